/* Which pairs of view and light to measure: each the one that leaves least unknown (A-optimal, with the prior). */
#include "btf/model.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { RUN = 64, LANES = 4 };

/* P is the covariance of coefficients given what has been measured. Nothing but +, -, * and / in one order decides. */
typedef struct greedy {
    const pv_basis *basis;
    int64_t pairs;
    double *covariance; /* P, [component][component] */
    double *variance;   /* [pair]: u' P u */
    double *removed;    /* [pair]: |P u|^2, over variance and noise what measuring it takes away */
    double *own, *gain, *turned; /* u of the pair chosen, P u, and P times that */
    double chosen, length; /* its variance with the noise; |P u|^2 */
    uint8_t *taken;
} greedy;

static void dots(const float *row, const double *a, const double *b, int32_t count, double out[2])
{
    double one[LANES] = { 0 }, two[LANES] = { 0 };
    int32_t k = 0;
    for (; k + LANES <= count; k += LANES)
        for (int32_t j = 0; j < LANES; j++) {
            one[j] += (double)row[k + j] * a[k + j];
            two[j] += (double)row[k + j] * b[k + j];
        }
    for (; k < count; k++) {
        one[0] += (double)row[k] * a[k];
        two[0] += (double)row[k] * b[k];
    }
    out[0] = (one[0] + one[1]) + (one[2] + one[3]);
    out[1] = (two[0] + two[1]) + (two[2] + two[3]);
}

static void begin_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    greedy *g = data;
    for (int32_t p = begin; p < end; p++) {
        const float *row = g->basis->left + (int64_t)p * g->basis->components;
        double variance = 0, removed = 0;
        for (int32_t k = 0; k < g->basis->components; k++) {
            double prior = (double)g->basis->deviation[k] * (double)g->basis->deviation[k], u = (double)row[k];
            variance += prior * u * u;
            removed += prior * prior * u * u;
        }
        g->variance[p] = variance;
        g->removed[p] = removed;
    }
}

static void update_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    greedy *g = data;
    for (int32_t p = begin; p < end; p++) {
        double along[2];
        dots(g->basis->left + (int64_t)p * g->basis->components, g->gain, g->turned, g->basis->components, along);
        double share = along[0] / g->chosen;
        g->variance[p] -= share * along[0];
        g->removed[p] += share * (share * g->length - 2 * along[1]);
    }
}

static void update_covariance(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    greedy *g = data;
    for (int32_t i = begin; i < end; i++) {
        double *row = g->covariance + (int64_t)i * g->basis->components, share = g->gain[i] / g->chosen;
        for (int32_t k = 0; k < g->basis->components; k++)
            row[k] -= share * g->gain[k];
    }
}

/* P times a vector; P is symmetric. */
static void apply(const greedy *g, const double *vector, double *out)
{
    int32_t n = g->basis->components;
    for (int32_t i = 0; i < n; i++) {
        const double *row = g->covariance + (int64_t)i * n;
        double sum[LANES] = { 0 };
        int32_t k = 0;
        for (; k + LANES <= n; k += LANES)
            for (int32_t j = 0; j < LANES; j++)
                sum[j] += row[k + j] * vector[k + j];
        for (; k < n; k++)
            sum[0] += row[k] * vector[k];
        out[i] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    }
}

static int32_t find_best(const greedy *g, double noise)
{
    int32_t best = -1;
    double most = 0;
    for (int32_t p = 0; p < g->pairs; p++) {
        double score = g->removed[p] / (fmax(g->variance[p], 0) + noise);
        if (!g->taken[p] && (best < 0 || score > most)) {
            most = score;
            best = p;
        }
    }
    return best;
}

static pave_result measure(pave_context *context, greedy *g, int32_t pair, double noise, double *left)
{
    int32_t n = g->basis->components;
    const float *row = g->basis->left + (int64_t)pair * n;
    double along = 0;
    for (int32_t k = 0; k < n; k++)
        g->own[k] = (double)row[k];
    apply(g, g->own, g->gain);
    apply(g, g->gain, g->turned);
    g->length = 0;
    for (int32_t k = 0; k < n; k++) {
        along += g->own[k] * g->gain[k];
        g->length += g->gain[k] * g->gain[k];
    }
    g->chosen = fmax(along, 0) + noise;
    g->taken[pair] = 1;
    *left = fmax(*left - g->length / g->chosen, 0);
    pave_result result = pv_parallel_runs(context, (int32_t)g->pairs, RUN, update_rows, g, 0, 0);
    return result ? result : pv_parallel_runs(context, n, RUN, update_covariance, g, 0, 0);
}

static pave_result open_greedy(pave_context *context, greedy *g)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)g->basis->components, pairs = (size_t)g->pairs;
    g->covariance = pv_allocate_zeroed(context, n, n * sizeof(double), &result);
    if (!result)
        g->variance = pv_allocate(context, pairs, sizeof(double), &result);
    if (!result)
        g->removed = pv_allocate(context, pairs, sizeof(double), &result);
    if (!result)
        g->own = pv_allocate(context, n, sizeof(double), &result);
    if (!result)
        g->gain = pv_allocate(context, n, sizeof(double), &result);
    if (!result)
        g->turned = pv_allocate(context, n, sizeof(double), &result);
    if (!result)
        g->taken = pv_allocate_zeroed(context, pairs, 1, &result);
    for (size_t k = 0; k < n && !result; k++)
        g->covariance[k * n + k] = (double)g->basis->deviation[k] * (double)g->basis->deviation[k];
    return result ? result : pv_parallel_runs(context, (int32_t)pairs, RUN, begin_rows, g, 0, 0);
}

static void close_greedy(greedy *g)
{
    pv_release(g->covariance);
    pv_release(g->variance);
    pv_release(g->removed);
    pv_release(g->own);
    pv_release(g->gain);
    pv_release(g->turned);
    pv_release(g->taken);
}

/* The trace of the prior. */
static double whole_of(const pv_basis *basis)
{
    double sum = 0;
    for (int32_t k = 0; k < basis->components; k++)
        sum += (double)basis->deviation[k] * (double)basis->deviation[k];
    return sum;
}

pave_result pv_plan_greedy(pave_context *context, const pave_btf_model *model, double noise, int32_t count,
                           int32_t *pairs, double *left)
{
    greedy g = { .basis = &model->basis[0][PV_OF_TEXELS], .pairs = pv_model_pairs(model) };
    double remains = whole_of(g.basis);
    pave_result result = open_greedy(context, &g);
    for (int32_t i = 0; i < count && !result; i++) {
        pairs[i] = find_best(&g, noise);
        result = measure(context, &g, pairs[i], noise, &remains);
        if (left)
            left[i] = remains;
        if (!result)
            result = pv_progress(context, (i + 1.0) / count);
    }
    close_greedy(&g);
    return result;
}

/* ---- Whole views and whole lights ---- */

typedef struct dome {
    int32_t views, lights;   /* of the model */
    uint8_t *view, *light;   /* chosen */
    int32_t view_count, light_count;
} dome;

/* What the pairs of a view with the chosen lights, or of a light with the chosen views, would take away one by one. */
static double score_line(const greedy *g, const dome *d, int of_light, int32_t line, double noise)
{
    double sum = 0;
    for (int32_t i = 0; i < (of_light ? d->views : d->lights); i++) {
        int64_t pair = of_light ? (int64_t)i * d->lights + line : (int64_t)line * d->lights + i;
        if (of_light ? d->view[i] : d->light[i])
            sum += g->removed[pair] / (fmax(g->variance[pair], 0) + noise);
    }
    return sum;
}

/* The view or light that brings most for its cost; -1 if none fits. */
static int32_t best_line(const greedy *g, const dome *d, double noise, double shot_cost, int32_t room, int *of_light)
{
    int32_t best = -1;
    double most = -INFINITY;
    for (int light = 0; light < 2; light++) {
        int32_t pictures = light ? d->view_count : d->light_count;
        for (int32_t i = 0; i < (light ? d->lights : d->views) && pictures <= room; i++) {
            double score = score_line(g, d, light, i, noise) / (pictures + (light ? shot_cost : 0));
            if ((light ? d->light[i] : d->view[i]) || !(score > most))
                continue;
            most = score;
            best = i;
            *of_light = light;
        }
    }
    return best;
}

static pave_result open_dome(pave_context *context, const pave_btf_model *model, dome *d)
{
    pave_result result = PAVE_OK;
    d->views = model->views.count;
    d->lights = model->lights.count;
    d->view = pv_allocate_zeroed(context, (size_t)d->views, 1, &result);
    if (!result)
        d->light = pv_allocate_zeroed(context, (size_t)d->lights, 1, &result);
    return result;
}

/* Measures the pairs of a line in their order. */
static pave_result take_line(pave_context *context, greedy *g, dome *d, int of_light, int32_t line, double noise,
                             double *remains, int32_t *pairs, double *left, int32_t *at)
{
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < (of_light ? d->views : d->lights) && !result; i++) {
        if (!(of_light ? d->view[i] : d->light[i]))
            continue;
        pairs[*at] = of_light ? i * d->lights + line : line * d->lights + i;
        result = measure(context, g, pairs[*at], noise, remains);
        left[(*at)++] = *remains;
    }
    (of_light ? d->light : d->view)[line] = 1;
    d->view_count += !of_light;
    d->light_count += of_light;
    return result;
}

pave_result pv_plan_dome(pave_context *context, const pave_btf_model *model, double noise, double shot_cost,
                         int32_t *pairs, double *left, int32_t *count)
{
    greedy g = { .basis = &model->basis[0][PV_OF_TEXELS], .pairs = pv_model_pairs(model) };
    dome d = { 0 };
    int32_t at = 0, room = *count, line;
    int of_light = 1;
    double remains = whole_of(g.basis);
    pave_result result = open_greedy(context, &g);
    if (!result)
        result = open_dome(context, model, &d);
    if (!result) { /* the first pair is the best one by itself */
        int32_t first = find_best(&g, noise);
        d.view[first / d.lights] = 1;
        d.view_count = 1;
        result = take_line(context, &g, &d, 1, first % d.lights, noise, &remains, pairs, left, &at);
    }
    while (!result && (line = best_line(&g, &d, noise, shot_cost, room - at, &of_light)) >= 0) {
        result = take_line(context, &g, &d, of_light, line, noise, &remains, pairs, left, &at);
        if (!result)
            result = pv_progress(context, (double)at / room);
    }
    *count = at;
    pv_release(d.view);
    pv_release(d.light);
    close_greedy(&g);
    return result;
}
