/* Texture Optimization (Kwatra et al. 2005, as Steinhausen 2014 uses it: Eqs. 2 and 3): each window of the whole finds
 * the window of the sample that is most like it, and each texel becomes the mean of what its windows found. */
#include "btf/windows.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { ROUNDS = 10, MOST_LEVELS = 4 };

/* Coefficients and weighted guides side by side, at one level. */
typedef struct level {
    pv_enlarge *e;
    pv_texels sample, whole, guides_of_sample, guides_of_whole;
    pv_windows windows;
    int32_t *nearest;
} level;

static void free_level(level *l)
{
    pv_release(l->sample.values);
    pv_release(l->whole.values);
    pv_release(l->guides_of_sample.values);
    pv_release(l->guides_of_whole.values);
    pv_release(l->nearest);
}

/* Each texel becomes the mean of four. */
static pave_result halve(pave_context *context, pv_texels *t)
{
    pv_texels half;
    pave_result result = pv_texels_new(context, t->width / 2, t->height / 2, t->channels, &half);
    if (result)
        return result;
    for (int64_t y = 0; y < half.height; y++)
        for (int64_t x = 0; x < half.width; x++) {
            const float *a = t->values + (2 * y * t->width + 2 * x) * t->channels;
            const float *b = a + (int64_t)t->width * t->channels;
            float *to = half.values + (y * half.width + x) * t->channels;
            for (int32_t c = 0; c < t->channels; c++)
                to[c] = 0.25f * (a[c] + a[c + t->channels] + b[c] + b[c + t->channels]);
        }
    pv_release(t->values);
    *t = half;
    return PAVE_OK;
}

static pave_result copy_weighted(pave_context *context, const pv_texels *t, float weight, int32_t levels,
                                 pv_texels *out)
{
    pave_result result = pv_texels_new(context, t->width, t->height, t->channels, out);
    for (int64_t i = 0; i < pv_texels_count(t) * t->channels && !result; i++)
        out->values[i] = weight * t->values[i];
    for (int32_t i = 0; i < levels && !result; i++)
        result = halve(context, out);
    return result;
}

/* a, and b after it; without a, room for it. */
static pave_result side_by_side(pave_context *context, const pv_texels *a, int32_t first, const pv_texels *b,
                                pv_texels *out)
{
    pave_result result = pv_texels_new(context, b->width, b->height, first + b->channels, out);
    for (int64_t t = 0; t < pv_texels_count(b) && !result; t++) {
        float *to = out->values + t * out->channels;
        if (a)
            memcpy(to, a->values + t * first, (size_t)first * sizeof *to);
        memcpy(to + first, b->values + t * b->channels, (size_t)b->channels * sizeof *to);
    }
    return result;
}

/* Guides count once for each row of the texture that they stand for (the paper's lambda). */
static float guide_weight(const pv_enlarge *e, double balance)
{
    double pairs = (double)e->sample->views.count * e->sample->lights.count;
    return (float)sqrt(balance * pairs / (e->guides / e->planes));
}

static pave_result open_level(pv_enlarge *e, int32_t index, double balance, level *l)
{
    pave_context *context = e->context;
    pv_texels coefficients = { 0 };
    float weight = guide_weight(e, balance);
    *l = (level){ .e = e };
    pave_result result = copy_weighted(context, &e->known, 1, index, &coefficients);
    if (!result)
        result = copy_weighted(context, &e->seen, weight, index, &l->guides_of_sample);
    if (!result)
        result = copy_weighted(context, &e->given, weight, index, &l->guides_of_whole);
    if (!result)
        result = side_by_side(context, &coefficients, e->coefficients, &l->guides_of_sample, &l->sample);
    if (!result)
        result = side_by_side(context, NULL, e->coefficients, &l->guides_of_whole, &l->whole);
    pv_release(coefficients.values);
    if (result)
        return result;
    l->windows = pv_windows_of(&l->whole, e->params->neighbourhood, fmax(1, e->params->neighbourhood / 4));
    l->nearest = pv_allocate_zeroed(context, (size_t)l->windows.across * (size_t)l->windows.down, sizeof *l->nearest,
                                    &result);
    return result;
}

/* ---- What the windows found ---- */

static void mean_of(const level *l, int32_t x, int32_t y, float *out)
{
    const pv_windows *w = &l->windows;
    int32_t n = l->e->coefficients, across = l->sample.width - w->side + 1, count = 0;
    int32_t last_x = x / w->step + 1 < w->across ? x / w->step + 1 : w->across - 1;
    int32_t last_y = y / w->step + 1 < w->down ? y / w->step + 1 : w->down - 1;
    memset(out, 0, (size_t)n * sizeof *out);
    for (int32_t j = last_y; j >= 0 && pv_window_corner(w, j, l->whole.height) + w->side > y; j--)
        for (int32_t i = last_x; i >= 0 && pv_window_corner(w, i, l->whole.width) + w->side > x; i--) {
            int32_t dx = x - pv_window_corner(w, i, l->whole.width), dy = y - pv_window_corner(w, j, l->whole.height);
            if (dx < 0 || dy < 0)
                continue;
            int32_t found = l->nearest[j * w->across + i];
            int64_t texel = (int64_t)(found / across + dy) * l->sample.width + found % across + dx;
            for (int32_t c = 0; c < n; c++)
                out[c] += l->sample.values[texel * l->sample.channels + c];
            count++;
        }
    for (int32_t c = 0; c < n; c++)
        out[c] /= (float)count;
}

static void average_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const level *l = data;
    for (int32_t x = 0; x < l->whole.width; x++)
        mean_of(l, x, y, l->whole.values + ((int64_t)y * l->whole.width + x) * l->whole.channels);
}

static pave_result average(level *l)
{
    return pv_parallel(l->e->context, l->whole.height, average_row, l, 0, 0);
}

/* ---- Levels ---- */

/* Windows that show the same as the photographs, whatever lies under them. */
static pave_result start_from_guides(level *l, double from, double to)
{
    pave_result result = pv_windows_match(l->e->context, &l->e->algebra, &l->guides_of_sample, &l->guides_of_whole,
                                          &l->windows, l->nearest, from, to);
    return result ? result : average(l);
}

/* Coefficients of the level before, between its texels. */
static void start_from_coarser(level *l, const pv_texels *coarse)
{
    for (int32_t y = 0; y < l->whole.height; y++)
        for (int32_t x = 0; x < l->whole.width; x++) {
            float fx = fminf(fmaxf(0.5f * (float)x - 0.25f, 0), (float)(coarse->width - 1));
            float fy = fminf(fmaxf(0.5f * (float)y - 0.25f, 0), (float)(coarse->height - 1));
            int64_t left = (int64_t)fx, top = (int64_t)fy, n = coarse->channels;
            int64_t right = left + (left + 1 < coarse->width), below = top + (top + 1 < coarse->height);
            float u = fx - (float)left, v = fy - (float)top;
            const float *a = coarse->values + (top * coarse->width + left) * n;
            const float *b = coarse->values + (top * coarse->width + right) * n;
            const float *c = coarse->values + (below * coarse->width + left) * n;
            const float *d = coarse->values + (below * coarse->width + right) * n;
            float *to = l->whole.values + ((int64_t)y * l->whole.width + x) * n;
            for (int32_t k = 0; k < l->e->coefficients; k++)
                to[k] = (1 - v) * ((1 - u) * a[k] + u * b[k]) + v * ((1 - u) * c[k] + u * d[k]);
        }
}

/* Until all windows find what they found before. */
static pave_result iterate(level *l, double from, double to)
{
    pv_enlarge *e = l->e;
    size_t count = (size_t)l->windows.across * (size_t)l->windows.down;
    pave_result result = PAVE_OK;
    int32_t *before = pv_allocate(e->context, count, sizeof *before, &result);
    for (int32_t i = 0; i < ROUNDS && !result; i++) {
        memcpy(before, l->nearest, count * sizeof *before);
        result = pv_windows_match(e->context, &e->algebra, &l->sample, &l->whole, &l->windows, l->nearest,
                                  from + (to - from) * i / ROUNDS, from + (to - from) * (i + 1) / ROUNDS);
        e->rounds++;
        if (!result && !memcmp(before, l->nearest, count * sizeof *before))
            break;
        if (!result)
            result = average(l);
    }
    pv_release(before);
    return result;
}

static pave_result run_level(pv_enlarge *e, int32_t index, double balance, pv_texels *coarse, double from, double to)
{
    level l;
    double start = from + (coarse->values ? 0 : 0.1 * (to - from));
    pave_result result = open_level(e, index, balance, &l);
    if (!result && !coarse->values)
        result = start_from_guides(&l, from, start);
    else if (!result)
        start_from_coarser(&l, coarse);
    if (!result)
        result = iterate(&l, start, to);
    pv_release(coarse->values);
    *coarse = l.whole;
    l.whole.values = NULL;
    free_level(&l);
    return result;
}

/* Is there enough of the sample at this level for a window to choose from? */
static int level_serves(const pv_enlarge *e, int32_t index)
{
    int32_t side = e->params->neighbourhood;
    return (e->known.width >> index) >= 2 * side && (e->known.height >> index) >= 2 * side;
}

pave_result pv_enlarge_optimize(pv_enlarge *e, int32_t levels, double balance, double from, double to)
{
    static const double share[MOST_LEVELS + 1] = { 0, 0.75, 0.94, 0.985, 1 }; /* a quarter of the texels each */
    pv_texels whole = { 0 };
    pave_result result = PAVE_OK;
    while (levels > 1 && !level_serves(e, levels - 1))
        levels--;
    for (int32_t i = levels - 1; i >= 0 && !result; i--)
        result = run_level(e, i, balance, &whole, to - (to - from) * share[i + 1] / share[levels],
                           to - (to - from) * share[i] / share[levels]);
    for (int64_t t = 0; t < pv_texels_count(&e->made) && !result; t++)
        memcpy(e->made.values + t * e->coefficients, whole.values + t * whole.channels,
               (size_t)e->coefficients * sizeof(float));
    pv_release(whole.values);
    return result;
}
