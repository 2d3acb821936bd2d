/* Classes found: k-means on the materials' models, each the covariance of its ABRDFs, all of one length. */
#include "btf/factor.h"
#include "btf/model.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { COMPONENTS = 24, TEXELS = 1024, MOST_ROUNDS = 100 };

typedef struct clustering {
    pave_context *context;
    pv_algebra algebra;
    const pave_btf *const *btfs;
    int32_t count;
    pv_factors *factors; /* [material]: of its first channel */
    double *alike;       /* [material][material]: inner products of covariances of length 1 */
} clustering;

typedef struct reading {
    pv_values values;
    int64_t count;
    float *rest; /* the other channels', for each worker */
} reading;

static void read_column(void *user, int64_t column, int32_t worker, float *const *out)
{
    const reading *r = user;
    int64_t texels = pv_btf_texels(r->values.btf), pairs = pv_model_pairs(r->values.model);
    float *to[PV_BTF_CHANNELS] = { out[0] };
    for (int32_t c = 1; c < r->values.model->planes; c++)
        to[c] = r->rest + (worker * (int64_t)r->values.model->planes + c) * pairs;
    pv_values_read(&r->values, r->count < 2 ? 0 : column * (texels - 1) / (r->count - 1), worker, to);
}

static pave_result factor_material(clustering *c, const pave_btf_model *frame, int32_t index)
{
    reading r = { .count = pv_btf_texels(c->btfs[index]) };
    const int32_t components[1] = { COMPONENTS };
    pave_result result = pv_values_open(c->context, c->btfs[index], frame, &r.values);
    r.count = r.count < TEXELS ? r.count : TEXELS;
    if (!result)
        r.rest = pv_allocate(c->context, (size_t)pv_workers(c->context) * (size_t)frame->planes,
                             (size_t)pv_model_pairs(frame) * sizeof(float), &result);
    const pv_columns columns = { 1, pv_model_pairs(frame), r.count, read_column, &r };
    if (!result)
        result = pv_factor(c->context, &c->algebra, &columns, components, 0, 2, &c->factors[index]);
    pv_values_close(&r.values);
    pv_release(r.rest);
    return result;
}

/* <A, B> of A = U S^2 U' and B = V R^2 V': the sum of (s u'v r)^2. */
static pave_result inner_product(clustering *c, int32_t i, int32_t j, int64_t rows, double *out)
{
    const pv_factors *a = &c->factors[i], *b = &c->factors[j];
    pave_result result = PAVE_OK;
    float *cross = pv_allocate(c->context, (size_t)a->components, (size_t)b->components * sizeof *cross, &result);
    if (result)
        return result;
    pv_multiply(&c->algebra, 1, 0, a->components, b->components, (int)rows, a->left, a->components, b->left,
                b->components, 0, cross, b->components);
    *out = 0;
    for (int32_t k = 0; k < a->components * b->components; k++) {
        double value = (double)cross[k] * (double)a->singular[k / b->components] *
                       (double)b->singular[k % b->components];
        *out += value * value;
    }
    pv_release(cross);
    return PAVE_OK;
}

static pave_result compare_all(clustering *c, int64_t rows)
{
    pave_result result = PAVE_OK;
    int32_t n = c->count;
    for (int32_t i = 0; i < n && !result; i++) {
        for (int32_t j = 0; j <= i && !result; j++) {
            result = inner_product(c, i, j, rows, &c->alike[(int64_t)i * n + j]);
            c->alike[(int64_t)j * n + i] = c->alike[(int64_t)i * n + j];
        }
        if (!result)
            result = pv_progress(c->context, 0.8 + 0.2 * (i + 1) / n);
    }
    for (int32_t i = 0; i < n && !result; i++)
        for (int32_t j = 0; j < n; j++)
            if (i != j)
                c->alike[(int64_t)i * n + j] /= sqrt(fmax(c->alike[(int64_t)i * n + i] * c->alike[(int64_t)j * n + j],
                                                          1e-300));
    for (int32_t i = 0; i < n && !result; i++)
        c->alike[(int64_t)i * n + i] = 1;
    return result;
}

/* The square of how far a material is from the mean of a class. */
static double distance(const clustering *c, int32_t i, const int32_t *label, int32_t class_of)
{
    double toward = 0, within = 0, members = 0;
    for (int32_t j = 0; j < c->count; j++) {
        if (label[j] != class_of)
            continue;
        members++;
        toward += c->alike[(int64_t)i * c->count + j];
        for (int32_t k = 0; k < c->count; k++)
            within += label[k] == class_of ? c->alike[(int64_t)j * c->count + k] : 0;
    }
    return members > 0 ? 1 - 2 * toward / members + within / (members * members) : INFINITY;
}

/* Seeds: the first material, then each time the one that is farthest from all seeds. */
static void sow(const clustering *c, int32_t classes, int32_t *label)
{
    for (int32_t i = 0; i < c->count; i++)
        label[i] = -1;
    for (int32_t s = 0, next = 0; s < classes; s++) { /* those left belong to nobody, until they settle */
        label[next] = s;
        double most = -1;
        int32_t far = 0;
        for (int32_t i = 0; i < c->count; i++) {
            double nearest = INFINITY;
            for (int32_t j = 0; j < c->count && label[i] < 0; j++)
                if (label[j] >= 0)
                    nearest = fmin(nearest, 1 - c->alike[(int64_t)i * c->count + j]);
            if (label[i] < 0 && nearest > most) {
                most = nearest;
                far = i;
            }
        }
        next = far;
    }
}

static void settle(const clustering *c, int32_t classes, int32_t *label, int32_t *next)
{
    int changed = 1;
    for (int32_t round = 0; round < MOST_ROUNDS && changed; round++) {
        changed = 0;
        for (int32_t i = 0; i < c->count; i++) {
            double least = INFINITY;
            next[i] = label[i];
            for (int32_t s = 0; s < classes; s++) {
                double away = distance(c, i, label, s);
                if (away < least) {
                    least = away;
                    next[i] = s;
                }
            }
            changed |= next[i] != label[i];
        }
        memcpy(label, next, (size_t)c->count * sizeof *label);
    }
}

/* What materials differ from the means of their classes, over what they differ from that of all. */
static double share_within(const clustering *c, const int32_t *label, int32_t *zeros)
{
    double within = 0, whole = 0;
    memset(zeros, 0, (size_t)c->count * sizeof *zeros);
    for (int32_t i = 0; i < c->count; i++) {
        within += distance(c, i, label, label[i]);
        whole += distance(c, i, zeros, 0);
    }
    return whole > 0 ? within / whole : 0;
}

static pave_result find_clusters(clustering *c, const pave_btf_model *frame, int32_t classes, int32_t *labels,
                                 double *within)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)c->count;
    c->factors = pv_allocate_zeroed(c->context, n, sizeof *c->factors, &result);
    int32_t *next = result ? NULL : pv_allocate(c->context, n, sizeof *next, &result);
    if (!result)
        c->alike = pv_allocate(c->context, n, n * sizeof *c->alike, &result);
    for (int32_t i = 0; i < c->count && !result; i++) {
        pv_call call = pv_call_begin(c->context, "cluster", 0.8 * i / c->count, 0.8 * (i + 1) / c->count);
        result = factor_material(c, frame, i);
        pv_call_end(c->context, call);
    }
    if (!result)
        result = compare_all(c, pv_model_pairs(frame));
    if (!result) {
        sow(c, classes, labels);
        settle(c, classes, labels, next);
        if (within)
            *within = share_within(c, labels, next);
    }
    for (int32_t i = 0; i < c->count && c->factors; i++)
        pv_factors_free(&c->factors[i]);
    pv_release(c->factors);
    pv_release(c->alike);
    pv_release(next);
    return result;
}

pave_result pave_btf_cluster(pave_context *context, const pave_btf *const *btfs, int32_t count, int32_t classes,
                             const pave_btf_model_params *params, int32_t *labels, double *within)
{
    clustering c = { .context = context, .btfs = btfs, .count = count };
    pave_btf_model *frame = NULL;
    if (!context || !btfs || count < 1 || !labels)
        return PAVE_ERR_ARGUMENT;
    if (classes < 1 || classes > count)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%d classes of %d materials: 1 to %d can be", (int)classes, (int)count,
                       (int)count);
    pave_result result = pv_model_frame(context, btfs, count, params, &frame);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "cluster", 0, 1);
    result = pv_algebra_open(context, &c.algebra);
    if (!result) {
        result = find_clusters(&c, frame, classes, labels, within);
        pv_algebra_close(&c.algebra);
    }
    pv_call_end(context, call);
    pave_btf_model_free(&frame);
    return result;
}
