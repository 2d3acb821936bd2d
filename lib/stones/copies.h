/* Copies of the stones of a plane that repeats: those that a window shows, so that its picture tiles. */
#pragma once

#include "stones/stones.h"

/* Periods that a stone is to be moved by, first to last. */
typedef struct pv_copies {
    int32_t first_x, last_x, first_y, last_y;
} pv_copies;

/* Which copies of a stone (corners in 1/1000 px) lie at least in part in the window; by (0, 0) is the stone itself, and
 * the only one where the plane does not repeat. */
pv_copies pv_copies_seen(const pave_stones *head, const int32_t *xy, int32_t corners);

/* All copies that are seen as stones of their own: starts, vertices and colours; released by pv_copies_free. */
pave_result pv_copies_make(pave_context *context, const pave_stones *stones, pave_stones *out);
void pv_copies_free(pave_stones *copies);
