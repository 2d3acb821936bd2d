/* Images through codecs: PNG, JPEG, TIFF, PNM, WebP in; PNG, JPEG, TIFF out. */
#pragma once

#include "io/drawing.h"
#include "io/input.h"
#include "io/codec.h"

pave_result pv_raster_read(pave_context *context, pv_input *input, const pv_target *target);

/* Writes an image; `format` is "png", "jpeg" or "tiff". */
pave_result pv_raster_write(pave_context *context, const pave_image *image, const char *path, const char *format);

/* The same row by row, from the top. Close reports the first error, and `result` if that is one. */
typedef struct pv_raster pv_raster;
pave_result pv_raster_open(pave_context *context, const char *path, const char *format, const pv_picture *picture,
                           pv_raster **out);
pave_result pv_raster_rows(pv_raster *raster, int32_t from, int32_t to, const void *pixels);
pave_result pv_raster_close(pv_raster *raster, pave_result result);
