/* Best mode: the cells as a mesh in which every inner vertex is a corner to all but one of its faces, so that these
 * have four corners; drawn gently to the edges and towards rectangles that the field turns; in each face a tile. The
 * mesh is on an integer grid and stays one, so that no two tiles can overlap. */
#include "mosaic/mosaic.h"

#include "stones/assign.h"
#include "stones/collapse.h"
#include "stones/contour.h"
#include "stones/inscribe.h"
#include "stones/realise.h"

#include <math.h>
#include <string.h>

enum { BLOCK_TILES = 8, MOST_CORNERS = 16 };

#define SIZE_PULL 0.5 /* how far a rectangle goes towards the size that is wanted */

/* Labels into faces: holes are labels of their own, at the end. */
static pave_result trace(pave_context *context, const pv_work *w, pv_tess *tess)
{
    pave_result result = PAVE_OK;
    pv_pieces pieces = { 0 };
    pv_net net = { 0 };
    pv_outline outline = { 0 };
    pv_tess_place place = { 0, 0, 1, w->side / 2, { 0, 0 }, NULL };
    pv_label_image image = { .width = w->width, .height = w->height, .labels = w->cvd->labels,
                             .stride = w->width, .label_count = w->n + 1, .scale = 1 };
    double least = w->side * (w->size ? w->size_min : 1) / 3;
    result = pv_pieces_split(context, &image, (int64_t)(least * least) + 1, 1, &pieces);
    if (!result)
        result = pv_net_trace(context, &pieces, &net);
    if (!result)
        result = pv_outline_draw(context, &net, &place, &outline);
    if (!result)
        result = pv_tess_build(context, &net, &place, &outline, tess);
    pv_outline_free(&outline);
    pv_net_free(&net);
    pv_pieces_free(&pieces);
    return result;
}

/* What the vertices heed besides their lines. */
typedef struct shaping {
    const pv_work *w;
    double to_edge, to_square;
} shaping;

static double away_at(const pv_work *w, double x, double y)
{
    x = fmin(fmax(x - 0.5, 0), w->width - 1.001);
    y = fmin(fmax(y - 0.5, 0), w->height - 1.001);
    const float *at = w->guide->away + (int64_t)y * w->width + (int64_t)x;
    double fx = x - floor(x), fy = y - floor(y);
    int64_t right = w->width > 1, down = w->height > 1 ? w->width : 0;
    double up = (double)at[0] + fx * ((double)at[right] - (double)at[0]);
    double low = (double)at[down] + fx * ((double)at[down + right] - (double)at[down]);
    return up + fy * (low - up);
}

/* Vertices near an edge are drawn onto it. */
static void pull_to_edge(const shaping *s, pv_cell at, pv_equations *e)
{
    const pv_work *w = s->w;
    double x = (double)at.x / PV_GRID, y = (double)at.y / PV_GRID, near = 0.4 * pv_wanted_side(w, x, y);
    double away = away_at(w, x, y), gx = away_at(w, x + 1, y) - away_at(w, x - 1, y);
    double gy = away_at(w, x, y + 1) - away_at(w, x, y - 1), steep = sqrt(gx * gx + gy * gy);
    if (away >= near || steep < 0.5)
        return;
    pv_add_equation(e, s->to_edge, gx / steep, gy / steep, away * PV_GRID);
}

/* The rectangle that the corners of a face come nearest to, made more like the size that is wanted. */
typedef struct rectangle {
    double x, y, c, s, a, b; /* centre, direction, half sides; grid units */
} rectangle;

static int corners_of(const pv_tess *tess, int32_t face, pv_cell *out)
{
    int count = 0;
    for (int64_t p = tess->first[face]; p < tess->first[face + 1]; p++)
        if (pv_is_corner(tess, p)) {
            if (count == MOST_CORNERS)
                return 0;
            out[count++] = tess->at[tess->corner[p]];
        }
    return count;
}

/* Its direction is between that of the sides and the field's. */
static void turn_rectangle(const pv_work *w, const pv_cell *corner, int count, rectangle *r)
{
    double c4 = 0, s4 = 0, around = 0;
    int32_t fc, fs, px = (int32_t)(r->x / PV_GRID), py = (int32_t)(r->y / PV_GRID);
    for (int i = 0; i < count; i++) {
        pv_cell a = corner[i], b = corner[i + 1 < count ? i + 1 : 0];
        double dx = (double)b.x - a.x, dy = (double)b.y - a.y, d2 = dx * dx + dy * dy, length = sqrt(d2);
        double c = d2 > 0 ? (dx * dx - dy * dy) / d2 : 0, s = d2 > 0 ? 2 * dx * dy / d2 : 0;
        c4 += length * (c * c - s * s);
        s4 += length * 2 * c * s;
        around += length;
    }
    px = px < 0 ? 0 : px < w->width ? px : w->width - 1;
    py = py < 0 ? 0 : py < w->height ? py : w->height - 1;
    pv_turn(4 * w->guide->direction[(int64_t)py * w->width + px], &fc, &fs);
    c4 += around * fc / 65536;
    s4 += around * fs / 65536;
    for (int halving = 0; halving < 2; halving++) { /* the root of the unit vector, twice */
        double length = sqrt(c4 * c4 + s4 * s4), c = length > 0 ? c4 / length : 1;
        c4 = sqrt(fmax(0, (1 + c) / 2));
        s4 = sqrt(fmax(0, (1 - c) / 2)) * (s4 < 0 ? -1 : 1);
    }
    r->c = c4;
    r->s = s4;
}

static int rectangle_of(const pv_work *w, const pv_tess *tess, int32_t face, rectangle *r)
{
    pv_cell corner[MOST_CORNERS];
    int count = corners_of(tess, face, corner);
    if (count < 3)
        return 0;
    *r = (rectangle){ 0, 0, 1, 0, 0, 0 };
    for (int i = 0; i < count; i++) {
        r->x += (double)corner[i].x / count;
        r->y += (double)corner[i].y / count;
    }
    turn_rectangle(w, corner, count, r);
    for (int i = 0; i < count; i++) {
        double dx = corner[i].x - r->x, dy = corner[i].y - r->y;
        r->a += fabs(dx * r->c + dy * r->s) / count;
        r->b += fabs(dy * r->c - dx * r->s) / count;
    }
    double wanted = pv_wanted_side(w, r->x / PV_GRID, r->y / PV_GRID) * PV_GRID / 2, is = sqrt(r->a * r->b);
    double grow = is > 0 ? 1 + SIZE_PULL * (wanted / is - 1) : 1;
    r->a *= grow;
    r->b *= grow;
    return 1;
}

/* A corner belongs where the rectangle has one. */
static void pull_to_square(const shaping *s, const pv_tess *tess, int64_t place, pv_equations *e)
{
    rectangle r;
    pv_cell at = tess->at[tess->corner[place]];
    if (!pv_is_corner(tess, place) || !rectangle_of(s->w, tess, tess->face_of[place], &r))
        return;
    double dx = at.x - r.x, dy = at.y - r.y, u = dx * r.c + dy * r.s, v = dy * r.c - dx * r.s;
    double a = u < 0 ? -r.a : r.a, b = v < 0 ? -r.b : r.b;
    pv_add_equation(e, s->to_square, r.c, r.s, u - a);
    pv_add_equation(e, s->to_square, -r.s, r.c, v - b);
}

static void pull(const void *user, const pv_tess *tess, int32_t vertex, pv_equations *e)
{
    const shaping *s = user;
    if (s->w->guide->away)
        pull_to_edge(s, tess->at[vertex], e);
    for (int64_t k = tess->star[vertex]; k < tess->star[vertex + 1]; k++)
        pull_to_square(s, tess, tess->spoke[k], e);
}

/* First all that draws, then the lines alone, so that flat vertices end on them. */
static pave_result shape(pave_context *context, const pv_work *w, pv_tess *tess)
{
    double side = w->side * PV_GRID, least = side * (w->size ? w->size_min : 1);
    int64_t block = (int64_t)(side * BLOCK_TILES);
    pv_assign_params assign = { block, 65, 35 };
    shaping s = { w, 0.12, 0.4 };
    int32_t step = (int32_t)(side / 8), shortest = (int32_t)(least / 8);
    pv_realise_params draw = { block, 24, (int32_t)(side / 2), step, (int32_t)(least / 4), shortest, 0, 0, pull, &s };
    pv_realise_params settle = { block, 6, (int32_t)(side / 4), step, (int32_t)(least / 5), shortest, 0, 0, NULL, NULL };
    pave_result result = pv_tess_collapse(context, tess, (int64_t)(least / 5), 4, 3);
    if (!result)
        result = pv_assign_flats(context, &assign, tess, 0.2, 0.3);
    if (!result)
        result = pv_realise_flats(context, &draw, tess, 0.3, 0.6);
    return result ? result : pv_realise_flats(context, &settle, tess, 0.6, 0.8);
}

/* Tiles of all faces, before they are put one after the other. */
typedef struct cutting {
    const pv_work *w;
    const pv_tess *tess;
    int plain;
    pv_cell *corner; /* of face f from tess->first[f] on */
    int32_t *count;
} cutting;

enum { TASK = 64 };

/* Is every corner of a tile within the ring that it is made of, or on it, and the tile in order? */
static int lies_within(const pv_cell *ring, int32_t count, const pv_cell *tile, int32_t corners)
{
    if (corners < 3 || !pv_ring_valid(tile, corners))
        return 0;
    for (int32_t i = 0; i < corners; i++) {
        int inside = 0, on = 0;
        for (int32_t k = 0; k < count; k++) {
            pv_cell a = ring[k], b = ring[k + 1 < count ? k + 1 : 0], p = tile[i];
            int64_t turn = pv_cell_turn(a, b, p);
            on |= !turn && (p.x - (int64_t)a.x) * (p.x - (int64_t)b.x) <= 0 &&
                  (p.y - (int64_t)a.y) * (p.y - (int64_t)b.y) <= 0;
            if ((a.y > p.y) != (b.y > p.y) && (turn > 0) == (b.y < a.y))
                inside = !inside;
        }
        if (!inside && !on)
            return 0;
    }
    return 1;
}

/* Sides move inwards; those of a tile hardly larger than the joint may miss each other: then its corners do. */
static int32_t open_joint(pv_cell *tile, int32_t count, double way)
{
    pv_cell whole[PV_STONE_MOST];
    memcpy(whole, tile, (size_t)count * sizeof *whole);
    int32_t left = pv_stone_offset(tile, count, way);
    if (lies_within(whole, count, tile, left))
        return left;
    memcpy(tile, whole, (size_t)count * sizeof *whole);
    left = pv_stone_draw_in(tile, count, way);
    return lies_within(whole, count, tile, left) ? left : 0;
}

static int32_t cut_tile(const cutting *c, int32_t face, pv_cell *out)
{
    pv_cell ring[PV_STONE_MOST];
    uint8_t corner[PV_STONE_MOST];
    const pv_tess *tess = c->tess;
    int32_t count = pv_tess_ring(tess, face, ring, PV_STONE_MOST);
    if (count > PV_STONE_MOST)
        return 0;
    if (c->plain) {
        memcpy(out, ring, (size_t)count * sizeof *ring);
        return count;
    }
    for (int32_t i = 0; i < count; i++)
        corner[i] = (uint8_t)pv_is_corner(tess, tess->first[face] + i);
    pv_stone_cell cell = { count, ring, corner, 0 };
    int32_t kept = pv_stone_inscribe(&cell, 0.055, out);
    if (!pv_ring_contains(ring, count, out, kept)) { /* slivers are beyond its arithmetic */
        memcpy(out, ring, (size_t)count * sizeof *ring);
        kept = count;
    }
    return open_joint(out, kept, c->w->params->joint / 2 * c->w->side * PV_GRID);
}

static void cut_tiles(void *data, int32_t task, int32_t worker)
{
    const cutting *c = data;
    (void)worker;
    for (int32_t f = task * TASK; f < (task + 1) * TASK && f < c->tess->face_count; f++) {
        pv_cell tile[PV_STONE_MOST];
        c->count[f] = c->tess->label[f] < c->w->n ? cut_tile(c, f, tile) : 0;
        memcpy(c->corner + c->tess->first[f], tile, (size_t)c->count[f] * sizeof *tile);
    }
}

static void add_tile(const cutting *c, int32_t face, pave_stones *out)
{
    int64_t at = out->starts[out->count], from = c->tess->first[face];
    for (int32_t i = 0; i < c->count[face]; i++) {
        out->vertices[2 * (at + i)] = (double)c->corner[from + i].x / PV_GRID;
        out->vertices[2 * (at + i) + 1] = (double)c->corner[from + i].y / PV_GRID;
    }
    out->sites[out->count] = out->count;
    out->mosaic->served += c->tess->part[face] == 0;
    out->starts[++out->count] = at + c->count[face];
}

static pave_result isolate(pave_context *context, cutting *c, pave_stones *out)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)c->tess->face_count, corners = (size_t)c->tess->first[n];
    out->starts = pv_allocate_zeroed(context, n + 1, sizeof *out->starts, &result);
    if (!result)
        out->vertices = pv_allocate(context, corners, 2 * sizeof *out->vertices, &result);
    if (!result)
        out->sites = pv_allocate(context, n, sizeof *out->sites, &result);
    if (!result)
        c->corner = pv_allocate(context, corners, sizeof *c->corner, &result);
    if (!result)
        c->count = pv_allocate(context, n, sizeof *c->count, &result);
    if (!result)
        result = pv_parallel(context, ((int32_t)n + TASK - 1) / TASK, cut_tiles, c, 0.8, 1);
    for (int32_t f = 0; f < (int32_t)n && !result; f++)
        if (c->count[f])
            add_tile(c, f, out);
    pv_release(c->corner);
    pv_release(c->count);
    return result;
}

pave_result pv_quads_cut(pave_context *context, const pv_work *w, int plain, pave_stones *out)
{
    pv_tess tess = { 0 };
    pave_result result = trace(context, w, &tess);
    if (!result && !plain)
        result = shape(context, w, &tess);
    cutting c = { w, &tess, plain, NULL, NULL };
    if (!result)
        result = isolate(context, &c, out);
    pv_tess_free(&tess);
    return result;
}
