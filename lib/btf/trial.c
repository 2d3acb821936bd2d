/* Trying a basis on a material that the model has not seen: what it would say of some pairs, from others. */
#include "btf/trial.h"

#include <string.h>

static const double cut = 1e-6;

pave_result pv_trial_product(const pv_trial *t, int transpose_b, int64_t rows, int n, int k, const float *a,
                             int stride_a, const float *b, int stride_b, float beta, float *c, int stride_c)
{
    pv_product p = { t->algebra, rows, n, k, a, b, c, stride_a, stride_b, stride_c, transpose_b, beta };
    if (!k) /* nothing is known */
        memset(c, 0, (size_t)rows * (size_t)n * sizeof *c);
    return n && k ? pv_multiply_all(t->context, &p, 0, 0) : PAVE_OK;
}

/* What is known of patches in which the texel has place `place`. */
static pave_result know(pv_attempt *a, int32_t place)
{
    const pv_trial *t = a->t;
    int32_t side = a->side, rank = a->system.rank, lead = t->window / 2 - side / 2 - side / 2;
    int32_t left = lead + side - 1 - place % side, top = lead + side - 1 - place / side;
    float *out = a->known + (int64_t)place * t->texels * rank;
    pave_result result = PAVE_OK;
    for (int32_t q = 0; q < side * side && !result; q++) {
        const float *spot = pv_trial_measured(t, a->plane, (top + q / side) * t->window + left + q % side);
        result = pv_trial_product(t, 0, t->texels, rank, a->samples, spot, t->samples,
                                  a->system.from + (int64_t)q * a->samples * rank, rank, q > 0, out, rank);
    }
    return result;
}

pave_result pv_attempt_open(const pv_trial *t, int32_t plane, int32_t of, int32_t samples, pv_attempt *a)
{
    const pv_basis *basis = &t->model->basis[plane][of];
    pave_context *context = t->context;
    pave_result result = PAVE_OK;
    memset(a, 0, sizeof *a);
    a->t = t;
    a->plane = plane;
    a->samples = samples;
    a->side = of == PV_OF_PATCHES ? t->model->patch : 1;
    int32_t places = a->side * a->side, k = basis->components;
    size_t most = (size_t)places * (size_t)(samples > t->pairs ? samples : t->pairs);
    float *rows = pv_allocate(context, most, (size_t)k * sizeof *rows, &result);
    if (!result) {
        pv_basis_rows_of(t->model, basis, places, t->plan, samples, rows);
        result = pv_system_open(context, t->algebra, rows, places * samples, k, k, basis->deviation, cut, &a->system);
    }
    size_t rank = (size_t)a->system.rank;
    if (!result)
        a->known = pv_allocate(context, (size_t)places * (size_t)t->texels, rank * sizeof(float), &result);
    if (!result)
        a->shown = pv_allocate(context, (size_t)places * (size_t)t->pairs, rank * sizeof(float), &result);
    if (!result)
        a->weighted = pv_allocate(context, (size_t)t->texels, rank * sizeof(float), &result);
    if (!result) {
        pv_basis_rows_of(t->model, basis, places, t->asked, t->pairs, rows);
        result = pv_trial_product(t, 0, (int64_t)places * t->pairs, (int)rank, k, rows, k, a->system.to, (int)rank, 0,
                                  a->shown, (int)rank);
    }
    for (int32_t q = 0; q < places && !result; q++)
        result = know(a, q);
    pv_release(rows);
    return result;
}

void pv_attempt_close(pv_attempt *a)
{
    pv_system_close(&a->system);
    pv_release(a->known);
    pv_release(a->shown);
    pv_release(a->weighted);
}

/* What is known of a place's patches, weighted for noise; towards measured values also by the singular values. */
static void weigh(pv_attempt *a, const float *known, double noise, int measured)
{
    int32_t rank = a->system.rank, places = a->side * a->side;
    for (int64_t i = 0; i < (int64_t)a->t->texels * rank; i++) {
        int32_t k = (int32_t)(i % rank);
        double gain = pv_system_gain(&a->system, k, noise) * (measured ? a->system.values[k] : 1);
        a->weighted[i] = known[i] * (float)(gain / places);
    }
}

/* The asked pairs of every texel, [texel][asked]. */
pave_result pv_attempt_predict(pv_attempt *a, const float *known, double noise, float *out)
{
    const pv_trial *t = a->t;
    int32_t rank = a->system.rank;
    pave_result result = PAVE_OK;
    for (int32_t q = 0; q < a->side * a->side && !result; q++) {
        weigh(a, known + (int64_t)q * t->texels * rank, noise, 0);
        result = pv_trial_product(t, 1, t->texels, t->pairs, rank, a->weighted, rank,
                                  a->shown + (int64_t)q * t->pairs * rank, rank, q > 0, out, t->pairs);
    }
    return result;
}

/* The measured pairs of every texel as the basis has them, [texel][sample]. */
pave_result pv_attempt_predict_measured(pv_attempt *a, double noise, float *out)
{
    const pv_trial *t = a->t;
    int32_t rank = a->system.rank;
    pave_result result = PAVE_OK;
    for (int32_t q = 0; q < a->side * a->side && !result; q++) {
        weigh(a, a->known + (int64_t)q * t->texels * rank, noise, 1);
        result = pv_trial_product(t, 1, t->texels, a->samples, rank, a->weighted, rank,
                                  a->system.from + (int64_t)q * a->samples * rank, rank, q > 0, out, a->samples);
    }
    return result;
}
