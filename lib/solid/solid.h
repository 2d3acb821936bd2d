/* Digital stones from inside. */
#pragma once

#include "base/params.h"
#include "image/image.h"

#include <pave/solid.h>

extern const pv_table pv_solid_table;

struct pave_volume {
    int32_t size[3], channels, type;
    double spacing, origin[3];
    uint8_t *values, *states;
    int32_t *cells;
    int32_t seeds;
    /* what made it, for the report; mode -1: handed in */
    pave_solid_params params;
    int32_t labels, samples;
    double use, constraint_error; /* see pave_solid_measure; NaN */
    char shape[96];
};

struct pave_mesh {
    int64_t vertex_count, triangle_count;
    double *vertices;
    int32_t *triangles;
};

/* A volume whose values and states are the caller's to fill. All limits are checked first. */
pave_result pv_volume_new(pave_context *context, const pave_volume_params *params, pave_volume **out);

/* voxelize.c: the voxels along the mesh's longest side are `resolution`; states are OUTSIDE or FREE. Says in `shape`
 * how inside was told. */
pave_result pv_voxelize(pave_context *context, const pave_mesh *mesh, int32_t resolution, pave_volume_params *place,
                        uint8_t **states, char shape[96]);

/* A value as it is stored, and back. */
double pv_volume_stored(const void *values, int32_t type, int64_t index);
void pv_volume_store(void *values, int32_t type, int64_t index, double stored);
