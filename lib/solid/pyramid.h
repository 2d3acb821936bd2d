/* Coarse structure first: the sample and the volume at several levels. */
#pragma once

#include "solid/control.h"

enum { PV_MOST_LEVELS = 6 };

/* How one level is made. */
typedef struct pv_recipe {
    int32_t passes, hot, cold; /* temperature of the first and the last pass, 1/256 */
    int32_t weight_class, weight_step, weight_use, agree;
} pv_recipe;

typedef struct pv_pyramid {
    int32_t levels, same; /* same: one sample for all planes */
    int32_t side, labels;
    double sigma;
    uint64_t seed;
    pv_texels texels[PV_MOST_LEVELS][PV_PLANES]; /* [0]: the full level */
    pv_recipe recipe[PV_MOST_LEVELS];
} pv_pyramid;

/* Fills the full level's free voxels. */
pave_result pv_pyramid_run(pave_context *context, pv_pyramid *pyramid, pv_grid *grid);
