/* Vertices by block, and runs over blocks in four turns. */
#include "stones/blocks.h"

#include "util/fixed.h"

#include <string.h>

typedef struct lattice {
    int64_t side, shift;
    int32_t left, top; /* the first block */
} lattice;

static int32_t column_of(const lattice *l, int32_t v)
{
    return (int32_t)pv_floor_div(v + l->shift, l->side);
}

/* Vertices of faces that reach over more than two blocks stay as they are. */
static void free_vertices(const pv_tess *tess, const lattice *l, uint8_t *idle)
{
    for (int32_t f = 0; f < tess->face_count; f++) {
        int32_t low_x = INT32_MAX, low_y = INT32_MAX, high_x = INT32_MIN, high_y = INT32_MIN;
        for (int64_t p = tess->first[f]; p < tess->first[f + 1]; p++) {
            pv_cell c = tess->at[tess->corner[p]];
            low_x = c.x < low_x ? c.x : low_x;
            low_y = c.y < low_y ? c.y : low_y;
            high_x = c.x > high_x ? c.x : high_x;
            high_y = c.y > high_y ? c.y : high_y;
        }
        if (column_of(l, high_x) - column_of(l, low_x) < 2 && column_of(l, high_y) - column_of(l, low_y) < 2)
            continue;
        for (int64_t p = tess->first[f]; p < tess->first[f + 1]; p++)
            idle[tess->corner[p]] = 1;
    }
}

static void set_size(const pv_tess *tess, lattice *l, pv_blocks *out)
{
    int32_t right = INT32_MIN, bottom = INT32_MIN;
    l->left = l->top = INT32_MAX;
    for (int32_t v = 0; v < tess->vertex_count; v++) {
        int32_t x = column_of(l, tess->at[v].x), y = column_of(l, tess->at[v].y);
        l->left = x < l->left ? x : l->left;
        l->top = y < l->top ? y : l->top;
        right = x > right ? x : right;
        bottom = y > bottom ? y : bottom;
    }
    l->left -= l->left & 1; /* turns belong to the plane */
    l->top -= l->top & 1;
    out->across = right - l->left + 1;
    out->down = bottom - l->top + 1;
}

static int64_t block_of(const lattice *l, const pv_blocks *b, pv_cell c)
{
    return (int64_t)(column_of(l, c.y) - l->top) * b->across + column_of(l, c.x) - l->left;
}

pave_result pv_blocks_build(pave_context *context, const pv_tess *tess, int64_t side, int shifted, pv_blocks *out)
{
    lattice l = { side, shifted ? side / 2 : 0, 0, 0 };
    pave_result result = PAVE_OK;
    memset(out, 0, sizeof *out);
    set_size(tess, &l, out);
    int64_t blocks = (int64_t)out->across * out->down;
    uint8_t *idle = pv_allocate_zeroed(context, (size_t)tess->vertex_count, 1, &result);
    if (!result)
        out->first = pv_allocate_zeroed(context, (size_t)blocks + 2, sizeof *out->first, &result);
    if (!result)
        out->vertex = pv_allocate(context, (size_t)tess->vertex_count, sizeof *out->vertex, &result);
    if (!result) {
        free_vertices(tess, &l, idle);
        for (int32_t v = 0; v < tess->vertex_count; v++)
            if (!idle[v])
                out->first[block_of(&l, out, tess->at[v]) + 2]++;
        for (int64_t b = 0; b < blocks; b++)
            out->first[b + 2] += out->first[b + 1];
        for (int32_t v = 0; v < tess->vertex_count; v++)
            if (!idle[v])
                out->vertex[out->first[block_of(&l, out, tess->at[v]) + 1]++] = v;
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
    }
    return result;
}

void pv_blocks_free(pv_blocks *blocks)
{
    pv_release(blocks->first);
    pv_release(blocks->vertex);
    memset(blocks, 0, sizeof *blocks);
}
