/* What a mosaic is judged by. Pixels count where their centres lie in a tile. */
#include "mosaic/cover.h"
#include "mosaic/mosaic.h"

#include "base/parallel.h"
#include "util/polygon.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CHUNK = 32, MOST_CORNERS = 64 };

/* Of one tile. */
typedef struct verdict {
    double area, squareness, aspect, field_angle, edge_angle, difference, size; /* negative: does not apply */
    int32_t corners, straddles;
} verdict;

typedef struct judgement {
    const pv_work *w;
    const pave_stones *stones;
    verdict *verdicts;
} judgement;

typedef struct shape {
    const double *xy;
    int32_t corners;
    double area, x, y; /* centre of area */
} shape;

static shape shape_of(const pave_stones *s, int32_t tile)
{
    shape p = { s->vertices + 2 * s->starts[tile], (int32_t)(s->starts[tile + 1] - s->starts[tile]), 0, 0, 0 };
    const double *o = p.xy;
    for (int32_t i = 0; i < p.corners; i++) {
        const double *a = p.xy + 2 * i, *b = p.xy + 2 * ((i + 1) % p.corners);
        double turn = pv_left_turn(o[0], o[1], a[0], a[1], b[0], b[1]);
        p.area += turn / 2;
        p.x += turn * (o[0] + a[0] + b[0]);
        p.y += turn * (o[1] + a[1] + b[1]);
    }
    p.x = p.area > 0 ? p.x / (6 * p.area) : o[0];
    p.y = p.area > 0 ? p.y / (6 * p.area) : o[1];
    return p;
}

static double degrees(double y, double x)
{
    return atan2(y, x) * (180 / 3.14159265358979323846);
}

/* Length-weighted mean of the sides' directions, four-fold; as a unit vector. */
static void direction_of(const shape *p, double out[2])
{
    out[0] = out[1] = 0;
    for (int32_t i = 0; i < p->corners; i++) {
        const double *a = p->xy + 2 * i, *b = p->xy + 2 * ((i + 1) % p->corners);
        double x = b[0] - a[0], y = b[1] - a[1], d2 = x * x + y * y;
        if (d2 <= 0)
            continue;
        double c = (x * x - y * y) / d2, s = 2 * x * y / d2, length = sqrt(d2);
        out[0] += length * (c * c - s * s);
        out[1] += length * 2 * c * s;
    }
}

/* Between two four-fold directions, 0 .. 45 degrees. */
static double between(const double a[2], double x, double y)
{
    return fabs(degrees(a[0] * y - a[1] * x, a[0] * x + a[1] * y)) / 4;
}

static void judge_corners(const shape *p, verdict *v)
{
    double length[4], worst = 0;
    v->squareness = v->aspect = -1;
    if (p->corners != 4)
        return;
    for (int i = 0; i < 4; i++) {
        const double *a = p->xy + 2 * ((i + 3) % 4), *b = p->xy + 2 * i, *c = p->xy + 2 * ((i + 1) % 4);
        double ux = a[0] - b[0], uy = a[1] - b[1], vx = c[0] - b[0], vy = c[1] - b[1];
        length[i] = sqrt(vx * vx + vy * vy);
        worst = fmax(worst, fabs(fabs(degrees(ux * vy - uy * vx, ux * vx + uy * vy)) - 90));
    }
    double one = length[0] + length[2], other = length[1] + length[3];
    v->squareness = worst;
    v->aspect = fmax(one, other) / fmax(fmin(one, other), 1e-9);
}

static double judge_colour(const pave_stones *s, int32_t tile, const double sum[3], int64_t count)
{
    double mean[3], own[3], a[3], b[3];
    for (int c = 0; c < 3; c++) {
        mean[c] = sum[c] / (double)count;
        own[c] = pv_tile_light(s->rgb[3 * tile + c] / 255.0);
    }
    pv_tile_lab(mean, a);
    pv_tile_lab(own, b);
    return pv_ciede2000(a, b);
}

/* Light, field and edges under the tile. */
static void judge_pixels(const judgement *j, int32_t tile, const shape *p, const double direction[2], verdict *v)
{
    const pv_work *w = j->w;
    double light[3] = { 0, 0, 0 }, angle = 0;
    int64_t count = 0;
    int32_t from[PV_COVER_RUNS], to[PV_COVER_RUNS];
    pv_cover cover = pv_cover_of(p->xy, p->corners, w->width, w->height);
    for (int32_t y = cover.top; y < cover.bottom; y++)
        for (int32_t k = pv_cover_row(&cover, y, from, to) - 1; k >= 0; k--)
            for (int32_t x = from[k]; x < to[k]; x++) {
                int64_t i = (int64_t)y * w->width + x;
                int32_t c, s;
                pv_turn(4 * w->guide->direction[i], &c, &s);
                angle += between(direction, c, s);
                for (int n = 0; n < 3; n++)
                    light[n] += (double)w->photo.light[3 * i + n];
                count++;
            }
    v->field_angle = count ? angle / (double)count : -1;
    v->difference = count ? judge_colour(j->stones, tile, light, count) : -1;
}

/* The edges within a side of the tile's centre, if they have one direction. */
static double judge_edges(const judgement *j, const shape *p, const double direction[2])
{
    const pv_work *w = j->w;
    double side = pv_wanted_side(w, p->x, p->y), nearest = 1e9, c = 0, s = 0, n = 0;
    int32_t l = (int32_t)(p->x - side), r = (int32_t)(p->x + side) + 1, t = (int32_t)(p->y - side);
    int32_t b = (int32_t)(p->y + side) + 1;
    for (int32_t y = t < 0 ? 0 : t; y <= b && y < w->height; y++)
        for (int32_t x = l < 0 ? 0 : l; x <= r && x < w->width; x++) {
            int64_t i = (int64_t)y * w->width + x;
            double dx = x + 0.5 - p->x, dy = y + 0.5 - p->y, d = sqrt(dx * dx + dy * dy);
            if (!w->guide->edge[i] || d > side)
                continue;
            double way[2] = { (double)w->guide->way[2 * i], (double)w->guide->way[2 * i + 1] };
            nearest = fmin(nearest, d);
            c += way[0] * way[0] - way[1] * way[1];
            s += 2 * way[0] * way[1];
            n++;
        }
    return nearest <= 0.8 * side && sqrt(c * c + s * s) > 0.7 * n ? between(direction, c, s) : -1;
}

/* Pixels of a tile in its bounding box: 0 none, 1 in it, 2 counted. */
typedef struct patch {
    uint8_t *pixel;
    int32_t *stack;
    int32_t left, top, width, height;
} patch;

static int64_t flood(const patch *p, int32_t start)
{
    int64_t count = 0;
    int32_t depth = 1;
    p->stack[0] = start;
    p->pixel[start] = 2;
    while (depth) {
        int32_t at = p->stack[--depth], x = at % p->width, y = at / p->width;
        int32_t next[4] = { x > 0 ? at - 1 : -1, x < p->width - 1 ? at + 1 : -1, y > 0 ? at - p->width : -1,
                            y < p->height - 1 ? at + p->width : -1 };
        count++;
        for (int k = 0; k < 4; k++)
            if (next[k] >= 0 && p->pixel[next[k]] == 1) {
                p->pixel[next[k]] = 2;
                p->stack[depth++] = next[k];
            }
    }
    return count;
}

/* Does an edge cut the tile into parts of which the second has 15 % or more? */
static int straddles(const judgement *j, const shape *s, uint8_t *room, int32_t *stack)
{
    const pv_work *w = j->w;
    pv_cover cover = pv_cover_of(s->xy, s->corners, w->width, w->height);
    int32_t from[PV_COVER_RUNS], to[PV_COVER_RUNS], left = w->width, right = 0;
    for (int32_t i = 0; i < s->corners; i++) {
        left = (int32_t)fmin(left, fmax(0, floor(s->xy[2 * i])));
        right = (int32_t)fmax(right, fmin(w->width, ceil(s->xy[2 * i])));
    }
    patch p = { room, stack, left, cover.top, right - left, cover.bottom - cover.top };
    int64_t all = 0, parts[2] = { 0, 0 }, edges = 0;
    if (p.width <= 0 || p.height <= 0 || (int64_t)p.width * p.height > 1 << 20)
        return 0;
    memset(room, 0, (size_t)p.width * (size_t)p.height);
    for (int32_t y = cover.top; y < cover.bottom; y++)
        for (int32_t k = pv_cover_row(&cover, y, from, to) - 1; k >= 0; k--)
            for (int32_t x = from[k]; x < to[k]; x++, all++) {
                int edge = w->guide->edge[(int64_t)y * w->width + x];
                room[(y - p.top) * p.width + x - p.left] = !edge;
                edges += edge;
            }
    for (int32_t i = 0; i < p.width * p.height && edges; i++) {
        int64_t count = room[i] == 1 ? flood(&p, i) : 0;
        if (count > parts[0])
            parts[1] = parts[0], parts[0] = count;
        else if (count > parts[1])
            parts[1] = count;
    }
    return (double)parts[1] >= 0.15 * (double)all && all > 0;
}

static void judge_tile(const judgement *j, int32_t tile, uint8_t *room, int32_t *stack)
{
    const pv_work *w = j->w;
    verdict *v = &j->verdicts[tile];
    shape p = shape_of(j->stones, tile);
    double direction[2], wanted = pv_wanted_side(w, p.x, p.y);
    wanted = w->params->mode == PAVE_MODE_PAPER ? w->params->delta * wanted : wanted - w->params->joint * w->side;
    v->area = p.area;
    v->corners = p.corners;
    direction_of(&p, direction);
    judge_corners(&p, v);
    judge_pixels(j, tile, &p, direction, v);
    v->edge_angle = judge_edges(j, &p, direction);
    v->straddles = straddles(j, &p, room, stack);
    v->size = sqrt(p.area > 0 ? p.area : 0) / fmax(wanted, 1e-9);
}

typedef struct room {
    const judgement *j;
    uint8_t *pixel; /* 2^20 a worker */
    int32_t *stack;
} room;

static void judge_chunk(void *data, int32_t chunk, int32_t worker)
{
    const room *r = data;
    for (int32_t i = chunk * CHUNK; i < (chunk + 1) * CHUNK && i < r->j->stones->count; i++)
        judge_tile(r->j, i, r->pixel + ((size_t)worker << 20), r->stack + ((size_t)worker << 20));
}

static int ascending(const void *a, const void *b)
{
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

/* Chips are not judged by themselves. */
static int32_t tiles_of(const pave_stones *s)
{
    return s->count - s->mosaic->chips;
}

/* The value that a share of those that apply does not reach; between two of them as near to each as the share is. */
static double rank(const judgement *j, size_t offset, double share, double *values)
{
    int32_t count = 0;
    for (int32_t i = 0; i < tiles_of(j->stones); i++) {
        double v = *(const double *)(const void *)((const char *)&j->verdicts[i] + offset);
        if (v >= 0)
            values[count++] = v;
    }
    qsort(values, (size_t)count, sizeof *values, ascending);
    if (!count)
        return 0;
    double at = share * (count - 1);
    int32_t below = (int32_t)at, above = below + 1 < count ? below + 1 : below;
    return values[below] + (at - below) * (values[above] - values[below]);
}

static double mean(const judgement *j, size_t offset)
{
    double sum = 0, count = 0;
    for (int32_t i = 0; i < tiles_of(j->stones); i++) {
        double v = *(const double *)(const void *)((const char *)&j->verdicts[i] + offset);
        if (v >= 0)
            sum += v, count++;
    }
    return count > 0 ? sum / count : 0;
}

static double pixels_of(const pv_work *w)
{
    const pv_work *photo = w->period ? w->period : w;
    return (double)photo->width * photo->height;
}

static void sum_up(const judgement *j, double *values, pave_mosaic_measure *m)
{
    double pixels = pixels_of(j->w), n = fmax(1, tiles_of(j->stones));
    double root = 0, square = 0;
    for (int32_t i = 0; i < j->stones->count; i++) {
        const verdict *v = &j->verdicts[i];
        m->coverage += v->area / pixels;
        if (i >= tiles_of(j->stones))
            continue;
        m->corners4 += (v->corners == 4) / n;
        m->straddlers += v->straddles / n;
        m->sizes_met += (fabs(v->size - 1) <= 0.25) / n;
        m->size_error += fabs(v->size - 1) / n;
        root += sqrt(v->area) / n;
        square += v->area / n;
    }
    m->side_cv = root > 0 ? sqrt(fmax(0, square - root * root)) / root : 0;
    m->squareness = mean(j, offsetof(verdict, squareness));
    m->aspect = rank(j, offsetof(verdict, aspect), 0.5, values);
    m->field_angle = mean(j, offsetof(verdict, field_angle));
    m->edge_angle = mean(j, offsetof(verdict, edge_angle));
    m->delta_e = mean(j, offsetof(verdict, difference));
    m->delta_e_p95 = rank(j, offsetof(verdict, difference), 0.95, values);
}

static pave_result judge(pave_context *context, judgement *j, pave_mosaic_measure *m)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)j->stones->count, workers = (size_t)pv_workers(context);
    room r = { .j = j };
    double *values = pv_allocate(context, n, sizeof *values, &result);
    if (!result)
        j->verdicts = pv_allocate_zeroed(context, n, sizeof *j->verdicts, &result);
    if (!result)
        r.pixel = pv_allocate(context, workers << 20, 1, &result);
    if (!result)
        r.stack = pv_allocate(context, workers << 20, sizeof *r.stack, &result);
    if (!result)
        result = pv_parallel(context, (j->stones->count + CHUNK - 1) / CHUNK, judge_chunk, &r, 0.5, 1);
    if (!result)
        sum_up(j, values, m);
    if (!result)
        result = pv_overlap(context, j->stones, j->w->period != NULL, &m->overlap);
    pv_release(values);
    pv_release(j->verdicts);
    pv_release(r.pixel);
    pv_release(r.stack);
    return result;
}

pave_result pv_mosaic_judge(pave_context *context, const pv_work *w, const pave_stones *stones,
                            pave_mosaic_measure *m)
{
    judgement j = { w, stones, NULL };
    *m = (pave_mosaic_measure){ .size = sizeof *m, .tiles = tiles_of(stones), .chips = stones->mosaic->chips,
                                .lost = w->n - stones->mosaic->served,
                                .singularities = w->guide->singularities, .tile_side = w->side };
    pave_result result = judge(context, &j, m);
    m->overlap /= pixels_of(w);
    return result;
}
