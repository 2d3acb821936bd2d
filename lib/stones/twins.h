/* Copies of vertices in a plane that repeats. */
#pragma once

#include "stones/tess.h"

typedef struct pv_twins {
    int32_t count;
    int32_t *copy, *original;
    pv_cell *away; /* the copy from its original */
} pv_twins;

/* Originals are marked, one of each vertex; the others are found by their places. */
pave_result pv_twins_find(pave_context *context, const pv_tess *tess, const uint8_t *originals, pv_twins *out);

/* Puts copies where their originals are, flat in the same faces. */
void pv_twins_follow(const pv_twins *twins, pv_tess *tess);
void pv_twins_free(pv_twins *twins);
