/* The steps of mode best. */
#pragma once

#include "tiling/cut.h"
#include "tiling/prices.h"
#include "tiling/search.h"
#include "util/random.h"

/* What one thread works on a part of the canvas with. */
typedef struct pv_worker {
    const pave_tiling_params *params;
    pv_canvas *canvas;
    const pv_coverage *coverage;
    pv_compare *compare;
    pv_repeats repeats;
    pv_prices prices;
    pv_cut cut;
    pv_query query;
    int64_t *costs;  /* of a search */
    int32_t *heat;   /* what seams cost at each pixel of the part */
    int64_t *sums;   /* of heat above and left */
} pv_worker;

/* Sizes, px, that everything else follows from. */
typedef struct pv_scale {
    int32_t block;   /* side of a block at the start */
    int32_t overlap;
    int32_t window;  /* side of what is looked at around a bad seam */
    int32_t reach;   /* no copy is larger */
    int32_t places;  /* no search tries more places across and down */
    int32_t radius;  /* of the same thing twice */
} pv_scale;

pave_result pv_worker_create(pave_context *context, const pave_tiling_params *params, const pv_scale *scale,
                             pv_canvas *canvas, const pv_coverage *coverage, int32_t most_width, int32_t most_height,
                             pv_worker *out);
void pv_worker_free(pv_worker *worker);

/* A copy that is tried: the bank's place for the window's first pixel. */
typedef struct pv_candidate { int32_t place; double score; } pv_candidate;

/* candidates.c: the places whose surroundings are most like the query, best first, by what they cost there. `window`
 * is where the query lies in the worker's part. Returns how many, at most `most`. */
enum { PV_MOST_CANDIDATES = 16 };
int32_t pv_candidates_find(pv_worker *worker, const pv_scale *scale, pv_area window, pv_random *random, int32_t most,
                           pv_candidate *out);

/* Cuts a copy out of the sheet of a candidate, no larger than reach around the window. Returns what it gains. */
int64_t pv_copy_find(pv_worker *worker, const pv_scale *scale, pv_area window, int32_t place, pv_area *area,
                     int32_t *first);

/* Lays the whole canvas, or cuts again what is laid. */
pave_result pv_best_lay(pave_context *context, const pave_tiling_params *params, const pv_scale *scale,
                        pv_canvas *canvas);
