/* Coefficients from some of a basis's rows: the pseudo-inverse, and the ridge with the model's prior. */
#pragma once

#include "btf/algebra.h"

/* The singular value decomposition of the rows seen, W S V', each column scaled by its deviation. */
typedef struct pv_system {
    int32_t equations, unknowns, rank;
    double *values; /* S, falling */
    float *from;    /* [equation][rank]: W */
    float *to;      /* [unknown][rank]: V, scaled by the deviations */
} pv_system;

/* `rows` is [equation][stride], of which the first `unknowns` count. Without deviations (NULL) they are 1. Singular
 * values below `cut` of the greatest do not count. */
pave_result pv_system_open(pave_context *context, const pv_algebra *algebra, const float *rows, int32_t equations,
                           int32_t unknowns, int32_t stride, const float *deviations, double cut, pv_system *out);
void pv_system_close(pv_system *system);

/* What a singular direction counts with noise of that variance: s / (s^2 + noise). */
static inline double pv_system_gain(const pv_system *system, int32_t k, double noise)
{
    return system->values[k] / (system->values[k] * system->values[k] + noise);
}

/* How much what was measured surprises the model, 1 on the mean if it is right; `known` is W' times it. */
double pv_system_surprise(const pv_system *system, double noise, const float *measured, const float *known);

/* The sum of the variances of all coefficients that is left, of `whole` before. */
double pv_system_left(const pv_system *system, double whole, double noise);
