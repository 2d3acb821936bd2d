/* The volume while it is being made: storage. */
#include "solid/grid.h"

#include <string.h>

static pave_result make_steps(pave_context *context, pv_grid *grid)
{
    pave_result result = PAVE_OK;
    int64_t stride = 1;
    for (int a = 0; a < 3 && !result; a++) {
        int32_t n = grid->size[a], all = n + 2 * grid->reach;
        grid->step[a] = pv_allocate(context, (size_t)all, sizeof *grid->step[a], &result);
        for (int32_t i = 0; i < all && !result; i++) {
            int32_t at = i - grid->reach, wrapped = (at % n + n) % n;
            grid->step[a][i] = at == wrapped || grid->periodic ? wrapped * stride : -1;
        }
        stride *= n;
    }
    return result;
}

pave_result pv_grid_create(pave_context *context, const int32_t size[3], int32_t periodic, int32_t reach,
                           int32_t features, pv_grid *grid)
{
    memset(grid, 0, sizeof *grid);
    memcpy(grid->size, size, sizeof grid->size);
    grid->periodic = periodic;
    grid->reach = reach;
    grid->features = features;
    grid->voxels = (int64_t)size[0] * size[1] * size[2];
    size_t n = (size_t)grid->voxels;
    pave_result result = make_steps(context, grid);
    grid->state = result ? NULL : pv_allocate(context, n, 1, &result);
    grid->class = result ? NULL : pv_allocate_zeroed(context, n, 1, &result);
    grid->feature = result ? NULL : pv_allocate_zeroed(context, n, (size_t)features, &result);
    if (!result)
        memset(grid->state, PAVE_VOXEL_FREE, n);
    return result;
}

pave_result pv_grid_open_sources(pave_context *context, pv_grid *grid)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)grid->voxels;
    for (int p = 0; p < PV_PLANES && !result; p++) {
        grid->source[p] = pv_allocate(context, n, sizeof *grid->source[p], &result);
        if (!result)
            memset(grid->source[p], -1, n * sizeof *grid->source[p]);
    }
    return result;
}

void pv_grid_free(pv_grid *grid)
{
    for (int a = 0; a < 3; a++) {
        pv_release(grid->step[a]);
        pv_release(grid->source[a]);
    }
    pv_release(grid->state);
    pv_release(grid->class);
    pv_release(grid->feature);
    memset(grid, 0, sizeof *grid);
}
