/* One round: all statistics of a channel imposed in turn, from the coarsest scale to the pixels.
 * Source: Portilla and Simoncelli 2000, the synthesis procedure. */
#include "statistics/texture.h"

#include <math.h>
#include <string.h>

static size_t size_of(const pv_texture *t, int32_t scale)
{
    return pv_level_size(&t->steerable, scale);
}

/* A band's magnitudes with those of the other channels. */
static pave_result impose_others(pv_texture *t, const pv_statistics *wanted, int32_t channel, int32_t s, int32_t k)
{
    int32_t pairs = wanted->channels * (wanted->channels - 1) / 2, others = 0;
    const double *of = pv_statistics_at(wanted, PV_CHANNEL_MAGNITUDES, 0, s);
    pave_result result = PAVE_OK;
    if (!of || !t->company)
        return PAVE_OK;
    float **fixed = pv_allocate(t->context, (size_t)wanted->channels, sizeof *fixed, &result);
    double *with = result ? NULL : pv_allocate(t->context, (size_t)wanted->channels, sizeof *with, &result);
    for (int32_t c = 0; c < wanted->channels && !result; c++)
        if (c != channel && t->company->known[c]) {
            with[others] = of[k * pairs + pv_pair(channel, c)];
            fixed[others++] = pv_company_magnitude(t, c, s, k);
        }
    if (!result && others)
        result = pv_impose_covariance(t->context, 1, &t->magnitude[s][k], others, fixed, size_of(t, s), NULL, with);
    pv_release(fixed);
    pv_release(with);
    return result;
}

/* Magnitudes of a scale: among each other and with the coarser ones, then each by itself. */
static pave_result impose_magnitudes(pv_texture *t, const pv_statistics *wanted, int32_t channel, int32_t s)
{
    int32_t n = t->steerable.orientations, reach = wanted->reach[s], lags = pv_lags(reach);
    const double *correlation = pv_statistics_at(wanted, PV_MAGNITUDE_CORRELATION, channel, s);
    const double *pairs = pv_statistics_at(wanted, PV_ORIENTATIONS, channel, s);
    const double *with = pv_statistics_at(wanted, PV_SCALES, channel, s);
    double among[PV_MOST_ORIENTATIONS * PV_MOST_ORIENTATIONS];
    for (int32_t k = 0; k < n; k++)
        for (int32_t j = 0; j <= k; j++)
            among[k * n + j] = among[j * n + k] = j == k ? correlation[k * lags] : pairs[k * (k - 1) / 2 + j];
    pave_result result = pv_impose_covariance(t->context, n, t->magnitude[s], with ? n : 0, t->parent_magnitude[s],
                                              size_of(t, s), among, with);
    for (int32_t k = 0; k < n && !result; k++)
        result = impose_others(t, wanted, channel, s, k);
    for (int32_t k = 0; k < n && !result; k++)
        result = pv_impose_autocorrelation(t, s, reach, correlation + k * lags, t->magnitude[s][k]);
    return result;
}

/* Bands with their magnitudes made new, and their phases. */
static void scale_bands(pv_texture *t, const pv_statistics *wanted, int32_t channel, int32_t s)
{
    const double *mean = pv_statistics_at(wanted, PV_MAGNITUDE, channel, s);
    for (int32_t k = 0; k < t->steerable.orientations; k++)
        for (size_t i = 0; i < size_of(t, s); i++) {
            pv_complex *z = &t->pyramid.band[s][k][i];
            float is = sqrtf(z->r * z->r + z->i * z->i), be = t->magnitude[s][k][i] + (float)mean[k];
            float gain = be > 0 && is > 1e-30f ? be / is : 0;
            z->r *= gain, z->i *= gain;
        }
}

/* Real parts, with those of the coarser scale whose phase is doubled. Then the real part is all that is left. */
static pave_result impose_phases(pv_texture *t, const pv_statistics *wanted, int32_t channel, int32_t s)
{
    int32_t n = t->steerable.orientations;
    size_t size = size_of(t, s);
    float *planes[PV_MOST_ORIENTATIONS], *fixed[2 * PV_MOST_ORIENTATIONS];
    pave_result result = PAVE_OK;
    float *room = pv_allocate(t->context, 3 * (size_t)n * size, sizeof *room, &result);
    for (int32_t k = 0; k < n && !result; k++) {
        planes[k] = room + (size_t)k * size;
        fixed[k] = room + (size_t)(n + k) * size, fixed[n + k] = room + (size_t)(2 * n + k) * size;
        for (size_t i = 0; i < size; i++) {
            planes[k][i] = t->pyramid.band[s][k][i].r;
            fixed[k][i] = t->doubled[s][k][i].r;
            fixed[n + k][i] = t->doubled[s][k][i].i;
        }
    }
    if (!result)
        result = pv_impose_covariance(t->context, n, planes, 2 * n, fixed, size, NULL,
                                      pv_statistics_at(wanted, PV_PHASE, channel, s));
    for (int32_t k = 0; k < n && !result; k++)
        for (size_t i = 0; i < size; i++)
            t->pyramid.band[s][k][i] = (pv_complex){ planes[k][i], 0 };
    pv_release(room);
    return result;
}

/* A lowpass picture as a picture: autocorrelation, skewness, kurtosis. Then its spectrum. */
static pave_result impose_low(pv_texture *t, const pv_statistics *wanted, int32_t channel, int32_t s)
{
    size_t size = size_of(t, s);
    pv_complex *low = t->pyramid.low[s];
    const double *shape = pv_statistics_at(wanted, PV_LOW_SHAPE, channel, s);
    for (size_t i = 0; i < size; i++)
        t->low[s][i] = low[i].r;
    pave_result result = pv_impose_autocorrelation(t, s, wanted->reach[s],
                                                   pv_statistics_at(wanted, PV_LOW_CORRELATION, channel, s), t->low[s]);
    pv_move_moment(t->low[s], size, 3, shape[0]);
    pv_move_moment(t->low[s], size, 4, shape[1]);
    for (size_t i = 0; i < size; i++)
        low[i] = (pv_complex){ t->low[s][i], 0 };
    return result ? result : pv_fourier_forth(t->context, &t->steerable.level[s].fourier, 1, &low);
}

/* The bands of a scale, and from them and the coarser low its own one; its bands anew from that, for the finer ones. */
static pave_result impose_scale(pv_texture *t, const pv_statistics *wanted, int32_t channel, int32_t s)
{
    const pv_fourier *fourier = &t->steerable.level[s].fourier;
    int32_t n = t->steerable.orientations;
    pave_result result = pv_texture_parents(t, s);
    if (!result)
        result = pv_texture_magnitudes(t, s);
    if (!result)
        result = impose_magnitudes(t, wanted, channel, s);
    if (!result)
        scale_bands(t, wanted, channel, s);
    if (!result && s + 1 < t->steerable.scales)
        result = impose_phases(t, wanted, channel, s);
    for (int32_t k = 0; k < n && !result; k++)
        for (size_t i = 0; i < size_of(t, s); i++)
            t->pyramid.band[s][k][i].i = 0;
    if (!result)
        result = pv_fourier_forth(t->context, fourier, n, t->pyramid.band[s]);
    if (!result)
        result = pv_steerable_join(t->context, &t->steerable, &t->pyramid, s, 0);
    if (!result)
        result = pv_fourier_back(t->context, fourier, 1, &t->pyramid.low[s]);
    if (!result)
        result = impose_low(t, wanted, channel, s);
    if (!result)
        result = pv_steerable_split(t->context, &t->steerable, &t->pyramid, s);
    return result ? result : pv_fourier_back(t->context, fourier, n, t->pyramid.band[s]);
}

/* The highpass residual's variance, by one factor. */
static void impose_high(pv_texture *t, const pv_statistics *wanted, int32_t channel)
{
    double sum = 0, be = *pv_statistics_at(wanted, PV_HIGH, channel, 0);
    for (size_t i = 0; i < size_of(t, 0); i++)
        sum += (double)(t->pyramid.high[i].r * t->pyramid.high[i].r);
    float gain = sum > 0 ? (float)sqrt(be * (double)size_of(t, 0) / sum) : 0;
    for (size_t i = 0; i < size_of(t, 0); i++)
        t->pyramid.high[i] = (pv_complex){ t->pyramid.high[i].r * gain, 0 };
}

/* The first low and the highpass residual make the picture. */
static pave_result assemble(pv_texture *t, float *plane)
{
    pv_complex *high = t->pyramid.high, *low = t->pyramid.low[0];
    const float *first_low = t->steerable.first_low, *first_high = t->steerable.first_high;
    pave_result result = pv_fourier_forth(t->context, &t->steerable.level[0].fourier, 1, &high);
    for (size_t i = 0; i < size_of(t, 0) && !result; i++) {
        high[i].r = high[i].r * first_high[i] + low[i].r * first_low[i];
        high[i].i = high[i].i * first_high[i] + low[i].i * first_low[i];
    }
    if (!result)
        result = pv_fourier_back(t->context, &t->steerable.level[0].fourier, 1, &high);
    for (size_t i = 0; i < size_of(t, 0) && !result; i++)
        plane[i] = high[i].r;
    return result;
}

pave_result pv_texture_impose(pv_texture *texture, const pv_statistics *wanted, int32_t channel, float *plane)
{
    pv_texture *t = texture;
    int32_t last = t->steerable.scales;
    double mean = pv_mean(plane, size_of(t, 0));
    pave_result result = pv_steerable_analyse(t->context, &t->steerable, plane, mean, &t->pyramid);
    if (!result)
        result = impose_low(t, wanted, channel, last);
    for (int32_t s = last - 1; s >= 0 && !result; s--)
        result = impose_scale(t, wanted, channel, s);
    if (!result) {
        impose_high(t, wanted, channel);
        result = assemble(t, plane);
    }
    if (!result)
        pv_impose_marginal(plane, size_of(t, 0), pv_statistics_at(wanted, PV_PIXELS, channel, 0),
                           pv_statistics_at(wanted, PV_SHAPE, channel, 0));
    return result;
}
