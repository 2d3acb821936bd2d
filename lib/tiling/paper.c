/* Mode paper: the first fraction at random, then from left to right and from top to bottom the one that differs least
 * where it overlaps what is there (Eq. 1), averaged there (Eq. 2). */
#include "tiling/quilt.h"

#include "util/random.h"

#include <string.h>

/* The result so far, as it is compared. */
typedef struct paper {
    pave_context *context;
    const pave_tiling_params *params;
    pv_canvas *canvas;
    int16_t *values;
    int32_t fraction, overlap;
    pv_query query;
    pv_searcher searcher;
} paper;

static void ask(paper *p, const pv_block *block)
{
    size_t depth = (size_t)p->canvas->bank->depth;
    pv_query_begin(&p->query, p->fraction, p->fraction);
    for (int32_t y = 0; y < block->height; y++)
        for (int32_t x = 0; x < block->width; x++) {
            size_t pixel = (size_t)pv_pixel(p->canvas, block->x + x, block->y + y);
            size_t at = (size_t)(y * p->fraction + x);
            if (p->canvas->source[pixel] < 0)
                continue;
            memcpy(p->query.value + at * depth, p->values + pixel * depth, depth * sizeof *p->values);
            p->query.counts[at] = 1;
        }
    pv_query_end(&p->query);
}

static void lay(paper *p, const pv_block *block)
{
    const pv_bank *bank = p->canvas->bank;
    for (int32_t y = 0; y < block->height; y++)
        for (int32_t x = 0; x < block->width; x++) {
            int32_t pixel = pv_pixel(p->canvas, block->x + x, block->y + y);
            int32_t place = block->source + y * bank->stride + x;
            int16_t *there = p->values + (int64_t)pixel * bank->depth;
            const int16_t *new = bank->values + (int64_t)place * bank->depth;
            for (int32_t k = 0; k < bank->depth; k++)
                there[k] = (int16_t)(p->canvas->source[pixel] < 0 ? new[k] : (there[k] + new[k] + 1) / 2);
            p->canvas->source[pixel] = place;
        }
}

static pave_result choose(paper *p, int32_t index, pv_block *block)
{
    int64_t difference;
    if (index) {
        ask(p, block);
        pave_result result = pv_search_least(p->context, &p->searcher, &p->query, &block->source, &difference);
        if (result)
            return result;
    } else {
        uint32_t word = pv_draw(p->params->seed, PV_DRAW_FRACTION, 0, 0, 0).word[0];
        block->source = pv_random_place(p->canvas->bank, p->fraction, p->fraction, word);
    }
    if (block->source < 0)
        return pv_fail(p->context, PAVE_ERR_ARGUMENT, "the exemplar has no usable fraction of %d x %d px",
                       (int)p->fraction, (int)p->fraction);
    return PAVE_OK;
}

/* How many blocks it takes: one that would show no more than its overlap is not laid. */
static int32_t blocks_along(const paper *p, int32_t size)
{
    int32_t step = p->fraction - p->overlap;
    return size <= p->fraction ? 1 : 1 + (size - p->fraction + step - 1) / step;
}

static void note_source(const pv_bank *bank, pv_block *b)
{
    pave_source right, down;
    b->from = pv_bank_source(bank, b->source);
    right = b->width > 1 ? pv_bank_source(bank, b->source + 1) : b->from;
    down = b->height > 1 ? pv_bank_source(bank, b->source + bank->stride) : b->from;
    b->right[0] = right.x - b->from.x, b->right[1] = right.y - b->from.y;
    b->down[0] = down.x - b->from.x, b->down[1] = down.y - b->from.y;
}

static pave_result lay_all(paper *p, int32_t across, int32_t down, pv_block *blocks)
{
    pave_result result = PAVE_OK;
    int32_t step = p->fraction - p->overlap;
    for (int32_t i = 0; i < across * down && !result; i++) {
        pv_block *b = &blocks[i];
        *b = (pv_block){ .x = i % across * step, .y = i / across * step, .width = p->fraction, .height = p->fraction,
                        .source = -1 };
        b->width = b->width < p->canvas->width - b->x ? b->width : p->canvas->width - b->x;
        b->height = b->height < p->canvas->height - b->y ? b->height : p->canvas->height - b->y;
        result = choose(p, i, b);
        if (!result) {
            lay(p, b);
            note_source(p->canvas->bank, b);
        }
        if (!result)
            result = pv_progress(p->context, (double)(i + 1) / (across * down));
    }
    return result;
}

pave_result pv_paper_lay(pave_context *context, const pave_tiling_params *params, pv_canvas *canvas,
                         pv_block **blocks, int32_t *count)
{
    pave_result result = PAVE_OK;
    paper p = { .context = context, .params = params, .canvas = canvas,
                .searcher = pv_searcher_of(context, canvas->bank, params->search) };
    p.fraction = params->fraction ? params->fraction : 20;
    p.overlap = params->overlap ? params->overlap : p.fraction > 3 ? 3 : p.fraction - 1;
    int32_t across = blocks_along(&p, canvas->width), down = blocks_along(&p, canvas->height);
    size_t values = (size_t)canvas->width * (size_t)canvas->height * (size_t)canvas->bank->depth;
    *count = 0;
    *blocks = pv_allocate(context, (size_t)across * (size_t)down, sizeof **blocks, &result);
    if (!result)
        p.values = pv_allocate(context, values, sizeof *p.values, &result);
    if (!result)
        result = pv_query_create(context, canvas->bank, p.fraction, p.fraction, &p.query);
    if (!result)
        result = lay_all(&p, across, down, *blocks);
    *count = across * down;
    pv_query_free(&p.query);
    pv_searcher_free(&p.searcher);
    pv_release(p.values);
    return result;
}
