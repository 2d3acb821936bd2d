/* Coefficients of patches and texels from what was measured (den Brok 2014, Eq. 3), or with the model's prior. */
#include "btf/rebuild.h"

#include <math.h>
#include <string.h>

static void limit_components(pv_rebuild *r, int32_t plane)
{
    const pave_btf_reconstruct_params *p = r->params;
    for (int32_t of = 0; of < 2; of++) {
        int32_t all = r->model->basis[plane][of].components, asked = of == PV_OF_PATCHES ? p->components : p->abrdfs;
        int used = p->mode == PAVE_BTF_BEST ? p->basis != (of == PV_OF_PATCHES ? PAVE_BTF_ABRDFS : PAVE_BTF_ABTFS) ||
                                                  (of == PV_OF_TEXELS && r->model->patch == 1)
                   : of == PV_OF_PATCHES    ? p->basis != PAVE_BTF_ABRDFS && r->model->patch > 1
                                            : p->basis == PAVE_BTF_ABRDFS || r->model->patch == 1;
        r->part[plane][of].components = !used ? 0 : asked && asked < all ? asked : all;
    }
}

/* Onto the basis itself: the rows seen are all rows. */
static pave_result open_projection(pv_rebuild *r, int32_t plane, int32_t of, int32_t k)
{
    const pv_basis *basis = &r->model->basis[plane][of];
    pv_part *p = &r->part[plane][of];
    pave_result result = PAVE_OK;
    size_t rows = (size_t)pv_rebuild_places(r, of) * (size_t)r->samples;
    float *all = pv_allocate(r->context, rows, (size_t)basis->components * sizeof *all, &result);
    if (!result)
        p->system.from = pv_allocate(r->context, rows, (size_t)k * sizeof(float), &result);
    if (!result)
        p->system.values = pv_allocate(r->context, (size_t)k, sizeof(double), &result);
    if (!result) {
        pv_basis_rows_of(r->model, basis, pv_rebuild_places(r, of), r->pair, r->samples, all);
        for (size_t i = 0; i < rows; i++)
            memcpy(p->system.from + i * (size_t)k, all + i * (size_t)basis->components, (size_t)k * sizeof *all);
        for (int32_t i = 0; i < k; i++)
            p->system.values[i] = 1;
        p->system.rank = p->system.unknowns = k;
    }
    pv_release(all);
    return result;
}

/* With the prior, or as it is. */
static pave_result open_system(const pv_rebuild *r, int32_t plane, int32_t of, int32_t components, int with_prior,
                               pv_system *out)
{
    const pv_basis *basis = &r->model->basis[plane][of];
    int32_t equations = pv_rebuild_places(r, of) * r->samples;
    pave_result result = PAVE_OK;
    float *rows = pv_allocate(r->context, (size_t)equations, (size_t)basis->components * sizeof *rows, &result);
    if (result)
        return result;
    pv_basis_rows_of(r->model, basis, pv_rebuild_places(r, of), r->pair, r->samples, rows);
    result = pv_system_open(r->context, &r->algebra, rows, equations, components, basis->components,
                            with_prior ? basis->deviation : NULL, with_prior ? 1e-6 : r->params->cut, out);
    pv_release(rows);
    if (!result && !out->rank)
        return pv_fail(r->context, PAVE_ERR_ARGUMENT, "the system is singular: nothing of the model shows in the %d "
                       "pairs that were measured", (int)r->samples);
    return result;
}

static pave_result open_part(pv_rebuild *r, int32_t plane, int32_t of)
{
    pv_part *p = &r->part[plane][of];
    const char *what = of == PV_OF_PATCHES ? "ABTFs" : "ABRDFs";
    int32_t k = p->components, places = pv_rebuild_places(r, of);
    if (r->params->mode == PAVE_BTF_PROJECT)
        return open_projection(r, plane, of, k);
    if (r->params->mode == PAVE_BTF_PAPER && places * r->samples < k)
        return pv_fail(r->context, PAVE_ERR_ARGUMENT,
                       "%d samples are too few for %d eigen-%s: by the text at least %d are needed (mode best takes "
                       "any number)", (int)r->samples, (int)k, what, (int)((k + places - 1) / places));
    pave_result result = open_system(r, plane, of, k, r->params->mode == PAVE_BTF_BEST, &p->system);
    if (!result && r->params->mode == PAVE_BTF_PAPER && p->system.rank < k)
        pv_note(r->context, PAVE_MESSAGE_INFO, "channel %d: of %d eigen-%s, %d can be told from the samples",
                (int)plane, (int)k, what, (int)p->system.rank);
    return result;
}

static void set_noise(pv_rebuild *r, int32_t plane)
{
    pv_part *part = r->part[plane];
    const pv_rung *settings = &r->settings[plane];
    double extra = r->params->noise * r->params->noise;
    int best = r->params->mode == PAVE_BTF_BEST;
    part[PV_OF_PATCHES].noise = best ? settings->noise[1] + extra : 0;
    part[PV_OF_TEXELS].noise = !best                              ? 0
                               : part[PV_OF_PATCHES].components ? settings->rest + extra
                                                                  : settings->noise[0] + extra;
}

static pave_result product(const pv_rebuild *r, int transpose_b, int64_t rows, int n, int k, const float *a,
                           const float *b, float beta, float *c)
{
    pv_product p = { &r->algebra, rows, n, k, a, b, c, k, transpose_b ? k : n, n, transpose_b, beta };
    return pv_multiply_all(r->context, &p, 0, 0);
}

/* Weights what is known along singular directions, [row][rank]; towards measured values also by singular values. */
static void weigh(const pv_part *p, int64_t rows, int measured, float *known)
{
    int32_t rank = p->system.rank;
    for (int64_t i = 0; i < rows * rank; i++) {
        int32_t k = (int32_t)(i % rank);
        double gain = pv_system_gain(&p->system, k, p->noise);
        known[i] *= (float)(measured ? p->system.values[k] : gain);
    }
}

/* Coefficients from what is known and weighted; it is released. */
static pave_result finish_part(pv_rebuild *r, pv_part *p, int64_t rows, float *known)
{
    pave_result result = PAVE_OK;
    if (!p->system.to) { /* a projection: they are the same */
        p->coefficients = known;
        return PAVE_OK;
    }
    p->coefficients = pv_allocate(r->context, (size_t)rows, (size_t)p->components * sizeof(float), &result);
    if (!result)
        result = product(r, 1, rows, p->components, p->system.rank, known, p->system.to, 0, p->coefficients);
    pv_release(known);
    return result;
}

/* What is known of every patch, [patch][rank]. */
static pave_result know_patches(const pv_rebuild *r, int32_t plane, float *known)
{
    const pv_system *s = &r->part[plane][PV_OF_PATCHES].system;
    int32_t side = r->model->patch;
    pave_result result = PAVE_OK;
    for (int32_t y = 0; y < pv_rebuild_high(r) && !result; y++)
        for (int32_t q = 0; q < side * side && !result; q++)
            result = product(r, 0, pv_rebuild_wide(r), s->rank, r->samples,
                             r->measured[plane] + ((int64_t)(y + q / side) * r->sparse->width + q % side) * r->samples,
                             s->from + (int64_t)q * r->samples * s->rank, q > 0,
                             known + (int64_t)y * pv_rebuild_wide(r) * s->rank);
    return result;
}

/* Takes off the values measured what patches say of them; `known` is weighted for values. */
static pave_result take_off(pv_rebuild *r, int32_t plane, const float *known)
{
    const pv_system *s = &r->part[plane][PV_OF_PATCHES].system;
    int32_t side = r->model->patch, width = r->sparse->width;
    pave_result result = PAVE_OK;
    float *row = pv_allocate(r->context, (size_t)pv_rebuild_wide(r), (size_t)r->samples * sizeof *row, &result);
    for (int32_t y = 0; y < pv_rebuild_high(r) && !result; y++)
        for (int32_t q = 0; q < side * side && !result; q++) {
            const float *from = known + (int64_t)y * pv_rebuild_wide(r) * s->rank;
            result = product(r, 1, pv_rebuild_wide(r), r->samples, s->rank, from,
                             s->from + (int64_t)q * r->samples * s->rank, 0, row);
            for (int32_t x = 0; x < pv_rebuild_wide(r) && !result; x++) {
                int64_t texel = (int64_t)(y + q / side) * width + x + q % side;
                float weight = pv_rebuild_blend(r, texel) * (float)r->settings[plane].share;
                for (int32_t i = 0; i < r->samples; i++)
                    r->measured[plane][texel * r->samples + i] -= weight * row[(int64_t)x * r->samples + i];
            }
        }
    pv_release(row);
    return result;
}

static pave_result solve_patches(pv_rebuild *r, int32_t plane)
{
    pv_part *p = &r->part[plane][PV_OF_PATCHES];
    int64_t patches = (int64_t)pv_rebuild_wide(r) * pv_rebuild_high(r);
    pave_result result = PAVE_OK;
    float *known = pv_allocate(r->context, (size_t)patches, (size_t)p->system.rank * sizeof *known, &result);
    if (!result)
        result = know_patches(r, plane, known);
    if (!result)
        weigh(p, patches, 0, known);
    if (!result && r->part[plane][PV_OF_TEXELS].components) {
        weigh(p, patches, 1, known);
        result = take_off(r, plane, known);
        for (int64_t i = 0; i < patches * p->system.rank && !result; i++)
            known[i] /= (float)p->system.values[i % p->system.rank];
    }
    if (result) {
        pv_release(known);
        return result;
    }
    return finish_part(r, p, patches, known);
}

static pave_result solve_texels(pv_rebuild *r, int32_t plane)
{
    pv_part *p = &r->part[plane][PV_OF_TEXELS];
    int64_t texels = pv_btf_texels(r->sparse);
    pave_result result = PAVE_OK;
    float *known = pv_allocate(r->context, (size_t)texels, (size_t)p->system.rank * sizeof *known, &result);
    if (!result)
        result = product(r, 0, texels, p->system.rank, r->samples, r->measured[plane], p->system.from, 0, known);
    if (result) {
        pv_release(known);
        return result;
    }
    weigh(p, texels, 0, known);
    return finish_part(r, p, texels, known);
}

/* What root mean square error to expect of each texel, before the ABTFs' share is taken off. */
static pave_result expect_errors(const pv_rebuild *r, const pv_system *s, float *out)
{
    const pv_basis *basis = &r->model->basis[0][PV_OF_TEXELS];
    double whole = 0, noise = r->settings[0].noise[0] + r->params->noise * r->params->noise;
    int64_t texels = pv_btf_texels(r->sparse);
    pave_result result = PAVE_OK;
    float *known = pv_allocate(r->context, (size_t)texels, (size_t)s->rank * sizeof *known, &result);
    if (!result)
        result = product(r, 0, texels, s->rank, r->samples, r->measured[0], s->from, 0, known);
    for (int32_t k = 0; k < basis->components; k++)
        whole += (double)basis->deviation[k] * basis->deviation[k];
    double left = pv_system_left(s, whole, noise) / (double)pv_model_pairs(r->model) + basis->outside;
    for (int64_t t = 0; t < texels && !result; t++) {
        double surprise = pv_system_surprise(s, noise, r->measured[0] + t * r->samples, known + t * s->rank);
        out[t] = (float)(r->settings[0].trust * sqrt(left * surprise));
    }
    pv_release(known);
    return result;
}

static int64_t count_bad(const pv_rebuild *r)
{
    int64_t bad = 0;
    for (int64_t t = 0; t < pv_btf_texels(r->sparse); t++)
        bad += r->bad[t];
    return bad;
}

/* The ABRDFs' system with the prior is what mends samples and tells errors, too. */
static pave_result use_prior(pv_rebuild *r, int32_t plane, float *errors, pv_system *prior)
{
    int32_t used = r->part[plane][PV_OF_TEXELS].components, all = r->model->basis[plane][PV_OF_TEXELS].components;
    pave_result result = open_system(r, plane, PV_OF_TEXELS, used ? used : all, 1, prior);
    if (!result)
        result = pv_rebuild_mend(r, plane, prior);
    return result || !errors || plane ? result : expect_errors(r, prior, errors);
}

static pave_result solve_plane(pv_rebuild *r, int32_t plane, float *errors)
{
    pv_part *texels = &r->part[plane][PV_OF_TEXELS], *patches = &r->part[plane][PV_OF_PATCHES];
    int best = r->params->mode == PAVE_BTF_BEST;
    pv_system prior = { 0 };
    pave_result result = PAVE_OK;
    set_noise(r, plane);
    if ((best && texels->components) || errors || count_bad(r))
        result = use_prior(r, plane, errors, &prior);
    if (!result && patches->components)
        result = open_part(r, plane, PV_OF_PATCHES);
    if (!result && patches->components)
        result = solve_patches(r, plane);
    pv_system_close(&patches->system);
    if (best && texels->components && !result) {
        texels->system = prior;
        memset(&prior, 0, sizeof prior);
    } else if (texels->components && !result)
        result = open_part(r, plane, PV_OF_TEXELS);
    if (!result && texels->components)
        result = solve_texels(r, plane);
    pv_system_close(&texels->system);
    pv_system_close(&prior);
    pv_release(r->measured[plane]);
    r->measured[plane] = NULL;
    return result ? result : pv_progress(r->context, 0.1 + 0.3 * (plane + 1) / r->model->planes);
}

pave_result pv_rebuild_solve(pv_rebuild *r, float *errors)
{
    pave_result result = PAVE_OK;
    for (int32_t c = 0; c < r->model->planes && !result; c++) {
        r->settings[c] = pv_model_settings(r->model, c, r->samples);
        limit_components(r, c);
        if (!r->part[c][PV_OF_TEXELS].components) /* ABTFs by themselves count in full */
            r->settings[c].share = 1;
        result = solve_plane(r, c, errors);
    }
    return result;
}
