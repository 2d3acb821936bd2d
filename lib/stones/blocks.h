/* Work shared out by place: vertices in the blocks of a lattice that belongs to the plane, so that neither window nor
 * thread matters to what is done in which order. */
#pragma once

#include "base/parallel.h"
#include "stones/twins.h"

typedef struct pv_blocks {
    pv_tess *tess;
    pv_twins twins;
    int32_t across, down;
    int64_t *first;    /* block b has vertex[first[b]] .. vertex[first[b + 1] - 1], ascending */
    int32_t *vertex;   /* those that may be worked on: of faces that lie in 2 x 2 blocks at most */
} pv_blocks;

typedef void pv_block_task(void *data, const int32_t *vertices, int64_t count);

/* Blocks of `side` x `side` grid units, moved by half of that if `shifted`. In a plane that repeats as many fit into a
 * period as come nearest to that, but an even number; of a period that is all there only the blocks of that one work,
 * and copies of their vertices follow after each turn. */
pave_result pv_blocks_build(pave_context *context, pv_tess *tess, int64_t side, int shifted, pv_blocks *out);

/* Calls task(data, ...) for every block with vertices, every fourth block at once. No two that run at once have a face
 * in common, so that what is done in a block depends on blocks at most three away. */
pave_result pv_blocks_run(pave_context *context, const pv_blocks *blocks, pv_block_task *task, void *data, double from,
                          double to);
void pv_blocks_free(pv_blocks *blocks);

/* How long blocks are along a line with this period, 0: none. */
int64_t pv_block_length(int64_t side, int64_t period);
