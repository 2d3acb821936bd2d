/* The direction field (section 4): the gradient of the distance from the edges; or the harmonic extension of the edges'
 * own directions as vectors (cos kt, sin kt), k = 4 for square tiles and 2 for long ones, solved on a pyramid. */
#include "mosaic/mosaic.h"

#include "base/parallel.h"
#include "field/field.h"
#include "image/image.h"

#include <math.h>
#include <string.h>

enum { QUARTER = 16384, SWEEPS = 12, COARSEST = 8, COARSEST_SWEEPS = 200, SERIAL = 4096, SERIAL_SIDE = 62 };

/* 65536 to a turn, of a vector that is not 0. */
static int32_t angle_of(double x, double y)
{
    double ax = fabs(x), ay = fabs(y), t = ax > ay ? ay / ax : ax / ay, s = t * t;
    double a = t * (0.99997726 + s * (-0.33262347 + s * (0.19354346 +
                    s * (-0.11643287 + s * (0.05265332 - s * 0.01172120))))); /* atan, within 2e-5 */
    int32_t angle = (int32_t)(a * 10430.378350470453 + 0.5);
    angle = ax > ay ? angle : QUARTER - angle;
    angle = x < 0 ? 2 * QUARTER - angle : angle;
    return (y < 0 ? -angle : angle) & 65535;
}

pave_result pv_distance_from(pave_context *context, const uint8_t *marks, int32_t width, int32_t height, int32_t wraps,
                             float **out)
{
    pave_result result = PAVE_OK;
    pv_drawing drawing = { width, height, marks, wraps };
    size_t pixels = (size_t)width * (size_t)height;
    int32_t *fixed = pv_allocate(context, pixels, sizeof *fixed, &result);
    *out = NULL;
    if (!result)
        result = pv_euclid(context, &drawing, fixed);
    if (!result)
        *out = pv_allocate(context, pixels, sizeof **out, &result);
    for (size_t i = 0; i < pixels && !result; i++)
        (*out)[i] = marks[i] ? 0 : (float)fixed[i] / PV_FIELD_ONE;
    pv_release(fixed);
    return result;
}

typedef struct level {
    int32_t width, height, wraps;
    double across, down; /* px of the photo in a cell */
    float *way;          /* 2 a cell */
    uint8_t *fixed;
} level;

typedef struct extension {
    pave_guide *guide;
    int32_t fold, colour;
    double frame_from; /* px from an edge where rows may follow the frame */
    level *level;
} extension;

/* The direction of the edge at one of its pixels: the main axis of the edge pixels around it, as a double angle. */
static void direction_at(const pave_guide *g, int32_t px, int32_t py, int32_t radius, float way[2])
{
    double n = 0, sx = 0, sy = 0, xx = 0, xy = 0, yy = 0;
    for (int32_t y = py - radius; y <= py + radius; y++)
        for (int32_t x = px - radius; x <= px + radius; x++) {
            int in = g->wraps || (x >= 0 && y >= 0 && x < g->width && y < g->height);
            if (!in || !g->edge[(int64_t)pv_inside(y, g->height, 1) * g->width + pv_inside(x, g->width, 1)])
                continue;
            double dx = x - px, dy = y - py, w = 1 - (dx * dx + dy * dy) / ((radius + 1.0) * (radius + 1.0));
            if (w <= 0)
                continue;
            n += w, sx += w * dx, sy += w * dy, xx += w * dx * dx, xy += w * dx * dy, yy += w * dy * dy;
        }
    double c = xx - sx * sx / n - (yy - sy * sy / n), s = 2 * (xy - sx * sy / n), length = sqrt(c * c + s * s);
    way[0] = length > 0 ? (float)(c / length) : 0;
    way[1] = length > 0 ? (float)(s / length) : 0;
}

typedef struct edge_job {
    pave_guide *guide;
    int32_t radius;
} edge_job;

static void directions_of_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const edge_job *job = data;
    pave_guide *g = job->guide;
    for (int32_t x = 0; x < g->width; x++)
        if (g->edge[(int64_t)y * g->width + x] && g->way[2 * ((int64_t)y * g->width + x)] == 0 &&
            g->way[2 * ((int64_t)y * g->width + x) + 1] == 0) /* those of drawn curves are known */
            direction_at(g, x, y, job->radius, g->way + 2 * ((int64_t)y * g->width + x));
}

static pave_result edge_directions(pave_context *context, double side, pave_guide *guide)
{
    edge_job job = { guide, (int32_t)fmin(24, fmax(4, 0.5 * side)) };
    return pv_parallel(context, guide->height, directions_of_row, &job, 0, 0.2);
}

/* Multiplies the angle of a unit vector by k / 2, k 2 or 4. */
static void fold_angle(const float way[2], int32_t fold, float out[2])
{
    out[0] = fold == 4 ? way[0] * way[0] - way[1] * way[1] : way[0];
    out[1] = fold == 4 ? 2 * way[0] * way[1] : way[1];
}

static void fix_cells(const extension *e, level *l)
{
    const pave_guide *g = e->guide;
    for (int32_t y = 0; y < g->height; y++)
        for (int32_t x = 0; x < g->width; x++) {
            int64_t i = (int64_t)y * g->width + x;
            int64_t cell = (int64_t)(y / l->down) * l->width + (int64_t)(x / l->across);
            float folded[2];
            if (!g->edge[i])
                continue;
            fold_angle(g->way + 2 * i, e->fold, folded);
            l->way[2 * cell] += folded[0];
            l->way[2 * cell + 1] += folded[1];
            l->fixed[cell] = 1;
        }
}

static int near_edge(const extension *e, const level *l, int32_t x, int32_t y)
{
    const pave_guide *g = e->guide;
    int32_t px = (int32_t)(x * l->across), py = (int32_t)(y * l->down);
    return g->away && (double)g->away[(int64_t)py * g->width + px] < e->frame_from;
}

/* A square tile is as well along the frame as across it, so rows follow it where no edge is near. */
static void fix_frame(const extension *e, level *l)
{
    for (int32_t y = 0; y < l->height; y++)
        for (int32_t x = 0; x < l->width; x++) {
            int64_t cell = (int64_t)y * l->width + x;
            int rim = x == 0 || y == 0 || x == l->width - 1 || y == l->height - 1;
            if (rim && e->fold == 4 && !l->fixed[cell] && !near_edge(e, l, x, y)) {
                l->fixed[cell] = 1;
                l->way[2 * cell] = 1;
            }
        }
}

static void normalise(float *way)
{
    float length = sqrtf(way[0] * way[0] + way[1] * way[1]);
    way[0] = length > 0 ? way[0] / length : 0;
    way[1] = length > 0 ? way[1] / length : 0;
}

static void coarsen(const level *fine, level *l)
{
    for (int32_t y = 0; y < fine->height; y++)
        for (int32_t x = 0; x < fine->width; x++) {
            int64_t from = (int64_t)y * fine->width + x, cell = (int64_t)(y / 2) * l->width + x / 2;
            if (!fine->fixed[from])
                continue;
            l->fixed[cell] = 1;
            l->way[2 * cell] += fine->way[2 * from];
            l->way[2 * cell + 1] += fine->way[2 * from + 1];
        }
    for (int64_t i = 0; i < (int64_t)l->width * l->height; i++)
        if (l->fixed[i])
            normalise(l->way + 2 * i);
}

/* Gauss and Seidel in two colours, so that the order within a colour does not matter. */
static void sweep_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const extension *e = data;
    const level *l = e->level;
    const float *up = l->way + 2 * (int64_t)pv_inside(y - 1, l->height, l->wraps) * l->width;
    const float *down = l->way + 2 * (int64_t)pv_inside(y + 1, l->height, l->wraps) * l->width;
    float *row = l->way + 2 * (int64_t)y * l->width;
    for (int32_t x = (y + e->colour) & 1; x < l->width; x += 2) {
        int32_t left = pv_inside(x - 1, l->width, l->wraps), right = pv_inside(x + 1, l->width, l->wraps);
        if (l->fixed[(int64_t)y * l->width + x])
            continue;
        for (int c = 0; c < 2; c++)
            row[2 * x + c] = (up[2 * x + c] + down[2 * x + c] + row[2 * left + c] + row[2 * right + c]) / 4;
    }
}

static pave_result sweep(pave_context *context, extension *e, level *l, int32_t sweeps)
{
    pave_result result = PAVE_OK;
    e->level = l;
    for (int32_t i = 0; i < 2 * sweeps && !result; i++) {
        e->colour = i & 1;
        if ((int64_t)l->width * l->height < SERIAL)
            for (int32_t y = 0; y < l->height; y++)
                sweep_row(e, y, 0);
        else
            result = pv_parallel(context, l->height, sweep_row, e, 0.5, 0.5);
    }
    return result;
}

static void refine(const level *coarse, level *l)
{
    for (int32_t y = 0; y < l->height; y++)
        for (int32_t x = 0; x < l->width; x++) {
            int64_t to = (int64_t)y * l->width + x;
            const float *from = coarse->way + 2 * ((int64_t)(y / 2) * coarse->width + x / 2);
            if (!l->fixed[to])
                memcpy(l->way + 2 * to, from, 2 * sizeof *from);
        }
}

static pave_result new_level(pave_context *context, int32_t width, int32_t height, level *l)
{
    pave_result result = PAVE_OK;
    size_t cells = (size_t)width * (size_t)height;
    l->width = width;
    l->height = height;
    l->way = pv_allocate_zeroed(context, 2 * cells, sizeof(float), &result);
    if (!result)
        l->fixed = pv_allocate_zeroed(context, cells, 1, &result);
    return result;
}

static void free_level(level *l)
{
    pv_release(l->way);
    pv_release(l->fixed);
}

/* Solves a level from the solution of the next coarser one. */
static pave_result solve(pave_context *context, extension *e, level *l)
{
    if (l->width <= COARSEST || l->height <= COARSEST)
        return sweep(context, e, l, COARSEST_SWEEPS);
    level coarse = { .wraps = l->wraps };
    pave_result result = new_level(context, (l->width + 1) / 2, (l->height + 1) / 2, &coarse);
    if (!result) {
        coarsen(l, &coarse);
        result = solve(context, e, &coarse);
    }
    if (!result) {
        refine(&coarse, l);
        result = sweep(context, e, l, SWEEPS);
    }
    free_level(&coarse);
    return result;
}

typedef struct reading {
    const extension *e;
    const level *l;
} reading;

/* Bilinear between the centres of cells. */
static void read_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const reading *r = data;
    const level *l = r->l;
    pave_guide *g = r->e->guide;
    float v = (float)((y + 0.5) / l->down - 0.5), fy = v - floorf(v);
    int32_t y0 = pv_inside((int32_t)floorf(v), l->height, l->wraps);
    int32_t y1 = pv_inside((int32_t)floorf(v) + 1, l->height, l->wraps);
    for (int32_t x = 0; x < g->width; x++) {
        float u = (float)((x + 0.5) / l->across - 0.5), fx = u - floorf(u), way[2];
        int32_t x0 = pv_inside((int32_t)floorf(u), l->width, l->wraps);
        int32_t x1 = pv_inside((int32_t)floorf(u) + 1, l->width, l->wraps);
        for (int c = 0; c < 2; c++) {
            float a = l->way[2 * ((int64_t)y0 * l->width + x0) + c], b = l->way[2 * ((int64_t)y0 * l->width + x1) + c];
            float d = l->way[2 * ((int64_t)y1 * l->width + x0) + c], f = l->way[2 * ((int64_t)y1 * l->width + x1) + c];
            way[c] = (1 - fy) * (a + fx * (b - a)) + fy * (d + fx * (f - d));
        }
        int32_t angle = way[0] != 0 || way[1] != 0 ? angle_of((double)way[0], (double)way[1]) : 0;
        g->direction[(int64_t)y * g->width + x] = (uint16_t)(angle / r->e->fold);
    }
}

/* The finest cells. Where the borders meet they are so many that levels are even until they are done by one thread:
 * else cells of one colour would be neighbours across the borders. */
static pave_result new_finest(pave_context *context, const pave_guide *guide, int32_t step, level *l)
{
    int32_t across = (guide->width + step - 1) / step, down = (guide->height + step - 1) / step, unit = 1;
    *l = (level){ .wraps = guide->wraps, .across = step, .down = step };
    while (guide->wraps && (across > unit * SERIAL_SIDE || down > unit * SERIAL_SIDE))
        unit *= 2;
    if (guide->wraps) {
        across = (across + unit - 1) / unit * unit;
        down = (down + unit - 1) / unit * unit;
        l->across = (double)guide->width / across;
        l->down = (double)guide->height / down;
    }
    return new_level(context, across, down, l);
}

pave_result pv_field_harmonic(pave_context *context, int32_t fold, double side, pave_guide *guide)
{
    extension e = { .guide = guide, .fold = fold, .frame_from = 4 * side };
    int32_t step = side > 20 ? (int32_t)(side / 10) : 1;
    level finest;
    pave_result result = edge_directions(context, side, guide);
    if (result)
        return result;
    result = new_finest(context, guide, step, &finest);
    if (!result) {
        fix_cells(&e, &finest);
        for (int64_t i = 0; i < (int64_t)finest.width * finest.height; i++)
            normalise(finest.way + 2 * i);
        if (!guide->wraps)
            fix_frame(&e, &finest);
        result = solve(context, &e, &finest);
    }
    reading r = { &e, &finest };
    if (!result)
        result = pv_parallel(context, guide->height, read_row, &r, 0.8, 1);
    free_level(&finest);
    return result;
}

/* As in Eq. 2 of the pavement, and turned by a quarter: along the edge. */
pave_result pv_field_gradient(pave_context *context, pave_guide *guide)
{
    const float *distance = guide->away;
    for (int32_t y = 0; y < guide->height && distance; y++)
        for (int32_t x = 0; x < guide->width; x++) {
            double d[3][3];
            for (int k = 0; k < 9; k++)
                d[k / 3][k % 3] =
                    (double)distance[(int64_t)pv_inside(y + k / 3 - 1, guide->height, guide->wraps) * guide->width +
                                     pv_inside(x + k % 3 - 1, guide->width, guide->wraps)];
            double gx = d[0][2] - d[0][0] + 2 * (d[1][2] - d[1][0]) + d[2][2] - d[2][0];
            double gy = d[2][0] - d[0][0] + 2 * (d[2][1] - d[0][1]) + d[2][2] - d[0][2];
            int32_t angle = gx != 0 || gy != 0 ? angle_of(gx, gy) + QUARTER : 0;
            guide->direction[(int64_t)y * guide->width + x] = (uint16_t)angle;
        }
    return edge_directions(context, 20, guide);
}

pave_result pv_field_take(pave_context *context, const pave_image *image, pave_guide *guide)
{
    double half = image->type == PAVE_U8 || image->type == PAVE_U16 ? 0.5 : 0;
    for (int64_t i = 0; i < (int64_t)guide->width * guide->height; i++) {
        double a = pv_image_value(image, i * image->channels);
        if (image->channels == 1) {
            guide->direction[i] = (uint16_t)(isfinite(a) ? (int64_t)((a - floor(a)) * 65536) : 0);
            continue;
        }
        double x = a - half, y = pv_image_value(image, i * image->channels + 1) - half;
        int known = isfinite(x) && isfinite(y) && (x != 0 || y != 0);
        guide->direction[i] = (uint16_t)(known ? angle_of(x, y) : 0);
    }
    return edge_directions(context, 20, guide);
}

/* How far the k-fold angle turns from one place to the next, -32768 .. 32767. */
static int32_t turn(const pave_guide *g, int32_t fold, int64_t from, int64_t to)
{
    int32_t way = fold * (g->direction[to] - g->direction[from]);
    return (int16_t)(uint16_t)(way & 65535);
}

/* Around the squares of a lattice finer than tiles. */
pave_result pv_field_singularities(pave_context *context, int32_t fold, double side, pave_guide *guide)
{
    int32_t step = side > 8 ? (int32_t)(side / 4) : 2;
    int32_t across = (guide->width - !guide->wraps) / step, down = (guide->height - !guide->wraps) / step;
    pave_result result = PAVE_OK;
    size_t room = (size_t)across * (size_t)down;
    guide->singularity = pv_allocate(context, 2 * room, sizeof *guide->singularity, &result);
    for (int32_t y = 0; y < down && !result; y++)
        for (int32_t x = 0; x < across; x++) {
            int32_t right = guide->wraps && x == across - 1 ? 0 : (x + 1) * step;
            int32_t below = guide->wraps && y == down - 1 ? 0 : (y + 1) * step;
            int64_t a = (int64_t)y * step * guide->width + (int64_t)x * step;
            int64_t b = (int64_t)y * step * guide->width + right;
            int64_t d = (int64_t)below * guide->width + (int64_t)x * step, c = (int64_t)below * guide->width + right;
            int32_t round = turn(guide, fold, a, b) + turn(guide, fold, b, c) + turn(guide, fold, c, d) +
                            turn(guide, fold, d, a);
            if (round) {
                guide->singularity[2 * guide->singularities] = (x + 0.5) * step;
                guide->singularity[2 * guide->singularities++ + 1] = (y + 0.5) * step;
            }
        }
    return result;
}
