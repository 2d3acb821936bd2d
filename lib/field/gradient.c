/* Sobel gradient of the distance (Eq. 2). The text's g_y has y going up; here rows, and y, go down. */
#include "field/field.h"

#include <math.h>

/* A row and those above and below it; beyond a field that does not wrap its border is repeated. */
typedef struct three_rows {
    const float *up, *row, *down;
} three_rows;

static three_rows rows_at(const pave_field *field, int32_t y)
{
    int32_t bottom = field->height - 1, up = y ? y - 1 : field->wraps ? bottom : 0;
    int32_t down = y < bottom ? y + 1 : field->wraps ? 0 : bottom;
    int64_t width = field->width;
    return (three_rows){ field->distance + up * width, field->distance + y * width, field->distance + down * width };
}

static inline void sobel(three_rows r, int32_t left, int32_t x, int32_t right, float *gx, float *gy)
{
    float nw = r.up[left], n = r.up[x], ne = r.up[right];
    float w = r.row[left], e = r.row[right];
    float sw = r.down[left], s = r.down[x], se = r.down[right];
    float across = ((ne - nw) + 2 * (e - w) + (se - sw)) / 8;
    float down = ((sw - nw) + 2 * (s - n) + (se - ne)) / 8;
    int known = isfinite(across) & isfinite(down);
    *gx = known ? across : 0;
    *gy = known ? down : 0;
}

void pv_gradient(const pave_field *field, int32_t x, int32_t y, float *gx, float *gy)
{
    int32_t last = field->width - 1, left = x ? x - 1 : field->wraps ? last : 0;
    sobel(rows_at(field, y), left, x, x < last ? x + 1 : field->wraps ? 0 : last, gx, gy);
}

static void gradient_row(const pave_field *field, int32_t y, float *restrict gx, float *restrict gy)
{
    three_rows rows = rows_at(field, y);
    int32_t last = field->width - 1;
    for (int32_t x = 1; x < last; x++)
        sobel(rows, x - 1, x, x + 1, &gx[x], &gy[x]);
    pv_gradient(field, 0, y, &gx[0], &gy[0]);
    pv_gradient(field, last, y, &gx[last], &gy[last]);
}

void pave_field_gradient(const pave_field *field, float *x, float *y)
{
    for (int32_t row = 0; row < field->height; row++, x += field->width, y += field->width)
        gradient_row(field, row, x, y);
}
