/* Gauss-Newton, a block at a time: what is asked for is made linear, and all vertices of the block step at once. */
#include "stones/realise.h"

#include "stones/assign.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

/* A face with a vertex elsewhere: is it simple, and no larger than it may be unless it was? */
static int face_fits(const pv_tess *tess, int64_t place, pv_cell there, int64_t most)
{
    pv_cell ring[SHORT_RING];
    int32_t face = tess->face_of[place], count = pv_tess_ring(tess, face, ring, SHORT_RING);
    int32_t at = (int32_t)(place - tess->first[face]);
    if (count > SHORT_RING)
        return 0;
    pv_cell a = ring[at ? at - 1 : count - 1], b = ring[at + 1 < count ? at + 1 : 0];
    int grows = pv_cell_turn(a, there, b) > pv_cell_turn(a, ring[at], b);
    ring[at] = there;
    if (most && grows && pv_ring_area(ring, count) > 2 * most)
        return 0;
    return is_convex(ring, count) || pv_ring_valid_at(ring, count, at);
}

static int fits(const pv_tess *tess, int32_t vertex, pv_cell there, int64_t most)
{
    for (int64_t s = tess->star[vertex]; s < tess->star[vertex + 1]; s++)
        if (!face_fits(tess, tess->spoke[s], there, most))
            return 0;
    return 1;
}

enum { DESCENTS = 10, STILL = 4 }; /* STILL: grid units that are not worth a move */

#define LEAST_BEND 0.2 /* radians that a corner is bent by */
#define STIFF 0.12 /* what a step costs: of two ways to make all straight the shorter one is taken */

/* What a vertex can do: a step z moves it by (xx zx + xy zy, xy zx + yy zy). */
typedef struct mobility {
    double xx, xy, yy;
} mobility;

typedef struct realising {
    pv_tess *tess;
    const pv_realise_params *params;
    pv_cell *origin;
    uint8_t *is_corner; /* of places */
    int32_t *slot;      /* of vertices: their number in their block */
} realising;

/* What is asked for: that b lies on the line from a to c, or sticks out of it at least a little, or that a and c are
 * apart. */
typedef enum wish_kind { STRAIGHT, CORNER, APART } wish_kind;

typedef struct wish {
    wish_kind kind;
    int32_t vertex[3], number[3]; /* among the crew, -1: another one, or one that stays */
} wish;

enum { WISHES = 2048 };

/* The vertices that are moved at once, and what is amiss around them. */
typedef struct crew {
    const realising *r;
    const int32_t *vertex;
    int32_t count, wishes, amiss;
    mobility able[PV_ROWS_VERTICES];
    wish wish[WISHES];
    pv_rows rows;
} crew;

/* The number of a vertex in the crew; -1: it is none of it. */
static int32_t number_of(const crew *c, int32_t v)
{
    int64_t i = c->r->slot[v] - (int64_t)c->r->slot[c->vertex[0]];
    return i >= 0 && i < c->count && c->vertex[i] == v ? (int32_t)i : -1;
}

static void add_wish(crew *c, wish_kind kind, int32_t a, int32_t v, int32_t b)
{
    wish w = { kind, { a, v, b }, { -1, -1, -1 } };
    int asked = 0;
    for (int k = 0; k < 3; k++) {
        int32_t i = number_of(c, w.vertex[k]);
        if (i < 0 || c->able[i].xx + c->able[i].yy <= 0)
            continue;
        w.number[k] = i;
        asked = 1;
    }
    if (asked && c->wishes < WISHES)
        c->wish[c->wishes++] = w;
}

static int64_t next_corner(const realising *r, int64_t place)
{
    do
        place = pv_tess_next(r->tess, place);
    while (!r->is_corner[place]);
    return place;
}

static int64_t last_corner(const realising *r, int64_t place)
{
    do
        place = pv_tess_previous(r->tess, place);
    while (!r->is_corner[place]);
    return place;
}

/* All that a face asks for. */
static void add_face(crew *c, int32_t face)
{
    const realising *r = c->r;
    const pv_tess *tess = r->tess;
    int64_t first = tess->first[face], end = tess->first[face + 1];
    int32_t corners = 0;
    for (int64_t p = first; p < end; p++)
        corners += r->is_corner[p];
    if (corners < 3)
        return;
    while (!r->is_corner[first])
        first++;
    int64_t a = first, b = next_corner(r, a);
    do {
        int64_t d = next_corner(r, b);
        for (int64_t p = pv_tess_next(tess, a); p != b; p = pv_tess_next(tess, p))
            add_wish(c, STRAIGHT, tess->corner[a], tess->corner[p], tess->corner[b]);
        add_wish(c, APART, tess->corner[a], tess->corner[a], tess->corner[b]);
        if (corners > 3)
            add_wish(c, CORNER, tess->corner[a], tess->corner[b], tess->corner[d]);
        a = b, b = d;
    } while (a != first);
}

/* Is a vertex the first one of the crew in this face? */
static int is_first(const crew *c, int32_t face, int32_t number)
{
    const pv_tess *tess = c->r->tess;
    for (int64_t p = tess->first[face]; p < tess->first[face + 1]; p++) {
        int32_t i = number_of(c, tess->corner[p]);
        if (i >= 0 && i < number)
            return 0;
    }
    return 1;
}

static void gather_wishes(crew *c)
{
    const pv_tess *tess = c->r->tess;
    c->wishes = 0;
    for (int32_t i = 0; i < c->count; i++)
        for (int64_t s = tess->star[c->vertex[i]]; s < tess->star[c->vertex[i] + 1]; s++)
            if (is_first(c, tess->face_of[tess->spoke[s]], i))
                add_face(c, tess->face_of[tess->spoke[s]]);
}

static double length_of(double x, double y)
{
    return sqrt(x * x + y * y);
}

/* A step of the wish's k-th vertex along (x, y) counts. */
static void add_end(const crew *c, const wish *w, int k, double x, double y, pv_row *row)
{
    int32_t i = w->number[k];
    if (i < 0)
        return;
    const mobility *m = &c->able[i];
    row->end[row->ends] = i;
    row->x[row->ends] = m->xx * x + m->xy * y;
    row->y[row->ends++] = m->xy * x + m->yy * y;
}

/* Sides that are too short push their ends apart. */
static int ask_apart(const crew *c, const wish *w, double dx, double dy, double length, pv_row *row)
{
    if (length >= c->r->params->apart)
        return 0;
    row->rest = 0.5 * (length - c->r->params->apart);
    add_end(c, w, 0, -0.5 * dx / length, -0.5 * dy / length, row);
    add_end(c, w, 2, 0.5 * dx / length, 0.5 * dy / length, row);
    return 1;
}

/* What a wish asks for where all is now; 0: nothing. */
static int ask(crew *c, const wish *w, pv_row *row)
{
    const pv_cell *at = c->r->tess->at;
    pv_cell a = at[w->vertex[0]], v = at[w->vertex[1]], b = at[w->vertex[2]];
    double dx = (double)b.x - a.x, dy = (double)b.y - a.y, wx = (double)v.x - a.x, wy = (double)v.y - a.y;
    double length = length_of(dx, dy), weight = w->kind == CORNER ? 0.5 : 1;
    if (!(length > 0))
        return 0;
    if (w->kind == APART)
        return ask_apart(c, w, dx, dy, length, row);
    double nx = -dy / length, ny = dx / length, t = (wx * dx + wy * dy) / (length * length);
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    double off = nx * wx + ny * wy, wanted = w->kind == CORNER ? LEAST_BEND * t * (1 - t) * length : 0;
    if (w->kind == CORNER && off >= wanted)
        return 0;
    row->rest = weight * (off - wanted);
    add_end(c, w, 1, weight * nx, weight * ny, row);
    add_end(c, w, 0, -weight * (1 - t) * nx, -weight * (1 - t) * ny, row);
    add_end(c, w, 2, -weight * t * nx, -weight * t * ny, row);
    c->amiss |= fabs(row->rest) > STILL;
    return 1;
}

static void ask_all(crew *c)
{
    const pv_realise_params *params = c->r->params;
    c->amiss = c->rows.count = 0;
    c->rows.vertices = c->count;
    for (int32_t i = 0; i < c->count; i++) {
        c->rows.own[i] = (pv_equations){ STIFF, 0, STIFF, 0, 0 };
        if (params->pull)
            params->pull(params->user, c->r->tess, c->vertex[i], &c->rows.own[i]);
    }
    for (int32_t i = 0; i < c->wishes && c->rows.count < PV_ROWS_MOST; i++) {
        pv_row *row = &c->rows.row[c->rows.count];
        row->ends = 0;
        c->rows.count += ask(c, &c->wish[i], row);
    }
}

/* Counted from where it is, so that it is the same wherever that is. */
static int32_t limited(int32_t here, double way, int32_t origin, int32_t reach)
{
    double low = (double)origin - here - reach, high = (double)origin - here + reach;
    way = way < low ? low : way > high ? high : way;
    return here + (int32_t)floor(way + 0.5);
}

static int64_t square_to(const pv_tess *tess, int64_t place, pv_cell p)
{
    pv_cell q = tess->at[tess->corner[place]];
    int64_t dx = (int64_t)q.x - p.x, dy = (int64_t)q.y - p.y;
    return dx * dx + dy * dy;
}

/* Would a stone's side become shorter than it may be, or shorter still? */
static int gets_short(const realising *r, int32_t v, pv_cell there)
{
    const pv_tess *tess = r->tess;
    int64_t least = (int64_t)r->params->least * r->params->least;
    for (int64_t s = tess->star[v]; s < tess->star[v + 1]; s++) {
        int64_t place = tess->spoke[s];
        if (!r->is_corner[place])
            continue;
        int64_t ends[2] = { next_corner(r, place), last_corner(r, place) };
        for (int k = 0; k < 2; k++) {
            int64_t now = square_to(tess, ends[k], there);
            if (now < least && now < square_to(tess, ends[k], tess->at[v]))
                return 1;
        }
    }
    return 0;
}

/* As far as can be, in finer steps where faces have a size to keep to. */
static void move(const crew *c, int32_t i)
{
    const pv_realise_params *params = c->r->params;
    pv_tess *tess = c->r->tess;
    int32_t v = c->vertex[i], reach = tess->kind[v] & PV_CONTOUR ? params->sway : params->reach;
    const double *z = c->rows.step[i];
    double dx = c->able[i].xx * z[0] + c->able[i].xy * z[1], dy = c->able[i].xy * z[0] + c->able[i].yy * z[1];
    double way = length_of(dx, dy), shorter = way > params->step ? params->step / way : 1;
    pv_cell here = tess->at[v], origin = c->r->origin[v];
    dx *= shorter, dy *= shorter;
    for (int halving = 0; halving < (params->most ? 4 : 3); halving++, dx /= 2, dy /= 2) {
        pv_cell there = { limited(here.x, dx, origin.x, reach), limited(here.y, dy, origin.y, reach) };
        if (abs(there.x - here.x) + abs(there.y - here.y) < STILL)
            return;
        if (gets_short(c->r, v, there) || !fits(tess, v, there, params->most))
            continue;
        tess->at[v] = there;
        return;
    }
}

/* The two neighbours along the contour; 0 if there are not two. */
static int contour_neighbours(const pv_tess *tess, int32_t v, pv_cell out[2])
{
    int count = 0;
    for (int64_t s = tess->star[v]; s < tess->star[v + 1]; s++) {
        int64_t place = tess->spoke[s];
        int32_t w = tess->corner[pv_tess_next(tess, place)];
        uint8_t colour = tess->colour[tess->face_of[place]];
        for (int64_t k = tess->star[w]; k < tess->star[w + 1]; k++) {
            if (tess->corner[pv_tess_next(tess, tess->spoke[k])] != v ||
                tess->colour[tess->face_of[tess->spoke[k]]] == colour)
                continue;
            if (count < 2)
                out[count] = tess->at[w];
            count++;
        }
    }
    return count == 2;
}

/* Vertices of the contour go along it rather than across; its corners stay. */
static mobility mobility_of(const realising *r, int32_t v)
{
    mobility still = { 0, 0, 0 }, free = { 1, 0, 1 };
    pv_cell n[2], here = r->tess->at[v];
    if (!(r->tess->kind[v] & (PV_BORDER | PV_CONTOUR)))
        return free;
    if ((r->tess->kind[v] & PV_BORDER) || !r->params->sway || !contour_neighbours(r->tess, v, n))
        return still;
    double ux = (double)here.x - n[0].x, uy = (double)here.y - n[0].y, wx = (double)n[1].x - here.x;
    double wy = (double)n[1].y - here.y, u = length_of(ux, uy), w = length_of(wx, wy);
    if (!(u > 0) || !(w > 0) || ux * wx + uy * wy < 0.94 * u * w)
        return still;
    double tx = ux / u + wx / w, ty = uy / u + wy / w, t = length_of(tx, ty), along = 0.8, across = 0.3;
    tx /= t, ty /= t;
    return (mobility){ across + (along - across) * tx * tx, (along - across) * tx * ty,
                       across + (along - across) * ty * ty };
}

static void relax(crew *c)
{
    int32_t rounds = c->r->params->rounds;
    for (int32_t i = 0; i < c->count; i++)
        c->able[i] = mobility_of(c->r, c->vertex[i]);
    gather_wishes(c);
    for (int32_t round = 0; round < rounds; round++) {
        ask_all(c);
        if (!c->amiss && !c->r->params->pull)
            return;
        pv_rows_solve(&c->rows, DESCENTS);
        for (int32_t i = 0; i < c->count; i++)
            move(c, i);
    }
}

static void relax_block(void *data, const int32_t *vertices, int64_t count)
{
    crew c;
    c.r = data;
    for (int64_t i = 0; i < count; i += PV_ROWS_VERTICES) {
        c.vertex = vertices + i;
        c.count = (int32_t)(count - i < PV_ROWS_VERTICES ? count - i : PV_ROWS_VERTICES);
        relax(&c);
    }
}

static void number_slots(const realising *r, const pv_blocks *blocks)
{
    for (int64_t b = 0; b < (int64_t)blocks->across * blocks->down; b++)
        for (int64_t i = blocks->first[b]; i < blocks->first[b + 1]; i++)
            r->slot[blocks->vertex[i]] = (int32_t)(i - blocks->first[b]);
}

static pave_result prepare(pave_context *context, realising *r)
{
    pave_result result = PAVE_OK;
    pv_tess *tess = r->tess;
    int64_t places = tess->first[tess->face_count];
    r->origin = pv_allocate(context, (size_t)tess->vertex_count, sizeof *r->origin, &result);
    if (!result)
        r->slot = pv_allocate_zeroed(context, (size_t)tess->vertex_count, sizeof *r->slot, &result);
    if (!result)
        r->is_corner = pv_allocate(context, (size_t)places, 1, &result);
    if (result)
        return result;
    memcpy(r->origin, tess->at, (size_t)tess->vertex_count * sizeof *r->origin);
    for (int64_t p = 0; p < places; p++)
        r->is_corner[p] = (uint8_t)pv_is_corner(tess, p);
    return PAVE_OK;
}

pave_result pv_realise_flats(pave_context *context, const pv_realise_params *params, pv_tess *tess, double from,
                             double to)
{
    realising r = { tess, params, NULL, NULL, NULL };
    pave_result result = prepare(context, &r);
    for (int sweep = 0; sweep < 2 && !result; sweep++) {
        pv_blocks blocks;
        result = pv_blocks_build(context, tess, params->block, sweep, &blocks);
        if (!result) {
            number_slots(&r, &blocks);
            result = pv_blocks_run(context, &blocks, relax_block, &r, from + (to - from) * sweep / 2,
                                   from + (to - from) * (sweep + 1) / 2);
        }
        pv_blocks_free(&blocks);
    }
    pv_release(r.origin);
    pv_release(r.slot);
    pv_release(r.is_corner);
    return result;
}
