/* OpenBLAS, loaded when first needed and kept to one thread a call. */
#include "btf/algebra.h"

#include "base/parallel.h"
#include "util/random.h"

#include <dlfcn.h>
#include <math.h>
#include <string.h>

enum { ROW_MAJOR = 101, PLAIN = 111, TRANSPOSED = 112, UPPER = 121, STRIPE = 512, PARTS = 8, ROWS = 64 };

static void *find(void *library, const char *name)
{
    return dlsym(library, name);
}

pave_result pv_algebra_open(pave_context *context, pv_algebra *out)
{
    memset(out, 0, sizeof *out);
    out->library = dlopen("libopenblas.so.0", RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!out->library)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "factoring a BTF needs OpenBLAS, which is not installed: %s",
                       dlerror());
    *(void **)&out->sgemm = find(out->library, "cblas_sgemm");
    *(void **)&out->dgemm = find(out->library, "cblas_dgemm");
    *(void **)&out->dsyevd = find(out->library, "dsyevd_");
    *(void **)&out->dsyrk = find(out->library, "cblas_dsyrk");
    *(void **)&out->dposv = find(out->library, "dposv_");
    *(void **)&out->set_threads = find(out->library, "openblas_set_num_threads");
    *(void **)&out->get_threads = find(out->library, "openblas_get_num_threads");
    if (!out->sgemm || !out->dgemm || !out->dsyevd || !out->dsyrk || !out->dposv || !out->set_threads ||
        !out->get_threads) {
        pv_algebra_close(out);
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "this OpenBLAS has no CBLAS or no LAPACK");
    }
    out->threads_before = out->get_threads();
    out->set_threads(1);
    return PAVE_OK;
}

void pv_algebra_close(pv_algebra *algebra)
{
    if (algebra->threads_before)
        algebra->set_threads(algebra->threads_before);
    if (algebra->library)
        dlclose(algebra->library);
    memset(algebra, 0, sizeof *algebra);
}

void pv_multiply(const pv_algebra *algebra, int transpose_a, int transpose_b, int m, int n, int k, const float *a,
                 int stride_a, const float *b, int stride_b, float beta, float *c, int stride_c)
{
    algebra->sgemm(ROW_MAJOR, transpose_a ? TRANSPOSED : PLAIN, transpose_b ? TRANSPOSED : PLAIN, m, n, k, 1, a,
                   stride_a, b, stride_b, beta, c, stride_c);
}

void pv_multiply_double(const pv_algebra *algebra, int transpose_a, int transpose_b, int m, int n, int k,
                        const double *a, int stride_a, const double *b, int stride_b, double beta, double *c,
                        int stride_c)
{
    algebra->dgemm(ROW_MAJOR, transpose_a ? TRANSPOSED : PLAIN, transpose_b ? TRANSPOSED : PLAIN, m, n, k, 1, a,
                   stride_a, b, stride_b, beta, c, stride_c);
}

static void multiply_rows(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    const pv_product *p = data;
    int64_t first = (int64_t)index * ROWS, count = p->rows - first < ROWS ? p->rows - first : ROWS;
    pv_multiply(p->algebra, 0, p->transpose_b, (int)count, p->n, p->k, p->a + first * p->stride_a, p->stride_a, p->b,
                p->stride_b, p->beta, p->c + first * p->stride_c, p->stride_c);
}

pave_result pv_multiply_all(pave_context *context, pv_product *product, double from, double to)
{
    return pv_parallel(context, (int32_t)((product->rows + ROWS - 1) / ROWS), multiply_rows, product, from, to);
}

/* LAPACK gives the least first; its columns are the rows of what we hold. */
static void reverse(int n, double *matrix, double *values)
{
    for (int i = 0; i < n / 2; i++) {
        int j = n - 1 - i;
        double value = values[i];
        values[i] = values[j];
        values[j] = value;
        for (int k = 0; k < n; k++) {
            double entry = matrix[(size_t)i * n + k];
            matrix[(size_t)i * n + k] = matrix[(size_t)j * n + k];
            matrix[(size_t)j * n + k] = entry;
        }
    }
}

/* The sign of an eigenvector is free: its largest entry is made positive. */
static void fix_signs(int n, double *matrix)
{
    for (int i = 0; i < n; i++) {
        double *row = matrix + (size_t)i * n;
        int most = 0;
        for (int k = 1; k < n; k++)
            most = fabs(row[k]) > fabs(row[most]) ? k : most;
        for (int k = 0; k < n && row[most] < 0; k++)
            row[k] = k == most ? row[k] : -row[k];
        row[most] = fabs(row[most]);
    }
}

/* `job` is LAPACK's: "V" for vectors too, "N" for none. */
static pave_result find_eigen(pave_context *context, const pv_algebra *algebra, const char *job, int n, double *matrix,
                              double *values)
{
    int size = -1, whole_size = -1, info = 0, whole = 0;
    double wanted = 0;
    pave_result result = PAVE_OK;
    algebra->dsyevd(job, "L", &n, matrix, &n, values, &wanted, &size, &whole, &whole_size, &info);
    size = (int)wanted;
    whole_size = whole;
    double *room = pv_allocate(context, (size_t)size, sizeof *room, &result);
    int *whole_room = result ? NULL : pv_allocate(context, (size_t)whole_size, sizeof *whole_room, &result);
    if (!result)
        algebra->dsyevd(job, "L", &n, matrix, &n, values, room, &size, whole_room, &whole_size, &info);
    pv_release(room);
    pv_release(whole_room);
    if (!result && info)
        result = pv_fail(context, PAVE_ERR_INTERNAL, "the eigenvalues of a %d x %d matrix were not found", n, n);
    return result;
}

pave_result pv_eigen(pave_context *context, const pv_algebra *algebra, int n, double *matrix, double *values)
{
    pave_result result = find_eigen(context, algebra, "V", n, matrix, values);
    if (result)
        return result;
    reverse(n, matrix, values);
    fix_signs(n, matrix);
    return PAVE_OK;
}

pave_result pv_eigenvalues(pave_context *context, const pv_algebra *algebra, int n, double *matrix, double *values)
{
    pave_result result = find_eigen(context, algebra, "N", n, matrix, values);
    for (int i = 0; i < n / 2 && !result; i++) {
        double value = values[i];
        values[i] = values[n - 1 - i];
        values[n - 1 - i] = value;
    }
    return result;
}

/* Work on the rows of z, stripe by stripe in double, in parts whose number is fixed. */
typedef struct tall {
    const pv_algebra *algebra;
    int64_t rows;
    int n, k;
    const float *z, *y;
    float *out;
    double *stripe, *part; /* two stripes for each worker; the parts of z' z or y' z */
    const double *by;
} tall;

static int widest(const tall *t)
{
    return t->k > t->n ? t->k : t->n;
}

static int32_t stripes_of(const tall *t)
{
    return (int32_t)((t->rows + STRIPE - 1) / STRIPE);
}

/* A stripe in double, and room for another after it. */
static int widen(const tall *t, int32_t index, int32_t worker, double **out)
{
    int64_t first = (int64_t)index * STRIPE, count = t->rows - first < STRIPE ? t->rows - first : STRIPE;
    *out = t->stripe + (size_t)worker * STRIPE * (size_t)(t->n + widest(t));
    for (int64_t i = 0; i < count * t->n; i++)
        (*out)[i] = t->z[first * t->n + i];
    return (int)count;
}

static void gram_part(void *data, int32_t index, int32_t worker)
{
    const tall *t = data;
    double *wide, *sum = t->part + (size_t)index * (size_t)t->n * (size_t)t->n;
    memset(sum, 0, (size_t)t->n * (size_t)t->n * sizeof *sum);
    for (int32_t stripe = index; stripe < stripes_of(t); stripe += PARTS) {
        int count = widen(t, stripe, worker, &wide);
        t->algebra->dsyrk(ROW_MAJOR, UPPER, TRANSPOSED, t->n, count, 1, wide, t->n, 1, sum, t->n);
    }
}

static void cross_part(void *data, int32_t index, int32_t worker)
{
    const tall *t = data;
    double *wide, *sum = t->part + (size_t)index * (size_t)t->n * (size_t)t->k;
    memset(sum, 0, (size_t)t->n * (size_t)t->k * sizeof *sum);
    for (int32_t stripe = index; stripe < stripes_of(t); stripe += PARTS) {
        int count = widen(t, stripe, worker, &wide);
        double *other = wide + (size_t)STRIPE * (size_t)t->n;
        for (int64_t i = 0; i < (int64_t)count * t->k; i++)
            other[i] = t->y[(int64_t)stripe * STRIPE * t->k + i];
        pv_multiply_double(t->algebra, 1, 0, t->k, t->n, count, other, t->k, wide, t->n, 1, sum, t->n);
    }
}

static void rotate_stripe(void *data, int32_t index, int32_t worker)
{
    const tall *t = data;
    double *wide;
    int count = widen(t, index, worker, &wide);
    double *turned = wide + (size_t)STRIPE * (size_t)t->n;
    float *out = t->out + (int64_t)index * STRIPE * t->k;
    pv_multiply_double(t->algebra, 0, 1, count, t->k, t->n, wide, t->n, t->by, t->n, 0, turned, t->k);
    for (int64_t i = 0; i < (int64_t)count * t->k; i++)
        out[i] = (float)turned[i];
}

static pave_result open_tall(pave_context *context, tall *t)
{
    pave_result result = PAVE_OK;
    t->stripe = pv_allocate(context, (size_t)pv_workers(context), STRIPE * (size_t)(t->n + widest(t)) * sizeof(double),
                            &result);
    return result;
}

/* Parts are added up in their order. */
static pave_result sum_parts(pave_context *context, tall *t, pv_task *part, size_t size, double *out)
{
    int32_t parts = stripes_of(t) < PARTS ? stripes_of(t) : PARTS;
    pave_result result = open_tall(context, t);
    if (!result)
        t->part = pv_allocate(context, (size_t)parts, size * sizeof *t->part, &result);
    if (!result)
        result = pv_parallel(context, parts, part, t, 0, 0);
    if (!result)
        memcpy(out, t->part, size * sizeof *out);
    for (size_t i = size; i < (size_t)parts * size && !result; i++)
        out[i % size] += t->part[i];
    pv_release(t->stripe);
    pv_release(t->part);
    return result;
}

pave_result pv_gram(pave_context *context, const pv_algebra *algebra, int64_t rows, int n, const float *z, double *out)
{
    tall t = { .algebra = algebra, .rows = rows, .n = n, .z = z };
    pave_result result = sum_parts(context, &t, gram_part, (size_t)n * (size_t)n, out);
    for (int64_t i = 0; i < n && !result; i++) /* just the upper half was summed */
        for (int64_t k = 0; k < i; k++)
            out[i * n + k] = out[k * n + i];
    return result;
}

pave_result pv_cross(pave_context *context, const pv_algebra *algebra, int64_t rows, int n, const float *z, int k,
                     const float *y, double *out)
{
    tall t = { .algebra = algebra, .rows = rows, .n = n, .k = k, .z = z, .y = y };
    return sum_parts(context, &t, cross_part, (size_t)n * (size_t)k, out);
}

int pv_solve_positive(const pv_algebra *algebra, int n, double *matrix, int count, double *sides)
{
    int info = 0;
    algebra->dposv("L", &n, &count, matrix, &n, sides, &n, &info);
    return info == 0;
}

pave_result pv_rotate(pave_context *context, const pv_algebra *algebra, int64_t rows, int n, const float *z, int k,
                      const double *by, float *out)
{
    tall t = { .algebra = algebra, .rows = rows, .n = n, .k = k, .z = z, .out = out, .by = by };
    pave_result result = open_tall(context, &t);
    if (!result)
        result = pv_parallel(context, stripes_of(&t), rotate_stripe, &t, 0, 0);
    pv_release(t.stripe);
    return result;
}

/* So that small directions keep their digits beside large ones. */
static void scale_columns(int64_t rows, int n, float *z)
{
    for (int j = 0; j < n; j++) {
        double sum = 0;
        for (int64_t i = 0; i < rows; i++)
            sum += (double)z[i * n + j] * z[i * n + j];
        float scale = sum > 0 ? (float)(1 / sqrt(sum)) : 0;
        for (int64_t i = 0; i < rows; i++)
            z[i * n + j] *= scale;
    }
}

/* The inverse of the Cholesky factor of a Gram matrix, in its place, by which columns become orthonormal one after the
 * other. A column that hangs on those before it gets a row of zeros. */
static void invert_factor(int n, double *m)
{
    for (int j = 0; j < n; j++) {
        double *row = m + (size_t)j * (size_t)n, pivot = row[j];
        for (int k = 0; k < j; k++) { /* forward substitution with the factors found so far */
            double sum = row[k];
            const double *upper = m + (size_t)k * (size_t)n;
            for (int i = 0; i < k; i++)
                sum -= row[i] * upper[i];
            row[k] = upper[k] > 0 ? sum / upper[k] : 0;
            pivot -= row[k] * row[k];
        }
        row[j] = pivot > 1e-12 ? sqrt(pivot) : 0;
    }
    for (int j = 0; j < n; j++) {
        double *row = m + (size_t)j * (size_t)n, diagonal = row[j];
        for (int k = 0; k < j; k++) {
            double sum = 0;
            for (int i = k; i < j; i++)
                sum += row[i] * m[(size_t)i * (size_t)n + (size_t)k];
            row[k] = diagonal > 0 ? -sum / diagonal : 0;
        }
        row[j] = diagonal > 0 ? 1 / diagonal : 0;
        memset(row + j + 1, 0, (size_t)(n - 1 - j) * sizeof *row);
    }
}

/* Where nothing was left of a column, chance may find what is still missing. */
static void refill(int64_t rows, int n, const double *m, float *z)
{
    for (int j = 0; j < n; j++)
        for (int64_t i = 0; i < rows && m[(size_t)j * (size_t)n + (size_t)j] == 0; i++) {
            pv_random r = pv_draw(1, PV_DRAW_SKETCH, (uint32_t)i, (uint32_t)j, 0);
            z[i * n + j] = (float)(r.word[0] >> 8) * 0x1p-23f - 1;
        }
}

pave_result pv_orthonormalise(pave_context *context, const pv_algebra *algebra, int64_t rows, int n, float *z)
{
    pave_result result = PAVE_OK;
    size_t side = (size_t)n;
    double *matrix = pv_allocate(context, side, side * sizeof *matrix, &result);
    for (int i = 0; i < 3 && !result; i++) { /* again for what was filled in, and for what rounding left */
        scale_columns(rows, n, z);
        result = pv_gram(context, algebra, rows, n, z, matrix);
        if (result)
            break;
        invert_factor(n, matrix);
        result = pv_rotate(context, algebra, rows, n, z, n, matrix, z);
        if (!result && i < 2)
            refill(rows, n, matrix, z);
    }
    pv_release(matrix);
    return result;
}
