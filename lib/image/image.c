/* Images: storage. */
#include "image/image.h"

#include "base/params.h"
#include "util/fixed.h"
#include "util/half.h"

#include <stdio.h>
#include <string.h>

static const pave_image_params default_params = PAVE_IMAGE_PARAMS_INIT;

static const pv_param image_rows[] = {
    PV_INTEGER(pave_image_params, width, "px", 1, 1 << 20, "width"),
    PV_INTEGER(pave_image_params, height, "px", 1, 1 << 20, "height"),
    PV_INTEGER(pave_image_params, channels, "", 1, PV_MOST_CHANNELS, "number of channels"),
    PV_INTEGER(pave_image_params, type, "", PAVE_U8, PAVE_F32, "how a channel is stored"),
    PV_INTEGER(pave_image_params, encoding, "", PAVE_DISPLAY, PAVE_DATA, "what a value means"),
    PV_INTEGER(pave_image_params, alpha, "", -1, PV_MOST_CHANNELS - 1, "index of the alpha channel"),
};

static const pv_table image_table = PV_TABLE("image", default_params, image_rows);

void pave_image_params_init(pave_image_params *params, size_t size)
{
    pv_params_init(&image_table, params, size);
}

size_t pv_type_bytes(int32_t type)
{
    switch (type) {
    case PAVE_U8: return 1;
    case PAVE_U16:
    case PAVE_F16: return 2;
    case PAVE_U32:
    case PAVE_F32: return 4;
    default: return 0;
    }
}

pave_result pv_check_size(pave_context *context, const char *what, int64_t width, int64_t height)
{
    const pave_limits *limits = &context->limits;
    if (width < 1 || height < 1)
        return pv_fail(context, PAVE_ERR_FORMAT, "%s: has no pixels (%lld x %lld)", what, (long long)width,
                       (long long)height);
    if (width > limits->max_side || height > limits->max_side)
        return pv_fail(context, PAVE_ERR_LIMIT, "%s: %lld x %lld px is beyond the limit of %lld px a side", what,
                       (long long)width, (long long)height, (long long)limits->max_side);
    if (width * height > limits->max_pixels)
        return pv_fail(context, PAVE_ERR_LIMIT, "%s: %lld x %lld px is beyond the limit of %lld pixels", what,
                       (long long)width, (long long)height, (long long)limits->max_pixels);
    return PAVE_OK;
}

static const char *default_names(int32_t channels)
{
    static const char *const names[] = { "Y", "Y,A", "R,G,B", "R,G,B,A" };
    return channels <= 4 ? names[channels - 1] : "";
}

/* Channels without a name are called by their number. */
static pave_result set_names(pave_context *context, pave_image *image, const char *names)
{
    for (int32_t i = 0; i < image->channels; i++) {
        size_t length = strcspn(names, ",");
        if (length >= PV_CHANNEL_NAME)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "a channel name is longer than %d bytes", PV_CHANNEL_NAME - 1);
        memcpy(image->names[i], names, length);
        if (!length)
            snprintf(image->names[i], PV_CHANNEL_NAME, "c%02d", (int)i);
        names += length + (names[length] == ',');
    }
    return PAVE_OK;
}

pave_result pv_image_new(pave_context *context, const pave_image_params *given, pave_image **out)
{
    pave_image_params params;
    pave_result result = pv_params_read(context, &image_table, given, &params);
    if (!result)
        result = pv_check_size(context, "image", params.width, params.height);
    if (!result && params.alpha >= params.channels)
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "alpha is channel %d of %d", params.alpha, params.channels);
    if (result)
        return result;

    pave_image *image = pv_allocate_zeroed(context, 1, sizeof *image, &result);
    if (!image)
        return result;
    image->width = params.width;
    image->height = params.height;
    image->channels = params.channels;
    image->type = params.type;
    image->encoding = params.encoding;
    image->alpha = params.alpha;
    image->place = (pv_place){ 0, 0, params.width, params.height };
    result = set_names(context, image, params.names ? params.names : default_names(params.channels));
    if (!result)
        image->pixels = pv_allocate(context, (size_t)params.width * (size_t)params.height,
                                    (size_t)params.channels * pv_type_bytes(params.type), &result);
    if (result)
        pave_image_free(&image);
    *out = image;
    return result;
}

void pv_repeat(const pv_place *plane, const void *pixels, size_t size, int32_t width, int32_t height, void *out)
{
    char *to = out;
    for (int32_t y = plane->y; y < plane->y + height; y++) {
        const char *row = (const char *)pixels + (size_t)pv_modulo(y, plane->height) * (size_t)plane->width * size;
        for (int32_t x = plane->x, run; x < plane->x + width; x += run, to += (size_t)run * size) {
            int32_t at = pv_modulo(x, plane->width), left = plane->x + width - x;
            run = plane->width - at < left ? plane->width - at : left;
            memcpy(to, row + (size_t)at * size, (size_t)run * size);
        }
    }
}

pave_result pv_image_repeat(pave_context *context, const pave_image *drawing, int32_t x, int32_t y, int32_t width,
                            int32_t height, pave_image **out)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = width;
    shape.height = height;
    pave_result result = pv_image_new(context, &shape, out);
    if (result)
        return result;
    (*out)->place = (pv_place){ x, y, drawing->width, drawing->height };
    pv_repeat(&(*out)->place, drawing->pixels, 1, width, height, (*out)->pixels);
    if (!drawing->levels)
        return PAVE_OK;
    result = pv_levels_new(context, *out, drawing->cut);
    if (!result)
        pv_repeat(&(*out)->place, drawing->levels, 1, width, height, (*out)->levels);
    return result;
}

pave_result pave_image_create(pave_context *context, const pave_image_params *params, const void *pixels,
                              pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !params || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_image_new(context, params, out);
    if (result)
        return result;
    pave_image *image = *out;
    size_t bytes = (size_t)image->width * (size_t)image->height * (size_t)image->channels * pv_type_bytes(image->type);
    if (pixels)
        memcpy(image->pixels, pixels, bytes);
    else
        memset(image->pixels, 0, bytes);
    return PAVE_OK;
}

void pave_image_free(pave_image **image)
{
    if (!image || !*image)
        return;
    pv_release((*image)->pixels);
    pv_release((*image)->levels);
    pv_release(*image);
    *image = NULL;
}

int32_t pave_image_width(const pave_image *image) { return image->width; }
int32_t pave_image_height(const pave_image *image) { return image->height; }
int32_t pave_image_channels(const pave_image *image) { return image->channels; }
int32_t pave_image_type(const pave_image *image) { return image->type; }
int32_t pave_image_encoding(const pave_image *image) { return image->encoding; }
int32_t pave_image_alpha(const pave_image *image) { return image->alpha; }
const void *pave_image_pixels(const pave_image *image) { return image->pixels; }
const pave_palette *pave_image_palette(const pave_image *image) { return &image->palette; }

const char *pave_image_channel_name(const pave_image *image, int32_t channel)
{
    return channel >= 0 && channel < image->channels ? image->names[channel] : NULL;
}

int32_t pv_image_channel(const pave_image *image, const char *name)
{
    for (int32_t i = 0; i < image->channels; i++)
        if (!strcmp(image->names[i], name))
            return i;
    return -1;
}

double pv_image_value(const pave_image *image, int64_t index)
{
    switch (image->type) {
    case PAVE_U8: return ((const uint8_t *)image->pixels)[index] / 255.0;
    case PAVE_U16: return ((const uint16_t *)image->pixels)[index] / 65535.0;
    case PAVE_U32: return ((const uint32_t *)image->pixels)[index];
    case PAVE_F16: return pv_half_value(((const uint16_t *)image->pixels)[index]);
    default: return ((const float *)image->pixels)[index];
    }
}
