/* What faces are cut from: blocks of stone. A texture is a block one voxel thick. */
#pragma once

#include "base/context.h"

#include <pave/image.h>
#include <pave/solid.h>

typedef struct pv_quarry {
    int32_t size[3];     /* voxels */
    int32_t channels;    /* of a voxel, */
    int32_t colour[3];   /* and which of them are red, green and blue */
    int32_t type, coded; /* coded: floats are display values */
    int32_t mirrors[3];  /* beyond its border is its mirror image, else its other side */
    const void *values;
    float *light;   /* linear light of whole numbers; NULL for floats */
    double mean[3], deviation[3]; /* linear light */
    double seam[3]; /* across the border / between neighbours: mean differences along each axis */
} pv_quarry;

/* `what` begins the sentence of a failure: "texture 1". */
pave_result pv_quarry_of_image(pave_context *context, const pave_image *image, const char *what, pv_quarry *out);
pave_result pv_quarry_of_volume(pave_context *context, const pave_volume *volume, const char *what, pv_quarry *out);
void pv_quarry_free(pv_quarry *block);

/* Linear light at a place, in voxels from the first one's centre; between voxels mixed by how near they are. */
void pv_quarry_at(const pv_quarry *block, const double place[3], double light[3]);
