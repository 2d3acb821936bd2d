/* The distance field: how far each pixel of a drawing is from the nearest edge between two colours.
 * Source: Waintraub and Celes 2012, III.A. */
#ifndef PAVE_FIELD_H
#define PAVE_FIELD_H

#include <pave/image.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pave_field pave_field;

enum {
    PAVE_METRIC_CHAMFER = 0, /* quasi-Euclidean 3x3 chamfer, the paper's, in px; up to 8 % long off the axes */
    PAVE_METRIC_EUCLID = 1,  /* exact Euclidean distance from the pixel's centre to the frontier */
    PAVE_METRIC_FIGURE3 = 2  /* the numbers that Fig. 3 prints: the same chamfer with steps of 1/2 and sqrt(2)/2, so
                                that beyond the first pixel distances are half of what III.B compares with h */
};

typedef struct pave_field_params {
    size_t size;
    int32_t metric;   /* PAVE_METRIC_ */
    int32_t periodic; /* 1: the drawing repeats in x and y for ever: what lies beyond its right border is its left part.
                         So do the field, and the diagram and the stones that are made of it: they tile seamlessly */
} pave_field_params;

#define PAVE_FIELD_PARAMS_INIT { sizeof(pave_field_params), PAVE_METRIC_CHAMFER, 0 }

PAVE_API void pave_field_params_init(pave_field_params *params, size_t size);

/* `drawing` has one PAVE_U8 channel (see pave_image_threshold); two pixels of different value have an edge between
 * them. A pixel beside an edge is 0.5 from it, a pixel that only touches one by a corner sqrt(2)/2. Distances grow
 * in steps of 2^-16 px, and from 32767 px on, or without any edge, are infinite. Cost: linear, 8 bytes a pixel. */
PAVE_API pave_result pave_field_create(pave_context *context, const pave_image *drawing,
                                       const pave_field_params *params, pave_field **out);
PAVE_API void pave_field_free(pave_field **field);

PAVE_API int32_t pave_field_width(const pave_field *field);
PAVE_API int32_t pave_field_height(const pave_field *field);

/* Distances in px, row by row from the top. */
PAVE_API const float *pave_field_distance(const pave_field *field);

/* Sobel gradient (Eq. 2) divided by 8, so that it is the change of distance per px, at every pixel. x grows to the
 * right and y grows DOWN, as rows do; outside a drawing that does not repeat is its border pixel; where the distance is
 * infinite the gradient is 0. `x` and `y` are the caller's, width*height floats each. Cost: one pass. */
PAVE_API void pave_field_gradient(const pave_field *field, float *x, float *y);

/* The field as an image of three PAVE_F32 channels: distance, gradient.x, gradient.y. */
PAVE_API pave_result pave_field_image(pave_context *context, const pave_field *field, pave_image **out);

#ifdef __cplusplus
}
#endif

#endif
