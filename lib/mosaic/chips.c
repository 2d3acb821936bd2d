/* Chips (section 8.1): in a face whose tile leaves much of a corner free, a triangle of the face's own vertices that
 * lies beside the tile. All of it is exact, as tiles are, so that chips cannot overlap them either. */
#include "mosaic/chips.h"

#include "stones/inscribe.h"

#include <math.h>
#include <string.h>

/* Does a side of the convex ring have the whole triangle on its other side, or on its line? */
static int keeps_off(const pv_cell *convex, int32_t corners, const pv_cell *other, int32_t others)
{
    for (int32_t k = 0; k < corners; k++) {
        int beyond = 1;
        for (int32_t i = 0; i < others && beyond; i++)
            beyond = pv_cell_turn(convex[k], convex[(k + 1) % corners], other[i]) <= 0;
        if (beyond)
            return 1;
    }
    return 0;
}

int pv_chip_is_convex(const pv_cell *ring, int32_t count)
{
    for (int32_t i = 0; i < count; i++)
        if (pv_cell_turn(ring[i], ring[(i + 1) % count], ring[(i + 2) % count]) <= 0)
            return 0;
    return count >= 3;
}

/* The least height of a triangle, grid units. */
static double width_of(const pv_cell *t)
{
    double longest = 0;
    for (int k = 0; k < 3; k++) {
        double dx = (double)t[(k + 1) % 3].x - t[k].x, dy = (double)t[(k + 1) % 3].y - t[k].y;
        longest = fmax(longest, sqrt(dx * dx + dy * dy));
    }
    return longest > 0 ? (double)pv_ring_area(t, 3) / longest : 0;
}

static int fits(const pv_cell *ring, int32_t count, const pv_cell *tile, int32_t corners, const pv_cell *chip)
{
    return (keeps_off(chip, 3, tile, corners) || keeps_off(tile, corners, chip, 3)) &&
           pv_ring_contains(ring, count, chip, 3);
}

int32_t pv_chip_find(const pv_cell *ring, int32_t count, const pv_cell *tile, int32_t corners, double least,
                     pv_cell *chip)
{
    double best = least;
    int found = 0;
    if (count > PV_CHIP_MOST || !pv_chip_is_convex(tile, corners))
        return 0;
    for (int32_t a = 0; a < count; a++)
        for (int32_t b = a + 1; b < count; b++)
            for (int32_t c = b + 1; c < count; c++) {
                pv_cell t[3] = { ring[a], ring[b], ring[c] };
                if (pv_ring_area(t, 3) <= 0 || width_of(t) <= best || !fits(ring, count, tile, corners, t))
                    continue;
                best = width_of(t);
                memcpy(chip, t, sizeof t);
                found = 3;
            }
    return found;
}
