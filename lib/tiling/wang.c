/* Wang tiles: a complete set with n colours of edges, n^2 x n^2 tiles in one picture, every one beside those it fits.
 * Along x the colours of vertical edges run so that each pair of them follows each other once, and so do those of
 * horizontal edges along y; hence every tile is there once, and the whole repeats. Around edges of one colour the same
 * pixels lie, and around all corners; they are laid first, and the rest fitted to them.
 * Source: Cohen et al. 2003, "Wang tiles for image and texture generation", section 2; Wei 2004, "Tile-based texture
 * mapping on graphics hardware", section 4, for the order. */
#include "tiling/best.h"
#include "tiling/quilt.h"
#include "tiling/wang.h"

#include <string.h>

typedef struct wang {
    pave_context *context;
    const pave_tiling_params *params;
    const pv_scale *scale;
    pv_canvas *canvas;
    pave_tiling *tiling;
    int32_t colours, side[2]; /* of a tile */
    int32_t half;             /* how far from an edge the same pixels lie */
    int32_t order[16];        /* of colours along either axis */
    int32_t corner;           /* the bank's place of a corner's first pixel */
    int32_t *strip;           /* pixels around one edge */
} wang;

/* Each colour is followed by each once: for n = 3, 0 0 1 0 2 1 1 2 2, around. */
static void make_order(wang *w)
{
    static const int32_t two[4] = { 0, 0, 1, 1 }, three[9] = { 0, 0, 1, 0, 2, 1, 1, 2, 2 };
    int32_t n = w->colours * w->colours;
    for (int32_t i = 0; i <= n; i++)
        w->order[i] = w->colours == 2 ? two[i % n] : three[i % n];
}

/* The pixels around an edge of one colour, down (or across) from one corner to the next, which is the same. */
static pave_result make_strip(wang *w, int across, int32_t colour)
{
    pave_result result = PAVE_OK;
    pave_tiling_params params = *w->params;
    int32_t wide = 6 * w->half, stride = w->canvas->bank->stride;
    pv_canvas c = { .bank = w->canvas->bank, .width = across ? w->side[0] : wide,
                    .height = across ? wide : w->side[1] };
    size_t n = (size_t)c.width * (size_t)c.height;
    c.wrap_x = across;
    c.wrap_y = !across;
    params.seed = w->params->seed + 1 + (uint64_t)(2 * colour + across);
    params.rounds = params.rounds ? params.rounds / 4 + 1 : 20;
    c.source = pv_allocate(w->context, n, sizeof *c.source, &result);
    if (!result)
        c.fixed = pv_allocate_zeroed(w->context, n, 1, &result);
    for (int32_t k = 0; !result && k < 4 * w->half * w->half; k++) {
        int32_t u = k % (2 * w->half), v = k / (2 * w->half);
        int32_t x = u + (across ? -w->half : 2 * w->half), y = v + (across ? 2 * w->half : -w->half);
        if (!k)
            memset(c.source, -1, n * sizeof *c.source);
        c.source[pv_pixel(&c, x, y)] = w->corner + v * stride + u;
        c.fixed[pv_pixel(&c, x, y)] = 1;
    }
    if (!result)
        result = pv_best_lay(w->context, &params, w->scale, &c);
    pv_release(w->strip);
    w->strip = c.source;
    pv_release(c.fixed);
    return result;
}

/* Lays the strip around every edge of its colour. */
static void lay_strip(const wang *w, int across, int32_t colour)
{
    pv_canvas *c = w->canvas;
    int32_t n = w->colours * w->colours, wide = 6 * w->half, along = w->side[!across], middle = 3 * w->half;
    for (int32_t i = 0; i < n; i++)
        for (int32_t j = 0; j < n * along && w->order[i] == colour; j++)
            for (int32_t d = -w->half; d < w->half; d++) {
                int32_t edge = i * w->side[across] + d;
                int32_t pixel = across ? pv_pixel(c, j, edge) : pv_pixel(c, edge, j);
                c->source[pixel] = across ? w->strip[(middle + d) * w->side[0] + j % along]
                                          : w->strip[j % along * wide + middle + d];
                c->fixed[pixel] = 1;
            }
}

static pave_result index_tiles(wang *w)
{
    pave_result result = PAVE_OK;
    pave_tiling *t = w->tiling;
    int32_t n = w->colours * w->colours;
    t->tiles = pv_allocate(w->context, (size_t)n * (size_t)n, sizeof *t->tiles, &result);
    for (int32_t i = 0; i < n * n && !result; i++) {
        int32_t x = i % n, y = i / n;
        t->tiles[i] = (pave_wang_tile){ x * w->side[0], y * w->side[1], w->order[y], w->order[x + 1], w->order[y + 1],
                                        w->order[x] };
    }
    t->tile_count = result ? 0 : n * n;
    t->tile_width = w->side[0];
    t->tile_height = w->side[1];
    return result;
}

static pave_result lay_edges(wang *w)
{
    pave_result result = PAVE_OK;
    for (int32_t k = 0; k < 2 * w->colours && !result; k++) {
        pv_call call = pv_call_begin(w->context, "edges", 0.2 * k / (2 * w->colours), 0.2 * (k + 1) / (2 * w->colours));
        result = make_strip(w, k % 2, k / 2);
        if (!result)
            lay_strip(w, k % 2, k / 2);
        pv_call_end(w->context, call);
    }
    return result;
}

pave_result pv_wang_lay(pave_context *context, const pv_scale *scale, pv_canvas *canvas, pave_tiling *t)
{
    int32_t n = t->params.wang * t->params.wang;
    wang w = { .context = context, .params = &t->params, .scale = scale, .canvas = canvas, .tiling = t,
               .colours = t->params.wang, .side = { canvas->width / n, canvas->height / n } };
    int32_t least = w.side[0] < w.side[1] ? w.side[0] : w.side[1];
    w.half = scale->overlap / 2 < 4 ? 4 : scale->overlap / 2;
    w.half = w.half < least / 6 ? w.half : least / 6;
    if (w.half < 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "tiles of %d x %d px are too small for a Wang set", (int)w.side[0],
                       (int)w.side[1]);
    make_order(&w);
    w.corner = pv_random_place(canvas->bank, 2 * w.half, 2 * w.half,
                               pv_draw(t->params.seed, PV_DRAW_EDGES, 0, 0, 0).word[0]);
    if (w.corner < 0)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the exemplar has no usable block of %d x %d px for the corners",
                       (int)(2 * w.half), (int)(2 * w.half));
    pave_result result = lay_edges(&w);
    if (!result) {
        pv_call call = pv_call_begin(context, "tiles", 0.2, 1);
        result = pv_best_lay(context, &t->params, scale, canvas);
        pv_call_end(context, call);
    }
    pv_release(w.strip);
    return result ? result : index_tiles(&w);
}
