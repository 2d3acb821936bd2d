/* The photo as light and as it looks. Colours do without the libm, so that they are the same everywhere. */
#include "mosaic/mosaic.h"

#include "base/parallel.h"
#include "image/image.h"

#include <math.h>
#include <string.h>

static double cube_root(double v)
{
    if (!(v > 0))
        return 0;
    int exponent;
    double m = frexp(v, &exponent); /* 0.5 .. 1 */
    while (exponent % 3)
        exponent++, m /= 2;
    double r = 0.45 + 0.55 * m;
    for (int i = 0; i < 5; i++)
        r -= (r - m / (r * r)) / 3;
    return ldexp(r, exponent / 3);
}

static double fifth_root(double v)
{
    if (!(v > 0))
        return 0;
    int exponent;
    double m = frexp(v, &exponent);
    while (exponent % 5)
        exponent++, m /= 2;
    double r = 0.5 + 0.5 * m;
    for (int i = 0; i < 7; i++)
        r -= (r - m / (r * r * r * r)) / 5;
    return ldexp(r, exponent / 5);
}

double pv_tile_light(double display)
{
    double t = (display + 0.055) / 1.055;
    return display <= 0.04045 ? display / 12.92 : t * t * fifth_root(t * t);
}

static double display_value(double light)
{
    if (!(light > 0))
        return 0;
    if (light >= 1)
        return 1;
    if (light <= 0.0031308)
        return 12.92 * light;
    double quarter = sqrt(sqrt(light)); /* light^(1/2.4) is light^(1/3) times light^(1/12) */
    return 1.055 * cube_root(light) * cube_root(quarter) - 0.055;
}

uint8_t pv_tile_code(double light)
{
    return (uint8_t)(display_value(light) * 255 + 0.5);
}

static double lab_curve(double v)
{
    return v > 216.0 / 24389 ? cube_root(v) : (24389.0 / 27 * v + 16) / 116;
}

void pv_tile_lab(const double light[3], double lab[3])
{
    const double *c = light;
    double x = lab_curve((0.4124564 * c[0] + 0.3575761 * c[1] + 0.1804375 * c[2]) / 0.95047);
    double y = lab_curve(0.2126729 * c[0] + 0.7151522 * c[1] + 0.0721750 * c[2]);
    double z = lab_curve((0.0193339 * c[0] + 0.1191920 * c[1] + 0.9503041 * c[2]) / 1.08883);
    lab[0] = 116 * y - 16;
    lab[1] = 500 * (x - y);
    lab[2] = 200 * (y - z);
}

enum { CURVE = 4096 };

typedef struct conversion {
    const pave_image *image;
    pv_photo *photo;
    int32_t channel[3];
    float light[65536]; /* of the values of 8 or 16 bits */
    float lab_curve[CURVE + 2];
    int32_t holes;
} conversion;

static double light_at(const conversion *c, int64_t index)
{
    switch (c->image->type) {
    case PAVE_U8: return c->light[((const uint8_t *)c->image->pixels)[index]];
    case PAVE_U16: return c->light[((const uint16_t *)c->image->pixels)[index]];
    default: break;
    }
    double v = pv_image_value(c->image, index);
    v = v > 0 ? v < 1 ? v : 1 : 0;
    return c->image->encoding == PAVE_DISPLAY ? pv_tile_light(v) : v;
}

/* Edges need no more than a table of the curve, for which the square root is stepped evenly. */
static float curve_at(const conversion *c, double v)
{
    double at = sqrt(v > 0 ? v < 1 ? v : 1 : 0) * CURVE;
    int32_t i = (int32_t)at;
    return c->lab_curve[i] + (float)(at - i) * (c->lab_curve[i + 1] - c->lab_curve[i]);
}

static void convert_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const conversion *c = data;
    const pave_image *image = c->image;
    for (int64_t i = (int64_t)y * image->width; i < ((int64_t)y + 1) * image->width; i++) {
        float *light = c->photo->light + 3 * i, *lab = c->photo->lab + 3 * i;
        for (int k = 0; k < 3; k++)
            light[k] = (float)light_at(c, i * image->channels + c->channel[k]);
        double r = light[0], g = light[1], b = light[2];
        float fx = curve_at(c, (0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
        float fy = curve_at(c, 0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
        float fz = curve_at(c, (0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
        lab[0] = 116 * fy - 16;
        lab[1] = 500 * (fx - fy);
        lab[2] = 200 * (fy - fz);
        if (c->photo->hole)
            c->photo->hole[i] = pv_image_value(image, i * image->channels + image->alpha) < 0.5;
    }
}

static void find_channels(conversion *c)
{
    static const char *const names[] = { "R", "G", "B" };
    for (int k = 0; k < 3; k++)
        c->channel[k] = pv_image_channel(c->image, names[k]);
    if (c->channel[0] < 0 || c->channel[1] < 0 || c->channel[2] < 0)
        c->channel[0] = c->channel[1] = c->channel[2] = c->image->alpha == 0 && c->image->channels > 1 ? 1 : 0;
}

static void fill_tables(conversion *c)
{
    int32_t values = c->image->type == PAVE_U8 ? 256 : c->image->type == PAVE_U16 ? 65536 : 0;
    for (int32_t i = 0; i < values; i++) {
        double v = (double)i / (values - 1);
        c->light[i] = (float)(c->image->encoding == PAVE_DISPLAY ? pv_tile_light(v) : v);
    }
    for (int32_t i = 0; i <= CURVE + 1; i++)
        c->lab_curve[i] = (float)lab_curve((double)i / CURVE * i / CURVE);
}

static pave_result convert(pave_context *context, conversion *c)
{
    const pave_image *image = c->image;
    pave_result result = PAVE_OK;
    pv_photo *photo = c->photo;
    size_t pixels = (size_t)image->width * (size_t)image->height;
    photo->light = pv_allocate(context, 3 * pixels, sizeof *photo->light, &result);
    if (!result)
        photo->lab = pv_allocate(context, 3 * pixels, sizeof *photo->lab, &result);
    if (!result && image->alpha >= 0)
        photo->hole = pv_allocate(context, pixels, 1, &result);
    if (result)
        return result;
    find_channels(c);
    fill_tables(c);
    result = pv_parallel(context, image->height, convert_row, c, 0, 1);
    if (!result && photo->hole && !memchr(photo->hole, 1, pixels)) {
        pv_release(photo->hole);
        photo->hole = NULL;
    } else if (!result && photo->hole && !memchr(photo->hole, 0, pixels)) {
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "the photo is transparent everywhere: no place for tiles");
    }
    return result;
}

pave_result pv_photo_create(pave_context *context, const pave_image *image, pv_photo *out)
{
    pave_result result = PAVE_OK;
    *out = (pv_photo){ .width = image->width, .height = image->height };
    conversion *c = pv_allocate_zeroed(context, 1, sizeof *c, &result);
    if (!c)
        return result;
    c->image = image;
    c->photo = out;
    result = convert(context, c);
    pv_release(c);
    return result;
}

void pv_photo_free(pv_photo *photo)
{
    pv_release(photo->light);
    pv_release(photo->lab);
    pv_release(photo->hole);
    memset(photo, 0, sizeof *photo);
}
