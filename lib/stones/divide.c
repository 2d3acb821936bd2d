/* Stones that are too long, cut across. */
#include "stones/inscribe.h"

#include <math.h>
#include <string.h>

/* Along the longest side, and across it: a direction of length 1. */
static void longest_way(const pv_cell *ring, int32_t count, double *ux, double *uy)
{
    double most = 0;
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[i], b = ring[(i + 1) % count];
        double dx = (double)b.x - a.x, dy = (double)b.y - a.y, length = sqrt(dx * dx + dy * dy);
        if (length > most)
            most = length, *ux = dx / length, *uy = dy / length;
    }
}

static void extent(const pv_cell *ring, int32_t count, double x, double y, double *low, double *high)
{
    *low = 1e300, *high = -1e300;
    for (int32_t i = 0; i < count; i++) {
        double at = x * ring[i].x + y * ring[i].y;
        *low = at < *low ? at : *low;
        *high = at > *high ? at : *high;
    }
}

/* Where the line x ux + y uy = at crosses a side, a unit or so inside of it. */
static pv_cell crossing(pv_cell a, pv_cell b, double da, double db)
{
    double t = da / (da - db), dx = (double)b.x - a.x, dy = (double)b.y - a.y, length = sqrt(dx * dx + dy * dy);
    return (pv_cell){ (int32_t)floor(a.x + t * dx + 1.75 * dy / length + 0.5),
                      (int32_t)floor(a.y + t * dy - 1.75 * dx / length + 0.5) };
}

enum { LEAST_SIDE = 50 }; /* grid units */

static int is_good(const pv_cell *ring, int32_t count)
{
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[i], b = ring[(i + 1) % count];
        double dx = (double)b.x - a.x, dy = (double)b.y - a.y;
        if (pv_cell_turn(a, b, ring[(i + 2) % count]) <= 0 || dx * dx + dy * dy < LEAST_SIDE * LEAST_SIDE)
            return 0;
    }
    return count >= 3 && pv_ring_valid(ring, count);
}

/* What lies before the line, and what lies behind it; 0 if they are not two good stones. */
static int cut_at(const pv_cell *ring, int32_t count, const double way[2], double at, pv_cell *before, int32_t *n,
                  pv_cell *behind, int32_t *m)
{
    *n = *m = 0;
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[i], b = ring[(i + 1) % count];
        double da = way[0] * a.x + way[1] * a.y - at, db = way[0] * b.x + way[1] * b.y - at;
        if (da < 0)
            before[(*n)++] = a;
        else
            behind[(*m)++] = a;
        if ((da < 0) != (db < 0))
            before[(*n)++] = behind[(*m)++] = crossing(a, b, da, db);
    }
    return is_good(before, *n) && is_good(behind, *m);
}

int32_t pv_stone_divide(pv_cell *ring, int32_t count, double aspect, int32_t room, int32_t *counts)
{
    pv_cell rest[PV_STONE_MOST + 2], before[PV_STONE_MOST + 2], behind[PV_STONE_MOST + 2];
    double way[2] = { 1, 0 }, low, high, left, right;
    int32_t parts = 0, used = 0, left_over = count, n, m;
    counts[0] = count;
    if (!(aspect > 0) || !is_good(ring, count))
        return 1;
    longest_way(ring, count, &way[0], &way[1]);
    extent(ring, count, way[0], way[1], &low, &high);
    extent(ring, count, -way[1], way[0], &left, &right);
    int32_t pieces = (int32_t)ceil((high - low) / (aspect * (right - left)) - 1e-9), most = (room - count) / 4 + 1;
    pieces = pieces < most ? pieces : most;
    memcpy(rest, ring, (size_t)count * sizeof *rest);
    for (int32_t k = 1; k < pieces && parts + 1 < PV_STONE_PARTS; k++) {
        if (!cut_at(rest, left_over, way, low + (high - low) * k / pieces, before, &n, behind, &m))
            continue;
        memcpy(ring + used, before, (size_t)n * sizeof *ring);
        used += counts[parts++] = n;
        memcpy(rest, behind, (size_t)m * sizeof *rest);
        left_over = m;
    }
    memcpy(ring + used, rest, (size_t)left_over * sizeof *ring);
    counts[parts++] = left_over;
    return parts;
}
