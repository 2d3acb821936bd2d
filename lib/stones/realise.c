/* Gauss-Newton, a vertex at a time: the few constraints that it takes part in are linear in its place. */
#include "stones/realise.h"

#include "stones/assign.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int64_t corner_from(const pv_tess *tess, int64_t place, int on)
{
    int64_t p = place;
    do
        p = on ? pv_tess_next(tess, p) : pv_tess_previous(tess, p);
    while (p != place && !pv_is_corner(tess, p));
    return p;
}

/* The vertex at `place` is flat: it should lie between the corners around it. */
static void own_line(const pv_tess *tess, int64_t place, pv_equations *e)
{
    pv_cell v = tess->at[tess->corner[place]], a = tess->at[tess->corner[corner_from(tess, place, 0)]];
    pv_cell b = tess->at[tess->corner[corner_from(tess, place, 1)]];
    double dx = (double)b.x - a.x, dy = (double)b.y - a.y, length = sqrt(dx * dx + dy * dy);
    if (length > 0)
        pv_add_equation(e, 1, -dy / length, dx / length,
                        (dx * ((double)v.y - a.y) - dy * ((double)v.x - a.x)) / length);
}

/* The vertex at `place` is a corner: flat ones on its side should lie between it and the next corner. */
static void line_of_others(const pv_tess *tess, int64_t place, int on, pv_equations *e)
{
    int64_t first = on ? pv_tess_next(tess, place) : pv_tess_previous(tess, place);
    if (pv_is_corner(tess, first))
        return;
    pv_cell v = tess->at[tess->corner[place]], b = tess->at[tess->corner[corner_from(tess, place, on)]];
    double dx = (double)b.x - v.x, dy = (double)b.y - v.y, square = dx * dx + dy * dy, length = sqrt(square);
    if (!(length > 0))
        return;
    int32_t face = tess->face_of[place];
    for (int64_t p = first; !pv_is_corner(tess, p); p = on ? pv_tess_next(tess, p) : pv_tess_previous(tess, p)) {
        if (tess->flat[tess->corner[p]] != face)
            continue;
        pv_cell w = tess->at[tess->corner[p]];
        double wx = (double)w.x - v.x, wy = (double)w.y - v.y, t = (wx * dx + wy * dy) / square;
        t = t < 0 ? 0 : t > 1 ? 1 : t;
        double rest = (dx * wy - dy * wx) / length;
        pv_add_equation(e, 1, (1 - t) * dy / length, -(1 - t) * dx / length, rest);
    }
}

enum { LEFT_TURNS, SOME_RIGHT, FOLDED };

/* Turns of a ring; once around with left turns only it is convex, and so simple. */
static int is_convex(const pv_cell *ring, int32_t count)
{
    int flips = 0;
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[i], b = ring[i + 1 < count ? i + 1 : 0], c = ring[i + 2 < count ? i + 2 : i + 2 - count];
        int64_t ux = (int64_t)b.x - a.x, uy = (int64_t)b.y - a.y, wx = (int64_t)c.x - b.x, wy = (int64_t)c.y - b.y;
        if (ux * -wy + uy * wx <= 0)
            return 0;
        flips += (uy > 0 || (uy == 0 && ux > 0)) != (wy > 0 || (wy == 0 && wx > 0));
    }
    return flips == 2;
}

enum { SHORT_RING = 48 };

static int face_fits(const pv_tess *tess, int32_t face, int32_t vertex, pv_cell there)
{
    pv_cell ring[SHORT_RING];
    int32_t count = pv_tess_size(tess, face), at = -1;
    if (count > SHORT_RING)
        return 0;
    for (int32_t i = 0; i < count; i++) {
        int32_t v = tess->corner[tess->first[face] + i];
        ring[i] = v == vertex ? there : tess->at[v];
        at = v == vertex ? i : at;
    }
    return is_convex(ring, count) || pv_ring_valid_at(ring, count, at);
}

int pv_tess_fits(const pv_tess *tess, int32_t vertex, pv_cell there)
{
    for (int64_t s = tess->star[vertex]; s < tess->star[vertex + 1]; s++)
        if (!face_fits(tess, tess->face_of[tess->spoke[s]], vertex, there))
            return 0;
    return 1;
}

typedef struct realising {
    pv_tess *tess;
    pv_cell *origin;
    uint8_t *stirred; /* of faces: the last round, from 1, in which a vertex of it moved */
    int32_t rounds, reach, step, apart, least;
    pv_pull *pull;
    const void *user;
} realising;

/* Counted from where it is, so that it is the same wherever that is. */
static int32_t limited(int32_t here, double way, int32_t origin, int32_t reach)
{
    double low = (double)origin - here - reach, high = (double)origin - here + reach;
    way = way < low ? low : way > high ? high : way;
    return here + (int32_t)floor(way + 0.5);
}

/* Sides that are too short push their ends apart. */
static void keep_apart(const pv_tess *tess, int64_t place, double least, pv_equations *e)
{
    pv_cell v = tess->at[tess->corner[place]], w = tess->at[tess->corner[pv_tess_next(tess, place)]];
    double dx = (double)v.x - w.x, dy = (double)v.y - w.y, length = sqrt(dx * dx + dy * dy);
    if (length < least && length > 0)
        pv_add_equation(e, 1, dx / length, dy / length, length - least);
}

static void gather(const pv_tess *tess, int32_t v, double least, pv_equations *e)
{
    for (int64_t s = tess->star[v]; s < tess->star[v + 1]; s++) {
        int64_t place = tess->spoke[s];
        keep_apart(tess, place, least, e);
        if (tess->flat[v] == tess->face_of[place]) {
            own_line(tess, place, e);
            continue;
        }
        line_of_others(tess, place, 0, e);
        line_of_others(tess, place, 1, e);
    }
}

static int64_t square_to(const pv_tess *tess, int64_t place, pv_cell p)
{
    pv_cell q = tess->at[tess->corner[place]];
    int64_t dx = (int64_t)q.x - p.x, dy = (int64_t)q.y - p.y;
    return dx * dx + dy * dy;
}

/* Would a side become shorter than it may be, or shorter still? */
static int gets_short(const realising *r, int32_t v, pv_cell there)
{
    const pv_tess *tess = r->tess;
    int64_t least = (int64_t)r->least * r->least;
    for (int64_t s = tess->star[v]; s < tess->star[v + 1]; s++) {
        int64_t next = pv_tess_next(tess, tess->spoke[s]), now = square_to(tess, next, there);
        if (now < least && now < square_to(tess, next, tess->at[v]))
            return 1;
    }
    return 0;
}

enum { STILL = 4 }; /* grid units that are not worth a move */

static void stir(const realising *r, int32_t v, uint8_t round)
{
    for (int64_t s = r->tess->star[v]; s < r->tess->star[v + 1]; s++)
        r->stirred[r->tess->face_of[r->tess->spoke[s]]] = round;
}

/* Has anything moved around a vertex since its last turn? */
static int is_stirred(const realising *r, int32_t v, uint8_t round)
{
    for (int64_t s = r->tess->star[v]; s < r->tess->star[v + 1]; s++)
        if (r->stirred[r->tess->face_of[r->tess->spoke[s]]] + 1 >= round)
            return 1;
    return 0;
}

/* `stiff`: how much it costs to move at all, which keeps the first rounds near where all was. */
static void relax_vertex(const realising *r, int32_t v, double stiff, uint8_t round)
{
    pv_tess *tess = r->tess;
    pv_equations e = { stiff, 0, stiff, 0, 0 };
    gather(tess, v, r->apart, &e);
    if (r->pull)
        r->pull(r->user, tess, v, &e);
    double det = e.xx * e.yy - e.xy * e.xy;
    double dx = (e.yy * e.bx - e.xy * e.by) / det, dy = (e.xx * e.by - e.xy * e.bx) / det;
    double way = 1.1 * sqrt(dx * dx + dy * dy), shorter = 1.1 * (way > r->step ? r->step / way : 1);
    dx *= shorter, dy *= shorter;
    pv_cell here = tess->at[v];
    for (int halving = 0; halving < 3; halving++, dx /= 2, dy /= 2) {
        pv_cell there = { limited(here.x, dx, r->origin[v].x, r->reach),
                          limited(here.y, dy, r->origin[v].y, r->reach) };
        if (abs(there.x - here.x) + abs(there.y - here.y) < STILL)
            return;
        if (gets_short(r, v, there) || !pv_tess_fits(tess, v, there))
            continue;
        tess->at[v] = there;
        stir(r, v, round);
        return;
    }
}

static void relax_block(void *data, const int32_t *vertices, int64_t count)
{
    const realising *r = data;
    for (int64_t i = 0; i < count; i++)
        stir(r, vertices[i], 0);
    for (int32_t round = 0; round < r->rounds; round++) {
        double t = (double)round / r->rounds, stiff = (1 - t) * (1 - t) * (1 - t) + 0.02;
        for (int64_t i = 0; i < count; i++)
            if (!(r->tess->kind[vertices[i]] & (PV_BORDER | PV_CONTOUR)) &&
                is_stirred(r, vertices[i], (uint8_t)(round + 1)))
                relax_vertex(r, vertices[i], stiff, (uint8_t)(round + 1));
    }
}

pave_result pv_realise_flats(pave_context *context, const pv_realise_params *params, pv_tess *tess, double from,
                             double to)
{
    realising r = { tess, NULL, NULL, params->rounds, params->reach, params->step, params->apart,
                    params->least, params->pull, params->user };
    pave_result result = PAVE_OK;
    r.origin = pv_allocate(context, (size_t)tess->vertex_count, sizeof *r.origin, &result);
    if (!result)
        r.stirred = pv_allocate(context, (size_t)tess->face_count, 1, &result);
    if (!result)
        memcpy(r.origin, tess->at, (size_t)tess->vertex_count * sizeof *r.origin);
    for (int sweep = 0; sweep < 2 && !result; sweep++) {
        pv_blocks blocks;
        result = pv_blocks_build(context, tess, params->block, sweep, &blocks);
        if (!result)
            result = pv_blocks_run(context, &blocks, relax_block, &r, from + (to - from) * sweep / 2,
                                   from + (to - from) * (sweep + 1) / 2);
        pv_blocks_free(&blocks);
    }
    pv_release(r.stirred);
    pv_release(r.origin);
    return result;
}
