/* Radiance pictures (.hdr). */
#pragma once

#include "io/drawing.h"
#include "io/input.h"

/* Reads "-Y N +X M" (rows from the top) and "+Y N +X M" (from the bottom), run-length encoded or not, as PAVE_F32 in
 * linear light. "+X M -Y N", which the sets of ATRIUM say, are rows from the bottom, as they really are there. */
pave_result pv_radiance_read(pave_context *context, pv_input *input, const pv_target *target);

/* Does a file begin like one? */
int pv_is_radiance(const uint8_t *bytes, size_t size);
