/* Where polygons of the integer grid overlap: exactly whether, and by how much. Coordinates lie within a range of
 * 1.5 * 2^30, so that products fit into 64 bits. */
#pragma once

#include "util/polygon.h"

/* No corner turns right. The ring is counter-clockwise and valid. */
int pv_ring_convex(const pv_cell *ring, int32_t count);

/* Have two convex rings inner points in common? Exact: two that only touch have not. */
int pv_convex_meet(const pv_cell *a, int32_t a_count, const pv_cell *b, int32_t b_count);

/* The area that two convex rings have in common, in squares of the grid. `work` has room for 4 * (a_count + b_count)
 * numbers. */
double pv_convex_common(const pv_cell *a, int32_t a_count, const pv_cell *b, int32_t b_count, double *work);

/* Cuts a valid ring into at most count - 2 triangles, three corners each, written to `triangles`; returns their number.
 * `ring` is used up. */
int32_t pv_ring_triangles(pv_cell *ring, int32_t count, pv_cell *triangles);
