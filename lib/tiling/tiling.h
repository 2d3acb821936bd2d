/* Tilings from inside: exemplars as they are compared, the canvas, and the steps of all modes. */
#pragma once

#include "base/params.h"
#include "image/image.h"
#include "tiling/bank.h"

#include <pave/tiling.h>

extern const pv_table pv_tiling_table;

/* What is laid so far: for every pixel the place in the bank that it comes from. */
typedef struct pv_canvas {
    const pv_bank *bank;
    int32_t width, height;
    int32_t wrap_x, wrap_y; /* the right side adjoins the left one, the bottom the top */
    int32_t *source;        /* PV_NOTHING: not laid yet */
    uint8_t *fixed;         /* pixels that must stay; NULL: none */
    const int16_t *guide;   /* brightness wanted; NULL: any */
} pv_canvas;

enum { PV_NOTHING = -1 };

/* A part of the canvas, px. */
typedef struct pv_area { int32_t x, y, width, height; } pv_area;

/* A block of mode paper: its place in the result, and in the bank. */
typedef struct pv_block {
    int32_t x, y, width, height, source;
    pave_source from;          /* of its first pixel, and */
    int32_t right[2], down[2]; /* how x and y change there to the right and down */
} pv_block;

/* guide.c: what brightness a guide asks for, pixel by pixel: its own, put through a curve that gives it the exemplars'
 * distribution. `tones` is the caller's to release. */
pave_result pv_guide_read(pave_context *context, const pv_bank *bank, const pave_image *guide, int16_t **tones);

/* A picture that is judged, as 0..255 of three channels. */
typedef struct pv_picture {
    int32_t width, height;
    float *rgb;
} pv_picture;

/* sliced.c: of patches of 7 x 7 px; 0 where a picture has none. */
pave_result pv_sliced_distance(pave_context *context, const pv_picture *a, const pv_picture *b, double *distance);

/* repeat.c: the highest peak of the circular autocorrelation of a picture's brightness, less its slow part, beyond
 * 16 px. */
pave_result pv_fft_repeat(pave_context *context, const float *rgb, int32_t width, int32_t height, double *repeat);

struct pave_tiling {
    pave_tiling_params params;
    int32_t width, height;
    int32_t exemplars;
    int32_t (*sizes)[2]; /* of the exemplars */
    pave_source *sources;
    pv_block *blocks; /* mode paper */
    int32_t block_count;
    pave_wang_tile *tiles;
    int32_t tile_count, tile_width, tile_height;
    double feature, seconds;
};
