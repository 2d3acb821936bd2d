/* One eigenspace for several materials (den Brok 2014, 4.1): factors are merged without going back to samples. */
#include "btf/algebra.h"
#include "btf/btf.h"

#include <math.h>
#include <string.h>

/* A channel of all materials: left factors times singular values, side by side. */
typedef struct merging {
    pave_context *context;
    const pv_algebra *algebra;
    const pave_btf *const *btfs;
    int32_t count, plane, width; /* width: components of all together */
    int64_t rows;
    float *side; /* [row][width] */
    double *turn, *values;
} merging;

static pave_result check(pave_context *context, const pave_btf *const *btfs, int32_t count)
{
    const pave_btf *first = btfs[0];
    int64_t height = 0;
    for (int32_t i = 0; i < count; i++) {
        const pave_btf *b = btfs[i];
        if (!b || !b->factors)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "material %d is not factored: compress it first", (int)i);
        height += b->height;
        if (b->width != first->width || b->channels != first->channels || b->views.count != first->views.count ||
            b->lights.count != first->lights.count || b->joint != first->joint || b->colour != first->colour)
            return pv_fail(context, PAVE_ERR_ARGUMENT,
                           "materials 0 and %d differ in width, channels, directions or colour model", (int)i);
    }
    if (height > context->limits.max_side)
        return pv_fail(context, PAVE_ERR_LIMIT, "merged materials of %lld texels height: a side must be 1 .. %lld "
                       "(max_side)", (long long)height, (long long)context->limits.max_side);
    return PAVE_OK;
}

/* A' A is diagonal for right factors of one SVD, so left factors that are scaled by singular values have the same
 * singular vectors and values as the samples they stand for. */
static void put_side_by_side(merging *m)
{
    int32_t at = 0;
    for (int32_t i = 0; i < m->count; i++) {
        const pv_factors *f = &m->btfs[i]->factors[m->plane];
        for (int64_t r = 0; r < m->rows; r++)
            for (int32_t k = 0; k < f->components; k++)
                m->side[r * m->width + at + k] = f->left[r * f->components + k] * f->singular[k];
        at += f->components;
    }
}

/* U = A V / s, where A' A = V s^2 V'. */
static pave_result find_left(merging *m, pv_factors *out)
{
    size_t n = (size_t)m->width;
    pave_result result = pv_gram(m->context, m->algebra, m->rows, m->width, m->side, m->turn);
    if (!result)
        result = pv_eigen(m->context, m->algebra, m->width, m->turn, m->values);
    double whole = 0, left = 0;
    for (int32_t k = 0; k < m->width && !result; k++) {
        whole += fmax(m->values[k], 0);
        left += k < out->components ? 0 : fmax(m->values[k], 0);
    }
    for (int32_t k = 0; k < out->components && !result; k++) {
        double s = sqrt(fmax(m->values[k], 0));
        out->singular[k] = (float)s;
        for (size_t j = 0; j < n; j++)
            m->turn[(size_t)k * n + j] *= s > 1e-7 * sqrt(whole) ? 1 / s : 0;
    }
    out->error = whole > 0 ? sqrt(left / whole) : 0;
    return result ? result
                  : pv_rotate(m->context, m->algebra, m->rows, m->width, m->side, out->components, m->turn, out->left);
}

/* What each material's texels have of the new basis: right * (left' U). */
static pave_result find_right(const merging *m, pv_factors *out)
{
    pave_result result = PAVE_OK;
    int k = out->components;
    float *cross = pv_allocate(m->context, (size_t)m->width, (size_t)k * sizeof *cross, &result), *to = out->right;
    for (int32_t i = 0; i < m->count && !result; i++) {
        const pv_factors *f = &m->btfs[i]->factors[m->plane];
        int own = f->components, texels = (int)pv_btf_texels(m->btfs[i]);
        pv_multiply(m->algebra, 1, 0, own, k, (int)m->rows, f->left, own, out->left, k, 0, cross, k);
        pv_multiply(m->algebra, 0, 0, texels, k, own, f->right, own, cross, k, 0, to, k);
        to += (int64_t)texels * k;
        result = pv_progress(m->context, (m->plane + (i + 1.0) / m->count) / pv_btf_planes(m->btfs[0]));
    }
    pv_release(cross);
    return result;
}

static pave_result merge_plane(merging *m, int32_t components, pave_btf *out)
{
    pave_result result = PAVE_OK;
    m->width = 0;
    for (int32_t i = 0; i < m->count; i++)
        m->width += m->btfs[i]->factors[m->plane].components;
    int32_t kept = components < m->width ? components : m->width;
    kept = kept < m->rows ? kept : (int32_t)m->rows;
    size_t n = (size_t)m->width;
    m->side = pv_allocate(m->context, (size_t)m->rows, n * sizeof *m->side, &result);
    if (!result)
        m->turn = pv_allocate(m->context, n, n * sizeof *m->turn, &result);
    if (!result)
        m->values = pv_allocate(m->context, n, sizeof *m->values, &result);
    if (!result)
        result = pv_btf_allocate_factors(m->context, out, m->plane, kept);
    if (!result) {
        put_side_by_side(m);
        result = find_left(m, &out->factors[m->plane]);
    }
    if (!result)
        result = find_right(m, &out->factors[m->plane]);
    pv_release(m->side);
    pv_release(m->turn);
    pv_release(m->values);
    m->side = NULL, m->turn = m->values = NULL;
    return result;
}

static pave_result merge_planes(merging *m, int32_t components, pave_btf *out)
{
    pave_result result = PAVE_OK;
    m->rows = pv_btf_rows(out);
    for (m->plane = 0; m->plane < pv_btf_planes(out) && !result; m->plane++)
        result = merge_plane(m, components, out);
    return result;
}

pave_result pave_btf_merge(pave_context *context, const pave_btf *const *btfs, int32_t count, int32_t components,
                           pave_btf **out)
{
    pv_algebra algebra;
    merging m = { .context = context, .algebra = &algebra, .btfs = btfs, .count = count };
    if (out)
        *out = NULL;
    if (!context || !btfs || count < 1 || components < 1 || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = check(context, btfs, count);
    if (!result)
        result = pv_btf_copy_frame(context, btfs[0], out);
    if (result)
        return result;
    pave_btf *merged = *out;
    for (int32_t i = 1; i < count; i++)
        merged->height += btfs[i]->height;
    merged->colour = btfs[0]->colour;
    merged->joint = btfs[0]->joint;
    merged->factor_type = btfs[0]->factor_type;
    memcpy(merged->colour_space, btfs[0]->colour_space, sizeof merged->colour_space);
    pv_call call = pv_call_begin(context, "merge", 0, 1);
    result = pv_algebra_open(context, &algebra);
    if (!result) {
        result = merge_planes(&m, components, merged);
        pv_algebra_close(&algebra);
    }
    pv_call_end(context, call);
    if (result)
        pave_btf_free(out);
    return result;
}
