/* A volume while it is being made: voxels, where each one's value comes from, and what neighbours which. */
#pragma once

#include "solid/bank.h"

#include <pave/solid.h>

/* Planes by their normal: x (axes y, z), y (axes x, z), z (axes x, y). */
enum { PV_PLANES = 3 };
static inline int pv_plane_u(int plane) { return plane == 0; }
static inline int pv_plane_v(int plane) { return plane == 2 ? 1 : 2; }

typedef struct pv_grid {
    int32_t size[3];
    int32_t periodic;
    int32_t reach, features;
    int64_t voxels;
    int64_t *step[3];            /* step[axis][i + reach]: what coordinate i adds to a voxel's index; -1: outside */
    uint8_t *state;              /* PAVE_VOXEL_ */
    uint8_t *class;
    uint8_t *feature;            /* [voxel][features] */
    int32_t *source[PV_PLANES];  /* the position of the plane's bank that the voxel looks like; -1: none yet */
} pv_grid;

/* All voxels are free and empty, and have no sources yet: three quarters of the memory wait until they are needed. */
pave_result pv_grid_create(pave_context *context, const int32_t size[3], int32_t periodic, int32_t reach,
                           int32_t features, pv_grid *out);
pave_result pv_grid_open_sources(pave_context *context, pv_grid *grid);
void pv_grid_free(pv_grid *grid);

static inline int64_t pv_grid_at(const pv_grid *grid, int32_t x, int32_t y, int32_t z)
{
    return ((int64_t)z * grid->size[1] + y) * grid->size[0] + x;
}

/* Voxels PV_FAR apart are never of one class of a pass, unless an axis is periodic or the window is larger. */
static inline int pv_grid_lags(const pv_grid *grid)
{
    return grid->reach == 2 && !grid->periodic ? PV_LAGS : 1;
}

/* The voxel `lag` beside (x, y, z), 0..5: -x +x -y +y -z +z; -1: none. */
static inline int64_t pv_grid_towards(const pv_grid *grid, const int32_t at[3], int which, int32_t lag)
{
    int axis = which / 2;
    int32_t to = at[axis] + (which & 1 ? lag : -lag);
    if (to < -grid->reach || to >= grid->size[axis] + grid->reach)
        return -1;
    int64_t index = 0;
    for (int a = 0; a < 3; a++) {
        int64_t s = grid->step[a][(a == axis ? to : at[a]) + grid->reach];
        if (s < 0)
            return -1;
        index += s;
    }
    return index;
}

static inline int64_t pv_grid_beside(const pv_grid *grid, const int32_t at[3], int which)
{
    return pv_grid_towards(grid, at, which, 1);
}

/* Voxels whose windows the stone's surface cuts, and all others. Fewer of their neighbours have a say, so that what is
 * hard to place gathers there, unless each layer is held to the sample's histogram on its own. */
enum { PV_INNER, PV_OUTER, PV_LAYERS };
static inline int pv_grid_layer(const pv_grid *grid, const int32_t at[3])
{
    for (int i = 0; i < 6; i++) {
        int64_t other = pv_grid_towards(grid, at, i, grid->reach);
        if (other < 0 || grid->state[other] == PAVE_VOXEL_OUTSIDE)
            return PV_OUTER;
    }
    return PV_INNER;
}
