/* Sampling voxels on a graphics device: the same bytes as by sample.c. */
#pragma once

#include "solid/sample.h"

typedef struct pv_device pv_device;

/* Where the voxels that are done together lie: coordinates first + i * every, i below count. */
typedef struct pv_lane { int32_t first, every, count; } pv_lane;

/* Opens a device and brings the grid and the banks there. */
pave_result pv_device_open(pave_context *context, const pv_sampler *sampler, pv_device **out);
void pv_device_close(pv_device *device);

/* As the sampler has it now; `order` or lanes say which voxels. */
pave_result pv_device_lanes(pv_device *device, const pv_sampler *sampler, const pv_lane lanes[3]);
pave_result pv_device_order(pv_device *device, const pv_sampler *sampler, const uint32_t *order, int64_t count);

/* The factors go there; the changes of the counts come back, and begin anew. */
pave_result pv_device_steer(pv_device *device, const pv_sampler *sampler, const pv_control *control);
pave_result pv_device_settle(pv_device *device, const pv_sampler *sampler, pv_control *control);

/* Brings the voxels back. */
pave_result pv_device_fetch(pv_device *device, const pv_sampler *sampler);
