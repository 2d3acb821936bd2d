/* Flat vertices brought onto their lines. */
#pragma once

#include "stones/blocks.h"

typedef struct pv_equations {
    double xx, xy, yy, bx, by; /* sums of the normal equations for one vertex's step, in grid units */
} pv_equations;

/* Adds: the step along the unit vector n should be -rest. */
static inline void pv_add_equation(pv_equations *e, double weight, double nx, double ny, double rest)
{
    e->xx += weight * nx * nx;
    e->xy += weight * nx * ny;
    e->yy += weight * ny * ny;
    e->bx -= weight * nx * rest;
    e->by -= weight * ny * rest;
}

/* Adds what else a vertex is to heed. */
typedef void pv_pull(const void *user, const pv_tess *tess, int32_t vertex, pv_equations *e);

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
    pv_pull *pull; /* NULL: nothing */
    const void *user;
} pv_realise_params;

pave_result pv_realise_flats(pave_context *context, const pv_realise_params *params, pv_tess *tess, double from,
                             double to);

/* Would all faces around a vertex be simple and counter-clockwise with the vertex there? */
int pv_tess_fits(const pv_tess *tess, int32_t vertex, pv_cell there);
