/* Solids of stone: upright sides on a footprint, a rounding, a face, and an underside. */
#include "maps/model.h"

#include "base/parallel.h"

#include <math.h>

enum { RUN = 16 };

int64_t pv_prism_vertices(int32_t corners, int32_t segments)
{
    return (int64_t)corners * (4 + segments + 1 + 1);
}

int64_t pv_prism_triangles(int32_t corners, int32_t segments)
{
    return (int64_t)corners * (2 + 2 * segments) + 2 * ((int64_t)corners - 2);
}

/* A stone being built; places are px from its first corner. */
typedef struct building {
    const pv_modelling *m;
    int32_t stone;
    const pv_footprint *footprint;
    const pv_cell *ring;
    const pv_laid *laid;
    uint32_t vertex;  /* the next one's number */
    uint32_t *corner; /* where the next triangle goes */
    int32_t *work, *filled;
    pv_cell *inner;
} building;

/* A vertex: where in the drawing and how high, px; its normal, with y down the drawing; px of the pictures, or the
 * place that has its colour. */
typedef struct vertex {
    double x, y, z;
    double normal[3]; /* right, down the drawing, up */
    double u, v;
    pv_patch patch;
} vertex;

static void put_vertex(const pv_modelling *m, uint32_t index, const vertex *v)
{
    pave_model *model = m->model;
    double per_metre = m->params.pixels_per_metre, length = 0;
    float *position = model->position + 3 * (int64_t)index, *normal = model->normal + 3 * (int64_t)index;
    position[0] = (float)((v->x - m->middle[0]) / per_metre);
    position[1] = (float)(v->z / per_metre);
    position[2] = (float)((v->y - m->middle[1]) / per_metre);
    for (int i = 0; i < 3; i++)
        length += v->normal[i] * v->normal[i];
    normal[0] = (float)(v->normal[0] / sqrt(length));
    normal[1] = (float)(v->normal[2] / sqrt(length));
    normal[2] = (float)(v->normal[1] / sqrt(length));
    if (!model->coordinate)
        return;
    model->coordinate[2 * (int64_t)index] = (float)(v->u / m->width);
    model->coordinate[2 * (int64_t)index + 1] = (float)(v->v / m->height);
}

static void put_colour(const pv_modelling *m, uint32_t index, const double light[3])
{
    for (int c = 0; m->model->colour && c < 3; c++)
        m->model->colour[3 * (int64_t)index + c] = (float)pv_clamped(light[c], 0, 1);
}

static uint32_t add_vertex(building *b, const vertex *v)
{
    double light[3];
    put_vertex(b->m, b->vertex, v);
    if (b->m->model->colour) {
        pv_face_light(b->m->bed, b->laid, &v->patch, light);
        put_colour(b->m, b->vertex, light);
    }
    return b->vertex++;
}

static void add_triangle(building *b, uint32_t i, uint32_t j, uint32_t k)
{
    *b->corner++ = i;
    *b->corner++ = j;
    *b->corner++ = k;
}

/* Lower side a b, upper side d c, seen from outside. */
static void add_quad(building *b, uint32_t i, uint32_t j, uint32_t k, uint32_t l)
{
    add_triangle(b, i, j, k);
    add_triangle(b, i, k, l);
}

/* A place of the stone seen from above, so far under the plane of its face. */
static vertex from_above(const building *b, pv_cell at, double drop)
{
    const pv_bed *bed = b->m->bed;
    const double *first = bed->stones->vertices + 2 * b->laid->first;
    double place[2];
    vertex v = { .x = first[0] + pv_fine(at.x), .y = first[1] + pv_fine(at.y) };
    pv_model_place(b->m, b->stone, pv_fine(at.x), pv_fine(at.y), place);
    v.z = pv_stone_plane(bed, b->laid, place[0], place[1]) - drop;
    v.u = v.x * bed->scale - (double)b->m->frame.x;
    v.v = v.y * bed->scale - (double)b->m->frame.y;
    v.patch = (pv_patch){ { place[0], place[1], drop }, { 1, 0, 0 }, { 0, 1, 0 } };
    return v;
}

/* Outwards between the two sides at a corner, and up as far as the rounding is; a tilted stone shears both. */
static void set_normal(const building *b, int32_t i, double cosine, double sine, double out[3])
{
    int32_t n = b->footprint->corners;
    double before[2], after[2];
    pv_footprint_normal(b->ring, n, i ? i - 1 : n - 1, before);
    pv_footprint_normal(b->ring, n, i, after);
    double x = before[0] + after[0], y = before[1] + after[1], length = sqrt(x * x + y * y);
    out[0] = (length > 0 ? x / length * cosine : 0) - b->laid->slope[0] * sine;
    out[1] = (length > 0 ? y / length * cosine : 0) - b->laid->slope[1] * sine;
    out[2] = sine;
}

/* The rings of the rounding, and the face; without rounding a face alone. Returns the face's first vertex. */
static uint32_t build_rounding(building *b)
{
    const pv_modelling *m = b->m;
    int32_t n = b->footprint->corners, segments = b->footprint->segments;
    const pv_cell *ring = b->ring;
    uint32_t first = b->vertex;
    for (int32_t k = 0; k <= segments; k++) {
        double cosine = segments ? m->cosine[k] : 0, sine = segments ? m->sine[k] : 1;
        if (k)
            pv_footprint_inset(b->ring, n, b->footprint->bevel * (1 - cosine), b->inner);
        ring = k ? b->inner : b->ring;
        for (int32_t i = 0; i < n; i++) {
            vertex v = from_above(b, ring[i], b->footprint->bevel * (1 - sine));
            set_normal(b, i, cosine, sine, v.normal);
            add_vertex(b, &v);
        }
    }
    for (int32_t k = 0; k < segments; k++)
        for (int32_t i = 0; i < n; i++) {
            uint32_t at = first + (uint32_t)(k * n), j = (uint32_t)(i + 1 < n ? i + 1 : 0);
            add_quad(b, at + (uint32_t)i, at + j, at + (uint32_t)n + j, at + (uint32_t)(n + i));
        }
    pv_footprint_fill(ring, n, b->work, b->filled);
    return first + (uint32_t)(segments * n);
}

static void build_caps(building *b, uint32_t face)
{
    int32_t n = b->footprint->corners;
    uint32_t under = b->vertex;
    for (int32_t i = 0; i < n - 2; i++)
        add_triangle(b, face + (uint32_t)b->filled[3 * i], face + (uint32_t)b->filled[3 * i + 1],
                     face + (uint32_t)b->filled[3 * i + 2]);
    for (int32_t i = 0; i < n; i++) {
        vertex v = from_above(b, b->ring[i], b->footprint->bevel);
        v.z = b->footprint->bottom;
        v.normal[2] = -1;
        add_vertex(b, &v);
    }
    pv_footprint_fill(b->ring, n, b->work, b->filled);
    for (int32_t i = 0; i < n - 2; i++)
        add_triangle(b, under + (uint32_t)b->filled[3 * i + 2], under + (uint32_t)b->filled[3 * i + 1],
                     under + (uint32_t)b->filled[3 * i]);
}

/* The upper or lower end of side `i`, at its corner `j`. */
static vertex of_side(const building *b, int32_t i, int32_t j, double along, int lower)
{
    const pv_modelling *m = b->m;
    vertex v = from_above(b, b->ring[j], b->footprint->bevel);
    double down = lower ? v.z - b->footprint->bottom : 0;
    pv_footprint_normal(b->ring, b->footprint->corners, i, v.normal);
    v.patch = pv_side_patch(m, b->stone, i, along, down);
    v.z = lower ? b->footprint->bottom : v.z;
    if (m->strip) {
        const pv_strip *strip = &m->strip[b->footprint->first + i];
        v.u = strip->x + 1 + along * m->bed->scale;
        v.v = strip->y + 1 + down * m->bed->scale;
    }
    return v;
}

static void build_sides(building *b)
{
    int32_t n = b->footprint->corners;
    for (int32_t i = 0; i < n; i++) {
        int32_t j = i + 1 < n ? i + 1 : 0;
        double x = pv_fine(b->ring[j].x - b->ring[i].x), y = pv_fine(b->ring[j].y - b->ring[i].y);
        double length = sqrt(x * x + y * y);
        const vertex corners[4] = { of_side(b, i, i, 0, 1), of_side(b, i, j, length, 1), of_side(b, i, j, length, 0),
                                    of_side(b, i, i, 0, 0) };
        uint32_t first = b->vertex;
        for (int k = 0; k < 4; k++)
            add_vertex(b, &corners[k]);
        add_quad(b, first, first + 1, first + 2, first + 3);
    }
}

typedef struct prisms {
    pv_modelling *m;
    int32_t *work;  /* for each worker: corners left, and triangles */
    pv_cell *inner; /* for each worker: a ring */
} prisms;

static void build_prisms(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const prisms *job = data;
    const pv_modelling *m = job->m;
    int32_t *work = job->work + 4 * (int64_t)worker * m->most_corners;
    for (int32_t s = begin; s < end; s++) {
        const pv_footprint *o = &m->footprint[s];
        building b = { .m = m, .stone = s, .footprint = o, .ring = m->corner + o->first, .laid = &m->bed->laid[s],
                       .vertex = (uint32_t)o->first_vertex, .corner = m->model->triangle + 3 * o->first_triangle,
                       .work = work, .filled = work + m->most_corners,
                       .inner = job->inner + (int64_t)worker * m->most_corners };
        if (!o->corners)
            continue;
        build_caps(&b, build_rounding(&b));
        build_sides(&b);
    }
}

pave_result pv_prisms_build(pave_context *context, pv_modelling *m, double from, double to)
{
    pave_result result = PAVE_OK;
    prisms job = { .m = m };
    size_t workers = (size_t)pv_workers(context), corners = (size_t)m->most_corners;
    job.work = pv_allocate(context, workers * 4, corners * sizeof *job.work, &result);
    if (!result)
        job.inner = pv_allocate(context, workers, corners * sizeof *job.inner, &result);
    if (!result)
        result = pv_parallel_runs(context, m->bed->count, RUN, build_prisms, &job, from, to);
    pv_release(job.work);
    pv_release(job.inner);
    return result;
}

/* At the height of the joints, as large as the frame. */
void pv_floor_build(pv_modelling *m)
{
    static const uint32_t around[6] = { 0, 1, 2, 0, 2, 3 };
    const pv_bed *bed = m->bed;
    uint32_t first = (uint32_t)(m->model->vertices - 4);
    uint32_t *triangle = m->model->triangle + 3 * (m->model->triangles - 2);
    double light[3];
    for (uint32_t i = 0; i < 4; i++) { /* from the lower left one, counter-clockwise */
        int right = i == 1 || i == 2, lower = i < 2;
        double u = right ? m->frame.width : 0, v = lower ? m->frame.height : 0;
        vertex at = { .x = ((double)m->frame.x + u) / bed->scale, .y = ((double)m->frame.y + v) / bed->scale,
                      .z = -bed->depth, .normal = { 0, 0, 1 }, .u = u, .v = v + m->frame.height };
        put_vertex(m, first + i, &at);
        pv_joint_surface(bed, m->frame.x + (int64_t)u, m->frame.y + (int64_t)v, light);
        put_colour(m, first + i, light);
    }
    for (int i = 0; i < 6; i++)
        triangle[i] = first + around[i];
}
