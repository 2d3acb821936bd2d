/* What photographs demand of the coefficients, as the paper has it (Eqs. 4 to 6). */
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

/* across[coefficient][guide]: the rows themselves. */
static void cross(const pv_enlarge *e, double *across)
{
    for (int32_t i = 0; i < e->coefficients; i++)
        for (int32_t g = 0; g < e->guides; g++) {
            int32_t first = e->first[e->guide[g].plane], after = e->first[e->guide[g].plane + 1];
            across[(int64_t)i * e->guides + g] = i >= first && i < after ? (double)e->guide[g].row[i - first] : 0;
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
        cross(e, gain);
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
