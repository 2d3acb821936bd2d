/* Bonn's BTF files: DFMF and FMF (factored) and BDI (samples). Little-endian, packed, angles in radians. */
#pragma once

#include "btf/btf.h"

/* Does a file begin like one of them? `size` bytes are at hand. */
int pv_is_bonn(const uint8_t *bytes, size_t size);

/* Reads from a file that is mapped, `size` bytes at `bytes`. A BDI file stays mapped: *keeps is set, and the handle
 * unmaps it. */
pave_result pv_bonn_read(pave_context *context, const char *path, const uint8_t *bytes, size_t size, int *keeps,
                         pave_btf **out);

/* BDI from any BTF, texels made as they are written; DFMF or FMF from a factored one. */
pave_result pv_bdi_write(pave_context *context, const pave_btf *btf, const char *path);
pave_result pv_fmf_write(pave_context *context, const pave_btf *btf, const char *path);
