/* What the rest of the library may ask about Vulkan devices besides the op table. */
#pragma once

#include "backend/backend.h"

/* 1 if there is a usable device that is a graphics processor, discrete or integrated. Asks drivers: takes a while. */
int32_t pv_vulkan_has_gpu(pave_context *context);

/* The op `list`: every device, usable or not, or one entry that says why there is none. */
void pv_vulkan_list_compute(pave_context *context, pave_device *devices, int32_t capacity, int32_t *count);
void pv_vulkan_list_raster(pave_context *context, pave_device *devices, int32_t capacity, int32_t *count);
