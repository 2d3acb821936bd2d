/* From images to texels that can be compared. */
#pragma once

#include "solid/bank.h"
#include "solid/solid.h"

enum { PV_MOST_LABELS = 8 };

/* What the samples share: how their values are stored, and how they become numbers of 0..255. */
typedef struct pv_palette {
    int32_t type, channels;  /* of the values; alpha is left out */
    int32_t features;        /* numbers that texels are compared by */
    int32_t labels;          /* different values, if there are at most 8 of one channel in whole numbers; else 0 */
    double label[PV_MOST_LABELS];
    int32_t commonest;       /* the label whose number is left out */
    double least[PV_MOST_FEATURES], most[PV_MOST_FEATURES]; /* of each channel */
    int exact;               /* the class is the value */
} pv_palette;

/* Looks at `count` images, each with the same channels and type. */
pave_result pv_palette_create(pave_context *context, const pave_image *const *images, int32_t count, pv_palette *out);

/* One stored value, all its channels, as features and class. */
void pv_palette_encode(const pv_palette *palette, const double *stored, uint8_t *feature, uint8_t *class);

/* A pixel as stored, without alpha, in the palette's type. */
void pv_palette_pixel(const pv_palette *palette, const pave_image *image, int64_t pixel, double *stored);

pave_result pv_texels_create(pave_context *context, const pv_palette *palette, const pave_image *image, pv_texels *out);
