/* Blocks: what mode best starts with. Each is searched for by what is laid already where it overlaps, and cut there.
 * Source: Kwatra et al. 2003, "Graphcut textures", section 3.1. */
#include "tiling/best.h"
#include "tiling/quilt.h"

/* The part of the canvas around a block that prices are reckoned in. */
static pv_area part_around(const pv_worker *w, pv_area block)
{
    const pv_canvas *c = w->canvas;
    int32_t width = w->scale->part_width - 2 * c->wrap_x, height = w->scale->part_height - 2 * c->wrap_y;
    width = width > block.width ? width : block.width;
    height = height > block.height ? height : block.height;
    int32_t x = block.x - (width - block.width) / 2, y = block.y - (height - block.height) / 2;
    x = c->wrap_x ? pv_wrapped(x, c->width) : x < 0 ? 0 : x + width > c->width ? c->width - width : x;
    y = c->wrap_y ? pv_wrapped(y, c->height) : y < 0 ? 0 : y + height > c->height ? c->height - height : y;
    return (pv_area){ x, y, width, height };
}

/* What is there already where a block is to lie. Returns the number of pixels. */
static int32_t ask_block(pv_worker *w, pv_area block)
{
    int32_t laid = 0;
    pv_query_begin(&w->query, block.width, block.height);
    for (int32_t y = 0; y < block.height; y++)
        for (int32_t x = 0; x < block.width; x++) {
            int32_t source = w->canvas->source[pv_pixel(w->canvas, block.x + x, block.y + y)];
            if (source < 0)
                continue;
            pv_query_set(&w->query, x, y, source);
            laid++;
        }
    pv_query_end(&w->query);
    return laid;
}

/* Returns 0 if the exemplar has no usable block as large. */
static int lay_block(pv_worker *w, pv_area block, int32_t index)
{
    pv_random random = pv_draw(w->params->seed, PV_DRAW_BLOCKS, (uint32_t)index, 0, w->attempt->number);
    pv_area part = part_around(w, block);
    pv_area window = { pv_wrapped(block.x - part.x, w->canvas->width), pv_wrapped(block.y - part.y, w->canvas->height),
                       block.width, block.height };
    pv_candidate best = { -1, 0 };
    pv_scale own = *w->scale;
    own.reach = block.width > block.height ? block.width : block.height;
    int32_t laid = ask_block(w, block);
    if (laid == block.width * block.height)
        return 1;
    pv_repeats_count(&w->repeats, part);
    if (!laid)
        best.place = pv_random_place(w->canvas->bank, block.width, block.height, random.word[3]);
    else
        pv_candidates_find(w, &own, window, &random, 1, &best);
    if (best.place < 0)
        return 0;
    w->copy.gain = 0;
    pv_copy_try(w, &own, window, best.place);
    pv_cut_lay(w->copy.taken, w->canvas, w->copy.area, w->copy.first);
    return 1;
}

/* A row or column of blocks: where the i-th of n begins and ends, overlaps included. */
static void block_span(int32_t size, int wraps, int32_t n, int32_t overlap, int32_t shift, int32_t i, int32_t *from,
                       int32_t *length)
{
    int32_t a = (int32_t)((int64_t)size * i / n) - overlap / 2;
    int32_t b = (int32_t)((int64_t)size * (i + 1) / n) + overlap / 2;
    if (wraps) {
        *from = pv_wrapped((a + size + shift) % size, size);
        *length = b - a < size - 2 ? b - a : size - 2;
        return;
    }
    *from = a < 0 ? 0 : a;
    *length = (b > size ? size : b) - *from;
}

static void count_blocks(const pv_worker *w, int32_t *across, int32_t *down)
{
    const pv_canvas *c = w->canvas;
    int32_t step = w->scale->block - w->scale->overlap;
    *across = (c->width + step - 1) / step;
    *down = (c->height + step - 1) / step;
    *across = *across > 1 + c->wrap_x ? *across : 1 + c->wrap_x;
    *down = *down > 1 + c->wrap_y ? *down : 1 + c->wrap_y;
}

int32_t pv_blocks_all(const pv_worker *w)
{
    int32_t across, down;
    count_blocks(w, &across, &down);
    return across * down;
}

int pv_blocks_lay(pv_worker *w, int32_t i)
{
    enum { SOME = 64 };
    const pv_canvas *c = w->canvas;
    int32_t across, down, overlap = w->scale->overlap;
    pv_area block;
    count_blocks(w, &across, &down);
    pv_random random = pv_draw(w->params->seed, PV_DRAW_BLOCKS, (uint32_t)(i / across), 1, w->attempt->number);
    int32_t shift = (int32_t)pv_below(random.word[0], (uint32_t)c->width);
    block_span(c->width, c->wrap_x, across, overlap, shift, i % across, &block.x, &block.width);
    block_span(c->height, c->wrap_y, down, overlap, 0, i / across, &block.y, &block.height);
    if (i % (across * down / SOME + 1) == 0)
        pv_coverage_count(&w->attempt->coverage, c);
    return lay_block(w, block, i);
}
