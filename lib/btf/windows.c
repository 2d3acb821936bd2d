/* Nearest windows by lower bounds: a distance is at least that of the windows' principal components, and of the lengths
 * of what these leave. */
#include "btf/windows.h"

#include "base/parallel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { AXES = 48, LEARNED = 640, BLOCK = 16 };

static const float slack = 1e-4f; /* what rounding may do to a bound */

/* All windows of a field, seen through the axes. */
typedef struct view {
    const pv_texels *texels;
    pv_windows windows;
    int32_t count;
    float *seen; /* [window][axis] */
    float *rest; /* [window]: length of what the axes do not see */
    float *size; /* [window]: square length of what they see */
} view;

typedef struct candidate {
    float bound;
    int32_t index;
} candidate;

typedef struct search {
    pave_context *context;
    const pv_algebra *algebra;
    const pv_texels *sample, *whole;
    float *mean; /* [channel], of the sample */
    float *turn; /* [place and channel of a window][axis] */
    int32_t axes, length;
    view from, to;
    view *viewed;
    float *room; /* a block of windows, or of products, for each worker */
    size_t room_each;
    candidate *list; /* for each worker, as many as the sample has windows */
    int32_t *nearest;
} search;

pv_windows pv_windows_of(const pv_texels *t, int32_t side, int32_t step)
{
    int32_t across = (t->width - side + step - 1) / step + 1, down = (t->height - side + step - 1) / step + 1;
    return (pv_windows){ side, step, across, down };
}

static const float *corner_of(const view *v, int32_t index)
{
    int64_t x = pv_window_corner(&v->windows, index % v->windows.across, v->texels->width);
    int64_t y = pv_window_corner(&v->windows, index / v->windows.across, v->texels->height);
    return v->texels->values + (y * v->texels->width + x) * v->texels->channels;
}

/* A window less the mean, at every `stride`-th place of `out`. */
static void copy_window(const search *s, const view *v, int32_t index, int64_t stride, float *out)
{
    const float *from = corner_of(v, index);
    int32_t side = v->windows.side, channels = v->texels->channels;
    for (int32_t y = 0; y < side; y++, from += (int64_t)v->texels->width * channels)
        for (int32_t i = 0; i < side * channels; i++, out += stride)
            *out = from[i] - s->mean[i % channels];
}

static pave_result find_mean(search *s)
{
    int32_t channels = s->sample->channels;
    int64_t texels = pv_texels_count(s->sample);
    pave_result result = PAVE_OK;
    s->mean = pv_allocate(s->context, (size_t)channels, sizeof *s->mean, &result);
    for (int32_t c = 0; c < channels && !result; c++) {
        double sum = 0;
        for (int64_t t = 0; t < texels; t++)
            sum += (double)s->sample->values[t * channels + c];
        s->mean[c] = (float)(sum / (double)texels);
    }
    return result;
}

/* Principal axes of some of the sample's windows, spread evenly, through the smaller Gram matrix. */
static pave_result find_axes(search *s)
{
    pave_result result = PAVE_OK;
    int32_t count = s->from.count < LEARNED ? s->from.count : LEARNED;
    size_t side = (size_t)count;
    double *square = pv_allocate(s->context, side, side * sizeof *square, &result), *values = NULL;
    float *windows = NULL;
    if (!result)
        values = pv_allocate(s->context, side, sizeof *values, &result);
    if (!result)
        windows = pv_allocate(s->context, (size_t)s->length, side * sizeof *windows, &result);
    for (int64_t i = 0; i < count && !result; i++)
        copy_window(s, &s->from, (int32_t)(i * s->from.count / count), count, windows + i);
    if (!result)
        result = pv_gram(s->context, s->algebra, s->length, count, windows, square);
    if (!result)
        result = pv_eigen(s->context, s->algebra, count, square, values);
    while (!result && s->axes < AXES && s->axes < count && values[s->axes] > 1e-6 * values[0])
        s->axes++;
    for (int32_t k = 0; k < s->axes && !result; k++)
        for (int32_t i = 0; i < count; i++)
            square[(int64_t)k * count + i] /= sqrt(values[k]);
    if (!result)
        s->turn = pv_allocate(s->context, (size_t)s->length, ((size_t)s->axes + 1) * sizeof *s->turn, &result);
    if (!result && s->axes)
        result = pv_rotate(s->context, s->algebra, s->length, count, windows, s->axes, square, s->turn);
    pv_release(square);
    pv_release(values);
    pv_release(windows);
    return result;
}

static double square_length(const float *vector, int32_t length)
{
    double sum = 0;
    for (int32_t i = 0; i < length; i++)
        sum += (double)vector[i] * (double)vector[i];
    return sum;
}

static void see_block(void *data, int32_t begin, int32_t end, int32_t worker)
{
    search *s = data;
    view *v = s->viewed;
    float *room = s->room + (size_t)worker * s->room_each;
    for (int32_t i = begin; i < end; i++)
        copy_window(s, v, i, 1, room + (int64_t)(i - begin) * s->length);
    if (s->axes)
        pv_multiply(s->algebra, 0, 0, end - begin, s->axes, s->length, room, s->length, s->turn, s->axes, 0,
                    v->seen + (int64_t)begin * s->axes, s->axes);
    for (int32_t i = begin; i < end; i++) {
        double whole = square_length(room + (int64_t)(i - begin) * s->length, s->length);
        double seen = square_length(v->seen + (int64_t)i * s->axes, s->axes);
        v->rest[i] = (float)sqrt(fmax(whole - seen, 0));
        v->size[i] = (float)seen;
    }
}

static pave_result see_all(search *s, view *v, double from, double to)
{
    pave_result result = PAVE_OK;
    size_t count = (size_t)v->count;
    v->seen = pv_allocate(s->context, count, ((size_t)s->axes + 1) * sizeof *v->seen, &result);
    if (!result)
        v->rest = pv_allocate(s->context, count, sizeof *v->rest, &result);
    if (!result)
        v->size = pv_allocate(s->context, count, sizeof *v->size, &result);
    s->viewed = v;
    return result ? result : pv_parallel_runs(s->context, v->count, BLOCK, see_block, s, from, to);
}

/* The square distance of two windows; more than `most` may end early. */
static float distance(const search *s, const float *a, const float *b, float most)
{
    int32_t side = s->from.windows.side, channels = s->sample->channels, run = side * channels;
    float sum = 0;
    for (int32_t y = 0; y < side && sum <= most; y++) {
        float part[8] = { 0 };
        int32_t i = 0;
        for (; i + 8 <= run; i += 8)
            for (int32_t k = 0; k < 8; k++)
                part[k] += (a[i + k] - b[i + k]) * (a[i + k] - b[i + k]);
        for (; i < run; i++)
            part[0] += (a[i] - b[i]) * (a[i] - b[i]);
        sum += ((part[0] + part[1]) + (part[2] + part[3])) + ((part[4] + part[5]) + (part[6] + part[7]));
        a += (int64_t)s->whole->width * channels;
        b += (int64_t)s->sample->width * channels;
    }
    return sum;
}

static int by_bound(const void *a, const void *b)
{
    const candidate *p = a, *q = b;
    int order = (p->bound > q->bound) - (p->bound < q->bound);
    return order ? order : (p->index > q->index) - (p->index < q->index);
}

/* All bounds first; then in their order, until none that is left can be nearer. */
static int32_t find_nearest(const search *s, int32_t query, const float *products, candidate *list)
{
    const view *to = &s->to, *from = &s->from;
    const float *window = corner_of(to, query);
    int32_t nearest = 0, count = 0;
    float least = INFINITY;
    for (int32_t i = 0; i < from->count; i++) {
        float rest = to->rest[query] - from->rest[i], size = to->size[query] + from->size[i];
        float bound = size - 2 * products[i] + rest * rest - slack * (size + 1e-6f);
        list[i] = (candidate){ bound, i };
        if (bound < least) {
            least = bound;
            nearest = i;
        }
    }
    least = distance(s, window, corner_of(from, nearest), INFINITY);
    for (int32_t i = 0; i < from->count; i++)
        if (list[i].bound <= least && i != nearest)
            list[count++] = list[i];
    qsort(list, (size_t)count, sizeof *list, by_bound);
    for (int32_t i = 0; i < count && list[i].bound <= least; i++) {
        float here = distance(s, window, corner_of(from, list[i].index), least);
        if (here < least || (here <= least && list[i].index < nearest)) {
            least = here;
            nearest = list[i].index;
        }
    }
    return nearest;
}

static void match_block(void *data, int32_t begin, int32_t end, int32_t worker)
{
    search *s = data;
    int32_t count = s->from.count;
    float *products = s->room + (size_t)worker * s->room_each;
    candidate *list = s->list + (int64_t)worker * count;
    memset(products, 0, (size_t)(end - begin) * (size_t)count * sizeof *products);
    if (s->axes)
        pv_multiply(s->algebra, 0, 1, end - begin, count, s->axes, s->to.seen + (int64_t)begin * s->axes, s->axes,
                    s->from.seen, s->axes, 0, products, count);
    for (int32_t i = begin; i < end; i++)
        s->nearest[i] = find_nearest(s, i, products + (int64_t)(i - begin) * count, list);
}

static void free_search(search *s)
{
    view *views[2] = { &s->from, &s->to };
    for (int32_t i = 0; i < 2; i++) {
        pv_release(views[i]->seen);
        pv_release(views[i]->rest);
        pv_release(views[i]->size);
    }
    pv_release(s->mean);
    pv_release(s->turn);
    pv_release(s->room);
    pv_release(s->list);
}

static pave_result make_room(search *s)
{
    size_t products = BLOCK * (size_t)s->from.count, windows = BLOCK * (size_t)s->length;
    size_t workers = (size_t)pv_workers(s->context);
    pave_result result = PAVE_OK;
    s->room_each = products > windows ? products : windows;
    s->room = pv_allocate(s->context, workers, s->room_each * sizeof *s->room, &result);
    if (!result)
        s->list = pv_allocate(s->context, workers, (size_t)s->from.count * sizeof *s->list, &result);
    return result;
}

pave_result pv_windows_match(pave_context *context, const pv_algebra *algebra, const pv_texels *sample,
                             const pv_texels *whole, const pv_windows *windows, int32_t *nearest, double from,
                             double to)
{
    search s = { .context = context, .algebra = algebra, .sample = sample, .whole = whole, .nearest = nearest };
    s.length = windows->side * windows->side * sample->channels;
    s.from = (view){ .texels = sample, .windows = pv_windows_of(sample, windows->side, 1) };
    s.to = (view){ .texels = whole, .windows = *windows };
    s.from.count = s.from.windows.across * s.from.windows.down;
    s.to.count = s.to.windows.across * s.to.windows.down;
    pave_result result = find_mean(&s);
    if (!result)
        result = find_axes(&s);
    if (!result)
        result = make_room(&s);
    if (!result)
        result = see_all(&s, &s.from, from, from + 0.2 * (to - from));
    if (!result)
        result = see_all(&s, &s.to, from + 0.2 * (to - from), from + 0.4 * (to - from));
    if (!result)
        result = pv_parallel_runs(context, s.to.count, BLOCK, match_block, &s, from + 0.4 * (to - from), to);
    free_search(&s);
    return result;
}
