/* Faces of the mesh into tiles: in each a quadrilateral if that loses little, less the joint, and a chip where that
 * leaves a hole. All that is cut lies in its face, exactly, so that nothing overlaps. */
#include "mosaic/chips.h"
#include "mosaic/mosaic.h"

#include "base/parallel.h"
#include "stones/assign.h"
#include "stones/inscribe.h"

#include <string.h>

/* Tiles of all faces, before they are put one after the other. */
typedef struct cutting {
    const pv_work *w;
    const pv_tess *tess;
    int plain;
    pv_cell *corner; /* of face f from place_of(f) on */
    int32_t *count;
    pv_cell (*chip)[3]; /* of face f; where there is none all its corners are one. NULL: none at all */
} cutting;

/* A tile has at most one corner more than its face: a triangle's tip may be cut. */
static int64_t place_of(const cutting *c, int32_t face)
{
    return c->tess->first[face] + face;
}

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

static double half_joint(const pv_work *w)
{
    return w->params->joint / 2 * w->side * PV_GRID;
}

#define CHIP_WIDTH 0.1    /* least, sides; besides the joint */
#define MOST_LOSS 0.055   /* of a face's area, for a tile of four corners, */
#define MOST_CHIPPED 0.3  /* and where chips fill what is lost */

static void find_chip(const cutting *c, int32_t face, const pv_cell *ring, int32_t count, const pv_cell *tile,
                      int32_t corners)
{
    pv_cell chip[PV_STONE_MOST];
    double way = half_joint(c->w);
    int32_t found = pv_chip_find(ring, count, tile, corners, CHIP_WIDTH * c->w->side * PV_GRID + 3 * way, chip);
    memset(c->chip[face], 0, sizeof c->chip[face]);
    if (found && open_joint(chip, found, way) == 3)
        memcpy(c->chip[face], chip, sizeof c->chip[face]);
}

/* The tile of a face before the joint is opened, with four corners if no more than a share of the area is lost so. */
static int32_t inscribe(const pv_stone_cell *cell, double most_loss, pv_cell *out)
{
    int32_t kept = pv_stone_inscribe(cell, most_loss, out);
    if (pv_ring_contains(cell->ring, cell->count, out, kept))
        return kept;
    memcpy(out, cell->ring, (size_t)cell->count * sizeof *out); /* slivers are beyond its arithmetic */
    return cell->count;
}

enum { MOST_TRIED = 12 };

/* Of all quadrilaterals of the ring's own vertices the one of which the joint leaves most, and what it was before: for
 * faces with spikes. */
static int32_t cut_largest(const cutting *c, const pv_cell *ring, int32_t count, pv_cell *whole, pv_cell *out)
{
    int64_t best = 0;
    for (int32_t k = 0; k < 1 << count && count <= MOST_TRIED; k++) {
        pv_cell tile[PV_STONE_MOST];
        int32_t corners = 0;
        if (__builtin_popcount((uint32_t)k) != 4)
            continue;
        for (int32_t i = 0; i < count; i++)
            if (k >> i & 1)
                tile[corners++] = ring[i];
        if (!pv_chip_is_convex(tile, 4) || !pv_ring_contains(ring, count, tile, 4) ||
            open_joint(tile, 4, half_joint(c->w)) != 4 || pv_ring_area(tile, 4) <= best)
            continue;
        best = pv_ring_area(tile, 4);
        memcpy(out, tile, 4 * sizeof *out);
        for (int32_t i = 0, n = 0; i < count; i++)
            if (k >> i & 1)
                whole[n++] = ring[i];
    }
    return best ? 4 : 0;
}

/* Dented tiles may have no room for the joint: then rather less of them, and a chip. */
static int32_t cut_tile(const cutting *c, int32_t face, pv_cell *out)
{
    static const double losses[] = { MOST_LOSS, MOST_CHIPPED };
    pv_cell ring[PV_STONE_MOST];
    uint8_t corner[PV_STONE_MOST];
    const pv_tess *tess = c->tess;
    int32_t count = pv_tess_ring(tess, face, ring, PV_STONE_MOST), left = 0;
    if (count > PV_STONE_MOST)
        return 0;
    if (c->plain) {
        memcpy(out, ring, (size_t)count * sizeof *ring);
        return count;
    }
    for (int32_t i = 0; i < count; i++)
        corner[i] = (uint8_t)pv_is_corner(tess, tess->first[face] + i);
    pv_stone_cell cell = { count, ring, corner, 0 };
    for (int k = c->w->params->chips; k < 2 && !left; k++) {
        int32_t kept = inscribe(&cell, losses[k], out);
        if (k)
            find_chip(c, face, ring, count, out, kept);
        left = open_joint(out, kept, half_joint(c->w));
    }
    if (left)
        return left;
    pv_cell whole[4];
    left = cut_largest(c, ring, count, whole, out);
    if (left)
        find_chip(c, face, ring, count, whole, 4);
    return left;
}

static void cut_tiles(void *data, int32_t task, int32_t worker)
{
    const cutting *c = data;
    (void)worker;
    for (int32_t f = task * TASK; f < (task + 1) * TASK && f < c->tess->face_count; f++) {
        pv_cell tile[PV_STONE_MOST];
        c->count[f] = pv_is_tile(c->w, c->tess->label[f]) ? cut_tile(c, f, tile) : 0;
        memcpy(c->corner + place_of(c, f), tile, (size_t)c->count[f] * sizeof *tile);
    }
}

static void add_ring(const pv_cell *ring, int32_t count, pave_stones *out)
{
    int64_t at = out->starts[out->count];
    for (int32_t i = 0; i < count; i++) {
        out->vertices[2 * (at + i)] = (double)ring[i].x / PV_GRID;
        out->vertices[2 * (at + i) + 1] = (double)ring[i].y / PV_GRID;
    }
    out->sites[out->count] = out->count;
    out->starts[++out->count] = at + count;
}

static void add_tiles(const cutting *c, pave_stones *out)
{
    for (int32_t f = 0; f < c->tess->face_count; f++) {
        if (!c->count[f])
            continue;
        add_ring(c->corner + place_of(c, f), c->count[f], out);
        out->mosaic->served += c->tess->part[f] == 0;
    }
}

static void add_chips(const cutting *c, pave_stones *out)
{
    for (int32_t f = 0; f < c->tess->face_count && c->chip; f++) {
        if (pv_ring_area(c->chip[f], 3) <= 0)
            continue;
        add_ring(c->chip[f], 3, out);
        out->mosaic->chips++;
    }
}

pave_result pv_faces_cut(pave_context *context, const pv_work *w, const pv_tess *tess, int plain, pave_stones *out)
{
    cutting cut = { w, tess, plain, NULL, NULL, NULL }, *c = &cut;
    pave_result result = PAVE_OK;
    int chips = !c->plain;
    size_t n = (size_t)c->tess->face_count, corners = (size_t)place_of(c, c->tess->face_count);
    out->starts = pv_allocate_zeroed(context, (chips ? 2 : 1) * n + 1, sizeof *out->starts, &result);
    if (!result)
        out->vertices = pv_allocate(context, corners + (chips ? 3 * n : 0), 2 * sizeof *out->vertices, &result);
    if (!result)
        out->sites = pv_allocate(context, (chips ? 2 : 1) * n, sizeof *out->sites, &result);
    if (!result && chips)
        c->chip = pv_allocate_zeroed(context, n, sizeof *c->chip, &result);
    if (!result)
        c->corner = pv_allocate(context, corners, sizeof *c->corner, &result);
    if (!result)
        c->count = pv_allocate(context, n, sizeof *c->count, &result);
    if (!result)
        result = pv_parallel(context, ((int32_t)n + TASK - 1) / TASK, cut_tiles, c, 0.8, 1);
    if (!result) {
        add_tiles(c, out);
        add_chips(c, out);
    }
    pv_release(c->chip);
    pv_release(c->corner);
    pv_release(c->count);
    return result;
}
