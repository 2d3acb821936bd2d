/* Dense linear algebra, by OpenBLAS, which is loaded when it is first needed. */
#pragma once

#include "base/context.h"

/* Each call runs in the thread that makes it; blocks are shared out by pv_parallel, so that no sum depends on the
 * number of threads. */
typedef struct pv_algebra {
    void *library;
    int threads_before;
    void (*sgemm)(int, int, int, int, int, int, float, const float *, int, const float *, int, float, float *, int);
    void (*dgemm)(int, int, int, int, int, int, double, const double *, int, const double *, int, double, double *,
                  int);
    void (*dsyevd)(const char *, const char *, const int *, double *, const int *, double *, double *, const int *,
                   int *, const int *, int *);
    void (*dsyrk)(int, int, int, int, int, double, const double *, int, double, double *, int);
    void (*dposv)(const char *, const int *, const int *, double *, const int *, double *, const int *, int *);
    void (*set_threads)(int);
    int (*get_threads)(void);
} pv_algebra;

pave_result pv_algebra_open(pave_context *context, pv_algebra *out);
void pv_algebra_close(pv_algebra *algebra);

/* c = a b + beta c, with a or b transposed if asked: c is m x n, the inner length k; rows, with their strides. */
void pv_multiply(const pv_algebra *algebra, int transpose_a, int transpose_b, int m, int n, int k, const float *a,
                 int stride_a, const float *b, int stride_b, float beta, float *c, int stride_c);
void pv_multiply_double(const pv_algebra *algebra, int transpose_a, int transpose_b, int m, int n, int k,
                        const double *a, int stride_a, const double *b, int stride_b, double beta, double *c,
                        int stride_c);

/* c = a b + beta c for a of many rows, or a b', shared out among the threads; progress of from..to. */
typedef struct pv_product {
    const pv_algebra *algebra;
    int64_t rows;
    int n, k; /* columns of c, and of a */
    const float *a, *b;
    float *c;
    int stride_a, stride_b, stride_c, transpose_b;
    float beta;
} pv_product;

pave_result pv_multiply_all(pave_context *context, pv_product *product, double from, double to);

/* Eigenvalues of a symmetric n x n matrix, greatest first, and its eigenvectors, which replace it: one in each row. */
pave_result pv_eigen(pave_context *context, const pv_algebra *algebra, int n, double *matrix, double *values);

/* The eigenvalues alone; the matrix is used up. */
pave_result pv_eigenvalues(pave_context *context, const pv_algebra *algebra, int n, double *matrix, double *values);

/* out = z' z, for z of rows x n. */
pave_result pv_gram(pave_context *context, const pv_algebra *algebra, int64_t rows, int n, const float *z, double *out);

/* out = y' z, for z of rows x n and y of rows x k; in parts whose number is fixed. */
pave_result pv_cross(pave_context *context, const pv_algebra *algebra, int64_t rows, int n, const float *z, int k,
                     const float *y, double *out);

/* Solves m x = b for a symmetric positive definite n x n matrix and `count` right sides, a row each; x replaces b, and
 * the matrix is used up. 0 if it is not positive definite. Runs in the thread that calls. */
int pv_solve_positive(const pv_algebra *algebra, int n, double *matrix, int count, double *sides);

/* out = z by', for z of rows x n and `by` of k x n, k <= n. `out` may be z if k is n. */
pave_result pv_rotate(pave_context *context, const pv_algebra *algebra, int64_t rows, int n, const float *z, int k,
                      const double *by, float *out);

/* Makes the columns of z (rows x n) orthonormal, each against those before it. What depends on others is replaced. */
pave_result pv_orthonormalise(pave_context *context, const pv_algebra *algebra, int64_t rows, int n, float *z);
