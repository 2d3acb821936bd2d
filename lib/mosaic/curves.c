/* Curves as the artist draws them. */
#include "mosaic/mosaic.h"

#include <math.h>
#include <string.h>

pave_result pave_curves_create(pave_context *context, int32_t count, const int64_t *starts, const double *points,
                               pave_curves **out)
{
    if (out)
        *out = NULL;
    if (!context || !out || count < 0 || (count && (!starts || !points)))
        return PAVE_ERR_ARGUMENT;
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < count; i++)
        if (starts[i] < 0 || starts[i] > starts[i + 1])
            return pv_fail(context, PAVE_ERR_ARGUMENT, "the starts of curves must ascend");
    int64_t total = count ? starts[count] : 0;
    for (int64_t i = 0; i < 2 * total; i++)
        if (!isfinite(points[i]))
            return pv_fail(context, PAVE_ERR_ARGUMENT, "a point of a curve is not a number");
    pave_curves *curves = pv_allocate_zeroed(context, 1, sizeof *curves, &result);
    if (!curves)
        return result;
    curves->count = count;
    curves->starts = pv_allocate_zeroed(context, (size_t)count + 1, sizeof *curves->starts, &result);
    if (!result)
        curves->points = pv_allocate(context, (size_t)total, 2 * sizeof *curves->points, &result);
    if (result) {
        pave_curves_free(&curves);
        return result;
    }
    if (count)
        memcpy(curves->starts, starts, ((size_t)count + 1) * sizeof *starts);
    if (total)
        memcpy(curves->points, points, 2 * (size_t)total * sizeof *points);
    *out = curves;
    return PAVE_OK;
}

void pave_curves_free(pave_curves **curves)
{
    if (!curves || !*curves)
        return;
    pv_release((*curves)->starts);
    pv_release((*curves)->points);
    pv_release(*curves);
    *curves = NULL;
}

int32_t pave_curves_count(const pave_curves *curves) { return curves->count; }
const int64_t *pave_curves_starts(const pave_curves *curves) { return curves->starts; }
const double *pave_curves_points(const pave_curves *curves) { return curves->points; }
