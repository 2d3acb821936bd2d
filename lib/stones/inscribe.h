/* A stone within its cell, and the joint around it. */
#pragma once

#include "util/polygon.h"

enum { PV_STONE_MOST = 256, PV_STONE_SIDES = 12, PV_STONE_PARTS = 8 };

/* A cell: a simple ring, counter-clockwise, with its corners marked. */
typedef struct pv_stone_cell {
    int32_t count;
    const pv_cell *ring;
    const uint8_t *corner;
    int dents; /* may a stone have corners bent inwards? */
} pv_stone_cell;

/* The convex polygon of four corners that fits into the cell and leaves little of it, of more if it leaves more than
 * `most_loss` of the area; lies in the cell exactly, and touches sides of the cell only where whole sides are common.
 * If none does, the cell itself, less corners that hardly count. Returns the number of corners in `out` (of
 * PV_STONE_MOST), 0 if the cell has too many. */
int32_t pv_stone_inscribe(const pv_stone_cell *cell, double most_loss, pv_cell *out);

/* The same, but 0 if it would be the cell itself. */
int32_t pv_stone_fit(const pv_stone_cell *cell, double most_loss, pv_cell *out);

/* A stone of more corners, some perhaps bent inwards, that leaves no more than twice `most_loss` of the cell. 0: none
 * does. */
int32_t pv_stone_grow(const pv_stone_cell *cell, double most_loss, pv_cell *out);

/* Parts a cell with a dent in two simple rings along a line from the dent, so that stones in both leave the least of
 * it. Returns 0 if nothing is gained; else the two rings' sizes are in counts. Rings have room for PV_STONE_MOST. */
int pv_stone_part(const pv_stone_cell *cell, double most_loss, pv_cell *first, pv_cell *second, int32_t counts[2]);

/* Marks the corners of a ring by itself: convex by 30 degrees or more. */
void pv_stone_mark(const pv_cell *ring, int32_t count, uint8_t *corner);

/* Cuts a convex stone across where it is longer than `aspect` times its width, 0: never, in equal parts as many as that
 * takes, or as `room` corners and PV_STONE_PARTS let be. The parts lie in what the ring was, one after the other, as
 * many as are returned. */
int32_t pv_stone_divide(pv_cell *ring, int32_t count, double aspect, int32_t room, int32_t *counts);

/* Does a simple ring, convex or with few dents, lie in another? Exact; 0 also for dents that it cannot part. */
int pv_ring_contains(const pv_cell *ring, int32_t count, const pv_cell *inner, int32_t corners);

/* Moves the sides of a stone inwards by `way` grid units. A stone that has not so much room keeps all its corners with
 * three quarters or half of it; after that it may lose some. Returns the number of corners left, 0: nothing remains.
 * The ring lies within what it was. */
int32_t pv_stone_offset(pv_cell *ring, int32_t count, double way);

/* The same as in the text, where every corner goes `way` towards the centroid; a convex stone stays convex. */
int32_t pv_stone_draw_in(pv_cell *ring, int32_t count, double way);
