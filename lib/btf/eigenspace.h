/* Eigenspaces of several materials merged into one (den Brok 2014, 4.1; Hall, Marshall and Martin 2000). */
#pragma once

#include "btf/algebra.h"
#include "btf/symmetry.h"

/* Left factors of materials, times their singular values, side by side: [row][stride]. Of these `width` count: those
 * before a gap and those after it. Rows are [y of a patch][x][view][light]. */
typedef struct pv_side {
    int64_t rows;
    int32_t patch, lights; /* of a row's place */
    int32_t width, stride, gap, gap_width;
    const float *values;
} pv_side;

/* The left singular vectors of all of it together with its mirrored and turned copies, as if each were a material of
 * its own with an equal share: at most `components`, and none below 1e-5 of the greatest. The copies are never made:
 * the covariance falls into as many blocks as the symmetry has elements, each with functions of one parity.
 * `left` is [row][*components], `singular` is of one copy; both are the caller's to free. */
pave_result pv_eigenspace(pave_context *context, const pv_algebra *algebra, const pv_side *side,
                          const pv_symmetry *symmetry, int32_t *components, float **left, float **singular);
