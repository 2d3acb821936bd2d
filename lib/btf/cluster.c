/* Classes found: k-means on the materials' models, the roots of the covariances of their ABRDFs, all one in length. */
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
    double (*root)[COMPONENTS * COMPONENTS]; /* [material]: of the covariance of texels about their mean */
    double *alike;       /* [material][material]: inner products of roots of length 1 */
} clustering;

typedef struct reading {
    pv_values values;
    int32_t index;
    int64_t count;
    float *rest; /* the other channels', for each worker */
} reading;

static int read_column(void *user, int64_t column, int32_t worker, float *const *out)
{
    const reading *r = user;
    int64_t texels = pv_btf_texels(r->values.btf), pairs = pv_model_pairs(r->values.model);
    float *to[PV_BTF_CHANNELS] = { out[0] };
    for (int32_t c = 1; c < r->values.model->planes; c++)
        to[c] = r->rest + (worker * (int64_t)r->values.model->planes + c) * pairs;
    return pv_values_read(&r->values, r->count < 2 ? 0 : column * (texels - 1) / (r->count - 1), worker, to);
}

static pave_result refuse_column(pave_context *context, void *user, int64_t column)
{
    const reading *r = user;
    (void)column;
    return pv_fail(context, PAVE_ERR_FORMAT, "material %d has samples that are infinite or no numbers", (int)r->index);
}

/* What texels differ from their mean, in the basis of left factors: S^2 / n less the outer product of the mean. */
static void covary(const pv_factors *f, int64_t texels, double *out)
{
    double mean[COMPONENTS] = { 0 };
    int32_t n = f->components;
    for (int64_t t = 0; t < texels; t++)
        for (int32_t k = 0; k < n; k++)
            mean[k] += (double)f->right[t * n + k] / (double)texels;
    for (int32_t i = 0; i < n; i++)
        for (int32_t k = 0; k < n; k++)
            out[i * COMPONENTS + k] =
                (i == k ? (double)f->singular[k] * (double)f->singular[k] / (double)texels : 0) - mean[i] * mean[k];
}

/* Its square root, in which strong components do not drown the others. */
static pave_result take_root(clustering *c, int32_t n, double *matrix)
{
    double vectors[COMPONENTS * COMPONENTS], values[COMPONENTS];
    for (int32_t i = 0; i < n * n; i++)
        vectors[i] = matrix[i / n * COMPONENTS + i % n];
    pave_result result = pv_eigen(c->context, &c->algebra, n, vectors, values);
    for (int32_t i = 0; i < n * n && !result; i++) {
        double sum = 0;
        for (int32_t k = 0; k < n; k++)
            sum += vectors[k * n + i / n] * vectors[k * n + i % n] * sqrt(fmax(values[k], 0));
        matrix[i / n * COMPONENTS + i % n] = sum;
    }
    return result;
}

static pave_result factor_material(clustering *c, const pave_btf_model *frame, int32_t index)
{
    reading r = { .index = index, .count = pv_btf_texels(c->btfs[index]) };
    const int32_t components[1] = { COMPONENTS };
    pave_result result = pv_values_open(c->context, c->btfs[index], frame, &r.values);
    r.count = r.count < TEXELS ? r.count : TEXELS;
    if (!result)
        r.rest = pv_allocate(c->context, (size_t)pv_workers(c->context) * (size_t)frame->planes,
                             (size_t)pv_model_pairs(frame) * sizeof(float), &result);
    const pv_columns columns = { 1, pv_model_pairs(frame), r.count, read_column, refuse_column, &r };
    if (!result)
        result = pv_factor(c->context, &c->algebra, &columns, components, 0, 2, &c->factors[index]);
    if (!result) {
        covary(&c->factors[index], r.count, c->root[index]);
        result = take_root(c, c->factors[index].components, c->root[index]);
    }
    pv_values_close(&r.values);
    pv_release(r.rest);
    return result;
}

/* <A, B> of A = U M U' and B = V N V': the sum of (M X)(X N), element by element, with X = U' V. */
static void inner_product(const clustering *c, int32_t i, int32_t j, int64_t rows, double *out)
{
    const pv_factors *a = &c->factors[i], *b = &c->factors[j];
    const double *m = c->root[i], *n = c->root[j];
    float cross[COMPONENTS * COMPONENTS];
    pv_multiply(&c->algebra, 1, 0, a->components, b->components, (int)rows, a->left, a->components, b->left,
                b->components, 0, cross, COMPONENTS);
    *out = 0;
    for (int32_t r = 0; r < a->components; r++)
        for (int32_t s = 0; s < b->components; s++) {
            double left = 0, right = 0;
            for (int32_t k = 0; k < a->components; k++)
                left += m[r * COMPONENTS + k] * (double)cross[k * COMPONENTS + s];
            for (int32_t k = 0; k < b->components; k++)
                right += (double)cross[r * COMPONENTS + k] * n[k * COMPONENTS + s];
            *out += left * right;
        }
}

static pave_result compare_all(clustering *c, int64_t rows)
{
    pave_result result = PAVE_OK;
    int32_t n = c->count;
    for (int32_t i = 0; i < n && !result; i++) {
        for (int32_t j = 0; j <= i; j++) {
            inner_product(c, i, j, rows, &c->alike[(int64_t)i * n + j]);
            c->alike[(int64_t)j * n + i] = c->alike[(int64_t)i * n + j];
        }
        result = pv_progress(c->context, 0.8 + 0.1 * (i + 1) / n);
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

/* Classes under way: distances need only inner products. */
typedef struct sharing {
    int32_t classes;
    int32_t *label, *next, *best; /* [material] */
    double *within, *members;     /* [class]: inner products of its members with each other, and their number */
} sharing;

static void weigh_classes(const clustering *c, sharing *s)
{
    memset(s->within, 0, (size_t)s->classes * sizeof *s->within);
    memset(s->members, 0, (size_t)s->classes * sizeof *s->members);
    for (int32_t i = 0; i < c->count; i++) {
        if (s->label[i] < 0)
            continue;
        s->members[s->label[i]]++;
        for (int32_t j = 0; j < c->count; j++)
            s->within[s->label[i]] += s->label[j] == s->label[i] ? c->alike[(int64_t)i * c->count + j] : 0;
    }
}

/* The square of how far a material is from the mean of a class. */
static double distance(const clustering *c, const sharing *s, int32_t i, int32_t class_of)
{
    double toward = 0, members = s->members[class_of];
    for (int32_t j = 0; j < c->count; j++)
        toward += s->label[j] == class_of ? c->alike[(int64_t)i * c->count + j] : 0;
    return members > 0 ? 1 - 2 * toward / members + s->within[class_of] / (members * members) : INFINITY;
}

/* Seeds: one material, then each time the one that is farthest from all seeds. The others belong to nobody yet. */
static void sow(const clustering *c, sharing *s, int32_t first)
{
    for (int32_t i = 0; i < c->count; i++)
        s->label[i] = -1;
    for (int32_t k = 0, next = first; k < s->classes; k++) {
        double most = -1;
        s->label[next] = k;
        for (int32_t i = 0; i < c->count; i++) {
            double nearest = INFINITY;
            for (int32_t j = 0; j < c->count; j++)
                if (s->label[j] >= 0)
                    nearest = fmin(nearest, 1 - c->alike[(int64_t)i * c->count + j]);
            if (s->label[i] < 0 && nearest > most) {
                most = nearest;
                next = i;
            }
        }
    }
}

/* Everyone joins the nearest class until nobody changes. Returns what materials differ from the means of theirs. */
static double settle(const clustering *c, sharing *s)
{
    double sum = 0;
    int changed = 1;
    for (int32_t round = 0; round < MOST_ROUNDS && changed; round++) {
        weigh_classes(c, s);
        changed = 0;
        sum = 0;
        for (int32_t i = 0; i < c->count; i++) {
            double least = INFINITY;
            for (int32_t k = 0; k < s->classes; k++) {
                double away = distance(c, s, i, k);
                if (away < least) {
                    least = away;
                    s->next[i] = k;
                }
            }
            changed |= s->next[i] != s->label[i];
            sum += least;
        }
        memcpy(s->label, s->next, (size_t)c->count * sizeof *s->label);
    }
    return sum;
}

/* From each material as the first seed; the best of all. */
static pave_result share_out(const clustering *c, sharing *s, double *least)
{
    pave_result result = PAVE_OK;
    *least = INFINITY;
    for (int32_t first = 0; first < c->count && !result; first++) {
        sow(c, s, first);
        double here = settle(c, s);
        if (here < *least) {
            *least = here;
            memcpy(s->best, s->label, (size_t)c->count * sizeof *s->best);
        }
        result = pv_progress(c->context, 0.9 + 0.1 * (first + 1) / c->count);
    }
    return result;
}

/* Numbers classes by their first materials, and tells what is left within them. */
static void hand_out(const clustering *c, sharing *s, double least, int32_t *labels, double *within)
{
    int32_t known = 0;
    double whole = 0;
    for (int32_t i = 0; i < c->count; i++) {
        labels[i] = -1;
        for (int32_t j = 0; j < i && labels[i] < 0; j++)
            labels[i] = s->best[j] == s->best[i] ? labels[j] : -1;
        labels[i] = labels[i] < 0 ? known++ : labels[i];
        s->label[i] = 0;
    }
    weigh_classes(c, s);
    for (int32_t i = 0; i < c->count; i++)
        whole += distance(c, s, i, 0);
    if (within)
        *within = whole > 0 ? least / whole : 0;
}

static pave_result find_classes(const clustering *c, int32_t classes, int32_t *labels, double *within)
{
    sharing s = { .classes = classes };
    size_t n = (size_t)c->count;
    double least;
    pave_result result = PAVE_OK;
    s.label = pv_allocate(c->context, n, 3 * sizeof *s.label, &result);
    if (!result)
        s.within = pv_allocate(c->context, (size_t)classes, 2 * sizeof *s.within, &result);
    if (!result) {
        s.next = s.label + n;
        s.best = s.next + n;
        s.members = s.within + classes;
        result = share_out(c, &s, &least);
    }
    if (!result)
        hand_out(c, &s, least, labels, within);
    pv_release(s.label);
    pv_release(s.within);
    return result;
}

static pave_result find_clusters(clustering *c, const pave_btf_model *frame, int32_t classes, int32_t *labels,
                                 double *within)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)c->count;
    c->factors = pv_allocate_zeroed(c->context, n, sizeof *c->factors, &result);
    if (!result)
        c->root = pv_allocate(c->context, n, sizeof *c->root, &result);
    if (!result)
        c->alike = pv_allocate(c->context, n, n * sizeof *c->alike, &result);
    for (int32_t i = 0; i < c->count && !result; i++) {
        pv_call call = pv_call_begin(c->context, "cluster", 0.8 * i / c->count, 0.8 * (i + 1) / c->count);
        result = factor_material(c, frame, i);
        pv_call_end(c->context, call);
    }
    if (!result)
        result = compare_all(c, pv_model_pairs(frame));
    if (!result)
        result = find_classes(c, classes, labels, within);
    for (int32_t i = 0; i < c->count && c->factors; i++)
        pv_factors_free(&c->factors[i]);
    pv_release(c->factors);
    pv_release(c->root);
    pv_release(c->alike);
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
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%d classes of %d materials: 1 to %d can be", (int)classes,
                       (int)count, (int)count);
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
