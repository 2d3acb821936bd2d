/* The complex steerable pyramid: a picture as bands of a scale and an orientation, each with its amplitude and phase.
 * Source: Portilla and Simoncelli 2000, "A parametric texture model based on joint statistics of complex wavelet
 * coefficients"; Simoncelli and Freeman 1995, "The steerable pyramid".
 *
 * The frame is tight: mean squares of the parts (of a band's real part) add up to the picture's, and what was taken
 * apart goes together again to the rounding of floats. The picture is taken to repeat. */
#pragma once

#include "image/fourier.h"

enum { PV_MOST_SCALES = 8, PV_MOST_ORIENTATIONS = 16 };

typedef struct pv_steerable_level {
    int32_t width, height;
    pv_fourier fourier;
    float *low;                        /* what of a spectrum goes on to the next level */
    float *band[PV_MOST_ORIENTATIONS]; /* twice that half of it which is a band's */
} pv_steerable_level;

typedef struct pv_steerable {
    int32_t scales, orientations;
    float *first_low, *first_high; /* what goes on to level 0, and the rest */
    pv_steerable_level level[PV_MOST_SCALES + 1]; /* the last one is the residual's */
} pv_steerable;

/* The parts of a picture, of their levels' sizes: as pictures or as spectra. */
typedef struct pv_pyramid {
    pv_complex *high;                    /* the highpass residual, of level 0's size */
    pv_complex *low[PV_MOST_SCALES + 1]; /* of each level, what it and all below it hold; the last: the residual */
    pv_complex *band[PV_MOST_SCALES][PV_MOST_ORIENTATIONS];
} pv_pyramid;

/* Sides that 2^scales divides. */
pave_result pv_steerable_create(pave_context *context, int32_t width, int32_t height, int32_t scales,
                                int32_t orientations, pv_steerable *out);
void pv_steerable_free(pv_steerable *steerable);

pave_result pv_pyramid_create(pave_context *context, const pv_steerable *steerable, pv_pyramid *out);
void pv_pyramid_free(pv_pyramid *pyramid);

static inline size_t pv_level_size(const pv_steerable *s, int32_t level)
{
    return (size_t)s->level[level].width * (size_t)s->level[level].height;
}

/* A level of spectra: its bands and the next low from its low; and its low from these. With `add` they are added to
 * what it holds. */
pave_result pv_steerable_split(pave_context *context, const pv_steerable *steerable, pv_pyramid *pyramid,
                               int32_t level);
pave_result pv_steerable_join(pave_context *context, const pv_steerable *steerable, pv_pyramid *pyramid, int32_t level,
                              int add);

/* A spectrum of one level at the size of the one before: twice as fine. */
void pv_steerable_expand(const pv_steerable *steerable, int32_t level, const pv_complex *spectrum, pv_complex *out);

/* The other way around: its adjoint, what of the spectrum of `level` is of the next one's size. */
void pv_steerable_shrink(const pv_steerable *steerable, int32_t level, const pv_complex *spectrum, pv_complex *out);

/* A filter, for spectra of level 0, that weighs the highpass residual, each scale and the lowpass residual. */
pave_result pv_steerable_spread(pave_context *context, const pv_steerable *steerable, const double *weights,
                                float *out);

/* A picture, less its mean, into its parts, as pictures. */
pave_result pv_steerable_analyse(pave_context *context, const pv_steerable *steerable, const float *plane, double mean,
                                 pv_pyramid *out);

/* The adjoint: a picture from parts, which are used up; with `lows`, all lows count, else only the residual. Of what
 * analysis gives, with bands made real, it is the inverse. */
pave_result pv_steerable_collect(pave_context *context, const pv_steerable *steerable, pv_pyramid *parts, int lows,
                                 float *plane);
