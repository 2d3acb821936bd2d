/* The distance field: mark the edges, spread the distance, hand it out in pixels. */
#include "field/field.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

static const pave_field_params default_params = PAVE_FIELD_PARAMS_INIT;

static const pv_param field_rows[] = {
    PV_CHOICE(pave_field_params, metric, "chamfer|euclid|figure3",
              "distance to the edges: the text's chamfer, exact, or the numbers of Fig. 3"),
    PV_FLAG(pave_field_params, periodic, "the drawing repeats in x and y, and so do the stones"),
};

const pv_table pv_field_table = PV_TABLE("field", default_params, field_rows);

void pave_field_params_init(pave_field_params *params, size_t size)
{
    pv_params_init(&pv_field_table, params, size);
}

/* From 1/65536 px to px, in place. */
static void to_pixels(void *data, int32_t band, int32_t worker)
{
    (void)worker;
    const pave_field *field = data;
    int64_t pixels = (int64_t)field->width * field->height, task = (int64_t)field->width * pv_band_rows(field->width);
    for (int64_t i = band * task; i < (band + 1) * task && i < pixels; i++) {
        int32_t fixed;
        memcpy(&fixed, &field->distance[i], sizeof fixed);
        field->distance[i] = fixed == PV_FIELD_FAR ? INFINITY : (float)fixed / PV_FIELD_ONE;
    }
}

/* One pixel and its diagonal; Fig. 3 was made with half of that. */
static pv_steps steps_of(int32_t metric)
{
    pv_steps whole = { PV_FIELD_ONE, 92682 }, half = { PV_FIELD_ONE / 2, 46341 };
    return metric == PAVE_METRIC_FIGURE3 ? half : whole;
}

static pave_result measure(pave_context *context, const pv_drawing *drawing, pave_field *field)
{
    pave_result result;
    int32_t *distance = pv_allocate(context, (size_t)field->width * (size_t)field->height, sizeof *distance, &result);
    if (!distance)
        return result;
    field->distance = (void *)distance;
    if (field->params.metric == PAVE_METRIC_EUCLID)
        result = pv_euclid(context, drawing, distance);
    else
        result = pv_chamfer(context, drawing, steps_of(field->params.metric), distance);
    return result ? result : pv_parallel(context, pv_bands(field->width, field->height), to_pixels, field, 0.9, 1);
}

pave_result pave_field_create(pave_context *context, const pave_image *drawing, const pave_field_params *given,
                              pave_field **out)
{
    if (out)
        *out = NULL;
    if (!context || !drawing || !out)
        return PAVE_ERR_ARGUMENT;
    pave_field_params params;
    pave_result result = pv_params_read(context, &pv_field_table, given, &params);
    if (!result && (drawing->channels != 1 || drawing->type != PAVE_U8))
        result = pv_fail(context, PAVE_ERR_ARGUMENT,
                         "a drawing has one 8-bit channel: call pave_image_threshold first");
    if (result)
        return result;

    pave_field *field = pv_allocate_zeroed(context, 1, sizeof *field, &result);
    if (!field)
        return result;
    field->width = drawing->width;
    field->height = drawing->height;
    field->place = drawing->place;
    field->params = params;
    field->wraps = params.periodic && pv_is_whole(&drawing->place, drawing->width, drawing->height);
    pv_drawing pixels = { drawing->width, drawing->height, drawing->pixels, field->wraps };
    pv_call call = pv_call_begin(context, "field", 0, 1);
    result = measure(context, &pixels, field);
    pv_call_end(context, call);
    if (result)
        pave_field_free(&field);
    *out = field;
    return result;
}

pave_result pv_field_repeat(pave_context *context, const pave_field *field, int32_t x, int32_t y, int32_t width,
                            int32_t height, pave_field **out)
{
    pave_result result = PAVE_OK;
    pave_field *part = *out = pv_allocate_zeroed(context, 1, sizeof *part, &result);
    if (!part)
        return result;
    *part = (pave_field){ .width = width, .height = height, .params = field->params,
                          .place = { x, y, field->width, field->height } };
    part->distance = pv_allocate(context, (size_t)width * (size_t)height, sizeof *part->distance, &result);
    if (part->distance)
        pv_repeat(&part->place, field->distance, sizeof *part->distance, width, height, part->distance);
    else
        pave_field_free(out);
    return result;
}

void pave_field_free(pave_field **field)
{
    if (!field || !*field)
        return;
    pv_release((*field)->distance);
    pv_release(*field);
    *field = NULL;
}

int32_t pave_field_width(const pave_field *field) { return field->width; }
int32_t pave_field_height(const pave_field *field) { return field->height; }
const float *pave_field_distance(const pave_field *field) { return field->distance; }

pave_result pave_field_image(pave_context *context, const pave_field *field, pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !field || !out)
        return PAVE_ERR_ARGUMENT;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = field->width;
    shape.height = field->height;
    shape.channels = 3;
    shape.type = PAVE_F32;
    shape.encoding = PAVE_DATA;
    shape.names = "distance,gradient.x,gradient.y";
    pave_result result = pv_image_new(context, &shape, out);
    if (result)
        return result;
    float *pixel = (*out)->pixels;
    for (int32_t y = 0; y < field->height; y++)
        for (int32_t x = 0; x < field->width; x++, pixel += 3) {
            pixel[0] = field->distance[(int64_t)y * field->width + x];
            pv_gradient(field, x, y, &pixel[1], &pixel[2]);
        }
    return PAVE_OK;
}
