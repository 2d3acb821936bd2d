/* A plan: the windows of a pavement, with all that they follow from, for many processes to share. */
#pragma once

#include "cvd/cvd.h"
#include "field/field.h"
#include "stones/stones.h"

typedef struct pv_manifest {
    char *drawing; /* path; released by pv_manifest_free */
    uint64_t hash; /* of the drawing */
    int32_t width, height;
    pave_threshold_params threshold;
    pave_palette_params palette; /* already found */
    pave_field_params field;
    pave_cvd_params cvd;
    pave_stones_params stones;
    int32_t columns, rows, margin;
} pv_manifest;

enum { PV_MOST_WINDOWS = 1000000 };

pave_result pv_manifest_write(pave_context *context, const pv_manifest *manifest, const char *path);
pave_result pv_manifest_read(pave_context *context, const char *path, pv_manifest *out);
void pv_manifest_free(pv_manifest *manifest);

/* Window k, row by row. */
pv_rect pv_manifest_window(const pv_manifest *manifest, int32_t k);
