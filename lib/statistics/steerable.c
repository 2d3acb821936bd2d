/* The complex steerable pyramid, by masks on Fourier transforms. */
#include "statistics/steerable.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { ROWS = 16, TASK = 4096 }; /* of a task, rows at least and pixels */

static const double PI = 3.14159265358979323846;

/* Raised cosines on a logarithmic scale, whose squares add up to 1: low passes up to pi / 4 and nothing from pi / 2. */
static double low_at(double r)
{
    return r <= PI / 4 ? 1 : r >= PI / 2 ? 0 : cos(PI / 2 * log2(4 * r / PI));
}

static double high_at(double r)
{
    return r <= PI / 4 ? 0 : r >= PI / 2 ? 1 : sin(PI / 2 * log2(4 * r / PI));
}

/* What makes the squares of all orientations' cosines to their power add up to 1. */
static double angular_scale(int32_t orientations)
{
    double power = orientations - 1;
    return exp(power * log(2.0) + lgamma(power + 1) - (log(orientations) + lgamma(2 * power + 1)) / 2);
}

static double frequency(int32_t i, int32_t count)
{
    return 2 * PI * (i < (count + 1) / 2 ? i : i - count) / count;
}

/* A level's masks. */
typedef struct masking {
    pv_steerable_level *level;
    int32_t orientations;
    double scale, x[PV_MOST_ORIENTATIONS], y[PV_MOST_ORIENTATIONS]; /* where each orientation points */
} masking;

static void mask_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    const masking *m = data;
    const pv_steerable_level *level = m->level;
    for (int32_t y = begin; y < end; y++)
        for (int32_t x = 0; x < level->width; x++) {
            double u = frequency(x, level->width), v = frequency(y, level->height), r = sqrt(u * u + v * v);
            size_t i = (size_t)y * (size_t)level->width + (size_t)x;
            double high = high_at(r) * m->scale;
            level->low[i] = (float)low_at(r);
            for (int32_t k = 0; k < m->orientations; k++) {
                double towards = r > 0 ? (u * m->x[k] + v * m->y[k]) / r : 0;
                level->band[k][i] = towards > 1e-12 && high > 0 ? (float)(high * pow(towards, m->orientations - 1)) : 0;
            }
        }
}

static pave_result fill_masks(pave_context *context, pv_steerable_level *level, int32_t orientations)
{
    masking m = { .level = level, .orientations = orientations, .scale = 2 * angular_scale(orientations) };
    for (int32_t k = 0; k < orientations; k++)
        m.x[k] = cos(PI * k / orientations), m.y[k] = sin(PI * k / orientations);
    return pv_parallel_runs(context, level->height, ROWS, mask_rows, &m, 0, 0);
}

static pave_result make_level(pave_context *context, int32_t width, int32_t height, int32_t orientations,
                              pv_steerable_level *level)
{
    size_t n = (size_t)width * (size_t)height;
    level->width = width, level->height = height;
    pave_result result = pv_fourier_create(context, width, height, &level->fourier);
    if (!result && orientations)
        level->low = pv_allocate(context, n, sizeof *level->low, &result);
    for (int32_t k = 0; k < orientations && !result; k++)
        level->band[k] = pv_allocate(context, n, sizeof *level->band[k], &result);
    return result || !orientations ? result : fill_masks(context, level, orientations);
}

static void first_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    pv_steerable *s = data;
    const pv_steerable_level *level = &s->level[0];
    for (int32_t y = begin; y < end; y++)
        for (int32_t x = 0; x < level->width; x++) {
            double u = frequency(x, level->width), v = frequency(y, level->height), r = sqrt(u * u + v * v);
            size_t i = (size_t)y * (size_t)level->width + (size_t)x;
            s->first_low[i] = (float)low_at(r / 2);
            s->first_high[i] = (float)high_at(r / 2);
        }
}

static pave_result make_first(pave_context *context, pv_steerable *s)
{
    pave_result result = PAVE_OK;
    s->first_low = pv_allocate(context, pv_level_size(s, 0), sizeof *s->first_low, &result);
    s->first_high = result ? NULL : pv_allocate(context, pv_level_size(s, 0), sizeof *s->first_high, &result);
    return result ? result : pv_parallel_runs(context, s->level[0].height, ROWS, first_rows, s, 0, 0);
}

pave_result pv_steerable_create(pave_context *context, int32_t width, int32_t height, int32_t scales,
                                int32_t orientations, pv_steerable *out)
{
    pave_result result = PAVE_OK;
    memset(out, 0, sizeof *out);
    out->scales = scales, out->orientations = orientations;
    if (width >> scales << scales != width || height >> scales << scales != height || width < 1 || height < 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%d x %d px do not divide into %d scales", (int)width, (int)height,
                       (int)scales);
    for (int32_t s = 0; s <= scales && !result; s++)
        result = make_level(context, width >> s, height >> s, s < scales ? orientations : 0, &out->level[s]);
    if (!result)
        result = make_first(context, out);
    if (result)
        pv_steerable_free(out);
    return result;
}

void pv_steerable_free(pv_steerable *steerable)
{
    for (int32_t s = 0; s <= PV_MOST_SCALES; s++) {
        pv_fourier_free(&steerable->level[s].fourier);
        pv_release(steerable->level[s].low);
        for (int32_t k = 0; k < PV_MOST_ORIENTATIONS; k++)
            pv_release(steerable->level[s].band[k]);
    }
    pv_release(steerable->first_low);
    pv_release(steerable->first_high);
    memset(steerable, 0, sizeof *steerable);
}

pave_result pv_pyramid_create(pave_context *context, const pv_steerable *steerable, pv_pyramid *out)
{
    pave_result result = PAVE_OK;
    memset(out, 0, sizeof *out);
    out->high = pv_allocate(context, pv_level_size(steerable, 0), sizeof *out->high, &result);
    for (int32_t s = 0; s <= steerable->scales && !result; s++) {
        size_t n = pv_level_size(steerable, s);
        out->low[s] = pv_allocate(context, n, sizeof *out->low[s], &result);
        for (int32_t k = 0; k < steerable->orientations && s < steerable->scales && !result; k++)
            out->band[s][k] = pv_allocate(context, n, sizeof *out->band[s][k], &result);
    }
    if (result)
        pv_pyramid_free(out);
    return result;
}

void pv_pyramid_free(pv_pyramid *pyramid)
{
    pv_release(pyramid->high);
    for (int32_t s = 0; s <= PV_MOST_SCALES; s++)
        pv_release(pyramid->low[s]);
    for (int32_t i = 0; i < PV_MOST_SCALES * PV_MOST_ORIENTATIONS; i++)
        pv_release(pyramid->band[i / PV_MOST_ORIENTATIONS][i % PV_MOST_ORIENTATIONS]);
    memset(pyramid, 0, sizeof *pyramid);
}

/* Times mask times i to the power `turns`. */
static inline pv_complex turned(pv_complex z, float mask, int turns)
{
    float r = z.r * mask, i = z.i * mask;
    switch (turns & 3) {
    case 0: return (pv_complex){ r, i };
    case 1: return (pv_complex){ -i, r };
    case 2: return (pv_complex){ -r, -i };
    default: return (pv_complex){ i, -r };
    }
}

/* Where the frequency of a coarser spectrum is in the finer one. */
static inline int32_t finer(int32_t i, int32_t count, int32_t fine)
{
    return i < (count + 1) / 2 ? i : i + fine - count;
}

typedef struct levelling {
    const pv_steerable *steerable;
    pv_pyramid *pyramid;
    int32_t level;
    int add;
} levelling;

static int32_t rows_of(const pv_steerable_level *level)
{
    return TASK / level->width > ROWS ? TASK / level->width : ROWS;
}

static void split_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    const levelling *l = data;
    const pv_steerable *s = l->steerable;
    const pv_steerable_level *level = &s->level[l->level], *next = level + 1;
    const pv_complex *from = l->pyramid->low[l->level];
    size_t first = (size_t)begin * (size_t)level->width, last = (size_t)end * (size_t)level->width;
    for (int32_t k = 0; k < s->orientations; k++)
        for (size_t i = first; i < last; i++)
            l->pyramid->band[l->level][k][i] = turned(from[i], level->band[k][i], -(s->orientations - 1));
    for (int32_t y = begin; y < end && y < next->height; y++)
        for (int32_t x = 0; x < next->width; x++) {
            size_t i = (size_t)finer(y, next->height, level->height) * (size_t)level->width +
                       (size_t)finer(x, next->width, level->width);
            l->pyramid->low[l->level + 1][(size_t)y * (size_t)next->width + (size_t)x] =
                turned(from[i], level->low[i] / 4, 0);
        }
}

pave_result pv_steerable_split(pave_context *context, const pv_steerable *steerable, pv_pyramid *pyramid,
                               int32_t level)
{
    levelling l = { steerable, pyramid, level, 0 };
    return pv_parallel_runs(context, steerable->level[level].height, rows_of(&steerable->level[level]), split_rows, &l,
                            0, 0);
}

static void join_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    const levelling *l = data;
    const pv_steerable *s = l->steerable;
    const pv_steerable_level *level = &s->level[l->level];
    pv_complex *to = l->pyramid->low[l->level];
    size_t first = (size_t)begin * (size_t)level->width, last = (size_t)end * (size_t)level->width;
    if (!l->add)
        memset(to + first, 0, (last - first) * sizeof *to);
    for (int32_t k = 0; k < s->orientations; k++)
        for (size_t i = first; i < last; i++) {
            pv_complex z = turned(l->pyramid->band[l->level][k][i], level->band[k][i], s->orientations - 1);
            to[i].r += z.r, to[i].i += z.i;
        }
}

static void join_low(const levelling *l)
{
    const pv_steerable_level *level = &l->steerable->level[l->level], *next = level + 1;
    for (int32_t y = 0; y < next->height; y++)
        for (int32_t x = 0; x < next->width; x++) {
            size_t i = (size_t)finer(y, next->height, level->height) * (size_t)level->width +
                       (size_t)finer(x, next->width, level->width);
            pv_complex z = l->pyramid->low[l->level + 1][(size_t)y * (size_t)next->width + (size_t)x];
            l->pyramid->low[l->level][i].r += z.r * 4 * level->low[i];
            l->pyramid->low[l->level][i].i += z.i * 4 * level->low[i];
        }
}

pave_result pv_steerable_join(pave_context *context, const pv_steerable *steerable, pv_pyramid *pyramid, int32_t level,
                              int add)
{
    levelling l = { steerable, pyramid, level, add };
    pave_result result =
        pv_parallel_runs(context, steerable->level[level].height, rows_of(&steerable->level[level]), join_rows, &l,
                         0, 0);
    if (!result)
        join_low(&l);
    return result;
}

void pv_steerable_expand(const pv_steerable *steerable, int32_t level, const pv_complex *spectrum, pv_complex *out)
{
    const pv_steerable_level *small = &steerable->level[level], *large = small - 1;
    memset(out, 0, pv_level_size(steerable, level - 1) * sizeof *out);
    for (int32_t y = 0; y < small->height; y++)
        for (int32_t x = 0; x < small->width; x++)
            out[(size_t)finer(y, small->height, large->height) * (size_t)large->width +
                (size_t)finer(x, small->width, large->width)] =
                turned(spectrum[(size_t)y * (size_t)small->width + (size_t)x], 4, 0);
}

void pv_steerable_shrink(const pv_steerable *steerable, int32_t level, const pv_complex *spectrum, pv_complex *out)
{
    const pv_steerable_level *large = &steerable->level[level], *small = large + 1;
    for (int32_t y = 0; y < small->height; y++)
        for (int32_t x = 0; x < small->width; x++)
            out[(size_t)y * (size_t)small->width + (size_t)x] =
                turned(spectrum[(size_t)finer(y, small->height, large->height) * (size_t)large->width +
                                (size_t)finer(x, small->width, large->width)], 0.25f, 0);
}

typedef struct spreading {
    const pv_steerable *steerable;
    const double *weights;
    float *out;
} spreading;

static void spread_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    const spreading *to = data;
    const pv_steerable *steerable = to->steerable;
    const pv_steerable_level *level = &steerable->level[0];
    const double *weights = to->weights;
    for (int32_t y = begin; y < end; y++)
        for (int32_t x = 0; x < level->width; x++) {
            double u = frequency(x, level->width), v = frequency(y, level->height), r = sqrt(u * u + v * v);
            double left = low_at(r / 2) * low_at(r / 2), sum = weights[0] * (1 - left);
            for (int32_t s = 0; s < steerable->scales; s++, r *= 2) {
                double low = low_at(r) * low_at(r);
                sum += weights[1 + s] * left * (1 - low);
                left *= low;
            }
            sum += weights[1 + steerable->scales] * left;
            to->out[(size_t)y * (size_t)level->width + (size_t)x] = (float)sum;
        }
}

pave_result pv_steerable_spread(pave_context *context, const pv_steerable *steerable, const double *weights,
                                float *out)
{
    spreading to = { steerable, weights, out };
    return pv_parallel_runs(context, steerable->level[0].height, ROWS, spread_rows, &to, 0, 0);
}

/* All planes of a level, as pv_fourier_ takes them. */
static int32_t planes_of(const pv_steerable *steerable, pv_pyramid *pyramid, int32_t level, int low,
                         pv_complex *planes[PV_MOST_ORIENTATIONS + 2])
{
    int32_t count = 0;
    if (level == 0)
        planes[count++] = pyramid->high;
    if (low || level == steerable->scales)
        planes[count++] = pyramid->low[level];
    for (int32_t k = 0; k < steerable->orientations && level < steerable->scales; k++)
        planes[count++] = pyramid->band[level][k];
    return count;
}

pave_result pv_steerable_analyse(pave_context *context, const pv_steerable *steerable, const float *plane, double mean,
                                 pv_pyramid *out)
{
    size_t n = pv_level_size(steerable, 0);
    pv_complex *planes[PV_MOST_ORIENTATIONS + 2];
    for (size_t i = 0; i < n; i++)
        out->high[i] = (pv_complex){ (float)(plane[i] - mean), 0 };
    pave_result result = pv_fourier_forth(context, &steerable->level[0].fourier, 1, &out->high);
    for (size_t i = 0; i < n && !result; i++) {
        out->low[0][i] = turned(out->high[i], steerable->first_low[i], 0);
        out->high[i] = turned(out->high[i], steerable->first_high[i], 0);
    }
    for (int32_t s = 0; s < steerable->scales && !result; s++)
        result = pv_steerable_split(context, steerable, out, s);
    for (int32_t s = 0; s <= steerable->scales && !result; s++)
        result = pv_fourier_back(context, &steerable->level[s].fourier, planes_of(steerable, out, s, 1, planes),
                                 planes);
    return result;
}

pave_result pv_steerable_collect(pave_context *context, const pv_steerable *steerable, pv_pyramid *parts, int lows,
                                 float *plane)
{
    size_t n = pv_level_size(steerable, 0);
    pave_result result = PAVE_OK;
    pv_complex *planes[PV_MOST_ORIENTATIONS + 2];
    for (int32_t s = 0; s <= steerable->scales && !result; s++)
        result = pv_fourier_forth(context, &steerable->level[s].fourier, planes_of(steerable, parts, s, lows, planes),
                                  planes);
    for (int32_t s = steerable->scales - 1; s >= 0 && !result; s--)
        result = pv_steerable_join(context, steerable, parts, s, lows);
    for (size_t i = 0; i < n && !result; i++) {
        pv_complex low = turned(parts->low[0][i], steerable->first_low[i], 0);
        pv_complex high = turned(parts->high[i], steerable->first_high[i], 0);
        parts->high[i] = (pv_complex){ low.r + high.r, low.i + high.i };
    }
    if (!result)
        result = pv_fourier_back(context, &steerable->level[0].fourier, 1, &parts->high);
    for (size_t i = 0; i < n && !result; i++)
        plane[i] = parts->high[i].r;
    return result;
}
