/* The statistics of an image: those of its channels along the principal axes of its colours. */
#pragma once

#include <pave/statistics.h>

#include "image/image.h"
#include "statistics/texture.h"

extern const pv_table pv_statistics_table, pv_statistics_synthesis_table;

struct pave_statistics {
    pave_statistics_params params;
    pave_image image; /* what it was, without its pixels */
    int32_t channels; /* without alpha */
    int32_t rank;     /* axes along which there is more than rounding: a grey picture stored as RGB has one */
    double mean[PV_MOST_CHANNELS], least[PV_MOST_CHANNELS], greatest[PV_MOST_CHANNELS];
    double axes[PV_MOST_CHANNELS * PV_MOST_CHANNELS]; /* one in each row */
    pv_statistics *values;
};
