/* The joint statistics of a texture as planes: measured, compared, and imposed on others.
 * Source: Portilla and Simoncelli 2000, "A parametric texture model based on joint statistics of complex wavelet
 * coefficients". docs/papers.md says what differs. */
#pragma once

#include "base/context.h"

typedef struct pv_statistics pv_statistics;

typedef struct pv_statistics_settings {
    int32_t scales, orientations; /* of the pyramid, 1..8 and 2..16 */
    int32_t neighbourhood;        /* side of the square of lags, odd, 3..15 */
    int32_t cross;                /* 0: each channel by itself; 1: with the covariances of their pixels;
                                     2: and of the magnitudes of their bands */
} pv_statistics_settings;

/* Of channels as planes of width x height. What of them does not divide by 2^scales is left out, half on each side;
 * each side must have 4 * 2^scales px. */
pave_result pv_statistics_measure(pave_context *context, int32_t width, int32_t height, int32_t channels,
                                  const float *planes, const pv_statistics_settings *settings, pv_statistics **out);

/* In place, `iterations` rounds; progress from..to. The planes may be of another size than those measured. Up to 10
 * rounds are the paper's, some 0.1 s for 256 x 256 px and a channel; of more, the last three fifths are joint steps,
 * some 20 times as long, which end when each group is within half a per cent. */
pave_result pv_statistics_impose(pave_context *context, const pv_statistics *wanted, int32_t width, int32_t height,
                                 float *planes, int32_t iterations, double from, double to);

/* Relative distance, 0: equal: the worst of the groups, by the lags that both know; infinity for other channels, scales
 * or orientations. */
double pv_statistics_distance(const pv_statistics *a, const pv_statistics *b);
void pv_statistics_free(pv_statistics *statistics);
