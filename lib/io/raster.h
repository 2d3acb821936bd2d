/* Images through the module: PNG, JPEG, TIFF, PNM, WebP in; PNG, JPEG, TIFF out. */
#pragma once

#include "image/bitmap.h"
#include "io/oiio.h"

/* Decodes a file that is in memory; its bytes are changed. */
pave_result pv_raster_read(pave_context *context, const char *path, uint8_t *bytes, size_t size, pave_image **out);

/* The same as a drawing, band by band. */
pave_result pv_raster_read_drawing(pave_context *context, const char *path, uint8_t *bytes, size_t size,
                                   const pave_threshold_params *threshold, pv_bitmap *out);

/* Writes an image; `format` is "png", "jpeg" or "tiff". */
pave_result pv_raster_write(pave_context *context, const pave_image *image, const char *path, const char *format);

/* The same row by row, from the top. Close reports the first error, and `result` if that is one. */
typedef struct pv_raster pv_raster;
pave_result pv_raster_open(pave_context *context, const char *path, const char *format, const pv_picture *picture,
                           pv_raster **out);
pave_result pv_raster_rows(pv_raster *raster, int32_t from, int32_t to, const void *pixels);
pave_result pv_raster_close(pv_raster *raster, pave_result result);
