/* Tilings: read the exemplars, lay the canvas in one of three ways, keep where every pixel comes from. */
#include "tiling/tiling.h"

#include "tiling/best.h"
#include "tiling/quilt.h"
#include "tiling/wang.h"

#include <string.h>

enum { MOST_REACH = 128, LEAST_SIDE = 8 };

static const pave_tiling_params default_params = PAVE_TILING_PARAMS_INIT;

static const pv_param tiling_rows[] = {
    PV_CHOICE(pave_tiling_params, mode, "best|fast|paper", "how blocks are joined"),
    PV_EXTENT(pave_tiling_params, extent, "size", "size of the result, px [twice the exemplar's]"),
    PV_CHOICE(pave_tiling_params, periodic, "xy|x|y|none", "where the result repeats without a seam; not with paper"),
    PV_SEED(pave_tiling_params, seed, "another seed, another tiling"),
    PV_INTEGER(pave_tiling_params, fraction, "px", 0, 4096, "side of a block; 0: paper 20, else by size of features"),
    PV_INTEGER(pave_tiling_params, overlap, "px", 0, 4096, "how far blocks overlap; 0: paper 3, else by fraction"),
    PV_CHOICE(pave_tiling_params, search, "auto|reference|direct|fft|vulkan",
              "how blocks are found; all find the same"),
    PV_FLAG(pave_tiling_params, keep, "make the image itself tile: only a band at its border changes"),
    PV_INTEGER(pave_tiling_params, band, "px", 0, 1 << 20, "width of that band; 0: a feature and a half"),
    PV_INTEGER(pave_tiling_params, wang, "", 0, 3, "2 or 3: a set of Wang tiles with so many edge colours; 0: none"),
    PV_FLAG(pave_tiling_params, turns, "copies may be turned by quarter turns"),
    PV_FLAG(pave_tiling_params, flips, "copies may be mirrored"),
    PV_INTEGER(pave_tiling_params, rounds, "", 0, 10000, "best: turns to cut the worst seams again; 0: by size"),
    PV_REAL(pave_tiling_params, flatten, "", 0, 1, "share of slow changes of brightness left out in comparing"),
    PV_REAL(pave_tiling_params, joints, "", 0, 8, "weight of the distance to joints"),
    PV_REAL(pave_tiling_params, coverage, "", 0, 64, "weight of using all of the exemplar evenly"),
    PV_REAL(pave_tiling_params, repeat, "", 0, 64, "weight of not showing the same thing twice nearby"),
    PV_REAL(pave_tiling_params, guide_weight, "", 0, 64, "weight of the guide image"),
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

static int32_t at_most(int32_t v, int32_t most)
{
    return v < most ? v : most;
}

/* Two features and more to a block, but enough of the exemplar's side must remain for choosing. */
static void choose_scale(const pave_tiling *t, const pv_bank *bank, pv_scale *scale)
{
    int32_t width, height;
    least_sides(t, &width, &height);
    int32_t side = at_most(width, height), auto_block = (int32_t)((t->params.mode ? 1.8 : 2.2) * bank->feature);
    auto_block = bank->feature > 0 ? auto_block < 24 ? 24 : auto_block : side / 2;
    scale->block = t->params.fraction ? t->params.fraction : at_most(at_most(auto_block, 7 * side / 10), 112);
    scale->block = scale->block < 1 ? 1 : scale->block;
    scale->overlap = t->params.overlap ? t->params.overlap : scale->block < 24 ? scale->block / 3 : scale->block / 4;
    scale->overlap = t->params.overlap || scale->block < 24 || scale->overlap > 8 ? scale->overlap : 8;
    scale->window = at_most(30, (side + 1) / 2);
    scale->reach = at_most(width > height ? width : height, MOST_REACH);
    scale->reach = scale->reach > scale->block + 2 ? scale->reach : scale->block + 2;
    scale->places = MOST_REACH;
    scale->radius = (int32_t)(0.86 * at_most(side, MOST_REACH));
}

/* What the user should know of an exemplar that cannot give much. */
static void warn(pave_context *context, const pave_tiling *t, const pv_bank *bank)
{
    int32_t width, height;
    least_sides(t, &width, &height);
    double across = bank->feature > 0 ? at_most(width, height) / bank->feature : INFINITY;
    if (across < 2.5 && t->params.mode != PAVE_TILING_PAPER && !t->params.keep)
        pv_note(context, PAVE_MESSAGE_WARNING,
                "the exemplar shows only about %.1f features (of %.0f px) across: little can be varied; a larger part "
                "of the texture, or the same scaled down, would do better", across, bank->feature);
}

static pave_result check_blocks(pave_context *context, const pave_tiling *t)
{
    int32_t width, height, fraction = t->params.fraction, overlap = t->params.overlap;
    least_sides(t, &width, &height);
    if (!fraction && t->params.mode == PAVE_TILING_PAPER)
        fraction = 20;
    if (!overlap && t->params.mode == PAVE_TILING_PAPER)
        overlap = 3;
    if (!pave_tiling_fractions(width, height, fraction ? fraction : 1, fraction ? fraction : 1))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "an exemplar of %d x %d px has no room for a fraction of %d x %d",
                       (int)width, (int)height, (int)fraction, (int)fraction);
    if (fraction && overlap >= fraction)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "an overlap of %d px leaves nothing of a fraction of %d px",
                       (int)overlap, (int)fraction);
    if (!fraction && overlap)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "an overlap of %d px needs a fraction larger than that",
                       (int)overlap);
    if (fraction > MOST_REACH && t->params.mode == PAVE_TILING_BEST)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "fraction is %d, but must be 0 .. %d px in mode best", (int)fraction,
                       MOST_REACH);
    return PAVE_OK;
}

/* What only mode best does. */
static pave_result check_mode(pave_context *context, const pave_tiling *t, const pave_image *guide)
{
    const pave_tiling_params *p = &t->params;
    const char *what = guide ? "a guide" : p->keep ? "keep" : p->wang ? "a Wang set" : NULL;
    int32_t tiles = p->wang * p->wang;
    if (what && p->mode != PAVE_TILING_BEST)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%s needs mode best", what);
    if (p->wang == 1 || (p->wang && p->keep))
        return pv_fail(context, PAVE_ERR_ARGUMENT, p->keep ? "keep and wang exclude each other"
                                                           : "wang is 1, but must be 0, 2 or 3");
    if (p->wang && (p->periodic != PAVE_PERIODIC_XY || t->width % tiles || t->height % tiles))
        return pv_fail(context, PAVE_ERR_ARGUMENT,
                       "a Wang set of %d colours is periodic in x and y, and its sides are multiples of %d px",
                       (int)p->wang, (int)tiles);
    if (p->keep && (t->exemplars > 1 || t->width != t->sizes[0][0] || t->height != t->sizes[0][1]))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "keep works on one image, and in its own size");
    if (p->keep && p->periodic == PAVE_PERIODIC_NONE)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "keep makes an image periodic: periodic cannot be none");
    if (guide && (guide->width != t->width || guide->height != t->height))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the guide has %d x %d px, the tiling %d x %d", (int)guide->width,
                       (int)guide->height, (int)t->width, (int)t->height);
    return PAVE_OK;
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

/* Is a pixel so near to a side that wraps? */
static int is_near(const pv_canvas *c, int32_t x, int32_t y, int32_t band)
{
    return (c->wrap_x && (x < band || x >= c->width - band)) || (c->wrap_y && (y < band || y >= c->height - band));
}

/* The image as it is, of which only a band along sides that wrap may change. The outermost quarter of that is laid
 * anew, for a straight seam would cost no more than the two that take its place. */
static void lay_kept(const pave_tiling *t, pv_canvas *c)
{
    const pv_sheet *sheet = &c->bank->sheet[0];
    int32_t side = at_most(c->width, c->height), band = t->params.band ? t->params.band : (int32_t)(1.5 * t->feature);
    band = t->params.band ? band : at_most(band < 8 ? 8 : band, side / 4);
    for (int32_t y = 0; y < c->height; y++)
        for (int32_t x = 0; x < c->width; x++) {
            int32_t at = y * c->width + x, own = sheet->first + y * c->bank->stride + x;
            c->source[at] = is_near(c, x, y, band / 4) ? PV_NOTHING : own;
            c->fixed[at] = !is_near(c, x, y, band);
        }
}

/* One colour needs no search, and a few pixels leave nothing to choose. */
static int is_obvious(const pave_tiling *t, const pv_canvas *c)
{
    int32_t width, height;
    least_sides(t, &width, &height);
    return c->bank->plain || at_most(width, height) < LEAST_SIDE || at_most(c->width, c->height) < LEAST_SIDE;
}

/* Copies side by side. */
static pave_result lay_plain(pave_context *context, pv_canvas *c)
{
    if (c->bank->usable_count < c->bank->all)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "so few pixels, not all of which can be used, make no tiling");
    const pv_sheet *sheet = &c->bank->sheet[0];
    for (int32_t y = 0; y < c->height; y++)
        for (int32_t x = 0; x < c->width; x++)
            c->source[(int64_t)y * c->width + x] =
                sheet->first + y % sheet->height * c->bank->stride + x % sheet->width;
    return PAVE_OK;
}

static pave_result lay_by_mode(pave_context *context, pv_canvas *canvas, pave_tiling *t)
{
    pv_scale scale;
    choose_scale(t, canvas->bank, &scale);
    if (t->params.mode == PAVE_TILING_PAPER)
        return pv_paper_lay(context, &t->params, canvas, &t->blocks, &t->block_count);
    if (is_obvious(t, canvas) && t->params.wang)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "an exemplar of one colour, or of a few pixels, makes no Wang set");
    if (is_obvious(t, canvas))
        return lay_plain(context, canvas);
    if (t->params.mode == PAVE_TILING_FAST)
        return pv_quilt_lay(context, &t->params, scale.block, scale.overlap, canvas);
    if (t->params.wang)
        return pv_wang_lay(context, &scale, canvas, t);
    if (t->params.keep)
        lay_kept(t, canvas);
    return pv_best_lay(context, &t->params, &scale, canvas);
}

static pave_result lay(pave_context *context, const pv_bank *bank, const pave_image *guide, pave_tiling *t)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)t->width * (size_t)t->height;
    int16_t *tones = NULL;
    pv_canvas canvas = { .bank = bank, .width = t->width, .height = t->height };
    canvas.wrap_x = t->params.periodic == PAVE_PERIODIC_XY || t->params.periodic == PAVE_PERIODIC_X;
    canvas.wrap_y = t->params.periodic == PAVE_PERIODIC_XY || t->params.periodic == PAVE_PERIODIC_Y;
    if (t->params.mode == PAVE_TILING_PAPER)
        canvas.wrap_x = canvas.wrap_y = 0;
    canvas.source = pv_allocate(context, n, sizeof *canvas.source, &result);
    if (!result && (t->params.keep || t->params.wang))
        canvas.fixed = pv_allocate_zeroed(context, n, 1, &result);
    if (!result && guide)
        result = pv_guide_read(context, bank, guide, &tones);
    if (!result) {
        memset(canvas.source, -1, n * sizeof *canvas.source);
        canvas.guide = tones;
        result = lay_by_mode(context, &canvas, t);
    }
    if (!result)
        result = keep_sources(context, &canvas, t);
    pv_release(canvas.source);
    pv_release(canvas.fixed);
    pv_release(tones);
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
    int64_t times = t->params.keep ? 1 : t->params.wang ? t->params.wang * t->params.wang : 2;
    int64_t width = t->params.extent[0] ? t->params.extent[0] : times * t->sizes[0][0];
    int64_t height = t->params.extent[1] ? t->params.extent[1] : times * t->sizes[0][1];
    result = pv_check_size(context, "the tiling", width, height);
    t->width = (int32_t)width;
    t->height = (int32_t)height;
    return result;
}

static pave_result run(pave_context *context, const pave_image *const *exemplars, int32_t count,
                       const pave_image *guide, const pave_tiling_params *given, pave_tiling *t)
{
    double started = pv_seconds();
    pv_bank bank = { 0 };
    pave_result result = read_inputs(context, exemplars, count, given, t);
    if (!result)
        result = check_blocks(context, t);
    if (!result)
        result = check_mode(context, t, guide);
    if (!result)
        result = pv_bank_create(context, exemplars, count, &t->params, &bank);
    if (!result) {
        t->feature = bank.feature;
        warn(context, t, &bank);
        result = lay(context, &bank, guide, t);
    }
    t->seconds = pv_seconds() - started;
    pv_bank_free(&bank);
    return result;
}

pave_result pave_tiling_create(pave_context *context, const pave_image *const *exemplars, int32_t count,
                               const pave_image *guide, const pave_tiling_params *given, pave_tiling **out)
{
    if (out)
        *out = NULL;
    if (!context || !exemplars || !out)
        return PAVE_ERR_ARGUMENT;
    for (int32_t i = 0; i < count; i++)
        if (!exemplars[i])
            return pv_fail(context, PAVE_ERR_ARGUMENT, "exemplar %d is NULL", (int)i);
    if (count < 1 || count > PV_MOST_EXEMPLARS)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%d exemplars, but there must be 1 .. %d", (int)count,
                       PV_MOST_EXEMPLARS);
    pave_result result = PAVE_OK;
    pv_call outer = pv_call_begin(context, "tile", 0, 1);
    pave_tiling *t = pv_allocate_zeroed(context, 1, sizeof *t, &result);
    if (!result)
        result = run(context, exemplars, count, guide, given, t);
    pv_call_end(context, outer);
    if (result)
        pave_tiling_free(&t);
    *out = t;
    return result;
}
