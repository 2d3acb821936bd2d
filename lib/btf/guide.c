/* Photographs of the whole as guides (Steinhausen 2014, 3.2): what they show of each texel, and what the sample would
 * show on them. The picture under even light (Eq. 10) is a mean of linear samples, here and there. */
#include "btf/enlarge.h"

#include "base/parallel.h"
#include "image/image.h"
#include "util/light.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;

/* ---- Which photographs there are ---- */

/* All that were taken, in their order; with a plan only those that are in it. */
static pave_result list_pairs(pv_enlarge *e, const int32_t *view, const int32_t *light, const uint8_t *wanted)
{
    const pave_btf *photos = e->photos;
    pave_result result = PAVE_OK;
    size_t pairs = (size_t)photos->views.count * (size_t)photos->lights.count;
    e->given_pair = pv_allocate(e->context, pairs, sizeof *e->given_pair, &result);
    if (!result)
        e->sample_pair = pv_allocate(e->context, pairs, sizeof *e->sample_pair, &result);
    for (int32_t p = 0; p < (int32_t)pairs && !result; p++) {
        if ((photos->missing && photos->missing[p]) || (wanted && !wanted[p]))
            continue;
        e->given_pair[e->photographs] = p;
        e->sample_pair[e->photographs++] = view[p / photos->lights.count] * e->sample->lights.count +
                                           light[p % photos->lights.count];
    }
    return result;
}

static pave_result find_pairs(pv_enlarge *e)
{
    const pave_btf *photos = e->photos;
    pave_result result = PAVE_OK;
    int32_t *view = pv_allocate(e->context, (size_t)photos->views.count, sizeof *view, &result), *light = NULL;
    uint8_t *wanted = NULL;
    if (!result)
        light = pv_allocate(e->context, (size_t)photos->lights.count, sizeof *light, &result);
    if (!result && e->plan)
        wanted = pv_allocate_zeroed(e->context, (size_t)photos->views.count, (size_t)photos->lights.count, &result);
    if (!result)
        result = pv_directions_match(e->context, "the sample", "view", &photos->views, &e->sample->views, view);
    if (!result)
        result = pv_directions_match(e->context, "the sample", "light", &photos->lights, &e->sample->lights, light);
    if (!result && e->plan)
        result = pv_plan_mark(e->context, e->plan, e->params->samples, "the photographs have", photos->views.count,
                              photos->lights.count, wanted);
    if (!result)
        result = list_pairs(e, view, light, wanted);
    pv_release(view);
    pv_release(light);
    pv_release(wanted);
    return result;
}

/* ---- What they show ---- */

static void put(const pv_enlarge *e, pv_texels *to, int64_t texel, int32_t photograph, float *samples)
{
    pv_enlarge_encode(e, samples, 1, to->values + texel * to->channels + (int64_t)photograph * e->planes);
}

/* The mean over all lights from a view. */
static void under_even_light(const pave_btf *sample, int64_t texel, int32_t view, float *room, float *out)
{
    int32_t channels = sample->channels, lights = sample->lights.count;
    double sum[PV_BTF_CHANNELS] = { 0 };
    pv_btf_from_view(sample, texel, view, room);
    for (int32_t i = 0; i < lights * channels; i++)
        sum[i % channels] += (double)room[i];
    for (int32_t c = 0; c < channels; c++)
        out[c] = (float)(sum[c] / lights);
}

typedef struct seeing {
    const pv_enlarge *e;
    const pv_turned *copy;
    int32_t top; /* view */
    float *room; /* a texel from one view, for each worker */
    pv_texels *out;
} seeing;

static void see_texel(void *data, int32_t texel, int32_t worker)
{
    const seeing *s = data;
    const pv_enlarge *e = s->e;
    const pave_btf *sample = e->sample;
    const int32_t *view = s->copy->view, *light = s->copy->light;
    int32_t lights = sample->lights.count;
    float samples[PV_BTF_CHANNELS];
    for (int32_t i = 0; i < e->photographs; i++) {
        int32_t pair = e->sample_pair[i];
        pv_btf_sample(sample, texel, view[pair / lights] * lights + light[pair % lights], samples);
        put(e, s->out, texel, i, samples);
    }
    if (e->mean) {
        under_even_light(sample, texel, view[s->top], s->room + (int64_t)worker * lights * sample->channels, samples);
        put(e, s->out, texel, e->photographs, samples);
    }
    pv_btf_leave(sample, texel);
}

pave_result pv_enlarge_see(const pv_enlarge *e, const pv_turned *copy, pv_texels *out)
{
    const pave_btf *sample = e->sample;
    seeing s = { .e = e, .copy = copy, .out = out };
    s.top = pv_directions_nearest(&sample->views, (pave_direction){ 0, 0 }, &(double){ 0 });
    pave_result result = pv_texels_new(e->context, sample->width, sample->height, e->guides, out);
    if (!result)
        s.room = pv_allocate(e->context, (size_t)pv_workers(e->context),
                             (size_t)sample->lights.count * (size_t)sample->channels * sizeof *s.room, &result);
    if (!result)
        result = pv_parallel(e->context, (int32_t)pv_texels_count(out), see_texel, &s, 0, 0);
    pv_release(s.room);
    return result;
}

typedef struct showing {
    pv_enlarge *e;
    uint8_t *bad; /* [texel of the whole]: some photograph has no number there */
} showing;

static float linear_value(const pave_image *image, int64_t index)
{
    double value = pv_image_value(image, index);
    return (float)(image->encoding == PAVE_LINEAR ? value : pv_linear_light(value));
}

static void show_given(void *data, int32_t texel, int32_t worker)
{
    (void)worker;
    const showing *s = data;
    pv_enlarge *e = s->e;
    int32_t channels = e->sample->channels;
    float samples[PV_BTF_CHANNELS];
    for (int32_t i = 0; i < e->photographs; i++) {
        pv_btf_sample(e->photos, texel, e->given_pair[i], samples);
        s->bad[texel] |= !pv_all_finite(samples, channels);
        put(e, &e->given, texel, i, samples);
    }
    if (e->photos)
        pv_btf_leave(e->photos, texel);
    for (int32_t c = 0; c < channels && e->mean; c++)
        samples[c] = linear_value(e->mean, (int64_t)texel * e->mean->channels + c);
    if (e->mean) {
        s->bad[texel] |= !pv_all_finite(samples, channels);
        put(e, &e->given, texel, e->photographs, samples);
    }
}

static pave_result refuse_bad(const pv_enlarge *e, const uint8_t *bad)
{
    for (int64_t t = 0; t < pv_texels_count(&e->given); t++)
        if (bad[t])
            return pv_fail(e->context, PAVE_ERR_FORMAT, "texel %lld,%lld of a photograph is infinite or no number",
                           (long long)(t % e->given.width), (long long)(t / e->given.width));
    return PAVE_OK;
}

static pave_result show_all(pv_enlarge *e)
{
    showing s = { .e = e };
    int64_t whole = pv_texels_count(&e->given);
    pave_result result = PAVE_OK;
    s.bad = pv_allocate_zeroed(e->context, (size_t)whole, 1, &result);
    if (!result)
        result = pv_parallel(e->context, (int32_t)whole, show_given, &s, 0, 0);
    if (!result)
        result = refuse_bad(e, s.bad);
    pv_release(s.bad);
    return result;
}

/* ---- How coefficients and photographs hang together ---- */

/* The row that the sample itself suggests, where none of the basis is meant: least squares with an offset. */
static pave_result fit_row(pv_enlarge *e, int32_t g)
{
    pv_guide *guide = &e->guide[g];
    int32_t n = e->coefficients, first = e->first[guide->plane], k = e->first[guide->plane + 1] - first;
    int64_t texels = pv_texels_count(&e->known);
    double mean = 0;
    pave_result result = PAVE_OK;
    double *matrix = pv_allocate(e->context, (size_t)k, (size_t)k * sizeof *matrix, &result), *side = NULL;
    if (!result)
        side = pv_allocate_zeroed(e->context, (size_t)k, sizeof *side, &result);
    if (!result)
        guide->own = pv_allocate(e->context, (size_t)k, sizeof *guide->own, &result);
    for (int64_t t = 0; t < texels && !result; t++)
        mean += (double)e->seen.values[t * e->guides + g] / (double)texels;
    for (int64_t t = 0; t < texels && !result; t++)
        for (int32_t i = 0; i < k; i++)
            side[i] += ((double)e->seen.values[t * e->guides + g] - mean) *
                       ((double)e->known.values[t * n + first + i] - e->middle[first + i]) / (double)texels;
    for (int32_t i = 0; i < k && !result; i++)
        for (int32_t j = 0; j < k; j++)
            matrix[i * k + j] = e->spread[(int64_t)(first + i) * n + first + j] +
                                (i == j ? 1e-9 + 1e-6 * e->spread[(int64_t)first * n + first] : 0);
    if (!result && !pv_solve_positive(&e->algebra, k, matrix, 1, side))
        memset(side, 0, (size_t)k * sizeof *side);
    guide->offset = mean;
    for (int32_t i = 0; i < k && !result; i++) {
        guide->own[i] = (float)side[i];
        guide->offset -= side[i] * e->middle[first + i];
    }
    guide->row = guide->own;
    pv_release(matrix);
    pv_release(side);
    return result;
}

/* What the row leaves of the sample: the noise of what it says. */
static void find_noise(pv_enlarge *e, int32_t g)
{
    pv_guide *guide = &e->guide[g];
    int32_t first = e->first[guide->plane], k = e->first[guide->plane + 1] - first;
    int64_t texels = pv_texels_count(&e->known);
    guide->noise = 1e-8;
    for (int64_t t = 0; t < texels; t++) {
        double left = (double)e->seen.values[t * e->guides + g] - guide->offset;
        for (int32_t i = 0; i < k; i++)
            left -= (double)guide->row[i] * (double)e->known.values[t * e->coefficients + first + i];
        guide->noise += left * left / (double)texels;
    }
}

static pave_result find_rows(pv_enlarge *e)
{
    pave_result result = PAVE_OK;
    e->guide = pv_allocate_zeroed(e->context, (size_t)e->guides, sizeof *e->guide, &result);
    for (int32_t g = 0; g < e->guides && !result; g++) {
        int32_t photograph = g / e->planes, plane = e->guide[g].plane = g % e->planes;
        const pv_factors *f = &e->out->factors[plane];
        if (photograph < e->photographs)
            e->guide[g].row = f->left + (int64_t)e->sample_pair[photograph] * f->components;
        else
            result = fit_row(e, g);
        if (!result)
            find_noise(e, g);
    }
    return result;
}

/* ---- Whether they belong together ---- */

static void moments(const pv_texels *t, int32_t channel, double *mean, double *variance)
{
    double sum = 0, square = 0, count = (double)pv_texels_count(t);
    for (int64_t i = 0; i < pv_texels_count(t); i++) {
        double value = (double)t->values[i * t->channels + channel];
        sum += value;
        square += value * value;
    }
    *mean = sum / count;
    *variance = fmax(square / count - *mean * *mean, 0);
}

/* A photograph by its directions: "of view 0, 0 under light 30, 90". */
static void name_photograph(const pv_enlarge *e, int32_t i, char *out, size_t room)
{
    if (i == e->photographs) {
        snprintf(out, room, "the picture under even light");
        return;
    }
    const pave_direction *v = &e->photos->views.direction[e->given_pair[i] / e->photos->lights.count];
    const pave_direction *l = &e->photos->lights.direction[e->given_pair[i] % e->photos->lights.count];
    snprintf(out, room, "the photograph from view %.0f,%.0f under light %.0f,%.0f", (double)v->theta / degree,
             (double)v->phi / degree, (double)l->theta / degree, (double)l->phi / degree);
}

/* Root mean square difference of a guide where the sample lies within the whole. */
static double mismatch(const pv_enlarge *e, int32_t g)
{
    double sum = 0;
    for (int64_t t = 0; t < pv_texels_count(&e->seen); t++) {
        int64_t x = t % e->seen.width + e->params->x, y = t / e->seen.width + e->params->y;
        double apart = (double)e->seen.values[t * e->guides + g] -
                       (double)e->given.values[(y * e->given.width + x) * e->guides + g];
        sum += apart * apart;
    }
    return sqrt(sum / (double)pv_texels_count(&e->seen));
}

static pave_result check_photograph(const pv_enlarge *e, int32_t i)
{
    char name[120];
    double mean, variance, own_mean, own_variance;
    int32_t g = i * e->planes;
    name_photograph(e, i, name, sizeof name);
    moments(&e->given, g, &mean, &variance);
    moments(&e->seen, g, &own_mean, &own_variance);
    int is_log = e->out->colour != PV_COLOUR_RGB;
    if (is_log && variance == 0 && mean <= log(e->params->epsilon + (double)PV_LEAST_LIGHT) + 1e-4)
        return pv_fail(e->context, PAVE_ERR_ARGUMENT, "%s is black: it says nothing", name);
    if (e->params->x >= 0 && mismatch(e, g) > 1.2 * sqrt(own_variance + e->guide[g].noise) + 0.02)
        return pv_fail(e->context, PAVE_ERR_ARGUMENT, "%s contradicts the sample at %d,%d: the root mean square "
                       "difference is %.3g, and the sample itself varies by %.3g", name, (int)e->params->x,
                       (int)e->params->y, mismatch(e, g), sqrt(own_variance));
    if (fabs(mean - own_mean) > 3 * sqrt(own_variance + variance) + 0.5)
        return pv_fail(e->context, PAVE_ERR_ARGUMENT, "%s contradicts the sample: its mean is %.3g, and the sample's "
                       "under the same light %.3g", name, mean, own_mean);
    return PAVE_OK;
}

static pave_result check_size(const pv_enlarge *e, const char *what, int32_t width, int32_t height)
{
    if (width < e->sample->width || height < e->sample->height)
        return pv_fail(e->context, PAVE_ERR_ARGUMENT, "%s %d x %d texels, fewer than the sample's %d x %d", what,
                       (int)width, (int)height, (int)e->sample->width, (int)e->sample->height);
    if (width != e->out->width || height != e->out->height)
        return pv_fail(e->context, PAVE_ERR_ARGUMENT, "%s %d x %d texels, and the photographs have %d x %d", what,
                       (int)width, (int)height, (int)e->out->width, (int)e->out->height);
    return PAVE_OK;
}

pave_result pv_enlarge_guide(pv_enlarge *e)
{
    pave_result result = check_size(e, "the photographs have", e->out->width, e->out->height);
    if (!result && e->mean)
        result = check_size(e, "the picture under even light has", e->mean->width, e->mean->height);
    if (!result && e->photos)
        result = find_pairs(e);
    e->guides = (e->photographs + (e->mean != NULL)) * e->planes;
    if (!result && !e->guides)
        result = pv_fail(e->context, PAVE_ERR_ARGUMENT, "there is not one photograph");
    if (!result)
        result = pv_enlarge_copy(e);
    if (!result)
        result = pv_texels_new(e->context, e->out->width, e->out->height, e->guides, &e->given);
    if (!result)
        result = show_all(e);
    if (!result)
        result = find_rows(e);
    for (int32_t i = 0; i * e->planes < e->guides && !result; i++)
        result = check_photograph(e, i);
    return result;
}
