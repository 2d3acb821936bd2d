/* The statistics of a texture, gathered from its fields. */
#include "statistics/texture.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { PIECE = 256 };

static size_t size_of(const pv_texture *t, int32_t scale)
{
    return pv_level_size(&t->steerable, scale);
}

/* In eight sums, so that they can be done at once; short ones, so that little is rounded. */
static double row_product(const float *a, const float *b, int32_t count)
{
    double total = 0;
    for (int32_t begin = 0; begin < count; begin += PIECE) {
        int32_t end = count - begin < PIECE ? count : begin + PIECE, i = begin;
        float sum[8] = { 0 };
        for (; i + 8 <= end; i += 8)
            for (int32_t k = 0; k < 8; k++)
                sum[k] += a[i + k] * b[i + k];
        for (; i < end; i++)
            sum[i & 7] += a[i] * b[i];
        for (int32_t k = 0; k < 8; k++)
            total += sum[k];
    }
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

/* Of the real part of a band, with the real or the imaginary part of the coarser one whose phase is doubled. */
static double mean_phase_product(const pv_complex *band, const pv_complex *doubled, size_t count, int imaginary)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (double)(band[i].r * (imaginary ? doubled[i].i : doubled[i].r));
    return sum / (double)count;
}

static double mean_real_product(const pv_complex *a, const pv_complex *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (double)(a[i].r * b[i].r);
    return sum / (double)count;
}

/* The products of a texture's fields with themselves; or, for the change of these, with those of the change, both ways
 * around. */
typedef struct gathering {
    const pv_texture *a, *b;
    pv_statistics *into;
    int32_t channel;
} gathering;

static int changes(const gathering *g)
{
    return g->a != g->b;
}

/* The mean product of two fields of a scale, by name. */
#define PRODUCT(g, field_a, field_b, level, x, y) \
    (pv_mean_product((g)->a->field_a, (g)->b->field_b, (level)->width, (level)->height, x, y) + \
     (changes(g) ? pv_mean_product((g)->b->field_a, (g)->a->field_b, (level)->width, (level)->height, x, y) : 0))

static void gather_low(const gathering *g, int32_t s)
{
    const pv_steerable_level *level = &g->a->steerable.level[s];
    double *shape = pv_statistics_at(g->into, PV_LOW_SHAPE, g->channel, s);
    double *correlation = pv_statistics_at(g->into, PV_LOW_CORRELATION, g->channel, s);
    int32_t reach = g->into->reach[s], x, y;
    if (changes(g))
        pv_shape_change(g->a->low[s], g->b->low[s], size_of(g->a, s), shape);
    else
        pv_shape_of(g->a->low[s], size_of(g->a, s), shape);
    for (int32_t i = 0; i < pv_lags(reach); i++) {
        pv_lag(reach, i, &x, &y);
        correlation[i] = PRODUCT(g, low[s], low[s], level, x, y);
    }
}

static void gather_parents(const gathering *g, int32_t s, int32_t k)
{
    const pv_steerable_level *level = &g->a->steerable.level[s];
    int32_t orientations = g->a->steerable.orientations;
    size_t n = size_of(g->a, s);
    double *scales = pv_statistics_at(g->into, PV_SCALES, g->channel, s) + k * orientations;
    double *phase = pv_statistics_at(g->into, PV_PHASE, g->channel, s) + k * 2 * orientations;
    for (int32_t j = 0; j < orientations; j++) {
        scales[j] = PRODUCT(g, magnitude[s][k], parent_magnitude[s][j], level, 0, 0);
        for (int i = 0; i < 2; i++)
            phase[i * orientations + j] =
                mean_phase_product(g->a->pyramid.band[s][k], g->b->doubled[s][j], n, i) +
                (changes(g) ? mean_phase_product(g->b->pyramid.band[s][k], g->a->doubled[s][j], n, i) : 0);
    }
}

static void gather_band(const gathering *g, int32_t s, int32_t k)
{
    const pv_steerable_level *level = &g->a->steerable.level[s];
    int32_t reach = g->into->reach[s], x, y;
    double *pairs = pv_statistics_at(g->into, PV_ORIENTATIONS, g->channel, s) + k * (k - 1) / 2;
    double *correlation = pv_statistics_at(g->into, PV_MAGNITUDE_CORRELATION, g->channel, s) + k * pv_lags(reach);
    pv_statistics_at(g->into, PV_MAGNITUDE, g->channel, s)[k] = g->b->mean_magnitude[s][k];
    for (int32_t i = 0; i < pv_lags(reach); i++) {
        pv_lag(reach, i, &x, &y);
        correlation[i] = PRODUCT(g, magnitude[s][k], magnitude[s][k], level, x, y);
    }
    for (int32_t j = 0; j < k; j++)
        pairs[j] = PRODUCT(g, magnitude[s][k], magnitude[s][j], level, 0, 0);
    if (s + 1 < g->a->steerable.scales)
        gather_parents(g, s, k);
}

static void gather_task(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    const gathering *g = data;
    int32_t planes = g->a->steerable.orientations + 1;
    if (index % planes == 0)
        gather_low(g, index / planes);
    else
        gather_band(g, index / planes, index % planes - 1);
}

static pave_result gather_all(const pv_texture *a, const pv_texture *b, int32_t channel, pv_statistics *into)
{
    gathering g = { a, b, into, channel };
    *pv_statistics_at(into, PV_HIGH, channel, 0) =
        mean_real_product(a->pyramid.high, b->pyramid.high, size_of(a, 0)) * (a == b ? 1 : 2);
    return pv_parallel(a->context, a->steerable.scales * (a->steerable.orientations + 1) + 1, gather_task, &g, 0, 0);
}

pave_result pv_texture_gather(pv_texture *texture, const float *plane, int32_t channel, pv_statistics *into)
{
    pv_moments m = pv_moments_of(plane, size_of(texture, 0));
    double *pixels = pv_statistics_at(into, PV_PIXELS, channel, 0);
    double *shape = pv_statistics_at(into, PV_SHAPE, channel, 0);
    pixels[0] = m.mean, pixels[1] = sqrt(m.variance), pixels[2] = m.least, pixels[3] = m.greatest;
    shape[0] = m.skewness, shape[1] = m.kurtosis;
    pv_company_gather(texture, plane, channel, into);
    return gather_all(texture, texture, channel, into);
}

/* The ends of the range do not change smoothly: they are left to be imposed by themselves. */
pave_result pv_texture_gather_change(const pv_texture *at, const pv_texture *change, const float *plane,
                                     const float *direction, int32_t channel, pv_statistics *into)
{
    double *pixels = pv_statistics_at(into, PV_PIXELS, channel, 0);
    memset(pixels, 0, 4 * sizeof *pixels);
    pixels[1] = pv_deviation_change(plane, direction, size_of(at, 0));
    pv_shape_change(plane, direction, size_of(at, 0), pv_statistics_at(into, PV_SHAPE, channel, 0));
    pv_company_gather_change(change, direction, channel, into);
    return gather_all(at, change, channel, into);
}
