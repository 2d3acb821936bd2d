/* Pictures around the solids: faces as the maps have them, the floor, and a strip for each side. */
#include "maps/model.h"

#include "base/parallel.h"
#include "image/image.h"
#include "util/fixed.h"

#include <math.h>
#include <string.h>

enum { RUN = 16, ROWS = 8, SPREADS = 3, HIDES = 3 };
static const double bleeds = 2.5; /* px */

static double length_of(const pv_modelling *m, const pv_footprint *o, int32_t i)
{
    const pv_cell *ring = m->corner + o->first, a = ring[i], b = ring[i + 1 < o->corners ? i + 1 : 0];
    double x = pv_fine(b.x - a.x), y = pv_fine(b.y - a.y);
    return sqrt(x * x + y * y);
}

/* A px around it is its neighbours' when pictures are looked at from between px. */
static int32_t strip_width(const pv_modelling *m, const pv_footprint *o, int32_t i)
{
    return (int32_t)ceil(length_of(m, o, i) * m->bed->scale) + 2;
}

/* The tallest side, or what is seen of it over the floor, px of the maps. */
static int32_t tallest(const pv_modelling *m, int seen)
{
    double most = 0;
    for (int32_t s = 0; s < m->bed->count; s++) {
        const pv_footprint *o = &m->footprint[s];
        for (int32_t i = 0; i < o->corners; i++) {
            pv_cell c = m->corner[o->first + i];
            double at[2];
            pv_model_place(m, s, pv_fine(c.x), pv_fine(c.y), at);
            double top = pv_stone_plane(m->bed, &m->bed->laid[s], at[0], at[1]) - o->bevel;
            double tall = top - (seen ? fmax(o->bottom, -m->bed->depth) : o->bottom);
            most = tall > most ? tall : most;
        }
    }
    return (int32_t)pv_clamped(ceil(most * m->bed->scale) + 2, 2, 1 << 20);
}

static void widen(pv_modelling *m)
{
    for (int32_t s = 0; s < m->bed->count; s++)
        for (int32_t i = 0; i < m->footprint[s].corners; i++) {
            int32_t width = strip_width(m, &m->footprint[s], i);
            m->frame.width = width > m->frame.width ? width : m->frame.width;
        }
}

/* Strips side by side, row under row. What is under the floor may lie on the next row, for it is not seen. */
static int64_t place_strips(pv_modelling *m, int64_t top)
{
    int32_t x = 0;
    int64_t y = top;
    for (int32_t s = 0; s < m->bed->count; s++)
        for (int32_t i = 0; i < m->footprint[s].corners; i++) {
            int32_t width = strip_width(m, &m->footprint[s], i);
            if (x + width > m->frame.width)
                x = 0, y += m->strip_height;
            if (y < INT32_MAX)
                m->strip[m->footprint[s].first + i] = (pv_strip){ x, (int32_t)y };
            x += width;
        }
    return y + tallest(m, 0);
}

pave_result pv_skin_plan(pave_context *context, pv_modelling *m)
{
    pave_result result = PAVE_OK;
    m->strip = pv_allocate(context, (size_t)m->bed->stones->starts[m->bed->count], sizeof *m->strip, &result);
    if (result)
        return result;
    widen(m);
    m->strip_height = tallest(m, m->params.ground);
    int64_t height = place_strips(m, (int64_t)m->frame.height * (1 + m->params.ground));
    m->width = m->frame.width;
    m->height = (int32_t)(height < INT32_MAX ? height : INT32_MAX);
    return pv_check_size(context, "the model's pictures", m->width, height);
}

pv_patch pv_side_patch(const pv_modelling *m, int32_t stone, int32_t i, double along, double down)
{
    const pv_bed *bed = m->bed;
    const pv_footprint *o = &m->footprint[stone];
    const pv_cell *ring = m->corner + o->first;
    int32_t block = bed->laid[stone].face.block;
    int solid = block >= 0 && bed->block[block].size[2] > 1;
    double n[2], place[2], deep = solid ? bed->bevel + down : 0, fold = solid ? 0 : down * bed->scale;
    pv_footprint_normal(ring, o->corners, i, n);
    pv_model_place(m, stone, pv_fine(ring[i].x) + n[1] * along, pv_fine(ring[i].y) - n[0] * along, place);
    return (pv_patch){ { place[0] + n[0] * fold, place[1] + n[1] * fold, deep },
                       { n[1], -n[0], 0 },
                       { solid ? 0 : n[0], solid ? 0 : n[1], solid ? 1 / bed->scale : 0 } };
}

typedef struct skinning {
    pv_modelling *m;
    pv_coder coder;
    uint8_t *mask, *roughness, *occlusion; /* of the faces */
    uint8_t *colour, *surface;
    uint8_t *normal;
    double joint; /* px */
} skinning;

static uint8_t byte_of(double value)
{
    return (uint8_t)(pv_clamped(value, 0, 1) * 255 + 0.5);
}

/* Of the sky above a joint, the part that is seen from so far down at its side: 1 - sin of the other side's height. */
static double seen_sky(double joint, double down)
{
    return 1 - down / sqrt(down * down + joint * joint);
}

static void put_side(const skinning *job, int32_t s, int32_t i, int32_t x, int32_t y)
{
    const pv_modelling *m = job->m;
    const pv_footprint *o = &m->footprint[s];
    const pv_laid *laid = &m->bed->laid[s];
    const pv_strip *strip = &m->strip[o->first + i];
    double down = (y - 0.5) / m->bed->scale, light[3], slope[2];
    pv_patch patch = pv_side_patch(m, s, i, (x - 0.5) / m->bed->scale, down);
    int64_t at = ((int64_t)strip->y + y) * m->width + strip->x + x;
    pv_face_light(m->bed, laid, &patch, light);
    pv_coder_put(&job->coder, job->colour, at, light);
    job->surface[3 * at] = byte_of(seen_sky(job->joint, fmax(down, 0) + o->bevel));
    job->surface[3 * at + 1] = byte_of(laid->roughness);
    job->surface[3 * at + 2] = 0;
    if (!job->normal)
        return;
    pv_face_slope(m->bed, laid, &patch, slope);
    pv_grain_put(slope[0], slope[1], job->normal + 3 * at);
}

static void paint_sides(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const skinning *job = data;
    const pv_modelling *m = job->m;
    (void)worker;
    for (int32_t s = begin; s < end; s++)
        for (int32_t i = 0; i < m->footprint[s].corners; i++)
            for (int32_t y = 0, width = strip_width(m, &m->footprint[s], i); y < m->strip_height; y++)
                for (int32_t x = 0; x < width; x++)
                    put_side(job, s, i, x, y);
}

/* Under stones, farther in than pictures are looked at from, the floor is plain. */
static int is_hidden(const skinning *job, int32_t x, int32_t y)
{
    const pv_frame *frame = &job->m->frame;
    for (int k = 0; k < 4; k++) {
        int32_t u = x + (k & 1 ? HIDES : -HIDES), v = y + (k & 2 ? HIDES : -HIDES);
        if (u < 0 || v < 0 || u >= frame->width || v >= frame->height || job->mask[(int64_t)v * frame->width + u] != 255)
            return 0;
    }
    return 1;
}

static void paint_floor(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const skinning *job = data;
    const pv_modelling *m = job->m;
    double light[3];
    (void)worker;
    for (int32_t y = begin; y < end; y++)
        for (int32_t x = 0; x < m->width; x++) {
            int64_t at = ((int64_t)m->frame.height + y) * m->width + x;
            job->surface[3 * at + 1] = byte_of(m->bed->params.joint_roughness);
            if (is_hidden(job, x, y))
                continue;
            pv_joint_surface(m->bed, m->frame.x + x, m->frame.y + y, light);
            pv_coder_put(&job->coder, job->colour, at, light);
        }
}

/* Joints are darker than edges, and must not show on them: px that stones do not cover take after those that they
 * do. Covered ones have 255 in `before`, and afterwards in `known`. */
typedef struct spreading {
    pv_frame frame;
    const uint8_t *before;
    uint8_t *known, *occlusion;
} spreading;

static void spread_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const spreading *s = data;
    int64_t row = s->frame.width;
    (void)worker;
    memcpy(s->known + begin * row, s->before + begin * row, (size_t)((end - begin) * row));
    for (int32_t y = begin > 1 ? begin : 1; y < end && y + 1 < s->frame.height; y++)
        for (int32_t x = 1; x + 1 < s->frame.width; x++) {
            int64_t at = y * row + x;
            int32_t sum = 0, count = 0;
            for (int k = 0; k < 9 && s->before[at] != 255; k++) {
                int64_t other = at + (k / 3 - 1) * row + k % 3 - 1;
                sum += s->before[other] == 255 ? s->occlusion[other] : 0;
                count += s->before[other] == 255;
            }
            if (count)
                s->occlusion[at] = (uint8_t)(sum / count), s->known[at] = 255;
        }
}

static void pack_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const skinning *job = data;
    int64_t row = job->m->frame.width;
    (void)worker;
    for (int64_t i = begin * row; i < end * row; i++) {
        job->surface[3 * i] = job->occlusion[i];
        job->surface[3 * i + 1] = job->roughness[i];
    }
}

/* The floor's, below the faces, is as it was. */
static void pack_floor(const skinning *job)
{
    int64_t count = (int64_t)job->m->frame.width * job->m->frame.height;
    for (int64_t i = 0; i < count; i++)
        job->surface[3 * (count + i)] = job->occlusion[i];
}

/* `work` has room for two more pictures of a byte. */
static pave_result pack(pave_context *context, skinning *job, uint8_t *work, double at)
{
    const pv_frame *frame = &job->m->frame;
    uint8_t *other = work + (int64_t)frame->width * frame->height;
    spreading s = { *frame, job->mask, work, job->occlusion };
    pave_result result = PAVE_OK;
    if (job->m->params.ground)
        pack_floor(job);
    for (int i = 0; i < SPREADS && !result; i++) {
        result = pv_parallel_runs(context, frame->height, ROWS, spread_rows, &s, at, at);
        s.before = s.known;
        s.known = s.known == work ? other : work;
    }
    return result ? result : pv_parallel_runs(context, frame->height, ROWS, pack_rows, job, at, at);
}

static pave_result shade(pave_context *context, skinning *job, const pv_plate *plate, double reach, double from,
                         double to)
{
    const pv_shades shades = { plate->height, plate->frame.width, plate->frame.height, plate->rim,
                               job->m->bed->scale, 1, NULL, job->occlusion, reach };
    return pv_shade(context, &shades, from, to);
}

static pave_result paint_faces(pave_context *context, skinning *job, double from, double to)
{
    const pv_bed *bed = job->m->bed;
    pave_result result = PAVE_OK;
    double reach = bed->params.occlusion * bed->half_side * bed->scale, most = from + (to - from) * 0.8;
    pv_plate plate = { .frame = job->m->frame, .rim = pv_shade_rim(reach), .bleed = bleeds, .colour = job->colour,
                       .grain = job->normal };
    size_t width = (size_t)plate.frame.width, height = (size_t)plate.frame.height, rim = 2 * (size_t)plate.rim;
    plate.height = pv_allocate(context, (width + rim) * sizeof(float), height + rim, &result);
    uint8_t *bytes = result ? NULL : pv_allocate(context, 4 * width, height, &result);
    if (!result) {
        plate.mask = job->mask;
        plate.roughness = job->roughness = bytes;
        job->occlusion = bytes + width * height;
        result = pv_plate_paint(context, bed, &plate, from, most);
    }
    if (!result)
        result = shade(context, job, &plate, reach, most, to);
    if (!result)
        result = pack(context, job, bytes + 2 * width * height, to);
    pv_release(plate.height);
    pv_release(bytes);
    return result;
}

/* What there is no px of stays plain. */
static pave_result new_picture(pave_context *context, const pv_modelling *m, int32_t which)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = m->width;
    shape.height = m->height;
    shape.channels = 3;
    shape.encoding = which == PAVE_SKIN_COLOUR ? PAVE_DISPLAY : PAVE_DATA;
    pave_result result = pv_image_new(context, &shape, &m->model->picture[which]);
    if (result)
        return result;
    uint8_t *pixels = m->model->picture[which]->pixels;
    int64_t count = (int64_t)m->width * m->height;
    memset(pixels, 0, 3 * (size_t)count);
    for (int64_t i = 0; which == PAVE_SKIN_NORMAL && i < count; i++)
        pv_grain_put(0, 0, pixels + 3 * i);
    return PAVE_OK;
}

pave_result pv_skin_paint(pave_context *context, pv_modelling *m, double from, double to)
{
    skinning job = { .m = m };
    pave_image **picture = m->model->picture;
    pave_result result = new_picture(context, m, PAVE_SKIN_COLOUR);
    if (!result)
        result = new_picture(context, m, PAVE_SKIN_SURFACE);
    if (!result && m->bed->relief != 0 && m->bed->blocks)
        result = new_picture(context, m, PAVE_SKIN_NORMAL);
    if (result)
        return result;
    pv_coder_begin(&job.coder, PAVE_U8);
    job.colour = picture[PAVE_SKIN_COLOUR]->pixels;
    job.surface = picture[PAVE_SKIN_SURFACE]->pixels;
    job.normal = picture[PAVE_SKIN_NORMAL] ? picture[PAVE_SKIN_NORMAL]->pixels : NULL;
    job.joint = fmax(m->bed->stones->params.grout, 0.05 * m->bed->half_side);
    job.mask = pv_allocate(context, (size_t)m->frame.width, (size_t)m->frame.height, &result);
    double third = (to - from) / 3;
    if (!result)
        result = paint_faces(context, &job, from, from + third);
    if (!result && m->params.ground)
        result = pv_parallel_runs(context, m->frame.height, ROWS, paint_floor, &job, from + third, from + 2 * third);
    pv_release(job.mask);
    return result ? result
                  : pv_parallel_runs(context, m->bed->count, RUN, paint_sides, &job, from + 2 * third, to);
}
