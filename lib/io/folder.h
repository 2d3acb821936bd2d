/* BTFs as sets of pictures: a folder or a zip archive, each picture named by its light and view. */
#pragma once

#include "btf/btf.h"

#include <pave/io.h>

/* Reads the pictures of a folder and of those below it, or of an archive. */
pave_result pv_folder_read(pave_context *context, const char *path, const pave_btf_file_params *params,
                           pave_btf **out);
pave_result pv_zip_read(pave_context *context, const char *path, const pave_btf_file_params *params, pave_btf **out);

/* Writes a folder: tv030_pv060/tl015_pl000_tv030_pv060.exr (or .png) and so on. It is made beside its target, which
 * must be missing or empty, and renamed when it is complete. */
pave_result pv_folder_write(pave_context *context, const pave_btf *btf, const pave_btf_file_params *params,
                            const char *path);

/* Light and view from a name: the last "tl", "pl", "tv" and "pv", each before a number of degrees. 0 if one lacks. */
int pv_parse_angles(const char *name, double light[2], double view[2]);
