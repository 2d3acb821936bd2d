/* Plane polygons. Rings are counter-clockwise as seen with y going down, which makes a convex corner a left turn. */
#pragma once

#include <stdint.h>

/* Twice the area of the triangle a b c, positive for a left turn as seen (y goes down). */
static inline double pv_left_turn(double ax, double ay, double bx, double by, double cx, double cy)
{
    return (bx - ax) * (ay - cy) - (ay - by) * (cx - ax);
}

/* How wide the corner at b is between a and c, growing with the angle from -1 (0 degrees) over 1 (180) to 3 (360). */
double pv_corner_width(double ax, double ay, double bx, double by, double cx, double cy);

/* The same scale for an angle in degrees, 0..180. */
double pv_width_of_degrees(double degrees);

/* A polygon on the integer grid, exactly. */
typedef struct pv_cell {
    int32_t x, y;
} pv_cell;

/* Twice the area of the triangle a b c, positive for a left turn. */
static inline int64_t pv_cell_turn(pv_cell a, pv_cell b, pv_cell c)
{
    return ((int64_t)b.x - a.x) * ((int64_t)a.y - c.y) - ((int64_t)a.y - b.y) * ((int64_t)c.x - a.x);
}

/* Twice the signed area, positive for a ring as above. */
int64_t pv_ring_area(const pv_cell *ring, int32_t count);

/* No two sides touch but neighbours at their common corner, and the area is positive. */
int pv_ring_valid(const pv_cell *ring, int32_t count);

/* The same where only corner `at` of a valid ring has been moved. */
int pv_ring_valid_at(const pv_cell *ring, int32_t count, int32_t at);

/* Does a ring lie inside another one, both valid, and touch it nowhere? */
int pv_ring_inside(const pv_cell *ring, int32_t count, const pv_cell *inner, int32_t corners);

/* The convex hull, written to `hull` (room for count + 1) without corners on straight sides. Sorts `points`. Returns
 * its number of corners. */
int32_t pv_convex_hull(pv_cell *points, int32_t count, pv_cell *hull);
