/* UTIA's BIG files: version 3.0, and the older ones without a signature (2.36, 2.37). */
#pragma once

#include "btf/btf.h"

#include <pave/io.h>

/* Does a file look like one? Old ones are known by their first chunk, which says how many images there are. */
int pv_is_big(const uint8_t *bytes, size_t size);

/* Reads from a file that is mapped. If its samples already lie texel by texel, it stays mapped and *keeps is set. */
pave_result pv_big_read(pave_context *context, const char *path, const uint8_t *bytes, size_t size,
                        const pave_btf_file_params *params, int *keeps, pave_btf **out);
