/* Pairs chosen by chance as long as the condition number of the system falls (den Brok 2014, Algorithm 1). */
#include "btf/model.h"

#include "util/random.h"

#include <math.h>
#include <string.h>

/* The Gram matrix of the rows chosen is kept, and two of its rows' worth changed at each step. */
typedef struct swapping {
    pave_context *context;
    const pv_algebra *algebra;
    const pave_btf_model *model;
    const pv_basis *basis;
    int32_t places, unknowns, count;
    int32_t *pairs;
    uint8_t *taken;
    double *gram, *work, *values;
    uint64_t seed;
} swapping;

/* Adds `sign` times the outer products of a pair's rows, one for each place of a patch. */
static void add_pair(const swapping *s, double *gram, int32_t pair, double sign)
{
    int64_t all = pv_model_pairs(s->model);
    for (int32_t q = 0; q < s->places; q++) {
        const float *row = s->basis->left + (q * all + pair) * s->basis->components;
        for (int32_t i = 0; i < s->unknowns; i++) {
            double one = sign * (double)row[i], *to = gram + (int64_t)i * s->unknowns;
            for (int32_t k = 0; k <= i; k++) /* below the diagonal is what eigenvalues are found from; see condition */
                to[k] += one * (double)row[k];
        }
    }
}

static pave_result condition(const swapping *s, double *out)
{
    int32_t n = s->unknowns;
    for (int32_t i = 0; i < n; i++)
        for (int32_t k = 0; k <= i; k++)
            s->work[(int64_t)i * n + k] = s->work[(int64_t)k * n + i] = s->gram[(int64_t)i * n + k];
    pave_result result = pv_eigenvalues(s->context, s->algebra, n, s->work, s->values);
    double least = result ? 0 : s->values[n - 1];
    *out = least > 1e-14 * s->values[0] ? sqrt(s->values[0] / least) : INFINITY;
    return result;
}

static int32_t draw_pair(const swapping *s, uint32_t step, uint32_t try)
{
    pv_random r = pv_draw(s->seed, PV_DRAW_PLAN, step, try, 0);
    return (int32_t)(((uint64_t)r.word[0] * (uint64_t)pv_model_pairs(s->model)) >> 32);
}

static int32_t draw_other(const swapping *s, uint32_t step)
{
    uint32_t try = 0;
    int32_t pair = draw_pair(s, step, try);
    while (s->taken[pair])
        pair = draw_pair(s, step, ++try);
    return pair;
}

static pave_result try_swap(swapping *s, uint32_t step, double *kappa)
{
    pv_random r = pv_draw(s->seed, PV_DRAW_PLAN, step, 0, 1);
    int32_t place = (int32_t)(((uint64_t)r.word[0] * (uint64_t)s->count) >> 32), other = draw_other(s, step);
    double here;
    add_pair(s, s->gram, s->pairs[place], -1);
    add_pair(s, s->gram, other, 1);
    pave_result result = condition(s, &here);
    if (result)
        return result;
    if (here < *kappa) {
        s->taken[s->pairs[place]] = 0;
        s->taken[other] = 1;
        s->pairs[place] = other;
        *kappa = here;
        return PAVE_OK;
    }
    add_pair(s, s->gram, other, -1);
    add_pair(s, s->gram, s->pairs[place], 1);
    return PAVE_OK;
}

static pave_result open_swapping(swapping *s)
{
    size_t n = (size_t)s->unknowns;
    pave_result result = PAVE_OK;
    s->taken = pv_allocate_zeroed(s->context, (size_t)pv_model_pairs(s->model), 1, &result);
    if (!result)
        s->gram = pv_allocate_zeroed(s->context, n, n * sizeof *s->gram, &result);
    if (!result)
        s->work = pv_allocate(s->context, n, n * sizeof *s->work, &result);
    if (!result)
        s->values = pv_allocate(s->context, n, sizeof *s->values, &result);
    for (int32_t i = 0; i < s->count && !result; i++) {
        s->pairs[i] = draw_other(s, (uint32_t)i);
        s->taken[s->pairs[i]] = 1;
        add_pair(s, s->gram, s->pairs[i], 1);
        result = pv_progress(s->context, 0.1 * i / s->count);
    }
    return result;
}

pave_result pv_plan_swap(pave_context *context, const pave_btf_model *model, const pave_btf_plan_params *params,
                         int32_t *pairs, double *before, double *after)
{
    int of = params->patches && model->patch > 1 ? PV_OF_PATCHES : PV_OF_TEXELS;
    int32_t asked = of == PV_OF_PATCHES ? params->components : params->abrdfs;
    pv_algebra algebra;
    swapping s = { .context = context, .algebra = &algebra, .model = model, .basis = &model->basis[0][of],
                   .places = of == PV_OF_PATCHES ? model->patch * model->patch : 1, .count = params->samples,
                   .pairs = pairs, .seed = params->seed };
    s.unknowns = asked && asked < s.basis->components ? asked : s.basis->components;
    if ((int64_t)s.count * s.places < s.unknowns)
        return pv_fail(context, PAVE_ERR_ARGUMENT,
                       "%d samples are too few for the condition of %d eigen-%s: at least %d are needed", (int)s.count,
                       (int)s.unknowns, of == PV_OF_PATCHES ? "ABTFs" : "ABRDFs",
                       (int)((s.unknowns + s.places - 1) / s.places));
    pave_result result = pv_algebra_open(context, &algebra);
    if (result)
        return result;
    result = open_swapping(&s);
    if (!result)
        result = condition(&s, before);
    *after = *before;
    for (int32_t i = 0; i < params->steps && !result; i++) {
        result = try_swap(&s, (uint32_t)(s.count + i), after);
        if (!result)
            result = pv_progress(context, 0.1 + 0.9 * (i + 1) / params->steps);
    }
    pv_algebra_close(&algebra);
    pv_release(s.taken);
    pv_release(s.gram);
    pv_release(s.work);
    pv_release(s.values);
    return result;
}
