/* Vertices by block, and runs over blocks in four turns. */
#include "stones/blocks.h"

#include "util/fixed.h"

#include <string.h>

/* Blocks along a line: `count` in each span. */
typedef struct axis {
    int64_t span, count, shift;
    int32_t first; /* block of all */
    int32_t whole; /* of the period that works; INT32_MIN: all do */
} axis;

typedef struct lattice {
    axis x, y;
} lattice;

static int64_t blocks_in(int64_t side, int64_t period)
{
    int64_t pairs = (period + side) / (2 * side);
    return pairs ? 2 * pairs : 2; /* even, so that turns go round */
}

int64_t pv_block_length(int64_t side, int64_t period)
{
    return period ? pv_ceil_div(period, blocks_in(side, period)) : side;
}

static int32_t block_at(const axis *a, int64_t v)
{
    return (int32_t)pv_floor_div((v + a->shift) * a->count, a->span);
}

static axis make_axis(int64_t side, int shifted, int64_t period, int has_whole, int32_t whole)
{
    axis a = { side, 1, 0, INT32_MAX, INT32_MIN };
    if (period)
        a.span = period, a.count = blocks_in(side, period);
    a.shift = shifted ? a.span / a.count / 2 : 0;
    if (has_whole)
        a.whole = block_at(&a, (int64_t)whole - 1) + 1;
    return a;
}

static int works(const axis *a, int32_t v)
{
    int32_t b = block_at(a, v);
    return a->whole == INT32_MIN || (b >= a->whole && b < a->whole + a->count);
}

static int32_t blocks_between(const axis *a, int32_t low, int32_t high)
{
    return block_at(a, high) - block_at(a, low);
}

/* Vertices of faces that reach over more than two blocks stay as they are; copies follow. */
static void find_idle(const pv_tess *tess, const lattice *l, uint8_t *idle)
{
    for (int32_t v = 0; v < tess->vertex_count; v++)
        idle[v] = !works(&l->x, tess->at[v].x) || !works(&l->y, tess->at[v].y);
    for (int32_t f = 0; f < tess->face_count; f++) {
        int32_t low_x = INT32_MAX, low_y = INT32_MAX, high_x = INT32_MIN, high_y = INT32_MIN;
        for (int64_t p = tess->first[f]; p < tess->first[f + 1]; p++) {
            pv_cell c = tess->at[tess->corner[p]];
            low_x = c.x < low_x ? c.x : low_x;
            low_y = c.y < low_y ? c.y : low_y;
            high_x = c.x > high_x ? c.x : high_x;
            high_y = c.y > high_y ? c.y : high_y;
        }
        if (blocks_between(&l->x, low_x, high_x) < 2 && blocks_between(&l->y, low_y, high_y) < 2)
            continue;
        for (int64_t p = tess->first[f]; p < tess->first[f + 1]; p++)
            idle[tess->corner[p]] = 1;
    }
}

static void set_size(const pv_tess *tess, lattice *l, pv_blocks *out)
{
    int32_t right = INT32_MIN, bottom = INT32_MIN;
    for (int32_t v = 0; v < tess->vertex_count; v++) {
        int32_t x = block_at(&l->x, tess->at[v].x), y = block_at(&l->y, tess->at[v].y);
        l->x.first = x < l->x.first ? x : l->x.first;
        l->y.first = y < l->y.first ? y : l->y.first;
        right = x > right ? x : right;
        bottom = y > bottom ? y : bottom;
    }
    l->x.first -= l->x.first & 1; /* turns belong to the plane */
    l->y.first -= l->y.first & 1;
    out->across = right - l->x.first + 1;
    out->down = bottom - l->y.first + 1;
}

static int64_t block_of(const lattice *l, const pv_blocks *b, pv_cell c)
{
    return (int64_t)(block_at(&l->y, c.y) - l->y.first) * b->across + block_at(&l->x, c.x) - l->x.first;
}

pave_result pv_blocks_build(pave_context *context, pv_tess *tess, int64_t side, int shifted, pv_blocks *out)
{
    lattice l = { make_axis(side, shifted, tess->period.x, tess->has_whole, tess->whole.x),
                  make_axis(side, shifted, tess->period.y, tess->has_whole, tess->whole.y) };
    pave_result result = PAVE_OK;
    memset(out, 0, sizeof *out);
    out->tess = tess;
    set_size(tess, &l, out);
    int64_t blocks = (int64_t)out->across * out->down;
    uint8_t *idle = pv_allocate_zeroed(context, (size_t)tess->vertex_count, 1, &result);
    if (!result)
        out->first = pv_allocate_zeroed(context, (size_t)blocks + 2, sizeof *out->first, &result);
    if (!result)
        out->vertex = pv_allocate(context, (size_t)tess->vertex_count, sizeof *out->vertex, &result);
    if (!result) {
        find_idle(tess, &l, idle);
        for (int32_t v = 0; v < tess->vertex_count; v++)
            if (!idle[v])
                out->first[block_of(&l, out, tess->at[v]) + 2]++;
        for (int64_t b = 0; b < blocks; b++)
            out->first[b + 2] += out->first[b + 1];
        for (int32_t v = 0; v < tess->vertex_count; v++)
            if (!idle[v])
                out->vertex[out->first[block_of(&l, out, tess->at[v]) + 1]++] = v;
    }
    if (!result && tess->has_whole) {
        for (int32_t v = 0; v < tess->vertex_count; v++)
            idle[v] = works(&l.x, tess->at[v].x) && works(&l.y, tess->at[v].y);
        result = pv_twins_find(context, tess, idle, &out->twins);
    }
    pv_release(idle);
    return result;
}

typedef struct turn {
    const pv_blocks *blocks;
    pv_block_task *task;
    void *data;
    int32_t x, y, across;
} turn;

static void run_block(void *data, int32_t index, int32_t worker)
{
    const turn *t = data;
    int32_t x = t->x + 2 * (index % t->across), y = t->y + 2 * (index / t->across);
    int64_t b = (int64_t)y * t->blocks->across + x, count = t->blocks->first[b + 1] - t->blocks->first[b];
    (void)worker;
    if (count)
        t->task(t->data, t->blocks->vertex + t->blocks->first[b], count);
}

pave_result pv_blocks_run(pave_context *context, const pv_blocks *blocks, pv_block_task *task, void *data, double from,
                          double to)
{
    pave_result result = PAVE_OK;
    for (int32_t k = 0; k < 4 && !result; k++) {
        turn t = { blocks, task, data, k & 1, k >> 1, (blocks->across - (k & 1) + 1) / 2 };
        int32_t down = (blocks->down - (k >> 1) + 1) / 2;
        if (t.across > 0 && down > 0)
            result = pv_parallel(context, t.across * down, run_block, &t, from + (to - from) * k / 4,
                                 from + (to - from) * (k + 1) / 4);
        pv_twins_follow(&blocks->twins, blocks->tess);
    }
    return result;
}

void pv_blocks_free(pv_blocks *blocks)
{
    pv_release(blocks->first);
    pv_release(blocks->vertex);
    pv_twins_free(&blocks->twins);
    memset(blocks, 0, sizeof *blocks);
}
