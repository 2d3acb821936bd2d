/* Pixels of any image as colours for display. */
#include "image/pixel.h"

#include <math.h>

pv_pixels_of pv_pixels_begin(const pave_image *image)
{
    pv_pixels_of p = { image, 0, 0, 0, image->type == PAVE_U32 ? 4294967295.0 : 1, 0 };
    int32_t red = pv_image_channel(image, "R"), green = pv_image_channel(image, "G"),
            blue = pv_image_channel(image, "B");
    if (red >= 0 && green >= 0 && blue >= 0)
        p.red = red, p.green = green, p.blue = blue;
    p.plain = image->type == PAVE_U8 && image->encoding != PAVE_LINEAR && image->alpha < 0;
    return p;
}

/* Halley's iteration, for pow and cbrt differ between C libraries. */
static double cube_root(double v)
{
    double t = 1;
    for (int i = 0; i < 8; i++)
        t *= (t * t * t + 2 * v) / (2 * t * t * t + v);
    return t;
}

/* IEC 61966-2-1: v^(1/2.4) = v^(1/4) * v^(1/6). */
static double display(double linear)
{
    if (linear <= 0.0031308)
        return 12.92 * linear;
    double root = sqrt(linear < 1 ? linear : 1);
    return 1.055 * sqrt(root) * cube_root(root) - 0.055;
}

void pv_pixel_values(const pv_pixels_of *p, int64_t at, double values[3])
{
    const pave_image *image = p->image;
    int64_t first = at * image->channels;
    const int32_t channels[3] = { p->red, p->green, p->blue };
    double alpha = image->alpha < 0 ? 1 : pv_image_value(image, first + image->alpha) / p->full;
    for (int c = 0; c < 3; c++) {
        double v = pv_image_value(image, first + channels[c]) / p->full;
        if (alpha < 1)
            v = 1 + (v - 1) * alpha;
        values[c] = image->encoding == PAVE_LINEAR ? display(v) : v;
    }
}

static uint8_t whole(double v)
{
    return v >= 1 ? 255 : v > 0 ? (uint8_t)(v * 255 + 0.5) : 0;
}

pv_rgb pv_pixel_rgb(const pv_pixels_of *p, int64_t at)
{
    if (p->plain) {
        const uint8_t *first = (const uint8_t *)p->image->pixels + at * p->image->channels;
        return (pv_rgb){ first[p->red], first[p->green], first[p->blue] };
    }
    double values[3];
    pv_pixel_values(p, at, values);
    return (pv_rgb){ whole(values[0]), whole(values[1]), whole(values[2]) };
}
