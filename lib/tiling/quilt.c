/* Mode fast: quilting on a torus. Every block covers the overlaps with its neighbours and is cut along the path through
 * each of them on which it differs least from what is there.
 * Source: Efros and Freeman 2001, "Image quilting for texture synthesis and transfer", section 2. */
#include "tiling/quilt.h"

#include "util/random.h"

#include <string.h>

enum { LEFT, TOP, RIGHT, BOTTOM, SIDES };

typedef struct quilt {
    pave_context *context;
    const pave_tiling_params *params;
    pv_canvas *canvas;
    int32_t overlap, most; /* most: side of a block */
    pv_query query;
    pv_searcher searcher;
    int64_t *costs;
    int32_t *path; /* costs of paths through one overlap, and from where each comes */
    int8_t *turn;
    int32_t *edge; /* how far in the cut runs, for each side */
} quilt;

int32_t pv_random_place(const pv_bank *bank, int32_t width, int32_t height, uint32_t word)
{
    int64_t all = 0, wanted = -1;
    for (int pass = 0; pass < 2; pass++) {
        int64_t count = 0;
        for (int32_t i = 0; i < bank->sheets; i++) {
            pv_places p = pv_places_all(&bank->sheet[i], width, height);
            for (int32_t k = 0; k < p.across * p.down; k++) {
                int32_t place = p.sheet->first + k / p.across * bank->stride + k % p.across;
                if (pv_bank_clear(bank, place, width, height) && count++ == wanted)
                    return place;
            }
        }
        all = count;
        wanted = all ? (int64_t)pv_below(word, (uint32_t)all) : -1;
    }
    return -1;
}

static int32_t laid(const quilt *q, pv_area block, int32_t x, int32_t y)
{
    return q->canvas->source[pv_pixel(q->canvas, block.x + x, block.y + y)];
}

static int32_t ask(quilt *q, pv_area block)
{
    int32_t count = 0;
    pv_query_begin(&q->query, block.width, block.height);
    for (int32_t y = 0; y < block.height; y++)
        for (int32_t x = 0; x < block.width; x++)
            if (laid(q, block, x, y) >= 0) {
                pv_query_set(&q->query, x, y, laid(q, block, x, y));
                count++;
            }
    pv_query_end(&q->query);
    return count;
}

/* One of the places that are at most a tenth of the least difference worse, at random. */
static pave_result choose(quilt *q, pv_area block, uint32_t word, int32_t *place)
{
    const pv_bank *bank = q->canvas->bank;
    int64_t least = PV_NO_PLACE, good = 0, wanted = -1;
    pave_result result = PAVE_OK;
    *place = -1;
    for (int pass = 0; pass < 3 && !result; pass++) {
        for (int32_t i = 0; i < bank->sheets && !result; i++) {
            pv_places p = pv_places_all(&bank->sheet[i], block.width, block.height);
            p = pv_places_even(p, block.x, block.y);
            if (!pass || bank->sheets > 1)
                result = pv_search_costs(q->context, &q->searcher, &q->query, &p, q->costs);
            for (int32_t k = 0; k < p.across * p.down && !result; k++) {
                int64_t cost = q->costs[k];
                if (!pass)
                    least = cost < least ? cost : least;
                else if (cost <= least + least / 10 && cost < PV_NO_PLACE && (pass == 1 || wanted-- == 0)) {
                    good++;
                    *place = pv_place_at(bank, &p, k % p.across, k / p.across);
                }
            }
        }
        wanted = pass == 1 ? (int64_t)pv_below(word, (uint32_t)good) : -1;
    }
    return result;
}

/* The pixel of a block that is `in` px from a side, `along` px from that side's beginning. */
static void at_side(pv_area block, int side, int32_t along, int32_t in, int32_t *x, int32_t *y)
{
    *x = side == LEFT ? in : side == RIGHT ? block.width - 1 - in : along;
    *y = side == TOP ? in : side == BOTTOM ? block.height - 1 - in : along;
}

static int32_t cost_at(const quilt *q, pv_area block, int32_t place, int side, int32_t along, int32_t in)
{
    int32_t x, y;
    at_side(block, side, along, in, &x, &y);
    int32_t old = laid(q, block, x, y);
    return old < 0 ? 0 : pv_differ(q->canvas->bank, old, place + y * q->canvas->bank->stride + x);
}

/* The path through a side's overlap that costs least: for each place along the side, the first px in that is new. */
static void find_path(const quilt *q, pv_area block, int32_t place, int side, int32_t *edge)
{
    int32_t length = side == LEFT || side == RIGHT ? block.height : block.width, n = q->overlap, best = 0;
    for (int32_t a = 0; a < length; a++)
        for (int32_t d = 0; d < n; d++) {
            const int32_t *before = q->path + (a - 1) * n;
            int turn = 0;
            if (a && d && before[d - 1] < before[d])
                turn = -1;
            if (a && d + 1 < n && before[d + 1] < before[d + turn])
                turn = 1;
            q->turn[a * n + d] = (int8_t)turn;
            q->path[a * n + d] = cost_at(q, block, place, side, a, d) + (a ? before[d + turn] : 0);
        }
    for (int32_t d = 1; d < n; d++)
        best = q->path[(length - 1) * n + d] < q->path[(length - 1) * n + best] ? d : best;
    for (int32_t a = length - 1; a >= 0; a--) {
        edge[a] = best;
        best += q->turn[a * n + best];
    }
}

/* Is anything laid where a side has its middle? Then it is cut. */
static int is_laid(const quilt *q, pv_area block, int side)
{
    int32_t x, y;
    at_side(block, side, (side == LEFT || side == RIGHT ? block.height : block.width) / 2, 0, &x, &y);
    return laid(q, block, x, y) >= 0;
}

static void lay_block(quilt *q, pv_area block, int32_t place)
{
    int cut[SIDES];
    for (int side = 0; side < SIDES; side++) {
        cut[side] = is_laid(q, block, side);
        if (cut[side])
            find_path(q, block, place, side, q->edge + side * q->most);
    }
    for (int32_t y = 0; y < block.height; y++)
        for (int32_t x = 0; x < block.width; x++) {
            const int32_t *edge = q->edge;
            int inside = (!cut[LEFT] || x >= edge[LEFT * q->most + y]) && (!cut[TOP] || y >= edge[TOP * q->most + x]) &&
                         (!cut[RIGHT] || block.width - 1 - x >= edge[RIGHT * q->most + y]) &&
                         (!cut[BOTTOM] || block.height - 1 - y >= edge[BOTTOM * q->most + x]);
            if (inside || laid(q, block, x, y) < 0)
                q->canvas->source[pv_pixel(q->canvas, block.x + x, block.y + y)] =
                    place + y * q->canvas->bank->stride + x;
        }
}

/* Block i of n along a side: it reaches back over its neighbour. */
static void span(int32_t size, int wraps, int32_t n, int32_t overlap, int32_t i, int32_t *from, int32_t *length)
{
    int32_t a = (int32_t)((int64_t)size * i / n), b = (int32_t)((int64_t)size * (i + 1) / n);
    int32_t back = i || (wraps && n > 1) ? overlap : 0;
    *from = pv_wrapped(a - back, size);
    *length = b - a + back < size ? b - a + back : size;
}

static int32_t blocks_along(int32_t size, int32_t step)
{
    return (size + step - 1) / step;
}

static pave_result lay_all(quilt *q, int32_t across, int32_t down)
{
    pv_canvas *c = q->canvas;
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < across * down && !result; i++) {
        pv_area block;
        int32_t place;
        uint32_t word = pv_draw(q->params->seed, PV_DRAW_BLOCKS, (uint32_t)i, 2, 0).word[0];
        span(c->width, c->wrap_x, across, q->overlap, i % across, &block.x, &block.width);
        span(c->height, c->wrap_y, down, q->overlap, i / across, &block.y, &block.height);
        if (ask(q, block))
            result = choose(q, block, word, &place);
        else
            place = pv_random_place(c->bank, block.width, block.height, word);
        if (!result && place < 0)
            result = pv_fail(q->context, PAVE_ERR_ARGUMENT, "the exemplar has no usable block of %d x %d px",
                             (int)block.width, (int)block.height);
        if (!result)
            lay_block(q, block, place);
        if (!result)
            result = pv_progress(q->context, (double)(i + 1) / (across * down));
    }
    return result;
}

static pave_result allocate(quilt *q)
{
    pave_result result = PAVE_OK;
    size_t places = 0, cells = (size_t)q->most * (size_t)q->overlap;
    for (int32_t i = 0; i < q->canvas->bank->sheets; i++) {
        const pv_sheet *sheet = &q->canvas->bank->sheet[i];
        size_t n = (size_t)sheet->width * (size_t)sheet->height;
        places = n > places ? n : places;
    }
    result = pv_query_create(q->context, q->canvas->bank, q->most, q->most, &q->query);
    if (!result)
        q->costs = pv_allocate(q->context, places, sizeof *q->costs, &result);
    if (!result)
        q->path = pv_allocate(q->context, cells, sizeof *q->path, &result);
    if (!result)
        q->turn = pv_allocate(q->context, cells, sizeof *q->turn, &result);
    if (!result)
        q->edge = pv_allocate(q->context, SIDES * (size_t)q->most, sizeof *q->edge, &result);
    return result;
}

pave_result pv_quilt_lay(pave_context *context, const pave_tiling_params *params, int32_t block, int32_t overlap,
                         pv_canvas *canvas)
{
    quilt q = { .context = context, .params = params, .canvas = canvas, .overlap = overlap, .most = block + 1,
                .searcher = pv_searcher_of(context, canvas->bank, params->search) };
    int32_t step = block - overlap;
    pave_result result = allocate(&q);
    if (!result)
        result = lay_all(&q, blocks_along(canvas->width, step), blocks_along(canvas->height, step));
    pv_query_free(&q.query);
    pv_searcher_free(&q.searcher);
    pv_release(q.costs);
    pv_release(q.path);
    pv_release(q.turn);
    pv_release(q.edge);
    return result;
}
