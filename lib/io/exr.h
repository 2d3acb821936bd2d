/* OpenEXR files, through OpenEXRCore. */
#pragma once

#include "io/drawing.h"
#include "io/input.h"

/* Reads single-part flat images, scanlines or the full level of tiles, compressed with NONE, RLE, ZIPS or ZIP.
 * Channels of one type keep it, half with float becomes float; R, G, B, A come first. */
pave_result pv_exr_read(pave_context *context, pv_input *input, const pv_target *target);

/* Writes all channels by name, ZIP-compressed, in linear light and premultiplied as EXR wants it. PAVE_U8 becomes
 * half, PAVE_U16 float, the others stay. */
pave_result pv_exr_write(pave_context *context, const pave_image *image, const char *path);

/* "3.1.5" */
void pv_exr_version(char *text, size_t capacity);
