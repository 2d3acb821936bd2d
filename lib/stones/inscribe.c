/* The largest quadrilateral that a cell's own sides lead to. */
#include "stones/inscribe.h"

#include <math.h>
#include <string.h>

__extension__ typedef __int128 wide;

/* Is there more than a point of the segment strictly inside the convex ring? */
static int cuts_into(const pv_cell *convex, int32_t corners, pv_cell s, pv_cell e)
{
    int64_t low_n = 0, low_d = 1, high_n = 1, high_d = 1;
    for (int32_t k = 0; k < corners; k++) {
        pv_cell a = convex[k], b = convex[k + 1 < corners ? k + 1 : 0];
        int64_t cs = pv_cell_turn(a, b, s), ce = pv_cell_turn(a, b, e);
        if (cs <= 0 && ce <= 0)
            return 0;
        if (cs < 0 && (wide)-cs * low_d > (wide)low_n * (ce - cs))
            low_n = -cs, low_d = ce - cs;
        if (ce < 0 && (wide)cs * high_d < (wide)high_n * (cs - ce))
            high_n = cs, high_d = cs - ce;
    }
    return (wide)low_n * high_d < (wide)high_n * low_d;
}

/* Is the mean of the convex ring's corners inside the other one? Even-odd, in units of 1 / corners. */
static int holds_middle(const pv_cell *ring, int32_t count, const pv_cell *convex, int32_t corners)
{
    int64_t mx = 0, my = 0;
    int inside = 0;
    for (int32_t k = 0; k < corners; k++) {
        mx += (int64_t)convex[k].x - ring[0].x;
        my += (int64_t)convex[k].y - ring[0].y;
    }
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[i], b = ring[i + 1 < count ? i + 1 : 0];
        int64_t ax = ((int64_t)a.x - ring[0].x) * corners - mx, ay = ((int64_t)a.y - ring[0].y) * corners - my;
        int64_t bx = ((int64_t)b.x - ring[0].x) * corners - mx, by = ((int64_t)b.y - ring[0].y) * corners - my;
        if ((ay <= 0) == (by <= 0))
            continue;
        wide turn = (wide)ax * by - (wide)ay * bx;
        inside ^= by > ay ? turn > 0 : turn < 0;
    }
    return inside;
}

static int contains_convex(const pv_cell *ring, int32_t count, const pv_cell *convex, int32_t corners)
{
    for (int32_t i = 0; i < count; i++)
        if (cuts_into(convex, corners, ring[i], ring[i + 1 < count ? i + 1 : 0]))
            return 0;
    return holds_middle(ring, count, convex, corners);
}

/* The first corner bent inwards; -1: none is. */
static int32_t first_dent(const pv_cell *ring, int32_t count)
{
    for (int32_t i = 0; i < count; i++)
        if (pv_cell_turn(ring[(i + count - 1) % count], ring[i], ring[(i + 1) % count]) <= 0)
            return i;
    return -1;
}

/* From corner i on, so many. */
static void part_of(const pv_cell *ring, int32_t count, int32_t i, int32_t many, pv_cell *out)
{
    for (int32_t k = 0; k < many; k++)
        out[k] = ring[(i + k) % count];
}

/* A ring with a dent lies in another if both its parts do, on the sides of some line from the dent to a corner. */
int pv_ring_contains(const pv_cell *ring, int32_t count, const pv_cell *inner, int32_t corners)
{
    pv_cell a[PV_STONE_SIDES], b[PV_STONE_SIDES];
    int32_t dent = first_dent(inner, corners);
    if (dent < 0)
        return contains_convex(ring, count, inner, corners);
    for (int32_t k = 2; k < corners - 1 && corners <= PV_STONE_SIDES; k++) {
        part_of(inner, corners, dent, k + 1, a);
        part_of(inner, corners, (dent + k) % corners, corners - k + 1, b);
        if (first_dent(a, k + 1) < 0 && first_dent(b, corners - k + 1) < 0)
            return contains_convex(ring, count, a, k + 1) && contains_convex(ring, count, b, corners - k + 1);
    }
    return 0;
}

enum { MOST_DENTED = 8, LEAST_SIDE = 50 }; /* grid units; some readers take shorter ones for none */

/* A side of the stone: the line through two points of the cell that has all others of its chain on the outside. */
typedef struct side {
    pv_cell a, b;
    int moved; /* it is not just the chord between its corners */
} side;

/* May a point lie on a side's line? Where the line is upright or level, files and readers agree that it does. */
static int touches(pv_cell a, pv_cell b)
{
    return a.x == b.x || a.y == b.y;
}

static double length_of(pv_cell a, pv_cell b)
{
    double dx = (double)b.x - a.x, dy = (double)b.y - a.y;
    return sqrt(dx * dx + dy * dy);
}

/* The next point of a chain's hull from `i` on: no later one lies to the left of the line there. */
static int32_t next_on_hull(const pv_cell *ring, int32_t count, int32_t i, int32_t steps, int32_t *gone)
{
    int32_t best = 1;
    for (int32_t k = 2; k <= steps; k++) {
        int64_t turn = pv_cell_turn(ring[i], ring[(i + best) % count], ring[(i + k) % count]);
        if (turn >= 0)
            best = k;
    }
    *gone = best;
    return (i + best) % count;
}

static side side_between(const pv_cell *ring, int32_t count, int32_t i, int32_t j)
{
    int32_t steps = (j - i + count) % count;
    side out = { ring[i], ring[j], 0 };
    double longest = 0;
    for (int32_t k = 1; k < steps && !out.moved; k++) {
        int64_t turn = pv_cell_turn(ring[i], ring[j], ring[(i + k) % count]);
        out.moved = turn > 0 || (turn == 0 && !touches(ring[i], ring[j]));
    }
    for (int32_t at = i; out.moved && steps > 0;) {
        int32_t gone, next = next_on_hull(ring, count, at, steps, &gone);
        double length = length_of(ring[at], ring[next]);
        if (length > longest)
            longest = length, out.a = ring[at], out.b = ring[next];
        at = next;
        steps -= gone;
    }
    return out;
}

/* Where two sides meet: at their common corner; or, one of them moved, at a point of the grid that is a unit or more
 * inside both, for rounding goes less than 3/4 of a unit astray. */
static int meet(const side *s, const side *t, pv_cell corner, pv_cell *out)
{
    double ux = (double)s->b.x - s->a.x, uy = (double)s->b.y - s->a.y, u = length_of(s->a, s->b);
    double vx = (double)t->b.x - t->a.x, vy = (double)t->b.y - t->a.y, v = length_of(t->a, t->b);
    double cross = ux * vy - uy * vx, inside = 1.75;
    *out = corner;
    if (!s->moved && !t->moved)
        return 1;
    if (!(fabs(cross) > 1e-3 * u * v))
        return 0;
    double k = (((double)t->a.x - s->a.x) * vy - ((double)t->a.y - s->a.y) * vx) / cross;
    double x = s->a.x + k * ux + inside * (ux * v - vx * u) / cross;
    double y = s->a.y + k * uy + inside * (uy * v - vy * u) / cross;
    if (fabs(x - corner.x) > 1e6 || fabs(y - corner.y) > 1e6)
        return 0;
    *out = (pv_cell){ (int32_t)floor(x + 0.5), (int32_t)floor(y + 0.5) };
    return 1;
}

/* The stone with corners at these places of the ring, if it fits. */
static int32_t stone_at(const pv_stone_cell *cell, const int32_t *at, int32_t corners, pv_cell *out)
{
    side sides[PV_STONE_SIDES];
    for (int32_t k = 0; k < corners; k++)
        sides[k] = side_between(cell->ring, cell->count, at[k], at[(k + 1) % corners]);
    for (int32_t k = 0; k < corners; k++)
        if (!meet(&sides[(k + corners - 1) % corners], &sides[k], cell->ring[at[k]], &out[k]))
            return 0;
    if (!cell->dents && first_dent(out, corners) >= 0)
        return 0;
    for (int32_t k = 0; k < corners; k++)
        if (pv_cell_turn(out[k], out[(k + 1) % corners], out[(k + 2) % corners]) == 0 ||
            length_of(out[k], out[(k + 1) % corners]) < LEAST_SIDE)
            return 0;
    return pv_ring_valid(out, corners) && pv_ring_contains(cell->ring, cell->count, out, corners) ? corners : 0;
}

static int64_t ear(const pv_cell *ring, const int32_t *at, int32_t corners, int32_t k)
{
    return pv_cell_turn(ring[at[(k + corners - 1) % corners]], ring[at[k]], ring[at[(k + 1) % corners]]);
}

/* Corners of the cell that stick out, at most `most` of them: those go first that cut off least. */
static int32_t choose_corners(const pv_stone_cell *cell, int32_t most, int32_t *at)
{
    int32_t n = 0;
    for (int32_t i = 0; i < cell->count; i++) {
        pv_cell a = cell->ring[(i + cell->count - 1) % cell->count], c = cell->ring[(i + 1) % cell->count];
        if (cell->corner[i] && pv_cell_turn(a, cell->ring[i], c) > 0 && n < PV_STONE_MOST)
            at[n++] = i;
    }
    while (n > most) {
        int32_t worst = 0;
        for (int32_t k = 1; k < n; k++)
            if (ear(cell->ring, at, n, k) < ear(cell->ring, at, n, worst))
                worst = k;
        n--;
        memmove(&at[worst], &at[worst + 1], (size_t)(n - worst) * sizeof *at);
    }
    return n;
}

/* How far a place of the ring sticks out of the side between two corners, or from the only one. */
static int64_t bulge(const pv_cell *ring, int32_t i, int32_t j, int32_t m)
{
    int64_t dx = (int64_t)ring[m].x - ring[i].x, dy = (int64_t)ring[m].y - ring[i].y;
    return i == j ? dx * dx + dy * dy : -pv_cell_turn(ring[i], ring[j], ring[m]);
}

/* The place that sticks out most; -1: none does. */
static int32_t farthest_out(const pv_stone_cell *cell, const int32_t *at, int32_t n)
{
    int64_t best = 0;
    int32_t where = -1;
    for (int32_t k = 0; k < n; k++) {
        int32_t i = at[k], j = at[(k + 1) % n], steps = i == j ? cell->count : (j - i + cell->count) % cell->count;
        for (int32_t s = 1; s < steps; s++) {
            int32_t m = (i + s) % cell->count;
            if (bulge(cell->ring, i, j, m) > best)
                best = bulge(cell->ring, i, j, m), where = m;
        }
    }
    return where;
}

/* Puts a place among the corners, in order. */
static void insert_corner(int32_t *at, int32_t n, int32_t m)
{
    for (; n && at[n - 1] > m; n--)
        at[n] = at[n - 1];
    at[n] = m;
}

/* Too few corners: those places of the ring that stick out most become corners too. */
static int32_t add_corners(const pv_stone_cell *cell, int32_t least, int32_t n, int32_t *at)
{
    if (!n)
        at[n++] = 0;
    while (n < least) {
        int32_t m = farthest_out(cell, at, n);
        if (m < 0)
            return n;
        insert_corner(at, n++, m);
    }
    return n;
}

/* A point a little inside the side from a to b, so much of its length from a. */
static pv_cell point_along(pv_cell a, pv_cell b, double part)
{
    double dx = (double)b.x - a.x, dy = (double)b.y - a.y, length = length_of(a, b);
    return (pv_cell){ (int32_t)floor(a.x + part * dx + 1.75 * dy / length + 0.5),
                      (int32_t)floor(a.y + part * dy - 1.75 * dx / length + 0.5) };
}

/* A triangle gets a fourth corner: its sharpest tip, which would break off anyway, is cut. */
static int32_t blunt(pv_cell *ring)
{
    int32_t sharpest = 0;
    double least = 3;
    for (int32_t i = 0; i < 3; i++) {
        pv_cell a = ring[(i + 2) % 3], b = ring[i], c = ring[(i + 1) % 3];
        double width = pv_corner_width(a.x, a.y, b.x, b.y, c.x, c.y);
        if (width < least)
            least = width, sharpest = i;
    }
    pv_cell a = ring[(sharpest + 2) % 3], b = ring[sharpest], c = ring[(sharpest + 1) % 3];
    double far = length_of(a, b) < length_of(b, c) ? length_of(a, b) : length_of(b, c), way = far / 6;
    pv_cell out[4] = { point_along(a, b, 1 - way / length_of(a, b)), point_along(b, c, way / length_of(b, c)), c, a };
    for (int32_t k = 0; k < 4; k++)
        if (pv_cell_turn(out[k], out[(k + 1) % 4], out[(k + 2) % 4]) <= 0 ||
            length_of(out[k], out[(k + 1) % 4]) < LEAST_SIDE || pv_ring_area(ring, 3) <= 0)
            return 3;
    memcpy(ring, out, sizeof out);
    return 4;
}

/* One corner more: that with which the stone is largest. Returns twice its area, 0: no stone has one more. */
static int64_t grow(const pv_stone_cell *cell, int32_t *at, int32_t n, pv_cell *out)
{
    pv_cell trial[PV_STONE_SIDES];
    int32_t with[PV_STONE_SIDES], best_at[PV_STONE_SIDES];
    int64_t most = 0;
    for (int32_t m = 0; m < cell->count; m++) {
        int known = 0;
        for (int32_t k = 0; k < n; k++)
            known |= at[k] == m;
        memcpy(with, at, (size_t)n * sizeof *with);
        insert_corner(with, n, m);
        if (known || !stone_at(cell, with, n + 1, trial) || pv_ring_area(trial, n + 1) <= most)
            continue;
        most = pv_ring_area(trial, n + 1);
        memcpy(out, trial, ((size_t)n + 1) * sizeof *out);
        memcpy(best_at, with, ((size_t)n + 1) * sizeof *with);
    }
    if (most)
        memcpy(at, best_at, ((size_t)n + 1) * sizeof *at);
    return most;
}

int32_t pv_stone_grow(const pv_stone_cell *cell, double most_loss, pv_cell *out)
{
    int32_t at[PV_STONE_MOST], n;
    int64_t most = 0, area = pv_ring_area(cell->ring, cell->count);
    if (cell->count > PV_STONE_MOST)
        return 0;
    n = choose_corners(cell, 4, at);
    if (n < 4)
        n = add_corners(cell, 4, n, at);
    while (n < MOST_DENTED && (double)most < (1 - most_loss) * (double)area) {
        most = grow(cell, at, n, out);
        if (!most)
            return 0;
        n++;
    }
    return (double)most < (1 - 2 * most_loss) * (double)area ? 0 : n;
}

int32_t pv_stone_fit(const pv_stone_cell *cell, double most_loss, pv_cell *out)
{
    pv_cell best[PV_STONE_SIDES], trial[PV_STONE_SIDES];
    int32_t at[PV_STONE_MOST], found = 0;
    if (cell->count > PV_STONE_MOST)
        return 0;
    int64_t area = pv_ring_area(cell->ring, cell->count), most = 0;
    for (int32_t corners = 4; corners <= PV_STONE_SIDES && (double)most < (1 - most_loss) * (double)area; corners++) {
        int32_t n = choose_corners(cell, corners, at);
        if (n < 4)
            n = add_corners(cell, 4, n, at);
        if (n < 3 || (corners > 4 && n < corners))
            break;
        if (stone_at(cell, at, n, trial) && pv_ring_area(trial, n) > most) {
            most = pv_ring_area(trial, n);
            found = n;
            memcpy(best, trial, sizeof best);
        }
    }
    if ((double)most < (1 - 2 * most_loss) * (double)area)
        return 0;
    memcpy(out, best, sizeof best);
    return found == 3 ? blunt(out) : found;
}

/* May the corner k of a ring go? Not if it is a dent, or if the rest would come into what it cuts off. */
static int may_go(const pv_cell *ring, int32_t count, int32_t k)
{
    pv_cell a = ring[(k + count - 1) % count], b = ring[k], c = ring[(k + 1) % count];
    if (pv_cell_turn(a, b, c) <= 0)
        return pv_cell_turn(a, b, c) == 0;
    for (int32_t s = 2; s < count - 1; s++) {
        pv_cell p = ring[(k + s) % count];
        if (pv_cell_turn(a, b, p) >= 0 && pv_cell_turn(b, c, p) >= 0 && pv_cell_turn(c, a, p) >= 0)
            return 0;
    }
    return 1;
}

#define MOST_DROPPED 0.003 /* of a cell's area, with corners that are hardly seen */

/* Drops corners of a ring, those first that cut off least, as long as all together cut off no more than that. */
static int32_t drop_corners(pv_cell *ring, int32_t count, double most)
{
    while (count > 4) {
        int32_t best = -1;
        int64_t least = 0;
        for (int32_t k = 0; k < count; k++) {
            int64_t area = pv_cell_turn(ring[(k + count - 1) % count], ring[k], ring[(k + 1) % count]);
            if ((best < 0 || area < least) && may_go(ring, count, k))
                best = k, least = area;
        }
        if (best < 0 || (double)least > most)
            return count;
        most -= (double)least;
        count--;
        memmove(&ring[best], &ring[best + 1], (size_t)(count - best) * sizeof *ring);
    }
    return count;
}

int32_t pv_stone_inscribe(const pv_stone_cell *cell, double most_loss, pv_cell *out)
{
    int32_t found = pv_stone_fit(cell, most_loss, out);
    if (found || cell->count > PV_STONE_MOST)
        return found;
    memcpy(out, cell->ring, (size_t)cell->count * sizeof *out);
    return drop_corners(out, cell->count, MOST_DROPPED * (double)pv_ring_area(cell->ring, cell->count));
}
