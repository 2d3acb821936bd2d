/* Windows: how far a step carries something, and the region that a window needs.
 *
 * Let all sites deeper than `margin` inside the region be what they are in the whole plane, and no pixel as deep be
 * farther than `radius` from its site; nearer to the border, where sites are missing, it may be. A pixel's label
 * depends on the sites within `radius` of it, so labels are right from margin + radius on. A site's cell lies within
 * `radius` of it: were a pixel farther off its own, the way there would cross pixels whose sites are nearer. So sites
 * that lie deeper than margin + 2 radius move as they do in the whole.
 * After the move, those deeper by another `radius` and the push (or by a lattice cell, if they were drawn again) are
 * known to have been among them: a site cannot have got there from farther out, for then it would own a right pixel
 * farther than `radius` away. Where a relaxation takes sites past their centroid or keeps them short of it, they end
 * no farther than a lattice cell from it, so that the cell is added: its centroid is still that deep. */
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

/* As measured: in step i no pixel is farther from a box than 1.6 + 2.4 / (1 + i) half sides. */
int32_t pv_margin_guess(const pave_cvd_params *params)
{
    double reach = params->cap * sqrt(params->scale_max * params->scale_max + 1), sum = 2 * reach + 6;
    for (int32_t i = 0; i < params->iterations; i++)
        sum += 3 * (reach + 1.6 + 2.4 / (1 + i)) + params->push_to + 0.5 + (params->relaxation != 1 ? 2 : 0);
    double guess = params->half_side * sum + params->iterations * 2;
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
