/* The edge of a drawing between two of its pixels, from the greys that it was made from: where these cross the
 * threshold on the way from one centre to the other. */
#include "stones/contour.h"

#include "image/image.h"

enum { PIXELS = 4, FINE = 1024, LEAST = 8 };

/* Pixels across an edge, which is between the inner ones; -1: none. Rows of them go from left to right, or down. */
static void read_across(const pave_image *drawing, int32_t x, int32_t y, int upright, int32_t level[PIXELS])
{
    for (int i = 0; i < PIXELS; i++) {
        int32_t px = x + (upright ? i - PIXELS / 2 : 0), py = y + (upright ? 0 : i - PIXELS / 2);
        int inside = px >= 0 && py >= 0 && px < drawing->width && py < drawing->height;
        level[i] = inside ? drawing->levels[(int64_t)py * drawing->width + px] : -1;
    }
}

static int is_between(int32_t v, int32_t a, int32_t b)
{
    int32_t low = a < b ? a : b, high = a < b ? b : a, least = (high - low) / LEAST + 1;
    return low >= 0 && v >= low + least && v <= high - least;
}

/* Does the edge take more than one step, as that of a smooth drawing does? Flat greys beside an edge are no step. */
static int is_ramp(const int32_t level[PIXELS])
{
    return is_between(level[1], level[0], level[2]) || is_between(level[2], level[1], level[3]);
}

int pv_isoline(const pave_image *drawing, int32_t x, int32_t y, int upright, double *way)
{
    int32_t across[PIXELS], beside[PIXELS];
    int smooth = 0;
    x -= drawing->place.x;
    y -= drawing->place.y;
    read_across(drawing, x, y, upright, across);
    int32_t a = across[1], b = across[2], cut = drawing->cut;
    if (a < 0 || b < 0 || (256 * a > cut) == (256 * b > cut))
        return 0;
    for (int32_t i = -PV_SMOOTH_REACH; i <= PV_SMOOTH_REACH && !smooth; i++) {
        read_across(drawing, x + (upright ? 0 : i), y + (upright ? i : 0), upright, beside);
        smooth = is_ramp(beside);
    }
    int32_t from = a < b ? cut - 256 * a : 256 * a - cut, all = 256 * (a < b ? b - a : a - b);
    *way = (double)(FINE * from / all - FINE / 2) / FINE;
    return smooth;
}
