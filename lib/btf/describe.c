/* What is around a texel, in a few numbers: principal components of windows of the guides. */
#include "btf/enlarge.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { REACH = 4, SIDE = 2 * REACH + 1, WINDOW = SIDE * SIDE, MOST_GUIDES = 12, MOST_FEATURES = 128,
       MOST_TRAINED = 8192, BLOCK = 256 };

/* Vectors less their mean, along the axes in which they vary most. */
typedef struct axes {
    int32_t from, to;
    float *mean; /* [from] */
    float *turn; /* [from][to] */
} axes;

static void free_axes(axes *a)
{
    pv_release(a->mean);
    pv_release(a->turn);
}

/* Of `rows` vectors, which are centred on their way. */
static pave_result find_axes(pv_enlarge *e, int64_t rows, int32_t from, int32_t most, float *vectors, axes *out)
{
    pave_result result = PAVE_OK;
    size_t size = (size_t)from;
    *out = (axes){ from, from < most ? from : most, NULL, NULL };
    double *square = pv_allocate(e->context, size, size * sizeof *square, &result), *values = NULL, *mean = NULL;
    if (!result)
        values = pv_allocate(e->context, size, sizeof *values, &result);
    if (!result)
        mean = pv_allocate_zeroed(e->context, size, sizeof *mean, &result);
    if (!result)
        out->mean = pv_allocate(e->context, size, sizeof *out->mean, &result);
    if (!result)
        out->turn = pv_allocate(e->context, size, (size_t)out->to * sizeof *out->turn, &result);
    for (int64_t i = 0; i < rows * from && !result; i++)
        mean[i % from] += (double)vectors[i] / (double)rows;
    for (int32_t i = 0; i < from && !result; i++)
        out->mean[i] = (float)mean[i];
    for (int64_t i = 0; i < rows * from && !result; i++)
        vectors[i] -= out->mean[i % from];
    if (!result)
        result = pv_gram(e->context, &e->algebra, rows, from, vectors, square);
    if (!result)
        result = pv_eigen(e->context, &e->algebra, from, square, values);
    for (int32_t i = 0; i < from && !result; i++)
        for (int32_t k = 0; k < out->to; k++)
            out->turn[(int64_t)i * out->to + k] = (float)square[(int64_t)k * from + i];
    pv_release(square);
    pv_release(values);
    pv_release(mean);
    return result;
}

/* ---- Guides along their axes ---- */

static pave_result turn_guides(const pv_enlarge *e, const axes *a, const pv_texels *guides, pv_texels *out)
{
    pave_result result = pv_texels_new(e->context, guides->width, guides->height, a->to, out);
    for (int64_t t = 0; t < pv_texels_count(out) && !result; t++)
        for (int32_t k = 0; k < a->to; k++) {
            float sum = 0;
            for (int32_t g = 0; g < a->from; g++)
                sum += (guides->values[t * a->from + g] - a->mean[g]) * a->turn[g * a->to + k];
            out->values[t * a->to + k] = sum;
        }
    return result;
}

/* ---- Windows ---- */

typedef struct windows {
    const pv_enlarge *e;
    const pv_texels *guides;
    float weight[WINDOW];
    const axes *axes;
    float *room; /* a block of windows, for each worker */
    pv_texels *out;
} windows;

static void copy_window(const windows *w, int64_t texel, float *out)
{
    const pv_texels *g = w->guides;
    int32_t x = (int32_t)(texel % g->width), y = (int32_t)(texel / g->width);
    for (int32_t i = 0; i < WINDOW; i++) {
        int64_t row = pv_mirrored(y + i / SIDE - REACH, g->height);
        int64_t column = pv_mirrored(x + i % SIDE - REACH, g->width);
        const float *from = g->values + (row * g->width + column) * g->channels;
        for (int32_t c = 0; c < g->channels; c++)
            *out++ = from[c] * w->weight[i];
    }
}

static void describe_block(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const windows *w = data;
    const axes *a = w->axes;
    float *room = w->room + (int64_t)worker * BLOCK * a->from;
    for (int32_t t = begin; t < end; t++) {
        float *vector = room + (int64_t)(t - begin) * a->from;
        copy_window(w, t, vector);
        for (int32_t i = 0; i < a->from; i++)
            vector[i] -= a->mean[i];
    }
    pv_multiply(&w->e->algebra, 0, 0, end - begin, a->to, a->from, room, a->from, a->turn, a->to, 0,
                w->out->values + (int64_t)begin * a->to, a->to);
}

/* The axes of the sample's windows, of which some spread evenly tell enough. */
static pave_result learn_windows(pv_enlarge *e, windows *w, const pv_texels *guides, axes *out)
{
    int64_t texels = pv_texels_count(guides), count = texels < MOST_TRAINED ? texels : MOST_TRAINED;
    int32_t length = WINDOW * guides->channels;
    pave_result result = PAVE_OK;
    float *vectors = pv_allocate(e->context, (size_t)count, (size_t)length * sizeof *vectors, &result);
    w->guides = guides;
    for (int64_t i = 0; i < count && !result; i++)
        copy_window(w, i * texels / count, vectors + i * length);
    if (!result)
        result = find_axes(e, count, length, MOST_FEATURES, vectors, out);
    pv_release(vectors);
    return result;
}

static pave_result guide_axes(pv_enlarge *e, axes *out)
{
    pave_result result = PAVE_OK;
    size_t bytes = (size_t)e->guides * sizeof(float);
    float *copy = pv_allocate(e->context, (size_t)pv_texels_count(&e->seen), bytes, &result);
    if (!result)
        memcpy(copy, e->seen.values, (size_t)pv_texels_count(&e->seen) * bytes);
    if (!result)
        result = find_axes(e, pv_texels_count(&e->seen), e->guides, MOST_GUIDES, copy, out);
    pv_release(copy);
    return result;
}

/* Along the axes of the guides, then along those of their windows. */
static pave_result describe(windows *w, const axes *a, const pv_texels *guides, pv_texels *out)
{
    pv_texels turned = { 0 };
    pave_result result = turn_guides(w->e, a, guides, &turned);
    if (!result)
        result = pv_texels_new(w->e->context, guides->width, guides->height, w->axes->to, out);
    w->guides = &turned;
    w->out = out;
    if (!result)
        result = pv_parallel_runs(w->e->context, (int32_t)pv_texels_count(guides), BLOCK, describe_block, w, 0, 0);
    pv_release(turned.values);
    return result;
}

pave_result pv_enlarge_describe(pv_enlarge *e, double sigma, int32_t copies, pv_texels *of_sample, pv_texels *of_whole)
{
    axes guides = { 0 }, around = { 0 };
    pv_texels seen = { 0 };
    windows w = { .e = e, .axes = &around };
    for (int32_t i = 0; i < WINDOW; i++) {
        int32_t x = i % SIDE - REACH, y = i / SIDE - REACH;
        w.weight[i] = (float)exp(-(x * x + y * y) / (2 * sigma * sigma));
    }
    pave_result result = guide_axes(e, &guides);
    if (!result)
        result = turn_guides(e, &guides, &e->seen, &seen);
    if (!result)
        result = learn_windows(e, &w, &seen, &around);
    if (!result)
        w.room = pv_allocate(e->context, (size_t)pv_workers(e->context), (size_t)BLOCK * (size_t)around.from *
                             sizeof *w.room, &result);
    for (int32_t i = 0; i < copies && !result; i++)
        result = describe(&w, &guides, &e->seen_mirrored[i], &of_sample[i]);
    if (!result && of_whole)
        result = describe(&w, &guides, &e->given, of_whole);
    pv_release(w.room);
    pv_release(seen.values);
    free_axes(&guides);
    free_axes(&around);
    return result;
}
