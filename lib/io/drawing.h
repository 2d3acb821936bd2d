/* Drawing files that are too large to be decoded at once. */
#pragma once

#include "image/bitmap.h"

/* Reads an image file as a drawing with one bit a pixel, band by band: what is decoded is never held as a whole, but
 * for OpenEXR files. */
pave_result pv_drawing_read(pave_context *context, const char *path, const pave_threshold_params *threshold,
                            pv_bitmap *out);
