/* The distance that decides to which site a pixel belongs. The C twin of shaders/metric.glsl.
 *
 * u = (dx*C + dy*S + 2^15) >> 16 and v = (dy*C - dx*S + 2^15) >> 16 are the point less the site, turned into the box's
 * frame. The squared distance d2 is
 *   from a box:                  max(|u|-A, 0)^2 + max(|v|-B, 0)^2, in 1/256 px;
 *   on a pyramid over a square:  max(|u|*A >> 16, |v|*B >> 16)^2;
 *   on one over a rhombus:       ((|u|*A >> 16) + (|v|*B >> 16))^2. */
#pragma once

#include <pave/cvd.h>

static inline uint64_t pv_metric(int32_t metric, const pave_site *site, int32_t x, int32_t y)
{
    int64_t dx = (int64_t)x - site->x, dy = (int64_t)y - site->y;
    int64_t u = (dx * site->cosine + dy * site->sine + 32768) >> 16;
    int64_t v = (dy * site->cosine - dx * site->sine + 32768) >> 16;
    u = u < 0 ? -u : u;
    v = v < 0 ? -v : v;
    if (metric == PAVE_METRIC_BOX) {
        u = u > site->half_x ? u - site->half_x : 0;
        v = v > site->half_y ? v - site->half_y : 0;
        return (uint64_t)(u * u) + (uint64_t)(v * v);
    }
    u = u * site->half_x >> 16;
    v = v * site->half_y >> 16;
    u = metric == PAVE_METRIC_DIAMOND ? u + v : u > v ? u : v;
    return (uint64_t)(u * u);
}

/* Where |p - s| < 127 px, 32 bits hold every intermediate value: the fast paths may use them. */
enum { PV_METRIC_NARROW = 127 * 256 };

/* The computed distance is within PV_METRIC_SLACK of the true one for points up to 127 px from the site, and within a
 * further 2^-14 of the way for others: u and v are each rounded (by 1/2), and turned by a C and S that are 2^-16 off
 * (by 127*256 * 2^-16), which makes less than 1.5 together; on pyramids each is cut once more (by 1). */
enum { PV_METRIC_SLACK = 4 };
