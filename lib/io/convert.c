/* Pixels between what images hold and what files hold. */
#include "io/convert.h"

#include <math.h>
#include <string.h>

int pv_is_colour(const pave_image *image, int32_t channel)
{
    const char *name = image->names[channel];
    return image->encoding != PAVE_DATA && channel != image->alpha && name[0] && !name[1] && strchr("RGBY", name[0]);
}

static void store(void *out, int64_t index, int32_t type, double value)
{
    double unit = value > 0 ? value < 1 ? value : 1 : 0; /* 0 for NaN */
    switch (type) {
    case PAVE_U8: ((uint8_t *)out)[index] = (uint8_t)(unit * 255 + 0.5); break;
    case PAVE_U16: ((uint16_t *)out)[index] = (uint16_t)(unit * 65535 + 0.5); break;
    case PAVE_U32: ((uint32_t *)out)[index] = value > 0 ? value < UINT32_MAX ? (uint32_t)value : UINT32_MAX : 0; break;
    case PAVE_F16: ((uint16_t *)out)[index] = pv_half((float)value); break;
    default: ((float *)out)[index] = (float)value;
    }
}

static double recode(double value, int32_t from, int32_t to)
{
    if (from == PAVE_DISPLAY && to == PAVE_LINEAR)
        return pv_linear_light(value);
    return from == PAVE_LINEAR && to == PAVE_DISPLAY ? pv_display_code(value) : value;
}

void pv_convert_rows(const pave_image *image, int32_t from, int32_t to, pv_pixels how, void *out)
{
    int64_t n = image->channels, first = (int64_t)from * image->width, count = (int64_t)(to - from) * image->width;
    int multiply = how.premultiplied && image->alpha >= 0, colour[PV_MOST_CHANNELS];
    size_t bytes = pv_type_bytes(image->type);
    int same = image->encoding == how.encoding || image->encoding == PAVE_DATA || how.encoding == PAVE_DATA;
    if (image->type == how.type && same && !multiply) {
        memcpy(out, (const char *)image->pixels + (size_t)(first * n) * bytes, (size_t)(count * n) * bytes);
        return;
    }
    for (int32_t c = 0; c < n; c++)
        colour[c] = pv_is_colour(image, c);
    for (int64_t i = 0; i < count; i++) {
        double alpha = multiply ? pv_image_value(image, (first + i) * n + image->alpha) : 1;
        for (int32_t c = 0; c < n; c++) {
            double value = pv_image_value(image, (first + i) * n + c);
            if (colour[c])
                value = recode(value, image->encoding, how.encoding) * alpha;
            store(out, i * n + c, how.type, value);
        }
    }
}

void pv_unpremultiply(pave_image *image)
{
    int64_t n = image->channels, count = (int64_t)image->width * image->height;
    for (int64_t i = 0; image->alpha >= 0 && i < count; i++) {
        double alpha = pv_image_value(image, i * n + image->alpha);
        for (int32_t c = 0; alpha != 0 && alpha != 1 && c < n; c++)
            if (pv_is_colour(image, c))
                store(image->pixels, i * n + c, image->type, pv_image_value(image, i * n + c) / alpha);
    }
}

/* Where the pixel (x, y) of the turned image comes from. */
static int64_t source(int32_t orientation, int32_t w, int32_t h, int32_t x, int32_t y)
{
    int32_t turned = orientation >= 5, u = turned ? y : x, v = turned ? x : y;
    int mirror_x = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
    int mirror_y = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
    return (int64_t)(mirror_y ? h - 1 - v : v) * w + (mirror_x ? w - 1 - u : u);
}

static void turn(const pave_image *from, pave_image *to, int32_t orientation)
{
    size_t bytes = (size_t)from->channels * pv_type_bytes(from->type);
    const char *pixels = from->pixels;
    char *out = to->pixels;
    for (int32_t y = 0; y < to->height; y++)
        for (int32_t x = 0; x < to->width; x++, out += bytes)
            memcpy(out, pixels + (size_t)source(orientation, from->width, from->height, x, y) * bytes, bytes);
}

pave_result pv_orient(pave_context *context, pave_image **image, int32_t orientation)
{
    pave_image *from = *image, *to = NULL;
    if (orientation < 2 || orientation > 8)
        return PAVE_OK;
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    params.width = orientation >= 5 ? from->height : from->width;
    params.height = orientation >= 5 ? from->width : from->height;
    params.channels = from->channels;
    params.type = from->type;
    params.encoding = from->encoding;
    params.alpha = from->alpha;
    pave_result result = pv_image_new(context, &params, &to);
    if (!result) {
        memcpy(to->names, from->names, sizeof to->names);
        turn(from, to, orientation);
    }
    pave_image_free(image);
    *image = to;
    return result;
}
