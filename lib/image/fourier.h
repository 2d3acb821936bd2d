/* Fourier transforms of several pictures at once, in place, shared out among the threads. */
#pragma once

#include "image/fft.h"

typedef struct pv_fourier {
    int32_t width, height;
    void *row[2], *column[2]; /* kissfft's plans, forth and back */
    pv_complex *room;         /* of each worker */
} pv_fourier;

pave_result pv_fourier_create(pave_context *context, int32_t width, int32_t height, pv_fourier *out);
void pv_fourier_free(pv_fourier *fourier);

static inline size_t pv_fourier_size(const pv_fourier *f) { return (size_t)f->width * (size_t)f->height; }

/* Of `count` planes; the inverse is divided by their size. The same bytes for any number of threads. */
pave_result pv_fourier_forth(pave_context *context, const pv_fourier *fourier, int32_t count,
                             pv_complex *const *planes);
pave_result pv_fourier_back(pave_context *context, const pv_fourier *fourier, int32_t count,
                            pv_complex *const *planes);
