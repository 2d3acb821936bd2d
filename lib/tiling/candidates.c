/* Candidates: which places of the exemplar a copy might come from, and how a copy is cut. */
#include "tiling/best.h"

#include "util/random.h"

#include <string.h>

enum { SHORT_LIST = 24, APART = 4 };

pave_result pv_worker_create(pave_context *context, const pave_tiling_params *params, const pv_scale *scale,
                             pv_attempt *attempt, pv_worker *out)
{
    const pv_bank *bank = attempt->canvas.bank;
    int32_t most_width = scale->part_width > scale->block ? scale->part_width : scale->block;
    int32_t most_height = scale->part_height > scale->block ? scale->part_height : scale->block;
    size_t pixels = (size_t)most_width * (size_t)most_height, places = (size_t)scale->places * (size_t)scale->places;
    int32_t side = scale->block + 2 > scale->window ? scale->block + 2 : scale->window;
    *out = (pv_worker){ .params = params, .scale = scale, .compare = pv_compare_choose(params->search) };
    pave_result result = pv_repeats_create(context, &attempt->canvas, most_width, most_height, scale->radius,
                                           params->repeat, &out->repeats);
    if (!result)
        result = pv_cut_create(context, scale->reach, scale->reach, &out->cut);
    if (!result)
        result = pv_query_create(context, bank, side, side, &out->query);
    if (!result)
        out->copy.taken = pv_allocate(context, (size_t)scale->reach * (size_t)scale->reach, 1, &result);
    if (!result)
        out->costs = pv_allocate(context, places, sizeof *out->costs, &result);
    if (!result)
        out->heat = pv_allocate(context, pixels, sizeof *out->heat, &result);
    if (!result)
        out->sums = pv_allocate(context, pixels, sizeof *out->sums, &result);
    if (result)
        pv_worker_free(out);
    return result;
}

void pv_worker_turn(pv_worker *worker, pv_attempt *attempt)
{
    worker->attempt = attempt;
    worker->canvas = &attempt->canvas;
    worker->repeats.canvas = &attempt->canvas;
    worker->prices = (pv_prices){ &attempt->coverage, &worker->repeats, worker->params->guide_weight };
}

void pv_worker_free(pv_worker *worker)
{
    pv_repeats_free(&worker->repeats);
    pv_cut_free(&worker->cut);
    pv_release(worker->copy.taken);
    pv_query_free(&worker->query);
    pv_release(worker->costs);
    pv_release(worker->heat);
    pv_release(worker->sums);
    memset(worker, 0, sizeof *worker);
}

/* A part of a sheet that is small enough, at random. */
static pv_places some_places(const pv_scale *scale, const pv_sheet *sheet, int32_t width, int32_t height,
                             pv_random *random)
{
    pv_places p = pv_places_all(sheet, width, height);
    if (p.across > scale->places) {
        p.x = (int32_t)pv_below(random->word[1], (uint32_t)(p.across - scale->places + 1));
        p.across = scale->places;
    }
    if (p.down > scale->places) {
        p.y = (int32_t)pv_below(random->word[2], (uint32_t)(p.down - scale->places + 1));
        p.down = scale->places;
    }
    return p;
}

/* The least cost of all places; those near to it are then out of the running. */
static int64_t take_least(int64_t *costs, const pv_places *p, int32_t *x, int32_t *y)
{
    int32_t best = 0, n = p->across * p->down;
    for (int32_t i = 1; i < n; i++)
        best = costs[i] < costs[best] ? i : best;
    int64_t least = costs[best];
    *x = best % p->across;
    *y = best / p->across;
    for (int32_t v = *y - APART < 0 ? 0 : *y - APART; v <= *y + APART && v < p->down; v++)
        for (int32_t u = *x - APART < 0 ? 0 : *x - APART; u <= *x + APART && u < p->across; u++)
            costs[v * p->across + u] = PV_NO_PLACE;
    return least;
}

/* Around the window, what can be seen of the sheet there, and no more than reach. */
static pv_area copy_area(const pv_worker *worker, const pv_scale *scale, pv_area window, int32_t place, int32_t *first)
{
    const pv_bank *bank = worker->canvas->bank;
    const pv_sheet *sheet = pv_bank_sheet(bank, place);
    pv_area part = worker->repeats.area;
    int32_t sx = (place - sheet->first) % bank->stride, sy = (place - sheet->first) / bank->stride;
    int32_t left = window.x - sx, top = window.y - sy, right = left + sheet->width, bottom = top + sheet->height;
    int32_t spare_x = (scale->reach - window.width) / 2, spare_y = (scale->reach - window.height) / 2;
    left = left < window.x - spare_x ? window.x - spare_x : left;
    top = top < window.y - spare_y ? window.y - spare_y : top;
    right = right > window.x + window.width + spare_x ? window.x + window.width + spare_x : right;
    bottom = bottom > window.y + window.height + spare_y ? window.y + window.height + spare_y : bottom;
    left = left < 0 ? 0 : left;
    top = top < 0 ? 0 : top;
    right = right > part.width ? part.width : right;
    bottom = bottom > part.height ? part.height : bottom;
    *first = place + (left - window.x) + (top - window.y) * bank->stride;
    return (pv_area){ left, top, right - left, bottom - top };
}

/* Mean price of some pixels of a copy. */
static double mean_price(const pv_worker *worker, pv_area area, int32_t first)
{
    int32_t stride = worker->canvas->bank->stride, count = 0;
    int64_t sum = 0;
    for (int32_t y = PV_STEP / 2; y < area.height; y += 2 * PV_STEP)
        for (int32_t x = PV_STEP / 2; x < area.width; x += 2 * PV_STEP, count++)
            sum += pv_price_of(&worker->prices, area.x + x, area.y + y, first + y * stride + x);
    return count ? (double)sum / count : 0;
}

static double score_of(const pv_worker *worker, const pv_scale *scale, pv_area window, int32_t place, int64_t cost,
                       int32_t counted)
{
    int32_t first;
    pv_area area = copy_area(worker, scale, window, place, &first);
    double unlike = sqrt((double)cost / (counted ? counted : 1)) * 255.0 / worker->canvas->bank->white;
    return unlike + mean_price(worker, area, first) / PV_COST_UNIT;
}

static int32_t insert(pv_candidate *list, int32_t count, int32_t most, pv_candidate new)
{
    if (count == most && !(new.score < list[count - 1].score))
        return count;
    int32_t i = count < most ? count++ : count - 1;
    for (; i > 0 && new.score < list[i - 1].score; i--)
        list[i] = list[i - 1];
    list[i] = new;
    return count;
}

static int32_t counted_pixels(const pv_query *query)
{
    int32_t count = 0;
    for (int32_t i = 0; i < query->width * query->height; i++)
        count += query->counts[i];
    return count;
}

/* An image that is made to tile must not be laid where it lay: its own seam would come back with it. */
static int is_itself(const pv_worker *worker, pv_area window, int32_t place)
{
    const pv_canvas *canvas = worker->canvas;
    const pv_sheet *sheet = &canvas->bank->sheet[0];
    int32_t x = pv_wrapped(worker->repeats.area.x + window.x, canvas->width);
    int32_t y = pv_wrapped(worker->repeats.area.y + window.y, canvas->height);
    return worker->params->keep && place == sheet->first + y * canvas->bank->stride + x;
}

int32_t pv_candidates_find(pv_worker *worker, const pv_scale *scale, pv_area window, pv_random *random, int32_t most,
                           pv_candidate *out)
{
    const pv_bank *bank = worker->canvas->bank;
    pv_area part = worker->repeats.area;
    int32_t count = 0, counted = counted_pixels(&worker->query);
    for (int32_t i = 0; i < bank->sheets; i++) {
        pv_places p = some_places(scale, &bank->sheet[i], window.width, window.height, random);
        if (!p.across)
            continue;
        p = pv_places_even(p, pv_wrapped(part.x + window.x, worker->canvas->width),
                           pv_wrapped(part.y + window.y, worker->canvas->height));
        pv_search_all(&worker->query, p, worker->compare, worker->costs);
        for (int32_t k = 0; k < SHORT_LIST; k++) {
            int32_t x, y;
            int64_t cost = take_least(worker->costs, &p, &x, &y);
            if (cost == PV_NO_PLACE)
                break;
            int32_t place = pv_place_at(bank, &p, x, y);
            if (is_itself(worker, window, place))
                continue;
            count = insert(out, count, most,
                           (pv_candidate){ place, score_of(worker, scale, window, place, cost, counted) });
        }
    }
    return count;
}

typedef struct copy_price { const pv_prices *prices; int32_t x, y; } copy_price;

static int32_t price_in_copy(const void *data, int32_t x, int32_t y, int32_t place)
{
    const copy_price *copy = data;
    return pv_price_of(copy->prices, copy->x + x, copy->y + y, place);
}

void pv_copy_try(pv_worker *worker, const pv_scale *scale, pv_area window, int32_t place)
{
    const pv_canvas *canvas = worker->canvas;
    pv_copy *best = &worker->copy, copy = { .taken = worker->cut.taken };
    pv_area local = copy_area(worker, scale, window, place, &copy.first), part = worker->repeats.area;
    copy_price price = { &worker->prices, local.x, local.y };
    copy.local = local;
    copy.area = (pv_area){ pv_wrapped(part.x + local.x, canvas->width), pv_wrapped(part.y + local.y, canvas->height),
                           local.width, local.height };
    copy.gain = pv_cut_find(&worker->cut, canvas, copy.area, copy.first, price_in_copy, &price);
    if (copy.gain <= best->gain)
        return;
    worker->cut.taken = best->taken;
    *best = copy;
}
