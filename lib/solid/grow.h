/* The order in which a stone grows from its seeds. */
#pragma once

#include "solid/grid.h"

/* Free voxels in the order that a priority flood from all seeds at once reaches them (4.1.1), regrouped: voxels of a
 * level do not see each other, and each sees only voxels before it, as in the strict order. */
typedef struct pv_flood {
    int64_t count;
    uint32_t *order;
    int64_t *level; /* where each level begins; levels + 1 */
    int32_t levels;
    int32_t *cells; /* the seed of each voxel, -1: outside */
    int32_t seeds;
} pv_flood;

/* `seeds` random ones where nothing is measured, and one more in each part that no seed reaches. */
pave_result pv_flood_create(pave_context *context, const pv_grid *grid, int32_t seeds, uint64_t seed, pv_flood *out);
void pv_flood_free(pv_flood *flood);
