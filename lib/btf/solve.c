/* Coefficients from some of a basis's rows: a thin singular value decomposition through the smaller Gram matrix. */
#include "btf/solve.h"

#include <math.h>
#include <string.h>

/* The rows, or what is across them: the longer side down. */
static void lay_out(const float *rows, int32_t equations, int32_t unknowns, int32_t stride, const float *deviations,
                    float *out)
{
    int tall = equations >= unknowns;
    for (int64_t i = 0; i < equations; i++)
        for (int64_t k = 0; k < unknowns; k++)
            out[tall ? i * unknowns + k : k * equations + i] = rows[i * stride + k] * (deviations ? deviations[k] : 1);
}

/* Eigenvectors of the Gram matrix are one side; the rows turned by them, over the singular values, are the other. */
static pave_result decompose(pave_context *context, const pv_algebra *algebra, float *z, double cut, pv_system *s)
{
    int tall = s->equations >= s->unknowns;
    int32_t n = tall ? s->unknowns : s->equations, longer = tall ? s->equations : s->unknowns;
    float **across = tall ? &s->from : &s->to, **along = tall ? &s->to : &s->from;
    pave_result result = PAVE_OK;
    double *turn = pv_allocate(context, (size_t)n, (size_t)n * sizeof *turn, &result);
    if (!result)
        s->values = pv_allocate(context, (size_t)n, sizeof *s->values, &result);
    if (!result)
        result = pv_gram(context, algebra, longer, n, z, turn);
    if (!result)
        result = pv_eigen(context, algebra, n, turn, s->values);
    for (int32_t k = 0; k < n && !result; k++) {
        s->values[k] = sqrt(fmax(s->values[k], 0));
        if (s->values[k] <= 0 || s->values[k] < cut * s->values[0])
            break;
        s->rank++;
    }
    size_t rank = (size_t)s->rank;
    if (!result)
        *across = pv_allocate(context, (size_t)longer, rank * sizeof(float), &result);
    if (!result)
        *along = pv_allocate(context, (size_t)n, rank * sizeof(float), &result);
    for (size_t k = 0; k < rank && !result; k++)
        for (int32_t i = 0; i < n; i++) {
            (*along)[(size_t)i * rank + k] = (float)turn[k * (size_t)n + (size_t)i];
            turn[k * (size_t)n + (size_t)i] /= s->values[k];
        }
    if (!result && rank)
        result = pv_rotate(context, algebra, longer, n, z, s->rank, turn, *across);
    pv_release(turn);
    return result;
}

pave_result pv_system_open(pave_context *context, const pv_algebra *algebra, const float *rows, int32_t equations,
                           int32_t unknowns, int32_t stride, const float *deviations, double cut, pv_system *out)
{
    pave_result result = PAVE_OK;
    memset(out, 0, sizeof *out);
    out->equations = equations;
    out->unknowns = unknowns;
    float *z = pv_allocate(context, (size_t)equations, (size_t)unknowns * sizeof *z, &result);
    if (!result) {
        lay_out(rows, equations, unknowns, stride, deviations, z);
        result = decompose(context, algebra, z, cut, out);
    }
    for (int64_t i = 0; i < (int64_t)unknowns * out->rank && deviations && !result; i++)
        out->to[i] *= deviations[i / out->rank];
    pv_release(z);
    if (result)
        pv_system_close(out);
    return result;
}

void pv_system_close(pv_system *system)
{
    pv_release(system->values);
    pv_release(system->from);
    pv_release(system->to);
    memset(system, 0, sizeof *system);
}

double pv_system_left(const pv_system *system, double whole, double noise)
{
    for (int32_t k = 0; k < system->rank; k++) {
        double length = 0, s = system->values[k];
        for (int32_t i = 0; i < system->unknowns; i++) {
            double to = (double)system->to[(int64_t)i * system->rank + k];
            length += to * to;
        }
        whole -= length * s * pv_system_gain(system, k, noise);
    }
    return fmax(whole, 0);
}

double pv_system_surprise(const pv_system *system, double noise, const float *measured, const float *known)
{
    double sum = 0;
    for (int32_t i = 0; i < system->equations; i++)
        sum += (double)measured[i] * (double)measured[i];
    for (int32_t k = 0; k < system->rank; k++)
        sum -= (double)known[k] * (double)known[k] * system->values[k] * pv_system_gain(system, k, noise);
    return fmax(sum, 0) / (noise * system->equations);
}
