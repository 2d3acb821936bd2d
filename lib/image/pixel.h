/* Pixels of any image as colours for display. */
#pragma once

#include "image/image.h"
#include "util/oklab.h"

typedef struct pv_pixels_of {
    const pave_image *image;
    int32_t red, green, blue; /* channels; the same for grey */
    double full;              /* the value that stands for white */
    int32_t plain;            /* bytes for display, without alpha */
} pv_pixels_of;

pv_pixels_of pv_pixels_begin(const pave_image *image);

/* Display values r, g, b of a pixel, laid over white by its alpha; 0..1 where the image keeps to it. */
void pv_pixel_values(const pv_pixels_of *pixels, int64_t at, double values[3]);

/* The same in whole numbers. NaN becomes 0. */
pv_rgb pv_pixel_rgb(const pv_pixels_of *pixels, int64_t at);
