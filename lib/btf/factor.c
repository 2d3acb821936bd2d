/* Randomised subspace iteration over blocks of columns (Halko, Martinsson and Tropp 2011, 4.5). */
#include "btf/factor.h"

#include "base/parallel.h"
#include "util/random.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 512, GROUP = 64, STRIPE = 2048, SPARE = 16 };

/* One matrix, A': columns x rows, seen through a basis of `width` vectors. */
typedef struct plane {
    int32_t width;
    float *basis; /* [row][width], orthonormal */
    float *sum;   /* [row][width], of A' A basis */
    float *seen;  /* [column of the block][width], A basis */
    double *inner, *part; /* [width][width], of basis' A' A basis; what a block adds */
    float *block; /* [column of the block][row], A */
    double energy;
} plane;

typedef struct work {
    const pv_columns *columns;
    const pv_algebra *algebra;
    pv_factors *out;
    plane plane[PV_BTF_CHANNELS];
    double *energy; /* [column of the block][plane] */
    int64_t first;  /* column of the block */
    int32_t count;  /* of its columns */
} work;

static void read_column(void *data, int32_t index, int32_t worker)
{
    work *w = data;
    const pv_columns *columns = w->columns;
    float *out[PV_BTF_CHANNELS];
    for (int32_t c = 0; c < columns->planes; c++)
        out[c] = w->plane[c].block + (size_t)index * (size_t)columns->rows;
    double none = columns->read(columns->user, w->first + index, worker, out) ? 0 : NAN;
    for (int32_t c = 0; c < columns->planes; c++) {
        double energy = none;
        for (int64_t r = 0; r < columns->rows; r++)
            energy += (double)out[c][r] * out[c][r];
        w->energy[index * columns->planes + c] = energy;
    }
}

static int32_t groups(const work *w)
{
    return (w->count + GROUP - 1) / GROUP;
}

static int32_t stripes(const work *w)
{
    return (int32_t)((w->columns->rows + STRIPE - 1) / STRIPE);
}

static int least(int64_t a, int64_t b)
{
    return (int)(a < b ? a : b);
}

static void see_group(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    const work *w = data;
    const plane *p = &w->plane[index / groups(w)];
    int32_t first = index % groups(w) * GROUP;
    pv_multiply(w->algebra, 0, 0, least(GROUP, w->count - first), p->width, (int)w->columns->rows,
                p->block + (size_t)first * (size_t)w->columns->rows, (int)w->columns->rows, p->basis, p->width, 0,
                p->seen + (size_t)first * (size_t)p->width, p->width);
}

static void sum_stripe(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    const work *w = data;
    const plane *p = &w->plane[index / stripes(w)];
    int64_t first = (int64_t)(index % stripes(w)) * STRIPE;
    pv_multiply(w->algebra, 1, 0, least(STRIPE, w->columns->rows - first), p->width, w->count, p->block + first,
                (int)w->columns->rows, p->seen, p->width, 1, p->sum + (size_t)first * (size_t)p->width, p->width);
}

static pave_result check_energy(pave_context *context, const work *w)
{
    for (int32_t i = 0; i < w->count * w->columns->planes; i++)
        if (!isfinite(w->energy[i]))
            return w->columns->refuse(context, w->columns->user, w->first + i / w->columns->planes);
    return PAVE_OK;
}

/* Reads a block of columns and looks at it through the bases. */
static pave_result see_block(pave_context *context, work *w, double from, double to)
{
    double half = from + 0.5 * (to - from);
    w->count = least(BLOCK, w->columns->count - w->first);
    pave_result result = pv_parallel(context, w->count, read_column, w, from, half);
    if (!result)
        result = check_energy(context, w);
    return result ? result : pv_parallel(context, groups(w) * w->columns->planes, see_group, w, half, to);
}

static void add_energy(work *w)
{
    for (int32_t i = 0; i < w->count * w->columns->planes; i++)
        w->plane[i % w->columns->planes].energy += w->energy[i];
}

static pave_result add_inner(pave_context *context, work *w)
{
    pave_result result = PAVE_OK;
    for (int32_t c = 0; c < w->columns->planes && !result; c++) {
        plane *p = &w->plane[c];
        result = pv_gram(context, w->algebra, w->count, p->width, p->seen, p->part);
        for (int64_t i = 0; i < (int64_t)p->width * p->width && !result; i++)
            p->inner[i] += p->part[i];
    }
    return result;
}

/* The sum, turned to singular directions first (Rayleigh and Ritz), so that small ones keep their digits. */
static pave_result renew_basis(pave_context *context, work *w, plane *p)
{
    float *swap = p->basis;
    pave_result result = pv_eigen(context, w->algebra, p->width, p->inner, p->part);
    if (!result)
        result = pv_rotate(context, w->algebra, w->columns->rows, p->width, p->sum, p->width, p->inner, p->sum);
    p->basis = p->sum;
    p->sum = swap;
    return result ? result : pv_orthonormalise(context, w->algebra, w->columns->rows, p->width, p->basis);
}

/* basis := an orthonormal basis of A' A basis. */
static pave_result iterate(pave_context *context, work *w, double from, double to)
{
    int32_t planes = w->columns->planes;
    int64_t count = w->columns->count;
    pave_result result = PAVE_OK;
    for (int32_t c = 0; c < planes; c++) {
        size_t width = (size_t)w->plane[c].width;
        memset(w->plane[c].sum, 0, (size_t)w->columns->rows * width * sizeof(float));
        memset(w->plane[c].inner, 0, width * width * sizeof(double));
    }
    for (w->first = 0; w->first < count && !result; w->first += BLOCK) {
        double a = from + (to - from) * (double)w->first / (double)count;
        double b = from + (to - from) * (double)least(w->first + BLOCK, count) / (double)count;
        result = see_block(context, w, a, 0.6 * a + 0.4 * b);
        if (!result)
            result = add_inner(context, w);
        if (!result)
            result = pv_parallel(context, stripes(w) * planes, sum_stripe, w, 0.6 * a + 0.4 * b, b);
    }
    for (int32_t c = 0; c < planes && !result; c++)
        result = renew_basis(context, w, &w->plane[c]);
    return result;
}

/* A basis, which becomes each matrix's right factor before it is rotated. */
static pave_result project(pave_context *context, work *w, double from, double to)
{
    int64_t count = w->columns->count;
    pave_result result = PAVE_OK;
    for (w->first = 0; w->first < count && !result; w->first += BLOCK) {
        result = see_block(context, w, from + (to - from) * (double)w->first / (double)count,
                           from + (to - from) * (double)least(w->first + BLOCK, count) / (double)count);
        add_energy(w);
        for (int32_t c = 0; c < w->columns->planes && !result; c++)
            memcpy(w->out[c].right + w->first * w->plane[c].width, w->plane[c].seen,
                   (size_t)w->count * (size_t)w->plane[c].width * sizeof(float));
    }
    return result;
}

/* As many components as the error asks for, or as were asked for; the error that remains. */
static int32_t choose_components(const work *w, double error, int32_t c, const double *values)
{
    const plane *p = &w->plane[c];
    pv_factors *f = &w->out[c];
    int32_t most = least(f->components, p->width), k = 0;
    double left = p->energy;
    while (k < most && (error == 0 || left > error * error * p->energy))
        left -= fmax(values[k++], 0);
    f->error = p->energy > 0 ? sqrt(fmax(left, 0) / p->energy) : 0;
    return k ? k : 1;
}

/* Rotates a matrix's basis and its projection to singular vectors, and keeps the greatest. */
static pave_result finish_plane(pave_context *context, double error, work *w, int32_t c)
{
    plane *p = &w->plane[c];
    pv_factors *f = &w->out[c];
    int64_t count = w->columns->count;
    pave_result result = PAVE_OK;
    double *turn = pv_allocate(context, (size_t)p->width, (size_t)p->width * sizeof *turn, &result), *values = NULL;
    float *right = NULL;
    if (!result)
        values = pv_allocate(context, (size_t)p->width, sizeof *values, &result);
    if (!result)
        result = pv_gram(context, w->algebra, count, p->width, f->right, turn);
    if (!result)
        result = pv_eigen(context, w->algebra, p->width, turn, values);
    int32_t k = result ? 0 : choose_components(w, error, c, values);
    if (!result)
        right = pv_allocate(context, (size_t)count, (size_t)k * sizeof *right, &result);
    if (!result)
        result = pv_rotate(context, w->algebra, count, p->width, f->right, k, turn, right);
    if (!result)
        result = pv_rotate(context, w->algebra, w->columns->rows, p->width, p->basis, k, turn, f->left);
    for (int32_t i = 0; i < k && !result; i++)
        f->singular[i] = (float)sqrt(fmax(values[i], 0));
    pv_release(turn);
    pv_release(values);
    if (right) {
        pv_release(f->right);
        f->right = right;
        f->components = k;
    }
    return result;
}

static pave_result allocate(pave_context *context, const pv_columns *columns, int32_t width, pv_factors *out)
{
    pave_result result = PAVE_OK;
    size_t bytes = (size_t)width * sizeof(float);
    memset(out, 0, sizeof *out);
    out->singular = pv_allocate(context, 1, bytes, &result);
    if (!result)
        out->left = pv_allocate(context, (size_t)columns->rows, bytes, &result);
    if (!result)
        out->right = pv_allocate(context, (size_t)columns->count, bytes, &result);
    return result;
}

static pave_result open_plane(pave_context *context, work *w, int32_t c, int32_t components)
{
    plane *p = &w->plane[c];
    int64_t rows = w->columns->rows;
    int64_t room = components + (components / 8 > SPARE ? components / 8 : SPARE);
    p->width = least(least(room, rows), w->columns->count);
    pave_result result = allocate(context, w->columns, p->width, &w->out[c]);
    size_t width = (size_t)p->width * sizeof(float);
    if (!result)
        p->basis = pv_allocate(context, (size_t)rows, width, &result);
    if (!result)
        p->sum = pv_allocate(context, (size_t)rows, width, &result);
    if (!result)
        p->seen = pv_allocate(context, BLOCK, width, &result);
    if (!result)
        p->block = pv_allocate(context, BLOCK, (size_t)rows * sizeof(float), &result);
    if (!result)
        p->inner = pv_allocate(context, (size_t)p->width, (size_t)p->width * sizeof *p->inner, &result);
    if (!result)
        p->part = pv_allocate(context, (size_t)p->width, (size_t)p->width * sizeof *p->part, &result);
    for (int64_t i = 0; i < rows * p->width && !result; i++) {
        pv_random r = pv_draw(0, PV_DRAW_SKETCH, (uint32_t)i, (uint32_t)(i >> 32), (uint32_t)c);
        p->basis[i] = (float)(r.word[0] >> 8) * 0x1p-23f - 1;
    }
    w->out[c].components = least(components, p->width);
    return result ? result : pv_orthonormalise(context, w->algebra, rows, p->width, p->basis);
}

static void close_work(work *w)
{
    pv_release(w->energy);
    for (int32_t c = 0; c < PV_BTF_CHANNELS; c++) {
        pv_release(w->plane[c].basis);
        pv_release(w->plane[c].sum);
        pv_release(w->plane[c].seen);
        pv_release(w->plane[c].block);
        pv_release(w->plane[c].inner);
        pv_release(w->plane[c].part);
    }
}

void pv_factors_free(pv_factors *factors)
{
    pv_release(factors->left);
    pv_release(factors->right);
    pv_release(factors->singular);
    memset(factors, 0, sizeof *factors);
}

pave_result pv_factor(pave_context *context, const pv_algebra *algebra, const pv_columns *columns,
                      const int32_t *components, double error, int32_t passes, pv_factors *out)
{
    work w = { .columns = columns, .algebra = algebra, .out = out };
    pave_result result = PAVE_OK;
    memset(out, 0, (size_t)columns->planes * sizeof *out);
    w.energy = pv_allocate(context, BLOCK, (size_t)columns->planes * sizeof *w.energy, &result);
    for (int32_t c = 0; c < columns->planes && !result; c++)
        result = open_plane(context, &w, c, components[c]);
    for (int32_t i = 0; i + 1 < passes && !result; i++)
        result = iterate(context, &w, (double)i / passes, (double)(i + 1) / passes);
    if (!result)
        result = project(context, &w, 1 - 1.0 / passes, 1);
    for (int32_t c = 0; c < columns->planes && !result; c++)
        result = finish_plane(context, error, &w, c);
    close_work(&w);
    for (int32_t c = 0; c < columns->planes && result; c++)
        pv_factors_free(&out[c]);
    return result;
}
