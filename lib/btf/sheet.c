/* Sheets: textures under lights and from views side by side, and ABRDFs as discs of all lights. */
#include "btf/btf.h"

#include "base/parallel.h"
#include "image/image.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

enum { GAP = 2 };

static const pave_btf_sheet_params default_params = PAVE_BTF_SHEET_PARAMS_INIT;

static const pv_param sheet_rows[] = {
    PV_INTEGER(pave_btf_sheet_params, views, "", 1, 4096, "views shown, spread over all"),
    PV_INTEGER(pave_btf_sheet_params, lights, "", 1, 4096, "lights shown, of a contact sheet"),
    PV_INTEGER(pave_btf_sheet_params, tile, "px", 4, 4096, "side of each picture"),
    PV_INTEGER(pave_btf_sheet_params, x, "", -1, 1 << 20, "texel of a plot; -1: the mean of all"),
    PV_INTEGER(pave_btf_sheet_params, y, "", -1, 1 << 20, "texel of a plot; -1: the mean of all"),
    PV_REAL(pave_btf_sheet_params, exposure, "stops", -20, 20, "brightness, in powers of two"),
};

const pv_table pv_btf_sheet_table = PV_TABLE("BTF sheets", default_params, sheet_rows);

void pave_btf_sheet_params_init(pave_btf_sheet_params *params, size_t size)
{
    pv_params_init(&pv_btf_sheet_table, params, size);
}

typedef struct sheet {
    const pave_btf *btf;
    pave_btf_sheet_params params;
    int32_t columns, rows, width; /* width: of the picture, px */
    const float *abrdf;           /* of a plot */
    double gain;
    float *pixels;
} sheet;

/* The k-th of `count` out of `all`, spread evenly. */
static int32_t spread(int32_t k, int32_t count, int32_t all)
{
    return count < 2 ? 0 : (int32_t)((int64_t)k * (all - 1) / (count - 1));
}

/* Where a pixel of the picture lies: its tile, and its place there; 0 in a gap. */
static int find_tile(const sheet *s, int32_t at, int32_t count, int32_t *tile, int32_t *in)
{
    *tile = at / (s->params.tile + GAP);
    *in = at % (s->params.tile + GAP);
    return *tile < count && *in < s->params.tile;
}

static void put(const sheet *s, float *pixel, const double *values)
{
    for (int32_t c = 0; c < s->btf->channels; c++)
        pixel[c] = (float)(s->gain * values[c]);
    pixel[s->btf->channels] = 1;
}

/* A texel of the texture: tiles show its beginning if they are smaller, repeats of it if they are larger. */
static void contact_pixel(const sheet *s, int32_t column, int32_t row, int32_t x, int32_t y, float *pixel)
{
    const pave_btf *btf = s->btf;
    float values[PV_BTF_CHANNELS];
    double wide[PV_BTF_CHANNELS];
    int64_t view = spread(row, s->rows, btf->views.count), light = spread(column, s->columns, btf->lights.count);
    pv_btf_sample(btf, (int64_t)(y % btf->height) * btf->width + x % btf->width, view * btf->lights.count + light,
                  values);
    for (int32_t c = 0; c < btf->channels; c++)
        wide[c] = (double)values[c];
    put(s, pixel, wide);
}

/* A light in the parabolic plane; the disc is the hemisphere. */
static void plot_pixel(const sheet *s, int32_t column, int32_t x, int32_t y, float *pixel)
{
    const pave_btf *btf = s->btf;
    double half = s->params.tile / 2.0, px = (x + 0.5 - half) / half, py = (half - y - 0.5) / half, r = hypot(px, py);
    double weight[3], sum[PV_BTF_CHANNELS] = { 0 };
    int32_t index[3];
    int64_t view = spread(column, s->columns, btf->views.count);
    if (r > 1)
        return;
    pave_direction light = { (float)(2 * atan(r)), (float)atan2(py, px) };
    pv_directions_weigh(&btf->lights, light, index, weight);
    for (int32_t k = 0; k < 3; k++)
        for (int32_t c = 0; c < btf->channels; c++)
            sum[c] += weight[k] *
                      (double)s->abrdf[(view * btf->lights.count + index[k]) * btf->channels + c];
    put(s, pixel, sum);
}

static void draw_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const sheet *s = data;
    int32_t row, column, in_y, in_x, channels = s->btf->channels + 1;
    for (int32_t x = 0; x < s->width; x++) {
        float *pixel = s->pixels + ((int64_t)y * s->width + x) * channels;
        for (int32_t c = 0; c < channels; c++)
            pixel[c] = 0;
        if (!find_tile(s, y, s->rows, &row, &in_y) || !find_tile(s, x, s->columns, &column, &in_x))
            continue;
        if (s->abrdf)
            plot_pixel(s, column, in_x, in_y, pixel);
        else
            contact_pixel(s, column, row, in_x, in_y, pixel);
    }
}

static pave_result draw(pave_context *context, sheet *s, double from, pave_image **out)
{
    int32_t side = s->params.tile + GAP;
    int64_t width = (int64_t)s->columns * side - GAP, height = (int64_t)s->rows * side - GAP;
    pave_result result = pv_check_size(context, "the sheet", width, height);
    s->width = (int32_t)width;
    s->gain = pi * exp2(s->params.exposure);
    if (!result)
        result = pv_btf_picture(context, s->btf, s->width, (int32_t)height, 1, out);
    if (result)
        return result;
    s->pixels = (*out)->pixels;
    return pv_parallel(context, (int32_t)height, draw_row, s, from, 1);
}

static int32_t least(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

pave_result pave_btf_contact_sheet(pave_context *context, const pave_btf *btf, const pave_btf_sheet_params *given,
                                   pave_image **out)
{
    sheet s = { .btf = btf };
    if (out)
        *out = NULL;
    if (!context || !btf || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_btf_sheet_table, given, &s.params);
    if (result)
        return result;
    s.columns = least(s.params.lights, btf->lights.count);
    s.rows = least(s.params.views, btf->views.count);
    pv_call call = pv_call_begin(context, "sheet", 0, 1);
    result = draw(context, &s, 0, out);
    pv_call_end(context, call);
    if (result)
        pave_image_free(out);
    return result;
}

/* The mean over texels, spread over at most so many of them. */
static pave_result mean_abrdf(pave_context *context, const pave_btf *btf, float *out, float *room)
{
    enum { MOST = 1024 };
    int64_t texels = pv_btf_texels(btf), count = texels < MOST ? texels : MOST, length = pv_btf_length(btf);
    pave_result result = PAVE_OK;
    for (int64_t i = 0; i < length; i++)
        out[i] = 0;
    for (int64_t k = 0; k < count && !result; k++) {
        int64_t texel = k * texels / count;
        pave_btf_abrdf(btf, (int32_t)(texel % btf->width), (int32_t)(texel / btf->width), room);
        for (int64_t i = 0; i < length; i++)
            out[i] += room[i] / (float)count;
        result = pv_progress(context, 0.8 * (double)k / (double)count);
    }
    return result;
}

static pave_result plot(pave_context *context, sheet *s, pave_image **out)
{
    const pave_btf *btf = s->btf;
    pave_result result = PAVE_OK;
    size_t length = (size_t)pv_btf_length(btf);
    float *abrdf = pv_allocate(context, 2 * length, sizeof *abrdf, &result);
    if (!result && (s->params.x < 0 || s->params.y < 0))
        result = mean_abrdf(context, btf, abrdf, abrdf + length);
    else if (!result)
        pave_btf_abrdf(btf, s->params.x, s->params.y, abrdf);
    s->abrdf = abrdf;
    if (!result)
        result = draw(context, s, 0.8, out);
    pv_release(abrdf);
    return result;
}

pave_result pave_btf_plot(pave_context *context, const pave_btf *btf, const pave_btf_sheet_params *given,
                          pave_image **out)
{
    sheet s = { .btf = btf, .rows = 1 };
    if (out)
        *out = NULL;
    if (!context || !btf || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_btf_sheet_table, given, &s.params);
    if (!result && (s.params.x >= btf->width || s.params.y >= btf->height))
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "texel %d, %d is beyond the %d x %d there are", (int)s.params.x,
                         (int)s.params.y, (int)btf->width, (int)btf->height);
    if (result)
        return result;
    s.columns = least(s.params.views, btf->views.count);
    pv_call call = pv_call_begin(context, "plot", 0, 1);
    result = plot(context, &s, out);
    pv_call_end(context, call);
    if (result)
        pave_image_free(out);
    return result;
}

pave_result pave_btf_view_difference(pave_context *context, const pave_btf *a, const pave_btf *b,
                                     const pave_image *environment, const pave_btf_view_params *params, double scale,
                                     pave_image **out)
{
    pave_image *other = NULL;
    if (out)
        *out = NULL;
    if (!context || !a || !b || !out || !(scale >= 0) || isinf(scale))
        return PAVE_ERR_ARGUMENT;
    if (a->channels != b->channels)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the two BTFs differ in channels");
    pv_call call = pv_call_begin(context, "difference", 0, 0.5);
    pave_result result = pave_btf_view(context, a, environment, params, out);
    pv_call_end(context, call);
    call = pv_call_begin(context, "difference", 0.5, 1);
    if (!result)
        result = pave_btf_view(context, b, environment, params, &other);
    pv_call_end(context, call);
    int64_t count = result ? 0 : (int64_t)other->width * other->height * other->channels;
    for (int64_t i = 0; i < count; i++) {
        float *value = (float *)(*out)->pixels + i;
        if (i % other->channels != other->alpha)
            *value = (float)scale * fabsf(*value - ((const float *)other->pixels)[i]);
    }
    pave_image_free(&other);
    if (result)
        pave_image_free(out);
    return result;
}
