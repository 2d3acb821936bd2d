/* The steps of mode best. */
#pragma once

#include "tiling/cut.h"
#include "tiling/prices.h"
#include "tiling/search.h"
#include "util/random.h"

/* A copy that was cut out: where it lies on the canvas, the bank's place of its first pixel, which pixels are taken. */
typedef struct pv_copy {
    pv_area area, local; /* on the canvas and in the part */
    int32_t first;
    int64_t gain;
    uint8_t *taken;
} pv_copy;

/* One way to lay the canvas. */
typedef struct pv_attempt {
    pv_canvas canvas;
    pv_coverage coverage;
    uint8_t *fails; /* how often a pixel's seams have been tried in vain */
    uint32_t number;
    int failed;     /* there was no block to lay */
    int64_t cost;
} pv_attempt;

/* Sizes, px, that everything else follows from. */
typedef struct pv_scale {
    int32_t block;   /* side of a block at the start */
    int32_t overlap;
    int32_t window;  /* side of what is looked at around a bad seam */
    int32_t reach;   /* no copy is larger */
    int32_t places;  /* no search tries more places across and down */
    int32_t radius;  /* of the same thing twice */
    int32_t part_width, part_height; /* what one thread works on at a time */
} pv_scale;

/* What one thread works on a part of the canvas with. */
typedef struct pv_worker {
    const pave_tiling_params *params;
    const pv_scale *scale;
    pv_attempt *attempt;
    pv_canvas *canvas; /* the attempt's */
    pv_compare *compare;
    pv_repeats repeats;
    pv_prices prices;
    pv_cut cut;
    pv_copy copy; /* the best so far */
    pv_query query;
    int64_t *costs;  /* of a search */
    int32_t *heat;   /* what seams cost at each pixel of the part */
    int64_t *sums;   /* of heat above and left */
} pv_worker;

pave_result pv_worker_create(pave_context *context, const pave_tiling_params *params, const pv_scale *scale,
                             pv_attempt *attempt, pv_worker *out);
void pv_worker_free(pv_worker *worker);

/* Turns to another attempt at the same canvas. */
void pv_worker_turn(pv_worker *worker, pv_attempt *attempt);

/* A copy that is tried: the bank's place for the window's first pixel. */
typedef struct pv_candidate { int32_t place; double score; } pv_candidate;

/* candidates.c: the places whose surroundings are most like the query, best first, by what they cost there. `window`
 * is where the query lies in the worker's part. Returns how many, at most `most`. */
enum { PV_MOST_CANDIDATES = 16 };
int32_t pv_candidates_find(pv_worker *worker, const pv_scale *scale, pv_area window, pv_random *random, int32_t most,
                           pv_candidate *out);

/* Cuts a copy out of the sheet of a candidate, no larger than reach around the window. It becomes the worker's if it
 * gains more than that one. */
void pv_copy_try(pv_worker *worker, const pv_scale *scale, pv_area window, int32_t place);

/* blocks.c: lays the i-th block. Returns 0 if the exemplar has no usable one as large. */
int32_t pv_blocks_all(const pv_worker *worker);
int pv_blocks_lay(pv_worker *worker, int32_t i);

/* seams.c: what the seams of a part cost, pixel by pixel; then, as often as is wanted, the worst one is cut again, in
 * the part that repeats were counted in. Returns 0 if there is none. */
void pv_seams_find(pv_worker *worker, pv_area part);
int pv_seams_mend(pv_worker *worker, pv_random *random);

/* What all seams of a part cost. */
int64_t pv_seams_cost(pv_worker *worker, pv_area part);

/* Lays the whole canvas, or cuts again what is laid. */
pave_result pv_best_lay(pave_context *context, const pave_tiling_params *params, const pv_scale *scale,
                        pv_canvas *canvas);
