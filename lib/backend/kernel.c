/* Kernels in a build without Vulkan: there are none. */
#include "backend/kernel.h"

#ifndef PAVE_HAVE_VULKAN

pave_result pv_kernel_open(pave_context *context, const pv_kernel_params *params, pv_kernel **out)
{
    (void)params;
    *out = NULL;
    return pv_fail(context, PAVE_ERR_UNSUPPORTED, "this build has no Vulkan");
}

void pv_kernel_close(pv_kernel *kernel)
{
    (void)kernel;
}

pave_result pv_kernel_write(pv_kernel *kernel, int32_t buffer, const void *data, int64_t bytes)
{
    (void)kernel, (void)buffer, (void)data, (void)bytes;
    return PAVE_ERR_UNSUPPORTED;
}

pave_result pv_kernel_read(pv_kernel *kernel, int32_t buffer, void *data, int64_t bytes)
{
    (void)kernel, (void)buffer, (void)data, (void)bytes;
    return PAVE_ERR_UNSUPPORTED;
}

int32_t pv_kernel_slice(const pv_kernel *kernel, int32_t left, int32_t group, double cost)
{
    (void)kernel, (void)group, (void)cost;
    return left;
}

pave_result pv_kernel_run(pv_kernel *kernel, const void *push, int32_t push_bytes, int32_t groups, double cost)
{
    (void)kernel, (void)push, (void)push_bytes, (void)groups, (void)cost;
    return PAVE_ERR_UNSUPPORTED;
}

#endif
