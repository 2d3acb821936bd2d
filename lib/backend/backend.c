/* Which backends there are, and which one a job gets. */
#include "backend/backend.h"

#include <stdio.h>

static const pv_backend *const backends[] = {
    &pv_cpu_backend,
    &pv_cpu_portable_backend,
    &pv_cpu_reference_backend,
#ifdef PAVE_HAVE_VULKAN
    &pv_vulkan_compute_backend,
#endif
};

enum { BACKENDS = sizeof backends / sizeof *backends };

const pv_backend *pv_backend_find(int32_t id)
{
    for (int i = 0; i < BACKENDS; i++)
        if (backends[i]->id == id)
            return backends[i];
    return NULL;
}

void pv_device_add(pave_device *devices, int32_t capacity, int32_t *count, int32_t backend, int32_t usable,
                   const char *name)
{
    if (*count < capacity) {
        pave_device *device = &devices[*count];
        device->backend = backend;
        device->usable = usable;
        snprintf(device->name, sizeof device->name, "%s", name);
    }
    ++*count;
}

pave_result pave_devices(pave_context *context, pave_device *devices, int32_t capacity, int32_t *count)
{
    if (!context || !count || capacity < 0 || (capacity && !devices))
        return PAVE_ERR_ARGUMENT;
    *count = 0;
    for (int32_t i = 0; i < capacity; i++)
        if (devices[i].size < sizeof *devices)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "a pave_device has no size: set it first");
    for (int i = 0; i < BACKENDS; i++)
        backends[i]->list(context, devices, capacity, count);
    return PAVE_OK;
}

const pv_backend *pv_backend_choose(pave_context *context, const pv_plane *plane, int32_t iterations)
{
    (void)plane, (void)iterations;
    return context->backend == PAVE_BACKEND_AUTO ? &pv_cpu_backend : pv_backend_find(context->backend);
}
