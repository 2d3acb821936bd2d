/* Fourier transforms of pictures, by kissfft. */
#pragma once

#include "base/context.h"

typedef struct pv_complex { float r, i; } pv_complex;

/* For planes of real numbers and their halves of a spectrum. One thread at a time. */
typedef struct pv_fft {
    int32_t width, height; /* width is even */
    void *row[2], *column[2]; /* kissfft's plans, forth and back */
    pv_complex *scratch;
} pv_fft;

/* A plane of at least this size, of a size that transforms quickly. */
pave_result pv_fft_create(pave_context *context, int32_t width, int32_t height, pv_fft *out);

/* The same of this very size; the width must be even. */
pave_result pv_fft_create_exact(pave_context *context, int32_t width, int32_t height, pv_fft *out);
void pv_fft_free(pv_fft *fft);

static inline size_t pv_fft_reals(const pv_fft *fft) { return (size_t)fft->width * (size_t)fft->height; }
static inline size_t pv_fft_halves(const pv_fft *fft) { return ((size_t)fft->width / 2 + 1) * (size_t)fft->height; }

/* The inverse is `width * height` times too large. */
void pv_fft_forth(const pv_fft *fft, const float *plane, pv_complex *spectrum);
void pv_fft_back(const pv_fft *fft, const pv_complex *spectrum, float *plane);
