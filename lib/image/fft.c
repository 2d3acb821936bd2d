/* Fourier transforms of pictures. */
#include "image/fft.h"

#include <string.h>

#define KISS_FFT_SHARED
#define kiss_fft_scalar float
#include <kissfft/kiss_fftr.h>

/* Plans are made in memory of ours. */
static pave_result make_plan(pave_context *context, int32_t size, int inverse, int real, void **plan)
{
    pave_result result = PAVE_OK;
    size_t bytes = 0;
    if (real)
        kiss_fftr_alloc(size, inverse, NULL, &bytes);
    else
        kiss_fft_alloc(size, inverse, NULL, &bytes);
    *plan = pv_allocate(context, bytes, 1, &result);
    if (result)
        return result;
    int made = real ? kiss_fftr_alloc(size, inverse, *plan, &bytes) != NULL
                    : kiss_fft_alloc(size, inverse, *plan, &bytes) != NULL;
    return made ? PAVE_OK : pv_fail(context, PAVE_ERR_INTERNAL, "no Fourier transform of %d", (int)size);
}

static pave_result make_plans(pave_context *context, pv_fft *fft)
{
    pave_result result = PAVE_OK;
    for (int inverse = 0; inverse < 2 && !result; inverse++) {
        result = make_plan(context, fft->width, inverse, 1, &fft->row[inverse]);
        if (!result)
            result = make_plan(context, fft->height, inverse, 0, &fft->column[inverse]);
    }
    if (!result)
        fft->scratch = pv_allocate(context, pv_fft_halves(fft) + (size_t)fft->height, sizeof *fft->scratch, &result);
    if (result)
        pv_fft_free(fft);
    return result;
}

pave_result pv_fft_create_exact(pave_context *context, int32_t width, int32_t height, pv_fft *out)
{
    *out = (pv_fft){ .width = width, .height = height };
    return make_plans(context, out);
}

pave_result pv_fft_create(pave_context *context, int32_t width, int32_t height, pv_fft *out)
{
    return pv_fft_create_exact(context, 2 * kiss_fft_next_fast_size((width + 1) / 2), kiss_fft_next_fast_size(height),
                               out);
}

void pv_fft_free(pv_fft *fft)
{
    for (int inverse = 0; inverse < 2; inverse++) {
        pv_release(fft->row[inverse]);
        pv_release(fft->column[inverse]);
    }
    pv_release(fft->scratch);
    memset(fft, 0, sizeof *fft);
}

static void columns(const pv_fft *fft, int inverse, const pv_complex *in, pv_complex *out)
{
    int32_t across = fft->width / 2 + 1;
    pv_complex *one = fft->scratch + pv_fft_halves(fft);
    for (int32_t x = 0; x < across; x++) {
        kiss_fft_stride(fft->column[inverse], (const kiss_fft_cpx *)in + x, (kiss_fft_cpx *)one, across);
        for (int32_t y = 0; y < fft->height; y++)
            out[(size_t)y * (size_t)across + (size_t)x] = one[y];
    }
}

void pv_fft_forth(const pv_fft *fft, const float *plane, pv_complex *spectrum)
{
    size_t across = (size_t)fft->width / 2 + 1;
    for (size_t y = 0; y < (size_t)fft->height; y++)
        kiss_fftr(fft->row[0], plane + y * (size_t)fft->width, (kiss_fft_cpx *)fft->scratch + y * across);
    columns(fft, 0, fft->scratch, spectrum);
}

void pv_fft_back(const pv_fft *fft, const pv_complex *spectrum, float *plane)
{
    size_t across = (size_t)fft->width / 2 + 1;
    columns(fft, 1, spectrum, fft->scratch);
    for (size_t y = 0; y < (size_t)fft->height; y++)
        kiss_fftri(fft->row[1], (const kiss_fft_cpx *)fft->scratch + y * across, plane + y * (size_t)fft->width);
}
