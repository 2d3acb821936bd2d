/* The diagram from inside. */
#pragma once

#include "backend/backend.h"
#include "base/params.h"

extern const pv_table pv_cvd_table;

struct pave_cvd {
    int32_t width, height, site_count;
    int32_t *labels;
    pave_site *sites;
    pave_cvd_params params; /* half_side as it was used */
    int32_t backend;
    char backend_name[128];
};

/* seeds.c: draws the first sites of a plane and names their homes. Both arrays are the caller's to release. */
pave_result pv_seeds(pave_context *context, const pave_cvd_params *params, const pv_plane *plane, pave_site **sites,
                     pv_home **homes, int32_t *count);
