/* How far the edges between stones' colours are from those of the drawing, and the other way round. */
#include "stones/measure.h"

/* Pixels with colours, and how far pixels are from the edges of another picture of the same plane. */
typedef struct comparison {
    const uint8_t *colour; /* of a window, `stride` a row */
    int64_t stride;
    const uint8_t *other;  /* colours of the other picture at the same places */
    const float *distance; /* and its distances */
    int64_t other_stride;
    double sum, most;
    int64_t count;
} comparison;

/* Two pixels side by side: if there is an edge between them, how far it is from the other picture's. */
static void compare(comparison *c, int64_t a, int64_t b, int64_t other_a, int64_t other_b)
{
    if (c->colour[a] == c->colour[b])
        return;
    double d = 0;
    if (c->other[other_a] == c->other[other_b])
        d = ((double)c->distance[other_a] + c->distance[other_b]) / 2;
    c->sum += d;
    c->most = d > c->most ? d : c->most;
    c->count++;
}

static pave_result compare_all(pave_context *context, comparison *c, int32_t width, int32_t height, double from)
{
    pave_result result = PAVE_OK;
    for (int32_t y = 0; y < height && !result; y++) {
        int64_t row = y * c->stride, other = y * c->other_stride;
        for (int32_t x = 0; x < width; x++) {
            if (x + 1 < width)
                compare(c, row + x, row + x + 1, other + x, other + x + 1);
            if (y + 1 < height)
                compare(c, row + x, row + x + c->stride, other + x, other + x + c->other_stride);
        }
        if (y % 64 == 0)
            result = pv_progress(context, from + 0.05 * y / height);
    }
    return result;
}

/* The field of what the stones paint. */
static pave_result field_of(pave_context *context, const pave_image *painted, pave_field **out)
{
    pave_field_params params = PAVE_FIELD_PARAMS_INIT;
    params.metric = PAVE_METRIC_EUCLID;
    pv_call call = pv_call_begin(context, "measure", 0.85, 0.95);
    pave_result result = pave_field_create(context, painted, &params, out);
    pv_call_end(context, call);
    return result;
}

pave_result pv_measure_edges(pave_context *context, const pv_survey *survey, const pave_field *field,
                             const pave_image *painted, pave_stones_measures *out)
{
    const pave_stones *stones = survey->stones;
    int64_t plane = survey->drawing->width, at = stones->y * plane + stones->x;
    const uint8_t *drawn = (const uint8_t *)survey->drawing->pixels + at, *laid = painted->pixels;
    pave_field *back = NULL;
    comparison there = { laid, stones->width, drawn, field->distance + at, plane, 0, 0, 0 };
    pave_result result = compare_all(context, &there, stones->width, stones->height, 0.8);
    if (!result)
        result = field_of(context, painted, &back);
    if (result)
        return result;
    comparison here = { drawn, plane, laid, back->distance, stones->width, 0, 0, 0 };
    result = compare_all(context, &here, stones->width, stones->height, 0.95);
    pave_field_free(&back);
    out->edge_mean = there.sum / (double)(there.count ? there.count : 1);
    out->edge_max = there.most;
    out->missed_mean = here.sum / (double)(here.count ? here.count : 1);
    out->missed_max = here.most;
    return result;
}
