/* The last step: the volume's histogram becomes the sample's. */
#pragma once

#include "solid/grid.h"

/* For each free voxel, filled by now, the rank that its value should have among `count` of them, by value, then by the
 * mean around it, then by chance; ranks[voxel], others untouched. `count` is told. */
pave_result pv_match_ranks(pave_context *context, const pv_grid *grid, uint64_t seed, uint32_t *ranks, int64_t *count);
