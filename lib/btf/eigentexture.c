/* The sample as eigen-ABRDFs and coefficients (Steinhausen 2014, Eqs. 8 and 9), found texel by texel. */
#include "btf/enlarge.h"

#include "btf/factor.h"
#include "base/parallel.h"

#include <math.h>
#include <string.h>

pave_result pv_texels_new(pave_context *context, int32_t width, int32_t height, int32_t channels, pv_texels *out)
{
    pave_result result = PAVE_OK;
    *out = (pv_texels){ width, height, channels, NULL };
    out->values = pv_allocate(context, (size_t)pv_texels_count(out), (size_t)channels * sizeof *out->values, &result);
    return result;
}

/* Grey light is added until luminance, or a channel that stands for itself, is not below the least. */
void pv_enlarge_encode(const pv_enlarge *e, const float *samples, int64_t count, float *out)
{
    int32_t channels = e->sample->channels;
    float least = (float)e->params->epsilon, lifted[PV_BTF_CHANNELS];
    for (int64_t i = 0; i < count; i++, samples += channels, out += channels) {
        for (int32_t c = 0; c < channels; c++)
            lifted[c] = fmaxf(samples[c], e->out->colour == PV_COLOUR_LOG ? least : 0);
        if (e->out->colour == PV_COLOUR_LOG_YUV) {
            float more = fmaxf(least - (0.299f * lifted[0] + 0.587f * lifted[1] + 0.114f * lifted[2]), 0);
            for (int32_t c = 0; c < 3; c++)
                lifted[c] += more;
        }
        pv_colour_encode(e->out->colour, PV_LEAST_LIGHT, channels,
                         e->out->colour == PV_COLOUR_RGB ? samples : lifted, 1, out);
    }
}

typedef struct reading {
    pv_enlarge *e;
    float *room; /* two texels for each worker */
} reading;

static int read_texel(void *user, int64_t texel, int32_t worker, float *const *out)
{
    const reading *r = user;
    const pave_btf *sample = r->e->sample;
    int64_t length = pv_btf_length(sample), pairs = length / sample->channels;
    float *samples = r->room + worker * 2 * length, *values = samples + length;
    pave_btf_abrdf(sample, (int32_t)(texel % sample->width), (int32_t)(texel / sample->width), samples);
    pv_enlarge_encode(r->e, samples, pairs, values);
    for (int32_t c = 0; c < r->e->planes; c++)
        for (int64_t p = 0; p < pairs; p++)
            out[c][p] = values[p * r->e->planes + c];
    return pv_all_finite(samples, length);
}

static pave_result refuse_texel(pave_context *context, void *user, int64_t texel)
{
    const reading *r = user;
    return pv_fail(context, PAVE_ERR_FORMAT, "the sample's texel %lld,%lld has samples that are infinite or no numbers",
                   (long long)(texel % r->e->sample->width), (long long)(texel / r->e->sample->width));
}

/* The right factors, side by side: a texel's coefficients of all planes. */
static pave_result take_coefficients(pv_enlarge *e)
{
    for (int32_t c = 0; c < e->planes; c++)
        e->first[c + 1] = e->first[c] + e->out->factors[c].components;
    e->coefficients = e->first[e->planes];
    pave_result result = pv_texels_new(e->context, e->sample->width, e->sample->height, e->coefficients, &e->known);
    for (int32_t c = 0; c < e->planes && !result; c++) {
        pv_factors *f = &e->out->factors[c];
        for (int64_t t = 0; t < pv_texels_count(&e->known); t++)
            memcpy(e->known.values + t * e->coefficients + e->first[c], f->right + t * f->components,
                   (size_t)f->components * sizeof(float));
        pv_release(f->right);
        f->right = NULL;
    }
    return result;
}

static pave_result find_moments(pv_enlarge *e)
{
    pave_result result = PAVE_OK;
    int32_t n = e->coefficients;
    int64_t texels = pv_texels_count(&e->known);
    e->middle = pv_allocate_zeroed(e->context, (size_t)n, sizeof *e->middle, &result);
    if (!result)
        e->spread = pv_allocate(e->context, (size_t)n, (size_t)n * sizeof *e->spread, &result);
    if (!result)
        result = pv_gram(e->context, &e->algebra, texels, n, e->known.values, e->spread);
    for (int64_t t = 0; t < texels && !result; t++)
        for (int32_t k = 0; k < n; k++)
            e->middle[k] += (double)e->known.values[t * n + k] / (double)texels;
    for (int32_t i = 0; i < n && !result; i++)
        for (int32_t k = 0; k < n; k++)
            e->spread[i * n + k] = e->spread[i * n + k] / (double)texels - e->middle[i] * e->middle[k];
    return result;
}

pave_result pv_enlarge_factor(pv_enlarge *e)
{
    const pave_btf *sample = e->sample;
    const pave_btf_enlarge_params *params = e->params;
    int32_t half = (params->components + 1) / 2, components[PV_BTF_CHANNELS];
    reading r = { .e = e };
    const pv_columns columns = { e->planes, pv_btf_rows(e->out), pv_btf_texels(sample), read_texel, refuse_texel, &r };
    pave_result result = PAVE_OK;
    for (int32_t c = 0; c < e->planes; c++)
        components[c] = e->out->colour != PV_COLOUR_LOG_YUV || !c ? params->components
                        : params->chroma ? params->chroma : half;
    r.room = pv_allocate(e->context, (size_t)pv_workers(e->context), 2 * (size_t)pv_btf_length(sample) * sizeof *r.room,
                         &result);
    if (!result)
        e->out->factors = pv_allocate_zeroed(e->context, (size_t)e->planes, sizeof *e->out->factors, &result);
    if (!result)
        result = pv_factor(e->context, &e->algebra, &columns, components, 0, params->passes, e->out->factors);
    pv_release(r.room);
    if (!result)
        result = take_coefficients(e);
    return result ? result : find_moments(e);
}
