/* The distance that decides to which site a pixel belongs. The C twin of shaders/metric.glsl.
 *
 * u = (dx*C + dy*S + 2^15) >> 16 and v = (dy*C - dx*S + 2^15) >> 16 are the point less the site, turned into the box's
 * frame; d2 = max(|u|-A, 0)^2 + max(|v|-B, 0)^2. Everything is in 1/256 px. */
#pragma once

#include <pave/cvd.h>

static inline uint64_t pv_metric(const pave_site *site, int32_t x, int32_t y)
{
    int64_t dx = (int64_t)x - site->x, dy = (int64_t)y - site->y;
    int64_t u = (dx * site->cosine + dy * site->sine + 32768) >> 16;
    int64_t v = (dy * site->cosine - dx * site->sine + 32768) >> 16;
    u = (u < 0 ? -u : u) - site->half_x;
    v = (v < 0 ? -v : v) - site->half_y;
    u = u > 0 ? u : 0;
    v = v > 0 ? v : 0;
    return (uint64_t)(u * u) + (uint64_t)(v * v);
}

/* Where |p - s| < 127 px, 32 bits hold every intermediate value: the fast paths may use them. */
enum { PV_METRIC_NARROW = 127 * 256 };

/* The computed distance is within PV_METRIC_SLACK of the true one for points up to 127 px from the site, and within a
 * further 2^-14 of the way for others: u and v are each rounded (by 1/2), and turned by a C and S that are 2^-16 off
 * (by 127*256 * 2^-16), which makes less than 1.5 together. */
enum { PV_METRIC_SLACK = 2 };
