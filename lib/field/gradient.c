/* Sobel gradient of the distance (Eq. 2). The text's g_y has y going up; here rows, and y, go down. */
#include "field/field.h"

#include <math.h>

static float at(const pave_field *field, int32_t x, int32_t y)
{
    x = x < 0 ? 0 : x < field->width ? x : field->width - 1;
    y = y < 0 ? 0 : y < field->height ? y : field->height - 1;
    return field->distance[(int64_t)y * field->width + x];
}

void pv_gradient(const pave_field *field, int32_t x, int32_t y, float *gx, float *gy)
{
    float nw = at(field, x - 1, y - 1), n = at(field, x, y - 1), ne = at(field, x + 1, y - 1);
    float w = at(field, x - 1, y), e = at(field, x + 1, y);
    float sw = at(field, x - 1, y + 1), s = at(field, x, y + 1), se = at(field, x + 1, y + 1);
    *gx = ((ne - nw) + 2 * (e - w) + (se - sw)) / 8;
    *gy = ((sw - nw) + 2 * (s - n) + (se - ne)) / 8;
    if (!isfinite(*gx) || !isfinite(*gy))
        *gx = *gy = 0;
}

void pave_field_gradient(const pave_field *field, float *x, float *y)
{
    for (int32_t row = 0; row < field->height; row++)
        for (int32_t column = 0; column < field->width; column++)
            pv_gradient(field, column, row, x++, y++);
}
