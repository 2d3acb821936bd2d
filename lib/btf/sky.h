/* Light from all around, coarse. */
#pragma once

#include "btf/btf.h"

typedef struct pv_sky {
    double *radiance; /* [row][column][channel], the zenith (y) first */
    double *share;    /* of the hemisphere that each light direction of the BTF stands for, steradian */
    int32_t channels;
} pv_sky;

/* From a picture of all directions, latitude by longitude. To be closed in any case. */
pave_result pv_sky_open(pave_context *context, const pave_btf *btf, const pave_image *image, pv_sky *out);
void pv_sky_close(pv_sky *sky);

/* What comes from a direction, for each channel. */
void pv_sky_look(const pv_sky *sky, const double direction[3], double *out);
