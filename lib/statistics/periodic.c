/* Pictures made to repeat: what jumps at the border is spread over the whole as a smooth part, and taken out.
 * Source: Moisan 2011, "Periodic plus smooth image decomposition". Of a picture that repeats already nothing is taken:
 * only what the jumps exceed the steps inside counts, separately across and down. */
#include "statistics/periodic.h"

#include "image/fourier.h"

#include <math.h>
#include <string.h>

/* How much of the jumps across the border is more than a step may be, 0..1. A single line of steps may well have, by
 * chance, twice the mean square of all. */
static double excess(const float *plane, int32_t lines, int32_t line, int32_t steps, int32_t step)
{
    double jump = 0, inner = 0;
    for (int32_t i = 0; i < lines; i++) {
        const float *from = plane + (int64_t)i * line;
        for (int32_t k = 0; k < steps; k++) {
            double d = (double)from[(int64_t)((k + 1) % steps) * step] - from[(int64_t)k * step];
            *(k + 1 < steps ? &inner : &jump) += d * d;
        }
    }
    inner /= steps > 1 ? steps - 1 : 1;
    return jump > 2 * inner ? 1 - 2 * inner / jump : 0;
}

static void add_jumps(const float *plane, int32_t lines, int32_t line, int32_t steps, int32_t step, double share,
                      pv_complex *out)
{
    for (int32_t i = 0; i < lines; i++) {
        int64_t first = (int64_t)i * line, last = first + (int64_t)(steps - 1) * step;
        float jump = (float)(share * ((double)plane[last] - plane[first]));
        out[first].r += jump;
        out[last].r -= jump;
    }
}

static void solve(pv_complex *spectrum, int32_t width, int32_t height)
{
    const double turn = 2 * 3.14159265358979323846;
    for (int32_t y = 0; y < height; y++) {
        double down = 2 * cos(turn * y / height) - 4;
        for (int32_t x = 0; x < width; x++) {
            double by = 2 * cos(turn * x / width) + down;
            pv_complex *z = spectrum + (int64_t)y * width + x;
            *z = x || y ? (pv_complex){ (float)(z->r / by), (float)(z->i / by) } : (pv_complex){ 0, 0 };
        }
    }
}

pave_result pv_smooth_part(pave_context *context, const float *plane, int32_t width, int32_t height, float *out)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)width * (size_t)height;
    double across = excess(plane, height, width, width, 1), down = excess(plane, width, 1, height, width);
    memset(out, 0, n * sizeof *out);
    if (across == 0 && down == 0)
        return PAVE_OK;
    pv_fourier fourier;
    result = pv_fourier_create(context, width, height, &fourier);
    pv_complex *jumps = result ? NULL : pv_allocate_zeroed(context, n, sizeof *jumps, &result);
    if (!result) {
        add_jumps(plane, height, width, width, 1, across, jumps);
        add_jumps(plane, width, 1, height, width, down, jumps);
        result = pv_fourier_forth(context, &fourier, 1, &jumps);
    }
    if (!result) {
        solve(jumps, width, height);
        result = pv_fourier_back(context, &fourier, 1, &jumps);
    }
    for (size_t i = 0; i < n && !result; i++)
        out[i] = jumps[i].r;
    pv_release(jumps);
    pv_fourier_free(&fourier);
    return result;
}
