/* Autocorrelations imposed on planes by filters.
 * Source: Portilla and Simoncelli 2000, appendix: the filter's autocorrelation solves a linear system; the root of
 * its spectrum is the filter without a phase. */
#include "statistics/texture.h"

#include <math.h>
#include <string.h>

static void place(const pv_texture *t, int32_t level, const float *plane, pv_complex *out)
{
    for (size_t i = 0; i < pv_level_size(&t->steerable, level); i++)
        out[i] = (pv_complex){ plane[i], 0 };
}

static size_t at(const pv_steerable_level *level, int32_t x, int32_t y)
{
    return (size_t)((y % level->height + level->height) % level->height) * (size_t)level->width +
           (size_t)((x % level->width + level->width) % level->width);
}

/* Gauss's elimination with pivots; the last column is the right side and becomes the solution. */
static void solve(int32_t n, double *a)
{
    int32_t stride = n + 1;
    for (int32_t i = 0; i < n; i++) {
        int32_t pivot = i;
        for (int32_t k = i + 1; k < n; k++)
            pivot = fabs(a[k * stride + i]) > fabs(a[pivot * stride + i]) ? k : pivot;
        for (int32_t j = i; j <= n && pivot != i; j++) {
            double swap = a[i * stride + j];
            a[i * stride + j] = a[pivot * stride + j], a[pivot * stride + j] = swap;
        }
        for (int32_t k = 0; k < n; k++) {
            double factor = k != i && a[i * stride + i] != 0 ? a[k * stride + i] / a[i * stride + i] : 0;
            for (int32_t j = i; j <= n && factor != 0; j++)
                a[k * stride + j] -= factor * a[i * stride + j];
        }
    }
    for (int32_t i = 0; i < n; i++)
        a[i * stride + n] = a[i * stride + i] != 0 ? a[i * stride + n] / a[i * stride + i] : 0;
}

/* The filter's autocorrelation, convolved with that which is there, gives that wanted. */
static void find_filter(const pv_steerable_level *level, int32_t reach, const pv_complex *is, const double *wanted,
                        double *system)
{
    int32_t n = pv_lags(reach), x, y, u, v;
    for (int32_t i = 0; i < n; i++) {
        pv_lag(reach, i, &x, &y);
        for (int32_t j = 0; j < n; j++) {
            pv_lag(reach, j, &u, &v);
            system[i * (n + 1) + j] = is[at(level, x - u, y - v)].r + (j ? is[at(level, x + u, y + v)].r : 0);
        }
        system[i * (n + 1) + i] += 1e-7 * is[0].r;
        system[i * (n + 1) + n] = wanted[i];
    }
    solve(n, system);
}

static void spread_filter(const pv_steerable_level *level, int32_t reach, const double *system, pv_complex *out)
{
    int32_t n = pv_lags(reach), x, y;
    memset(out, 0, pv_fourier_size(&level->fourier) * sizeof *out);
    for (int32_t i = 0; i < n; i++) {
        pv_lag(reach, i, &x, &y);
        out[at(level, x, y)].r = out[at(level, -x, -y)].r = (float)system[i * (n + 1) + n];
    }
}

pave_result pv_impose_autocorrelation(pv_texture *texture, int32_t level, int32_t reach, const double *wanted,
                                      float *plane)
{
    pv_texture *t = texture;
    const pv_steerable_level *l = &t->steerable.level[level];
    pave_context *context = t->context;
    size_t size = pv_level_size(&t->steerable, level), n = (size_t)pv_lags(reach);
    pv_complex *spectrum = t->room[0], *power = t->room[1];
    pave_result result = PAVE_OK;
    double *system = pv_allocate(context, n, (n + 1) * sizeof *system, &result);
    place(t, level, plane, spectrum);
    if (!result)
        result = pv_fourier_forth(context, &l->fourier, 1, &spectrum);
    for (size_t i = 0; i < size && !result; i++)
        power[i] = (pv_complex){ (spectrum[i].r * spectrum[i].r + spectrum[i].i * spectrum[i].i) / (float)size, 0 };
    if (!result)
        result = pv_fourier_back(context, &l->fourier, 1, &power);
    if (!result && power[0].r > 0) {
        find_filter(l, reach, power, wanted, system);
        spread_filter(l, reach, system, power);
        result = pv_fourier_forth(context, &l->fourier, 1, &power);
        for (size_t i = 0; i < size && !result; i++) {
            float gain = sqrtf(fabsf(power[i].r));
            spectrum[i].r *= gain, spectrum[i].i *= gain;
        }
        if (!result)
            result = pv_fourier_back(context, &l->fourier, 1, &spectrum);
        for (size_t i = 0; i < size && !result; i++)
            plane[i] = spectrum[i].r;
    }
    pv_release(system);
    return result;
}
