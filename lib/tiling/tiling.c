/* Tilings: read the exemplars, lay the canvas in one of three ways, keep where every pixel comes from. */
#include "tiling/tiling.h"

#include "tiling/best.h"
#include "tiling/quilt.h"

#include <string.h>

static const pave_tiling_params default_params = PAVE_TILING_PARAMS_INIT;

static const pv_param tiling_rows[] = {
    PV_CHOICE(pave_tiling_params, mode, "best|fast|paper", "how blocks are joined"),
    PV_EXTENT(pave_tiling_params, extent, "size", "size of the result, px [twice the exemplar's]"),
    PV_CHOICE(pave_tiling_params, periodic, "xy|x|y|none", "where the result repeats without a seam (not in mode paper)"),
    PV_SEED(pave_tiling_params, seed, "another seed, another tiling"),
    PV_INTEGER(pave_tiling_params, fraction, "px", 0, 4096, "side of a block; 0: paper 20, else by size of features"),
    PV_INTEGER(pave_tiling_params, overlap, "px", 0, 4096, "how far blocks overlap; 0: paper 3, else by fraction"),
    PV_CHOICE(pave_tiling_params, search, "auto|reference|direct|fft|vulkan", "how blocks are found; all find the same"),
    PV_FLAG(pave_tiling_params, keep, "make the image itself tile: only a band at its border changes"),
    PV_INTEGER(pave_tiling_params, band, "px", 0, 1 << 20, "width of that band; 0: a feature and a half"),
    PV_INTEGER(pave_tiling_params, wang, "", 0, 3, "2 or 3: a set of Wang tiles with so many colours of edges; 0: none"),
    PV_FLAG(pave_tiling_params, turns, "copies may be turned by quarter turns"),
    PV_FLAG(pave_tiling_params, flips, "copies may be mirrored"),
    PV_INTEGER(pave_tiling_params, rounds, "", 0, 10000, "best: times that worst seams are cut again"),
    PV_REAL(pave_tiling_params, flatten, "", 0, 1, "share of slow changes of brightness left out in comparing"),
    PV_REAL(pave_tiling_params, joints, "", 0, 8, "weight of the distance to joints"),
    PV_REAL(pave_tiling_params, coverage, "", 0, 64, "weight of using all of the exemplar evenly"),
    PV_REAL(pave_tiling_params, repeat, "", 0, 64, "weight of not showing the same thing twice nearby"),
    PV_REAL(pave_tiling_params, guide, "", 0, 64, "weight of the guide image"),
    PV_REAL(pave_tiling_params, opaque, "", 0, 1, "exemplar pixels with less alpha are not used"),
};

const pv_table pv_tiling_table = PV_TABLE("tiling", default_params, tiling_rows);

void pave_tiling_params_init(pave_tiling_params *params, size_t size)
{
    pv_params_init(&pv_tiling_table, params, size);
}

int64_t pave_tiling_fractions(int32_t width, int32_t height, int32_t fraction_width, int32_t fraction_height)
{
    int64_t across = (int64_t)width - fraction_width + 1, down = (int64_t)height - fraction_height + 1;
    return fraction_width > 0 && fraction_height > 0 && across > 0 && down > 0 ? across * down : 0;
}

void pave_tiling_free(pave_tiling **tiling)
{
    if (!tiling || !*tiling)
        return;
    pv_release((*tiling)->sizes);
    pv_release((*tiling)->sources);
    pv_release((*tiling)->blocks);
    pv_release((*tiling)->tiles);
    pv_release(*tiling);
    *tiling = NULL;
}

int32_t pave_tiling_width(const pave_tiling *tiling) { return tiling->width; }
int32_t pave_tiling_height(const pave_tiling *tiling) { return tiling->height; }
const pave_source *pave_tiling_sources(const pave_tiling *tiling) { return tiling->sources; }
int32_t pave_tiling_wang_count(const pave_tiling *tiling) { return tiling->tile_count; }
int32_t pave_tiling_wang_width(const pave_tiling *tiling) { return tiling->tile_width; }
int32_t pave_tiling_wang_height(const pave_tiling *tiling) { return tiling->tile_height; }
const pave_wang_tile *pave_tiling_wang_tiles(const pave_tiling *tiling) { return tiling->tiles; }

/* The smallest exemplar's sides: a block must find room in each. */
static void least_sides(const pave_tiling *t, int32_t *width, int32_t *height)
{
    *width = t->sizes[0][0], *height = t->sizes[0][1];
    for (int32_t i = 1; i < t->exemplars; i++) {
        *width = t->sizes[i][0] < *width ? t->sizes[i][0] : *width;
        *height = t->sizes[i][1] < *height ? t->sizes[i][1] : *height;
    }
}

/* Two features and a half to a block, but half of the exemplar's side must remain for choosing. */
static void choose_scale(const pave_tiling *t, const pv_bank *bank, pv_scale *scale)
{
    int32_t width, height;
    least_sides(t, &width, &height);
    int32_t side = width < height ? width : height, most = 7 * side / 10;
    int32_t block = t->params.fraction ? t->params.fraction : (int32_t)(2.2 * bank->feature);
    if (!t->params.fraction)
        block = block < 24 ? 24 : block;
    block = block > most && !t->params.fraction ? most : block;
    scale->block = block < 2 ? 2 : block;
    scale->overlap = t->params.overlap ? t->params.overlap : block / 4 < 8 ? 8 : block / 4;
    scale->overlap = scale->overlap < scale->block ? scale->overlap : scale->block - 1;
    scale->window = 30;
    scale->window = scale->window > side / 2 ? side / 2 : scale->window;
    scale->window = scale->window < 1 ? 1 : scale->window;
    scale->reach = width > height ? width : height;
    scale->reach = scale->reach > 160 ? 160 : scale->reach;
    scale->places = 160;
    scale->radius = (int32_t)(0.86 * (side < 160 ? side : 160));
}

static pave_result keep_sources(pave_context *context, const pv_canvas *canvas, pave_tiling *t)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)canvas->width * (size_t)canvas->height;
    t->sources = pv_allocate(context, n, sizeof *t->sources, &result);
    for (size_t i = 0; i < n && !result; i++)
        t->sources[i] = pv_bank_source(canvas->bank, canvas->source[i]);
    return result;
}

static pave_result lay_by_mode(pave_context *context, const pv_scale *scale, pv_canvas *canvas, pave_tiling *t)
{
    switch (t->params.mode) {
    case PAVE_TILING_PAPER: return pv_paper_lay(context, &t->params, canvas, &t->blocks, &t->block_count);
    case PAVE_TILING_FAST: return pv_quilt_lay(context, &t->params, scale->block, scale->overlap, canvas);
    default: return pv_best_lay(context, &t->params, scale, canvas);
    }
}

static pave_result lay(pave_context *context, const pv_bank *bank, pave_tiling *t)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)t->width * (size_t)t->height;
    pv_canvas canvas = { .bank = bank, .width = t->width, .height = t->height };
    canvas.wrap_x = t->params.periodic == PAVE_PERIODIC_XY || t->params.periodic == PAVE_PERIODIC_X;
    canvas.wrap_y = t->params.periodic == PAVE_PERIODIC_XY || t->params.periodic == PAVE_PERIODIC_Y;
    pv_scale scale;
    choose_scale(t, bank, &scale);
    canvas.source = pv_allocate(context, n, sizeof *canvas.source, &result);
    if (!result) {
        memset(canvas.source, -1, n * sizeof *canvas.source);
        result = lay_by_mode(context, &scale, &canvas, t);
    }
    if (!result)
        result = keep_sources(context, &canvas, t);
    pv_release(canvas.source);
    return result;
}

static pave_result read_inputs(pave_context *context, const pave_image *const *exemplars, int32_t count,
                               const pave_tiling_params *given, pave_tiling *t)
{
    pave_result result = pv_params_read(context, &pv_tiling_table, given, &t->params);
    if (result)
        return result;
    t->exemplars = count;
    t->sizes = pv_allocate(context, (size_t)count, sizeof *t->sizes, &result);
    for (int32_t i = 0; i < count && !result; i++) {
        t->sizes[i][0] = exemplars[i]->width;
        t->sizes[i][1] = exemplars[i]->height;
    }
    if (result)
        return result;
    int32_t times = t->params.keep ? 1 : 2;
    t->width = t->params.extent[0] ? t->params.extent[0] : times * t->sizes[0][0];
    t->height = t->params.extent[1] ? t->params.extent[1] : times * t->sizes[0][1];
    return pv_check_size(context, "the tiling", t->width, t->height);
}

pave_result pave_tiling_create(pave_context *context, const pave_image *const *exemplars, int32_t count,
                               const pave_image *guide, const pave_tiling_params *given, pave_tiling **out)
{
    if (out)
        *out = NULL;
    if (!context || !exemplars || !out)
        return PAVE_ERR_ARGUMENT;
    (void)guide;
    double started = pv_seconds();
    pave_result result = PAVE_OK;
    pv_call outer = pv_call_begin(context, "tile", 0, 1);
    pv_bank bank = { 0 };
    pave_tiling *t = pv_allocate_zeroed(context, 1, sizeof *t, &result);
    if (!result)
        result = read_inputs(context, exemplars, count, given, t);
    if (!result)
        result = pv_bank_create(context, exemplars, count, &t->params, &bank);
    if (!result)
        result = lay(context, &bank, t);
    if (!result) {
        t->feature = bank.feature;
        t->seconds = pv_seconds() - started;
    }
    pv_bank_free(&bank);
    pv_call_end(context, outer);
    if (result)
        pave_tiling_free(&t);
    *out = t;
    return result;
}
