/* Parameter tables from inside: one row a field. A stage defines its table beside its params struct's code. */
#pragma once

#include "base/context.h"

#include <pave/params.h>

typedef struct pv_param {
    const char *name;
    int32_t type;
    const char *unit;
    double least, greatest;
    const char *choices;
    const char *help;
    size_t offset;
} pv_param;

typedef struct pv_table {
    const char *name;
    size_t size;
    const void *defaults; /* a struct made by PAVE_X_PARAMS_INIT */
    const pv_param *rows;
    int32_t count;
} pv_table;

#define PV_REAL(S, field, unit, least, greatest, help) \
    { #field, PAVE_PARAM_REAL, unit, least, greatest, NULL, help, offsetof(S, field) }
#define PV_INTEGER(S, field, unit, least, greatest, help) \
    { #field, PAVE_PARAM_INTEGER, unit, least, greatest, NULL, help, offsetof(S, field) }
#define PV_LONG(S, field, unit, least, greatest, help) \
    { #field, PAVE_PARAM_LONG, unit, least, greatest, NULL, help, offsetof(S, field) }
#define PV_SEED(S, field, help) \
    { #field, PAVE_PARAM_SEED, "", 0, 18446744073709551615.0, NULL, help, offsetof(S, field) }
#define PV_FLAG(S, field, help) { #field, PAVE_PARAM_FLAG, "", 0, 1, NULL, help, offsetof(S, field) }
#define PV_CHOICE(S, field, choices, help) { #field, PAVE_PARAM_CHOICE, "", 0, -1, choices, help, offsetof(S, field) }
#define PV_WINDOW(S, field, help) { #field, PAVE_PARAM_WINDOW, "px", 0, 1 << 20, NULL, help, offsetof(S, field) }
#define PV_EXTENT(S, field, name, help) \
    { name, PAVE_PARAM_EXTENT, "px", 0, 1 << 20, NULL, help, offsetof(S, field) }
#define PV_TABLE(name, defaults, rows) \
    { name, sizeof(defaults), &(defaults), rows, (int32_t)(sizeof(rows) / sizeof(*(rows))) }

extern const pv_table pv_context_table, pv_limits_table;

/* Fills a caller's struct of `size` bytes with defaults; bytes past what is known here become 0. */
void pv_params_init(const pv_table *table, void *params, size_t size);

/* Reads a caller's struct, of any version or NULL, into `out` (of table->size), and checks every field's range. */
pave_result pv_params_read(pave_context *context, const pv_table *table, const void *given, void *out);

/* Size-first structs without a table are read by the same rule. */
pave_result pv_struct_read(pave_context *context, const char *name, const void *defaults, size_t known,
                           const void *given, void *out);

/* Have two structs the same values in the fields before `end` (a field's offset, or the struct's size)? Structs have
 * padding, so their bytes do not tell. */
int pv_params_same(const pv_table *table, const void *a, const void *b, size_t end);

pave_result pv_param_describe(const pv_table *table, int32_t index, pave_param *out);
pave_result pv_param_set(pave_context *context, const pv_table *table, void *params, const char *name,
                         const char *value);
