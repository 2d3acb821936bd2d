/* Surfaces: what a px of the maps holds of a stone and of the joints. */
#include "maps/maps.h"

#include "util/noise.h"
#include "util/random.h"

#include <math.h>

enum { WAVES = 2 };

/* Squared distance from the origin to the side a b. */
static double to_side(double ax, double ay, double bx, double by)
{
    double dx = bx - ax, dy = by - ay, length = dx * dx + dy * dy, t = -(ax * dx + ay * dy);
    t = length > 0 ? pv_clamped(t / length, 0, 1) : 0;
    double x = ax + t * dx, y = ay + t * dy;
    return x * x + y * y;
}

/* Does a ray from p to the right cross the side? Of two stones that meet at a side just one has what lies on it. */
static int crosses(pv_cell a, pv_cell b, int64_t x, int64_t y)
{
    if ((a.y <= y) == (b.y <= y))
        return 0;
    int64_t turn = (b.x - (int64_t)a.x) * (y - a.y) - (b.y - (int64_t)a.y) * (x - a.x);
    return b.y > a.y ? turn > 0 : turn < 0;
}

/* The integral from 0 to x of what is beyond 0, but no more than 1. */
static double beyond(double x)
{
    return x <= 0 ? 0 : x >= 1 ? x - 0.5 : x * x / 2;
}

/* What is left of a side, within the square 0..1, signed by the way that the side goes. */
static double left_of(double ax, double ay, double bx, double by)
{
    double top = pv_clamped(ay, 0, 1), bottom = pv_clamped(by, 0, 1);
    if (top == bottom)
        return 0;
    double slope = (bx - ax) / (by - ay), from = ax + (top - ay) * slope, to = ax + (bottom - ay) * slope;
    double mean = from == to ? pv_clamped(from, 0, 1) : (beyond(to) - beyond(from)) / (to - from);
    return (bottom - top) * mean;
}

/* The stone's sides around a px whose corner is the origin. */
typedef struct around {
    const pv_cell *ring;
    int32_t corners;
    int64_t left, top;
} around;

static void side(const around *a, int32_t i, double out[4])
{
    pv_cell p = a->ring[i], q = a->ring[i + 1 < a->corners ? i + 1 : 0];
    const double grid = PV_MAP_GRID;
    out[0] = (double)(p.x - a->left) / grid;
    out[1] = (double)(p.y - a->top) / grid;
    out[2] = (double)(q.x - a->left) / grid;
    out[3] = (double)(q.y - a->top) / grid;
}

static double area_of(const around *a)
{
    double area = 0, s[4];
    for (int32_t i = 0; i < a->corners; i++) {
        side(a, i, s);
        area += left_of(s[0], s[1], s[2], s[3]);
    }
    return pv_clamped(fabs(area), 0, 1);
}

pv_cover pv_stone_cover(const pv_bed *bed, const pv_laid *laid, int32_t x, int32_t y)
{
    const around a = { bed->corner + laid->first, laid->corners, (int64_t)x * PV_MAP_GRID, (int64_t)y * PV_MAP_GRID };
    double near = INFINITY, s[4];
    int inside = 0;
    for (int32_t i = 0; i < a.corners; i++) {
        side(&a, i, s);
        double far = to_side(s[0] - 0.5, s[1] - 0.5, s[2] - 0.5, s[3] - 0.5);
        near = far < near ? far : near;
        inside ^= crosses(a.ring[i], a.ring[i + 1 < a.corners ? i + 1 : 0], a.left + PV_MAP_GRID / 2,
                          a.top + PV_MAP_GRID / 2);
    }
    return (pv_cover){ near > 0.5 ? inside : area_of(&a), inside, inside ? sqrt(near) : -sqrt(near) };
}

double pv_bevel_drop(double bevel, double inset)
{
    if (inset >= bevel || bevel <= 0)
        return 0;
    double left = inset > 0 ? bevel - inset : bevel;
    return bevel - sqrt(bevel * bevel - left * left);
}

double pv_stone_plane(const pv_bed *bed, const pv_laid *laid, double x, double y)
{
    return laid->lift + (laid->slope[0] * (x - laid->middle[0]) + laid->slope[1] * (y - laid->middle[1])) / bed->scale;
}

pv_patch pv_stone_patch(const pv_bed *bed, int32_t x, int32_t y, double inset)
{
    double drop = pv_bevel_drop(bed->bevel, inset / bed->scale);
    return (pv_patch){ { x + 0.5, y + 0.5, drop }, { 1, 0, 0 }, { 0, 1, 0 } };
}

double pv_stone_surface(const pv_bed *bed, const pv_laid *laid, const pv_patch *patch, double light[3])
{
    double relief = pv_face_light(bed, laid, patch, light);
    double z = pv_stone_plane(bed, laid, patch->at[0], patch->at[1]) - patch->at[2] + bed->relief * relief;
    return z > -bed->depth ? z : -bed->depth;
}

/* Sand: two waves of noise in the plane, -1..1. */
static double sand(const pv_bed *bed, int64_t x, int64_t y)
{
    static const double wave[WAVES] = { 0.5, 0.15 }; /* h */
    const pave_stones *stones = bed->stones;
    int32_t repeats = stones->field.periodic ? 256 : 0;
    double sum = 0;
    for (uint32_t i = 0; i < WAVES; i++) {
        pv_noise_cell cell = { 0 };
        int32_t length = (int32_t)(256 * wave[i] * bed->half_side);
        length = length > 1 ? length : 1;
        pv_lattice across = pv_lattice_of(length, repeats * stones->plane_width);
        pv_lattice down = pv_lattice_of(length, repeats * stones->plane_height);
        uint32_t key = pv_draw(bed->params.seed, PV_DRAW_SAND, i, 0, 0).word[0];
        sum += pv_noise(&cell, key, &across, &down, (int32_t)floor(((double)x + 0.5) * 256 / bed->scale),
                        (int32_t)floor(((double)y + 0.5) * 256 / bed->scale));
    }
    return sum / (WAVES * 65536.0);
}

/* A texture lies from the plane's origin on. */
static void joint_light(const pv_bed *bed, int64_t x, int64_t y, double light[3])
{
    int32_t n = bed->samples;
    double ratio = bed->texels / bed->scale, part[3], sum[3] = { 0, 0, 0 };
    for (int32_t i = 0; i < n * n; i++) {
        const double place[3] = { ((double)x + (i % n + 0.5) / n) * ratio - 0.5,
                                  ((double)y + (i / n + 0.5) / n) * ratio - 0.5, 0 };
        pv_quarry_at(&bed->joint, place, part);
        for (int c = 0; c < 3; c++)
            sum[c] += part[c];
    }
    for (int c = 0; c < 3; c++)
        light[c] = n == 1 ? sum[c] : sum[c] / (n * n);
}

double pv_joint_surface(const pv_bed *bed, int64_t x, int64_t y, double light[3])
{
    const pave_stones *stones = bed->stones;
    if (stones->field.periodic) {
        int64_t across = llround(stones->plane_width * bed->scale), down = llround(stones->plane_height * bed->scale);
        x = x % across + (x % across < 0 ? across : 0);
        y = y % down + (y % down < 0 ? down : 0);
    }
    double grain = bed->sand > 0 ? sand(bed, x, y) : 0;
    if (bed->joint.values)
        joint_light(bed, x, y, light);
    else
        for (int c = 0; c < 3; c++)
            light[c] = bed->joint_paint[c] * (1 + pv_clamped(6 * bed->params.joint_sand, 0, 0.5) * grain);
    return -bed->depth + bed->sand * grain;
}
