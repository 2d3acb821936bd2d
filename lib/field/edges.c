/* First distances: pixels that touch a pixel of another colour (III.A). */
#include "field/field.h"

enum { SIDE = PV_FIELD_ONE / 2, CORNER = 46341 /* sqrt(2)/2 */ };

/* The pixel at x of `row` among its eight neighbours. */
static inline int32_t first_distance(const uint8_t *up, const uint8_t *row, const uint8_t *down, int32_t left,
                                     int32_t x, int32_t right)
{
    uint8_t here = row[x];
    uint8_t side = (row[left] ^ here) | (row[right] ^ here) | (up[x] ^ here) | (down[x] ^ here);
    uint8_t corner = (up[left] ^ here) | (up[right] ^ here) | (down[left] ^ here) | (down[right] ^ here);
    return side ? SIDE : corner ? CORNER : PV_FIELD_FAR;
}

/* Beyond a drawing that does not wrap its border is repeated: there a pixel meets only colours that it meets inside,
 * too. */
void pv_edge_row(const pv_drawing *drawing, int32_t y, int32_t *distance)
{
    int32_t last = drawing->width - 1, bottom = drawing->height - 1, wraps = drawing->wraps;
    const uint8_t *row = drawing->pixels + (int64_t)y * drawing->width;
    const uint8_t *up = y ? row - drawing->width : wraps ? row + (int64_t)bottom * drawing->width : row;
    const uint8_t *down = y < bottom ? row + drawing->width : wraps ? drawing->pixels : row;
    for (int32_t x = 1; x < last; x++)
        distance[x] = first_distance(up, row, down, x - 1, x, x + 1);
    distance[0] = first_distance(up, row, down, wraps ? last : 0, 0, last ? 1 : 0);
    distance[last] = first_distance(up, row, down, last ? last - 1 : 0, last, wraps ? 0 : last);
}
