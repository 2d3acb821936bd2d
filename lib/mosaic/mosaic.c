/* A mosaic: read the photo, find edges and field, decide sizes, pack, cut the tiles, colour, judge (Hausner 2001). */
#include "mosaic/mosaic.h"

#include "image/image.h"

#include <math.h>
#include <string.h>

static const pave_mosaic_params default_params = PAVE_MOSAIC_PARAMS_INIT;

static const pv_param mosaic_rows[] = {
    PV_CHOICE(pave_mosaic_params, mode, "paper|best", "plain tiles as in the text, or quadrilaterals without holes"),
    PV_INTEGER(pave_mosaic_params, tiles, "", 1, 1 << 30, "number of tiles"),
    PV_REAL(pave_mosaic_params, tile_side, "px", 0, 16384, "side of a tile, instead of their number; 0: by the number"),
    PV_REAL(pave_mosaic_params, aspect, "", 1, 10, "long side over short side; the long one lies along the edges"),
    PV_SEED(pave_mosaic_params, seed, "another seed, another mosaic"),
    PV_CHOICE(pave_mosaic_params, direction, "auto|gradient|harmonic",
              "field: gradient of the distance (paper mode), or harmonic extension of the edges (best mode)"),
    PV_REAL(pave_mosaic_params, strength, "", 0, 1, "of edges found where none are given: 0 none, 1 the faintest"),
    PV_CHOICE(pave_mosaic_params, size_from, "even|image|regions|detail", "what decides how large tiles are where"),
    PV_REAL(pave_mosaic_params, size_figure, "", 0.1, 1, "side of tiles in the figure, the background's being 1"),
    PV_REAL(pave_mosaic_params, size_detail, "", 0.1, 1, "side of tiles in the detail"),
    PV_CHOICE(pave_mosaic_params, pyramid, "square|diamond", "metric: max(|u|, |v|), or the text's |u| + |v|"),
    PV_CHOICE(pave_mosaic_params, start, "jitter|random", "first sites: stratified, or by rejection sampling"),
    PV_INTEGER(pave_mosaic_params, iterations, "", 0, 10000, "of Lloyd's method"),
    PV_INTEGER(pave_mosaic_params, avoiding, "", 0, 10000, "more, with the edges masked"),
    PV_INTEGER(pave_mosaic_params, closing, "", 0, 10000, "more, free again"),
    PV_REAL(pave_mosaic_params, relaxation, "", 0.1, 1.9, "1: sites move to the centroids; more: beyond"),
    PV_REAL(pave_mosaic_params, edge_width, "sides", 0, 1, "half the thickness of masked edges"),
    PV_REAL(pave_mosaic_params, joint, "sides", 0, 0.9, "best mode: joint between tiles"),
    PV_REAL(pave_mosaic_params, delta, "sides", 0.05, 4, "paper mode: side of a tile"),
    PV_CHOICE(pave_mosaic_params, shape, "square|ellipse|cell", "paper mode: what is laid at a site"),
    PV_CHOICE(pave_mosaic_params, colour, "area|point", "of a tile: mean of the light under it, or its centre's pixel"),
    PV_FLAG(pave_mosaic_params, periodic, "opposite borders of the photo meet, and tiles go on across them"),
    PV_FLAG(pave_mosaic_params, chips, "best mode: tiles have four corners, and chips fill what they leave"),
};

const pv_table pv_mosaic_table = PV_TABLE("mosaic", default_params, mosaic_rows);

void pave_mosaic_params_init(pave_mosaic_params *params, size_t size)
{
    pv_params_init(&pv_mosaic_table, params, size);
}

static const pave_mosaic_sources no_sources = PAVE_MOSAIC_SOURCES_INIT;

void pave_mosaic_sources_init(pave_mosaic_sources *sources, size_t size)
{
    const pv_table table = { "sources", sizeof no_sources, &no_sources, NULL, 0 };
    pv_params_init(&table, sources, size);
}

typedef struct inputs {
    pave_mosaic_sources sources;
    pave_mosaic_params params;
} inputs;

static pave_result read_inputs(pave_context *context, const pave_mosaic_sources *sources,
                               const pave_mosaic_params *params, inputs *out)
{
    pave_result result =
        pv_struct_read(context, "sources", &no_sources, sizeof no_sources, sources, &out->sources);
    if (!result)
        result = pv_params_read(context, &pv_mosaic_table, params, &out->params);
    if (!result && !out->sources.photo)
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "a mosaic needs a photo");
    if (!result && out->params.tile_side > 0 && out->params.tile_side < 1)
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "tiles cannot be smaller than a pixel");
    return result;
}

/* Photo and sizes: what guide and packing both need. */
static pave_result begin(pave_context *context, const inputs *in, pv_work *w)
{
    memset(w, 0, sizeof *w);
    w->sources = &in->sources;
    w->params = &in->params;
    w->width = in->sources.photo->width;
    w->height = in->sources.photo->height;
    pave_result result = pv_photo_create(context, in->sources.photo, &w->photo);
    return result ? result : pv_sizes_read(context, w);
}

static void end(pv_work *w)
{
    pv_photo_free(&w->photo);
    pv_release(w->size);
    pave_cvd_free(&w->cvd);
}

static pave_result make_guide(pave_context *context, const pv_work *w, pave_guide **out)
{
    pave_mosaic_params params = *w->params;
    params.tile_side = w->side;
    return pv_guide_make(context, w->sources, &params, &w->photo, out);
}

pave_result pave_guide_create(pave_context *context, const pave_mosaic_sources *sources,
                              const pave_mosaic_params *params, pave_guide **out)
{
    inputs in;
    pv_work w;
    if (out)
        *out = NULL;
    if (!context || !sources || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = read_inputs(context, sources, params, &in);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "guide", 0, 1);
    result = begin(context, &in, &w);
    if (!result)
        result = make_guide(context, &w, out);
    pv_call_end(context, call);
    end(&w);
    return result;
}

static pave_result cut(pave_context *context, const pv_work *w, int *closed, pave_stones *stones)
{
    int plain = w->params->mode == PAVE_MODE_PAPER;
    *closed = 1;
    if (plain && w->params->shape != PAVE_TILE_CELL)
        return pv_tiles_cut(context, w, stones);
    return pv_quads_cut(context, w, plain, closed, stones);
}

/* *enough: 0: what is around a period does not do. */
static pave_result lay_tiles(pave_context *context, pv_work *w, int *enough, pave_stones *stones)
{
    pv_call call = pv_call_begin(context, "mosaic", 0.2, 0.7);
    pave_result result = pv_tiles_pack(context, w);
    pv_call_end(context, call);
    *enough = w->needed <= w->margin;
    if (result || !*enough)
        return result;
    call = pv_call_begin(context, "mosaic", 0.7, 1);
    result = cut(context, w, enough, stones);
    if (result || !*enough) {
        pv_call_end(context, call);
        return result;
    }
    result = pv_tiles_colour(context, w, stones);
    if (!result)
        result = pv_mosaic_judge(context, w, stones, &stones->mosaic->measure);
    pv_call_end(context, call);
    return result;
}

/* A period with ever more around it, until that is enough. */
static pave_result lay_period(pave_context *context, const pv_work *w, pave_cvd **cvd, pave_stones *stones)
{
    int enough = 0;
    pave_result result = PAVE_OK;
    for (int32_t margin = pv_period_guess(w); !enough && !result;) {
        pave_guide guide;
        pv_work wide;
        result = pv_period_widen(context, w, margin, &guide, &wide);
        if (!result)
            result = lay_tiles(context, &wide, &enough, stones);
        if (!result && enough)
            pv_period_settle(&wide, stones);
        if (!result && enough)
            *cvd = wide.cvd, wide.cvd = NULL;
        margin = (wide.needed > margin ? wide.needed : margin) + margin / 4;
        pv_period_drop(&guide, &wide);
    }
    return result;
}

static pave_result new_stones(pave_context *context, const pv_work *w, pave_stones **out)
{
    pave_result result = PAVE_OK;
    pave_stones *stones = *out = pv_allocate_zeroed(context, 1, sizeof *stones, &result);
    if (!stones)
        return result;
    stones->width = stones->plane_width = w->width;
    stones->height = stones->plane_height = w->height;
    stones->report.size = sizeof stones->report;
    stones->field.periodic = w->params->periodic;
    stones->mosaic = pv_allocate_zeroed(context, 1, sizeof *stones->mosaic, &result);
    if (!result)
        stones->mosaic->params = *w->params;
    return result;
}

/* What the diagram knows, for the report. */
static void describe(const pv_work *w, pave_stones *stones)
{
    stones->cvd = w->cvd->params;
    stones->backend = w->cvd->backend;
    memcpy(stones->backend_name, w->cvd->backend_name, sizeof stones->backend_name);
}

static pave_result run(pave_context *context, const inputs *in, const pave_guide *guide, pave_stones **out)
{
    pv_work w;
    pave_guide *own = NULL;
    pave_result result = begin(context, in, &w);
    if (!result && !guide)
        result = make_guide(context, &w, &own);
    w.guide = guide ? guide : own;
    if (!result && (w.guide->width != w.width || w.guide->height != w.height))
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "the guide has not the photo's size");
    if (!result && w.guide->wraps != in->params.periodic)
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "guide and mosaic must both be periodic, or neither");
    if (!result)
        result = new_stones(context, &w, out);
    int enough;
    if (!result)
        result = in->params.periodic ? lay_period(context, &w, &w.cvd, *out) : lay_tiles(context, &w, &enough, *out);
    if (!result)
        describe(&w, *out);
    end(&w);
    pave_guide_free(&own);
    return result;
}

pave_result pave_mosaic_create(pave_context *context, const pave_mosaic_sources *sources, const pave_guide *guide,
                               const pave_mosaic_params *params, pave_stones **out)
{
    inputs in;
    if (out)
        *out = NULL;
    if (!context || !sources || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = read_inputs(context, sources, params, &in);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "mosaic", 0, 1);
    result = run(context, &in, guide, out);
    pv_call_end(context, call);
    if (result)
        pave_stones_free(out);
    return result;
}

pave_result pave_mosaic_measure_of(pave_context *context, const pave_stones *stones, pave_mosaic_measure *measure)
{
    if (!context || !stones || !measure)
        return PAVE_ERR_ARGUMENT;
    if (!stones->mosaic)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "these stones are a pavement, not a mosaic");
    size_t size = measure->size, known = sizeof stones->mosaic->measure;
    if (size < sizeof(size_t) || size > 65536)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the measure has no size: set it first");
    memset(measure, 0, size);
    memcpy(measure, &stones->mosaic->measure, size < known ? size : known);
    measure->size = size;
    return PAVE_OK;
}
