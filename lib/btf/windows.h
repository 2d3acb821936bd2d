/* Which window of one field of texels is nearest to each window of another: exactly. */
#pragma once

#include "btf/enlarge.h"

/* Windows of side x side texels whose corners lie `step` apart, and along the far borders. */
typedef struct pv_windows {
    int32_t side, step, across, down;
} pv_windows;

pv_windows pv_windows_of(const pv_texels *t, int32_t side, int32_t step);

/* The corner of the i-th of them along one axis of `length` texels. */
static inline int32_t pv_window_corner(const pv_windows *w, int32_t i, int32_t length)
{
    return i * w->step < length - w->side ? i * w->step : length - w->side;
}

/* `nearest`, [window of `whole`], gets the number of the window of `sample`, of all with step 1, that differs least,
 * the lower of equals. Bounds from principal components leave few to be looked at in full; none is given up on
 * chance. */
pave_result pv_windows_match(pave_context *context, const pv_algebra *algebra, const pv_texels *sample,
                             const pv_texels *whole, const pv_windows *windows, int32_t *nearest, double from,
                             double to);
