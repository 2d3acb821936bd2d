/* What is around a texel, in a few numbers: principal components of windows of the guides. */
#include "btf/enlarge.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { REACH = 4, SIDE = 2 * REACH + 1, WINDOW = SIDE * SIDE, MOST_GUIDES = 12, MOST_FEATURES = 128,
       MOST_TRAINED = 8192, BLOCK = 256, MOST_TAPS = 16 };

static void free_axes(pv_axes *a)
{
    pv_release(a->mean);
    pv_release(a->turn);
}

/* Of `rows` vectors, which are centred on their way. */
static pave_result find_axes(const pv_enlarge *e, int64_t rows, int32_t from, int32_t most, float *vectors,
                             pv_axes *out)
{
    pave_result result = PAVE_OK;
    size_t size = (size_t)from;
    *out = (pv_axes){ from, from < most ? from : most, NULL, NULL };
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

static pave_result turn_guides(const pv_around *around, const pv_texels *guides, pv_texels *out)
{
    const pv_axes *a = &around->guides;
    pave_result result = pv_texels_new(around->e->context, guides->width, guides->height, a->to, out);
    for (int64_t t = 0; t < pv_texels_count(guides) && !result; t++)
        for (int32_t k = 0; k < a->to; k++) {
            float sum = 0;
            for (int32_t g = 0; g < a->from; g++)
                sum += (guides->values[t * a->from + g] - a->mean[g]) * a->turn[g * a->to + k];
            out->values[t * a->to + k] = sum;
        }
    return result;
}

/* ---- Windows ---- */

/* A place in a window is a sum over texels: one, or those around it (Catmull and Rom's spline) where the window is
 * askew. */
typedef struct tap {
    int32_t x, y;
    float weight;
} tap;

typedef struct windows {
    const pv_around *around;
    const pv_texels *guides;
    const int64_t *texels; /* NULL: all */
    tap tap[WINDOW][MOST_TAPS];
    int32_t taps[WINDOW];
    float *room; /* a block of windows, for each worker */
    float *out;
} windows;

static void spline(double t, double weight[4])
{
    weight[0] = t * (t * (1 - 0.5 * t) - 0.5);
    weight[1] = t * t * (1.5 * t - 2.5) + 1;
    weight[2] = t * (t * (2 - 1.5 * t) + 0.5);
    weight[3] = 0.5 * t * t * (t - 1);
}

static void find_taps(windows *w, const double place[4])
{
    double sigma = w->around->sigma, along[4], down[4];
    for (int32_t i = 0; i < WINDOW; i++) {
        int32_t x = i % SIDE - REACH, y = i / SIDE - REACH;
        double u = place[0] * x + place[1] * y, v = place[2] * x + place[3] * y;
        double left = floor(u + 1e-9), top = floor(v + 1e-9), weight = exp(-(x * x + y * y) / (2 * sigma * sigma));
        spline(fmax(u - left, 0), along);
        spline(fmax(v - top, 0), down);
        w->taps[i] = 0;
        for (int32_t k = 0; k < MOST_TAPS; k++)
            if (fabs(along[k % 4] * down[k / 4]) > 1e-6)
                w->tap[i][w->taps[i]++] = (tap){ (int32_t)left + k % 4 - 1, (int32_t)top + k / 4 - 1,
                                                 (float)(weight * along[k % 4] * down[k / 4]) };
    }
}

static void copy_window(const windows *w, int64_t texel, float *out)
{
    const pv_texels *g = w->guides;
    int32_t x = (int32_t)(texel % g->width), y = (int32_t)(texel / g->width), n = g->channels;
    memset(out, 0, WINDOW * (size_t)n * sizeof *out);
    for (int32_t i = 0; i < WINDOW; i++, out += n)
        for (int32_t k = 0; k < w->taps[i]; k++) {
            const tap *t = &w->tap[i][k];
            int64_t from = pv_mirrored(y + t->y, g->height) * g->width + pv_mirrored(x + t->x, g->width);
            for (int32_t c = 0; c < n; c++)
                out[c] += t->weight * g->values[from * n + c];
        }
}

static void describe_block(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const windows *w = data;
    const pv_axes *a = &w->around->windows;
    float *room = w->room + (int64_t)worker * BLOCK * a->from;
    for (int32_t t = begin; t < end; t++) {
        float *vector = room + (int64_t)(t - begin) * a->from;
        copy_window(w, w->texels ? w->texels[t] : t, vector);
        for (int32_t i = 0; i < a->from; i++)
            vector[i] -= a->mean[i];
    }
    pv_multiply(&w->around->e->algebra, 0, 0, end - begin, a->to, a->from, room, a->from, a->turn, a->to, 0,
                w->out + (int64_t)begin * a->to, a->to);
}

pave_result pv_around_describe(const pv_around *around, const pv_turned *copy, const int64_t *texels, int64_t count,
                               float *out)
{
    const pv_enlarge *e = around->e;
    pv_texels guides = { 0 };
    windows w = { .around = around, .guides = &guides, .texels = texels, .out = out };
    pave_result result = turn_guides(around, copy ? &copy->seen : &e->given, &guides);
    find_taps(&w, copy ? copy->place : e->copy[0].place);
    if (!result)
        w.room = pv_allocate(e->context, (size_t)pv_workers(e->context), BLOCK * (size_t)around->windows.from *
                             sizeof *w.room, &result);
    if (!result)
        result = pv_parallel_runs(e->context, (int32_t)count, BLOCK, describe_block, &w, 0, 0);
    pv_release(w.room);
    pv_release(guides.values);
    return result;
}

/* ---- Axes ---- */

static pave_result learn_guides(pv_around *around)
{
    const pv_enlarge *e = around->e;
    pave_result result = PAVE_OK;
    size_t bytes = (size_t)e->guides * sizeof(float);
    float *copy = pv_allocate(e->context, (size_t)pv_texels_count(&e->seen), bytes, &result);
    if (!result)
        memcpy(copy, e->seen.values, (size_t)pv_texels_count(&e->seen) * bytes);
    if (!result)
        result = find_axes(e, pv_texels_count(&e->seen), e->guides, MOST_GUIDES, copy, &around->guides);
    pv_release(copy);
    return result;
}

/* Of the sample's windows some, spread evenly, tell enough. */
static pave_result learn_windows(pv_around *around)
{
    const pv_enlarge *e = around->e;
    int64_t texels = pv_texels_count(&e->seen), count = texels < MOST_TRAINED ? texels : MOST_TRAINED;
    int32_t length = WINDOW * around->guides.to;
    pv_texels guides = { 0 };
    windows w = { .around = around, .guides = &guides };
    float *vectors = NULL;
    pave_result result = turn_guides(around, &e->seen, &guides);
    find_taps(&w, e->copy[0].place);
    if (!result)
        vectors = pv_allocate(e->context, (size_t)count, (size_t)length * sizeof *vectors, &result);
    for (int64_t i = 0; i < count && !result; i++)
        copy_window(&w, i * texels / count, vectors + i * length);
    if (!result)
        result = find_axes(e, count, length, MOST_FEATURES, vectors, &around->windows);
    pv_release(vectors);
    pv_release(guides.values);
    return result;
}

pave_result pv_around_learn(pv_enlarge *e, double sigma, pv_around *out)
{
    *out = (pv_around){ .e = e, .sigma = sigma };
    pave_result result = learn_guides(out);
    return result ? result : learn_windows(out);
}

void pv_around_free(pv_around *around)
{
    free_axes(&around->guides);
    free_axes(&around->windows);
}
