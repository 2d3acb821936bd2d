/* Prices: using the exemplar evenly, and not showing the same thing twice nearby or at regular steps. */
#include "tiling/prices.h"

#include "tiling/cut.h"

#include <stdlib.h>
#include <string.h>

enum { LEVEL_WEIGHT = 4, LACK_WEIGHT = 2, SAMPLE = 2 /* one pixel in so many across and down tells the steps */ };

static int32_t level(const pv_bank *bank, int32_t place)
{
    return bank->white == PV_LEVELS - 1 ? bank->bright[place] : bank->bright[place] >> 4;
}

pave_result pv_coverage_create(pave_context *context, const pv_bank *bank, double weight, pv_coverage *out)
{
    pave_result result;
    size_t cells = (size_t)bank->cells;
    memset(out, 0, sizeof *out);
    out->weight = weight * bank->contrast;
    out->price = pv_allocate_zeroed(context, cells, sizeof *out->price, &result);
    out->count = out->price ? pv_allocate_zeroed(context, cells, sizeof *out->count, &result) : NULL;
    out->room = out->count ? pv_allocate_zeroed(context, cells, sizeof *out->room, &result) : NULL;
    if (!out->room) {
        pv_coverage_free(out);
        return result;
    }
    out->bank = bank;
    for (int32_t i = 0; i < bank->pixels; i++)
        if (bank->usable[i] && bank->home[i] == i) {
            out->room[bank->cell[i]]++;
            out->level_share[level(bank, i)] += 1.0 / (double)bank->usable_count;
        }
    for (int32_t i = 1; i < PV_LEVELS; i++)
        out->level_share[i] += out->level_share[i - 1];
    return PAVE_OK;
}

void pv_coverage_free(pv_coverage *coverage)
{
    pv_release(coverage->price);
    pv_release(coverage->count);
    pv_release(coverage->room);
    memset(coverage, 0, sizeof *coverage);
}

/* Where the result has more that is as dark as a level, or darker, than the exemplar, a darker pixel makes it worse:
 * the slope of the squared difference of their distributions. */
static void price_levels(pv_coverage *coverage, const int32_t *count, int64_t laid)
{
    int64_t below[PV_LEVELS], sum = 0;
    double slope = 0;
    for (int32_t i = 0; i < PV_LEVELS; i++)
        below[i] = sum += count[i];
    for (int32_t i = PV_LEVELS - 1; i >= 0; i--) {
        slope += laid ? (double)below[i] / (double)laid - coverage->level_share[i] : 0;
        coverage->level_price[i] = (int32_t)(LEVEL_WEIGHT * coverage->weight * PV_COST_UNIT * slope);
    }
}

/* A cell that is used as often as others costs nothing, one used twice as often more, one hardly used far less. */
void pv_coverage_count(pv_coverage *coverage, const pv_canvas *canvas)
{
    const pv_bank *bank = canvas->bank;
    int32_t levels[PV_LEVELS] = { 0 };
    int64_t laid = 0;
    memset(coverage->count, 0, (size_t)bank->cells * sizeof *coverage->count);
    for (int64_t i = 0; i < (int64_t)canvas->width * canvas->height; i++)
        if (canvas->source[i] >= 0) {
            coverage->count[bank->cell[canvas->source[i]]]++;
            levels[level(bank, canvas->source[i])]++;
            laid++;
        }
    price_levels(coverage, levels, laid);
    double even = (double)laid / (double)bank->usable_count;
    for (int32_t i = 0; i < bank->cells; i++) {
        double use = even > 0 && coverage->room[i] ? coverage->count[i] / (even * coverage->room[i]) : 1;
        double lack = use < 1 ? 1 - use : 0, price = (use < 3 ? use : 3) - 1 - LACK_WEIGHT * lack * lack;
        coverage->price[i] = (int32_t)(coverage->weight * PV_COST_UNIT * price);
    }
}

pave_result pv_repeats_create(pave_context *context, const pv_canvas *canvas, int32_t most_width, int32_t most_height,
                              int32_t radius, double weight, pv_repeats *out)
{
    pave_result result = PAVE_OK;
    memset(out, 0, sizeof *out);
    out->canvas = canvas;
    out->radius = radius > 1 ? radius : 1;
    out->weight = weight * canvas->bank->contrast;
    out->across = 2 * (most_width / PV_STEP + 1) + 1;
    out->down = most_height / PV_STEP + 2;
    size_t steps = (size_t)out->across * (size_t)out->down;
    out->head = pv_allocate(context, (size_t)canvas->bank->pixels, sizeof *out->head, &result);
    if (!result)
        out->next = pv_allocate(context, (size_t)most_width * (size_t)most_height, sizeof *out->next, &result);
    if (!result)
        out->steps = pv_allocate(context, steps, sizeof *out->steps, &result);
    if (!result)
        out->step_price = pv_allocate(context, steps, sizeof *out->step_price, &result);
    if (result)
        pv_repeats_free(out);
    return result;
}

void pv_repeats_free(pv_repeats *repeats)
{
    pv_release(repeats->head);
    pv_release(repeats->next);
    pv_release(repeats->steps);
    pv_release(repeats->step_price);
    memset(repeats, 0, sizeof *repeats);
}

/* The shorter way around, where that is open. */
static int32_t shorter(int32_t d, int32_t size, int wraps)
{
    return !wraps ? d : d > size / 2 ? d - size : d < -size / 2 ? d + size : d;
}

static int32_t step_of(const pv_repeats *r, int32_t dx, int32_t dy)
{
    if (dy < 0 || (dy == 0 && dx < 0))
        dx = -dx, dy = -dy;
    int32_t x = (dx + r->across / 2 * PV_STEP + PV_STEP / 2) / PV_STEP, y = (dy + PV_STEP / 2) / PV_STEP;
    return y * r->across + x;
}

typedef struct gap { int32_t x, y; } gap;

static gap gap_between(const pv_repeats *r, int32_t x, int32_t y, int32_t other)
{
    const pv_canvas *canvas = r->canvas;
    return (gap){ shorter(other % r->area.width - x, canvas->width, canvas->wrap_x),
                  shorter(other / r->area.width - y, canvas->height, canvas->wrap_y) };
}

static void price_steps(pv_repeats *r)
{
    double pixels = (double)r->area.width * r->area.height;
    for (int32_t i = 0; i < r->across * r->down; i++) {
        double share = SAMPLE * SAMPLE * r->steps[i] / pixels;
        r->step_price[i] = (int32_t)(r->weight * PV_COST_UNIT * 12 * (share < 0.5 ? share : 0.5));
    }
}

static void count_row(pv_repeats *r, int32_t y)
{
    const pv_canvas *canvas = r->canvas;
    const int32_t *row = canvas->source + pv_pixel(canvas, 0, r->area.y + y);
    int32_t at = y * r->area.width;
    for (int32_t x = 0, u = r->area.x; x < r->area.width; x++, u++, at++) {
        u = u < canvas->width ? u : u - canvas->width;
        if (row[u] < 0)
            continue;
        int32_t *head = &r->head[canvas->bank->home[row[u]]];
        for (int32_t other = *head; other >= 0 && x % SAMPLE == 0 && y % SAMPLE == 0; other = r->next[other]) {
            gap g = gap_between(r, x, y, other);
            r->steps[step_of(r, g.x, g.y)]++;
        }
        r->next[at] = *head;
        *head = at;
    }
}

void pv_repeats_count(pv_repeats *r, pv_area area)
{
    const pv_canvas *canvas = r->canvas;
    r->area = area;
    memset(r->head, -1, (size_t)canvas->bank->pixels * sizeof *r->head);
    memset(r->steps, 0, (size_t)r->across * (size_t)r->down * sizeof *r->steps);
    for (int32_t y = 0; y < area.height; y++)
        count_row(r, y);
    price_steps(r);
}

static int32_t repeat_price(const pv_repeats *r, int32_t x, int32_t y, int32_t place)
{
    int32_t price = 0, at = y * r->area.width + x, most = r->radius * r->radius;
    int32_t near = (int32_t)(r->weight * 3 * PV_COST_UNIT);
    for (int32_t other = r->head[r->canvas->bank->home[place]]; other >= 0; other = r->next[other]) {
        if (other == at)
            continue;
        gap g = gap_between(r, x, y, other);
        int32_t square = g.x * g.x + g.y * g.y;
        if (square < most)
            price += (int32_t)((int64_t)near * (most - square) / most);
        price += r->step_price[step_of(r, g.x, g.y)];
    }
    return price;
}

static int32_t guide_price(const pv_prices *prices, int32_t x, int32_t y, int32_t place)
{
    const pv_canvas *canvas = prices->repeats->canvas;
    pv_area area = prices->repeats->area;
    int32_t wanted = canvas->guide[pv_pixel(canvas, area.x + x, area.y + y)], is = canvas->bank->bright[place];
    return (int32_t)(prices->guide * PV_COST_UNIT * 255 * abs(wanted - is) / canvas->bank->white);
}

int32_t pv_price_of(const pv_prices *prices, int32_t x, int32_t y, int32_t place)
{
    const pv_coverage *coverage = prices->coverage;
    int32_t price = coverage->price[coverage->bank->cell[place]] + coverage->level_price[level(coverage->bank, place)];
    price += repeat_price(prices->repeats, x, y, place);
    return prices->repeats->canvas->guide ? price + guide_price(prices, x, y, place) : price;
}
