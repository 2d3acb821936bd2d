/* Quasi-Euclidean 3x3 chamfer distance transform (III.A). Sums are integers, so a distance depends on nothing
 * but the edges around it: not on the order of passes, nor on what lies beyond. */
#include "field/field.h"

static uint32_t least(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* What a row inherits from the row beside it, straight and diagonally. */
static void from_row(uint32_t *row, const uint32_t *beside, int32_t width, pv_steps steps)
{
    for (int32_t x = 0; x < width; x++) {
        uint32_t d = least(row[x], beside[x] + steps.straight);
        if (x > 0)
            d = least(d, beside[x - 1] + steps.diagonal);
        if (x + 1 < width)
            d = least(d, beside[x + 1] + steps.diagonal);
        row[x] = d;
    }
}

static void along_row(uint32_t *row, int32_t width, uint32_t straight)
{
    for (int32_t x = 1; x < width; x++)
        row[x] = least(row[x], row[x - 1] + straight);
    for (int32_t x = width - 2; x >= 0; x--)
        row[x] = least(row[x], row[x + 1] + straight);
    for (int32_t x = 0; x < width; x++)
        row[x] = least(row[x], PV_FIELD_FAR);
}

pave_result pv_chamfer(pave_context *context, int32_t width, int32_t height, pv_steps steps, uint32_t *distance)
{
    pave_result result = PAVE_OK;
    for (int32_t y = 0; y < height && !result; y++) {
        uint32_t *row = distance + (int64_t)y * width;
        if (y)
            from_row(row, row - width, width, steps);
        along_row(row, width, steps.straight);
        if (y % 64 == 0)
            result = pv_progress(context, 0.3 + 0.3 * y / height);
    }
    for (int32_t y = height - 2; y >= 0 && !result; y--) {
        uint32_t *row = distance + (int64_t)y * width;
        from_row(row, row + width, width, steps);
        along_row(row, width, steps.straight);
        if (y % 64 == 0)
            result = pv_progress(context, 0.9 - 0.3 * y / height);
    }
    return result;
}
