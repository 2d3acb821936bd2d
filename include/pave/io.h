/* Files in and out. A file is written beside its target and renamed when it is complete: whatever happens, the target
 * is the old file or the whole new one. Devices and pipes are written directly. */
#ifndef PAVE_IO_H
#define PAVE_IO_H

#include <pave/btf.h>
#include <pave/stones.h>
#include <pave/tiling.h>
#include <pave/solid.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads an image. The format follows from the first bytes: OpenEXR and Radiance by this library; PNG, JPEG, TIFF, PNM
 * and WebP by a module that is loaded then. Palettes become colours, EXIF orientation is applied. The header's sizes
 * are held against the context's limits, and against what a file of that length can hold, before anything is
 * allocated. */
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

/* Reads a mesh: .obj, .ply (text and binary) or .stl (text and binary). Polygons become fans of triangles. */
PAVE_API pave_result pave_mesh_read(pave_context *context, const char *path, pave_mesh **out);

/* Writes a mesh as binary PLY whose vertices have the colour of the volume there. */
PAVE_API pave_result pave_surface_write(pave_context *context, const pave_mesh *mesh, const pave_volume *volume,
                                        const char *path);

/* Writes a volume as
 *   "nrrd"       NRRD with raw values, with spacing and origin; ".nrrd"
 *   "nrrd-gzip"  the same, compressed; ".nrrd.gz" (the file is an NRRD, not a gzip file)
 *   "vti"        VTK image data with one raw appended array "stone"; ".vti"
 *   "raw"        bare values, and beside them NAME.nhdr, a header that NRRD readers open; ".raw"
 *   "tiff"       a stack of pages NAME-0000.tif, NAME-0001.tif ... along z; ".tif", ".tiff"
 * NULL chooses by the ending. */
PAVE_API pave_result pave_volume_write(pave_context *context, const pave_volume *volume, const char *path,
                                       const char *format);

/* Reads what pave_volume_write writes, and any NRRD of bytes, 16 bit whole numbers or floats, of three axes or four
 * with channels first. Voxels are PAVE_VOXEL_MEASURED; where a float is not finite, PAVE_VOXEL_FREE. */
PAVE_API pave_result pave_volume_read(pave_context *context, const char *path, pave_volume **out);

/* The format that pave_volume_write would choose for a path; NULL if there is none. Never fails. Any thread. */
PAVE_API const char *pave_volume_format(const char *path);

/* Writes the measures of a stone, as JSON; those that are not known are null. The path "-" is standard output. */
PAVE_API pave_result pave_solid_measure_write(pave_context *context, const pave_volume *volume,
                                              const pave_solid_measure *measure, const char *path);

/* What whole-number pictures of a BTF hold: display values by the curve of sRGB, or by a power of 2.2. */
enum { PAVE_BTF_GAMMA_SRGB = 0, PAVE_BTF_GAMMA_22 = 1 };

/* What pictures a folder is written as: EXR (halves or floats, linear), or PNG (8 bits, sRGB, cut at 0 and 1). */
enum { PAVE_BTF_EXR = 0, PAVE_BTF_PNG = 1 };

typedef struct pave_btf_file_params {
    size_t size;
    int32_t gamma;    /* when read: PAVE_BTF_GAMMA_ */
    int32_t pictures; /* when a folder is written: PAVE_BTF_EXR or PAVE_BTF_PNG */
} pave_btf_file_params;

#define PAVE_BTF_FILE_PARAMS_INIT { sizeof(pave_btf_file_params), PAVE_BTF_GAMMA_SRGB, PAVE_BTF_EXR }

PAVE_API void pave_btf_file_params_init(pave_btf_file_params *params, size_t size);

/* Reads a BTF. The format follows from the first bytes:
 *   Bonn's DFMF, FMF and BDI. A BDI file is mapped and not read;
 *   OpenEXR of many parts, as pave_btf_write writes it;
 *   UTIA's BIG 3.0, and BIG 2.36 and 2.37; mapped if its samples lie texel by texel;
 *   a folder, or a zip archive, of pictures (PNG, JPEG, TIFF, EXR, Radiance) with the light's and the view's
 *   inclination and azimuth in their names, in degrees after "tl", "pl", "tv" and "pv", as those of UBO2003, ATRIUM and
 *   UTIA have. Pairs of view and light without a picture are told of and marked in pave_btf_missing.
 * A file that is mapped must not change as long as the handle lives. What is put together from pictures and takes
 * more than an eighth of max_bytes lies in a temporary file without a name, which ends with the handle. */
PAVE_API pave_result pave_btf_read(pave_context *context, const char *path, const pave_btf_file_params *params,
                                   pave_btf **out);

/* Writes a BTF. The format follows from the ending: ".bdi" holds samples as halves; ".btf" holds the factors of a
 * compressed BTF, as FMF if all channels are one matrix and as DFMF if not; ".exr" a part for each view with a channel
 * for each light and colour; "/", a folder of pictures, which must be missing or empty: one for each pair of view and
 * light. Samples are made as they are written. */
PAVE_API pave_result pave_btf_write(pave_context *context, const pave_btf *btf, const pave_btf_file_params *params,
                                    const char *path);

/* Writes and reads a model: docs/formats.md. Its bases are mapped and not read, so the file must not change as long as
 * the handle lives. */
PAVE_API pave_result pave_btf_model_write(pave_context *context, const pave_btf_model *model, const char *path);
PAVE_API pave_result pave_btf_model_read(pave_context *context, const char *path, pave_btf_model **out);

/* Writes what a model holds, as "json" or as "text". */
PAVE_API pave_result pave_btf_model_info_write(pave_context *context, const pave_btf_model *model, const char *path,
                                               const char *format);

/* Writes and reads a plan as CSV: a line of names, and one for each pair, in order, with the numbers of its view and
 * light and their angles in degrees. Of a file that is read the columns "view" and "light" count; a pair that the model
 * has not, or one twice, is PAVE_ERR_FORMAT. */
PAVE_API pave_result pave_btf_plan_write(pave_context *context, const pave_btf_plan *plan, const char *path);
PAVE_API pave_result pave_btf_plan_read(pave_context *context, const pave_btf_model *model, const char *path,
                                        pave_btf_plan **out);

/* Writes what was found out, as "json", or as "text": lines for people, which NULL means too. "-": standard output. */
PAVE_API pave_result pave_btf_diagnosis_write(pave_context *context, const pave_btf *btf,
                                              const pave_btf_diagnosis *diagnosis, const char *path,
                                              const char *format);
PAVE_API pave_result pave_btf_difference_write(pave_context *context, const pave_btf_difference *difference,
                                               const char *path, const char *format);
PAVE_API pave_result pave_btf_enlargement_write(pave_context *context, const pave_btf_enlargement *enlargement,
                                                const char *path, const char *format);

#ifdef __cplusplus
}
#endif

#endif
