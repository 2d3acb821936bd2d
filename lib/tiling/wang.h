/* Sets of Wang tiles. */
#pragma once

#include "tiling/best.h"

/* Lays a complete set on a canvas that wraps, whose sides are multiples of the number of tiles; fills the index. */
pave_result pv_wang_lay(pave_context *context, const pv_scale *scale, pv_canvas *canvas, pave_tiling *tiling);
