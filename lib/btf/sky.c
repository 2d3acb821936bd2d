/* An environment as light: cells of the sky, coarse enough to be looked up for each lamp of a BTF. */
#include "btf/sky.h"

#include "image/image.h"
#include "util/light.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

enum { SKY = 64 };

/* Between the middles of four cells, around the horizon and up to the poles. */
void pv_sky_look(const pv_sky *around, const double d[3], double *out)
{
    int32_t channels = around->channels;
    double y = acos(fmin(fmax(d[1], -1), 1)) / pi * (SKY / 2) - 0.5;
    double x = (atan2(d[0], d[2]) / pi + 1) / 2 * SKY - 0.5, fx = x - floor(x), fy = y - floor(y);
    int32_t x0 = ((int32_t)floor(x) + SKY) % SKY, x1 = (x0 + 1) % SKY;
    int32_t y0 = y < 0 ? 0 : (int32_t)y, y1 = (int32_t)floor(y) + 1;
    y1 = y1 < SKY / 2 ? y1 : SKY / 2 - 1;
    const double *a = around->radiance + (int64_t)y0 * SKY * channels;
    const double *b = around->radiance + (int64_t)y1 * SKY * channels;
    for (int32_t c = 0; c < channels; c++) {
        double above = (1 - fx) * a[x0 * channels + c] + fx * a[x1 * channels + c];
        double below = (1 - fx) * b[x0 * channels + c] + fx * b[x1 * channels + c];
        out[c] = (1 - fy) * above + fy * below;
    }
}

static double light_of(const pave_image *image, int32_t x, int32_t y, int32_t channel)
{
    double value = pv_image_value(image, ((int64_t)y * image->width + x) * image->channels + channel);
    return image->encoding == PAVE_DISPLAY ? pv_linear_light(value) : value;
}

/* The mean light of a cell of the sky, at least one pixel of it. */
static double mean_light(const pave_image *image, int32_t cell, int32_t channel)
{
    int32_t w = image->width, h = image->height, column = cell % SKY, row = cell / SKY;
    int32_t x0 = (int32_t)((int64_t)column * w / SKY), x1 = (int32_t)((int64_t)(column + 1) * w / SKY);
    int32_t y0 = (int32_t)((int64_t)row * h * 2 / SKY), y1 = (int32_t)((int64_t)(row + 1) * h * 2 / SKY);
    double sum = 0, count = 0;
    x1 = x1 > x0 ? x1 : x0 + 1;
    y1 = y1 > y0 ? y1 : y0 + 1;
    for (int32_t y = y0; y < y1; y++)
        for (int32_t x = x0; x < x1; x++, count++)
            sum += light_of(image, x, y, channel);
    return sum / count;
}

pave_result pv_sky_open(pave_context *context, const pave_btf *btf, const pave_image *image, pv_sky *out)
{
    pave_result result = PAVE_OK;
    int32_t channels = out->channels = btf->channels;
    out->radiance = pv_allocate(context, SKY * SKY / 2, (size_t)channels * sizeof *out->radiance, &result);
    if (!result)
        out->share = pv_allocate(context, (size_t)btf->lights.count, sizeof *out->share, &result);
    if (result)
        return result;
    for (int32_t i = 0; i < SKY * SKY / 2 * channels; i++) /* a grey sky lights all channels alike */
        out->radiance[i] = mean_light(image, i / channels, image->channels >= channels ? i % channels : 0);
    pv_directions_share(&btf->lights, out->share);
    return PAVE_OK;
}

void pv_sky_close(pv_sky *sky)
{
    pv_release(sky->radiance);
    pv_release(sky->share);
}
