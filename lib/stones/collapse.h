/* Short sides taken out. */
#pragma once

#include "stones/tess.h"

/* Sides between two junctions of three faces each that are shorter than `least` grid units become one junction of four
 * faces, in `rounds` rounds; in each round those that are the shortest around them. Faces keep `corners` vertices at
 * least and stay simple; a vertex of the contour or border stays where it is. */
pave_result pv_tess_collapse(pave_context *context, pv_tess *tess, int64_t least, int32_t corners, int32_t rounds);
