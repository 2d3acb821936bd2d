/* Which pixels' centres a polygon holds: where its sides cross a row, by the even-odd rule. */
#include "mosaic/cover.h"

#include <math.h>

static int32_t cut(double v, int32_t most)
{
    return v > 0 ? v < most ? (int32_t)v : most : 0;
}

pv_cover pv_cover_of(const double *xy, int64_t corners, int32_t width, int32_t height)
{
    double least = INFINITY, most = -INFINITY;
    for (int64_t i = 0; i < corners; i++) {
        least = fmin(least, xy[2 * i + 1]);
        most = fmax(most, xy[2 * i + 1]);
    }
    return (pv_cover){ xy, corners, width, height, cut(floor(least), height), cut(ceil(most), height) };
}

int32_t pv_cover_row(const pv_cover *c, int32_t y, int32_t from[PV_COVER_RUNS], int32_t to[PV_COVER_RUNS])
{
    double at[2 * PV_COVER_RUNS], v = y + 0.5;
    int32_t count = 0;
    for (int64_t i = 0; i < c->corners && count < 2 * PV_COVER_RUNS; i++) {
        const double *a = c->xy + 2 * i, *b = c->xy + 2 * ((i + 1) % c->corners);
        if ((a[1] > v) == (b[1] > v))
            continue;
        double x = a[0] + (v - a[1]) * (b[0] - a[0]) / (b[1] - a[1]);
        int32_t k = count++;
        for (; k > 0 && at[k - 1] > x; k--)
            at[k] = at[k - 1];
        at[k] = x;
    }
    for (int32_t k = 0; k + 1 < count; k += 2) {
        from[k / 2] = cut(ceil(at[k] - 0.5), c->width);
        to[k / 2] = cut(ceil(at[k + 1] - 0.5), c->width);
    }
    return count / 2;
}
