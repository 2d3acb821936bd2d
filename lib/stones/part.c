/* A cell with a dent in two: by the line from the dent that leaves the best stones. */
#include "stones/inscribe.h"

#include <math.h>
#include <string.h>

enum { MOST_RING = 40 };

void pv_stone_mark(const pv_cell *ring, int32_t count, uint8_t *corner)
{
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[(i + count - 1) % count], b = ring[i], c = ring[(i + 1) % count];
        corner[i] = pv_corner_width(a.x, a.y, b.x, b.y, c.x, c.y) < 0.8660254;
    }
}

/* The corner that is bent inwards most; -1: none is by more than 20 degrees. */
static int32_t deepest_dent(const pv_stone_cell *cell)
{
    double most = 1.06;
    int32_t at = -1;
    for (int32_t i = 0; i < cell->count; i++) {
        pv_cell a = cell->ring[(i + cell->count - 1) % cell->count], b = cell->ring[i];
        pv_cell c = cell->ring[(i + 1) % cell->count];
        double width = pv_corner_width(a.x, a.y, b.x, b.y, c.x, c.y);
        if (width > most)
            most = width, at = i;
    }
    return at;
}

/* From corner i to corner j, and the point between if it is not one of them. */
static int32_t ring_between(const pv_stone_cell *cell, int32_t i, int32_t j, const pv_cell *point, pv_cell *out)
{
    int32_t n = 0;
    for (int32_t k = i;; k = (k + 1) % cell->count) {
        out[n++] = cell->ring[k];
        if (k == j)
            break;
    }
    if (point)
        out[n++] = *point;
    return n;
}

/* Twice the area of the stone in a ring; 0 if it is no simple ring, or has no good stone. */
static int64_t worth(const pv_cell *ring, int32_t count, double most_loss)
{
    pv_cell out[PV_STONE_MOST];
    uint8_t corner[PV_STONE_MOST];
    if (!pv_ring_valid(ring, count))
        return 0;
    pv_stone_mark(ring, count, corner);
    pv_stone_cell cell = { count, ring, corner, 0 };
    int32_t found = pv_stone_fit(&cell, most_loss, out);
    return found ? pv_ring_area(out, found) : 0;
}

/* A point a unit or so inside the middle of a side. */
static pv_cell middle_of(pv_cell a, pv_cell b)
{
    double dx = (double)b.x - a.x, dy = (double)b.y - a.y, length = sqrt(dx * dx + dy * dy) + 1e-9;
    return (pv_cell){ (int32_t)floor((a.x + (double)b.x) / 2 + 1.75 * dy / length + 0.5),
                      (int32_t)floor((a.y + (double)b.y) / 2 - 1.75 * dx / length + 0.5) };
}

int pv_stone_part(const pv_stone_cell *cell, double most_loss, pv_cell *first, pv_cell *second, int32_t counts[2])
{
    pv_cell a[MOST_RING + 2], b[MOST_RING + 2];
    int32_t n = cell->count, dent = n <= MOST_RING ? deepest_dent(cell) : -1;
    int64_t best = 0;
    for (int32_t k = 2; dent >= 0 && k < 2 * n - 2; k++) {
        int32_t j = (dent + k / 2) % n, next = (j + 1) % n;
        pv_cell p = middle_of(cell->ring[j], cell->ring[next]);
        if (!(k & 1) && k / 2 < 2)
            continue;
        int32_t na = ring_between(cell, dent, j, k & 1 ? &p : NULL, a);
        int32_t nb = ring_between(cell, k & 1 ? next : j, dent, k & 1 ? &p : NULL, b);
        if (na < 3 || nb < 3)
            continue;
        int64_t wa = worth(a, na, most_loss), wb = wa ? worth(b, nb, most_loss) : 0;
        if (!wa || !wb || wa + wb <= best || 6 * wa < wb || 6 * wb < wa)
            continue;
        best = wa + wb;
        counts[0] = na, counts[1] = nb;
        memcpy(first, a, (size_t)na * sizeof *a);
        memcpy(second, b, (size_t)nb * sizeof *b);
    }
    return best > 0;
}
