/* Flat vertices brought onto their lines. */
#pragma once

#include "stones/blocks.h"
#include "stones/rows.h"

/* Adds what else a vertex is to heed. */
typedef void pv_pull(const void *user, const pv_tess *tess, int32_t vertex, pv_equations *e);

/* Moves vertices, block by block in two sweeps, `rounds` times each, to where the flat ones lie on the lines between
 * corners as nearly as can be; none farther than `reach` in x or y from where it was, and none so that a face would not
 * be simple any more. The border stays, and so do corners of contours; elsewhere contours give way by `sway`. */
typedef struct pv_realise_params {
    int64_t block; /* side of a block, grid units */
    int32_t rounds;
    int32_t reach; /* grid units */
    int32_t step;  /* farthest in one round, grid units */
    int32_t apart; /* whole sides of faces that are shorter than this push their ends apart, */
    int32_t least; /* and do not become shorter than this, grid units */
    int32_t sway;  /* grid units */
    int64_t most;  /* faces do not become larger than this, square grid units; 0: as large as they like */
    pv_pull *pull; /* NULL: nothing */
    const void *user;
} pv_realise_params;

pave_result pv_realise_flats(pave_context *context, const pv_realise_params *params, pv_tess *tess, double from,
                             double to);
