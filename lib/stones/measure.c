/* The judge: stones against their drawing. Each part of the measures has a file. */
#include "stones/measure.h"

#include "base/params.h"

#include <string.h>

static const pave_stones_measure_params default_params = PAVE_STONES_MEASURE_PARAMS_INIT;

static const pv_param measure_rows[] = {
    PV_REAL(pave_stones_measure_params, half_side, "px", 0, 4096,
            "what near, far, thin and small are told by; 0: as laid, or by the stones' number"),
    PV_REAL(pave_stones_measure_params, joint_limit, "half sides", 0.01, 100, "wider gaps are holes, not joints"),
};

const pv_table pv_measure_table = PV_TABLE("measure", default_params, measure_rows);

void pave_stones_measure_params_init(pave_stones_measure_params *params, size_t size)
{
    pv_params_init(&pv_measure_table, params, size);
}

static pave_result check_inputs(pave_context *context, const pave_image *drawing, const pave_stones *stones)
{
    if (drawing->channels != 1 || drawing->type != PAVE_U8)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a drawing has one 8-bit channel: call pave_image_threshold first");
    if (drawing->width != drawing->place.width || drawing->height != drawing->place.height)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "stones are measured against the whole drawing, not a part of it");
    if (stones->x < 0 || stones->y < 0 || stones->width > drawing->width - stones->x ||
        stones->height > drawing->height - stones->y)
        return pv_fail(context, PAVE_ERR_ARGUMENT,
                       "the stones lie on %d,%d,%d,%d px, which is not within the drawing's %d x %d px", stones->x,
                       stones->y, stones->width, stones->height, drawing->width, drawing->height);
    return PAVE_OK;
}

static pave_result field_of(pave_context *context, const pave_image *drawing, pave_field **out)
{
    pave_field_params params = PAVE_FIELD_PARAMS_INIT;
    params.metric = PAVE_METRIC_EUCLID;
    pv_call call = pv_call_begin(context, "measure", 0.5, 0.65);
    pave_result result = pave_field_create(context, drawing, &params, out);
    pv_call_end(context, call);
    return result;
}

static pave_result judge(pave_context *context, const pv_survey *survey, pave_stones_measures *out)
{
    pave_image *painted = NULL;
    pave_field *field = NULL;
    pave_result result = pv_measure_shapes(context, survey, out);
    if (!result)
        result = pv_measure_overlap(context, survey, out);
    if (!result)
        result = pv_measure_ground(context, survey, &painted, out);
    if (!result)
        result = field_of(context, survey->drawing, &field);
    if (!result)
        result = pv_measure_directions(context, survey, field, out);
    if (!result)
        result = pv_measure_joints(context, survey, out);
    if (!result)
        result = pv_measure_edges(context, survey, field, painted, out);
    pave_field_free(&field);
    pave_image_free(&painted);
    return result;
}

static pave_result measure(pave_context *context, const pave_image *drawing, const pave_stones *stones,
                           const pave_stones_measure_params *params, pave_stones_measures *out)
{
    pv_survey survey;
    memset(out, 0, sizeof *out);
    out->size = sizeof *out;
    out->width = stones->width;
    out->height = stones->height;
    pave_result result = pv_survey_make(context, drawing, stones, params, &survey, &out->clockwise);
    out->half_side = survey.half_side;
    if (!result)
        result = judge(context, &survey, out);
    pv_survey_free(&survey);
    return result ? result : pv_progress(context, 1);
}

pave_result pave_stones_measure(pave_context *context, const pave_image *drawing, const pave_stones *stones,
                                const pave_stones_measure_params *given, pave_stones_measures *out)
{
    if (!context || !drawing || !stones || !out)
        return PAVE_ERR_ARGUMENT;
    size_t size = out->size;
    pave_stones_measure_params params;
    pave_stones_measures measures;
    if (size < sizeof(size_t) || size > 65536)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the measures have no size: set it first");
    memset(out, 0, size);
    out->size = size;
    pave_result result = pv_params_read(context, &pv_measure_table, given, &params);
    if (!result)
        result = check_inputs(context, drawing, stones);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "measure", 0, 1);
    result = measure(context, drawing, stones, &params, &measures);
    pv_call_end(context, call);
    if (result)
        return result;
    memcpy(out, &measures, size < sizeof measures ? size : sizeof measures);
    out->size = size;
    return PAVE_OK;
}
