/* Pictures made to repeat. */
#pragma once

#include "base/context.h"

/* What has to be taken from a plane so that it repeats without a jump; nothing from one that does. Its mean is 0. */
pave_result pv_smooth_part(pave_context *context, const float *plane, int32_t width, int32_t height, float *out);
