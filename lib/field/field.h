/* The distance field from inside. While it is computed, distances are integers in 1/65536 px. */
#pragma once

#include "base/params.h"
#include "image/image.h"

#include <pave/field.h>

extern const pv_table pv_field_table;

enum { PV_FIELD_ONE = 65536 };
#define PV_FIELD_FAR INT32_MAX /* saturation: 32767 px and beyond, or no edge at all */

struct pave_field {
    int32_t width, height;
    pv_place place;
    int32_t wraps; /* it is the whole of a plane that repeats */
    float *distance;
    pave_field_params params;
};

/* A part of the plane, wherever it lies, from a field that wraps. */
pave_result pv_field_repeat(pave_context *context, const pave_field *field, int32_t x, int32_t y, int32_t width,
                            int32_t height, pave_field **out);

/* refine.c: the field of the same plane with `scale` pixels to one along a side. */
pave_result pv_field_refine(pave_context *context, const pave_field *field, int32_t scale, pave_field **out);

/* A drawing's pixels with their size. */
typedef struct pv_drawing {
    int32_t width, height;
    const uint8_t *pixels;
    int32_t wraps; /* its borders meet */
} pv_drawing;

/* Rows that make a task of about a millisecond, and how many such tasks there are. */
static inline int32_t pv_band_rows(int32_t width)
{
    return (1 << 18) / width + 1;
}

static inline int32_t pv_bands(int32_t width, int32_t height)
{
    return (height - 1) / pv_band_rows(width) + 1;
}

/* edges.c: writes 0.5 or sqrt(2)/2 where a pixel of row y has a neighbour of another colour, PV_FIELD_FAR elsewhere. */
void pv_edge_row(const pv_drawing *drawing, int32_t y, int32_t *distance);

/* Lengths of a chamfer transform's steps, in 1/65536 px. */
typedef struct pv_steps {
    int32_t straight, diagonal;
} pv_steps;

/* chamfer.c: spreads those by the quasi-Euclidean 3x3 chamfer transform. */
pave_result pv_chamfer(pave_context *context, const pv_drawing *drawing, pv_steps steps, int32_t *distance);

/* euclid.c: the exact distance to the frontier instead. */
pave_result pv_euclid(pave_context *context, const pv_drawing *drawing, int32_t *distance);

/* gradient.c: Sobel over 8 at one pixel, image rows going down. */
void pv_gradient(const pave_field *field, int32_t x, int32_t y, float *gx, float *gy);
