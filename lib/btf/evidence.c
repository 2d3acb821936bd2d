/* How best to reconstruct, by the errors on materials that were held out. */
#include "btf/evidence.h"

#include <math.h>
#include <string.h>

pave_result pv_evidence_create(pave_context *context, int32_t planes, pv_evidence **out)
{
    pave_result result = PAVE_OK;
    pv_evidence *e = *out = pv_allocate_zeroed(context, 1, sizeof **out, &result);
    if (result)
        return result;
    e->planes = planes;
    e->sum = pv_allocate_zeroed(context, (size_t)planes, sizeof *e->sum, &result);
    if (result) {
        pv_release(e);
        *out = NULL;
    }
    return result;
}

void pv_evidence_free(pv_evidence *evidence)
{
    if (!evidence)
        return;
    pv_release(evidence->sum);
    pv_release(evidence);
}

double pv_noise_at(const pv_basis *basis, int32_t i)
{
    return basis->whole * pow(10, -0.5 * i);
}

static int32_t find_least(const double errors[PV_NOISES])
{
    int32_t least = 0;
    for (int32_t i = 1; i < PV_NOISES; i++)
        least = errors[i] < errors[least] ? i : least;
    return least;
}

void pv_evidence_add(pv_evidence *evidence, int32_t plane, int32_t rung, const pv_errors *errors)
{
    double *sum = (double *)&evidence->sum[plane][rung];
    const double *more = (const double *)errors;
    double least = fmin(errors->texels[find_least(errors->texels)], errors->patches[find_least(errors->patches)]);
    for (size_t i = 0; i < sizeof *errors / sizeof *sum; i++)
        sum[i] += more[i] / fmax(least, 1e-30);
}

/* The best share of the ABTFs has a closed form. */
static double best_share(const double mixed[3], double *error)
{
    double share = mixed[2] > 0 ? fmin(fmax(-mixed[1] / mixed[2], 0), 1) : 0;
    *error = mixed[0] + 2 * share * mixed[1] + share * share * mixed[2];
    return share;
}

static pv_rung settle(const pv_errors *e, const pave_btf_model *model, const pv_basis basis[2], double samples)
{
    int32_t texels = find_least(e->texels), patches = find_least(e->patches);
    double least = e->texels[texels], error, noise = pv_noise_at(&basis[PV_OF_TEXELS], texels);
    pv_rung rung = { samples, { noise, noise }, noise, 0, 1 };
    if (model->patch > 1)
        rung.noise[1] = pv_noise_at(&basis[PV_OF_PATCHES], patches);
    for (int32_t i = 0; i < PV_ALL_NOISES && model->patch > 1; i++) {
        double share = best_share(e->mixed[patches][i], &error);
        if (error < least) {
            least = error;
            rung.rest = pv_noise_at(&basis[PV_OF_TEXELS], i - PV_LOUD_NOISES);
            rung.share = share;
        }
    }
    rung.trust = sqrt(least / fmax(e->expected[texels], 1e-30));
    return rung;
}

void pv_evidence_settle(const pv_evidence *evidence, pave_btf_model *model)
{
    model->rungs = evidence->rungs;
    for (int32_t c = 0; c < evidence->planes; c++)
        for (int32_t k = 0; k < evidence->rungs; k++)
            model->rung[c][k] = settle(&evidence->sum[c][k], model, model->basis[c], evidence->samples[k]);
}
