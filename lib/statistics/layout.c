/* How statistics are kept: stretches of numbers, each of a group, a channel and a scale; and how far two are apart. */
#include "statistics/texture.h"

#include <math.h>
#include <stdlib.h>

enum { LEAST_SIDE = 4 };

static int32_t lesser(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* Numbers of a group in a channel and a scale. */
static int32_t count_of(const pv_statistics *s, int32_t group, int32_t scale)
{
    int32_t orientations = s->settings.orientations, bands = scale < s->settings.scales;
    int32_t pairs = s->channels * (s->channels - 1) / 2, coarser = scale + 1 < s->settings.scales;
    switch (group) {
    case PV_PIXELS: return scale ? 0 : 4;
    case PV_SHAPE: return scale ? 0 : 2;
    case PV_LOW_SHAPE: return 2;
    case PV_LOW_CORRELATION: return pv_lags(s->reach[scale]);
    case PV_HIGH: return scale ? 0 : 1;
    case PV_MAGNITUDE: return bands * orientations;
    case PV_MAGNITUDE_CORRELATION: return bands * orientations * pv_lags(s->reach[scale]);
    case PV_ORIENTATIONS: return bands * orientations * (orientations - 1) / 2;
    case PV_SCALES: return coarser * orientations * orientations;
    case PV_PHASE: return coarser * orientations * 2 * orientations;
    case PV_CHANNELS: return s->settings.cross > 0 && !scale ? pairs : 0;
    default: return s->settings.cross > 1 ? bands * orientations * pairs : 0;
    }
}

static void lay_out(pv_statistics *s, pv_stretch *stretches)
{
    s->stretch_count = s->count = 0;
    for (int32_t group = 0; group < PV_GROUPS; group++)
        for (int32_t channel = 0; channel < (group < PV_CHANNELS ? s->channels : 1); channel++)
            for (int32_t scale = 0; scale <= s->settings.scales; scale++) {
                int32_t count = count_of(s, group, scale);
                if (count && stretches)
                    stretches[s->stretch_count] = (pv_stretch){ group, channel, scale, s->count, count };
                s->stretch_count += count > 0;
                s->count += count;
            }
}

static pave_result check(pave_context *context, int32_t width, int32_t height, int32_t channels,
                         const pv_statistics_settings *settings)
{
    int32_t scales = 0, side = lesser(width, height);
    while (side >> (scales + 1) >= LEAST_SIDE)
        scales++;
    if (settings->scales < 1 || settings->scales > PV_MOST_SCALES || settings->orientations < 2 ||
        settings->orientations > PV_MOST_ORIENTATIONS || settings->neighbourhood < 3 ||
        settings->neighbourhood > 2 * PV_MOST_REACH + 1 || settings->neighbourhood % 2 == 0 || channels < 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT,
                       "statistics are of 1 to %d scales, 2 to %d orientations and an odd neighbourhood of 3 to %d, "
                       "not of %d, %d and %d", PV_MOST_SCALES, PV_MOST_ORIENTATIONS, 2 * PV_MOST_REACH + 1,
                       (int)settings->scales, (int)settings->orientations, (int)settings->neighbourhood);
    if ((int64_t)width * height > PV_MOST_TEXTURE)
        return pv_fail(context, PAVE_ERR_LIMIT, "a texture of %d x %d px is too large for statistics", (int)width,
                       (int)height);
    if (!scales)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a texture of %d x %d px is too small for statistics: each side "
                       "must have %d px", (int)width, (int)height, 2 * LEAST_SIDE);
    if (settings->scales > scales)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a texture of %d x %d px is too small for %d scales, which need "
                       "sides of %d px; it allows %d", (int)width, (int)height, (int)settings->scales,
                       LEAST_SIDE << settings->scales, (int)scales);
    return PAVE_OK;
}

static pave_result make(pave_context *context, const pv_statistics *like, pv_statistics **out)
{
    pave_result result = PAVE_OK;
    pv_statistics *s = pv_allocate(context, 1, sizeof *s, &result);
    if (result)
        return result;
    *s = *like;
    s->stretches = NULL, s->values = NULL;
    lay_out(s, NULL);
    s->stretches = pv_allocate(context, (size_t)s->stretch_count, sizeof *s->stretches, &result);
    s->values = result ? NULL : pv_allocate_zeroed(context, (size_t)s->count, sizeof *s->values, &result);
    if (result) {
        pv_statistics_free(s);
        return result;
    }
    lay_out(s, s->stretches);
    *out = s;
    return PAVE_OK;
}

pave_result pv_statistics_create(pave_context *context, int32_t width, int32_t height, int32_t channels,
                                 const pv_statistics_settings *settings, pv_statistics **out)
{
    pave_result result = check(context, width, height, channels, settings);
    pv_statistics s = { .settings = *settings, .channels = channels };
    for (int32_t level = 0; level <= settings->scales && !result; level++)
        s.reach[level] = lesser(settings->neighbourhood / 2, (lesser(width, height) >> level) / 2 - 1);
    return result ? result : make(context, &s, out);
}

pave_result pv_statistics_create_like(pave_context *context, const pv_statistics *like, pv_statistics **out)
{
    return make(context, like, out);
}

void pv_statistics_free(pv_statistics *statistics)
{
    if (!statistics)
        return;
    pv_release(statistics->stretches);
    pv_release(statistics->values);
    pv_release(statistics);
}

double *pv_statistics_at(const pv_statistics *statistics, int32_t group, int32_t channel, int32_t scale)
{
    for (int32_t i = 0; i < statistics->stretch_count; i++) {
        const pv_stretch *s = &statistics->stretches[i];
        if (s->group == group && s->channel == channel && s->scale == scale)
            return statistics->values + s->first;
    }
    return NULL;
}

/* Of a channel's pixels, or of the magnitudes of one of its bands. */
static double channel_variance(const pv_statistics *s, const pv_stretch *stretch, int32_t channel, int32_t k)
{
    int32_t scale = stretch->scale, lags = pv_lags(s->reach[scale]);
    double deviation = pv_statistics_at(s, PV_PIXELS, channel, 0)[1];
    return stretch->group == PV_CHANNELS ? deviation * deviation
                                         : pv_statistics_at(s, PV_MAGNITUDE_CORRELATION, channel, scale)[k * lags];
}

/* The variance of the pixels of a stretch's channel; of what is between channels, that of all. */
static double variance_of(const pv_statistics *s, const pv_stretch *stretch)
{
    double sum = 0;
    for (int32_t c = 0; c < s->channels; c++) {
        double deviation = pv_statistics_at(s, PV_PIXELS, c, 0)[1];
        if (stretch->group >= PV_CHANNELS || c == stretch->channel)
            sum += deviation * deviation;
    }
    return sum;
}

/* What lies between two channels is held against both: where they are without any relation, too. */
static double norm_between(const pv_statistics *s, const pv_stretch *stretch)
{
    double sum = 0;
    int32_t orientations = stretch->group == PV_CHANNELS ? 1 : s->settings.orientations;
    for (int32_t k = 0; k < orientations; k++)
        for (int32_t a = 1; a < s->channels; a++)
            for (int32_t b = 0; b < a; b++)
                sum += channel_variance(s, stretch, a, k) * channel_variance(s, stretch, b, k);
    return sqrt(sum);
}

/* Sums of squares, of pixels without what the mean adds to least and greatest. Where nothing is, nothing may come: what
 * is below the rounding of floats beside the whole counts as much as that. */
double pv_statistics_norm(const pv_statistics *wanted, const pv_stretch *stretch)
{
    const double *v = wanted->values + stretch->first;
    double sum = 0, variance = variance_of(wanted, stretch), least;
    int32_t group = stretch->group;
    if (group >= PV_CHANNELS)
        return fmax(norm_between(wanted, stretch), fmax(1e-6 * variance, 1e-30));
    for (int32_t i = 0; i < stretch->count; i++) {
        double value = group != PV_PIXELS ? v[i] : i == 0 ? 0 : i == 1 ? v[1] : v[i] - v[0];
        sum += value * value;
    }
    least = group == PV_SHAPE || group == PV_LOW_SHAPE        ? 1
            : group == PV_PIXELS || group == PV_MAGNITUDE     ? 1e-4 * sqrt(variance)
                                                              : 1e-6 * variance;
    return fmax(fmax(sqrt(sum), least), 1e-30);
}

/* Where a number of a stretch is among those of another measurement, whose lags may not go so far: NULL. */
static const double *counterpart(const pv_statistics *of, const pv_statistics *in, const pv_stretch *s, int32_t k)
{
    const double *values = pv_statistics_at(in, s->group, s->channel, s->scale);
    int32_t own = of->reach[s->scale], other = in->reach[s->scale], x, y;
    if ((s->group != PV_LOW_CORRELATION && s->group != PV_MAGNITUDE_CORRELATION) || own == other)
        return values + k;
    pv_lag(own, k % pv_lags(own), &x, &y);
    return abs(x) > other || y > other ? NULL : values + k / pv_lags(own) * pv_lags(other) + y * (2 * other + 1) + x;
}

double pv_statistics_group(const pv_statistics *wanted, const pv_statistics *is, int32_t group)
{
    double sum = 0;
    int32_t stretches = 0;
    for (int32_t i = 0; i < wanted->stretch_count; i++) {
        const pv_stretch *s = &wanted->stretches[i];
        double norm = s->group == group ? pv_statistics_norm(wanted, s) : 0;
        for (int32_t k = 0; k < s->count && norm > 0; k++) {
            const double *other = counterpart(wanted, is, s, k);
            double off = other ? (*other - wanted->values[s->first + k]) / norm : 0;
            sum += off * off;
        }
        stretches += norm > 0;
    }
    return stretches ? sqrt(sum / stretches) : -1;
}

static int comparable(const pv_statistics *a, const pv_statistics *b)
{
    const pv_statistics_settings *s = &a->settings, *t = &b->settings;
    return a->channels == b->channels && s->scales == t->scales && s->orientations == t->orientations &&
           s->cross == t->cross;
}

double pv_statistics_distance(const pv_statistics *a, const pv_statistics *b)
{
    double worst = 0;
    for (int32_t group = 0; group < PV_GROUPS && comparable(a, b); group++)
        worst = fmax(worst, pv_statistics_group(a, b, group));
    return comparable(a, b) ? worst : INFINITY;
}
