/* A finer field: between the pixels' centres the distance is what the four around say together, weighted. */
#include "field/field.h"

#include "base/parallel.h"

#include <math.h>

typedef struct refining {
    const pave_field *from;
    pave_field *to;
    int32_t scale;
} refining;

/* Between which of `count` pixels the finer one lies, and how far from the first. */
static double between(int32_t i, int32_t scale, int32_t count, int32_t wraps, int32_t *a, int32_t *b)
{
    int32_t at = 2 * i + 1 - scale, first = at / (2 * scale) - (at < 0);
    *a = first >= 0 ? first : wraps ? count - 1 : 0;
    *b = first + 1 < count ? first + 1 : wraps ? 0 : first;
    return (double)(at - 2 * scale * first) / (2 * scale);
}

static void refine_row(void *data, int32_t y, int32_t worker)
{
    const refining *r = data;
    const pave_field *from = r->from;
    int32_t top, bottom, left, right;
    double v = between(y, r->scale, from->height, from->wraps, &top, &bottom);
    const float *up = from->distance + (int64_t)top * from->width;
    const float *down = from->distance + (int64_t)bottom * from->width;
    float *out = r->to->distance + (int64_t)y * r->to->width;
    (void)worker;
    for (int32_t x = 0; x < r->to->width; x++) {
        double u = between(x, r->scale, from->width, from->wraps, &left, &right);
        double a = up[left] + ((double)up[right] - up[left]) * u;
        double b = down[left] + ((double)down[right] - down[left]) * u, d = r->scale * (a + (b - a) * v);
        out[x] = isfinite(d) ? (float)d : INFINITY;
    }
}

pave_result pv_field_refine(pave_context *context, const pave_field *field, int32_t scale, pave_field **out)
{
    pave_result result = PAVE_OK;
    *out = pv_allocate_zeroed(context, 1, sizeof **out, &result);
    if (!*out)
        return result;
    **out = *field;
    (*out)->width *= scale;
    (*out)->height *= scale;
    (*out)->place = (pv_place){ scale * field->place.x, scale * field->place.y, scale * field->place.width,
                                scale * field->place.height };
    (*out)->distance = pv_allocate(context, (size_t)(*out)->width * (size_t)(*out)->height, sizeof *field->distance,
                                   &result);
    refining r = { field, *out, scale };
    if (!result)
        result = pv_parallel(context, (*out)->height, refine_row, &r, 0, 0.02);
    if (result)
        pave_field_free(out);
    return result;
}
