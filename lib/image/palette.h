/* Colours of flat-coloured drawings from inside. */
#pragma once

#include "image/bitmap.h"
#include "image/pixel.h"

/* How often each colour comes, gathered pixel by pixel in any order and in any parts: the palette found is the same. */
typedef struct pv_histogram pv_histogram;

pave_result pv_histogram_create(pave_context *context, pv_histogram **out);
pave_result pv_histogram_add(pave_context *context, pv_histogram *histogram, const pave_image *image);
pave_result pv_histogram_palette(pave_context *context, const pv_histogram *histogram, int32_t colours,
                                 pave_palette *out);
void pv_histogram_free(pv_histogram *histogram);

enum { PV_WAYS = 22 * 21 / 2 }; /* with more entries there is no room for points between them */

/* What a pixel's colour is kept as in a byte: an entry of the palette, or a point on the way between two of them. */
typedef struct pv_codebook {
    int32_t entries, codes;
    pv_rgb colour[256];
    uint8_t nearest[256]; /* entry, in OKLab */
    pv_lab lab[256];      /* of the entries */
    pv_rgb way[PV_WAYS][3]; /* a quarter, a half and three quarters of b in a, mixed as light; a < b */
    pv_oklab tables;
} pv_codebook;

pave_result pv_codebook_create(pave_context *context, const pave_palette *palette, pv_codebook **out);

/* The nearest entry, in OKLab; the lower one among equals. */
uint8_t pv_nearest_entry(const pv_codebook *book, pv_rgb colour);

/* Codes of an image's pixels, each by itself; as many bytes. */
pave_result pv_encode(pave_context *context, const pv_codebook *book, const pave_image *image, uint8_t *codes);

/* The same as an image of one channel. */
pave_result pv_encode_image(pave_context *context, const pv_codebook *book, const pave_image *image, pave_image **out);

/* Codes of a plane, or of a part of it. Where a plane repeats, each period is looked at by itself. */
typedef struct pv_codes {
    int32_t width; /* of a row */
    int32_t left, top, right, bottom; /* of the period that a pixel is in, as far as there are codes of it */
    const uint8_t *code;
} pv_codes;

enum { PV_RESOLVE_REACH = 6 }; /* px around a pixel that tell its entry: 3 to others, and 3 that tell theirs */

/* The entry of the pixel at x, y of the codes, which must hold all of its period within the reach. */
uint8_t pv_resolve(const pv_codebook *book, const pv_codes *codes, int32_t x, int32_t y);

/* A part of a plane that is kept as codes, or in black and white if the palette is empty, as a drawing. */
pave_result pv_drawing_cut(pave_context *context, const pv_bitmap *bitmap, const pave_palette *palette, int32_t x,
                           int32_t y, int32_t width, int32_t height, pave_image **out);
