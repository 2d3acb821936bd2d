/* A drawing with one bit a pixel, or with a byte if it has a palette or was made from greys: how a plane is kept that
 * is laid window by window. */
#pragma once

#include "image/image.h"

typedef struct pv_bitmap {
    int32_t width, height;
    int32_t depth;  /* bits a pixel, 1 or 8 */
    int32_t cut;    /* bytes are levels, see image.h; 0: they are codes */
    int64_t stride; /* bytes a row */
    uint8_t *bits;  /* 1: white; the pixel on the left is the highest bit */
    int file;       /* instead of `bits`, if that is NULL: row after row */
} pv_bitmap;

/* All black, or 0. In a file, which is then the bitmap's and closed with it, the rows must be put first. */
pave_result pv_bitmap_create(pave_context *context, int32_t width, int32_t height, int32_t depth, pv_bitmap *out);
pave_result pv_bitmap_create_in(pave_context *context, int32_t width, int32_t height, int32_t depth, int file,
                                pv_bitmap *out);
void pv_bitmap_free(pv_bitmap *bitmap);

/* Stores a drawing, or a part of it, in a bitmap in memory that is black there. */
void pv_bitmap_store(pv_bitmap *bitmap, int32_t x, int32_t y, const pave_image *drawing);

/* Puts a band of rows, which is in memory, into a bitmap of the same width. */
pave_result pv_bitmap_put(pave_context *context, pv_bitmap *bitmap, int32_t y, const pv_bitmap *band);

/* Puts the first rows of one with a bit a pixel into one of levels. */
pave_result pv_bitmap_deepen(pave_context *context, const pv_bitmap *bitmap, int32_t rows, pv_bitmap *out);

/* A part of the plane as a drawing that knows its place; beyond its borders the plane repeats. */
pave_result pv_bitmap_cut(pave_context *context, const pv_bitmap *bitmap, int32_t x, int32_t y, int32_t width,
                          int32_t height, pave_image **out);

/* Names the drawing: the same for the same pixels, and for others hardly ever. Not 0. */
pave_result pv_bitmap_hash(pave_context *context, const pv_bitmap *bitmap, uint64_t *out);
