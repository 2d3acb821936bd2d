/* The whole job in one call, and the register of parameter tables: the two things that know every stage. */
#include "base/params.h"
#include "btf/enlarge.h"
#include "btf/model.h"
#include "cvd/cvd.h"
#include "field/field.h"
#include "image/bitmap.h"
#include "maps/maps.h"
#include "mosaic/mosaic.h"
#include "solid/solid.h"
#include "statistics/statistics.h"
#include "stones/stones.h"
#include "tiling/tiling.h"

#include <pave/pave.h>

#include <math.h>

extern const pv_table pv_stream_table;   /* stream.c */
extern const pv_table pv_btf_file_table; /* io/btf_file.c */
extern const pv_table pv_maps_file_table; /* io/maps.c */

static const pave_lay_params default_params = PAVE_LAY_PARAMS_INIT;

void pave_lay_params_init(pave_lay_params *params, size_t size)
{
    const pv_table table = { "lay", sizeof default_params, &default_params, NULL, 0 };
    pv_params_init(&table, params, size);
}

static const pv_table *find_table(int32_t table)
{
    switch (table) {
    case PAVE_PARAMS_CONTEXT: return &pv_context_table;
    case PAVE_PARAMS_LIMITS: return &pv_limits_table;
    case PAVE_PARAMS_THRESHOLD: return &pv_threshold_table;
    case PAVE_PARAMS_FIELD: return &pv_field_table;
    case PAVE_PARAMS_CVD: return &pv_cvd_table;
    case PAVE_PARAMS_STONES: return &pv_stones_table;
    case PAVE_PARAMS_STREAM: return &pv_stream_table;
    case PAVE_PARAMS_PALETTE: return &pv_palette_table;
    case PAVE_PARAMS_MEASURE: return &pv_measure_table;
    case PAVE_PARAMS_MOSAIC: return &pv_mosaic_table;
    case PAVE_PARAMS_TILING: return &pv_tiling_table;
    case PAVE_PARAMS_SOLID: return &pv_solid_table;
    case PAVE_PARAMS_STATISTICS: return &pv_statistics_table;
    case PAVE_PARAMS_STATISTICS_SYNTHESIS: return &pv_statistics_synthesis_table;
    case PAVE_PARAMS_BTF_SYNTHESIS: return &pv_btf_synthesis_table;
    case PAVE_PARAMS_BTF_COMPRESS: return &pv_btf_compress_table;
    case PAVE_PARAMS_BTF_VIEW: return &pv_btf_view_table;
    case PAVE_PARAMS_BTF_FILE: return &pv_btf_file_table;
    case PAVE_PARAMS_BTF_TEXELS: return &pv_btf_texels_table;
    case PAVE_PARAMS_BTF_SHEET: return &pv_btf_sheet_table;
    case PAVE_PARAMS_BTF_MODEL: return &pv_btf_model_table;
    case PAVE_PARAMS_BTF_PLAN: return &pv_btf_plan_table;
    case PAVE_PARAMS_BTF_RECONSTRUCT: return &pv_btf_reconstruct_table;
    case PAVE_PARAMS_BTF_MEASURE: return &pv_btf_measure_table;
    case PAVE_PARAMS_BTF_ENLARGE: return &pv_btf_enlarge_table;
    case PAVE_PARAMS_MAPS: return &pv_maps_table;
    case PAVE_PARAMS_MODEL: return &pv_model_table;
    case PAVE_PARAMS_MAPS_FILE: return &pv_maps_file_table;
    default: return NULL;
    }
}

int32_t pave_params_count(int32_t table)
{
    const pv_table *found = find_table(table);
    return found ? found->count : 0;
}

pave_result pave_params_describe(int32_t table, int32_t index, pave_param *out)
{
    return pv_param_describe(find_table(table), index, out);
}

pave_result pave_params_set(pave_context *context, int32_t table, void *params, const char *name, const char *value)
{
    const pv_table *found = find_table(table);
    if (!context || !found || !params || !name || !value)
        return PAVE_ERR_ARGUMENT;
    return pv_param_set(context, found, params, name, value);
}

/* What the stages hand on to each other. */
typedef struct lay_work {
    pave_image *drawing;
    pave_field *field;
    pave_cvd *cvd;
    pave_stones *stones;
} lay_work;

/* The diagram, again with a larger margin if the stones of its window need it. */
static pave_result make_diagram(pave_context *context, const pave_lay_params *params, lay_work *work)
{
    pave_cvd_params cvd;
    pave_stones_params stones;
    pave_result result = pv_params_read(context, &pv_cvd_table, params->cvd, &cvd);
    if (!result)
        result = pv_params_read(context, &pv_stones_table, params->stones, &stones);
    if (!cvd.supersample)
        cvd.supersample = pv_stones_supersample(&stones);
    if (!result)
        cvd.window_margin = fmax(cvd.window_margin, pv_stones_margin_guess(work->field->place.width,
                                 work->field->place.height, work->field->wraps, &cvd, &stones));
    while (!result && !work->cvd) {
        result = pave_cvd_create(context, work->field, &cvd, &work->cvd);
        if (result)
            break;
        double lacking = pv_stones_margin(work->cvd, &stones) - pv_stones_room(work->cvd);
        if (lacking <= 0)
            break;
        cvd.window_margin += 1.25 * lacking / pave_cvd_half_side(work->cvd) + 1;
        pave_cvd_free(&work->cvd);
    }
    return result;
}

static pave_result widen_drawing(pave_context *context, const pave_lay_params *params, pave_image **drawing)
{
    pave_field_params field;
    pave_cvd_params cvd;
    pave_stones_params stones;
    pave_result result = pv_params_read(context, &pv_field_table, params->field, &field);
    if (!result)
        result = pv_params_read(context, &pv_cvd_table, params->cvd, &cvd);
    if (!result)
        result = pv_params_read(context, &pv_stones_table, params->stones, &stones);
    return result ? result : pv_stones_widen(context, &cvd, &stones, field.periodic, drawing);
}

/* In black and white, or in the colours of a palette, which is found first if none is given. */
static pave_result make_drawing(pave_context *context, const pave_image *image, const pave_lay_params *params,
                                pave_image **out)
{
    pave_palette_params palette;
    pave_result result = pv_params_read(context, &pv_palette_table, params->palette, &palette);
    if (!result && !palette.colours && !palette.palette.count)
        return pave_image_threshold(context, image, params->threshold, out);
    pv_call call = pv_call_begin(context, "colours", 0, 0.5);
    if (!result && !palette.palette.count)
        result = pave_palette_find(context, image, palette.colours, &palette.palette);
    pv_call_end(context, call);
    call = pv_call_begin(context, "colours", 0.5, 1);
    if (!result)
        result = pave_image_quantise(context, image, &palette.palette, out);
    pv_call_end(context, call);
    return result;
}

/* So that a merge can tell windows of different drawings. */
static pave_result hash_drawing(pave_context *context, lay_work *work)
{
    pv_bitmap bitmap;
    if (work->drawing->palette.count) {
        work->stones->drawing = work->drawing->hash;
        return PAVE_OK;
    }
    int32_t depth = work->drawing->levels ? 8 : 1;
    pave_result result = pv_bitmap_create(context, work->drawing->width, work->drawing->height, depth, &bitmap);
    if (result)
        return result;
    bitmap.cut = work->drawing->cut;
    pv_bitmap_store(&bitmap, 0, 0, work->drawing);
    result = pv_bitmap_hash(context, &bitmap, &work->stones->drawing);
    pv_bitmap_free(&bitmap);
    return result;
}

/* The shares of progress are about those of the time. */
static pave_result run_stages(pave_context *context, const pave_image *image, const pave_lay_params *params,
                              lay_work *work)
{
    double start = pv_seconds(), after_field = start, after_cvd = start;
    pv_call call = pv_call_begin(context, "lay", 0, 0.05);
    pave_result result = make_drawing(context, image, params, &work->drawing);
    if (!result)
        result = widen_drawing(context, params, &work->drawing);
    if (!result)
        result = pave_field_create(context, work->drawing, params->field, &work->field);
    pv_call_end(context, call);
    after_field = pv_seconds();
    call = pv_call_begin(context, "lay", 0.05, 0.85);
    if (!result)
        result = make_diagram(context, params, work);
    pv_call_end(context, call);
    after_cvd = pv_seconds();
    call = pv_call_begin(context, "lay", 0.85, 1);
    if (!result)
        result = pave_stones_create(context, work->drawing, work->field, work->cvd, params->stones, &work->stones);
    pv_call_end(context, call);
    if (result)
        return result;
    pave_report *report = &work->stones->report;
    report->seconds_field = after_field - start;
    report->seconds_cvd = after_cvd - after_field;
    report->seconds_stones = pv_seconds() - after_cvd;
    const pave_stones *s = work->stones;
    if (!pv_is_whole(&(pv_place){ s->x, s->y, s->plane_width, s->plane_height }, s->width, s->height))
        result = hash_drawing(context, work);
    return result ? result : pv_params_read(context, &pv_threshold_table, params->threshold, &work->stones->threshold);
}

pave_result pave_lay(pave_context *context, const pave_image *image, const pave_lay_params *given,
                     pave_stones **out)
{
    if (out)
        *out = NULL;
    if (!context || !image || !out)
        return PAVE_ERR_ARGUMENT;
    pave_lay_params params;
    pave_result result =
        pv_struct_read(context, "lay", &default_params, sizeof default_params, given, &params);
    if (result)
        return result;
    lay_work work = { NULL, NULL, NULL, NULL };
    pv_call call = pv_call_begin(context, "lay", 0, 1);
    result = run_stages(context, image, &params, &work);
    pv_call_end(context, call);
    pave_image_free(&work.drawing);
    pave_field_free(&work.field);
    pave_cvd_free(&work.cvd);
    if (result)
        pave_stones_free(&work.stones);
    *out = work.stones;
    return result;
}
