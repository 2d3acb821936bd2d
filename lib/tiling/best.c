/* Mode best: blocks laid over each other and cut; then, part by part, the worst seam looked up and cut again with a
 * copy that fits what is around it. */
#include "tiling/best.h"
#include "tiling/quilt.h"

#include "util/random.h"

#include <string.h>

enum { CLEAR = 2, MOST_FAILS = 6, SOME = 64, FEW_PARTS = 4 };

/* The whole job. */
typedef struct job {
    pave_context *context;
    const pave_tiling_params *params;
    pv_canvas *canvas;
    pv_scale scale;
    pv_coverage coverage;
    uint8_t *fails; /* how often a pixel's seams have been tried in vain */
    int32_t workers;
    pv_worker *worker;
    int32_t across, down; /* parts */
    int32_t shift_x, shift_y, round;
} job;

/* A stretch of one side of the canvas: part i of `parts`. Between parts one or two pixels belong to none, so that what
 * one thread reads no other writes. */
static void stretch(int32_t size, int wraps, int32_t parts, int32_t shift, int32_t i, int32_t *from, int32_t *length)
{
    int32_t each = size / parts, end;
    if (!wraps && parts == 1) {
        *from = 0;
        *length = size;
        return;
    }
    *from = shift % each + i * each;
    end = *from + each - 2;
    if (!wraps && i == parts - 1) /* what is left over at both ends is the turn of other rounds */
        end = end < size ? end : size;
    *length = end - *from;
}

static pv_area part_at(const job *j, int32_t index)
{
    pv_area part;
    stretch(j->canvas->width, j->canvas->wrap_x, j->across, j->shift_x, index % j->across, &part.x, &part.width);
    stretch(j->canvas->height, j->canvas->wrap_y, j->down, j->shift_y, index / j->across, &part.y, &part.height);
    part.x = pv_wrapped(part.x, j->canvas->width);
    part.y = pv_wrapped(part.y, j->canvas->height);
    return part;
}

/* What the seams to the right and below cost at every pixel of the part, and the sums of that. */
static void find_heat(pv_worker *w, const uint8_t *fails)
{
    const pv_canvas *canvas = w->canvas;
    pv_area part = w->repeats.area;
    for (int32_t y = 0; y < part.height; y++) {
        int64_t row = 0;
        for (int32_t x = 0; x < part.width; x++) {
            int32_t pixel = pv_pixel(canvas, part.x + x, part.y + y), at = y * part.width + x, heat = 0;
            int32_t source = canvas->source[pixel], stride = canvas->bank->stride;
            if (x + 1 < part.width)
                heat += pv_seam(canvas->bank, source, canvas->source[pv_pixel(canvas, part.x + x + 1, part.y + y)], 1);
            if (y + 1 < part.height)
                heat += pv_seam(canvas->bank, source, canvas->source[pv_pixel(canvas, part.x + x, part.y + y + 1)],
                                stride);
            w->heat[at] = heat;
            row += heat >> fails[pixel];
            w->sums[at] = row + (y ? w->sums[at - part.width] : 0);
        }
    }
}

static int64_t heat_in(const pv_worker *w, int32_t x, int32_t y, int32_t width, int32_t height)
{
    const int64_t *sums = w->sums;
    int32_t across = w->repeats.area.width, right = x + width - 1, bottom = y + height - 1;
    int64_t all = sums[bottom * across + right];
    all -= x ? sums[bottom * across + x - 1] : 0;
    all -= y ? sums[(y - 1) * across + right] : 0;
    return x && y ? all + sums[(y - 1) * across + x - 1] : all;
}

static int64_t worst_window(const pv_worker *w, int32_t side, pv_area *window)
{
    pv_area part = w->repeats.area;
    int64_t most = -1;
    *window = (pv_area){ 0, 0, side < part.width ? side : part.width, side < part.height ? side : part.height };
    for (int32_t y = 0; y + window->height <= part.height; y += 2)
        for (int32_t x = 0; x + window->width <= part.width; x += 2) {
            int64_t heat = heat_in(w, x, y, window->width, window->height);
            if (heat > most) {
                most = heat;
                window->x = x;
                window->y = y;
            }
        }
    return most;
}

/* What lies in every other row of the window, but for the seams and what is next to them. */
static void ask(pv_worker *w, pv_area window)
{
    pv_area part = w->repeats.area;
    pv_query_begin(&w->query, window.width, window.height);
    for (int32_t y = 0; y < window.height; y += 2)
        for (int32_t x = 0; x < window.width; x++) {
            int32_t left = window.x + x - CLEAR, top = window.y + y - CLEAR, side = 2 * CLEAR;
            left = left < 0 ? 0 : left + side < part.width ? left : part.width - side;
            top = top < 0 ? 0 : top + side < part.height ? top : part.height - side;
            if (heat_in(w, left, top, side, side) == 0)
                pv_query_set(&w->query, x, y, w->canvas->source[pv_pixel(w->canvas, part.x + window.x + x,
                                                                         part.y + window.y + y)]);
        }
    pv_query_end(&w->query);
}

static void note_failure(job *j, const pv_worker *w, pv_area window)
{
    pv_area part = w->repeats.area;
    for (int32_t y = 0; y < window.height; y++)
        for (int32_t x = 0; x < window.width; x++) {
            uint8_t *fails = &j->fails[pv_pixel(j->canvas, part.x + window.x + x, part.y + window.y + y)];
            *fails = (uint8_t)(*fails < MOST_FAILS ? *fails + 1 : MOST_FAILS);
        }
}

/* Lays the copy that was cut, and forgets what was tried in vain there. */
static void lay_copy(job *j, const pv_worker *w, pv_area area, int32_t first)
{
    pv_cut_lay(w->cut.taken, j->canvas, area, first);
    for (int32_t y = 0; y < area.height; y++)
        for (int32_t x = 0; x < area.width; x++)
            if (w->cut.taken[y * area.width + x])
                j->fails[pv_pixel(j->canvas, area.x + x, area.y + y)] = 0;
}

/* How often a window has been tried in vain. */
static int32_t tried(const job *j, pv_area part, pv_area window)
{
    return j->fails[pv_pixel(j->canvas, part.x + window.x + window.width / 2, part.y + window.y + window.height / 2)];
}

/* The worst seam of a part is cut again, with one candidate: cutting the next worst seam gains more than a second one
 * does. Where the best was in vain, the next best has its turn. */
static void mend(void *data, int32_t index, int32_t worker)
{
    job *j = data;
    pv_worker *w = &j->worker[worker];
    pv_area part = part_at(j, index), window, area;
    int32_t first;
    pv_candidate list[PV_MOST_CANDIDATES];
    if (part.width < 2 * j->scale.window / 3 || part.height < 2 * j->scale.window / 3)
        return;
    pv_repeats_count(&w->repeats, part);
    find_heat(w, j->fails);
    if (worst_window(w, j->scale.window, &window) <= 0)
        return;
    ask(w, window);
    pv_random random = pv_draw(j->params->seed, PV_DRAW_ROUNDS, (uint32_t)j->round, (uint32_t)index, 1);
    int32_t count = pv_candidates_find(w, &j->scale, window, &random, 1 + tried(j, part, window), list);
    if (count && pv_copy_find(w, &j->scale, window, list[count - 1].place, &area, &first) > 0)
        lay_copy(j, w, area, first);
    else
        note_failure(j, w, window);
}

static pave_result refine(job *j, double from, double to)
{
    pave_result result = PAVE_OK;
    int32_t parts = j->across * j->down, rounds = j->params->rounds ? j->params->rounds : parts > FEW_PARTS ? 140 : 480;
    for (j->round = 0; j->round < rounds && !result; j->round++) {
        pv_random random = pv_draw(j->params->seed, PV_DRAW_ROUNDS, (uint32_t)j->round, 0, 0);
        double a = from + (to - from) * j->round / rounds;
        j->shift_x = (int32_t)pv_below(random.word[0], 1 << 20);
        j->shift_y = (int32_t)pv_below(random.word[1], 1 << 20);
        pv_coverage_count(&j->coverage, j->canvas);
        result = pv_parallel(j->context, parts, mend, j, a, a + (to - from) / rounds);
    }
    return result;
}

/* The part of the canvas around a block that prices are reckoned in. */
static pv_area part_around(const job *j, pv_area block)
{
    const pv_canvas *c = j->canvas;
    int32_t width = c->width / j->across - 2 * c->wrap_x, height = c->height / j->down - 2 * c->wrap_y;
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

static pave_result lay_block(job *j, pv_area block, int32_t index)
{
    pv_worker *w = &j->worker[0];
    pv_random random = pv_draw(j->params->seed, PV_DRAW_BLOCKS, (uint32_t)index, 0, 0);
    pv_area part = part_around(j, block), area;
    pv_area window = { pv_wrapped(block.x - part.x, j->canvas->width), pv_wrapped(block.y - part.y, j->canvas->height),
                       block.width, block.height };
    pv_candidate best = { -1, 0 };
    pv_scale own = j->scale;
    own.reach = block.width > block.height ? block.width : block.height;
    int32_t laid = ask_block(w, block), first;
    if (laid == block.width * block.height)
        return PAVE_OK;
    pv_repeats_count(&w->repeats, part);
    if (!laid)
        best.place = pv_random_place(j->canvas->bank, block.width, block.height, random.word[3]);
    else
        pv_candidates_find(w, &own, window, &random, 1, &best);
    if (best.place < 0)
        return pv_fail(j->context, PAVE_ERR_ARGUMENT, "no usable block of %d x %d px in the exemplar",
                       (int)block.width, (int)block.height);
    pv_copy_find(w, &own, window, best.place, &area, &first);
    pv_cut_lay(w->cut.taken, j->canvas, area, first);
    return PAVE_OK;
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

static pave_result start(job *j, double to)
{
    pv_canvas *c = j->canvas;
    int32_t step = j->scale.block - j->scale.overlap;
    int32_t across = (c->width + step - 1) / step, down = (c->height + step - 1) / step;
    across = across > 1 + c->wrap_x ? across : 1 + c->wrap_x;
    down = down > 1 + c->wrap_y ? down : 1 + c->wrap_y;
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < across * down && !result; i++) {
        pv_random random = pv_draw(j->params->seed, PV_DRAW_BLOCKS, (uint32_t)(i / across), 1, 1);
        pv_area block;
        int32_t shift = (int32_t)pv_below(random.word[0], (uint32_t)c->width);
        block_span(c->width, c->wrap_x, across, j->scale.overlap, shift, i % across, &block.x, &block.width);
        block_span(c->height, c->wrap_y, down, j->scale.overlap, 0, i / across, &block.y, &block.height);
        if (i % (across * down / SOME + 1) == 0)
            pv_coverage_count(&j->coverage, c);
        result = lay_block(j, block, i);
        if (!result)
            result = pv_progress(j->context, to * (i + 1) / (across * down));
    }
    return result;
}

static int32_t parts_of(int32_t size, int32_t reach)
{
    int32_t parts = size / (reach + reach / 2);
    return parts > 1 ? parts : 1;
}

static pave_result prepare(job *j)
{
    const pv_canvas *c = j->canvas;
    j->across = parts_of(c->width, j->scale.reach);
    j->down = parts_of(c->height, j->scale.reach);
    int32_t most_width = c->width / j->across, most_height = c->height / j->down;
    most_width = most_width > j->scale.block ? most_width : j->scale.block;
    most_height = most_height > j->scale.block ? most_height : j->scale.block;
    pave_result result = pv_coverage_create(j->context, c->bank, j->params->coverage, &j->coverage);
    j->workers = pv_workers(j->context) < j->across * j->down ? pv_workers(j->context) : j->across * j->down;
    j->workers = pv_workers(j->context);
    if (!result)
        j->fails = pv_allocate_zeroed(j->context, (size_t)c->width * (size_t)c->height, 1, &result);
    if (!result)
        j->worker = pv_allocate_zeroed(j->context, (size_t)j->workers, sizeof *j->worker, &result);
    for (int32_t i = 0; i < j->workers && !result; i++)
        result = pv_worker_create(j->context, j->params, &j->scale, j->canvas, &j->coverage, most_width, most_height,
                                  &j->worker[i]);
    return result;
}

pave_result pv_best_lay(pave_context *context, const pave_tiling_params *params, const pv_scale *scale,
                        pv_canvas *canvas)
{
    job j = { .context = context, .params = params, .canvas = canvas, .scale = *scale };
    pave_result result = prepare(&j);
    if (!result)
        result = start(&j, 0.1);
    if (!result)
        result = refine(&j, 0.1, 1);
    for (int32_t i = 0; i < j.workers && j.worker; i++)
        pv_worker_free(&j.worker[i]);
    pv_release(j.worker);
    pv_release(j.fails);
    pv_coverage_free(&j.coverage);
    return result;
}
