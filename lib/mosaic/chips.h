/* Small pieces that fill what tiles leave free. */
#pragma once

#include "util/polygon.h"

enum { PV_CHIP_MOST = 24 }; /* vertices of a face that is looked at */

int pv_chip_is_convex(const pv_cell *ring, int32_t count);

/* The widest triangle of a ring's vertices, no less wide than `least` grid units, that lies in the ring and beside the
 * convex tile in it. Returns 3, or 0 if there is none. */
int32_t pv_chip_find(const pv_cell *ring, int32_t count, const pv_cell *tile, int32_t corners, double least,
                     pv_cell *chip);
