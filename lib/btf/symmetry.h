/* Mirrors and turns that a set of directions keeps: under them a material is another of its class. */
#pragma once

#include "btf/btf.h"

/* Elements of the group, the identity first: 1, 2 (a mirror, or a half turn) or 4 (both mirrors and the half turn). */
typedef struct pv_symmetry {
    int32_t count;
    int32_t flips[4];             /* of each element: 1 turns x round, 2 turns y round */
    int32_t *view[4], *light[4];  /* where each direction goes */
} pv_symmetry;

/* Those that views and lights both keep, direction for direction; just the identity unless `wanted`. */
pave_result pv_symmetry_find(pave_context *context, const pv_directions *views, const pv_directions *lights,
                             int wanted, pv_symmetry *out);
void pv_symmetry_free(pv_symmetry *symmetry);

/* Where each direction goes under an orthogonal matrix across the plane; 0 if one goes where there is none. */
int pv_directions_moved(const pv_directions *directions, const double across[4], int32_t *out);

/* 1 or -1: what a function of block `block` (0 .. count-1) is multiplied by under an element. */
static inline int pv_symmetry_sign(const pv_symmetry *symmetry, int32_t element, int32_t block)
{
    int32_t both = symmetry->flips[element] & block;
    return symmetry->count == 2 ? (element && block ? -1 : 1) : both == 1 || both == 2 ? -1 : 1;
}
