/* A drawing with one bit a pixel: how a plane is kept that is laid window by window. */
#pragma once

#include "image/image.h"

typedef struct pv_bitmap {
    int32_t width, height;
    int64_t stride; /* bytes a row */
    uint8_t *bits;  /* 1: white; the pixel on the left is the highest bit */
} pv_bitmap;

pave_result pv_bitmap_create(pave_context *context, int32_t width, int32_t height, pv_bitmap *out);
void pv_bitmap_free(pv_bitmap *bitmap);

/* Stores a drawing, or a band of its rows from `y` on. */
void pv_bitmap_store(pv_bitmap *bitmap, int32_t y, const pave_image *drawing);

/* A part of the plane as a drawing that knows its place; beyond its borders the plane repeats. */
pave_result pv_bitmap_cut(pave_context *context, const pv_bitmap *bitmap, int32_t x, int32_t y, int32_t width,
                          int32_t height, pave_image **out);

/* Names the drawing: the same for the same pixels, and for others hardly ever. Not 0. */
uint64_t pv_bitmap_hash(const pv_bitmap *bitmap);
