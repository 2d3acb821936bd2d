/* Cuts: the pixels of a copy that are taken so that what shows of its border costs least.
 * Source: Kwatra et al. 2003, "Graphcut textures", section 3; Kolmogorov and Zabih 2004 for the graph. */
#include "tiling/cut.h"

#include <string.h>

enum { SAMPLE = 4 /* one pixel's price stands for so many across and down: fewer sources and sinks, shorter paths */ };

pave_result pv_cut_create(pave_context *context, int32_t most_width, int32_t most_height, pv_cut *out)
{
    pave_result result;
    size_t pixels = (size_t)most_width * (size_t)most_height;
    memset(out, 0, sizeof *out);
    result = pv_flow_create(context, most_width, most_height, &out->flow);
    if (!result)
        result = pv_flow_create(context, (most_width + 1) / 2, (most_height + 1) / 2, &out->coarse);
    if (!result)
        out->state = pv_allocate(context, pixels, 1, &result);
    if (!result)
        out->unlike = pv_allocate(context, pixels, sizeof *out->unlike, &result);
    if (!result)
        out->taken = pv_allocate(context, pixels, 1, &result);
    if (result)
        pv_cut_free(out);
    return result;
}

void pv_cut_free(pv_cut *cut)
{
    pv_flow_free(&cut->flow);
    pv_flow_free(&cut->coarse);
    pv_release(cut->state);
    pv_release(cut->unlike);
    pv_release(cut->taken);
    memset(cut, 0, sizeof *cut);
}

/* A copy that is being cut. */
typedef struct work {
    pv_cut *cut;
    const pv_canvas *canvas;
    pv_area area;
    int32_t first;
} work;

static int32_t fresh(const work *w, int32_t x, int32_t y)
{
    return w->first + y * w->canvas->bank->stride + x;
}

static int32_t laid(const work *w, int32_t x, int32_t y)
{
    return w->canvas->source[pv_pixel(w->canvas, w->area.x + x, w->area.y + y)];
}

static int must_stay(const work *w, int32_t x, int32_t y)
{
    const pv_canvas *canvas = w->canvas;
    return !canvas->bank->usable[fresh(w, x, y)] ||
           (canvas->fixed && canvas->fixed[pv_pixel(canvas, w->area.x + x, w->area.y + y)]);
}

static void begin_pixel(const work *w, int32_t x, int32_t y, pv_price *price, const void *data)
{
    pv_flow *flow = &w->cut->flow;
    int32_t old = laid(w, x, y), new = fresh(w, x, y), *terminal = &flow->node[pv_flow_node(flow, x, y)].terminal;
    w->cut->unlike[y * w->area.width + x] = old < 0 || old == new ? 0 : pv_differ(w->canvas->bank, old, new);
    if (must_stay(w, x, y))
        *terminal = -PV_MUST;
    else if (old < 0)
        *terminal = PV_MUST;
    else if (price && old != new && x % SAMPLE == 1 && y % SAMPLE == 1)
        *terminal = SAMPLE * SAMPLE * (price(data, x, y, old) - price(data, x, y, new));
}

/* Two neighbours, both in the area: p, and q one step further. */
static void join(const work *w, int32_t x, int32_t y, int way)
{
    const pv_bank *bank = w->canvas->bank;
    pv_flow *flow = &w->cut->flow;
    int32_t u = x + (way == PV_RIGHT), v = y + (way == PV_DOWN), step = way == PV_RIGHT ? 1 : bank->stride;
    int32_t p = laid(w, x, y), q = laid(w, u, v), np = fresh(w, x, y), nq = np + step;
    int32_t *tp = &flow->node[pv_flow_node(flow, x, y)].terminal, *tq = &flow->node[pv_flow_node(flow, u, v)].terminal;
    if (p < 0 && q < 0)
        return;
    int32_t unlike_p = w->cut->unlike[y * w->area.width + x], unlike_q = w->cut->unlike[v * w->area.width + u];
    int adjoin = p + step == q;
    int32_t only_q = 0, only_p = 0;
    if (p >= 0 && p != np)
        only_q = unlike_p + PV_COST_UNIT + (adjoin ? unlike_q : pv_differ(bank, p + step, nq));
    if (q >= 0 && q != nq)
        only_p = unlike_q + PV_COST_UNIT + (adjoin ? unlike_p : pv_differ(bank, np, q - step));
    if (p < 0) {
        *tq += only_p;
        return;
    }
    if (q < 0) {
        *tp += only_q;
        return;
    }
    int32_t none = pv_seam(bank, p, q, step), arc = only_p + only_q - none;
    *tp -= only_p - none;
    *tq += only_p;
    flow->node[pv_flow_node(flow, u, v)].capacity[way ^ 2] = arc > 0 ? arc : 0;
}

/* A neighbour outside of the area stays what it is. */
static void join_outside(const work *w, int32_t x, int32_t y, int way)
{
    static const int32_t dx[PV_WAYS] = { 1, 0, -1, 0 }, dy[PV_WAYS] = { 0, 1, 0, -1 };
    const pv_bank *bank = w->canvas->bank;
    int32_t u = w->area.x + x + dx[way], v = w->area.y + y + dy[way];
    if (!pv_inside(w->canvas, u, v))
        return;
    int32_t p = laid(w, x, y), q = w->canvas->source[pv_pixel(w->canvas, u, v)], np = fresh(w, x, y);
    if (p < 0 || q < 0)
        return;
    int32_t step = dx[way] + dy[way] * bank->stride;
    w->cut->flow.node[pv_flow_node(&w->cut->flow, x, y)].terminal +=
        pv_seam(bank, p, q, step) - pv_seam(bank, np, q, step);
}

static void build(const work *w, pv_price *price, const void *data)
{
    int32_t width = w->area.width, height = w->area.height;
    pv_flow_begin(&w->cut->flow, width, height);
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++)
            begin_pixel(w, x, y, price, data);
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++) {
            if (x + 1 < width)
                join(w, x, y, PV_RIGHT);
            else
                join_outside(w, x, y, PV_RIGHT);
            if (y + 1 < height)
                join(w, x, y, PV_DOWN);
            else
                join_outside(w, x, y, PV_DOWN);
            if (!x)
                join_outside(w, x, y, PV_LEFT);
            if (!y)
                join_outside(w, x, y, PV_UP);
        }
}

/* What the source could not send away is what all nodes on its side are better by. */
int64_t pv_cut_find(pv_cut *cut, const pv_canvas *canvas, pv_area area, int32_t first, pv_price *price,
                    const void *data)
{
    work w = { cut, canvas, area, first };
    int64_t gain;
    build(&w, price, data);
    int banded = pv_band_find(cut, &gain);
    if (!banded)
        pv_flow_solve(&cut->flow);
    for (int32_t y = 0; y < area.height; y++)
        for (int32_t x = 0; x < area.width; x++) {
            int32_t node = pv_flow_node(&cut->flow, x, y), left = cut->flow.node[node].terminal;
            cut->taken[y * area.width + x] =
                (uint8_t)(banded ? pv_band_taken(cut, x, y) : pv_flow_chosen(&cut->flow, node));
            gain += left > 0 ? left : 0;
        }
    return gain;
}

void pv_cut_lay(const uint8_t *taken, pv_canvas *canvas, pv_area area, int32_t first)
{
    for (int32_t y = 0; y < area.height; y++)
        for (int32_t x = 0; x < area.width; x++)
            if (taken[y * area.width + x])
                canvas->source[pv_pixel(canvas, area.x + x, area.y + y)] = first + y * canvas->bank->stride + x;
}
