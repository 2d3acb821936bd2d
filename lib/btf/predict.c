/* Coefficients from what the photographs show around a texel: kernel ridge regression on some of the sample's texels
 * (Smola and Schoelkopf 2000, sparse greedy approximation without the greed), whose settings are found by holding out
 * a quarter of the sample at a time. */
#include "btf/enlarge.h"

#include "base/parallel.h"
#include "util/random.h"

#include <math.h>
#include <string.h>

enum { FOLDS = 4, MORE = 3, MOST_TEXELS = 16384, MOST_CENTRES = 3072, TRIED_TEXELS = 4096, TRIED_CENTRES = 1024,
       BLOCK = 128, SIGMAS = 3, WIDTHS = 3, RIDGES = 3 };

static const double sigmas[SIGMAS] = { 2, 1.3, 3 }, widths[WIDTHS] = { 0.5, 1, 2 },
                    ridges[RIDGES] = { 1e-5, 1e-4, 1e-3 };

/* Texels of the sample that are learned from, quarter after quarter, those of its copies after its own, and some of
 * them that kernels stand on. */
typedef struct lesson {
    pv_enlarge *e;
    const pv_around *around;
    int32_t copies, texels, centres, features;
    int32_t sampled[FOLDS], copied[FOLDS]; /* texels of a quarter in the sample, and in each copy */
    int32_t from[FOLDS + 1];
    float *feature; /* [texel][feature] */
    float *target;  /* [texel][coefficient], less the mean */
    float *centre;  /* [centre][feature] */
    double scale;   /* mean square distance of texels and centres */
    double width;   /* of the kernel: exp(-distance^2 / (2 width scale)) */
    float *kernel;  /* [texel][centre] */
    double *own;    /* [centre][centre] */
    double *gram;   /* [fold][centre][centre]: kernel' kernel */
    double *side;   /* [fold][coefficient][centre]: target' kernel */
} lesson;

static void free_lesson(lesson *l)
{
    pv_release(l->feature);
    pv_release(l->target);
    pv_release(l->centre);
    pv_release(l->kernel);
    pv_release(l->own);
    pv_release(l->gram);
    pv_release(l->side);
}

/* ---- What is learned from ---- */

static double distance(const float *a, const float *b, int32_t n)
{
    float sum[8] = { 0 };
    int32_t i = 0;
    for (; i + 8 <= n; i += 8)
        for (int32_t k = 0; k < 8; k++)
            sum[k] += (a[i + k] - b[i + k]) * (a[i + k] - b[i + k]);
    for (; i < n; i++)
        sum[0] += (a[i] - b[i]) * (a[i] - b[i]);
    return ((double)sum[0] + (double)sum[1]) + ((double)sum[2] + (double)sum[3]) + ((double)sum[4] + (double)sum[5]) +
           ((double)sum[6] + (double)sum[7]);
}

/* The k-th of so many texels that are spread over a part of the sample, at a place within its share drawn by chance. */
static int64_t texel_of(const pv_enlarge *e, int32_t fold, int32_t copy, int32_t k, int32_t count)
{
    int32_t width = e->known.width, height = e->known.height;
    int32_t left = fold % 2 * (width / 2), top = fold / 2 * (height / 2);
    int64_t wide = fold % 2 ? width - width / 2 : width / 2, high = fold / 2 ? height - height / 2 : height / 2;
    int64_t first = k * wide * high / count, after = (k + 1) * wide * high / count;
    int64_t at = first + pv_below(pv_draw(0, PV_DRAW_SKETCH, (uint32_t)k, (uint32_t)fold, 1 + (uint32_t)copy).word[0],
                                  (uint32_t)(after - first));
    return (top + at / wide) * width + left + at % wide;
}

static int32_t texels_of_fold(const pv_enlarge *e, int32_t fold, int32_t most)
{
    int64_t wide = fold % 2 ? e->known.width - e->known.width / 2 : e->known.width / 2;
    int64_t high = fold / 2 ? e->known.height - e->known.height / 2 : e->known.height / 2;
    return (int32_t)(wide * high < most / FOLDS ? wide * high : most / FOLDS);
}

/* So many texels of a quarter in one copy, from the first row on. */
static pave_result fill_part(lesson *l, int32_t fold, int32_t copy, int32_t first, int32_t count)
{
    const pv_enlarge *e = l->e;
    int32_t n = e->coefficients;
    pave_result result = PAVE_OK;
    int64_t *texels = pv_allocate(e->context, (size_t)count, sizeof *texels, &result);
    for (int32_t k = 0; k < count && !result; k++) {
        float *target = l->target + (int64_t)(first + k) * n;
        texels[k] = texel_of(e, fold, copy, k, count);
        pv_enlarge_copied(e, &e->copy[copy], texels[k], target);
        for (int32_t c = 0; c < n; c++)
            target[c] -= (float)e->middle[c];
    }
    if (!result)
        result = pv_around_describe(l->around, &e->copy[copy], texels, count,
                                    l->feature + (int64_t)first * l->features);
    pv_release(texels);
    return result;
}

static pave_result fill_lesson(lesson *l)
{
    pave_result result = PAVE_OK;
    for (int32_t fold = 0; fold < FOLDS && !result; fold++) {
        result = fill_part(l, fold, 0, l->from[fold], l->sampled[fold]);
        for (int32_t copy = 1; copy < l->copies && !result; copy++)
            result = fill_part(l, fold, copy, l->from[fold] + l->sampled[fold] + (copy - 1) * l->copied[fold],
                               l->copied[fold]);
    }
    if (result)
        return result;
    for (int32_t k = 0; k < l->centres; k++)
        memcpy(l->centre + (int64_t)k * l->features, l->feature + (int64_t)k * l->texels / l->centres * l->features,
               (size_t)l->features * sizeof(float));
    for (int32_t k = 0; k < l->texels; k++) /* a pair each: the mean is all that is needed */
        l->scale += distance(l->feature + (int64_t)k * l->features,
                             l->centre + (int64_t)(k * 7919LL % l->centres) * l->features, l->features) / l->texels;
    l->scale = fmax(l->scale, 1e-12);
    return PAVE_OK;
}

/* At most so many texels of the sample, and three times as many of its copies. */
static void count_rows(lesson *l, int32_t most)
{
    for (int32_t fold = 0; fold < FOLDS; fold++) {
        int32_t own = l->sampled[fold] = texels_of_fold(l->e, fold, most), others = l->copies - 1;
        l->copied[fold] = others > MORE ? MORE * own / others : own;
        l->from[fold + 1] = l->from[fold] + own + others * l->copied[fold];
    }
}

static pave_result open_lesson(const pv_around *around, int32_t copies, int32_t most, int32_t centres, lesson *l)
{
    pv_enlarge *e = around->e;
    pave_result result = PAVE_OK;
    *l = (lesson){ .e = e, .around = around, .copies = copies, .features = around->features };
    count_rows(l, most);
    l->texels = l->from[FOLDS];
    l->centres = l->texels < centres ? l->texels : centres;
    size_t texels = (size_t)l->texels, middle = (size_t)l->centres, bytes = (size_t)l->features * sizeof(float);
    l->feature = pv_allocate(e->context, texels, bytes, &result);
    if (!result)
        l->target = pv_allocate(e->context, texels, (size_t)e->coefficients * sizeof *l->target, &result);
    if (!result)
        l->centre = pv_allocate(e->context, middle, bytes, &result);
    if (!result)
        l->kernel = pv_allocate(e->context, texels, middle * sizeof *l->kernel, &result);
    if (!result)
        l->own = pv_allocate(e->context, middle, middle * sizeof *l->own, &result);
    if (!result)
        l->gram = pv_allocate(e->context, FOLDS * middle, middle * sizeof *l->gram, &result);
    if (!result)
        l->side = pv_allocate(e->context, FOLDS * middle, (size_t)e->coefficients * sizeof *l->side, &result);
    if (!result)
        result = fill_lesson(l);
    return result;
}

/* ---- Kernels ---- */

static void kernels_of(const lesson *l, const float *feature, float *out)
{
    for (int32_t k = 0; k < l->centres; k++)
        out[k] = (float)exp(-distance(feature, l->centre + (int64_t)k * l->features, l->features) /
                            (2 * l->width * l->scale));
}

static void find_kernel(void *data, int32_t texel, int32_t worker)
{
    (void)worker;
    const lesson *l = data;
    kernels_of(l, l->feature + (int64_t)texel * l->features, l->kernel + (int64_t)texel * l->centres);
}

static void find_own(void *data, int32_t k, int32_t worker)
{
    (void)worker;
    const lesson *l = data;
    const float *centre = l->centre + (int64_t)k * l->features;
    double *row = l->own + (int64_t)k * l->centres;
    for (int32_t i = 0; i < l->centres; i++)
        row[i] = exp(-distance(centre, l->centre + (int64_t)i * l->features, l->features) / (2 * l->width * l->scale));
}

/* Sums over each quarter, with a kernel of that width. */
static pave_result study(lesson *l, double width)
{
    pv_enlarge *e = l->e;
    l->width = width;
    pave_result result = pv_parallel(e->context, l->texels, find_kernel, l, 0, 0);
    if (!result)
        result = pv_parallel(e->context, l->centres, find_own, l, 0, 0);
    for (int32_t fold = 0; fold < FOLDS && !result; fold++) {
        int64_t rows = l->from[fold + 1] - l->from[fold], first = l->from[fold], each = l->centres;
        result = pv_gram(e->context, &e->algebra, rows, l->centres, l->kernel + first * each,
                         l->gram + fold * each * each);
        if (!result)
            result = pv_cross(e->context, &e->algebra, rows, l->centres, l->kernel + first * each, e->coefficients,
                              l->target + first * e->coefficients, l->side + fold * each * e->coefficients);
    }
    return result;
}

/* ---- Solving, with a quarter held out or with all ---- */

typedef struct answer {
    double ridge;
    int32_t held_out; /* a fold; -1: none */
    double *weights;  /* [coefficient][centre] */
    int solved;
} answer;

enum { MOST_ANSWERS = RIDGES * FOLDS };

typedef struct solving {
    const lesson *l;
    answer *answers;
    double *room; /* a matrix for each worker */
} solving;

static void solve(void *data, int32_t index, int32_t worker)
{
    const solving *s = data;
    const lesson *l = s->l;
    answer *a = &s->answers[index];
    int64_t n = l->centres, sides = n * l->e->coefficients;
    double *matrix = s->room + (int64_t)worker * n * n;
    for (int64_t i = 0; i < n * n; i++)
        matrix[i] = a->ridge * (double)l->texels * l->own[i] + (i % (n + 1) ? 0 : 1e-7 * (double)l->texels);
    memset(a->weights, 0, (size_t)sides * sizeof *a->weights);
    for (int32_t fold = 0; fold < FOLDS; fold++) {
        for (int64_t i = 0; i < n * n && fold != a->held_out; i++)
            matrix[i] += l->gram[fold * n * n + i];
        for (int64_t i = 0; i < sides && fold != a->held_out; i++)
            a->weights[i] += l->side[fold * sides + i];
    }
    a->solved = pv_solve_positive(&l->e->algebra, (int)n, matrix, l->e->coefficients, a->weights);
}

static pave_result solve_all(const lesson *l, answer *answers, int32_t count)
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

static pave_result make_answers(const lesson *l, answer *answers, int32_t count)
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
static pave_result narrow(const lesson *l, const answer *a, float **out)
{
    pave_result result = PAVE_OK;
    int64_t n = l->centres, coefficients = l->e->coefficients;
    *out = pv_allocate(l->e->context, (size_t)n, (size_t)coefficients * sizeof **out, &result);
    for (int64_t i = 0; i < n * coefficients && !result; i++)
        (*out)[i % n * coefficients + i / n] = (float)a->weights[i];
    return result;
}

/* What is missed of the quarter that was held out, copies aside: squares, and with `spread` their products, are added
 * up. */
static pave_result miss(const lesson *l, const answer *a, double *squares, double *spread)
{
    pv_enlarge *e = l->e;
    int32_t n = e->coefficients;
    int64_t first = l->from[a->held_out], rows = l->sampled[a->held_out];
    float *weights = NULL, *missed = NULL;
    double *products = NULL, own = 0;
    for (int32_t fold = 0; fold < FOLDS; fold++)
        own += l->sampled[fold];
    pave_result result = narrow(l, a, &weights);
    if (!result)
        missed = pv_allocate(e->context, (size_t)rows, (size_t)n * sizeof *missed, &result);
    if (!result) {
        pv_product product = { &e->algebra, rows, n, l->centres, l->kernel + first * l->centres, weights, missed,
                               l->centres, n, n, 0, 0 };
        result = pv_multiply_all(e->context, &product, 0, 0);
    }
    for (int64_t i = 0; i < rows * n && !result; i++) {
        missed[i] -= l->target[first * n + i];
        *squares += (double)missed[i] * (double)missed[i];
    }
    if (!result && spread)
        products = pv_allocate(e->context, (size_t)n, (size_t)n * sizeof *products, &result);
    if (!result && spread)
        result = pv_gram(e->context, &e->algebra, rows, n, missed, products);
    for (int32_t i = 0; i < n * n && spread && !result; i++)
        spread[i] += products[i] / own;
    pv_release(products);
    pv_release(weights);
    pv_release(missed);
    return result;
}

/* ---- Settings ---- */

typedef struct settings {
    int32_t copies;
    double sigma, width, ridge, squares;
} settings;

static pave_result try_width(lesson *l, double sigma, double width, answer *answers, settings *best)
{
    pave_result result = study(l, width);
    for (int32_t i = 0; i < RIDGES * FOLDS; i++) {
        answers[i].ridge = ridges[i / FOLDS];
        answers[i].held_out = i % FOLDS;
    }
    if (!result)
        result = solve_all(l, answers, RIDGES * FOLDS);
    for (int32_t r = 0; r < RIDGES && !result; r++) {
        double squares = 0;
        for (int32_t fold = 0; fold < FOLDS && !result; fold++)
            result = miss(l, &answers[r * FOLDS + fold], &squares, NULL);
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
    lesson l = { 0 };
    answer answers[MOST_ANSWERS] = { 0 };
    pave_result result = pv_around_learn(e, sigma, &around);
    if (!result)
        result = open_lesson(&around, copies, TRIED_TEXELS, TRIED_CENTRES, &l);
    if (!result)
        result = make_answers(&l, answers, MOST_ANSWERS);
    for (int32_t w = 0; w < WIDTHS && !result; w++)
        if (width == 0 || widths[w] == width)
            result = try_width(&l, sigma, widths[w], answers, best);
    free_answers(answers, MOST_ANSWERS);
    free_lesson(&l);
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
    const lesson *l;
    const float *features, *weights;
    float *room; /* kernels of a block of texels, for each worker */
} telling;

static void tell_block(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const telling *t = data;
    const lesson *l = t->l;
    pv_enlarge *e = l->e;
    float *kernel = t->room + (int64_t)worker * BLOCK * l->centres;
    float *out = e->made.values + (int64_t)begin * e->coefficients;
    for (int32_t i = begin; i < end; i++)
        kernels_of(l, t->features + (int64_t)i * l->features, kernel + (int64_t)(i - begin) * l->centres);
    pv_multiply(&e->algebra, 0, 0, end - begin, e->coefficients, l->centres, kernel, l->centres, t->weights,
                e->coefficients, 0, out, e->coefficients);
    for (int64_t i = 0; i < (int64_t)(end - begin) * e->coefficients; i++)
        out[i] += (float)e->middle[i % e->coefficients];
}

static pave_result tell_all(lesson *l, const float *features, const float *weights, double from, double to)
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

static double variance(const pv_enlarge *e)
{
    double sum = 0;
    for (int32_t k = 0; k < e->coefficients; k++)
        sum += e->spread[(int64_t)k * e->coefficients + k];
    return sum;
}

/* Each quarter is predicted from the others, which tells what to expect; then all teach. */
static pave_result teach(lesson *l, const settings *best, float **weights)
{
    pv_enlarge *e = l->e;
    answer answers[FOLDS + 1] = { 0 };
    double squares = 0;
    for (int32_t i = 0; i <= FOLDS; i++) {
        answers[i].ridge = best->ridge;
        answers[i].held_out = i < FOLDS ? i : -1;
    }
    pave_result result = study(l, best->width);
    if (!result)
        result = make_answers(l, answers, FOLDS + 1);
    if (!result)
        result = solve_all(l, answers, FOLDS + 1);
    if (!result)
        memset(e->spread, 0, (size_t)e->coefficients * (size_t)e->coefficients * sizeof *e->spread);
    for (int32_t fold = 0; fold < FOLDS && !result; fold++)
        result = miss(l, &answers[fold], &squares, e->spread);
    if (!result)
        result = narrow(l, &answers[FOLDS], weights);
    free_answers(answers, FOLDS + 1);
    return result;
}

pave_result pv_enlarge_predict(pv_enlarge *e, double from, double to)
{
    pv_around around = { 0 };
    lesson l = { 0 };
    float *weights = NULL, *features = NULL;
    settings best = { .squares = INFINITY };
    double before = variance(e), most = from + 0.7 * (to - from);
    pave_result result = choose_settings(e, &best, from, from + 0.4 * (to - from));
    if (!result)
        result = pv_around_learn(e, best.sigma, &around);
    if (!result)
        result = open_lesson(&around, best.copies, MOST_TEXELS / (best.copies > 1 ? 1 + MORE : 1), MOST_CENTRES, &l);
    if (!result)
        result = teach(&l, &best, &weights);
    if (!result)
        e->left = before > 0 ? variance(e) / before : 0;
    if (!result)
        features = pv_allocate(e->context, (size_t)pv_texels_count(&e->made), (size_t)around.features *
                               sizeof *features, &result);
    if (!result)
        result = pv_around_describe(&around, NULL, NULL, pv_texels_count(&e->made), features);
    if (!result)
        result = tell_all(&l, features, weights, most, to);
    pv_release(weights);
    pv_release(features);
    pv_around_free(&around);
    free_lesson(&l);
    return result;
}
