/* What is seen from above: stones and joints mixed px by px, by the area that they cover. */
#include "maps/maps.h"

#include "base/parallel.h"
#include "util/fixed.h"
#include "util/light.h"

#include <math.h>
#include <string.h>

enum { BAND = 8, CODES = 1 << 14 };
static const double faint = 1.0 / 4096; /* what a colour that bleeds weighs */

/* A stone, moved by whole periods. */
typedef struct copy {
    int32_t stone;
    int64_t x, y; /* of its origin, px of the frame with its rim */
} copy;

/* Sums over the stones of a px. */
typedef struct mixture {
    double light[3], height, roughness, share;
    double slope[2];
    double ink; /* the weight of light and slope */
    uint32_t id, part;
} mixture;

typedef struct painting {
    const pv_bed *bed;
    const pv_plate *plate;
    const pv_coder *coder;
    int32_t width, height, bands; /* with the rim */
    copy *copies;
    int64_t count;
    int64_t *starts; /* where each band's members begin */
    int64_t *members;
    mixture *mixtures; /* of a band, for each worker */
} painting;

void pv_coder_begin(pv_coder *coder, int32_t type)
{
    coder->type = type;
    for (int32_t i = 0; i <= CODES; i++)
        coder->code[i] = (uint8_t)(pv_display_code((double)i / CODES) * 255 + 0.5);
}

void pv_coder_put(const pv_coder *coder, void *out, int64_t index, const double light[3])
{
    for (int c = 0; c < 3; c++) {
        double value = pv_clamped(light[c], 0, 1);
        if (coder->type == PAVE_U8)
            ((uint8_t *)out)[3 * index + c] = coder->code[(int32_t)(value * CODES + 0.5)];
        else if (coder->type == PAVE_U16)
            ((uint16_t *)out)[3 * index + c] = (uint16_t)(pv_display_code(value) * 65535 + 0.5);
        else
            ((float *)out)[3 * index + c] = (float)light[c];
    }
}

/* The stones' box, in the frame; those that cannot be seen are left out. */
static void add_copy(painting *p, int32_t s, int64_t period_x, int64_t period_y)
{
    const pv_laid *laid = &p->bed->laid[s];
    const pv_plate *plate = p->plate;
    int64_t x = laid->x + period_x - plate->frame.x + plate->rim, y = laid->y + period_y - plate->frame.y + plate->rim;
    int32_t bleed = (int32_t)ceil(plate->bleed);
    if (x + laid->width + bleed <= 0 || y + laid->height + bleed <= 0 || x - bleed >= p->width ||
        y - bleed >= p->height)
        return;
    if (p->copies)
        p->copies[p->count] = (copy){ s, x, y };
    p->count++;
}

/* Which periods of the plane the frame shows. */
static void add_copies(painting *p, int32_t s)
{
    const pv_bed *bed = p->bed;
    const pv_laid *laid = &bed->laid[s];
    const pv_plate *plate = p->plate;
    int64_t across = llround(bed->stones->plane_width * bed->scale);
    int64_t down = llround(bed->stones->plane_height * bed->scale), reach = plate->rim + (int64_t)ceil(plate->bleed);
    if (!bed->stones->field.periodic) {
        add_copy(p, s, 0, 0);
        return;
    }
    int64_t first_x = pv_floor_div(plate->frame.x - reach - laid->x - laid->width, across);
    int64_t last_x = pv_floor_div(plate->frame.x + plate->frame.width + reach - laid->x, across);
    int64_t first_y = pv_floor_div(plate->frame.y - reach - laid->y - laid->height, down);
    int64_t last_y = pv_floor_div(plate->frame.y + plate->frame.height + reach - laid->y, down);
    for (int64_t y = first_y; y <= last_y; y++)
        for (int64_t x = first_x; x <= last_x; x++)
            add_copy(p, s, x * across, y * down);
}

static pave_result list_copies(pave_context *context, painting *p)
{
    pave_result result = PAVE_OK;
    for (int32_t s = 0; s < p->bed->count; s++)
        add_copies(p, s);
    p->copies = pv_allocate(context, (size_t)p->count, sizeof *p->copies, &result);
    p->count = 0;
    for (int32_t s = 0; s < p->bed->count && !result; s++)
        add_copies(p, s);
    return result;
}

static void bands_of(const painting *p, const copy *c, int32_t *first, int32_t *last)
{
    double bleed = ceil(p->plate->bleed), edge = p->height - 1;
    *first = (int32_t)pv_clamped((double)c->y - bleed, 0, edge) / BAND;
    *last = (int32_t)pv_clamped((double)(c->y + p->bed->laid[c->stone].height) - 1 + bleed, 0, edge) / BAND;
}

/* Copies by the bands that they touch, in the order of the stones. */
static pave_result sort_copies(pave_context *context, painting *p)
{
    pave_result result = PAVE_OK;
    int32_t first, last;
    p->starts = pv_allocate_zeroed(context, (size_t)p->bands + 2, sizeof *p->starts, &result);
    if (result)
        return result;
    for (int64_t i = 0; i < p->count; i++)
        for (bands_of(p, &p->copies[i], &first, &last); first <= last; first++)
            p->starts[first + 2]++;
    for (int32_t i = 0; i < p->bands; i++)
        p->starts[i + 2] += p->starts[i + 1];
    p->members = pv_allocate(context, (size_t)p->starts[p->bands + 1], sizeof *p->members, &result);
    for (int64_t i = 0; i < p->count && !result; i++)
        for (bands_of(p, &p->copies[i], &first, &last); first <= last; first++)
            p->members[p->starts[first + 1]++] = i;
    return result;
}

/* Painted stones lie over what is there; others add up. */
static void mix_in(const pv_bed *bed, mixture *m, const pv_laid *laid, pv_cover sample, double ink,
                   const double light[3], const double slope[2], double height)
{
    double left = bed->stones->painted ? 1 - sample.share : 1;
    for (int c = 0; c < 3; c++)
        m->light[c] = m->light[c] * left + ink * light[c];
    for (int i = 0; i < 2; i++)
        m->slope[i] = m->slope[i] * left + ink * slope[i];
    m->ink = m->ink * left + ink;
    m->height = m->height * left + sample.share * height;
    m->roughness = m->roughness * left + sample.share * laid->roughness;
    m->share = m->share * left + sample.share;
    if (sample.inside && (!m->id || bed->stones->painted)) {
        m->id = (uint32_t)laid->number + 1;
        m->part = (uint32_t)laid->part;
    }
}

static void add_stone(const painting *p, mixture *mixtures, int32_t top, const copy *c)
{
    const pv_bed *bed = p->bed;
    const pv_laid *laid = &bed->laid[c->stone];
    int32_t bleed = (int32_t)ceil(p->plate->bleed), bottom = top + BAND < p->height ? top + BAND : p->height;
    int64_t left = c->x - bleed > 0 ? c->x - bleed : 0, right = c->x + laid->width + bleed;
    int64_t from = c->y - bleed > top ? c->y - bleed : top, to = c->y + laid->height + bleed;
    right = right < p->width ? right : p->width;
    to = to < bottom ? to : bottom;
    for (int64_t y = from; y < to; y++)
        for (int64_t x = left; x < right; x++) {
            int32_t sx = (int32_t)(x - c->x), sy = (int32_t)(y - c->y);
            pv_cover sample = pv_stone_cover(bed, laid, sx, sy);
            double ink = sample.share, light[3], slope[2] = { 0, 0 };
            if (p->plate->bleed > 0 && ink < faint && sample.inset > -p->plate->bleed)
                ink = faint;
            if (ink <= 0)
                continue;
            pv_patch patch = pv_stone_patch(bed, sx, sy, sample.inset);
            double height = pv_stone_surface(bed, laid, &patch, light);
            if (p->plate->grain)
                pv_face_slope(bed, laid, &patch, slope);
            mix_in(bed, &mixtures[(y - top) * p->width + x], laid, sample, ink, light, slope, height);
        }
}

static uint8_t byte_of(double value)
{
    return (uint8_t)(pv_clamped(value, 0, 1) * 255 + 0.5);
}

void pv_grain_put(double across, double down, uint8_t out[3])
{
    double n[3];
    pv_normal_of(across, down, 1, n);
    for (int c = 0; c < 3; c++)
        out[c] = byte_of(n[c]);
}

/* The light of a px: stones share it where they overlap, joints have what they leave. */
static void light_of(const painting *p, const mixture *m, const double joint[3], double light[3])
{
    double whole = m->ink > 1 ? 1 / m->ink : 1, room = m->ink < 1 ? 1 - m->ink : 0;
    if (p->plate->bleed > 0 && m->ink > 0)
        whole = 1 / m->ink, room = 0;
    for (int c = 0; c < 3; c++)
        light[c] = room > 0 ? m->light[c] * whole + room * joint[c] : m->light[c] * whole;
}

static void finish(const painting *p, const mixture *m, int32_t x, int32_t y)
{
    const pv_bed *bed = p->bed;
    const pv_plate *s = p->plate;
    double joint[3] = { 0, 0, 0 }, light[3], low = 0;
    double whole = m->share > 1 ? 1 / m->share : 1, room = m->share < 1 ? 1 - m->share : 0;
    if (room > 0 || m->ink < 1)
        low = pv_joint_surface(bed, s->frame.x + x - s->rim, s->frame.y + y - s->rim, joint);
    if (s->height)
        s->height[(int64_t)y * p->width + x] = (float)(m->height * whole + room * low);
    x -= s->rim;
    y -= s->rim;
    if (x < 0 || y < 0 || x >= s->frame.width || y >= s->frame.height)
        return;
    int64_t at = (int64_t)y * s->frame.width + x;
    if (s->colour) {
        light_of(p, m, joint, light);
        pv_coder_put(p->coder, s->colour, at, light);
    }
    double whole_ink = m->ink > 0 ? 1 / m->ink : 0;
    if (s->grain)
        pv_grain_put(m->slope[0] * whole_ink, m->slope[1] * whole_ink, s->grain + 3 * at);
    if (s->roughness)
        s->roughness[at] = byte_of(m->roughness * whole + room * bed->params.joint_roughness);
    if (s->mask)
        s->mask[at] = byte_of(m->share);
    if (s->id)
        s->id[2 * at] = m->id, s->id[2 * at + 1] = m->part;
}

static void paint_band(void *data, int32_t band, int32_t worker)
{
    const painting *p = data;
    int32_t top = band * BAND, rows = p->height - top < BAND ? p->height - top : BAND;
    mixture *mixtures = p->mixtures + (int64_t)worker * BAND * p->width;
    memset(mixtures, 0, (size_t)rows * (size_t)p->width * sizeof *mixtures);
    for (int64_t i = p->starts[band]; i < p->starts[band + 1]; i++)
        add_stone(p, mixtures, top, &p->copies[p->members[i]]);
    for (int32_t y = 0; y < rows; y++)
        for (int32_t x = 0; x < p->width; x++)
            finish(p, &mixtures[(int64_t)y * p->width + x], x, top + y);
}

pave_result pv_plate_paint(pave_context *context, const pv_bed *bed, pv_plate *plate, double from, double to)
{
    pv_coder coder;
    painting p = { .bed = bed, .plate = plate, .coder = &coder };
    p.width = plate->frame.width + 2 * plate->rim;
    p.height = plate->frame.height + 2 * plate->rim;
    p.bands = (p.height - 1) / BAND + 1;
    pv_coder_begin(&coder, bed->colour_type);
    pave_result result = list_copies(context, &p);
    if (!result)
        result = sort_copies(context, &p);
    if (!result)
        p.mixtures = pv_allocate(context, (size_t)pv_workers(context) * BAND * (size_t)p.width, sizeof *p.mixtures,
                                 &result);
    if (!result)
        result = pv_parallel(context, p.bands, paint_band, &p, from, to);
    pv_release(p.copies);
    pv_release(p.starts);
    pv_release(p.members);
    pv_release(p.mixtures);
    return result;
}
