/* The joint statistics of planes: measured of some, imposed on others. */
#include "statistics/planes.h"

#include "base/parallel.h"
#include "statistics/periodic.h"
#include "statistics/texture.h"

#include <math.h>
#include <string.h>

enum {
    FEW = 10,           /* rounds, which are all of the paper's kind */
    SMALL = 128 * 128   /* pixels, whose round takes no longer than a task may */
};

static const double NEAR_ENOUGH = 0.005;

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

pave_result pv_check_finite(pave_context *context, int32_t width, int32_t height, int32_t channels,
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

static pave_result measure_torus(pave_context *context, const torus *t, pv_statistics *into)
{
    pv_texture texture;
    pv_company company = { 0 };
    pave_result result = pv_texture_create(context, into, t->width, t->height, &texture);
    if (!result && into->settings.cross)
        result = pv_company_create(context, into, t->width, t->height, t->planes, texture.company = &company);
    for (int32_t c = 0; c < t->channels && !result; c++) {
        result = pv_texture_analyse(&texture, plane_of(t, c));
        if (!result)
            result = pv_texture_gather(&texture, plane_of(t, c), c, into);
        if (!result)
            pv_company_keep(&texture, c);
    }
    pv_company_free(&company);
    pv_texture_free(&texture);
    return result;
}

static pave_result check_target(pave_context *context, const pv_statistics *wanted, int32_t width, int32_t height)
{
    int32_t side = width < height ? width : height;
    if ((int64_t)width * height > PV_MOST_TEXTURE)
        return pv_fail(context, PAVE_ERR_LIMIT, "a texture of %d x %d px is too large for statistics", (int)width,
                       (int)height);
    for (int32_t s = 0; s <= wanted->settings.scales; s++)
        if (side >> s < 2 * wanted->reach[s] + 2)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "%d x %d px are too few for statistics of %d scales with a "
                           "neighbourhood of %d", (int)width, (int)height, (int)wanted->settings.scales,
                           (int)wanted->settings.neighbourhood);
    return PAVE_OK;
}

/* The range is that of the planes as they were given. */
static void measure_ranges(int32_t width, int32_t height, const float *planes, pv_statistics *into)
{
    int64_t n = (int64_t)width * height;
    for (int32_t c = 0; c < into->channels; c++) {
        double *pixels = pv_statistics_at(into, PV_PIXELS, c, 0);
        pv_moments m = pv_moments_of(planes + c * n, (size_t)n);
        pixels[2] = m.least, pixels[3] = m.greatest;
    }
}

static pave_result measure_into(pave_context *context, int32_t width, int32_t height, const float *planes,
                                pv_statistics *into)
{
    torus t = { 0 };
    pave_result result = pv_check_finite(context, width, height, into->channels, planes);
    if (!result)
        result = cut_torus(context, width, height, into->channels, planes, into->settings.scales, &t);
    if (!result)
        result = measure_torus(context, &t, into);
    if (!result)
        measure_ranges(width, height, planes, into);
    pv_release(t.planes);
    return result;
}

static pave_result hand_over(pave_result result, pv_statistics *s, pv_statistics **out)
{
    if (result)
        pv_statistics_free(s);
    else
        *out = s;
    return result;
}

pave_result pv_statistics_measure(pave_context *context, int32_t width, int32_t height, int32_t channels,
                                  const float *planes, const pv_statistics_settings *settings, pv_statistics **out)
{
    pv_statistics *s = NULL;
    pave_result result = pv_statistics_create(context, width, height, channels, settings, &s);
    if (!result)
        result = measure_into(context, width, height, planes, s);
    return hand_over(result, s, out);
}

pave_result pv_statistics_measure_like(pave_context *context, const pv_statistics *like, int32_t width, int32_t height,
                                       const float *planes, pv_statistics **out)
{
    pv_statistics *s = NULL;
    pave_result result = check_target(context, like, width, height);
    if (!result)
        result = pv_statistics_create_like(context, like, &s);
    if (!result)
        result = measure_into(context, width, height, planes, s);
    return hand_over(result, s, out);
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

/* All channels of a torus to the covariance of their pixels. */
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
        double mean = pv_mean(planes[a], n);
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

/* A channel that knows of no other, done by one thread. */
typedef struct loner {
    pave_context context;
    pv_texture texture;
    pave_result result;
} loner;

/* What a run holds: a channel taken apart, room for changes of it, and what is between channels. */
typedef struct run {
    const pv_statistics *wanted;
    torus *torus;
    pv_texture texture, change;
    pv_company company;
    loner *loners;     /* of each worker; NULL: channels are done one after the other, each by all */
    pv_statistics *is; /* NULL: nobody asks, and no step is joint */
    int32_t steps;     /* conjugate gradients of the next joint step */
    int32_t in_turn, rounds;
} run;

/* Where channels are many and small, threads would rather wait for each other than work on the same one. */
static pave_result open_loners(pave_context *context, run *r)
{
    const torus *t = r->torus;
    pave_result result = PAVE_OK;
    if (r->wanted->settings.cross || t->channels < 2 || t->width * t->height > SMALL)
        return PAVE_OK;
    r->loners = pv_allocate_zeroed(context, (size_t)pv_workers(context), sizeof *r->loners, &result);
    for (int32_t w = 0; w < pv_workers(context) && !result; w++) {
        loner *l = &r->loners[w];
        result = pv_texture_create(context, r->wanted, t->width, t->height, &l->texture);
        pv_context_alone(context, &l->context);
        l->texture.context = &l->context;
    }
    return result;
}

static pave_result open_run(pave_context *context, run *r)
{
    torus *t = r->torus;
    pave_result result = pv_texture_create(context, r->wanted, t->width, t->height, &r->texture);
    if (!result)
        result = open_loners(context, r);
    if (!result && r->in_turn < r->rounds)
        result = pv_texture_create(context, r->wanted, t->width, t->height, &r->change);
    if (!result && r->wanted->settings.cross) {
        r->texture.company = r->change.company = &r->company;
        result = pv_company_create(context, r->wanted, t->width, t->height, t->planes, &r->company);
    }
    return result;
}

static void close_run(pave_context *context, run *r)
{
    for (int32_t w = 0; w < pv_workers(context) && r->loners; w++)
        pv_texture_free(&r->loners[w].texture);
    pv_release(r->loners);
    pv_texture_free(&r->texture);
    pv_texture_free(&r->change);
    pv_company_free(&r->company);
}

static void impose_alone(void *data, int32_t channel, int32_t worker)
{
    run *r = data;
    loner *l = &r->loners[worker];
    if (!l->result)
        l->result = pv_texture_impose(&l->texture, r->wanted, channel, plane_of(r->torus, channel));
}

static pave_result impose_at_once(pave_context *context, run *r, double from, double to)
{
    pave_result result = pv_parallel(context, r->torus->channels, impose_alone, r, from, to);
    for (int32_t w = 0; w < pv_workers(context) && !result; w++)
        if (r->loners[w].result)
            result = pv_fail(context, r->loners[w].result, "%s", r->loners[w].context.text);
    return result;
}

/* A round: in turn, or jointly. */
static pave_result impose_round(pave_context *context, run *r, int jointly, double from, double to)
{
    const torus *t = r->torus;
    pave_result result = PAVE_OK;
    if (!jointly && r->loners)
        return impose_at_once(context, r, from, to);
    for (int32_t c = 0; c < t->channels && !result; c++) {
        float *plane = plane_of(t, c);
        result = jointly ? pv_texture_approach(&r->texture, &r->change, r->wanted, c, plane, &r->steps, r->is)
                         : pv_texture_impose(&r->texture, r->wanted, c, plane);
        if (!result)
            result = pv_progress(context, from + (to - from) * (c + 1) / t->channels);
    }
    return result || jointly ? result : impose_channels(context, r->wanted, t);
}

/* The paper's projections in turn come near from anywhere, joint steps arrive. */
static pave_result impose_torus(pave_context *context, const pv_statistics *wanted, torus *t, int32_t iterations,
                                double from, double to, pv_statistics *is)
{
    run r = { .wanted = wanted, .torus = t, .is = is, .steps = 8, .rounds = iterations };
    int32_t in_turn = r.in_turn = iterations > FEW ? (2 * iterations + 4) / 5 : iterations;
    pave_result result = open_run(context, &r);
    for (int32_t i = 0; i < iterations && !result; i++) {
        double share = (to - from) / iterations;
        result = impose_round(context, &r, i >= in_turn, from + share * i, from + share * (i + 1));
        if (i >= in_turn && !result && pv_statistics_distance(wanted, is) < NEAR_ENOUGH)
            break;
    }
    close_run(context, &r);
    return result || !is || in_turn < iterations ? result : measure_torus(context, t, is);
}

pave_result pv_statistics_grow(pave_context *context, const pv_statistics *wanted, int32_t width, int32_t height,
                               float *planes, int32_t iterations, double from, double to, pv_statistics **is)
{
    torus t = { width, height, wanted->channels, planes };
    pave_result result = check_target(context, wanted, width, height);
    if (!result)
        result = pv_statistics_create_like(context, wanted, is);
    return result ? result : impose_torus(context, wanted, &t, iterations, from, to, *is);
}

/* Each channel as a torus and what is taken out for that. */
static pave_result make_toruses(pave_context *context, int32_t width, int32_t height, const float *planes, torus *t,
                                torus *smooth)
{
    pave_result result = make_torus(context, t->width, t->height, t->channels, t);
    if (!result)
        result = make_torus(context, t->width, t->height, t->channels, smooth);
    for (int32_t c = 0; c < t->channels && !result; c++) {
        float *plane = plane_of(t, c);
        reflect(planes + (int64_t)c * width * height, width, height, t, plane);
        result = pv_smooth_part(context, plane, t->width, t->height, plane_of(smooth, c));
        for (int64_t i = 0; i < (int64_t)t->width * t->height && !result; i++)
            plane[i] -= plane_of(smooth, c)[i];
    }
    return result;
}

pave_result pv_statistics_impose(pave_context *context, const pv_statistics *wanted, int32_t width, int32_t height,
                                 float *planes, int32_t iterations, double from, double to)
{
    int32_t channels = wanted->channels, step = 1 << wanted->settings.scales;
    int64_t size = (int64_t)width * height;
    torus t = { (width + step - 1) / step * step, (height + step - 1) / step * step, channels, NULL }, smooth = { 0 };
    pv_statistics *is = NULL;
    pave_result result = check_target(context, wanted, width, height);
    if (!result)
        result = pv_check_finite(context, width, height, channels, planes);
    if (!result)
        result = make_toruses(context, width, height, planes, &t, &smooth);
    if (!result && iterations > FEW)
        result = pv_statistics_create_like(context, wanted, &is);
    if (!result)
        result = impose_torus(context, wanted, &t, iterations, from, to, is);
    for (int64_t i = 0; i < size * channels && !result; i++) {
        int64_t at = i % size / width * t.width + i % width, c = i / size;
        planes[i] = plane_of(&t, (int32_t)c)[at] + plane_of(&smooth, (int32_t)c)[at];
    }
    pv_statistics_free(is);
    pv_release(t.planes);
    pv_release(smooth.planes);
    return result;
}
