/* How much of a picture repeats: the highest peak of its autocorrelation. */
#include "tiling/bank.h"
#include "tiling/tiling.h"

#include "image/fft.h"

#include <string.h>

/* Brightness less its mean in a square of 49 px, which is about what a Gauss of 20 px leaves out too. */
static pave_result take_slow_out(pave_context *context, const float *rgb, int32_t width, int32_t height, float *out)
{
    enum { RADIUS = 34 };
    pave_result result = PAVE_OK;
    size_t n = (size_t)width * (size_t)height;
    int16_t *bright = pv_allocate(context, n, sizeof *bright, &result);
    int32_t *slow = result ? NULL : pv_allocate(context, n, sizeof *slow, &result);
    for (size_t i = 0; i < n && !result; i++)
        bright[i] = (int16_t)(16 * (rgb[3 * i] + rgb[3 * i + 1] + rgb[3 * i + 2]) / 3);
    pv_grey grey = { width, height, width, 255 * 16, bright };
    if (!result)
        result = pv_box_mean(context, &grey, RADIUS, slow);
    for (size_t i = 0; i < n && !result; i++)
        out[i] = (float)(bright[i] - slow[i]) / 16;
    pv_release(bright);
    pv_release(slow);
    return result;
}

/* Is nothing around it higher? The flank of the centre is no peak. */
static int is_peak(const float *correlation, int32_t width, int32_t height, int32_t x, int32_t y)
{
    for (int32_t k = 0; k < 9; k++) {
        int32_t u = (x + k % 3 - 1 + width) % width, v = (y + k / 3 - 1 + height) % height;
        if (correlation[(int64_t)v * width + u] > correlation[(int64_t)y * width + x])
            return 0;
    }
    return 1;
}

static double highest_peak(const float *correlation, int32_t width, int32_t height)
{
    double most = -1;
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++) {
            int32_t dx = x < width - x ? x : width - x, dy = y < height - y ? y : height - y;
            double v = correlation[0] > 0 ? correlation[(int64_t)y * width + x] / correlation[0] : 0;
            if (dx * dx + dy * dy > 256 && v > most && is_peak(correlation, width, height, x, y))
                most = v;
        }
    return most;
}

pave_result pv_fft_repeat(pave_context *context, const float *rgb, int32_t width, int32_t height, double *repeat)
{
    pv_fft fft;
    int32_t even_width = width & ~1, even_height = height & ~1;
    *repeat = 0;
    if (even_width < 36 || even_height < 36)
        return PAVE_OK;
    pave_result result = pv_fft_create_exact(context, even_width, even_height, &fft);
    float *all = result ? NULL : pv_allocate(context, (size_t)width * (size_t)height, sizeof *all, &result);
    float *plane = result ? NULL : pv_allocate(context, pv_fft_reals(&fft), sizeof *plane, &result);
    pv_complex *spectrum = result ? NULL : pv_allocate(context, pv_fft_halves(&fft), sizeof *spectrum, &result);
    if (!result)
        result = take_slow_out(context, rgb, width, height, all);
    if (!result) {
        for (int32_t y = 0; y < even_height; y++)
            memcpy(plane + (int64_t)y * even_width, all + (int64_t)y * width, (size_t)even_width * sizeof *plane);
        pv_fft_forth(&fft, plane, spectrum);
        for (size_t i = 0; i < pv_fft_halves(&fft); i++)
            spectrum[i] = (pv_complex){ spectrum[i].r * spectrum[i].r + spectrum[i].i * spectrum[i].i, 0 };
        pv_fft_back(&fft, spectrum, plane);
        *repeat = highest_peak(plane, even_width, even_height);
    }
    pv_release(all);
    pv_release(plane);
    pv_release(spectrum);
    pv_fft_free(&fft);
    return result;
}
