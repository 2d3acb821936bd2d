/* What was measured of a BTF: which pairs of the model's, and their values. */
#include "btf/rebuild.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { ROUNDS = 30 };

/* Which samples of `sparse` stand for which of the model's pairs. */
static void list_pairs(pv_rebuild *r, const int32_t *view, const int32_t *light, const uint8_t *wanted)
{
    const pave_btf *sparse = r->sparse;
    for (int32_t v = 0; v < sparse->views.count; v++)
        for (int32_t l = 0; l < sparse->lights.count; l++) {
            int32_t given = v * sparse->lights.count + l, pair = view[v] * r->model->lights.count + light[l];
            if ((sparse->missing && sparse->missing[given]) || (wanted && !wanted[pair]))
                continue;
            r->given[r->samples] = given;
            r->pair[r->samples++] = pair;
        }
}

static pave_result find_pairs(pv_rebuild *r, const pave_btf_plan *plan)
{
    pave_context *context = r->context;
    size_t pairs = (size_t)r->sparse->views.count * (size_t)r->sparse->lights.count;
    pave_result result = PAVE_OK;
    int32_t *view = pv_allocate(context, (size_t)r->sparse->views.count, sizeof *view, &result), *light = NULL;
    uint8_t *wanted = NULL;
    if (!result)
        light = pv_allocate(context, (size_t)r->sparse->lights.count, sizeof *light, &result);
    if (!result)
        r->pair = pv_allocate(context, pairs, sizeof *r->pair, &result);
    if (!result)
        r->given = pv_allocate(context, pairs, sizeof *r->given, &result);
    if (!result && plan)
        wanted = pv_allocate_zeroed(context, (size_t)pv_model_pairs(r->model), 1, &result);
    if (!result)
        result = pv_directions_match(context, "the model", "view", &r->sparse->views, &r->model->views, view);
    if (!result)
        result = pv_directions_match(context, "the model", "light", &r->sparse->lights, &r->model->lights, light);
    if (!result && plan)
        result = pv_plan_mark(context, plan, r->params->samples, "the model has", r->model->views.count,
                              r->model->lights.count, wanted);
    if (!result)
        list_pairs(r, view, light, wanted);
    pv_release(view);
    pv_release(light);
    pv_release(wanted);
    if (!result && !r->samples)
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "not one pair of view and light was measured%s",
                         plan ? " of those that were planned" : "");
    return result;
}

static void read_texel(void *data, int32_t texel, int32_t worker)
{
    (void)worker;
    pv_rebuild *r = data;
    const pave_btf_model *model = r->model;
    int64_t pairs = pv_model_pairs(model);
    float sample[PV_BTF_CHANNELS], value[PV_BTF_CHANNELS];
    for (int32_t i = 0; i < r->samples; i++) {
        pv_btf_sample(r->sparse, texel, r->given[i], sample);
        int fine = pv_all_finite(sample, model->channels);
        r->bad[texel] |= !fine;
        pv_colour_encode(model->colour, model->least, model->channels, sample, 1, value);
        for (int32_t c = 0; c < model->planes; c++)
            r->measured[c][(int64_t)texel * r->samples + i] =
                fine ? value[c] - model->mean[c * pairs + r->pair[i]] : NAN;
    }
}

static pave_result read_measured(pv_rebuild *r)
{
    pave_result result = PAVE_OK;
    size_t texels = (size_t)pv_btf_texels(r->sparse);
    r->bad = pv_allocate_zeroed(r->context, texels, 1, &result);
    for (int32_t c = 0; c < r->model->planes && !result; c++)
        r->measured[c] = pv_allocate(r->context, texels, (size_t)r->samples * sizeof(float), &result);
    if (!result)
        result = pv_parallel(r->context, (int32_t)texels, read_texel, r, 0, 0.1);
    if (result || r->model->colour == PV_COLOUR_RGB)
        return result;
    int64_t pairs = pv_model_pairs(r->model);
    const float *mean = r->model->mean;
    for (int64_t i = 0; i < (int64_t)texels * r->samples; i++)
        if (r->measured[0][i] + mean[r->pair[i % r->samples] % pairs] > logf(r->model->least) + 1e-4f)
            return PAVE_OK;
    return pv_fail(r->context, PAVE_ERR_ARGUMENT, "all %d pairs that were measured are black, or no numbers",
                   (int)r->samples);
}

/* Values that are no numbers become what the ABRDFs make of the rest. */
static void mend(const pv_rebuild *r, const pv_system *s, double noise, float *values, double *known)
{
    uint8_t *missing = (uint8_t *)(known + s->rank);
    for (int32_t i = 0; i < r->samples; i++) {
        missing[i] = !isfinite(values[i]);
        values[i] = missing[i] ? 0 : values[i];
    }
    for (int32_t round = 0; round < ROUNDS; round++) {
        memset(known, 0, (size_t)s->rank * sizeof *known);
        for (int32_t i = 0; i < r->samples; i++)
            for (int32_t k = 0; k < s->rank; k++)
                known[k] += (double)s->from[(int64_t)i * s->rank + k] * (double)values[i];
        for (int32_t k = 0; k < s->rank; k++)
            known[k] *= s->values[k] * pv_system_gain(s, k, noise);
        for (int32_t i = 0; i < r->samples; i++) {
            double sum = 0;
            for (int32_t k = 0; k < s->rank && missing[i]; k++)
                sum += (double)s->from[(int64_t)i * s->rank + k] * known[k];
            values[i] = missing[i] ? (float)sum : values[i];
        }
    }
}

pave_result pv_rebuild_mend(pv_rebuild *r, int32_t plane, const pv_system *system)
{
    pave_result result = PAVE_OK;
    int64_t texels = pv_btf_texels(r->sparse), bad = 0;
    double *known = pv_allocate(r->context, 1, (size_t)system->rank * sizeof(double) + (size_t)r->samples, &result);
    for (int64_t t = 0; t < texels && !result; t++)
        if (r->bad[t]) {
            mend(r, system, r->settings[plane].noise[0], r->measured[plane] + t * r->samples, known);
            bad++;
            result = pv_progress(r->context, 0.1);
        }
    if (bad && !plane && !result)
        pv_note(r->context, PAVE_MESSAGE_WARNING, "%lld texels have samples that are no numbers, which count as not "
                "measured", (long long)bad);
    pv_release(known);
    return result;
}


pave_result pv_rebuild_measure(pv_rebuild *r, const pave_btf_plan *plan)
{
    pave_result result = find_pairs(r, plan);
    if (!result && r->params->mode == PAVE_BTF_PROJECT && r->samples < pv_model_pairs(r->model))
        result = pv_fail(r->context, PAVE_ERR_ARGUMENT, "only a complete BTF can be projected, and this has %d of %lld "
                         "pairs", (int)r->samples, (long long)pv_model_pairs(r->model));
    return result ? result : read_measured(r);
}
