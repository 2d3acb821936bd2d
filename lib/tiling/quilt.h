/* Quilting: blocks side by side, as mode fast and mode paper lay them. */
#pragma once

#include "tiling/cut.h"
#include "tiling/search.h"

/* Mode fast: blocks of `block` px that overlap, each cut along the path through the overlap where it differs least. */
pave_result pv_quilt_lay(pave_context *context, const pave_tiling_params *params, int32_t block, int32_t overlap,
                         pv_canvas *canvas);

/* Mode paper. The blocks, in the order in which they are laid, are the caller's to release, also on failure. */
pave_result pv_paper_lay(pave_context *context, const pave_tiling_params *params, pv_canvas *canvas,
                         pv_block **blocks, int32_t *count);

/* Any place of the bank where all of a block can be used; -1: there is none. */
int32_t pv_random_place(const pv_bank *bank, int32_t width, int32_t height, uint32_t word);
