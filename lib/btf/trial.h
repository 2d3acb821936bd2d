/* Trying a basis on a material that the model has not seen. */
#pragma once

#include "btf/model.h"
#include "btf/solve.h"

/* Texels of the material that was held out, with those around them. */
typedef struct pv_trial {
    pave_context *context;
    const pv_algebra *algebra;
    const pave_btf *btf;
    const pave_btf_model *model;
    int32_t window, samples, texels, pairs; /* window: side of what the patches with a texel cover */
    int32_t *plan, *asked;    /* pairs that are measured, and some of those that are to be found */
    float *measured;          /* [plane][window y][x][texel][sample] */
    float *truth;             /* [plane][texel][asked pair] */
    int64_t *place;           /* [texel]: top left of its window */
} pv_trial;

/* One basis on one plane with so many samples. Predictions are sums over the places that a texel can have in a patch,
 * over their number. */
typedef struct pv_attempt {
    const pv_trial *t;
    int32_t plane, samples, side; /* side of a patch */
    pv_system system;
    float *known;    /* [place][texel][rank]: what was measured of a patch, along the singular directions */
    float *shown;    /* [place][asked pair][rank] */
    float *weighted; /* [texel][rank] */
} pv_attempt;

/* What was measured at one spot of every window, [texel][sample]. */
static inline float *pv_trial_measured(const pv_trial *t, int32_t plane, int32_t spot)
{
    int64_t each = (int64_t)t->texels * t->samples;
    return t->measured + ((int64_t)plane * t->window * t->window + spot) * each;
}

/* A product whose inner length may be 0, shared out among the threads. */
pave_result pv_trial_product(const pv_trial *t, int transpose_b, int64_t rows, int n, int k, const float *a,
                             int stride_a, const float *b, int stride_b, float beta, float *c, int stride_c);

pave_result pv_attempt_open(const pv_trial *t, int32_t plane, int32_t of, int32_t samples, pv_attempt *a);
void pv_attempt_close(pv_attempt *a);

/* With noise of that variance, from what is known of the patches, [place][texel][rank]: the asked pairs of every texel,
 * [texel][asked]; and the measured ones, as the basis has them, [texel][sample]. */
pave_result pv_attempt_predict(pv_attempt *a, const float *known, double noise, float *out);
pave_result pv_attempt_predict_measured(pv_attempt *a, double noise, float *out);
