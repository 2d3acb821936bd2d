/* Files in and out. A file is written beside its target and renamed when it is complete: whatever happens, the target
 * is the old file or the whole new one. Devices and pipes are written directly. */
#ifndef PAVE_IO_H
#define PAVE_IO_H

#include <pave/stones.h>
#include <pave/tiling.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads an image. The format follows from the first bytes: OpenEXR by this library; PNG, JPEG, TIFF, PNM and WebP by
 * a module that is loaded then. Palettes become colours, EXIF orientation is applied. The header's sizes are held
 * against the context's limits, and against what a file of that length can hold, before anything is allocated. */
PAVE_API pave_result pave_image_read(pave_context *context, const char *path, pave_image **out);

/* Writes an image. The format follows from the ending: .exr (all channels, by name), .png, .tif, .tiff, .jpg, .jpeg. */
PAVE_API pave_result pave_image_write(pave_context *context, const pave_image *image, const char *path);

/* Writes stones as
 *   "svg"   one <polygon> a stone, in px of the drawing (viewBox "0 0 W H"), grouped by colour on a ground of grout
 *   "png"   a picture of them, one pixel to a pixel of the drawing, at most 16384 a side
 *   "json"  the report: pave_report, parameters, seed, backend, versions
 *   "stones" a binary file, for pave_stones_merge: docs/formats.md
 * NULL chooses by the ending of the path. The path "-" is standard output, as SVG unless a format is given. */
PAVE_API pave_result pave_stones_write(pave_context *context, const pave_stones *stones, const char *path,
                                       const char *format);

/* Reads stones back: a file that pave_stones_write wrote as "stones", or an SVG file of anyone's. Of SVG, every
 * <polygon> and every <path> of straight lines is a stone, in the order of the file, which numbers their sites;
 * copies (<use>) are not; viewBox, in px of the drawing, is the window. Corners are rounded to 1/1000 px; stones
 * are taken as they are, good or not. Their fills are pave_stones_rgb, and by luma (128 of 255) black or white in
 * pave_stones_colours. Curves, transforms, style sheets and fills that are no plain colour are
 * PAVE_ERR_UNSUPPORTED; other damage, and stones of several rings, PAVE_ERR_FORMAT with the line. What an SVG does
 * not tell, as parameters, is as by default. Cost: the file is held in memory meanwhile. */
PAVE_API pave_result pave_stones_read(pave_context *context, const char *path, pave_stones **out);

/* Merges windows of one pavement, each a file that pave_stones_write wrote as "stones", into one file: the same bytes
 * as from the whole at once. Any number of stones and files: neither is held in memory. Not as "png". Two files with
 * the same stone, or of different pavements, are PAVE_ERR_FORMAT; windows that are missing are a warning. */
PAVE_API pave_result pave_stones_merge(pave_context *context, const char *const *paths, int32_t count,
                                       const char *path, const char *format);

/* Writes measures of stones as "json", or as "text": lines for people, which NULL means too. */
PAVE_API pave_result pave_stones_measures_write(pave_context *context, const pave_stones_measures *measures,
                                                const char *path, const char *format);

/* Writes a tiling's report, as JSON: its parameters, what was measured (unless NULL), and, for a set of Wang tiles,
 * where each lies and the colours of its edges. The path "-" is standard output. */
PAVE_API pave_result pave_tiling_write(pave_context *context, const pave_tiling *tiling,
                                       const pave_tiling_measure *measure, const char *path);

/* The format that pave_stones_write would choose for a path; NULL if there is none. Never fails. Any thread. */
PAVE_API const char *pave_stones_format(const char *path);

#ifdef __cplusplus
}
#endif

#endif
