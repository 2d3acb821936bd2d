/* What is under the stones, at the centres of the pixels: whose colour, how many, and where there is none. */
#include "stones/measure.h"

#include "util/fixed.h"

#include <stdlib.h>
#include <string.h>

enum { HALF = PV_GRID / 2 };
enum { COVERED = 1, MULTIPLE = 2, GOOD = 4 };

typedef struct ground {
    const pv_survey *survey;
    int32_t x, y, width, height; /* of the window */
    uint8_t *state;
    uint8_t *colour;
    int32_t *crossings; /* of one row, sorted */
    int64_t under, good; /* pixels of one stone, and of those in its colour */
    int32_t straddlers;
} ground;

/* The first column whose centre is not left of where the line a b crosses the height y. */
static int32_t crossing(pv_cell a, pv_cell b, int32_t y)
{
    if (a.y > b.y) {
        pv_cell swap = a;
        a = b;
        b = swap;
    }
    int64_t way = ((int64_t)y - a.y) * ((int64_t)b.x - a.x), rise = (int64_t)b.y - a.y;
    int64_t down = pv_floor_div(way, rise), at = a.x - HALF + down;
    return (int32_t)(way == down * rise ? pv_ceil_div(at, PV_GRID) : pv_floor_div(at, PV_GRID) + 1);
}

static int by_number(const void *a, const void *b)
{
    int32_t p = *(const int32_t *)a, q = *(const int32_t *)b;
    return (p > q) - (p < q);
}

static int32_t cross_row(const pv_cell *ring, int32_t count, int32_t y, int32_t *crossings)
{
    int32_t n = 0;
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = ring[i], b = ring[(i + 1) % count];
        if ((a.y <= y) != (b.y <= y))
            crossings[n++] = crossing(a, b, y);
    }
    if (n > 2 || (n == 2 && crossings[0] > crossings[1]))
        qsort(crossings, (size_t)n, sizeof *crossings, by_number);
    return n;
}

static void cover(ground *g, int32_t row, int32_t from, int32_t to, uint8_t colour)
{
    const pave_image *drawing = g->survey->drawing;
    const uint8_t *source = (const uint8_t *)drawing->pixels + (int64_t)row * drawing->width;
    int64_t line = (int64_t)(row - g->y) * g->width - g->x;
    from = from > g->x ? from : g->x;
    to = to < g->x + g->width ? to : g->x + g->width;
    for (int32_t x = from; x < to; x++) {
        uint8_t *state = &g->state[line + x];
        int good = source[x] == colour;
        if (!*state || colour < g->colour[line + x]) /* whatever the stones' order */
            g->colour[line + x] = colour;
        *state |= (uint8_t)((*state ? MULTIPLE : COVERED) | (good ? GOOD : 0));
        g->good += good;
    }
    g->under += to > from ? to - from : 0;
}

static pave_result cover_stone(pave_context *context, ground *g, int32_t s)
{
    int32_t count;
    const pv_cell *ring = pv_survey_ring(g->survey, s, &count);
    pv_box box = pv_box_of(ring, count);
    int32_t top = (int32_t)pv_floor_div(box.top, PV_GRID), bottom = (int32_t)pv_ceil_div(box.bottom, PV_GRID);
    top = top > g->y ? top : g->y;
    bottom = bottom < g->y + g->height ? bottom : g->y + g->height;
    g->under = g->good = 0;
    for (int32_t row = top; row < bottom; row++) {
        int32_t n = cross_row(ring, count, row * PV_GRID + HALF, g->crossings);
        for (int32_t k = 0; k + 1 < n; k += 2)
            cover(g, row, g->crossings[k], g->crossings[k + 1], g->survey->colour[s]);
        pave_result result = row % 256 == 0 ? pv_progress(context, 0) : PAVE_OK;
        if (result)
            return result;
    }
    g->straddlers += g->under && (double)g->good / (double)g->under < 0.95;
    return PAVE_OK;
}

static pave_result cover_all(pave_context *context, ground *g)
{
    const pv_survey *survey = g->survey;
    pave_result result = PAVE_OK;
    for (int32_t s = 0; s < survey->count && !result; s++) {
        if (survey->valid[s])
            result = cover_stone(context, g, s);
        if (!result && s % 256 == 0)
            result = pv_progress(context, 0.3 + 0.2 * s / survey->count);
    }
    return result;
}

static pave_result count_pixels(pave_context *context, const ground *g, pave_stones_measures *out)
{
    int64_t pixels = (int64_t)g->width * g->height, mismatch = 0, uncovered = 0, multiple = 0;
    pave_result result = PAVE_OK;
    for (int64_t i = 0; i < pixels && !result; i++) {
        uint8_t state = g->state[i];
        uncovered += !state;
        multiple += (state & MULTIPLE) != 0;
        mismatch += state && !(state & GOOD);
        if (i % (1 << 22) == 0)
            result = pv_progress(context, 0.5);
    }
    out->mismatch = (double)mismatch / (double)pixels;
    out->uncovered = (double)uncovered / (double)pixels;
    out->multiple = (double)multiple / (double)pixels;
    out->straddlers = (double)g->straddlers / (g->survey->count ? g->survey->count : 1);
    return result;
}

enum { FAR = INT32_MAX - 1 };

static void nearer(const ground *g, int32_t *steps, int64_t i, int64_t from)
{
    if (steps[from] + 1 < steps[i]) {
        steps[i] = steps[from] + 1;
        g->colour[i] = g->colour[from];
    }
}

/* Steps to the nearest covered pixel, and its colour: one pass down and one up are exact. */
static void pass_down(const ground *g, int32_t *steps, int64_t row)
{
    int64_t w = g->width, from = row * w;
    for (int64_t i = from; i < from + w; i++) {
        steps[i] = g->state[i] ? 0 : FAR;
        if (row)
            nearer(g, steps, i, i - w);
        if (i > from)
            nearer(g, steps, i, i - 1);
    }
}

static void pass_up(const ground *g, int32_t *steps, int64_t row)
{
    int64_t w = g->width, from = row * w;
    for (int64_t i = from + w - 1; i >= from; i--) {
        if (row + 1 < g->height)
            nearer(g, steps, i, i + w);
        if (i + 1 < from + w)
            nearer(g, steps, i, i + 1);
    }
}

static pave_result fill(pave_context *context, const ground *g, int32_t *steps)
{
    pave_result result = PAVE_OK;
    for (int32_t k = 0; k < 2 * g->height && !result; k++) {
        if (k < g->height)
            pass_down(g, steps, k);
        else
            pass_up(g, steps, 2 * g->height - 1 - k);
        if (k % 64 == 0)
            result = pv_progress(context, 0.5);
    }
    return result;
}

static pave_result allocate(pave_context *context, const pv_survey *survey, ground *g, int32_t **steps,
                            pave_image **painted)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_result result;
    int64_t longest = 0, pixels = (int64_t)g->width * g->height;
    for (int32_t s = 0; s < survey->count; s++) {
        int64_t corners = survey->first[s + 1] - survey->first[s];
        longest = corners > longest ? corners : longest;
    }
    shape.width = g->width;
    shape.height = g->height;
    result = pv_image_new(context, &shape, painted);
    if (!result)
        memset((*painted)->pixels, 0, (size_t)pixels);
    if (!result)
        g->state = pv_allocate_zeroed(context, (size_t)pixels, 1, &result);
    if (!result)
        *steps = pv_allocate(context, (size_t)pixels, sizeof **steps, &result);
    if (!result)
        g->crossings = pv_allocate(context, (size_t)longest, sizeof *g->crossings, &result);
    return result;
}

pave_result pv_measure_ground(pave_context *context, const pv_survey *survey, pave_image **painted,
                              pave_stones_measures *out)
{
    const pave_stones *stones = survey->stones;
    ground g = { .survey = survey, .x = stones->x, .y = stones->y, .width = stones->width, .height = stones->height };
    int32_t *steps = NULL;
    pave_result result = allocate(context, survey, &g, &steps, painted);
    if (!result) {
        g.colour = (*painted)->pixels;
        result = cover_all(context, &g);
    }
    if (!result)
        result = count_pixels(context, &g, out);
    if (!result)
        result = fill(context, &g, steps);
    pv_release(g.state);
    pv_release(g.crossings);
    pv_release(steps);
    return result;
}
