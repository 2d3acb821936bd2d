/* Textures from textures: the statistics of an image, and another image from noise that has them. */
#include "statistics/statistics.h"

#include "util/half.h"
#include "util/random.h"

#include <math.h>
#include <string.h>

static const pave_statistics_params default_params = PAVE_STATISTICS_PARAMS_INIT;
static const pave_statistics_synthesis_params default_synthesis = PAVE_STATISTICS_SYNTHESIS_PARAMS_INIT;

static const pv_param statistics_rows[] = {
    PV_INTEGER(pave_statistics_params, scales, "", 1, PV_MOST_SCALES, "scales of the pyramid"),
    PV_INTEGER(pave_statistics_params, orientations, "", 2, PV_MOST_ORIENTATIONS, "orientations at each scale"),
    PV_INTEGER(pave_statistics_params, neighbourhood, "px", 3, 2 * PV_MOST_REACH + 1,
               "side of the square of lags of an autocorrelation; odd"),
    PV_CHOICE(pave_statistics_params, cross, "none|pixels|magnitudes", "what is measured between channels"),
};

static const pv_param synthesis_rows[] = {
    PV_EXTENT(pave_statistics_synthesis_params, extent, "size", "size of the result, px [the texture's]"),
    PV_SEED(pave_statistics_synthesis_params, seed, "another seed, another texture"),
    PV_INTEGER(pave_statistics_synthesis_params, iterations, "", 0, 10000, "rounds at most"),
};

const pv_table pv_statistics_table = PV_TABLE("statistics", default_params, statistics_rows);
const pv_table pv_statistics_synthesis_table = PV_TABLE("texture synthesis", default_synthesis, synthesis_rows);

void pave_statistics_params_init(pave_statistics_params *params, size_t size)
{
    pv_params_init(&pv_statistics_table, params, size);
}

void pave_statistics_synthesis_params_init(pave_statistics_synthesis_params *params, size_t size)
{
    pv_params_init(&pv_statistics_synthesis_table, params, size);
}

void pave_statistics_free(pave_statistics **statistics)
{
    if (!statistics || !*statistics)
        return;
    pv_statistics_free((*statistics)->values);
    pv_release(*statistics);
    *statistics = NULL;
}

int32_t pave_statistics_count(const pave_statistics *statistics) { return statistics->values->count; }

/* The image's channels but alpha, as planes. */
static pave_result read_planes(pave_context *context, const pave_image *image, float **out)
{
    pave_result result = PAVE_OK;
    int32_t channels = image->channels - (image->alpha >= 0);
    int64_t n = (int64_t)image->width * image->height;
    if (image->type == PAVE_U32)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "labels are no texture: an image of PAVE_U32 has no statistics");
    if (!channels)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "an image of nothing but alpha has no statistics");
    float *planes = pv_allocate(context, (size_t)channels * (size_t)n, sizeof *planes, &result);
    for (int32_t c = 0; c < image->channels && !result; c++)
        for (int64_t i = 0; i < n && c != image->alpha; i++)
            planes[(int64_t)(c - (image->alpha >= 0 && c > image->alpha)) * n + i] =
                (float)pv_image_value(image, i * image->channels + c);
    *out = planes;
    return result;
}

static void find_ranges(pave_statistics *s, int64_t n, const float *planes)
{
    for (int32_t c = 0; c < s->channels; c++) {
        pv_moments m = pv_moments_of(planes + c * n, (size_t)n);
        s->mean[c] = m.mean, s->least[c] = m.least, s->greatest[c] = m.greatest;
    }
}

/* The principal axes of the colours, the longest first; each points where its largest part is positive. */
static void find_axes(pave_statistics *s, int64_t n, const float *planes)
{
    enum { MOST = PV_MOST_CHANNELS };
    double covariance[MOST * MOST], values[MOST], vectors[MOST * MOST];
    int32_t channels = s->channels, order[MOST];
    for (int32_t a = 0; a < channels; a++)
        for (int32_t b = 0; b <= a; b++) {
            double sum = 0;
            for (int64_t i = 0; i < n; i++)
                sum += (planes[a * n + i] - s->mean[a]) * (planes[b * n + i] - s->mean[b]);
            covariance[a * channels + b] = covariance[b * channels + a] = sum / (double)n;
        }
    pv_jacobi(channels, covariance, values, vectors);
    for (int32_t k = 0; k < channels; k++) {
        int32_t at = k;
        for (; at && values[order[at - 1]] < values[k]; at--)
            order[at] = order[at - 1];
        order[at] = k;
    }
    s->rank = 1;
    while (s->rank < channels && values[order[s->rank]] > 1e-10 * values[order[0]])
        s->rank++;
    for (int32_t k = 0; k < channels; k++) {
        int32_t most = 0;
        for (int32_t c = 1; c < channels; c++)
            most = fabs(vectors[c * channels + order[k]]) > fabs(vectors[most * channels + order[k]]) ? c : most;
        double sign = vectors[most * channels + order[k]] < 0 ? -1 : 1;
        for (int32_t c = 0; c < channels; c++)
            s->axes[k * channels + c] = sign * vectors[c * channels + order[k]];
    }
}

/* To the axes that count, or with `back` from them, in place. One channel stays as it is. */
static void turn(const pave_statistics *s, int64_t n, float *planes, int back)
{
    int32_t channels = s->channels, from = back ? s->rank : channels, to = back ? channels : s->rank;
    for (int64_t i = 0; i < n && channels > 1; i++) {
        double old[PV_MOST_CHANNELS];
        for (int32_t c = 0; c < from; c++)
            old[c] = planes[c * n + i] - (back ? 0 : s->mean[c]);
        for (int32_t k = 0; k < to; k++) {
            double sum = back ? s->mean[k] : 0;
            for (int32_t c = 0; c < from; c++)
                sum += old[c] * s->axes[back ? c * channels + k : k * channels + c];
            planes[k * n + i] = (float)sum;
        }
    }
}

static pave_result measure(pave_context *context, const pave_image *image, pave_statistics *s)
{
    pv_statistics_settings settings = { s->params.scales, s->params.orientations, s->params.neighbourhood, 0 };
    int64_t n = (int64_t)image->width * image->height;
    float *planes = NULL;
    pave_result result = read_planes(context, image, &planes);
    if (!result)
        result = pv_check_finite(context, image->width, image->height, s->channels, planes);
    if (!result) {
        find_ranges(s, n, planes);
        find_axes(s, n, planes);
        turn(s, n, planes, 0);
        settings.cross = s->rank > 1 ? s->params.cross : 0;
        result = pv_statistics_measure(context, image->width, image->height, s->rank, planes, &settings, &s->values);
    }
    pv_release(planes);
    return result;
}

pave_result pave_statistics_create(pave_context *context, const pave_image *texture,
                                   const pave_statistics_params *given, pave_statistics **out)
{
    if (!context || !out)
        return PAVE_ERR_ARGUMENT;
    *out = NULL;
    if (!texture)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_statistics_create: no texture");
    pave_result result = PAVE_OK;
    pv_call call = pv_call_begin(context, "statistics", 0, 1);
    pave_statistics *s = pv_allocate_zeroed(context, 1, sizeof *s, &result);
    if (!result) {
        s->channels = texture->channels - (texture->alpha >= 0);
        s->image = *texture;
        s->image.pixels = NULL, s->image.levels = NULL;
        result = pv_params_read(context, &pv_statistics_table, given, &s->params);
    }
    if (!result && texture->alpha >= 0)
        pv_note(context, PAVE_MESSAGE_INFO, "the texture's alpha is not looked at, and the result has none");
    if (!result)
        result = measure(context, texture, s);
    if (!result)
        result = pv_progress(context, 1);
    pv_call_end(context, call);
    if (result)
        pave_statistics_free(&s);
    else
        *out = s;
    return result;
}

static void report_groups(const pv_statistics *wanted, const pv_statistics *is, pave_statistics_report *out)
{
    double group[PV_GROUPS], worst = 0;
    for (int32_t g = 0; g < PV_GROUPS; g++) {
        group[g] = pv_statistics_group(wanted, is, g);
        worst = fmax(worst, group[g]);
        group[g] = group[g] < 0 ? (g < PV_CHANNELS ? 0 : NAN) : group[g];
    }
    *out = (pave_statistics_report){
        sizeof *out, group[PV_PIXELS], group[PV_SHAPE], group[PV_LOW_SHAPE], group[PV_LOW_CORRELATION],
        group[PV_HIGH], group[PV_MAGNITUDE], group[PV_MAGNITUDE_CORRELATION], group[PV_ORIENTATIONS],
        group[PV_SCALES], group[PV_PHASE], group[PV_CHANNELS], group[PV_CHANNEL_MAGNITUDES], worst
    };
}

/* A caller's report of any size gets what there is room for. */
static pave_result check_report(pave_context *context, const pave_statistics_report *report)
{
    return report && report->size < sizeof *report
               ? pv_fail(context, PAVE_ERR_ARGUMENT, "the size of pave_statistics_report is not set") : PAVE_OK;
}

pave_result pave_statistics_compare(pave_context *context, const pave_statistics *wanted, const pave_image *texture,
                                    pave_statistics_report *report)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!wanted || !texture || !report)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_statistics_compare: statistics, texture or report is NULL");
    int32_t channels = texture->channels - (texture->alpha >= 0);
    if (channels != wanted->channels)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a texture of %d channels cannot be compared with one of %d",
                       (int)channels, (int)wanted->channels);
    float *planes = NULL;
    pv_statistics *is = NULL;
    pv_call call = pv_call_begin(context, "statistics", 0, 1);
    pave_result result = check_report(context, report);
    if (!result)
        result = read_planes(context, texture, &planes);
    if (!result)
        result = pv_check_finite(context, texture->width, texture->height, channels, planes);
    if (!result) {
        turn(wanted, (int64_t)texture->width * texture->height, planes, 0);
        result = pv_statistics_measure_like(context, wanted->values, texture->width, texture->height, planes, &is);
    }
    if (!result)
        report_groups(wanted->values, is, report);
    pv_release(planes);
    pv_statistics_free(is);
    pv_call_end(context, call);
    return result;
}

/* White noise, nearly of a Gauss's distribution, with the deviation of each channel. */
static void draw_noise(const pave_statistics *s, uint64_t seed, int32_t width, int32_t height, float *planes)
{
    for (int32_t c = 0; c < s->rank; c++) {
        const double *pixels = pv_statistics_at(s->values, PV_PIXELS, c, 0);
        for (int64_t i = 0; i < (int64_t)width * height; i++) {
            pv_random r = pv_draw(seed, PV_DRAW_WHITE, (uint32_t)(i % width), (uint32_t)(i / width), (uint32_t)c);
            double sum = -4;
            for (int k = 0; k < 4; k++)
                sum += ((r.word[k] >> 16) + (r.word[k] & 0xffff) + 1) * 0x1p-16;
            planes[(int64_t)c * width * height + i] = (float)(pixels[0] + pixels[1] * sum * 1.2247448713915890);
        }
    }
}

static void put_value(const pave_image *image, int64_t at, double value)
{
    double most = image->type == PAVE_U8 ? 255 : 65535, whole = fmin(fmax(value, 0), 1) * most + 0.5;
    switch (image->type) {
    case PAVE_U8: ((uint8_t *)image->pixels)[at] = (uint8_t)whole; break;
    case PAVE_U16: ((uint16_t *)image->pixels)[at] = (uint16_t)whole; break;
    case PAVE_F16: ((uint16_t *)image->pixels)[at] = pv_half((float)value); break;
    default: ((float *)image->pixels)[at] = (float)value;
    }
}

/* The corner of the planes as an image like the one that was measured. */
static pave_result make_image(pave_context *context, const pave_statistics *s, int32_t width, int32_t height,
                              int32_t stride, int64_t n, const float *planes, pave_image **out)
{
    char names[PV_MOST_CHANNELS * (PV_CHANNEL_NAME + 1)] = "";
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    for (int32_t c = 0; c < s->image.channels; c++)
        if (c != s->image.alpha) {
            strcat(names, *names ? "," : "");
            strcat(names, s->image.names[c]);
        }
    params.width = width, params.height = height, params.channels = s->channels;
    params.type = s->image.type, params.encoding = s->image.encoding, params.names = names;
    pave_result result = pv_image_new(context, &params, out);
    for (int64_t i = 0; i < (int64_t)width * height && !result; i++)
        for (int32_t c = 0; c < s->channels; c++) {
            double value = planes[c * n + i / width * stride + i % width];
            put_value(*out, i * s->channels + c, fmin(fmax(value, s->least[c]), s->greatest[c]));
        }
    return result;
}

static pave_result synthesize(pave_context *context, const pave_statistics *s,
                              const pave_statistics_synthesis_params *params, pave_statistics_report *report,
                              pave_image **out)
{
    int32_t width = params->extent[0] ? params->extent[0] : s->image.width, step = 1 << s->params.scales;
    int32_t height = params->extent[1] ? params->extent[1] : s->image.height;
    pave_result result = pv_check_size(context, "the texture", width, height);
    if (result)
        return result;
    int32_t across = (width + step - 1) / step * step, down = (height + step - 1) / step * step;
    int64_t n = (int64_t)across * down;
    pv_statistics *is = NULL;
    float *planes = pv_allocate(context, (size_t)n, (size_t)s->channels * sizeof *planes, &result);
    if (!result) {
        draw_noise(s, params->seed, across, down, planes);
        result = pv_statistics_grow(context, s->values, across, down, planes, params->iterations, 0, 0.99, &is);
    }
    if (!result && report)
        report_groups(s->values, is, report);
    if (!result) {
        turn(s, n, planes, 1);
        result = make_image(context, s, width, height, across, n, planes, out);
    }
    pv_release(planes);
    pv_statistics_free(is);
    return result;
}

pave_result pave_statistics_synthesize(pave_context *context, const pave_statistics *statistics,
                                       const pave_statistics_synthesis_params *given, pave_statistics_report *report,
                                       pave_image **out)
{
    pave_statistics_synthesis_params params;
    if (!context || !out)
        return PAVE_ERR_ARGUMENT;
    *out = NULL;
    if (!statistics)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_statistics_synthesize: no statistics");
    pv_call call = pv_call_begin(context, "texture", 0, 1);
    pave_result result = pv_params_read(context, &pv_statistics_synthesis_table, given, &params);
    if (!result)
        result = check_report(context, report);
    if (!result)
        result = synthesize(context, statistics, &params, report, out);
    if (!result)
        result = pv_progress(context, 1);
    if (result)
        pave_image_free(out);
    pv_call_end(context, call);
    return result;
}
