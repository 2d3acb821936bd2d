/* Eigenspaces merged, with mirrored and turned copies of every material by blocks of parity. */
#include "btf/eigenspace.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { RUN = 256 };

static const double rank_cut = 1e-5;

/* Rows that the symmetry takes into each other are known by the first of them. */
typedef struct folding {
    pave_context *context;
    const pv_algebra *algebra;
    const pv_side *side;
    const pv_symmetry *symmetry;
    int32_t block;
    int32_t orbits;
    int32_t *row;  /* [orbit][element]: where the first row goes */
    float *scale;  /* [orbit]: the root of its length, over the elements; and its inverse */
    float *folded; /* [orbit][width] */
    double *turn[4], *values[4]; /* of each block */
    int32_t *chosen; /* [component]: block * width + place */
    int32_t components, own; /* of all blocks, of this one */
    float *left, *turned, *singular;
} folding;

static int32_t image(const folding *f, int32_t row, int32_t element)
{
    const pv_symmetry *s = f->symmetry;
    int32_t patch = f->side->patch, lights = f->side->lights;
    int32_t pairs = (int32_t)(f->side->rows / (patch * patch)), place = row / pairs, pair = row % pairs;
    int32_t x = place % patch, y = place / patch;
    x = s->flips[element] & 1 ? patch - 1 - x : x;
    y = s->flips[element] & 2 ? patch - 1 - y : y;
    return (y * patch + x) * pairs + s->view[element][pair / lights] * lights + s->light[element][pair % lights];
}

static pave_result find_orbits(folding *f)
{
    pave_result result = PAVE_OK;
    int32_t count = f->symmetry->count, rows = (int32_t)f->side->rows;
    f->row = pv_allocate(f->context, (size_t)rows, (size_t)count * sizeof *f->row, &result);
    if (!result)
        f->scale = pv_allocate(f->context, (size_t)rows, 2 * sizeof *f->scale, &result);
    for (int32_t r = 0; r < rows && !result; r++) {
        int32_t *to = f->row + (int64_t)f->orbits * count, first = 1, same = 0;
        for (int32_t k = 0; k < count; k++) {
            to[k] = image(f, r, k);
            first &= to[k] >= r;
            same += to[k] == r;
        }
        if (first) {
            f->scale[2 * f->orbits] = (float)(sqrt((double)count / same) / count);
            f->scale[2 * f->orbits++ + 1] = (float)sqrt((double)same / count);
        }
    }
    return result;
}

static void fold_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    folding *f = data;
    int32_t count = f->symmetry->count, width = f->side->width;
    for (int32_t o = begin; o < end; o++) {
        const int32_t *row = f->row + (int64_t)o * count;
        float *to = f->folded + (int64_t)o * width;
        for (int32_t j = 0; j < width; j++) {
            const float *column = f->side->values + j + (j < f->side->gap ? 0 : f->side->gap_width);
            double sum = 0;
            for (int32_t k = 0; k < count; k++)
                sum += pv_symmetry_sign(f->symmetry, k, f->block) * (double)column[(int64_t)row[k] * f->side->stride];
            to[j] = (float)(sum * (double)f->scale[2 * o]);
        }
    }
}

static pave_result fold(folding *f, int32_t block)
{
    f->block = block;
    return pv_parallel_runs(f->context, f->orbits, RUN, fold_rows, f, 0, 0);
}

static pave_result solve_block(folding *f, int32_t block)
{
    size_t width = (size_t)f->side->width;
    pave_result result = fold(f, block);
    if (!result)
        f->turn[block] = pv_allocate(f->context, width, width * sizeof(double), &result);
    if (!result)
        f->values[block] = pv_allocate(f->context, width, sizeof(double), &result);
    if (!result)
        result = pv_gram(f->context, f->algebra, f->orbits, f->side->width, f->folded, f->turn[block]);
    return result ? result : pv_eigen(f->context, f->algebra, f->side->width, f->turn[block], f->values[block]);
}

/* The greatest of all blocks, in turn. */
static void choose(folding *f)
{
    int32_t at[4] = { 0 }, most = f->components;
    double greatest = 0;
    for (f->components = 0; f->components < most; f->components++) {
        int32_t best = -1;
        for (int32_t b = 0; b < f->symmetry->count; b++)
            if (at[b] < f->side->width && (best < 0 || f->values[b][at[b]] > f->values[best][at[best]]))
                best = b;
        double value = best < 0 ? 0 : f->values[best][at[best]];
        greatest = f->components ? greatest : value;
        if (value <= 0 || value < rank_cut * rank_cut * greatest)
            break;
        f->singular[f->components] = (float)sqrt(value);
        f->chosen[f->components] = best * f->side->width + at[best]++;
    }
}

static void unfold_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    folding *f = data;
    int32_t count = f->symmetry->count, width = f->side->width;
    for (int32_t o = begin; o < end; o++)
        for (int32_t c = 0; c < f->components; c++) {
            if (f->chosen[c] / width != f->block)
                continue;
            float value = f->turned[(int64_t)o * f->own + f->chosen[c] % width] * f->scale[2 * o + 1];
            for (int32_t k = 0; k < count; k++)
                f->left[(int64_t)f->row[(int64_t)o * count + k] * f->components + c] =
                    (float)pv_symmetry_sign(f->symmetry, k, f->block) * value;
        }
}

/* U = A V / s, where A' A = V s^2 V'. */
static pave_result unfold(folding *f, int32_t block)
{
    int32_t width = f->side->width;
    pave_result result = fold(f, block);
    f->own = 0;
    for (int32_t c = 0; c < f->components; c++)
        f->own += f->chosen[c] / width == block;
    for (int64_t i = 0; i < (int64_t)f->own * width; i++)
        f->turn[block][i] /= sqrt(f->values[block][i / width]);
    if (!result && f->own)
        result = pv_rotate(f->context, f->algebra, f->orbits, width, f->folded, f->own, f->turn[block], f->turned);
    return result || !f->own ? result : pv_parallel_runs(f->context, f->orbits, RUN, unfold_rows, f, 0, 0);
}

static pave_result open_folding(folding *f)
{
    size_t most = (size_t)f->components, width = (size_t)f->side->width;
    pave_result result = find_orbits(f);
    if (!result)
        f->folded = pv_allocate(f->context, (size_t)f->orbits, width * sizeof *f->folded, &result);
    if (!result)
        f->chosen = pv_allocate(f->context, most, sizeof *f->chosen, &result);
    if (!result)
        f->singular = pv_allocate(f->context, most, sizeof *f->singular, &result);
    return result;
}

static void close_folding(folding *f)
{
    pv_release(f->row);
    pv_release(f->scale);
    pv_release(f->folded);
    pv_release(f->turned);
    pv_release(f->chosen);
    for (int32_t b = 0; b < 4; b++) {
        pv_release(f->turn[b]);
        pv_release(f->values[b]);
    }
}

static pave_result merge(folding *f)
{
    pave_result result = open_folding(f);
    for (int32_t b = 0; b < f->symmetry->count && !result; b++)
        result = solve_block(f, b);
    if (result)
        return result;
    choose(f);
    int32_t width = f->side->width, most = f->components < width ? f->components : width;
    f->left = pv_allocate(f->context, (size_t)f->side->rows, (size_t)f->components * sizeof *f->left, &result);
    if (!result)
        f->turned = pv_allocate(f->context, (size_t)f->orbits, (size_t)most * sizeof *f->turned, &result);
    for (int32_t b = 0; b < f->symmetry->count && !result; b++)
        result = unfold(f, b);
    return result;
}

pave_result pv_eigenspace(pave_context *context, const pv_algebra *algebra, const pv_side *side,
                          const pv_symmetry *symmetry, int32_t *components, float **left, float **singular)
{
    folding f = { .context = context, .algebra = algebra, .side = side, .symmetry = symmetry };
    int64_t most = (int64_t)side->width * symmetry->count;
    most = most < side->rows ? most : side->rows;
    f.components = most < *components ? (int32_t)most : *components;
    pave_result result = merge(&f);
    close_folding(&f);
    if (result) {
        pv_release(f.left);
        pv_release(f.singular);
        return result;
    }
    *components = f.components;
    *left = f.left;
    *singular = f.singular;
    return PAVE_OK;
}
