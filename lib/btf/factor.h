/* Truncated singular value decompositions of matrices that may be larger than memory. */
#pragma once

#include "btf/algebra.h"
#include "btf/btf.h"

/* Some matrices of the same shape, read together, column by column. */
typedef struct pv_columns {
    int32_t planes; /* matrices, at most PV_BTF_CHANNELS */
    int64_t rows, count;
    /* Rows of each, in any thread; 0 if they are infinite or no numbers, about which `refuse` fails then. */
    int (*read)(void *user, int64_t column, int32_t worker, float *const *out);
    pave_result (*refuse)(pave_context *context, void *user, int64_t column);
    void *user;
} pv_columns;

/* Factors each: at most components[c], or as many as the relative `error` takes unless that is 0. */
pave_result pv_factor(pave_context *context, const pv_algebra *algebra, const pv_columns *columns,
                      const int32_t *components, double error, int32_t passes, pv_factors *out);

void pv_factors_free(pv_factors *factors);
