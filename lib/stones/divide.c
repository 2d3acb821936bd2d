/* Stones that are too long, cut across. */
#include "stones/inscribe.h"

#include <math.h>
#include <string.h>

static double length_of(pv_cell a, pv_cell b)
{
    double dx = (double)b.x - a.x, dy = (double)b.y - a.y;
    return sqrt(dx * dx + dy * dy);
}

/* Along the longest side, and across it: a direction of length 1. */
static void longest_way(const pv_cell *ring, int32_t count, double *ux, double *uy)
{
    double most = 0;
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[i], b = ring[(i + 1) % count];
        double length = length_of(a, b);
        if (length > most)
            most = length, *ux = ((double)b.x - a.x) / length, *uy = ((double)b.y - a.y) / length;
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
    double t = da / (da - db), dx = (double)b.x - a.x, dy = (double)b.y - a.y, length = length_of(a, b);
    return (pv_cell){ (int32_t)floor(a.x + t * dx + 1.75 * dy / length + 0.5),
                      (int32_t)floor(a.y + t * dy - 1.75 * dx / length + 0.5) };
}

enum { LEAST_SIDE = 50 }; /* grid units */

static int is_good(const pv_cell *ring, int32_t count)
{
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[i], b = ring[(i + 1) % count];
        if (pv_cell_turn(a, b, ring[(i + 2) % count]) <= 0 || length_of(a, b) < LEAST_SIDE)
            return 0;
    }
    return count >= 3 && pv_ring_valid(ring, count);
}

/* The line x * point.x + y * point.y = at. */
typedef struct line {
    double x, y, at;
} line;

/* Across a stone of four corners: from a part of one of its long sides to the same part of the other one, which leaves
 * four corners on either hand. */
static line line_across(const pv_cell *ring, double part)
{
    double length[4];
    for (int32_t i = 0; i < 4; i++)
        length[i] = length_of(ring[i], ring[(i + 1) % 4]);
    int32_t i = length[0] + length[2] >= length[1] + length[3] ? 0 : 1;
    pv_cell a = ring[i], b = ring[i + 1], c = ring[i + 2], d = ring[(i + 3) % 4];
    double px = a.x + part * ((double)b.x - a.x), py = a.y + part * ((double)b.y - a.y);
    double qx = d.x + part * ((double)c.x - d.x), qy = d.y + part * ((double)c.y - d.y);
    return (line){ qy - py, px - qx, (qy - py) * px + (px - qx) * py };
}

/* What lies before the line, and what lies behind it; 0 if they are not two good stones. */
static int cut_at(const pv_cell *ring, int32_t count, line l, pv_cell *before, int32_t *n, pv_cell *behind, int32_t *m)
{
    *n = *m = 0;
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[i], b = ring[(i + 1) % count];
        double da = l.x * a.x + l.y * a.y - l.at, db = l.x * b.x + l.y * b.y - l.at;
        if (da < 0)
            before[(*n)++] = a;
        else
            behind[(*m)++] = a;
        if ((da < 0) != (db < 0))
            before[(*n)++] = behind[(*m)++] = crossing(a, b, da, db);
    }
    int tips = (*n == 3) + (*m == 3) - (count == 3); /* a triangle has a tip, other stones need not get one */
    return tips <= 0 && is_good(before, *n) && is_good(behind, *m);
}

int32_t pv_stone_divide(pv_cell *ring, int32_t count, double aspect, int32_t room, int32_t *counts)
{
    pv_cell whole[PV_STONE_MOST], rest[PV_STONE_MOST + 2], before[PV_STONE_MOST + 2], behind[PV_STONE_MOST + 2];
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
    memcpy(whole, ring, (size_t)count * sizeof *whole);
    memcpy(rest, ring, (size_t)count * sizeof *rest);
    for (int32_t k = 1; k < pieces && parts + 1 < PV_STONE_PARTS; k++) {
        double part = (double)k / pieces;
        line l = count == 4 ? line_across(whole, part) : (line){ way[0], way[1], low + (high - low) * part };
        if (!cut_at(rest, left_over, l, before, &n, behind, &m))
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
