/* One voxel: what it should be, given its neighbours. */
#pragma once

#include "solid/grid.h"

/* What steers the statistics of the whole: how full each class, each kind of step between neighbours and each position
 * of the samples is against what it should be. The factors are frozen while voxels are made, and counted anew after. */
typedef struct pv_control {
    int64_t classes[PV_LAYERS][PV_CLASSES], steps[3][PV_LAGS][PV_STEPS]; /* along each axis */
    uint32_t class_factor[PV_LAYERS][PV_CLASSES]; /* 1/256 */
    uint32_t step_factor[3][PV_LAGS][PV_STEPS];
    double push[3][PV_LAGS][PV_STEPS]; /* by how much the steps' factors have grown */
    int32_t *uses[PV_PLANES];          /* [position]; planes with the same bank share them */
    uint16_t *use_factor[PV_PLANES];   /* [position], 1/256 */
} pv_control;

/* Changes that one worker makes to the counts. */
typedef struct pv_tally {
    int64_t classes[PV_LAYERS][PV_CLASSES], steps[3][PV_LAGS][PV_STEPS];
    int32_t *uses[PV_PLANES];
} pv_tally;

typedef struct pv_sampler {
    pv_grid *grid;
    const pv_windows *bank[PV_PLANES];
    const pv_control *control; /* NULL: none */
    uint64_t seed;
    uint32_t pass;
    int32_t temperature; /* epsilon, 1/256 */
    int32_t agree;       /* mu, 1/256: how much the value counts against the neighbourhood */
    int32_t paper;       /* exhaustive, in one plane */
    int32_t labels;      /* classes are labels */
    pv_distances *distances;
    int32_t steps;       /* the histograms of steps count */
    const pv_steps (*step)[PV_LAGS]; /* along each axis */
} pv_sampler;

/* Room for one worker. */
typedef struct pv_scratch {
    int16_t *patch[PV_PLANES], *presence[PV_PLANES];
    int32_t *distance; /* paper: [position] */
    pv_tally tally;
} pv_scratch;

pave_result pv_scratch_create(pave_context *context, const pv_sampler *sampler, pv_scratch *out);
void pv_scratch_free(pv_scratch *scratch);

/* Chooses the voxel's value and sources; of a measured voxel only the sources. Reads only voxels that are not outside
 * or free, within the window of the three planes, and the six beside it; writes this voxel and the scratch. */
void pv_sample(const pv_sampler *sampler, pv_scratch *scratch, const int32_t at[3]);
