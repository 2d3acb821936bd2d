/* Joints: the sides of a stone moved inwards, or its corners drawn in. */
#include "stones/inscribe.h"

#include "stones/tess.h"

#include <math.h>
#include <string.h>

static double length_of(pv_cell a, pv_cell b)
{
    double dx = (double)b.x - a.x, dy = (double)b.y - a.y;
    return sqrt(dx * dx + dy * dy);
}

/* Corners nearer than this are one to readers that compare with a tolerance: 1/50 px. */
enum { NEAR = PV_GRID / 50 };

static int are_near(pv_cell a, pv_cell b)
{
    return length_of(a, b) < NEAR;
}

static int is_convex(const pv_cell *ring, int32_t count)
{
    for (int32_t i = 0; i < count; i++)
        if (pv_cell_turn(ring[i], ring[(i + 1) % count], ring[(i + 2) % count]) <= 0)
            return 0;
    return 1;
}

/* How far a point lies inside a side, grid units. */
static double depth(pv_cell a, pv_cell b, pv_cell p)
{
    double length = length_of(a, b);
    return length > 0 ? (double)pv_cell_turn(a, b, p) / length : 0;
}

/* The point of the grid by corner b that is `way` inside of its sides, and a little more for the rounding. */
static int corner_inside(pv_cell a, pv_cell b, pv_cell c, double way, pv_cell *out)
{
    double u = length_of(a, b), v = length_of(b, c);
    double ux = ((double)b.x - a.x) / u, uy = ((double)b.y - a.y) / u, vx = ((double)c.x - b.x) / v;
    double vy = ((double)c.y - b.y) / v, cross = ux * vy - uy * vx;
    if (!(fabs(cross) > 1e-3))
        return 0;
    double k = (way + 0.75) / cross; /* the inner side is (uy, -ux) of a way u, for y goes down */
    *out = (pv_cell){ (int32_t)floor(b.x + k * (ux - vx) + 0.5), (int32_t)floor(b.y + k * (uy - vy) + 0.5) };
    return 1;
}

/* All corners moved in, if the stone stays what it was. */
static int offset_all(const pv_cell *ring, int32_t count, double way, pv_cell *out)
{
    for (int32_t i = 0; i < count; i++)
        if (!corner_inside(ring[(i + count - 1) % count], ring[i], ring[(i + 1) % count], way, &out[i]))
            return 0;
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[i], b = ring[(i + 1) % count], p = out[i], q = out[(i + 1) % count];
        double along = ((double)b.x - a.x) * ((double)q.x - p.x) + ((double)b.y - a.y) * ((double)q.y - p.y);
        if (along <= 0 || are_near(p, q))
            return 0;
    }
    if (!pv_ring_valid(out, count))
        return 0;
    return pv_ring_inside(ring, count, out, count) && (!is_convex(ring, count) || is_convex(out, count));
}

/* Sutherland and Hodgman's clipping by one side moved in; doubles, in grid units. */
static int32_t clip(const double (*in)[2], int32_t count, pv_cell a, pv_cell b, double way, double (*out)[2])
{
    double length = length_of(a, b), dx = ((double)b.x - a.x) / length, dy = ((double)b.y - a.y) / length;
    int32_t n = 0;
    for (int32_t i = 0; i < count; i++) {
        const double *p = in[i], *q = in[(i + 1) % count];
        double dp = dy * (p[0] - a.x) - dx * (p[1] - a.y) - way, dq = dy * (q[0] - a.x) - dx * (q[1] - a.y) - way;
        if (dp >= 0)
            out[n][0] = p[0], out[n++][1] = p[1];
        if ((dp < 0) != (dq < 0)) {
            double t = dp / (dp - dq);
            out[n][0] = p[0] + t * (q[0] - p[0]), out[n++][1] = p[1] + t * (q[1] - p[1]);
        }
    }
    return n;
}

static int inside_all(const pv_cell *ring, int32_t count, pv_cell p, double way)
{
    for (int32_t i = 0; i < count; i++)
        if (depth(ring[i], ring[(i + 1) % count], p) < way)
            return 0;
    return 1;
}

/* What is left of a convex stone with fewer corners. */
static int32_t offset_some(const pv_cell *ring, int32_t count, double way, pv_cell *out)
{
    double p[2][2 * PV_STONE_SIDES + 2][2];
    int32_t n = count, kept = 0;
    for (int32_t i = 0; i < count; i++)
        p[0][i][0] = ring[i].x, p[0][i][1] = ring[i].y;
    for (int32_t i = 0; i < count && n; i++) {
        n = clip((const double (*)[2])p[0], n, ring[i], ring[(i + 1) % count], way + 1, p[1]);
        memcpy(p[0], p[1], (size_t)n * sizeof p[0][0]);
    }
    for (int32_t i = 0; i < n; i++) {
        pv_cell c = { (int32_t)floor(p[0][i][0] + 0.5), (int32_t)floor(p[0][i][1] + 0.5) };
        if (inside_all(ring, count, c, way) && (!kept || !are_near(c, out[kept - 1])))
            out[kept++] = c;
    }
    while (kept > 1 && are_near(out[0], out[kept - 1]))
        kept--;
    return kept >= 3 && is_convex(out, kept) && pv_ring_valid(out, kept) ? kept : 0;
}

int32_t pv_stone_offset(pv_cell *ring, int32_t count, double way)
{
    pv_cell out[PV_STONE_MOST];
    if (!(way > 0))
        return count;
    for (int32_t quarters = 4; quarters >= 2; quarters--)
        if (offset_all(ring, count, way * quarters / 4, out)) {
            memcpy(ring, out, (size_t)count * sizeof *ring);
            return count;
        }
    if (count > PV_STONE_SIDES || !is_convex(ring, count))
        return 0;
    count = offset_some(ring, count, way / 2, out);
    memcpy(ring, out, (size_t)count * sizeof *ring);
    return count;
}

static void centroid(const pv_cell *ring, int32_t count, double *x, double *y)
{
    double area = 0, sx = 0, sy = 0;
    pv_cell o = ring[0];
    for (int32_t i = 1; i + 1 < count; i++) {
        double turn = (double)pv_cell_turn(o, ring[i], ring[i + 1]);
        area += turn;
        sx += turn * ((double)ring[i].x - o.x + ring[i + 1].x - o.x);
        sy += turn * ((double)ring[i].y - o.y + ring[i + 1].y - o.y);
    }
    *x = o.x + sx / (3 * area);
    *y = o.y + sy / (3 * area);
}

int32_t pv_stone_draw_in(pv_cell *ring, int32_t count, double way)
{
    pv_cell out[PV_STONE_MOST];
    double x, y;
    if (!(way > 0))
        return count;
    if (!is_convex(ring, count))
        return pv_stone_offset(ring, count, way);
    centroid(ring, count, &x, &y);
    for (int32_t quarters = 4; quarters > 0; quarters--) {
        int inside = 1;
        for (int32_t i = 0; i < count; i++) {
            double dx = x - ring[i].x, dy = y - ring[i].y, d = sqrt(dx * dx + dy * dy);
            double t = d > 0 ? way * quarters / 4 / d : 0;
            t = t < 0.5 ? t : 0.5;
            out[i] = (pv_cell){ (int32_t)floor(ring[i].x + t * dx + 0.5), (int32_t)floor(ring[i].y + t * dy + 0.5) };
            inside &= inside_all(ring, count, out[i], 0);
        }
        if (inside && is_convex(out, count) && pv_ring_valid(out, count)) {
            memcpy(ring, out, (size_t)count * sizeof *ring);
            return count;
        }
    }
    return pv_stone_offset(ring, count, way);
}
