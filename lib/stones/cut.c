/* Stones cut along the borders between the periods of a plane that repeats; all parts are moved into the first period.
 *
 * Everything is on the grid of 1/1000 px. A border runs a hair beyond its grid line, so that no corner lies on it;
 * where a side crosses it both parts get the same corner, rounded, on the line. Along the line crossings alternate
 * between entering the stone and leaving it, so that each is joined to its neighbour. */
#include "stones/stones.h"

#include "util/fixed.h"
#include "util/polygon.h"

#include <stdlib.h>
#include <string.h>

enum { GRID = 1000, MOST = 256, THIN = 2 /* parts no thicker than so many units are dropped */ };

typedef struct part {
    int32_t count;
    pv_cell at[MOST];
} part;

/* A ring with its crossings; `partner` is where the border leads from a crossing. */
typedef struct node {
    pv_cell at;
    int32_t high;    /* beyond the border; of a crossing: whether the node before is */
    int32_t partner; /* -1: a corner */
    double along;    /* of a crossing, unrounded */
    int32_t seen;
} node;

typedef struct cutter {
    int32_t width, height; /* of a period */
    int32_t apart;         /* stones do not overlap, nor may their parts */
    pave_stones *out;      /* its arrays are NULL while parts are counted */
    int64_t corners;
    int32_t site;
    uint8_t colour;
} cutter;

static int32_t across(pv_cell p, int axis)
{
    return axis ? p.y : p.x;
}

static node crossing(pv_cell a, pv_cell b, int axis, int32_t line)
{
    double along_a = across(a, !axis), along_b = across(b, !axis), from = across(a, axis), to = across(b, axis);
    double along = along_a + (along_b - along_a) * (line - from) / (to - from);
    int32_t rounded = (int32_t)floor(along + 0.5);
    return (node){ .at = axis ? (pv_cell){ rounded, line } : (pv_cell){ line, rounded }, .high = from > line,
                   .along = along };
}

/* The corners, with a crossing on each side that crosses the line. The same from either end of a side. */
static int32_t list_nodes(const part *p, int axis, int32_t line, node *nodes)
{
    int32_t n = 0;
    for (int32_t i = 0; i < p->count; i++) {
        pv_cell a = p->at[i], b = p->at[i + 1 < p->count ? i + 1 : 0];
        int high = across(a, axis) > line;
        nodes[n++] = (node){ .at = a, .high = high, .partner = -1 };
        if (high == (across(b, axis) > line))
            continue;
        nodes[n] = high ? crossing(b, a, axis, line) : crossing(a, b, axis, line);
        nodes[n++].high = high;
    }
    return n;
}

static void put_along(node *n, int axis, double along)
{
    if (axis)
        n->at.x = (int32_t)along;
    else
        n->at.y = (int32_t)along;
}

/* Joins crossings that are neighbours on the line; those of stones that lie apart are rounded into the stone. */
static void join(node *nodes, int32_t count, int axis, int apart)
{
    int32_t order[2 * MOST], n = 0;
    for (int32_t i = 0; i < count; i++) {
        if (nodes[i].partner < 0)
            continue;
        int32_t at = n++;
        for (; at > 0 && nodes[order[at - 1]].along > nodes[i].along; at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
    for (int32_t k = 0; k + 1 < n; k += 2) {
        nodes[order[k]].partner = order[k + 1];
        nodes[order[k + 1]].partner = order[k];
        if (!apart)
            continue;
        put_along(&nodes[order[k]], axis, ceil(nodes[order[k]].along));
        put_along(&nodes[order[k + 1]], axis, floor(nodes[order[k + 1]].along));
    }
}

static void add_corner(part *p, pv_cell at)
{
    if (p->count && p->at[p->count - 1].x == at.x && p->at[p->count - 1].y == at.y)
        return;
    if (p->count < MOST)
        p->at[p->count++] = at;
}

/* The part that a corner belongs to: along the ring, and where it leaves the corner's side of the line, along that. */
static void walk(node *nodes, int32_t count, int32_t start, part *p)
{
    p->count = 0;
    for (int32_t i = start; !nodes[i].seen; i = i + 1 < count ? i + 1 : 0) {
        nodes[i].seen = nodes[i].partner < 0;
        add_corner(p, nodes[i].at);
        if (nodes[i].partner >= 0) {
            i = nodes[i].partner;
            add_corner(p, nodes[i].at);
        }
    }
    while (p->count > 1 && p->at[0].x == p->at[p->count - 1].x && p->at[0].y == p->at[p->count - 1].y)
        p->count--;
}

static void make_hull(part *p)
{
    pv_cell hull[MOST + 1];
    p->count = p->count < 3 ? 0 : pv_convex_hull(p->at, p->count, hull);
    memcpy(p->at, hull, (size_t)p->count * sizeof *hull);
}

/* Takes away one corner that sticks out, so that the rest holds; or all. */
static void trim(part *p)
{
    for (int32_t i = 0; i < p->count; i++) {
        part less = { .count = p->count - 1 };
        memcpy(less.at, p->at, (size_t)i * sizeof *p->at);
        memcpy(less.at + i, p->at + i + 1, (size_t)(p->count - 1 - i) * sizeof *p->at);
        int64_t turn = pv_cell_turn(p->at[(i + p->count - 1) % p->count], p->at[i], p->at[(i + 1) % p->count]);
        if (turn > 0 && pv_ring_valid(less.at, less.count)) {
            *p = less;
            return;
        }
    }
    p->count = 0;
}

/* Rounding can make a part touch itself, or leave hardly anything of it. */
static int is_fine(part *p, int apart)
{
    if (!pv_ring_valid(p->at, p->count) && apart)
        trim(p);
    else if (!pv_ring_valid(p->at, p->count))
        make_hull(p);
    pv_cell low = p->at[0], high = p->at[0];
    for (int32_t i = 0; i < p->count; i++) {
        low.x = p->at[i].x < low.x ? p->at[i].x : low.x;
        low.y = p->at[i].y < low.y ? p->at[i].y : low.y;
        high.x = p->at[i].x > high.x ? p->at[i].x : high.x;
        high.y = p->at[i].y > high.y ? p->at[i].y : high.y;
    }
    int64_t length = high.x - low.x > high.y - low.y ? high.x - low.x : high.y - low.y;
    return p->count >= 3 && p->count < MOST && pv_ring_area(p->at, p->count) > 2 * THIN * length;
}

static void emit(cutter *c, const part *p, int32_t column, int32_t row)
{
    pave_stones *out = c->out;
    for (int32_t i = 0; i < p->count && out->vertices; i++) {
        out->vertices[2 * (c->corners + i)] = (double)(p->at[i].x - column * c->width) / GRID;
        out->vertices[2 * (c->corners + i) + 1] = (double)(p->at[i].y - row * c->height) / GRID;
    }
    if (out->vertices) {
        out->colours[out->count] = c->colour;
        out->sites[out->count] = c->site;
        out->starts[out->count + 1] = c->corners + p->count;
    }
    c->corners += p->count;
    out->count++;
}

/* The periods that a part lies in, first and last. A side on the border belongs to the period before. */
static void periods_of(const part *p, int axis, int32_t period, int32_t *first, int32_t *last)
{
    int32_t low = INT32_MAX, high = INT32_MIN;
    for (int32_t i = 0; i < p->count; i++) {
        low = across(p->at[i], axis) < low ? across(p->at[i], axis) : low;
        high = across(p->at[i], axis) > high ? across(p->at[i], axis) : high;
    }
    *first = (int32_t)pv_floor_div(low, period);
    *last = (int32_t)pv_floor_div((int64_t)high - 1, period);
}

/* Cuts along the lines across one axis, then each part along those across the other. */
static void cut(cutter *c, const part *p, int axis, int32_t column)
{
    int32_t first, last, period = axis ? c->height : c->width;
    periods_of(p, axis, period, &first, &last);
    if (first >= last) {
        if (axis)
            emit(c, p, column, first);
        else
            cut(c, p, 1, first);
        return;
    }
    node nodes[2 * MOST];
    int32_t count = list_nodes(p, axis, (first + 1) * period, nodes);
    join(nodes, count, axis, c->apart);
    for (int32_t i = 0; i < count; i++) {
        part piece;
        if (nodes[i].partner >= 0 || nodes[i].seen)
            continue;
        walk(nodes, count, i, &piece);
        if (is_fine(&piece, c->apart))
            cut(c, &piece, axis, column);
    }
}

static void cut_all(const pave_stones *stones, cutter *c)
{
    c->corners = 0;
    c->out->count = 0;
    for (int32_t s = 0; s < stones->count; s++) {
        const double *v = stones->vertices + 2 * stones->starts[s];
        part p = { .count = (int32_t)(stones->starts[s + 1] - stones->starts[s]) };
        for (int32_t i = 0; i < p.count; i++)
            p.at[i] = (pv_cell){ (int32_t)floor(v[2 * i] * GRID + 0.5), (int32_t)floor(v[2 * i + 1] * GRID + 0.5) };
        c->site = stones->sites[s];
        c->colour = stones->colours[s];
        cut(c, &p, 0, 0);
    }
}

pave_result pv_stones_cut(pave_context *context, pave_stones *stones)
{
    pave_stones parts = { .count = 0 };
    cutter c = { .width = GRID * stones->plane_width, .height = GRID * stones->plane_height, .out = &parts,
                 .apart = stones->params.mode == PAVE_MODE_BEST };
    cut_all(stones, &c);
    pave_result result = pv_stones_allocate(context, (size_t)parts.count, (size_t)c.corners, &parts);
    if (!result)
        cut_all(stones, &c);
    pv_stones_drop(result ? &parts : stones);
    if (result)
        return result;
    stones->starts = parts.starts;
    stones->vertices = parts.vertices;
    stones->colours = parts.colours;
    stones->sites = parts.sites;
    stones->count = parts.count;
    return PAVE_OK;
}
