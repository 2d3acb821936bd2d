/* From images to texels. A sample of a few labels gets one number a label, for the mean of two labels is not a third;
 * others are stretched to 0..255 unless they are bytes. */
#include "solid/exemplar.h"

#include <math.h>
#include <string.h>

static int colour_channels(const pave_image *image)
{
    return image->channels - (image->alpha >= 0);
}

static double full_of(int32_t type)
{
    return type == PAVE_U8 ? 255 : type == PAVE_U16 ? 65535 : type == PAVE_U32 ? 4294967295.0 : 1;
}

void pv_palette_pixel(const pv_palette *palette, const pave_image *image, int64_t pixel, double *stored)
{
    double from = image->type == PAVE_U8 || image->type == PAVE_U16 ? 1 : 1 / full_of(image->type);
    double scale = from * full_of(palette->type);
    for (int32_t c = 0, to = 0; c < image->channels && to < palette->channels; c++) {
        if (c == image->alpha)
            continue;
        double value = pv_image_value(image, pixel * image->channels + c) * scale;
        if (palette->type != PAVE_F32)
            value = floor(fmin(fmax(value, 0), full_of(palette->type)) + 0.5);
        stored[to++] = value;
    }
}

static pave_result check_alike(pave_context *context, const pave_image *const *images, int32_t count,
                               pv_palette *palette)
{
    const pave_image *first = images[0];
    palette->channels = colour_channels(first);
    palette->type = first->type == PAVE_U8 || first->type == PAVE_U16 ? first->type : PAVE_F32;
    if (palette->channels < 1 || palette->channels > PV_MOST_FEATURES)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "a sample has 1 to %d channels, this one %d", PV_MOST_FEATURES,
                       (int)palette->channels);
    for (int32_t i = 1; i < count; i++)
        if (colour_channels(images[i]) != palette->channels || images[i]->type != first->type)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "the samples of the axes differ in channels or type");
    return PAVE_OK;
}

static void look_at(pv_palette *palette, const pave_image *image, int32_t *found)
{
    double stored[PV_MOST_FEATURES];
    int64_t pixels = (int64_t)image->width * image->height;
    for (int64_t i = 0; i < pixels; i++) {
        pv_palette_pixel(palette, image, i, stored);
        for (int32_t c = 0; c < palette->channels; c++) {
            palette->least[c] = fmin(palette->least[c], stored[c]);
            palette->most[c] = fmax(palette->most[c], stored[c]);
        }
        int32_t l = 0;
        while (l < *found && l < PV_MOST_LABELS && palette->label[l] != stored[0])
            l++;
        if (l == *found && l < PV_MOST_LABELS)
            palette->label[l] = stored[0];
        *found = l == *found ? l + 1 : *found;
    }
}

static void choose_commonest(pv_palette *palette, const pave_image *image)
{
    double stored[PV_MOST_FEATURES];
    int64_t counts[PV_MOST_LABELS] = { 0 }, pixels = (int64_t)image->width * image->height;
    for (int64_t i = 0; i < pixels; i++) {
        pv_palette_pixel(palette, image, i, stored);
        for (int32_t l = 0; l < palette->labels; l++)
            counts[l] += palette->label[l] == stored[0];
    }
    for (int32_t l = 1; l < palette->labels; l++)
        if (counts[l] > counts[palette->commonest])
            palette->commonest = l;
}

pave_result pv_palette_create(pave_context *context, const pave_image *const *images, int32_t count, pv_palette *out)
{
    int32_t found = 0;
    memset(out, 0, sizeof *out);
    pave_result result = check_alike(context, images, count, out);
    for (int c = 0; c < PV_MOST_FEATURES; c++)
        out->least[c] = INFINITY, out->most[c] = -INFINITY;
    for (int32_t i = 0; i < count && !result; i++)
        look_at(out, images[i], &found);
    for (int32_t c = 0; c < out->channels && !result; c++)
        if (!isfinite(out->least[c]) || !isfinite(out->most[c]))
            result = pv_fail(context, PAVE_ERR_FORMAT, "a sample has values that are not finite numbers");
    if (result)
        return result;
    out->exact = out->channels == 1 && out->type == PAVE_U8;
    if (out->exact)
        out->least[0] = 0, out->most[0] = 255;
    int whole = out->channels == 1 && out->type != PAVE_F32;
    out->labels = whole && found > 1 && found <= PV_MOST_LABELS ? found : 0;
    out->features = out->labels ? out->labels - 1 : out->channels;
    if (out->labels)
        choose_commonest(out, images[0]);
    return PAVE_OK;
}

static uint8_t stretched(const pv_palette *palette, int32_t channel, double stored)
{
    double range = palette->most[channel] - palette->least[channel];
    double v = range > 0 ? (stored - palette->least[channel]) / range * 255 : 0;
    return (uint8_t)floor(fmin(fmax(v, 0), 255) + 0.5);
}

static int32_t nearest_label(const pv_palette *palette, double stored)
{
    int32_t best = 0;
    for (int32_t l = 1; l < palette->labels; l++)
        if (fabs(palette->label[l] - stored) < fabs(palette->label[best] - stored))
            best = l;
    return best;
}

void pv_palette_encode(const pv_palette *palette, const double *stored, uint8_t *feature, uint8_t *class)
{
    int32_t sum = 0;
    if (palette->labels) {
        int32_t label = nearest_label(palette, stored[0]), to = 0;
        for (int32_t l = 0; l < palette->labels; l++)
            if (l != palette->commonest)
                feature[to++] = l == label ? 255 : 0;
        *class = stretched(palette, 0, palette->label[label]);
        return;
    }
    for (int32_t c = 0; c < palette->channels; c++)
        sum += feature[c] = stretched(palette, c, stored[c]);
    *class = (uint8_t)(sum / palette->channels);
}

pave_result pv_texels_create(pave_context *context, const pv_palette *palette, const pave_image *image, pv_texels *out)
{
    pave_result result = PAVE_OK;
    double stored[PV_MOST_FEATURES];
    size_t n = (size_t)image->width * (size_t)image->height;
    *out = (pv_texels){ image->width, image->height, palette->features, NULL, NULL };
    out->feature = pv_allocate(context, n, (size_t)palette->features, &result);
    if (out->feature)
        out->class = pv_allocate(context, n, 1, &result);
    if (!out->class)
        return result;
    for (size_t i = 0; i < n; i++) {
        pv_palette_pixel(palette, image, (int64_t)i, stored);
        pv_palette_encode(palette, stored, out->feature + i * (size_t)palette->features, &out->class[i]);
    }
    return PAVE_OK;
}
