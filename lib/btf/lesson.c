/* What a regression learns from, and the sums that it needs of each quarter of the sample. */
#include "btf/lesson.h"

#include "base/parallel.h"
#include "util/random.h"

#include <math.h>
#include <string.h>

enum { MORE = 3 };

void pv_lesson_free(pv_lesson *l)
{
    pv_release(l->texel);
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
    return (int32_t)(wide * high < most / PV_FOLDS ? wide * high : most / PV_FOLDS);
}

/* So many texels of a quarter in one copy, from the first row on. */
static pave_result fill_part(pv_lesson *l, int32_t fold, int32_t copy, int32_t first, int32_t count)
{
    const pv_enlarge *e = l->e;
    int32_t n = e->coefficients;
    int64_t *texels = l->texel + first;
    for (int32_t k = 0; k < count; k++) {
        float *target = l->target + (int64_t)(first + k) * n;
        texels[k] = texel_of(e, fold, copy, k, count);
        pv_enlarge_copied(e, &e->copy[copy], texels[k], target);
        for (int32_t c = 0; c < n; c++)
            target[c] -= (float)e->middle[c];
    }
    return pv_around_describe(l->around, &e->copy[copy], texels, count, l->feature + (int64_t)first * l->features);
}

static pave_result fill_lesson(pv_lesson *l)
{
    pave_result result = PAVE_OK;
    for (int32_t fold = 0; fold < PV_FOLDS && !result; fold++) {
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

static void count_rows(pv_lesson *l, int32_t most)
{
    for (int32_t fold = 0; fold < PV_FOLDS; fold++) {
        int32_t own = l->sampled[fold] = texels_of_fold(l->e, fold, most), others = l->copies - 1;
        l->copied[fold] = others > MORE ? MORE * own / others : own;
        l->from[fold + 1] = l->from[fold] + own + others * l->copied[fold];
    }
}

pave_result pv_lesson_open(const pv_around *around, int32_t copies, int32_t most, int32_t centres, pv_lesson *l)
{
    pv_enlarge *e = around->e;
    pave_result result = PAVE_OK;
    *l = (pv_lesson){ .e = e, .around = around, .copies = copies, .features = around->windows.to };
    count_rows(l, most);
    l->texels = l->from[PV_FOLDS];
    l->centres = l->texels < centres ? l->texels : centres;
    size_t texels = (size_t)l->texels, middle = (size_t)l->centres, bytes = (size_t)l->features * sizeof(float);
    l->texel = pv_allocate(e->context, texels, sizeof *l->texel, &result);
    if (!result)
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
        l->gram = pv_allocate(e->context, PV_FOLDS * middle, middle * sizeof *l->gram, &result);
    if (!result)
        l->side = pv_allocate(e->context, PV_FOLDS * middle, (size_t)e->coefficients * sizeof *l->side, &result);
    if (!result)
        result = fill_lesson(l);
    return result;
}

/* ---- Kernels ---- */

void pv_lesson_kernels(const pv_lesson *l, const float *feature, float *out)
{
    for (int32_t k = 0; k < l->centres; k++)
        out[k] = (float)exp(-distance(feature, l->centre + (int64_t)k * l->features, l->features) /
                            (2 * l->width * l->scale));
}

static void find_kernel(void *data, int32_t texel, int32_t worker)
{
    (void)worker;
    const pv_lesson *l = data;
    pv_lesson_kernels(l, l->feature + (int64_t)texel * l->features, l->kernel + (int64_t)texel * l->centres);
}

static void find_own(void *data, int32_t k, int32_t worker)
{
    (void)worker;
    const pv_lesson *l = data;
    const float *centre = l->centre + (int64_t)k * l->features;
    double *row = l->own + (int64_t)k * l->centres;
    for (int32_t i = 0; i < l->centres; i++)
        row[i] = exp(-distance(centre, l->centre + (int64_t)i * l->features, l->features) / (2 * l->width * l->scale));
}

pave_result pv_lesson_study(pv_lesson *l, double width)
{
    pv_enlarge *e = l->e;
    l->width = width;
    pave_result result = pv_parallel(e->context, l->texels, find_kernel, l, 0, 0);
    if (!result)
        result = pv_parallel(e->context, l->centres, find_own, l, 0, 0);
    for (int32_t fold = 0; fold < PV_FOLDS && !result; fold++) {
        int64_t rows = l->from[fold + 1] - l->from[fold], first = l->from[fold], each = l->centres;
        result = pv_gram(e->context, &e->algebra, rows, l->centres, l->kernel + first * each,
                         l->gram + fold * each * each);
        if (!result)
            result = pv_cross(e->context, &e->algebra, rows, l->centres, l->kernel + first * each, e->coefficients,
                              l->target + first * e->coefficients, l->side + fold * each * e->coefficients);
    }
    return result;
}
