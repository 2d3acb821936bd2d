/* The joint statistics of a texture: measured of one picture, imposed on another. */
#include "btf/statistics.h"

#include "btf/periodic.h"
#include "btf/texture.h"

#include <math.h>
#include <string.h>

/* Planes of a size that divides into scales, which repeat. */
typedef struct torus {
    int32_t width, height, channels;
    float *planes;
} torus;

static pave_result make_torus(pave_context *context, int32_t width, int32_t height, int32_t channels, torus *out)
{
    pave_result result = PAVE_OK;
    *out = (torus){ width, height, channels, NULL };
    out->planes = pv_allocate(context, (size_t)channels * (size_t)width, (size_t)height * sizeof(float), &result);
    return result;
}

static float *plane_of(const torus *t, int32_t channel)
{
    return t->planes + (int64_t)channel * t->width * t->height;
}

static pave_result check_finite(pave_context *context, int32_t width, int32_t height, int32_t channels,
                                const float *planes)
{
    int64_t n = (int64_t)width * height;
    for (int64_t i = 0; i < n * channels; i++)
        if (!isfinite(planes[i]) || fabsf(planes[i]) > 1e15f)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "channel %d at %d, %d: a texture's values must be finite and "
                           "below 1e15", (int)(i / n), (int)(i % n % width), (int)(i % n / width));
    return PAVE_OK;
}

/* The middle of the planes, of a size that divides, without what jumps at its borders. */
static pave_result cut_torus(pave_context *context, int32_t width, int32_t height, int32_t channels,
                             const float *planes, int32_t scales, torus *out)
{
    int32_t w = width >> scales << scales, h = height >> scales << scales, x = (width - w) / 2, y = (height - h) / 2;
    size_t n = (size_t)w * (size_t)h;
    pave_result result = make_torus(context, w, h, channels, out);
    float *smooth = result ? NULL : pv_allocate(context, n, sizeof *smooth, &result);
    for (int32_t c = 0; c < channels && !result; c++) {
        float *plane = plane_of(out, c);
        for (int32_t v = 0; v < h; v++)
            memcpy(plane + (int64_t)v * w, planes + ((int64_t)c * height + y + v) * width + x,
                   (size_t)w * sizeof *plane);
        result = pv_smooth_part(context, plane, w, h, smooth);
        for (size_t i = 0; i < n && !result; i++)
            plane[i] -= smooth[i];
    }
    pv_release(smooth);
    return result;
}

/* Covariances of pixels, each pair of channels once. */
static void measure_channels(const torus *t, pv_statistics *into)
{
    double *pairs = pv_statistics_at(into, PV_CHANNELS, 0, 0);
    for (int32_t a = 1; a < t->channels && pairs; a++)
        for (int32_t b = 0; b < a; b++) {
            double means = pv_statistics_at(into, PV_PIXELS, a, 0)[0] * pv_statistics_at(into, PV_PIXELS, b, 0)[0];
            *pairs++ = pv_mean_product(plane_of(t, a), plane_of(t, b), t->width, t->height, 0, 0) - means;
        }
}

static pave_result measure_torus(pave_context *context, const torus *t, pv_statistics *into)
{
    pv_texture texture;
    pave_result result = pv_texture_create(context, into, t->width, t->height, &texture);
    for (int32_t c = 0; c < t->channels && !result; c++) {
        result = pv_texture_analyse(&texture, plane_of(t, c));
        if (!result)
            result = pv_texture_gather(&texture, plane_of(t, c), c, into);
    }
    if (!result)
        measure_channels(t, into);
    pv_texture_free(&texture);
    return result;
}

pave_result pv_statistics_measure(pave_context *context, int32_t width, int32_t height, int32_t channels,
                                  const float *planes, const pv_statistics_settings *settings, pv_statistics **out)
{
    torus t = { 0 };
    pv_statistics *s = NULL;
    pave_result result = pv_statistics_create(context, width, height, channels, settings, &s);
    if (!result)
        result = check_finite(context, width, height, channels, planes);
    if (!result)
        result = cut_torus(context, width, height, channels, planes, settings->scales, &t);
    if (!result)
        result = measure_torus(context, &t, s);
    pv_release(t.planes);
    if (result)
        pv_statistics_free(s);
    else
        *out = s;
    return result;
}

/* The plane within a torus that is larger where its size does not divide: its borders are reflected. */
static void reflect(const float *plane, int32_t width, int32_t height, const torus *t, float *out)
{
    for (int32_t y = 0; y < t->height; y++)
        for (int32_t x = 0; x < t->width; x++) {
            int32_t u = x < width ? x : 2 * width - 1 - x, v = y < height ? y : 2 * height - 1 - y;
            out[(int64_t)y * t->width + x] = plane[(int64_t)v * width + u];
        }
}

/* All channels of a torus nearer to the covariance of their pixels. */
static pave_result impose_channels(pave_context *context, const pv_statistics *wanted, const torus *t)
{
    size_t n = (size_t)t->width * (size_t)t->height, channels = (size_t)t->channels;
    const double *pairs = pv_statistics_at(wanted, PV_CHANNELS, 0, 0);
    pave_result result = PAVE_OK;
    if (!pairs || t->channels < 2)
        return PAVE_OK;
    double *among = pv_allocate(context, channels * channels, sizeof *among, &result);
    float **planes = result ? NULL : pv_allocate(context, channels, sizeof *planes, &result);
    for (int32_t a = 0; a < t->channels && !result; a++) {
        const double *pixels = pv_statistics_at(wanted, PV_PIXELS, a, 0);
        planes[a] = plane_of(t, a);
        among[a * t->channels + a] = pixels[1] * pixels[1];
        for (int32_t b = 0; b < a; b++)
            among[a * t->channels + b] = among[b * t->channels + a] = pairs[a * (a - 1) / 2 + b];
        double mean = pv_moments_of(planes[a], n).mean;
        for (size_t i = 0; i < n; i++)
            planes[a][i] -= (float)mean;
    }
    if (!result)
        result = pv_impose_covariance(context, t->channels, planes, 0, NULL, n, among, NULL);
    for (int32_t a = 0; a < t->channels && !result; a++) {
        const double *pixels = pv_statistics_at(wanted, PV_PIXELS, a, 0);
        for (size_t i = 0; i < n; i++)
            planes[a][i] = fminf(fmaxf(planes[a][i] + (float)pixels[0], (float)pixels[2]), (float)pixels[3]);
    }
    pv_release(among);
    pv_release(planes);
    return result;
}

static pave_result impose_torus(pave_context *context, const pv_statistics *wanted, const torus *t, int32_t iterations,
                                double from, double to)
{
    pv_texture texture;
    pave_result result = pv_texture_create(context, wanted, t->width, t->height, &texture);
    for (int32_t i = 0; i < iterations && !result; i++) {
        for (int32_t c = 0; c < t->channels && !result; c++) {
            double done = (i + (c + 1.0) / t->channels) / iterations;
            result = pv_texture_impose(&texture, wanted, c, plane_of(t, c));
            if (!result)
                result = pv_progress(context, from + (to - from) * done);
        }
        if (!result)
            result = impose_channels(context, wanted, t);
    }
    pv_texture_free(&texture);
    return result;
}

static pave_result check_target(pave_context *context, const pv_statistics *wanted, int32_t width, int32_t height)
{
    int32_t side = width < height ? width : height;
    for (int32_t s = 0; s <= wanted->settings.scales; s++)
        if (side >> s < 2 * wanted->reach[s] + 2)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "%d x %d px are too few for statistics of %d scales with a "
                           "neighbourhood of %d", (int)width, (int)height, (int)wanted->settings.scales,
                           (int)wanted->settings.neighbourhood);
    return PAVE_OK;
}

pave_result pv_statistics_impose(pave_context *context, const pv_statistics *wanted, int32_t width, int32_t height,
                                 float *planes, int32_t iterations, double from, double to)
{
    int32_t scales = wanted->settings.scales, channels = wanted->channels, step = 1 << scales;
    int64_t size = (int64_t)width * height;
    torus t = { 0 }, smooth = { 0 };
    pave_result result = check_target(context, wanted, width, height);
    if (!result)
        result = check_finite(context, width, height, channels, planes);
    if (!result)
        result = make_torus(context, (width + step - 1) / step * step, (height + step - 1) / step * step, channels, &t);
    if (!result)
        result = make_torus(context, t.width, t.height, channels, &smooth);
    size_t n = (size_t)t.width * (size_t)t.height;
    for (int32_t c = 0; c < channels && !result; c++) {
        reflect(planes + c * size, width, height, &t, plane_of(&t, c));
        result = pv_smooth_part(context, plane_of(&t, c), t.width, t.height, plane_of(&smooth, c));
        for (size_t i = 0; i < n && !result; i++)
            plane_of(&t, c)[i] -= plane_of(&smooth, c)[i];
    }
    if (!result)
        result = impose_torus(context, wanted, &t, iterations, from, to);
    for (int32_t c = 0; c < channels && !result; c++)
        for (int64_t i = 0; i < size; i++) {
            int64_t at = i / width * t.width + i % width;
            planes[c * size + i] = plane_of(&t, c)[at] + plane_of(&smooth, c)[at];
        }
    pv_release(t.planes);
    pv_release(smooth.planes);
    return result;
}
