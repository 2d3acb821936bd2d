/* The fields of a texture that its statistics are gathered from: lows, magnitudes, the coarser scale at the finer. */
#include "statistics/texture.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

static size_t size_of(const pv_texture *t, int32_t scale)
{
    return pv_level_size(&t->steerable, scale);
}

static pave_result make_scale(pave_context *context, pv_texture *t, int32_t scale)
{
    pave_result result = PAVE_OK;
    size_t n = size_of(t, scale);
    t->low[scale] = pv_allocate(context, n, sizeof *t->low[scale], &result);
    for (int32_t k = 0; k < t->steerable.orientations && scale < t->steerable.scales && !result; k++) {
        t->magnitude[scale][k] = pv_allocate(context, n, sizeof *t->magnitude[scale][k], &result);
        if (scale + 1 == t->steerable.scales)
            continue;
        if (!result)
            t->parent[scale][k] = pv_allocate(context, n, sizeof *t->parent[scale][k], &result);
        if (!result)
            t->doubled[scale][k] = pv_allocate(context, n, sizeof *t->doubled[scale][k], &result);
        if (!result)
            t->parent_magnitude[scale][k] = pv_allocate(context, n, sizeof *t->parent_magnitude[scale][k], &result);
    }
    return result;
}

pave_result pv_texture_create(pave_context *context, const pv_statistics *like, int32_t width, int32_t height,
                              pv_texture *out)
{
    memset(out, 0, sizeof *out);
    out->context = context, out->like = like;
    out->width = width, out->height = height;
    pave_result result = pv_steerable_create(context, width, height, like->settings.scales, like->settings.orientations,
                                             &out->steerable);
    if (!result)
        result = pv_pyramid_create(context, &out->steerable, &out->pyramid);
    for (int32_t s = 0; s <= like->settings.scales && !result; s++)
        result = make_scale(context, out, s);
    if (!result)
        out->rows = pv_allocate(context, (size_t)pv_workers(context) * (size_t)width, sizeof *out->rows, &result);
    for (int i = 0; i < 2 && !result; i++)
        out->room[i] = pv_allocate(context, size_of(out, 0), sizeof *out->room[i], &result);
    if (result)
        pv_texture_free(out);
    return result;
}

void pv_texture_free(pv_texture *texture)
{
    for (int32_t s = 0; s <= PV_MOST_SCALES; s++)
        pv_release(texture->low[s]);
    for (int32_t i = 0; i < PV_MOST_SCALES * PV_MOST_ORIENTATIONS; i++) {
        pv_release(texture->magnitude[i / PV_MOST_ORIENTATIONS][i % PV_MOST_ORIENTATIONS]);
        pv_release(texture->parent[i / PV_MOST_ORIENTATIONS][i % PV_MOST_ORIENTATIONS]);
        pv_release(texture->doubled[i / PV_MOST_ORIENTATIONS][i % PV_MOST_ORIENTATIONS]);
        pv_release(texture->parent_magnitude[i / PV_MOST_ORIENTATIONS][i % PV_MOST_ORIENTATIONS]);
    }
    pv_release(texture->rows);
    pv_release(texture->room[0]);
    pv_release(texture->room[1]);
    pv_pyramid_free(&texture->pyramid);
    pv_steerable_free(&texture->steerable);
    memset(texture, 0, sizeof *texture);
}

/* The absolute values less their mean, which is returned. */
static double take_magnitude(const pv_complex *band, size_t count, float *out)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        out[i] = sqrtf(band[i].r * band[i].r + band[i].i * band[i].i);
        sum += out[i];
    }
    double mean = sum / (double)count;
    for (size_t i = 0; i < count; i++)
        out[i] -= (float)mean;
    return mean;
}

/* The phase doubled, the magnitude kept. */
static inline pv_complex doubled_at(pv_complex z)
{
    float size = sqrtf(z.r * z.r + z.i * z.i);
    return size > 0 ? (pv_complex){ (z.r * z.r - z.i * z.i) / size, 2 * z.r * z.i / size } : (pv_complex){ 0, 0 };
}

/* How it changes with z: along z the magnitude does, across it the phase, twice as fast. */
static inline pv_complex doubled_change(pv_complex z, pv_complex change)
{
    float size = sqrtf(z.r * z.r + z.i * z.i);
    if (size <= 0)
        return (pv_complex){ 0, 0 };
    pv_complex u = { z.r / size, z.i / size }, v = { u.r * u.r - u.i * u.i, 2 * u.r * u.i };
    float along = u.r * change.r + u.i * change.i, across = 2 * (u.r * change.i - u.i * change.r);
    return (pv_complex){ along * v.r - across * v.i, along * v.i + across * v.r };
}

static double magnitude_change(const pv_complex *band, const pv_complex *change, size_t count, float *out)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        float size = sqrtf(band[i].r * band[i].r + band[i].i * band[i].i);
        out[i] = size > 0 ? (band[i].r * change[i].r + band[i].i * change[i].i) / size : 0;
        sum += out[i];
    }
    return sum / (double)count;
}

/* The fields of an orientation: of the bands, or of the coarser ones. Of a change, with what it is a change of. */
typedef struct taking {
    pv_texture *texture;
    const pv_texture *at;
    int32_t scale;
    int parents;
} taking;

static void take_parent(const taking *take, int32_t s, int32_t k)
{
    pv_texture *t = take->texture;
    size_t n = size_of(t, s);
    if (take->at) {
        magnitude_change(take->at->parent[s][k], t->parent[s][k], n, t->parent_magnitude[s][k]);
        for (size_t i = 0; i < n; i++)
            t->doubled[s][k][i] = doubled_change(take->at->parent[s][k][i], t->parent[s][k][i]);
        return;
    }
    take_magnitude(t->parent[s][k], n, t->parent_magnitude[s][k]);
    for (size_t i = 0; i < n; i++)
        t->doubled[s][k][i] = doubled_at(t->parent[s][k][i]);
}

static void take_task(void *data, int32_t k, int32_t worker)
{
    (void)worker;
    const taking *take = data;
    pv_texture *t = take->texture;
    int32_t s = take->scale;
    const pv_complex *band = t->pyramid.band[s][k];
    if (take->parents)
        take_parent(take, s, k);
    else if (take->at)
        t->mean_magnitude[s][k] =
            magnitude_change(take->at->pyramid.band[s][k], band, size_of(t, s), t->magnitude[s][k]);
    else
        t->mean_magnitude[s][k] = take_magnitude(band, size_of(t, s), t->magnitude[s][k]);
}

static pave_result take_magnitudes(pv_texture *t, const pv_texture *at, int32_t scale)
{
    taking take = { t, at, scale, 0 };
    return pv_parallel(t->context, t->steerable.orientations, take_task, &take, 0, 0);
}

static pave_result take_parents(pv_texture *t, const pv_texture *at, int32_t scale)
{
    taking take = { t, at, scale, 1 };
    pave_result result = PAVE_OK;
    if (scale + 1 >= t->steerable.scales)
        return PAVE_OK;
    for (int32_t k = 0; k < t->steerable.orientations && !result; k++) {
        memcpy(t->room[0], t->pyramid.band[scale + 1][k], size_of(t, scale + 1) * sizeof *t->room[0]);
        result = pv_fourier_forth(t->context, &t->steerable.level[scale + 1].fourier, 1, &t->room[0]);
        pv_steerable_expand(&t->steerable, scale + 1, t->room[0], t->parent[scale][k]);
    }
    if (!result)
        result = pv_fourier_back(t->context, &t->steerable.level[scale].fourier, t->steerable.orientations,
                                 t->parent[scale]);
    return result ? result : pv_parallel(t->context, t->steerable.orientations, take_task, &take, 0, 0);
}

static void take_low(pv_texture *t, int32_t scale)
{
    for (size_t i = 0; i < size_of(t, scale); i++)
        t->low[scale][i] = t->pyramid.low[scale][i].r;
}

static pave_result take_all(pv_texture *t, const pv_texture *at, const float *plane)
{
    double mean = pv_mean(plane, size_of(t, 0));
    pave_result result = pv_steerable_analyse(t->context, &t->steerable, plane, mean, &t->pyramid);
    for (int32_t s = 0; s <= t->steerable.scales && !result; s++) {
        take_low(t, s);
        if (s < t->steerable.scales)
            result = take_magnitudes(t, at, s);
        if (!result)
            result = take_parents(t, at, s);
    }
    return result;
}

pave_result pv_texture_magnitudes(pv_texture *texture, int32_t scale)
{
    return take_magnitudes(texture, NULL, scale);
}

pave_result pv_texture_parents(pv_texture *texture, int32_t scale)
{
    return take_parents(texture, NULL, scale);
}

pave_result pv_texture_analyse(pv_texture *texture, const float *plane)
{
    return take_all(texture, NULL, plane);
}

pave_result pv_texture_differentiate(const pv_texture *at, const float *direction, pv_texture *out)
{
    return take_all(out, at, direction);
}
