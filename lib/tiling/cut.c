/* Cuts: the pixels of a copy that are taken so that what shows of its border costs least.
 * Source: Kwatra et al. 2003, "Graphcut textures", section 3; Kolmogorov and Zabih 2004 for the graph. */
#include "tiling/cut.h"

#include <string.h>

enum { SAMPLE = 4 /* one pixel's price stands for so many across and down: fewer sources and sinks, shorter paths */ };

pave_result pv_cut_create(pave_context *context, int32_t most_width, int32_t most_height, pv_cut *out)
{
    pave_result result;
    size_t pixels = (size_t)most_width * (size_t)most_height;
    size_t nodes = ((size_t)most_width + 2) * ((size_t)most_height + 2);
    memset(out, 0, sizeof *out);
    result = pv_flow_create(context, most_width, most_height, &out->flow);
    if (!result)
        result = pv_flow_create(context, (most_width + 1) / 2, (most_height + 1) / 2, &out->coarse);
    if (!result)
        out->state = pv_allocate(context, nodes, 1, &result);
    if (!result)
        out->laid = pv_allocate(context, nodes, sizeof *out->laid, &result);
    if (!result)
        out->unlike = pv_allocate(context, nodes, sizeof *out->unlike, &result);
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
    pv_release(cut->laid);
    pv_release(cut->unlike);
    pv_release(cut->taken);
    memset(cut, 0, sizeof *cut);
}

/* A copy that is being cut. What is laid, and what it differs by from the copy, lie as the nodes of the flow do. */
typedef struct work {
    pv_cut *cut;
    const pv_canvas *canvas;
    pv_area area;
    int32_t first;
} work;

/* What is laid in the area and one pixel around it; PV_NOTHING beyond the canvas. */
static void read_laid(const work *w)
{
    const pv_canvas *canvas = w->canvas;
    pv_area area = w->area;
    for (int32_t y = -1, node = 0; y <= area.height; y++) {
        const int32_t *row = canvas->source + pv_pixel(canvas, 0, area.y + y);
        int inside = canvas->wrap_y || (area.y + y >= 0 && area.y + y < canvas->height);
        for (int32_t x = -1; x <= area.width; x++, node++)
            w->cut->laid[node] = inside && pv_inside(canvas, area.x + x, area.y)
                                     ? row[pv_wrapped(area.x + x, canvas->width)] : PV_NOTHING;
    }
}

static int must_stay(const work *w, int32_t x, int32_t y, int32_t fresh)
{
    const pv_canvas *canvas = w->canvas;
    return !canvas->bank->usable[fresh] ||
           (canvas->fixed && canvas->fixed[pv_pixel(canvas, w->area.x + x, w->area.y + y)]);
}

static void begin_pixel(const work *w, int32_t x, int32_t y, pv_price *price, const void *data)
{
    pv_flow *flow = &w->cut->flow;
    int32_t node = pv_flow_node(flow, x, y), new = w->first + y * w->canvas->bank->stride + x;
    int32_t old = w->cut->laid[node], *terminal = &flow->node[node].terminal;
    w->cut->unlike[node] = old < 0 || old == new ? 0 : pv_differ(w->canvas->bank, old, new);
    if (must_stay(w, x, y, new))
        *terminal = -PV_MUST;
    else if (old < 0)
        *terminal = PV_MUST;
    else if (price && old != new && x % SAMPLE == 1 && y % SAMPLE == 1)
        *terminal = SAMPLE * SAMPLE * (price(data, x, y, old) - price(data, x, y, new));
}

/* Two neighbours of which one is not laid, or between which there is a seam already: what it costs that only one of
 * them is taken, less what the seam costs now, which taking either saves half of. */
static void join_seam(const work *w, int32_t node, int32_t new, int way, int32_t step)
{
    const pv_bank *bank = w->canvas->bank;
    int32_t other = node + w->cut->flow.step[way], p = w->cut->laid[node], q = w->cut->laid[other];
    pv_node *a = &w->cut->flow.node[node], *b = &w->cut->flow.node[other];
    int32_t only_p = q < 0 || q == new + step ? 0 : pv_seam(bank, new, q, step);
    int32_t only_q = p < 0 || p == new ? 0 : pv_seam(bank, p, new + step, step);
    if (p < 0 || q < 0) {
        *(p < 0 ? &b->terminal : &a->terminal) += p < 0 ? only_p : only_q;
        return;
    }
    int32_t none = pv_seam(bank, p, q, step), half = none / 2, forth = only_p - (none - half);
    int32_t back = only_q - half, shift = forth < 0 || forth + back < 0 ? -forth : back < 0 ? back : 0;
    a->terminal += half + shift;
    b->terminal += none - half - shift;
    a->capacity[way] = forth + shift;
    b->capacity[way ^ 2] = back - shift > 0 ? back - shift : 0;
}

/* Two neighbours, both in the area: the one that is to be the copy's pixel `new`, and the next. */
static void join(const work *w, int32_t node, int32_t new, int way)
{
    pv_flow *flow = &w->cut->flow;
    int32_t other = node + flow->step[way], step = way == PV_RIGHT ? 1 : w->canvas->bank->stride;
    int32_t p = w->cut->laid[node], q = w->cut->laid[other];
    if (p == new && q == new + step)
        return;
    if (p < 0 || p + step != q) {
        join_seam(w, node, new, way, step);
        return;
    }
    int32_t cost = w->cut->unlike[node] + w->cut->unlike[other] + PV_COST_UNIT;
    flow->node[node].capacity[way] = cost;
    flow->node[other].capacity[way ^ 2] = cost;
}

/* A neighbour outside of the area stays what it is. */
static void join_outside(const work *w, int32_t x, int32_t y, int way)
{
    static const int32_t dx[PV_WAYS] = { 1, 0, -1, 0 }, dy[PV_WAYS] = { 0, 1, 0, -1 };
    const pv_bank *bank = w->canvas->bank;
    pv_flow *flow = &w->cut->flow;
    int32_t node = pv_flow_node(flow, x, y), new = w->first + y * bank->stride + x;
    int32_t p = w->cut->laid[node], q = w->cut->laid[node + flow->step[way]];
    int32_t step = dx[way] + dy[way] * bank->stride;
    if (p >= 0 && q >= 0)
        flow->node[node].terminal += pv_seam(bank, p, q, step) - pv_seam(bank, new, q, step);
}

static void join_all(const work *w)
{
    int32_t width = w->area.width, height = w->area.height;
    for (int32_t y = 0; y < height; y++) {
        int32_t node = pv_flow_node(&w->cut->flow, 0, y), new = w->first + y * w->canvas->bank->stride;
        for (int32_t x = 0; x < width; x++, node++, new++) {
            if (x + 1 < width)
                join(w, node, new, PV_RIGHT);
            if (y + 1 < height)
                join(w, node, new, PV_DOWN);
        }
        join_outside(w, width - 1, y, PV_RIGHT);
        join_outside(w, 0, y, PV_LEFT);
    }
    for (int32_t x = 0; x < width; x++) {
        join_outside(w, x, height - 1, PV_DOWN);
        join_outside(w, x, 0, PV_UP);
    }
}

static void build(const work *w, pv_price *price, const void *data)
{
    pv_flow_begin(&w->cut->flow, w->area.width, w->area.height);
    read_laid(w);
    for (int32_t y = 0; y < w->area.height; y++)
        for (int32_t x = 0; x < w->area.width; x++)
            begin_pixel(w, x, y, price, data);
    join_all(w);
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
