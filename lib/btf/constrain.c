/* What photographs demand of the coefficients: softly, as measurements with noise, and hard, as the paper has it. */
#include "btf/enlarge.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

/* Texels are moved by a matrix: [coefficient][guide], times what the guides show and the coefficients do not. */
typedef struct moving {
    const pv_enlarge *e;
    const double *gain;
    float *values; /* [texel][coefficient] */
    double *room;  /* what the coefficients miss, for each worker */
} moving;

static void move_texel(void *data, int32_t texel, int32_t worker)
{
    const moving *m = data;
    const pv_enlarge *e = m->e;
    float *x = m->values + (int64_t)texel * e->coefficients;
    double *missed = m->room + (int64_t)worker * e->guides;
    for (int32_t g = 0; g < e->guides; g++) {
        const pv_guide *guide = &e->guide[g];
        const float *own = x + e->first[guide->plane];
        missed[g] = (double)e->given.values[(int64_t)texel * e->guides + g] - guide->offset;
        for (int32_t k = 0; k < e->first[guide->plane + 1] - e->first[guide->plane]; k++)
            missed[g] -= (double)guide->row[k] * (double)own[k];
    }
    for (int32_t k = 0; k < e->coefficients; k++) {
        double sum = 0;
        for (int32_t g = 0; g < e->guides; g++)
            sum += m->gain[(int64_t)k * e->guides + g] * missed[g];
        x[k] += (float)sum;
    }
}

static pave_result move_all(const pv_enlarge *e, const double *gain, float *values)
{
    moving m = { .e = e, .gain = gain, .values = values };
    pave_result result = PAVE_OK;
    m.room = pv_allocate(e->context, (size_t)pv_workers(e->context), (size_t)e->guides * sizeof *m.room, &result);
    if (!result)
        result = pv_parallel(e->context, (int32_t)pv_texels_count(&e->made), move_texel, &m, 0, 0);
    pv_release(m.room);
    return result;
}

/* across[coefficient][guide] = spread row'; without a spread, the rows themselves. */
static void cross(const pv_enlarge *e, const double *spread, double *across)
{
    for (int32_t i = 0; i < e->coefficients; i++)
        for (int32_t g = 0; g < e->guides; g++) {
            int32_t first = e->first[e->guide[g].plane], after = e->first[e->guide[g].plane + 1];
            double sum = !spread && i >= first && i < after ? (double)e->guide[g].row[i - first] : 0;
            for (int32_t k = first; k < after && spread; k++)
                sum += spread[(int64_t)i * e->coefficients + k] * (double)e->guide[g].row[k - first];
            across[(int64_t)i * e->guides + g] = sum;
        }
}

/* inner[guide][guide] = row across. */
static void close_up(const pv_enlarge *e, const double *across, double *inner)
{
    for (int32_t a = 0; a < e->guides; a++)
        for (int32_t b = 0; b < e->guides; b++) {
            int32_t first = e->first[e->guide[a].plane], after = e->first[e->guide[a].plane + 1];
            double sum = 0;
            for (int32_t k = first; k < after; k++)
                sum += (double)e->guide[a].row[k - first] * across[(int64_t)k * e->guides + b];
            inner[a * e->guides + b] = sum;
        }
}

/* gain = across (inner + noise)^-1: the coefficients that are likeliest when a prediction errs by `spread` and a guide
 * by its noise. */
pave_result pv_enlarge_bind(pv_enlarge *e, pv_texels *made)
{
    pave_result result = PAVE_OK;
    size_t guides = (size_t)e->guides;
    double *gain = pv_allocate(e->context, (size_t)e->coefficients, guides * sizeof *gain, &result), *inner = NULL;
    if (!result)
        inner = pv_allocate(e->context, guides, guides * sizeof *inner, &result);
    if (!result) {
        cross(e, e->spread, gain);
        close_up(e, gain, inner);
        for (size_t g = 0; g < guides; g++)
            inner[g * guides + g] += e->guide[g].noise;
        if (!pv_solve_positive(&e->algebra, e->guides, inner, e->coefficients, gain))
            result = pv_fail(e->context, PAVE_ERR_INTERNAL, "what %d guides demand cannot be solved", (int)e->guides);
    }
    if (!result)
        result = move_all(e, gain, made->values);
    pv_release(gain);
    pv_release(inner);
    return result;
}

/* gain = rows' (rows rows')^+, without directions that hardly count: photographs may say the same twice. */
static pave_result pseudo_inverse(const pv_enlarge *e, double *gain)
{
    pave_result result = PAVE_OK;
    int32_t n = e->guides;
    size_t guides = (size_t)n;
    double *inner = pv_allocate(e->context, guides, guides * sizeof *inner, &result), *values = NULL, *row = NULL;
    if (!result)
        values = pv_allocate(e->context, guides, sizeof *values, &result);
    if (!result)
        row = pv_allocate(e->context, guides, sizeof *row, &result);
    if (!result) {
        cross(e, NULL, gain);
        close_up(e, gain, inner);
        result = pv_eigen(e->context, &e->algebra, n, inner, values);
    }
    for (int32_t i = 0; i < e->coefficients && !result; i++) {
        double *to = gain + (int64_t)i * n;
        memset(row, 0, guides * sizeof *row);
        for (int32_t k = 0; k < n && values[k] > 1e-8 * values[0]; k++) {
            double sum = 0;
            for (int32_t g = 0; g < n; g++)
                sum += inner[k * n + g] * to[g];
            for (int32_t g = 0; g < n; g++)
                row[g] += inner[k * n + g] * sum / values[k];
        }
        memcpy(to, row, guides * sizeof *to);
    }
    pv_release(inner);
    pv_release(values);
    pv_release(row);
    return result;
}

pave_result pv_enlarge_force(pv_enlarge *e, const float *before, const float *after, double share, float *out)
{
    pave_result result = PAVE_OK;
    int64_t count = pv_texels_count(&e->made) * e->coefficients;
    double *gain = pv_allocate(e->context, (size_t)e->coefficients, (size_t)e->guides * sizeof *gain, &result);
    for (int64_t i = 0; i < count && !result; i++)
        out[i] = (float)(share * (double)before[i] + (1 - share) * (double)after[i]);
    if (!result)
        result = pseudo_inverse(e, gain);
    if (!result)
        result = move_all(e, gain, out);
    pv_release(gain);
    return result;
}
