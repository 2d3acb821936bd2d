/* The gradient of a weighted sum of statistics: by the fields it is gathered from, back through the pyramid. */
#include "statistics/texture.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { ROWS = 16 };

static size_t size_of(const pv_texture *t, int32_t scale)
{
    return pv_level_size(&t->steerable, scale);
}

typedef struct grading {
    const pv_texture *at;
    const pv_statistics *weights;
    int32_t channel, scale;
    pv_texture *parts;
} grading;

/* out(p) += weight * in(p + lag), of a row. */
static void add_row(const float *in, int32_t width, int32_t x, float weight, float *out)
{
    int32_t across = (x + width) % width, end = width - across;
    for (int32_t i = 0; i < end; i++)
        out[i] += weight * in[i + across];
    for (int32_t i = end; i < width; i++)
        out[i] += weight * in[i - end];
}

/* The gradient of an autocorrelation: the plane, moved by each lag both ways. */
static void add_lags(const float *plane, const pv_steerable_level *level, int32_t reach, const double *weights,
                     int32_t row, float *out)
{
    int32_t x, y, w = level->width, h = level->height;
    for (int32_t i = 0; i < pv_lags(reach); i++) {
        pv_lag(reach, i, &x, &y);
        add_row(plane + (size_t)((row + y) % h) * (size_t)w, w, x, (float)weights[i], out);
        add_row(plane + (size_t)((row - y + h) % h) * (size_t)w, w, -x, (float)weights[i], out);
    }
}

static inline pv_complex unit(pv_complex z)
{
    float size = sqrtf(z.r * z.r + z.i * z.i);
    return size > 0 ? (pv_complex){ z.r / size, z.i / size } : (pv_complex){ 0, 0 };
}

/* Weight of the covariance of two orientations. */
static double pair_weight(const double *pairs, int32_t k, int32_t j)
{
    return k > j ? pairs[k * (k - 1) / 2 + j] : pairs[j * (j - 1) / 2 + k];
}

/* Weight of the covariance with another channel's magnitudes. */
static double channel_weight(const grading *g, int32_t s, int32_t k, int32_t other)
{
    int32_t pairs = g->weights->channels * (g->weights->channels - 1) / 2;
    return pv_statistics_at(g->weights, PV_CHANNEL_MAGNITUDES, 0, s)[k * pairs + pv_pair(g->channel, other)];
}

/* What a magnitude's statistics want of it, along a row. */
static void magnitude_row(const grading *g, int32_t k, int32_t row, float *out)
{
    const pv_texture *t = g->at;
    int32_t s = g->scale, n = t->steerable.orientations, reach = g->weights->reach[s];
    const pv_steerable_level *level = &t->steerable.level[s];
    const double *pairs = pv_statistics_at(g->weights, PV_ORIENTATIONS, g->channel, s);
    const double *scales = pv_statistics_at(g->weights, PV_SCALES, g->channel, s);
    float mean = (float)pv_statistics_at(g->weights, PV_MAGNITUDE, g->channel, s)[k];
    size_t first = (size_t)row * (size_t)level->width;
    for (int32_t x = 0; x < level->width; x++)
        out[x] = mean;
    add_lags(t->magnitude[s][k], level, reach,
             pv_statistics_at(g->weights, PV_MAGNITUDE_CORRELATION, g->channel, s) + k * pv_lags(reach), row, out);
    for (int32_t c = 0; t->company && t->company->magnitudes && c < t->company->channels; c++)
        if (c != g->channel && t->company->known[c])
            add_row(pv_company_magnitude(t, c, s, k) + first, level->width, 0,
                    (float)channel_weight(g, s, k, c), out);
    for (int32_t j = 0; j < n; j++) {
        if (j != k)
            add_row(t->magnitude[s][j] + first, level->width, 0, (float)pair_weight(pairs, k, j), out);
        if (scales)
            add_row(t->parent_magnitude[s][j] + first, level->width, 0, (float)scales[k * n + j], out);
    }
}

static void grade_band(const grading *g, int32_t k, int32_t row, float *magnitude)
{
    const pv_texture *t = g->at;
    int32_t s = g->scale, n = t->steerable.orientations, width = t->steerable.level[s].width;
    const double *phase = pv_statistics_at(g->weights, PV_PHASE, g->channel, s);
    pv_complex *out = g->parts->pyramid.band[s][k];
    magnitude_row(g, k, row, magnitude);
    for (size_t i = (size_t)row * (size_t)width, x = 0; x < (size_t)width; i++, x++) {
        pv_complex u = unit(t->pyramid.band[s][k][i]);
        out[i].r += magnitude[x] * u.r, out[i].i += magnitude[x] * u.i;
        for (int32_t j = 0; j < n && phase; j++)
            out[i].r += (float)phase[2 * k * n + j] * t->doubled[s][j][i].r +
                        (float)phase[(2 * k + 1) * n + j] * t->doubled[s][j][i].i;
    }
}

/* The same of a coarser band at this scale, whose gradient goes into its parent. */
static void grade_parent(const grading *g, int32_t j, int32_t row)
{
    const pv_texture *t = g->at;
    int32_t s = g->scale, n = t->steerable.orientations, width = t->steerable.level[s].width;
    const double *phase = pv_statistics_at(g->weights, PV_PHASE, g->channel, s);
    const double *scales = pv_statistics_at(g->weights, PV_SCALES, g->channel, s);
    for (size_t i = (size_t)row * (size_t)width, x = 0; x < (size_t)width; i++, x++) {
        float magnitude = 0, r = 0, m = 0;
        for (int32_t k = 0; k < n; k++) {
            magnitude += (float)scales[k * n + j] * t->magnitude[s][k][i];
            r += (float)phase[2 * k * n + j] * t->pyramid.band[s][k][i].r;
            m += (float)phase[(2 * k + 1) * n + j] * t->pyramid.band[s][k][i].r;
        }
        pv_complex u = unit(t->parent[s][j][i]), v = { u.r * u.r - u.i * u.i, 2 * u.r * u.i };
        float along = magnitude + r * v.r + m * v.i, across = -2 * (r * v.i - m * v.r);
        g->parts->parent[s][j][i] = (pv_complex){ along * u.r - across * u.i, along * u.i + across * u.r };
    }
}

static void grade_low(const grading *g, int32_t row, float *room)
{
    const pv_steerable_level *level = &g->at->steerable.level[g->scale];
    int32_t s = g->scale;
    const double *weights = pv_statistics_at(g->weights, PV_LOW_CORRELATION, g->channel, s);
    memset(room, 0, (size_t)level->width * sizeof *room);
    add_lags(g->at->low[s], level, g->weights->reach[s], weights, row, room);
    for (int32_t x = 0; x < level->width; x++)
        g->parts->pyramid.low[s][(size_t)row * (size_t)level->width + (size_t)x].r += room[x];
}

static void grade_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const grading *g = data;
    const pv_texture *t = g->at;
    float *room = g->parts->rows + (size_t)worker * (size_t)t->width;
    for (int32_t row = begin; row < end; row++) {
        grade_low(g, row, room);
        for (int32_t k = 0; k < t->steerable.orientations && g->scale < t->steerable.scales; k++) {
            grade_band(g, k, row, room);
            if (g->scale + 1 < t->steerable.scales)
                grade_parent(g, k, row);
        }
    }
}

/* What is wanted of the expanded bands comes down to the coarser ones. */
static pave_result lower_parents(const grading *g)
{
    pv_texture *p = g->parts;
    int32_t s = g->scale, n = p->steerable.orientations;
    pave_result result = pv_fourier_forth(p->context, &p->steerable.level[s].fourier, n, p->parent[s]);
    for (int32_t k = 0; k < n && !result; k++) {
        pv_steerable_shrink(&p->steerable, s, p->parent[s][k], p->room[0]);
        result = pv_fourier_back(p->context, &p->steerable.level[s + 1].fourier, 1, &p->room[0]);
        for (size_t i = 0; i < size_of(p, s + 1) && !result; i++) {
            p->pyramid.band[s + 1][k][i].r += p->room[0][i].r;
            p->pyramid.band[s + 1][k][i].i += p->room[0][i].i;
        }
    }
    return result;
}

static void clear(pv_texture *parts)
{
    for (int32_t s = 0; s <= parts->steerable.scales; s++) {
        memset(parts->pyramid.low[s], 0, size_of(parts, s) * sizeof(pv_complex));
        for (int32_t k = 0; k < parts->steerable.orientations && s < parts->steerable.scales; k++)
            memset(parts->pyramid.band[s][k], 0, size_of(parts, s) * sizeof(pv_complex));
    }
}

static pave_result grade_scale(grading *g)
{
    const pv_texture *t = g->at;
    int32_t s = g->scale;
    size_t n = size_of(t, s);
    float *low = g->parts->low[s];
    memset(low, 0, n * sizeof *low);
    pv_shape_gradient(t->low[s], n, pv_statistics_at(g->weights, PV_LOW_SHAPE, g->channel, s), low);
    for (size_t i = 0; i < n; i++)
        g->parts->pyramid.low[s][i].r = low[i];
    pave_result result =
        pv_parallel_runs(t->context, t->steerable.level[s].height, ROWS, grade_rows, g, 0, 0);
    return result || s + 1 >= t->steerable.scales ? result : lower_parents(g);
}

static void grade_pixels(const grading *g, const float *plane, float *out)
{
    size_t n = size_of(g->at, 0);
    pv_moments m = pv_moments_of(plane, n);
    double deviation = sqrt(m.variance), weight = pv_statistics_at(g->weights, PV_PIXELS, g->channel, 0)[1], sum = 0;
    pv_shape_gradient(plane, n, pv_statistics_at(g->weights, PV_SHAPE, g->channel, 0), out);
    pv_company_grade(g->at, g->channel, g->weights, out);
    for (size_t i = 0; i < n; i++) {
        out[i] += deviation > 0 ? (float)(weight * (plane[i] - m.mean) / deviation) : 0;
        sum += out[i];
    }
    for (size_t i = 0; i < n; i++)
        out[i] -= (float)(sum / (double)n);
}

pave_result pv_texture_gradient(const pv_texture *at, const float *plane, int32_t channel, const double *weights,
                                pv_texture *parts, float *out)
{
    pv_statistics weighted = *at->like;
    weighted.values = (double *)(uintptr_t)weights;
    grading g = { at, &weighted, channel, 0, parts };
    pave_result result = PAVE_OK;
    float high = 2 * (float)*pv_statistics_at(&weighted, PV_HIGH, channel, 0);
    clear(parts);
    for (size_t i = 0; i < size_of(at, 0); i++)
        parts->pyramid.high[i] = (pv_complex){ high * at->pyramid.high[i].r, 0 };
    for (g.scale = 0; g.scale <= at->steerable.scales && !result; g.scale++)
        result = grade_scale(&g);
    if (!result)
        result = pv_steerable_collect(at->context, &at->steerable, &parts->pyramid, 1, out);
    if (!result)
        grade_pixels(&g, plane, out);
    return result;
}
