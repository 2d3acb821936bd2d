/* Blending on a graphics device: weighted sums of samples, many of them for each pixel of a picture. */
#pragma once

#include "btf/btf.h"

enum { PV_BLEND_CHANNELS = 3 };

/* A sample of a BTF, and what each channel of it counts. */
typedef struct pv_term {
    int32_t texel, pair;
    float weight[PV_BLEND_CHANNELS];
} pv_term;

typedef struct pv_blender pv_blender;

/* For so many pixels at a time, of at most `most` terms each. PAVE_ERR_UNSUPPORTED if the BTF is not factored or has
 * more channels; PAVE_ERR_DEVICE if there is no device. */
pave_result pv_blender_open(pave_context *context, const pave_btf *btf, int32_t pixels, int32_t most, pv_blender **out);
void pv_blender_close(pv_blender *blender);

/* Pixel i has the first counts[i] of the terms from i * most on; its sums are PV_BLEND_CHANNELS numbers. */
pave_result pv_blender_run(pv_blender *blender, const pv_term *terms, const int32_t *counts, int32_t pixels,
                           float *sums);
