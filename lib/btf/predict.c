/* Coefficients from what the photographs show around a texel: kernel ridge regression on some of the sample's texels
 * (Smola and Schoelkopf 2000, sparse greedy approximation without the greed), whose settings are found by holding out
 * a quarter of the sample at a time. */
#include "btf/lesson.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { MOST_TEXELS = 16384, MOST_CENTRES = 3072, TRIED_TEXELS = 4096, TRIED_CENTRES = 1024, BLOCK = 128, SIGMAS = 3,
       WIDTHS = 3, RIDGES = 3 };

static const double sigmas[SIGMAS] = { 2, 1.3, 3 }, widths[WIDTHS] = { 0.5, 1, 2 },
                    ridges[RIDGES] = { 1e-5, 1e-4, 1e-3 };

/* ---- Solving, with a quarter held out or with all ---- */

typedef struct answer {
    double ridge;
    int32_t held_out; /* a fold; -1: none */
    double *weights;  /* [coefficient][centre] */
    int solved;
} answer;

enum { MOST_ANSWERS = RIDGES * PV_FOLDS };

typedef struct solving {
    const pv_lesson *l;
    answer *answers;
    double *room; /* a matrix for each worker */
} solving;

static void solve(void *data, int32_t index, int32_t worker)
{
    const solving *s = data;
    const pv_lesson *l = s->l;
    answer *a = &s->answers[index];
    int64_t n = l->centres, sides = n * l->e->coefficients;
    double *matrix = s->room + (int64_t)worker * n * n;
    for (int64_t i = 0; i < n * n; i++)
        matrix[i] = a->ridge * (double)l->texels * l->own[i] + (i % (n + 1) ? 0 : 1e-7 * (double)l->texels);
    memset(a->weights, 0, (size_t)sides * sizeof *a->weights);
    for (int32_t fold = 0; fold < PV_FOLDS; fold++) {
        for (int64_t i = 0; i < n * n && fold != a->held_out; i++)
            matrix[i] += l->gram[fold * n * n + i];
        for (int64_t i = 0; i < sides && fold != a->held_out; i++)
            a->weights[i] += l->side[fold * sides + i];
    }
    a->solved = pv_solve_positive(&l->e->algebra, (int)n, matrix, l->e->coefficients, a->weights);
}

static pave_result solve_all(const pv_lesson *l, answer *answers, int32_t count)
{
    solving s = { .l = l, .answers = answers };
    pave_context *context = l->e->context;
    size_t n = (size_t)l->centres;
    pave_result result = PAVE_OK;
    s.room = pv_allocate(context, (size_t)pv_workers(context), n * n * sizeof *s.room, &result);
    if (!result)
        result = pv_parallel(context, count, solve, &s, 0, 0);
    pv_release(s.room);
    for (int32_t i = 0; i < count && !result; i++)
        if (!answers[i].solved)
            result = pv_fail(context, PAVE_ERR_INTERNAL, "a regression of %d kernels has no solution", (int)n);
    return result;
}

static pave_result make_answers(const pv_lesson *l, answer *answers, int32_t count)
{
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < count && !result; i++)
        answers[i].weights = pv_allocate(l->e->context, (size_t)l->centres, (size_t)l->e->coefficients *
                                         sizeof *answers[i].weights, &result);
    return result;
}

static void free_answers(answer *answers, int32_t count)
{
    for (int32_t i = 0; i < count; i++)
        pv_release(answers[i].weights);
}

/* Weights as floats, [centre][coefficient]. */
static pave_result narrow(const pv_lesson *l, const answer *a, float **out)
{
    pave_result result = PAVE_OK;
    int64_t n = l->centres, coefficients = l->e->coefficients;
    *out = pv_allocate(l->e->context, (size_t)n, (size_t)coefficients * sizeof **out, &result);
    for (int64_t i = 0; i < n * coefficients && !result; i++)
        (*out)[i % n * coefficients + i / n] = (float)a->weights[i];
    return result;
}

/* What is missed of the quarter that was held out, copies aside: [texel][coefficient]. */
static pave_result miss(const pv_lesson *l, const answer *a, float *missed)
{
    pv_enlarge *e = l->e;
    int32_t n = e->coefficients;
    int64_t first = l->from[a->held_out], rows = l->sampled[a->held_out];
    float *weights = NULL;
    pave_result result = narrow(l, a, &weights);
    if (!result) {
        pv_product product = { &e->algebra, rows, n, l->centres, l->kernel + first * l->centres, weights, missed,
                               l->centres, n, n, 0, 0 };
        result = pv_multiply_all(e->context, &product, 0, 0);
    }
    for (int64_t i = 0; i < rows * n && !result; i++)
        missed[i] -= l->target[first * n + i];
    pv_release(weights);
    return result;
}

/* Of all quarters, held out in turn. */
static pave_result miss_all(const pv_lesson *l, const answer *answers, pv_held_out *out)
{
    pave_result result = PAVE_OK;
    out->count = 0;
    for (int32_t fold = 0; fold < PV_FOLDS && !result; fold++) {
        memcpy(out->texel + out->count, l->texel + l->from[fold], (size_t)l->sampled[fold] * sizeof *out->texel);
        result = miss(l, &answers[fold], out->missed + out->count * l->e->coefficients);
        out->count += l->sampled[fold];
    }
    return result;
}

static pave_result make_held_out(const pv_lesson *l, pv_held_out *out)
{
    pave_result result = PAVE_OK;
    size_t count = 0;
    for (int32_t fold = 0; fold < PV_FOLDS; fold++)
        count += (size_t)l->sampled[fold];
    out->texel = pv_allocate(l->e->context, count, sizeof *out->texel, &result);
    if (!result)
        out->missed = pv_allocate(l->e->context, count, (size_t)l->e->coefficients * sizeof *out->missed, &result);
    return result;
}

/* ---- Settings ---- */

typedef struct settings {
    int32_t copies;
    double sigma, width, ridge, squares;
} settings;

static pave_result try_width(pv_lesson *l, double sigma, double width, answer *answers, pv_held_out *held,
                             settings *best)
{
    pave_result result = pv_lesson_study(l, width);
    for (int32_t i = 0; i < RIDGES * PV_FOLDS; i++) {
        answers[i].ridge = ridges[i / PV_FOLDS];
        answers[i].held_out = i % PV_FOLDS;
    }
    if (!result)
        result = solve_all(l, answers, RIDGES * PV_FOLDS);
    for (int32_t r = 0; r < RIDGES && !result; r++) {
        double squares = 0;
        result = miss_all(l, answers + r * PV_FOLDS, held);
        for (int64_t i = 0; i < held->count * l->e->coefficients && !result; i++)
            squares += (double)held->missed[i] * (double)held->missed[i];
        if (!result && squares < best->squares)
            *best = (settings){ l->copies, sigma, width, ridges[r], squares };
    }
    return result;
}

/* All widths, or the best so far. */
static pave_result try_sigma(pv_enlarge *e, double sigma, int32_t copies, settings *best)
{
    double width = best->width;
    pv_around around;
    pv_lesson l = { 0 };
    answer answers[MOST_ANSWERS] = { 0 };
    pv_held_out held = { 0 };
    pave_result result = pv_around_learn(e, sigma, &around);
    if (!result)
        result = pv_lesson_open(&around, copies, TRIED_TEXELS, TRIED_CENTRES, &l);
    if (!result)
        result = make_answers(&l, answers, MOST_ANSWERS);
    if (!result)
        result = make_held_out(&l, &held);
    for (int32_t w = 0; w < WIDTHS && !result; w++)
        if (width == 0 || widths[w] == width)
            result = try_width(&l, sigma, widths[w], answers, &held, best);
    free_answers(answers, MOST_ANSWERS);
    pv_held_out_free(&held);
    pv_lesson_free(&l);
    pv_around_free(&around);
    return result;
}

/* With all copies, with those that are not askew, and without: a class may have a grain, or a hand. */
static pave_result choose_settings(pv_enlarge *e, settings *best, double from, double to)
{
    pave_result result = try_sigma(e, sigmas[0], e->copies, best);
    if (!result && e->straight < e->copies)
        result = try_sigma(e, sigmas[0], e->straight, best);
    if (!result && e->straight > 1)
        result = try_sigma(e, sigmas[0], 1, best);
    for (int32_t s = 1; s < SIGMAS && !result; s++) {
        result = pv_progress(e->context, from + (to - from) * s / SIGMAS);
        if (!result)
            result = try_sigma(e, sigmas[s], best->copies, best);
    }
    return result;
}

/* ---- The whole ---- */

typedef struct telling {
    const pv_lesson *l;
    const float *features, *weights;
    float *room; /* kernels of a block of texels, for each worker */
} telling;

static void tell_block(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const telling *t = data;
    const pv_lesson *l = t->l;
    pv_enlarge *e = l->e;
    float *kernel = t->room + (int64_t)worker * BLOCK * l->centres;
    float *out = e->made.values + (int64_t)begin * e->coefficients;
    for (int32_t i = begin; i < end; i++)
        pv_lesson_kernels(l, t->features + (int64_t)i * l->features, kernel + (int64_t)(i - begin) * l->centres);
    pv_multiply(&e->algebra, 0, 0, end - begin, e->coefficients, l->centres, kernel, l->centres, t->weights,
                e->coefficients, 0, out, e->coefficients);
    for (int64_t i = 0; i < (int64_t)(end - begin) * e->coefficients; i++)
        out[i] += (float)e->middle[i % e->coefficients];
}

static pave_result tell_all(pv_lesson *l, const float *features, const float *weights, double from, double to)
{
    pv_enlarge *e = l->e;
    telling t = { l, features, weights, NULL };
    pave_result result = PAVE_OK;
    t.room = pv_allocate(e->context, (size_t)pv_workers(e->context), BLOCK * (size_t)l->centres * sizeof *t.room,
                         &result);
    if (!result)
        result = pv_parallel_runs(e->context, (int32_t)pv_texels_count(&e->made), BLOCK, tell_block, &t, from, to);
    pv_release(t.room);
    return result;
}

/* Each quarter is predicted from the others, which tells what to expect; then all teach. */
static pave_result teach(pv_lesson *l, const settings *best, float **weights)
{
    pv_enlarge *e = l->e;
    answer answers[PV_FOLDS + 1] = { 0 };
    for (int32_t i = 0; i <= PV_FOLDS; i++) {
        answers[i].ridge = best->ridge;
        answers[i].held_out = i < PV_FOLDS ? i : -1;
    }
    pave_result result = pv_lesson_study(l, best->width);
    if (!result)
        result = make_answers(l, answers, PV_FOLDS + 1);
    if (!result)
        result = solve_all(l, answers, PV_FOLDS + 1);
    if (!result)
        result = make_held_out(l, &e->held);
    if (!result)
        result = miss_all(l, answers, &e->held);
    if (!result)
        result = narrow(l, &answers[PV_FOLDS], weights);
    free_answers(answers, PV_FOLDS + 1);
    return result;
}

pave_result pv_enlarge_predict(pv_enlarge *e, double from, double to)
{
    pv_around around = { 0 };
    pv_lesson l = { 0 };
    float *weights = NULL, *features = NULL;
    settings best = { .squares = INFINITY };
    double most = from + 0.7 * (to - from);
    pave_result result = choose_settings(e, &best, from, from + 0.4 * (to - from));
    if (!result)
        result = pv_around_learn(e, best.sigma, &around);
    if (!result)
        result = pv_lesson_open(&around, best.copies, MOST_TEXELS / (best.copies > 1 ? 4 : 1), MOST_CENTRES, &l);
    if (!result)
        result = teach(&l, &best, &weights);
    if (!result)
        features = pv_allocate(e->context, (size_t)pv_texels_count(&e->made), (size_t)around.windows.to *
                               sizeof *features, &result);
    if (!result)
        result = pv_around_describe(&around, NULL, NULL, pv_texels_count(&e->made), features);
    if (!result)
        result = tell_all(&l, features, weights, most, to);
    pv_release(weights);
    pv_release(features);
    pv_around_free(&around);
    pv_lesson_free(&l);
    return result;
}
