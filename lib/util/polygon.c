/* Plane polygons: angles, and exact tests on the integer grid. */
#include "util/polygon.h"

#include "util/fixed.h"

#include <math.h>
#include <stdlib.h>

double pv_corner_width(double ax, double ay, double bx, double by, double cx, double cy)
{
    double ux = ax - bx, uy = ay - by, vx = cx - bx, vy = cy - by;
    double lengths = sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy));
    if (!(lengths > 0))
        return 1; /* a corner on its neighbour is as good as straight */
    double cosine = (ux * vx + uy * vy) / lengths;
    return pv_left_turn(ax, ay, bx, by, cx, cy) >= 0 ? -cosine : 2 + cosine;
}

/* By the integer cosine, for libm's may differ in its last bit between machines. */
double pv_width_of_degrees(double degrees)
{
    double quarters = degrees / 90 * 16384;
    int32_t below = (int32_t)floor(quarters), c0, c1, s;
    pv_turn(below, &c0, &s);
    pv_turn(below + 1, &c1, &s);
    return -(c0 + (c1 - c0) * (quarters - below)) / 65536;
}

int64_t pv_ring_area(const pv_cell *ring, int32_t count)
{
    int64_t area = 0;
    for (int32_t i = 1; i + 1 < count; i++)
        area += pv_cell_turn(ring[0], ring[i], ring[i + 1]);
    return area;
}

static int within(int64_t a, int64_t b, int64_t v)
{
    return a < b ? a <= v && v <= b : b <= v && v <= a;
}

static int sign(int64_t v)
{
    return (v > 0) - (v < 0);
}

static int on_side(pv_cell a, pv_cell b, pv_cell p)
{
    return pv_cell_turn(a, b, p) == 0 && within(a.x, b.x, p.x) && within(a.y, b.y, p.y);
}

static int sides_touch(pv_cell a, pv_cell b, pv_cell c, pv_cell d)
{
    if (sign(pv_cell_turn(a, b, c)) * sign(pv_cell_turn(a, b, d)) < 0 &&
        sign(pv_cell_turn(c, d, a)) * sign(pv_cell_turn(c, d, b)) < 0)
        return 1;
    return on_side(a, b, c) || on_side(a, b, d) || on_side(c, d, a) || on_side(c, d, b);
}

/* Neighbouring sides a b and b c may only share b: c must not lie back along a b. */
static int folds_back(pv_cell a, pv_cell b, pv_cell c)
{
    int64_t along = ((int64_t)a.x - b.x) * ((int64_t)c.x - b.x) + ((int64_t)a.y - b.y) * ((int64_t)c.y - b.y);
    return pv_cell_turn(a, b, c) == 0 && along >= 0;
}

/* Does the side from corner i touch others but its neighbours? Those wholly on one side of its line are soon passed. */
static int side_is_clear(const pv_cell *ring, int32_t count, int32_t i)
{
    int32_t j = i + 1 < count ? i + 1 : 0, m = j + 1 < count ? j + 1 : 0;
    int64_t turn = pv_cell_turn(ring[i], ring[j], ring[m]);
    for (int32_t n = m + 1 < count ? m + 1 : 0; n != i; m = n, n = n + 1 < count ? n + 1 : 0) {
        int64_t next = pv_cell_turn(ring[i], ring[j], ring[n]);
        if (!((turn > 0 && next > 0) || (turn < 0 && next < 0)) && sides_touch(ring[i], ring[j], ring[m], ring[n]))
            return 0;
        turn = next;
    }
    return 1;
}

int pv_ring_valid(const pv_cell *ring, int32_t count)
{
    if (count < 3 || pv_ring_area(ring, count) <= 0)
        return 0;
    for (int32_t i = 0; i < count; i++)
        if (folds_back(ring[i], ring[(i + 1) % count], ring[(i + 2) % count]) || !side_is_clear(ring, count, i))
            return 0;
    return 1;
}

int pv_ring_valid_at(const pv_cell *ring, int32_t count, int32_t at)
{
    if (count < 3 || pv_ring_area(ring, count) <= 0)
        return 0;
    int32_t before = at ? at - 1 : count - 1, first = before ? before - 1 : count - 1;
    int32_t after = at + 1 < count ? at + 1 : 0, last = after + 1 < count ? after + 1 : 0;
    return !folds_back(ring[first], ring[before], ring[at]) && !folds_back(ring[before], ring[at], ring[after]) &&
           !folds_back(ring[at], ring[after], ring[last]) && side_is_clear(ring, count, before) &&
           side_is_clear(ring, count, at);
}

/* Even-odd, for a point on none of the sides. */
static int is_inside(const pv_cell *ring, int32_t count, pv_cell p)
{
    int inside = 0;
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[i], b = ring[i + 1 < count ? i + 1 : 0];
        if ((a.y > p.y) != (b.y > p.y))
            inside ^= (pv_cell_turn(a, b, p) > 0) == (b.y < a.y);
    }
    return inside;
}

int pv_ring_inside(const pv_cell *ring, int32_t count, const pv_cell *inner, int32_t corners)
{
    for (int32_t i = 0; i < corners; i++)
        for (int32_t k = 0; k < count; k++)
            if (sides_touch(inner[i], inner[i + 1 < corners ? i + 1 : 0], ring[k], ring[k + 1 < count ? k + 1 : 0]))
                return 0;
    return is_inside(ring, count, inner[0]);
}

static int by_place(const void *a, const void *b)
{
    const pv_cell *p = a, *q = b;
    return p->x != q->x ? (p->x > q->x) - (p->x < q->x) : (p->y > q->y) - (p->y < q->y);
}

/* Andrew's monotone chain: the lower side from left to right, then the upper one back. */
int32_t pv_convex_hull(pv_cell *points, int32_t count, pv_cell *hull)
{
    int32_t n = 0;
    qsort(points, (size_t)count, sizeof *points, by_place);
    for (int32_t pass = 0, start = 0; pass < 2; pass++, start = n) {
        for (int32_t i = 0; i < count; i++) {
            pv_cell p = points[pass ? count - 1 - i : i];
            while (n >= start + 2 && pv_cell_turn(hull[n - 2], hull[n - 1], p) <= 0)
                n--;
            hull[n++] = p;
        }
        n--; /* the last point begins the other side */
    }
    return n;
}
