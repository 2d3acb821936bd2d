/* The statistics of a texture, gathered from its pyramid. */
#include "btf/texture.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

static size_t size_of(const pv_texture *t, int32_t scale)
{
    return pv_level_size(&t->steerable, scale);
}

static pave_result make_scale(pave_context *context, pv_texture *t, int32_t scale)
{
    pave_result result = PAVE_OK;
    size_t n = size_of(t, scale);
    t->low[scale] = pv_allocate(context, n, sizeof *t->low[scale], &result);
    for (int32_t k = 0; k < t->steerable.orientations && scale < t->steerable.scales && !result; k++) {
        t->magnitude[scale][k] = pv_allocate(context, n, sizeof *t->magnitude[scale][k], &result);
        if (scale + 1 == t->steerable.scales)
            continue;
        if (!result)
            t->parent[scale][k] = pv_allocate(context, n, sizeof *t->parent[scale][k], &result);
        if (!result)
            t->parent_magnitude[scale][k] = pv_allocate(context, n, sizeof *t->parent_magnitude[scale][k], &result);
    }
    return result;
}

pave_result pv_texture_create(pave_context *context, const pv_statistics *like, int32_t width, int32_t height,
                              pv_texture *out)
{
    memset(out, 0, sizeof *out);
    out->context = context, out->like = like;
    out->width = width, out->height = height;
    pave_result result = pv_steerable_create(context, width, height, like->settings.scales, like->settings.orientations,
                                             &out->steerable);
    if (!result)
        result = pv_pyramid_create(context, &out->steerable, &out->pyramid);
    for (int32_t s = 0; s <= like->settings.scales && !result; s++)
        result = make_scale(context, out, s);
    for (int i = 0; i < 2 && !result; i++)
        out->room[i] = pv_allocate(context, size_of(out, 0), sizeof *out->room[i], &result);
    if (result)
        pv_texture_free(out);
    return result;
}

void pv_texture_free(pv_texture *texture)
{
    for (int32_t s = 0; s <= PV_MOST_SCALES; s++)
        pv_release(texture->low[s]);
    for (int32_t i = 0; i < PV_MOST_SCALES * PV_MOST_ORIENTATIONS; i++) {
        pv_release(texture->magnitude[i / PV_MOST_ORIENTATIONS][i % PV_MOST_ORIENTATIONS]);
        pv_release(texture->parent[i / PV_MOST_ORIENTATIONS][i % PV_MOST_ORIENTATIONS]);
        pv_release(texture->parent_magnitude[i / PV_MOST_ORIENTATIONS][i % PV_MOST_ORIENTATIONS]);
    }
    pv_release(texture->room[0]);
    pv_release(texture->room[1]);
    pv_pyramid_free(&texture->pyramid);
    pv_steerable_free(&texture->steerable);
    memset(texture, 0, sizeof *texture);
}

/* The absolute values less their mean, which is returned. */
static double take_magnitude(const pv_complex *band, size_t count, float *out)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        out[i] = sqrtf(band[i].r * band[i].r + band[i].i * band[i].i);
        sum += out[i];
    }
    double mean = sum / (double)count;
    for (size_t i = 0; i < count; i++)
        out[i] -= (float)mean;
    return mean;
}

typedef struct taking {
    pv_texture *texture;
    int32_t scale;
    int parents;
} taking;

static void take_task(void *data, int32_t k, int32_t worker)
{
    (void)worker;
    const taking *take = data;
    pv_texture *t = take->texture;
    int32_t s = take->scale;
    if (take->parents)
        take_magnitude(t->parent[s][k], size_of(t, s), t->parent_magnitude[s][k]);
    else
        t->mean_magnitude[s][k] = take_magnitude(t->pyramid.band[s][k], size_of(t, s), t->magnitude[s][k]);
}

pave_result pv_texture_magnitudes(pv_texture *texture, int32_t scale)
{
    taking take = { texture, scale, 0 };
    return pv_parallel(texture->context, texture->steerable.orientations, take_task, &take, 0, 0);
}

pave_result pv_texture_parents(pv_texture *texture, int32_t scale)
{
    pv_texture *t = texture;
    taking take = { t, scale, 1 };
    pave_result result = PAVE_OK;
    if (scale + 1 >= t->steerable.scales)
        return PAVE_OK;
    for (int32_t k = 0; k < t->steerable.orientations && !result; k++) {
        memcpy(t->room[0], t->pyramid.band[scale + 1][k], size_of(t, scale + 1) * sizeof *t->room[0]);
        result = pv_fourier_forth(t->context, &t->steerable.level[scale + 1].fourier, 1, &t->room[0]);
        pv_steerable_expand(&t->steerable, scale + 1, t->room[0], t->parent[scale][k]);
    }
    if (!result)
        result = pv_fourier_back(t->context, &t->steerable.level[scale].fourier, t->steerable.orientations,
                                 t->parent[scale]);
    return result ? result : pv_parallel(t->context, t->steerable.orientations, take_task, &take, 0, 0);
}

pave_result pv_texture_analyse(pv_texture *texture, const float *plane)
{
    pv_texture *t = texture;
    pave_result result = pv_steerable_analyse(t->context, &t->steerable, plane, &t->pyramid);
    for (int32_t s = 0; s <= t->steerable.scales && !result; s++) {
        double sum = 0;
        for (size_t i = 0; i < size_of(t, s); i++)
            sum += t->pyramid.low[s][i].r;
        double mean = sum / (double)size_of(t, s);
        for (size_t i = 0; i < size_of(t, s); i++)
            t->low[s][i] = (float)(t->pyramid.low[s][i].r - mean);
        if (s < t->steerable.scales)
            result = pv_texture_magnitudes(t, s);
        if (!result)
            result = pv_texture_parents(t, s);
    }
    return result;
}

/* In eight sums, so that they can be done at once. */
static double row_product(const float *a, const float *b, int32_t count)
{
    float sum[8] = { 0 };
    int32_t i = 0;
    for (; i + 8 <= count; i += 8)
        for (int32_t k = 0; k < 8; k++)
            sum[k] += a[i + k] * b[i + k];
    for (; i < count; i++)
        sum[i & 7] += a[i] * b[i];
    double total = 0;
    for (int32_t k = 0; k < 8; k++)
        total += sum[k];
    return total;
}

double pv_mean_product(const float *a, const float *b, int32_t width, int32_t height, int32_t x, int32_t y)
{
    double sum = 0;
    int32_t across = (x + width) % width, down = (y + height) % height;
    for (int32_t v = 0; v < height; v++) {
        const float *from = a + (size_t)v * (size_t)width;
        const float *to = b + (size_t)((v + down) % height) * (size_t)width;
        sum += row_product(from, to + across, width - across) + row_product(from + width - across, to, across);
    }
    return sum / ((double)width * (double)height);
}

/* Of products with the real or the imaginary part of a band whose phase is doubled. */
static double mean_phase_product(const pv_complex *band, const pv_complex *parent, size_t count, int imaginary)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        float r = parent[i].r, j = parent[i].i, size = sqrtf(r * r + j * j);
        float doubled = imaginary ? 2 * r * j : r * r - j * j;
        sum += size > 0 ? (double)(band[i].r * (doubled / size)) : 0;
    }
    return sum / (double)count;
}

/* A scale's tasks: a plane's autocorrelation each, and a band's products with the others. */
typedef struct gathering {
    pv_texture *texture;
    pv_statistics *into;
    int32_t channel;
} gathering;

static void autocorrelate(const pv_texture *t, const float *plane, int32_t scale, double *out)
{
    const pv_steerable_level *level = &t->steerable.level[scale];
    int32_t reach = t->like->reach[scale], x, y;
    for (int32_t i = 0; i < pv_lags(reach); i++) {
        pv_lag(reach, i, &x, &y);
        out[i] = pv_mean_product(plane, plane, level->width, level->height, x, y);
    }
}

static void gather_low(const gathering *g, int32_t scale)
{
    pv_texture *t = g->texture;
    pv_moments m = pv_moments_of(t->low[scale], size_of(t, scale));
    double *shape = pv_statistics_at(g->into, PV_LOW_SHAPE, g->channel, scale);
    shape[0] = m.skewness, shape[1] = m.kurtosis;
    autocorrelate(t, t->low[scale], scale, pv_statistics_at(g->into, PV_LOW_CORRELATION, g->channel, scale));
}

static void gather_parents(const gathering *g, int32_t scale, int32_t k)
{
    pv_texture *t = g->texture;
    const pv_steerable_level *level = &t->steerable.level[scale];
    int32_t orientations = t->steerable.orientations;
    double *scales = pv_statistics_at(g->into, PV_SCALES, g->channel, scale) + k * orientations;
    double *phase = pv_statistics_at(g->into, PV_PHASE, g->channel, scale) + k * 2 * orientations;
    for (int32_t j = 0; j < orientations; j++) {
        scales[j] = pv_mean_product(t->magnitude[scale][k], t->parent_magnitude[scale][j], level->width, level->height,
                                    0, 0);
        for (int i = 0; i < 2; i++)
            phase[i * orientations + j] =
                mean_phase_product(t->pyramid.band[scale][k], t->parent[scale][j], size_of(t, scale), i);
    }
}

static void gather_band(const gathering *g, int32_t scale, int32_t k)
{
    pv_texture *t = g->texture;
    const pv_steerable_level *level = &t->steerable.level[scale];
    double *pairs = pv_statistics_at(g->into, PV_ORIENTATIONS, g->channel, scale);
    pv_statistics_at(g->into, PV_MAGNITUDE, g->channel, scale)[k] = t->mean_magnitude[scale][k];
    autocorrelate(t, t->magnitude[scale][k], scale,
                  pv_statistics_at(g->into, PV_MAGNITUDE_CORRELATION, g->channel, scale) +
                      k * pv_lags(t->like->reach[scale]));
    for (int32_t j = 0; j < k; j++)
        pairs[k * (k - 1) / 2 + j] =
            pv_mean_product(t->magnitude[scale][k], t->magnitude[scale][j], level->width, level->height, 0, 0);
    if (scale + 1 < t->steerable.scales)
        gather_parents(g, scale, k);
}

static void gather_task(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    const gathering *g = data;
    int32_t planes = g->texture->steerable.orientations + 1;
    if (index % planes == 0)
        gather_low(g, index / planes);
    else
        gather_band(g, index / planes, index % planes - 1);
}

pave_result pv_texture_gather(pv_texture *texture, const float *plane, int32_t channel, pv_statistics *into)
{
    pv_texture *t = texture;
    gathering g = { t, into, channel };
    size_t n = size_of(t, 0);
    pv_moments m = pv_moments_of(plane, n);
    double *pixels = pv_statistics_at(into, PV_PIXELS, channel, 0), *shape = pv_statistics_at(into, PV_SHAPE, channel, 0);
    double sum = 0;
    pixels[0] = m.mean, pixels[1] = sqrt(m.variance), pixels[2] = m.least, pixels[3] = m.greatest;
    shape[0] = m.skewness, shape[1] = m.kurtosis;
    for (size_t i = 0; i < n; i++)
        sum += (double)(t->pyramid.high[i].r * t->pyramid.high[i].r);
    *pv_statistics_at(into, PV_HIGH, channel, 0) = sum / (double)n;
    return pv_parallel(t->context, t->steerable.scales * (t->steerable.orientations + 1) + 1, gather_task, &g, 0, 0);
}
