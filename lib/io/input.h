/* Input files, opened and read whole. */
#pragma once

#include "base/context.h"

/* Opens a file that is not empty; not a folder, device or pipe. */
pave_result pv_input_open(pave_context *context, const char *path, int *file, int64_t *size);

/* Reads its `size` bytes. */
pave_result pv_input_whole(pave_context *context, const char *path, int file, size_t size, uint8_t *bytes);
