/* BTFs as OpenEXR files of many parts: one for each view, with a channel for each light and colour. */
#pragma once

#include "btf/btf.h"
#include "io/input.h"

pave_result pv_exr_btf_read(pave_context *context, pv_input *input, pave_btf **out);
pave_result pv_exr_btf_write(pave_context *context, const pave_btf *btf, const char *path);
