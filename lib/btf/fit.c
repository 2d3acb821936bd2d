/* Fitting a model: each material's bases first, then all of them merged (den Brok 2014, 4.1). */
#include "btf/model.h"

#include "btf/eigenspace.h"
#include "btf/evidence.h"
#include "btf/factor.h"
#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { FOLDS = 3 };

/* The materials' bases side by side, for each plane and for texels and patches. */
typedef struct fitting {
    pave_context *context;
    pv_algebra algebra;
    const pave_btf_model_params *params;
    const pave_btf *const *btfs;
    int32_t count;
    pave_btf_model *model;
    pv_symmetry symmetry;
    pv_side side[PV_BTF_CHANNELS][2];
    float *values[PV_BTF_CHANNELS][2];
    double *energy[PV_BTF_CHANNELS][2]; /* of each material */
    int32_t *width[PV_BTF_CHANNELS][2]; /* alike */
    int64_t *columns[2];                /* alike */
    float (*seen)[2][PV_BTF_CHANNELS];  /* least and greatest values, of each worker */
} fitting;

/* ---- One material ---- */

typedef struct material {
    pv_values values;
    int32_t index; /* among the others */
    int32_t patch, stride, across; /* across: patches in a row of them */
    float (*seen)[2][PV_BTF_CHANNELS];
} material;

static void look(const material *m, int32_t worker, float *const *values)
{
    const pave_btf_model *model = m->values.model;
    int64_t pairs = pv_model_pairs(model);
    for (int32_t c = 0; c < model->planes; c++)
        for (int64_t p = 0; p < pairs; p++) {
            float value = values[c][p] + model->mean[c * pairs + p];
            m->seen[worker][0][c] = fminf(m->seen[worker][0][c], value);
            m->seen[worker][1][c] = fmaxf(m->seen[worker][1][c], value);
        }
}

/* The texels of a patch below each other; of a patch of one, what range its values have as well. */
static int read_patch(void *user, int64_t column, int32_t worker, float *const *out)
{
    const material *m = user;
    const pave_btf *btf = m->values.btf;
    int64_t pairs = pv_model_pairs(m->values.model);
    int64_t left = column % m->across * m->stride, top = column / m->across * m->stride;
    float *to[PV_BTF_CHANNELS];
    int fine = 1;
    for (int32_t q = 0; q < m->patch * m->patch; q++) {
        for (int32_t c = 0; c < m->values.model->planes; c++)
            to[c] = out[c] + q * pairs;
        fine &= pv_values_read(&m->values, (top + q / m->patch) * btf->width + left + q % m->patch, worker, to);
    }
    if (m->patch == 1)
        look(m, worker, to);
    return fine;
}

static pave_result refuse_patch(pave_context *context, void *user, int64_t column)
{
    const material *m = user;
    int64_t x = column % m->across * m->stride, y = column / m->across * m->stride;
    return pv_fail(context, PAVE_ERR_FORMAT, "material %d: texel %lld,%lld has samples that are infinite or no numbers",
                   (int)m->index, (long long)x, (long long)y);
}

static int64_t places(int32_t side, int32_t patch, int32_t stride)
{
    return side < patch ? 0 : (side - patch) / stride + 1;
}

static int32_t patch_of(const fitting *f, int32_t of)
{
    return of == PV_OF_PATCHES ? f->params->patch : 1;
}

static int32_t stride_of(const fitting *f, int32_t of)
{
    return of != PV_OF_PATCHES ? 1 : f->params->stride ? f->params->stride : f->params->patch;
}

static int64_t columns_of(const fitting *f, const pave_btf *btf, int32_t of)
{
    int32_t patch = patch_of(f, of), stride = stride_of(f, of);
    return places(btf->width, patch, stride) * places(btf->height, patch, stride);
}

static int32_t kept_of(const fitting *f, int32_t plane, int32_t of, int64_t columns)
{
    int64_t kept = plane && f->model->colour == PV_COLOUR_LOG_YUV ? (f->params->material + 1) / 2 : f->params->material;
    kept = kept < columns ? kept : columns;
    return (int32_t)(kept < pv_basis_rows(f->model, of) ? kept : pv_basis_rows(f->model, of));
}

/* U S of a material, after those before it. */
static void append(fitting *f, int32_t of, int32_t index, const pv_factors *factors)
{
    for (int32_t c = 0; c < f->model->planes; c++) {
        pv_side *side = &f->side[c][of];
        const pv_factors *own = &factors[c];
        double energy = 0;
        for (int32_t k = 0; k < own->components; k++)
            energy += (double)own->singular[k] * own->singular[k];
        for (int64_t r = 0; r < side->rows; r++)
            for (int32_t k = 0; k < own->components; k++)
                f->values[c][of][r * side->stride + side->width + k] =
                    own->left[r * own->components + k] * own->singular[k];
        side->width += own->components;
        f->width[c][of][index] = own->components;
        f->energy[c][of][index] = energy / fmax(1 - own->error * own->error, 1e-12);
    }
}

static pave_result fit_material(fitting *f, int32_t index, int32_t of)
{
    const pave_btf *btf = f->btfs[index];
    pave_btf_model *model = f->model;
    int32_t components[PV_BTF_CHANNELS];
    pv_factors factors[PV_BTF_CHANNELS];
    material m = { .index = index, .patch = patch_of(f, of), .stride = stride_of(f, of), .seen = f->seen };
    pv_columns columns = { model->planes, pv_basis_rows(model, of), columns_of(f, btf, of),
                           read_patch, refuse_patch, &m };
    m.across = (int32_t)places(btf->width, m.patch, m.stride);
    pave_result result = pv_values_open(f->context, btf, model, &m.values);
    for (int32_t c = 0; c < model->planes; c++)
        components[c] = kept_of(f, c, of, columns.count);
    if (!result)
        result = pv_factor(f->context, &f->algebra, &columns, components, 0, f->params->passes, factors);
    pv_values_close(&m.values);
    if (result)
        return result;
    append(f, of, index, factors);
    f->columns[of][index] = columns.count;
    for (int32_t c = 0; c < model->planes; c++)
        pv_factors_free(&factors[c]);
    return PAVE_OK;
}

/* ---- All of them ---- */

static pave_result open_sides(fitting *f)
{
    pave_result result = PAVE_OK;
    for (int32_t of = 0; of < 2 && !result; of++) {
        f->columns[of] = pv_allocate_zeroed(f->context, (size_t)f->count, sizeof(int64_t), &result);
        for (int32_t c = 0; c < f->model->planes && !result && patch_of(f, of) > of; c++) {
            pv_side *side = &f->side[c][of];
            side->rows = pv_basis_rows(f->model, of);
            side->patch = patch_of(f, of);
            side->lights = f->model->lights.count;
            for (int32_t i = 0; i < f->count; i++)
                side->stride += kept_of(f, c, of, columns_of(f, f->btfs[i], of));
            size_t bytes = (size_t)side->stride * sizeof(float);
            side->values = f->values[c][of] = pv_allocate(f->context, (size_t)side->rows, bytes, &result);
            if (!result)
                f->energy[c][of] = pv_allocate(f->context, (size_t)f->count, sizeof(double), &result);
            if (!result)
                f->width[c][of] = pv_allocate(f->context, (size_t)f->count, sizeof(int32_t), &result);
        }
    }
    return result;
}

/* Materials but one; -1: all of them. */
static int64_t count_columns(const fitting *f, int32_t without, int32_t of)
{
    int64_t columns = 0;
    for (int32_t i = 0; i < f->count; i++)
        columns += i == without ? 0 : f->columns[of][i];
    return columns;
}

/* The basis of all materials but one. */
static pave_result merge_basis(fitting *f, int32_t without, int32_t plane, int32_t of)
{
    pv_basis *basis = &f->model->basis[plane][of];
    pv_side side = f->side[plane][of];
    double columns = (double)count_columns(f, without, of), inside = 0, energy = 0;
    for (int32_t i = 0; i < f->count; i++)
        energy += i == without ? 0 : f->energy[plane][of][i];
    for (int32_t i = 0; i < without; i++)
        side.gap += f->width[plane][of][i];
    side.gap_width = without < 0 ? 0 : f->width[plane][of][without];
    side.width -= side.gap_width;
    basis->components = of == PV_OF_PATCHES ? f->params->components : f->params->abrdfs;
    pave_result result = pv_eigenspace(f->context, &f->algebra, &side, &f->symmetry, &basis->components, &basis->left,
                                       &basis->deviation);
    for (int32_t k = 0; k < basis->components && !result; k++) {
        inside += (double)basis->deviation[k] * basis->deviation[k];
        basis->deviation[k] = (float)((double)basis->deviation[k] / sqrt(columns));
    }
    basis->whole = energy / columns / (double)side.rows;
    basis->outside = fmax(energy - inside, 0) / columns / (double)side.rows;
    return result;
}

static pave_result merge_bases(fitting *f, int32_t without)
{
    pave_result result = PAVE_OK;
    pv_model_drop_bases(f->model);
    for (int32_t c = 0; c < f->model->planes && !result; c++)
        for (int32_t of = 0; of < 2 && !result; of++)
            if (f->values[c][of])
                result = merge_basis(f, without, c, of);
    f->model->materials = f->count - (without >= 0);
    f->model->texels = count_columns(f, without, PV_OF_TEXELS);
    f->model->patches = count_columns(f, without, PV_OF_PATCHES);
    return result;
}

static void sum_up_range(fitting *f)
{
    for (int32_t c = 0; c < f->model->planes; c++) {
        f->model->range[c][0] = INFINITY;
        f->model->range[c][1] = -INFINITY;
        for (int32_t w = 0; w < pv_workers(f->context); w++) {
            f->model->range[c][0] = fminf(f->model->range[c][0], f->seen[w][0][c]);
            f->model->range[c][1] = fmaxf(f->model->range[c][1], f->seen[w][1][c]);
        }
    }
}

static void reset_seen(fitting *f)
{
    for (int32_t w = 0; w < pv_workers(f->context); w++)
        for (int32_t c = 0; c < PV_BTF_CHANNELS; c++) {
            f->seen[w][0][c] = INFINITY;
            f->seen[w][1][c] = -INFINITY;
        }
}

/* A black material has the same values everywhere: those of light that is none. */
static pave_result fit_materials(fitting *f, double to)
{
    pave_result result = PAVE_OK;
    float range[2][PV_BTF_CHANNELS];
    for (int32_t c = 0; c < PV_BTF_CHANNELS; c++)
        range[0][c] = INFINITY, range[1][c] = -INFINITY;
    for (int32_t i = 0; i < f->count && !result; i++) {
        double from = to * i / f->count, mid = to * (i + 0.3) / f->count;
        reset_seen(f);
        pv_call call = pv_call_begin(f->context, "model", from, mid);
        result = fit_material(f, i, PV_OF_TEXELS);
        pv_call_end(f->context, call);
        if (result)
            break;
        sum_up_range(f);
        if (f->model->range[0][0] == f->model->range[0][1])
            return pv_fail(f->context, PAVE_ERR_ARGUMENT,
                           "material %d is black or even all over: nothing can be learned from it", (int)i);
        for (int32_t c = 0; c < f->model->planes; c++) {
            range[0][c] = fminf(range[0][c], f->model->range[c][0]);
            range[1][c] = fmaxf(range[1][c], f->model->range[c][1]);
        }
        call = pv_call_begin(f->context, "model", mid, to * (i + 1) / f->count);
        if (f->params->patch > 1)
            result = fit_material(f, i, PV_OF_PATCHES);
        pv_call_end(f->context, call);
    }
    for (int32_t c = 0; c < f->model->planes; c++) {
        f->model->range[c][0] = range[0][c];
        f->model->range[c][1] = range[1][c];
    }
    return result;
}

/* Some materials are held out in turn, to see how far the others go: what one of them says may be true of it alone. */
static pave_result validate(fitting *f, pv_evidence *evidence)
{
    int32_t folds = f->count < FOLDS ? f->count : FOLDS;
    pave_result result = PAVE_OK;
    for (int32_t k = 0; k < folds && !result; k++) {
        int32_t without = f->count - 1 - k * f->count / folds;
        double from = 0.6 + 0.3 * (k + 0.3) / folds, to = 0.6 + 0.3 * (k + 1) / folds;
        result = merge_bases(f, without);
        pv_call call = pv_call_begin(f->context, "validate", from, to);
        if (!result)
            result = pv_model_validate(f->context, &f->algebra, f->btfs[without], f->model, evidence);
        pv_call_end(f->context, call);
    }
    return result;
}

static pave_result fit(fitting *f)
{
    pv_evidence *evidence = NULL;
    pave_result result = open_sides(f);
    if (!result)
        f->seen = pv_allocate(f->context, (size_t)pv_workers(f->context), sizeof *f->seen, &result);
    if (!result)
        result = pv_evidence_create(f->context, f->model->planes, &evidence);
    if (!result)
        result = fit_materials(f, 0.6);
    if (!result && f->params->validate && f->count > 1)
        result = validate(f, evidence);
    if (!result)
        result = pv_progress(f->context, 0.9);
    if (!result)
        result = merge_bases(f, -1);
    if (!result)
        pv_evidence_settle(evidence, f->model);
    pv_evidence_free(evidence);
    return result;
}

static void close_fitting(fitting *f)
{
    for (int32_t of = 0; of < 2; of++) {
        for (int32_t c = 0; c < PV_BTF_CHANNELS; c++) {
            pv_release(f->values[c][of]);
            pv_release(f->energy[c][of]);
            pv_release(f->width[c][of]);
        }
        pv_release(f->columns[of]);
    }
    pv_release(f->seen);
    pv_symmetry_free(&f->symmetry);
}

pave_result pv_model_fit(pave_context *context, const pave_btf *const *btfs, int32_t count,
                         const pave_btf_model_params *params, pave_btf_model *model)
{
    fitting f = { .context = context, .params = params, .btfs = btfs, .count = count, .model = model };
    pave_result result = pv_symmetry_find(context, &model->views, &model->lights, params->symmetric, &f.symmetry);
    model->symmetry = f.symmetry.count;
    if (!result)
        result = pv_algebra_open(context, &f.algebra);
    if (!result) {
        result = fit(&f);
        pv_algebra_close(&f.algebra);
    }
    close_fitting(&f);
    return result;
}
