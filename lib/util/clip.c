/* Where polygons of the integer grid overlap. */
#include "util/clip.h"

#include <string.h>

static int64_t cross(pv_cell a, pv_cell b, pv_cell c)
{
    return ((int64_t)b.x - a.x) * ((int64_t)a.y - c.y) - ((int64_t)a.y - b.y) * ((int64_t)c.x - a.x);
}

int pv_ring_convex(const pv_cell *ring, int32_t count)
{
    for (int32_t i = 0; i < count; i++)
        if (cross(ring[i], ring[(i + 1) % count], ring[(i + 2) % count]) < 0)
            return 0;
    return 1;
}

/* Does the line through a side of `a` have all of `b` on its outer side? */
static int side_parts(const pv_cell *a, int32_t a_count, const pv_cell *b, int32_t b_count)
{
    for (int32_t i = 0; i < a_count; i++) {
        int parts = 1;
        for (int32_t j = 0; j < b_count && parts; j++)
            parts = cross(a[i], a[(i + 1) % a_count], b[j]) <= 0;
        if (parts)
            return 1;
    }
    return 0;
}

int pv_convex_meet(const pv_cell *a, int32_t a_count, const pv_cell *b, int32_t b_count)
{
    return !side_parts(a, a_count, b, b_count) && !side_parts(b, b_count, a, a_count);
}

/* A line from the origin `x, y` along `dx, dy`; inside is on its left as seen. */
typedef struct edge {
    double x, y, dx, dy;
} edge;

static double depth(const edge *e, const double *p)
{
    return e->dx * (e->y - p[1]) + e->dy * (p[0] - e->x);
}

/* Sutherland and Hodgman's step: what of a polygon is on the inner side of one line. */
static int32_t cut(const edge *e, const double *in, int32_t count, double *out)
{
    int32_t n = 0;
    for (int32_t i = 0; i < count; i++) {
        const double *p = in + 2 * i, *q = in + 2 * ((i + 1) % count);
        double dp = depth(e, p), dq = depth(e, q);
        if (dp >= 0) {
            out[2 * n] = p[0];
            out[2 * n++ + 1] = p[1];
        }
        if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) {
            double t = dp / (dp - dq);
            out[2 * n] = p[0] + t * (q[0] - p[0]);
            out[2 * n++ + 1] = p[1] + t * (q[1] - p[1]);
        }
    }
    return n;
}

static double area_of(const double *p, int32_t count)
{
    double twice = 0;
    for (int32_t i = 1; i + 1 < count; i++)
        twice += pv_left_turn(p[0], p[1], p[2 * i], p[2 * i + 1], p[2 * i + 2], p[2 * i + 3]);
    return twice > 0 ? twice / 2 : 0;
}

/* Everything as seen from the first corner, where differences are small and exact. */
double pv_convex_common(const pv_cell *a, int32_t a_count, const pv_cell *b, int32_t b_count, double *work)
{
    double *now = work, *next = work + 2 * (a_count + b_count);
    int32_t count = b_count;
    for (int32_t i = 0; i < b_count; i++) {
        now[2 * i] = (double)b[i].x - a[0].x;
        now[2 * i + 1] = (double)b[i].y - a[0].y;
    }
    for (int32_t i = 0; i < a_count && count; i++) {
        pv_cell p = a[i], q = a[(i + 1) % a_count];
        edge e = { (double)p.x - a[0].x, (double)p.y - a[0].y, (double)q.x - p.x, (double)q.y - p.y };
        count = cut(&e, now, count, next);
        double *swap = now;
        now = next;
        next = swap;
    }
    return area_of(now, count);
}

/* Can the corner at `i` be cut off: is it convex, with no other corner in or on its triangle but its own three? */
static int is_ear(const pv_cell *ring, int32_t count, int32_t i)
{
    pv_cell a = ring[(i + count - 1) % count], b = ring[i], c = ring[(i + 1) % count];
    if (cross(a, b, c) <= 0)
        return 0;
    for (int32_t j = 0; j < count; j++) {
        pv_cell p = ring[j];
        if ((j + 1) % count == i || j == i || (i + 1) % count == j)
            continue;
        if (cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0)
            return 0;
    }
    return 1;
}

/* A straight corner is as good; every valid ring without one has an ear. */
static int32_t find_ear(const pv_cell *ring, int32_t count, int *straight)
{
    for (int32_t i = 0; i < count; i++)
        if ((*straight = cross(ring[(i + count - 1) % count], ring[i], ring[(i + 1) % count]) == 0))
            return i;
    for (int32_t i = 0; i < count; i++)
        if (is_ear(ring, count, i))
            return i;
    return 0;
}

int32_t pv_ring_triangles(pv_cell *ring, int32_t count, pv_cell *triangles)
{
    int32_t found = 0;
    for (; count >= 3; count--) {
        int straight;
        int32_t i = find_ear(ring, count, &straight);
        if (!straight) {
            triangles[3 * found] = ring[(i + count - 1) % count];
            triangles[3 * found + 1] = ring[i];
            triangles[3 * found++ + 2] = ring[(i + 1) % count];
        }
        memmove(&ring[i], &ring[i + 1], (size_t)(count - 1 - i) * sizeof *ring);
    }
    return found;
}
