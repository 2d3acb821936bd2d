/* Copies of the stones of a plane that repeats. */
#include "stones/copies.h"

#include "util/fixed.h"

#include <math.h>

enum { GRID = 1000 };

/* Moved by `first` to `last` periods, low .. high meets the window. */
static void range_of(int64_t low, int64_t high, int32_t start, int32_t length, int32_t period, int32_t *first,
                     int32_t *last)
{
    int64_t from = GRID * (int64_t)start, to = from + GRID * (int64_t)length, p = GRID * (int64_t)period;
    *first = (int32_t)pv_floor_div(from - high, p) + 1;
    *last = (int32_t)-pv_floor_div(low - to, p) - 1;
}

pv_copies pv_copies_seen(const pave_stones *head, const int32_t *xy, int32_t corners)
{
    pv_copies c = { 0, 0, 0, 0 };
    int32_t low[2] = { INT32_MAX, INT32_MAX }, high[2] = { INT32_MIN, INT32_MIN };
    if (!head->field.periodic)
        return c;
    for (int32_t i = 0; i < 2 * corners; i++) {
        low[i % 2] = xy[i] < low[i % 2] ? xy[i] : low[i % 2];
        high[i % 2] = xy[i] > high[i % 2] ? xy[i] : high[i % 2];
    }
    range_of(low[0], high[0], head->x, head->width, head->plane_width, &c.first_x, &c.last_x);
    range_of(low[1], high[1], head->y, head->height, head->plane_height, &c.first_y, &c.last_y);
    return c;
}

static void add(const pave_stones *stones, int32_t s, int32_t x, int32_t y, pave_stones *out)
{
    int64_t at = out->starts[out->count];
    for (int64_t i = stones->starts[s]; i < stones->starts[s + 1]; i++, at++) {
        out->vertices[2 * at] = stones->vertices[2 * i] + (double)x * stones->plane_width;
        out->vertices[2 * at + 1] = stones->vertices[2 * i + 1] + (double)y * stones->plane_height;
    }
    out->colours[out->count] = stones->colours[s];
    for (int c = 0; c < 3 && stones->rgb; c++)
        out->rgb[3 * out->count + c] = stones->rgb[3 * s + c];
    out->starts[++out->count] = at;
}

static pv_copies seen(const pave_stones *stones, int32_t s)
{
    int32_t low[4] = { INT32_MAX, INT32_MAX, INT32_MIN, INT32_MIN };
    for (int64_t i = 2 * stones->starts[s]; i < 2 * stones->starts[s + 1]; i++) {
        int32_t v = (int32_t)floor(stones->vertices[i] * GRID + 0.5);
        low[i % 2] = v < low[i % 2] ? v : low[i % 2];
        low[2 + i % 2] = v > low[2 + i % 2] ? v : low[2 + i % 2];
    }
    return pv_copies_seen(stones, low, 2);
}

static pave_result allocate(pave_context *context, int64_t count, int64_t corners, int in_colour, pave_stones *out)
{
    pave_result result = PAVE_OK;
    out->starts = pv_allocate_zeroed(context, (size_t)count + 1, sizeof *out->starts, &result);
    if (!result)
        out->vertices = pv_allocate(context, (size_t)corners, 2 * sizeof *out->vertices, &result);
    if (!result)
        out->colours = pv_allocate(context, (size_t)count, sizeof *out->colours, &result);
    if (!result && in_colour)
        out->rgb = pv_allocate(context, (size_t)count, 3, &result);
    return result;
}

pave_result pv_copies_make(pave_context *context, const pave_stones *stones, pave_stones *out)
{
    int64_t count = 0, corners = 0;
    *out = *stones;
    out->starts = NULL;
    out->vertices = NULL;
    out->colours = NULL;
    out->rgb = NULL;
    out->count = 0;
    for (int32_t s = 0; s < stones->count; s++) {
        pv_copies c = seen(stones, s);
        int64_t copies = (int64_t)(c.last_x - c.first_x + 1) * (c.last_y - c.first_y + 1);
        count += c.last_x < c.first_x || c.last_y < c.first_y ? 0 : copies;
        corners += c.last_x < c.first_x || c.last_y < c.first_y
                       ? 0 : copies * (stones->starts[s + 1] - stones->starts[s]);
    }
    pave_result result = allocate(context, count, corners, stones->rgb != NULL, out);
    for (int32_t s = 0; s < stones->count && !result; s++) {
        pv_copies c = seen(stones, s);
        for (int32_t y = c.first_y; y <= c.last_y; y++)
            for (int32_t x = c.first_x; x <= c.last_x; x++)
                add(stones, s, x, y, out);
    }
    return result;
}

void pv_copies_free(pave_stones *copies)
{
    pv_release(copies->starts);
    pv_release(copies->vertices);
    pv_release(copies->colours);
    pv_release(copies->rgb);
}
