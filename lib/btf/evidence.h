/* How well settings did on materials that were held out. */
#pragma once

#include "btf/model.h"

/* Noises are tried in steps of the root of ten, from the variance of a value down; for ABRDFs of what ABTFs leave also
 * some above it, with which little is taken from them. */
enum { PV_NOISES = 17, PV_LOUD_NOISES = 6, PV_ALL_NOISES = PV_LOUD_NOISES + PV_NOISES };

/* Mean square errors of a plane from so many samples. */
typedef struct pv_errors {
    double texels[PV_NOISES], patches[PV_NOISES]; /* of either basis by itself */
    double expected[PV_NOISES];                   /* what the ABRDFs' prior says of `texels` */
    double mixed[PV_NOISES][PV_ALL_NOISES][3];    /* of both, by the noise of the first and of the second: a share s of
                                                     the first makes it a + 2 b s + c s^2 */
} pv_errors;

/* Sums over materials, to each of which the better basis by itself is 1: none counts for more because it is hard. */
typedef struct pv_evidence {
    int32_t planes, rungs;
    double samples[PV_MOST_RUNGS];
    pv_errors (*sum)[PV_MOST_RUNGS]; /* [plane] */
} pv_evidence;

pave_result pv_evidence_create(pave_context *context, int32_t planes, pv_evidence **out);
void pv_evidence_free(pv_evidence *evidence);

void pv_evidence_add(pv_evidence *evidence, int32_t plane, int32_t rung, const pv_errors *errors);

/* The rungs of a model: for each number of samples the settings with the least errors on the mean. */
void pv_evidence_settle(const pv_evidence *evidence, pave_btf_model *model);

/* The i-th noise of a basis. */
double pv_noise_at(const pv_basis *basis, int32_t i);

/* Tries a model on a material that it has not seen, for some numbers of samples. */
pave_result pv_model_validate(pave_context *context, const pv_algebra *algebra, const pave_btf *btf,
                              const pave_btf_model *model, pv_evidence *evidence);
