/* Flat vertices brought onto their lines. */
#pragma once

#include "stones/blocks.h"

/* Moves inner vertices, one after the other in blocks, `rounds` times in each of two sweeps, to where the flat ones
 * among them and their neighbours lie on the lines between corners as nearly as can be; none farther than `reach` in x
 * or y from where it was, and none so that a face would not be simple any more. Contour and border stay. */
typedef struct pv_realise_params {
    int64_t block; /* side of a block, grid units */
    int32_t rounds;
    int32_t reach; /* grid units */
    int32_t step;  /* farthest in one round, grid units */
    int32_t apart; /* sides shorter than this push their ends apart, */
    int32_t least; /* and do not become shorter than this, grid units */
} pv_realise_params;

pave_result pv_realise_flats(pave_context *context, const pv_realise_params *params, pv_tess *tess, double from,
                             double to);

/* Would all faces around a vertex be simple and counter-clockwise with the vertex there? */
int pv_tess_fits(const pv_tess *tess, int32_t vertex, pv_cell there);
