/* Samples as the values that models are about: logarithms less those of a grey diffuse plane, channel by channel. */
#include "btf/model.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

static const float grey = 0.3f / 3.14159265f;

/* Of a plane: what a grey diffuse sample would have. */
static void set_mean(pave_btf_model *model, int32_t plane)
{
    int64_t pairs = pv_model_pairs(model);
    int is_log = model->colour == PV_COLOUR_LOG || (model->colour == PV_COLOUR_LOG_YUV && plane == 0);
    for (int64_t p = 0; p < pairs; p++) {
        float theta = model->lights.direction[p % model->lights.count].theta;
        float sample = model->cosine ? grey * fmaxf(cosf(theta), 0) : grey;
        model->mean[plane * pairs + p] = is_log ? logf(sample + model->least) : 0;
    }
}

void pv_model_set_mean(pave_btf_model *model)
{
    for (int32_t c = 0; c < model->planes; c++)
        set_mean(model, c);
}

pave_result pv_values_open(pave_context *context, const pave_btf *btf, const pave_btf_model *model, pv_values *out)
{
    pave_result result = PAVE_OK;
    out->btf = btf;
    out->model = model;
    out->room = pv_allocate(context, (size_t)pv_workers(context), 2 * (size_t)pv_btf_length(btf) * sizeof *out->room,
                            &result);
    return result;
}

void pv_values_close(pv_values *values)
{
    pv_release(values->room);
    values->room = NULL;
}

int pv_values_read(const pv_values *values, int64_t texel, int32_t worker, float *const *out)
{
    const pave_btf *btf = values->btf;
    const pave_btf_model *model = values->model;
    int64_t length = pv_btf_length(btf), pairs = length / btf->channels;
    float *samples = values->room + worker * 2 * length, *coded = samples + length;
    pave_btf_abrdf(btf, (int32_t)(texel % btf->width), (int32_t)(texel / btf->width), samples);
    pv_colour_encode(model->colour, model->least, btf->channels, samples, pairs, coded);
    for (int32_t c = 0; c < model->planes; c++)
        for (int64_t p = 0; p < pairs; p++)
            out[c][p] = coded[p * model->planes + c] - model->mean[c * pairs + p];
    return pv_all_finite(samples, length);
}

void pv_basis_rows_of(const pave_btf_model *model, const pv_basis *basis, int32_t places, const int32_t *pairs,
                      int32_t count, float *out)
{
    int64_t all = pv_model_pairs(model), k = basis->components;
    for (int32_t q = 0; q < places; q++)
        for (int32_t i = 0; i < count; i++)
            memcpy(out + ((int64_t)q * count + i) * k, basis->left + (q * all + pairs[i]) * k, (size_t)k * sizeof *out);
}

/* Between the rungs by the logarithm of the number; beyond them, and without any, what is nearest. */
pv_rung pv_model_settings(const pave_btf_model *model, int32_t plane, double samples)
{
    const pv_rung *rung = model->rung[plane];
    const pv_basis *basis = model->basis[plane];
    double guess = fmax(basis[PV_OF_TEXELS].outside, 0.01 * basis[PV_OF_TEXELS].whole);
    if (!model->rungs)
        return (pv_rung){ samples, { guess, guess }, guess, model->patch > 1 ? 1 : 0, 1 };
    int32_t k = 0;
    while (k + 1 < model->rungs - 1 && rung[k + 1].samples < samples)
        k++;
    if (model->rungs == 1 || samples >= rung[model->rungs - 1].samples)
        return rung[model->rungs - 1];
    double t = log(samples / rung[k].samples) / log(rung[k + 1].samples / rung[k].samples);
    t = fmin(fmax(t, 0), 1);
    pv_rung a = rung[k], b = rung[k + 1];
    return (pv_rung){ samples,
                      { pow(a.noise[0], 1 - t) * pow(b.noise[0], t), pow(a.noise[1], 1 - t) * pow(b.noise[1], t) },
                      pow(a.rest, 1 - t) * pow(b.rest, t),
                      a.share + t * (b.share - a.share),
                      a.trust + t * (b.trust - a.trust) };
}
