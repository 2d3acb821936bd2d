/* Windows: how far a step carries something, and the region that a window needs.
 *
 * Let all sites deeper than m inside the region be what they are in the whole plane, and R be no less than the distance
 * from any pixel deeper than m + R to its site (of the metric, plus the farthest corner of a box). Nearer to the
 * border, where sites are missing, and beyond it there may be any.
 * Labels. A pixel deeper than m + R has no rival farther than R, so that its label is right.
 * Cells. The metric is the distance to a box: on the straight way from a pixel to the box of its site that site gets
 * nearer as fast as can be, and no rival overtakes it. Were a pixel farther than R from its site, and that deeper than
 * m + 2R, the way would lead through right pixels as far off. So the cell is right, and moves the site rightly.
 * Nobody else comes as deep. Let c, the centroid of the cell of s in the whole plane or in the region, be deeper than
 * m + 3R, and suppose |c - s| > R. Look along u, from s to c. A pixel p of the cell within 2R of c is right, |p - s| is
 * no more than R, and p lies short of c. For any other let x be the point 2R from c towards p: it has a site within R,
 * which is no farther from p than |p - x| + R = |p - c| - R; s is nearer still, so that p is nearer to s than to c and
 * lies short of c, too. All pixels would lie short of their mean. So |c - s| <= R, s was deeper than m + 2R, and it was
 * right. (This holds at corners of the region as well, around which cells beyond its borders may reach.)
 * Then sites are pushed, or drawn again in a lattice cell; a relaxation takes them no farther than a lattice cell from
 * their centroid. ROUNDING is for pixels that do not lie where they should. */
#include "cvd/cvd.h"

#include <math.h>

enum { ROUNDING = 512 };

int32_t pv_margin_after(const pv_plane *plane, int32_t margin, int32_t radius)
{
    int32_t back = plane->push_within - plane->push_to, push = plane->push_to > back ? plane->push_to : back;
    int64_t past = plane->excess ? plane->cell : 0, move = radius + past + push, again = plane->cell + plane->cell / 2;
    int64_t after = margin + 2 * (int64_t)radius + (move > again ? move : again) + ROUNDING;
    return after < INT32_MAX / 2 ? (int32_t)after : INT32_MAX / 2;
}

int32_t pv_most_reach(const pave_cvd_params *params)
{
    double extent = 256 * params->cap * params->half_side;
    return (int32_t)(extent * sqrt(params->scale_max * params->scale_max + 1)) + 3;
}

/* As measured: in step i no pixel is farther from a box than 1.6 + 2.4 / (1 + i) half sides. */
int32_t pv_margin_guess(const pave_cvd_params *params, int32_t step)
{
    double reach = params->cap * sqrt(params->scale_max * params->scale_max + 1), sum = 2 * reach + 6;
    for (int32_t i = step; i < params->iterations; i++)
        sum += 3 * (reach + 1.6 + 2.4 / (1 + i)) + params->push_to + 0.5 + (params->relaxation != 1 ? 2 : 0);
    double guess = params->half_side * sum + (params->iterations - step) * 2;
    return guess < 1 << 20 ? (int32_t)guess : 1 << 20;
}

static int32_t least(int64_t a, int64_t b)
{
    return (int32_t)(a < b ? a : b);
}

static int32_t most(int64_t a, int64_t b)
{
    return (int32_t)(a > b ? a : b);
}

pv_rect pv_rect_grown(pv_rect window, int32_t margin, pv_rect bounds)
{
    pv_rect r = { most((int64_t)window.x - margin, bounds.x), most((int64_t)window.y - margin, bounds.y), 0, 0 };
    r.width = least((int64_t)window.x + window.width + margin, (int64_t)bounds.x + bounds.width) - r.x;
    r.height = least((int64_t)window.y + window.height + margin, (int64_t)bounds.y + bounds.height) - r.y;
    return r;
}

int32_t pv_rect_room(pv_rect window, pv_rect region, const pave_cvd *plane)
{
    int32_t room = INT32_MAX, width = plane->place.width, height = plane->place.height;
    if (region.x > 0 || plane->repeats)
        room = least(room, window.x - region.x);
    if (region.y > 0 || plane->repeats)
        room = least(room, window.y - region.y);
    if (region.x + region.width < width || plane->repeats)
        room = least(room, region.x + region.width - window.x - window.width);
    if (region.y + region.height < height || plane->repeats)
        room = least(room, region.y + region.height - window.y - window.height);
    return room;
}
