/* A compute shader on a graphics device, with buffers of its own: what stages besides the diagram use a device for. */
#pragma once

#include "base/context.h"

typedef struct pv_kernel pv_kernel;

enum { PV_KERNEL_MATCH, PV_KERNEL_VOXELS, PV_KERNEL_EXHAUST, PV_KERNEL_BLEND, PV_KERNELS };
enum { PV_KERNEL_BUFFERS = 12, PV_KERNEL_CONSTANTS = 4 };

typedef struct pv_kernel_params {
    int32_t shader; /* PV_KERNEL_ */
    int32_t buffers;
    int64_t bytes[PV_KERNEL_BUFFERS];
    int32_t constants[PV_KERNEL_CONSTANTS]; /* what the shader is made for, by number */
    const char *what;                       /* that may be too large for the device, for the message */
} pv_kernel_params;

/* Opens a device. PAVE_ERR_DEVICE if there is none, PAVE_ERR_UNSUPPORTED if a buffer is too large for it, or there is
 * no Vulkan in this build. */
pave_result pv_kernel_open(pave_context *context, const pv_kernel_params *params, pv_kernel **out);
void pv_kernel_close(pv_kernel *kernel);

/* From the start of a buffer on. */
pave_result pv_kernel_write(pv_kernel *kernel, int32_t buffer, const void *data, int64_t bytes);
pave_result pv_kernel_read(pv_kernel *kernel, int32_t buffer, void *data, int64_t bytes);

/* How many of `left` items, each of a cost in any unit, to run together, so that they are done in about 10 ms: that is
 * how soon a kernel can be cancelled. At least as many as share a workgroup. */
int32_t pv_kernel_slice(const pv_kernel *kernel, int32_t left, int32_t group, double cost);

/* Runs so many workgroups and waits. `cost` is that of them all. */
pave_result pv_kernel_run(pv_kernel *kernel, const void *push, int32_t push_bytes, int32_t groups, double cost);
