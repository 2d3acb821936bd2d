/* Passes over the volume: who goes when, and the histograms that steer them. */
#pragma once

#include "solid/grow.h"
#include "solid/sample_device.h"

/* What makes a volume at one level. */
typedef struct pv_work {
    pave_context *context;
    pv_sampler sampler;
    pv_control control;
    pv_scratch *scratch; /* one a worker */
    pv_steps step[3][PV_LAGS];
    int32_t workers;
    pv_device *device; /* NULL: the workers do it */
    int32_t weight_class, weight_step, weight_use; /* 1/256 */
    double from, to; /* of the stage */
} pv_work;

pave_result pv_work_begin(pave_context *context, const pv_sampler *sampler, pv_work *out);
/* `result` so far; the voxels come back from where they were made, if that was well. */
pave_result pv_work_end(pv_work *work, pave_result result);

/* Counts everything afresh. */
void pv_work_count(pv_work *work);

/* Every voxel of the stone once: those whose windows do not touch together, class after class of coordinates. */
pave_result pv_work_pass(pv_work *work, double from, double to);

/* The flood's voxels, those that do not see each other together. */
pave_result pv_work_flood(pv_work *work, const pv_flood *flood, double from, double to);
