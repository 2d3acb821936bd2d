/* A reconstruction under way. */
#pragma once

#include "btf/model.h"
#include "btf/solve.h"

/* One basis on one plane. */
typedef struct pv_part {
    int32_t components;  /* 0: it is not used */
    pv_system system;
    double noise;
    float *coefficients; /* [texel or patch][component] */
} pv_part;

typedef struct pv_rebuild {
    pave_context *context;
    pv_algebra algebra;
    const pave_btf_model *model;
    const pave_btf *sparse;
    const pave_btf_reconstruct_params *params;
    int32_t samples;
    int32_t *pair, *given; /* of the model, and of `sparse`: what was measured */
    float *measured[PV_BTF_CHANNELS]; /* [texel][sample]: values, less the mean */
    uint8_t *bad;          /* [texel]: some of them were no numbers */
    pv_rung settings[PV_BTF_CHANNELS];
    pv_part part[PV_BTF_CHANNELS][2];
    float *tile;           /* room for each worker */
    pave_btf *out;
} pv_rebuild;

/* Patches in a row, and rows of them; texels of a patch. */
static inline int32_t pv_rebuild_wide(const pv_rebuild *r)
{
    return r->sparse->width - r->model->patch + 1;
}

static inline int32_t pv_rebuild_high(const pv_rebuild *r)
{
    return r->sparse->height - r->model->patch + 1;
}

static inline int32_t pv_rebuild_places(const pv_rebuild *r, int32_t of)
{
    return of == PV_OF_PATCHES ? r->model->patch * r->model->patch : 1;
}

/* One over the number of patches that a texel is in. */
float pv_rebuild_blend(const pv_rebuild *r, int64_t texel);

/* Finds which pairs were measured, and reads them. */
pave_result pv_rebuild_measure(pv_rebuild *r, const pave_btf_plan *plan);

/* Samples of one plane that are no numbers become what the ABRDFs make of the rest. */
pave_result pv_rebuild_mend(pv_rebuild *r, int32_t plane, const pv_system *system);

/* Finds the coefficients of all planes; `errors`, [texel], may be NULL. */
pave_result pv_rebuild_solve(pv_rebuild *r, float *errors);

/* Writes all samples of `out`. */
pave_result pv_rebuild_blend_all(pv_rebuild *r);
