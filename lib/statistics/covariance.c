/* Covariances imposed on planes by mixing them, as little as possible.
 * Source: Portilla and Simoncelli 2000, appendix; of all mixtures with the covariance wanted the nearest is taken,
 * which is a symmetric matrix: C^-1/2 (C^1/2 D C^1/2)^1/2 C^-1/2 from C to D (Olkin and Pukelsheim 1982). Planes are
 * held against their own deviations, for some may be a thousand times as strong as others. */
#include "statistics/texture.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { SWEEPS = 40, BLOCK = 256, MATRICES = 17 };

/* Turns rows and columns p and q so that their entry vanishes. */
static void turn(int32_t n, double *a, double *v, int32_t p, int32_t q)
{
    double apq = a[p * n + q], theta = (a[q * n + q] - a[p * n + p]) / (2 * apq);
    double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1)), c = 1 / sqrt(t * t + 1), s = t * c;
    for (int32_t k = 0; k < n; k++) {
        double x = a[k * n + p], y = a[k * n + q];
        a[k * n + p] = c * x - s * y, a[k * n + q] = s * x + c * y;
    }
    for (int32_t k = 0; k < n; k++) {
        double x = a[p * n + k], y = a[q * n + k];
        a[p * n + k] = c * x - s * y, a[q * n + k] = s * x + c * y;
        x = v[k * n + p], y = v[k * n + q];
        v[k * n + p] = c * x - s * y, v[k * n + q] = s * x + c * y;
    }
}

void pv_jacobi(int32_t n, double *matrix, double *values, double *vectors)
{
    for (int32_t i = 0; i < n * n; i++)
        vectors[i] = i % (n + 1) == 0;
    for (int32_t sweep = 0; sweep < SWEEPS; sweep++) {
        double off = 0, on = 0;
        for (int32_t i = 0; i < n * n; i++)
            *(i % (n + 1) ? &off : &on) += matrix[i] * matrix[i];
        if (off <= 1e-28 * on)
            break;
        for (int32_t p = 0; p < n; p++)
            for (int32_t q = p + 1; q < n; q++)
                if (matrix[p * n + q] != 0)
                    turn(n, matrix, vectors, p, q);
    }
    for (int32_t i = 0; i < n; i++)
        values[i] = matrix[i * (n + 1)];
}

/* out = a b, a: n x k, b: k x m; with b transposed: m x k. */
static void multiply(int32_t n, int32_t k, int32_t m, const double *a, const double *b, int transposed, double *out)
{
    for (int32_t i = 0; i < n; i++)
        for (int32_t j = 0; j < m; j++) {
            double sum = 0;
            for (int32_t l = 0; l < k; l++)
                sum += a[i * k + l] * (transposed ? b[j * k + l] : b[l * m + j]);
            out[i * m + j] = sum;
        }
}

/* The matrix to a power; what is below the rounding of its greatest eigenvalue counts as nothing. */
static void raise(int32_t n, const double *matrix, double power, double *out, double *room)
{
    double *copy = room, *vectors = room + n * n, *values = vectors + n * n, most = 0;
    memcpy(copy, matrix, (size_t)(n * n) * sizeof *copy);
    pv_jacobi(n, copy, values, vectors);
    for (int32_t i = 0; i < n; i++)
        most = fmax(most, values[i]);
    for (int32_t i = 0; i < n; i++)
        values[i] = values[i] > 1e-9 * most ? pow(values[i], power) : 0;
    for (int32_t i = 0; i < n; i++)
        for (int32_t j = 0; j < n; j++) {
            double sum = 0;
            for (int32_t k = 0; k < n; k++)
                sum += vectors[i * n + k] * values[k] * vectors[j * n + k];
            out[i * n + j] = sum;
        }
}

/* Covariances of planes, each row a task. */
typedef struct products {
    int32_t count, others;
    float *const *planes, *const *fixed;
    size_t size;
    double *among, *with, *of_fixed;
} products;

static double product(const float *a, const float *b, size_t size)
{
    return pv_mean_product(a, b, (int32_t)size, 1, 0, 0);
}

static void product_row(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    const products *p = data;
    int32_t fixed = index - p->count;
    for (int32_t j = 0; j <= index && index < p->count; j++)
        p->among[index * p->count + j] = product(p->planes[index], p->planes[j], p->size);
    for (int32_t j = 0; j < p->others && index < p->count; j++)
        p->with[index * p->others + j] = product(p->planes[index], p->fixed[j], p->size);
    for (int32_t j = 0; j <= fixed; j++)
        p->of_fixed[fixed * p->others + j] = product(p->fixed[fixed], p->fixed[j], p->size);
}

static void mirror(int32_t n, double *matrix)
{
    for (int32_t i = 0; i < n; i++)
        for (int32_t j = 0; j < i; j++)
            matrix[j * n + i] = matrix[i * n + j];
}

/* new = mix * planes + add * fixed, a block of pixels a task. */
typedef struct mixing {
    int32_t count, others;
    float *const *planes, *const *fixed;
    size_t size;
    const double *mix, *add;
} mixing;

static void mix_run(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    const mixing *m = data;
    for (int32_t block = begin; block < end; block++)
        for (size_t i = (size_t)block * BLOCK; i < (size_t)(block + 1) * BLOCK && i < m->size; i++) {
            double old[1024];
            for (int32_t k = 0; k < m->count; k++)
                old[k] = m->planes[k][i];
            for (int32_t k = 0; k < m->count; k++) {
                double sum = 0;
                for (int32_t j = 0; j < m->count; j++)
                    sum += m->mix[k * m->count + j] * old[j];
                for (int32_t j = 0; j < m->others; j++)
                    sum += m->add[k * m->others + j] * (double)m->fixed[j][i];
                m->planes[k][i] = (float)sum;
            }
        }
}

/* What of the covariance the fixed planes do not explain: a - x f^-1 x'. */
static void unexplained(int32_t n, int32_t m, const double *a, const double *x, const double *inverse, double *out,
                        double *room)
{
    multiply(n, m, m, x, inverse, 0, room);
    multiply(n, m, n, room, x, 1, out);
    for (int32_t i = 0; i < n * n; i++)
        out[i] = a[i] - out[i];
}

static void deviations(int32_t n, const double *covariance, double *out)
{
    for (int32_t i = 0; i < n; i++)
        out[i] = covariance[i * (n + 1)] > 0 ? sqrt(covariance[i * (n + 1)]) : 1;
}

/* A covariance over deviations; or, with `back`, what turns such planes as what turns the planes themselves. */
static void rescale(int32_t n, int32_t m, const double *rows, const double *columns, double *matrix, int back)
{
    for (int32_t i = 0; i < n; i++)
        for (int32_t j = 0; j < m; j++)
            matrix[i * m + j] *= back ? rows[i] / columns[j] : 1 / (rows[i] * columns[j]);
}

/* The nearest mixture from one covariance to another. */
static void find_mixture(int32_t n, const double *from, const double *to, double *out, double *room)
{
    double *half = room, *inner = half + n * n, *rest = inner + n * n;
    raise(n, from, 0.5, half, rest);
    multiply(n, n, n, half, to, 0, out);
    multiply(n, n, n, out, half, 0, inner);
    raise(n, inner, 0.5, inner, rest);
    raise(n, from, -0.5, half, rest);
    multiply(n, n, n, half, inner, 0, out);
    multiply(n, n, n, out, half, 0, inner);
    memcpy(out, inner, (size_t)(n * n) * sizeof *out);
}

pave_result pv_impose_covariance(pave_context *context, int32_t count, float *const *planes, int32_t others,
                                 float *const *fixed, size_t size, const double *among, const double *with)
{
    int32_t n = count, m = others, side = n > m ? n : m;
    size_t square = (size_t)(side * side + side);
    pave_result result = PAVE_OK;
    double *room = pv_allocate_zeroed(context, MATRICES * square, sizeof *room, &result);
    if (result)
        return result;
    double *is = room, *is_with = is + square, *of_fixed = is_with + square, *inverse = of_fixed + square;
    double *from = inverse + square, *to = from + square, *mix = to + square, *add = mix + square;
    double *be = add + square, *be_with = be + square, *own = be_with + square, *theirs = own + side;
    double *rest = own + square + side; /* five more */
    products p = { n, m, planes, fixed, size, is, is_with, of_fixed };
    result = pv_parallel(context, n + m, product_row, &p, 0, 0);
    mirror(n, is);
    mirror(m, of_fixed);
    deviations(n, is, own);
    deviations(m, of_fixed, theirs);
    memcpy(be, among ? among : is, (size_t)(n * n) * sizeof *be);
    if (m)
        memcpy(be_with, with, (size_t)(n * m) * sizeof *be_with);
    rescale(n, n, own, own, is, 0);
    rescale(n, n, own, own, be, 0);
    rescale(m, m, theirs, theirs, of_fixed, 0);
    rescale(n, m, own, theirs, is_with, 0);
    rescale(n, m, own, theirs, be_with, 0);
    raise(m, of_fixed, -1, inverse, rest);
    for (int32_t i = 0; i < n * n; i++)
        mix[i] = i % (n + 1) == 0;
    if (among) {
        unexplained(n, m, is, is_with, inverse, from, rest);
        unexplained(n, m, be, be_with, inverse, to, rest);
        find_mixture(n, from, to, mix, rest);
    }
    multiply(n, n, m, mix, is_with, 0, rest);
    for (int32_t i = 0; i < n * m; i++)
        rest[i] = be_with[i] - rest[i];
    multiply(n, m, m, rest, inverse, 0, add);
    rescale(n, n, own, own, mix, 1);
    rescale(n, m, own, theirs, add, 1);
    mixing mixed = { n, m, planes, fixed, size, mix, add };
    if (!result)
        result = pv_parallel_runs(context, (int32_t)((size + BLOCK - 1) / BLOCK), 8, mix_run, &mixed, 0, 0);
    pv_release(room);
    return result;
}
