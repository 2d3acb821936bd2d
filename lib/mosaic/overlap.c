/* The area that tiles share, two by two: of the triangles that each is made of, with their signs, so that tiles need
 * not be convex. */
#include "mosaic/mosaic.h"

#include "util/polygon.h"

#include <math.h>
#include <string.h>

enum { GRID = 1000 };

typedef struct point {
    double x, y;
} point;

typedef struct ring {
    point p[8];
    int count;
} ring;

/* What of a ring lies to the left of a line, as seen. */
static void clip(ring *r, point a, point b)
{
    ring out = { .count = 0 };
    for (int i = 0; i < r->count; i++) {
        point p = r->p[i], q = r->p[(i + 1) % r->count];
        double dp = pv_left_turn(a.x, a.y, b.x, b.y, p.x, p.y), dq = pv_left_turn(a.x, a.y, b.x, b.y, q.x, q.y);
        if (dp >= 0)
            out.p[out.count++] = p;
        if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) {
            double t = dp / (dp - dq);
            out.p[out.count++] = (point){ p.x + t * (q.x - p.x), p.y + t * (q.y - p.y) };
        }
    }
    *r = out;
}

static int apart_along(const point *a, const point *b)
{
    for (int k = 0; k < 3; k++) {
        point p = a[k], q = a[(k + 1) % 3], own = a[(k + 2) % 3];
        double side = pv_left_turn(p.x, p.y, q.x, q.y, own.x, own.y) > 0 ? 1 : -1;
        int beyond = 1;
        for (int i = 0; i < 3; i++)
            beyond &= side * pv_left_turn(p.x, p.y, q.x, q.y, b[i].x, b[i].y) <= 0;
        if (beyond)
            return 1;
    }
    return 0;
}

/* With the sign of both triangles. On the grid that vertices lie on it is exact whether they share any area. */
static double shared(const point *a, const point *b)
{
    double sa = pv_left_turn(a[0].x, a[0].y, a[1].x, a[1].y, a[2].x, a[2].y);
    double sb = pv_left_turn(b[0].x, b[0].y, b[1].x, b[1].y, b[2].x, b[2].y), area = 0;
    if (sa == 0 || sb == 0 || apart_along(a, b) || apart_along(b, a))
        return 0;
    ring r = { { a[0], sa > 0 ? a[1] : a[2], sa > 0 ? a[2] : a[1] }, 3 };
    for (int k = 0; k < 3 && r.count; k++)
        clip(&r, b[sb > 0 ? k : (3 - k) % 3], b[sb > 0 ? (k + 1) % 3 : (2 - k) % 3]);
    for (int i = 1; i + 1 < r.count; i++)
        area += pv_left_turn(r.p[0].x, r.p[0].y, r.p[i].x, r.p[i].y, r.p[i + 1].x, r.p[i + 1].y) / 2;
    return (sa > 0) == (sb > 0) ? area : -area;
}

static point corner(const pave_stones *s, int32_t tile, int64_t i)
{
    const double *xy = s->vertices + 2 * (s->starts[tile] + i);
    return (point){ floor(xy[0] * GRID + 0.5), floor(xy[1] * GRID + 0.5) };
}

static double shared_by(const pave_stones *s, int32_t a, int32_t b)
{
    double area = 0;
    for (int64_t i = 1; i + 1 < s->starts[a + 1] - s->starts[a]; i++)
        for (int64_t k = 1; k + 1 < s->starts[b + 1] - s->starts[b]; k++) {
            point p[3] = { corner(s, a, 0), corner(s, a, i), corner(s, a, i + 1) };
            point q[3] = { corner(s, b, 0), corner(s, b, k), corner(s, b, k + 1) };
            area += shared(p, q);
        }
    const double rounding = 1e-6; /* square grid units: of tiles that are not convex, whose triangles cancel out */
    return area > rounding ? area / ((double)GRID * GRID) : 0;
}

typedef struct bounds {
    double left, top, right, bottom;
} bounds;

static bounds bounds_of(const pave_stones *s, int32_t tile)
{
    bounds b = { INFINITY, INFINITY, -INFINITY, -INFINITY };
    for (int64_t i = 0; i < s->starts[tile + 1] - s->starts[tile]; i++) {
        point p = corner(s, tile, i);
        b = (bounds){ fmin(b.left, p.x), fmin(b.top, p.y), fmax(b.right, p.x), fmax(b.bottom, p.y) };
    }
    return b;
}

/* Tiles by the square of a grid in which the corner of their bounds lies; none is larger than a square. */
typedef struct grid {
    bounds *box;
    int32_t *first, *next; /* of a square; after a tile; -1 at the end */
    double side;
    int32_t across, down;
} grid;

static int32_t square_of(double v, double side, int32_t count)
{
    double i = floor(v / side) + 1;
    return i > 0 ? i < count - 1 ? (int32_t)i : count - 1 : 0;
}

static void fill(const pave_stones *s, grid *g)
{
    for (int32_t i = 0; i < g->across * g->down; i++)
        g->first[i] = -1;
    for (int32_t i = s->count - 1; i >= 0; i--) {
        int32_t x = square_of(g->box[i].left, g->side, g->across), y = square_of(g->box[i].top, g->side, g->down);
        int32_t at = y * g->across + x;
        g->next[i] = g->first[at];
        g->first[at] = i;
    }
}

/* With tiles from `copies` on each pair is met twice. */
static double with_others(const pave_stones *s, const grid *g, int32_t tile, int32_t copies)
{
    const bounds *b = &g->box[tile];
    int32_t x = square_of(b->left, g->side, g->across), y = square_of(b->top, g->side, g->down);
    double area = 0;
    for (int32_t v = y > 0 ? y - 1 : 0; v <= y + 1 && v < g->down; v++)
        for (int32_t u = x > 0 ? x - 1 : 0; u <= x + 1 && u < g->across; u++)
            for (int32_t k = g->first[v * g->across + u]; k >= 0; k = g->next[k]) {
                const bounds *c = &g->box[k];
                if (k > tile && c->left < b->right && c->right > b->left && c->top < b->bottom && c->bottom > b->top)
                    area += shared_by(s, tile, k) / (k < copies ? 1 : 2);
            }
    return area;
}

/* Of the first `own` tiles with all that follow. */
static pave_result sum_up(pave_context *context, const pave_stones *s, int32_t own, double *area)
{
    pave_result result = PAVE_OK;
    grid g = { .side = GRID };
    *area = 0;
    g.box = pv_allocate(context, (size_t)s->count, sizeof *g.box, &result);
    for (int32_t i = 0; i < s->count && !result; i++) {
        g.box[i] = bounds_of(s, i);
        g.side = fmax(g.side, fmax(g.box[i].right - g.box[i].left, g.box[i].bottom - g.box[i].top));
    }
    g.across = (int32_t)((double)s->plane_width * GRID / g.side) + 3;
    g.down = (int32_t)((double)s->plane_height * GRID / g.side) + 3;
    if (!result)
        g.first = pv_allocate(context, (size_t)g.across * (size_t)g.down, sizeof *g.first, &result);
    if (!result)
        g.next = pv_allocate(context, (size_t)s->count, sizeof *g.next, &result);
    if (!result)
        fill(s, &g);
    for (int32_t i = 0; i < own && !result; i++) {
        *area += with_others(s, &g, i, own);
        if (i % 1024 == 0)
            result = pv_progress(context, 1);
    }
    pv_release(g.box);
    pv_release(g.first);
    pv_release(g.next);
    return result;
}

pave_result pv_overlap(pave_context *context, const pave_stones *stones, int periodic, double *area)
{
    pave_stones copies = { .count = 0 };
    if (!periodic)
        return sum_up(context, stones, stones->count, area);
    pave_result result = pv_period_copies(context, stones, &copies);
    if (!result)
        result = sum_up(context, &copies, stones->count, area);
    pv_release(copies.starts);
    pv_release(copies.vertices);
    return result;
}
