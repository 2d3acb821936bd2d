/* Seams: the worst one of a part is looked up, and cut again with a copy that fits what is around it.
 * Source: Kwatra et al. 2003, "Graphcut textures", section 3.2. */
#include "tiling/best.h"

enum { CLEAR = 2, MOST_FAILS = 6, CANDIDATES = 3 };

/* What the seams to the right and below cost at the pixels of an area within the part. */
static void find_heat(pv_worker *w, pv_area area)
{
    const pv_canvas *canvas = w->canvas;
    const pv_bank *bank = canvas->bank;
    pv_area part = w->repeats.area;
    for (int32_t y = area.y; y < area.y + area.height; y++) {
        const int32_t *row = canvas->source + pv_pixel(canvas, 0, part.y + y);
        const int32_t *below = canvas->source + pv_pixel(canvas, 0, part.y + y + 1);
        for (int32_t x = area.x, u = pv_wrapped(part.x + x, canvas->width); x < area.x + area.width; x++) {
            int32_t next = u + 1 < canvas->width ? u + 1 : 0;
            int32_t heat = x + 1 < part.width ? pv_seam(bank, row[u], row[next], 1) : 0;
            heat += y + 1 < part.height ? pv_seam(bank, row[u], below[u], bank->stride) : 0;
            w->heat[y * part.width + x] = heat;
            u = next;
        }
    }
}

/* Sums of the heat above and left, less where it was tried in vain. */
static void sum_heat(pv_worker *w)
{
    pv_area part = w->repeats.area;
    for (int32_t y = 0, at = 0; y < part.height; y++) {
        const uint8_t *fails = w->attempt->fails + pv_pixel(w->canvas, 0, part.y + y);
        int64_t sum = 0;
        for (int32_t x = 0, u = part.x; x < part.width; x++, at++) {
            sum += w->heat[at] >> fails[u];
            w->sums[at] = sum + (y ? w->sums[at - part.width] : 0);
            u = u + 1 < w->canvas->width ? u + 1 : 0;
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

static void note_failure(const pv_worker *w, pv_area window)
{
    pv_area part = w->repeats.area;
    for (int32_t y = 0; y < window.height; y++)
        for (int32_t x = 0; x < window.width; x++) {
            uint8_t *fails = &w->attempt->fails[pv_pixel(w->canvas, part.x + window.x + x, part.y + window.y + y)];
            *fails = (uint8_t)(*fails < MOST_FAILS ? *fails + 1 : MOST_FAILS);
        }
}

/* Lays the copy that was cut, and forgets what was tried in vain there. */
static void lay_copy(pv_worker *w)
{
    const pv_copy *copy = &w->copy;
    pv_area area = copy->area, local = copy->local;
    pv_cut_lay(copy->taken, w->canvas, area, copy->first);
    for (int32_t y = 0; y < area.height; y++)
        for (int32_t x = 0; x < area.width; x++)
            if (copy->taken[y * area.width + x])
                w->attempt->fails[pv_pixel(w->canvas, area.x + x, area.y + y)] = 0;
    int32_t left = local.x > 0, top = local.y > 0; /* a pixel tells of the seams to the right and below */
    find_heat(w, (pv_area){ local.x - left, local.y - top, local.width + left, local.height + top });
}

void pv_seams_find(pv_worker *w, pv_area part)
{
    w->repeats.area = part;
    find_heat(w, (pv_area){ 0, 0, part.width, part.height });
}

int pv_seams_mend(pv_worker *w, pv_random *random)
{
    pv_candidate list[CANDIDATES];
    pv_area window;
    sum_heat(w);
    if (worst_window(w, w->scale->window, &window) <= 0)
        return 0;
    ask(w, window);
    int32_t count = pv_candidates_find(w, w->scale, window, random, CANDIDATES, list);
    w->copy.gain = 0;
    for (int32_t i = 0; i < count; i++)
        pv_copy_try(w, w->scale, window, list[i].place);
    if (w->copy.gain > 0)
        lay_copy(w);
    else
        note_failure(w, window);
    return 1;
}

int64_t pv_seams_cost(pv_worker *w, pv_area part)
{
    int64_t cost = 0;
    pv_seams_find(w, part);
    for (int32_t i = 0; i < part.width * part.height; i++)
        cost += w->heat[i];
    return cost;
}
