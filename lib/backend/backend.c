/* Which backends there are, and which one a job gets. */
#include "backend/backend.h"

#ifdef PAVE_HAVE_VULKAN
#include "backend/vulkan/compute.h"
#endif

#include "util/fixed.h"

#include <stdio.h>

static const pv_backend *const backends[] = {
    &pv_cpu_backend,
    &pv_cpu_portable_backend,
    &pv_cpu_reference_backend,
#ifdef PAVE_HAVE_VULKAN
    &pv_vulkan_compute_backend,
    &pv_vulkan_raster_backend,
#endif
#ifdef PAVE_HAVE_EGL
    &pv_gles_backend,
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

int32_t pv_plane_reach(const pv_plane *plane)
{
    uint64_t most = 0;
    if (plane->metric != PAVE_METRIC_BOX)
        return 0;
    for (int32_t i = 0; i < plane->sites; i++) {
        int64_t a = plane->start[i].half_x, b = plane->start[i].half_y;
        uint64_t square = (uint64_t)(a * a + b * b);
        most = square > most ? square : most;
    }
    return (int32_t)pv_isqrt(most) + 1;
}

double pv_plane_stretch(const pv_plane *plane)
{
    int32_t least = pv_steepest(plane->metric);
    if (plane->metric == PAVE_METRIC_BOX)
        return 1;
    for (int32_t i = 0; i < plane->sites; i++) {
        const pave_site *s = &plane->start[i];
        int32_t flattest = s->half_x < s->half_y ? s->half_x : s->half_y;
        least = flattest < least ? flattest : least;
    }
    return (plane->metric == PAVE_METRIC_SQUARE ? 1.41422 : 1.00001) * 65536 / least;
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

static int gpu_pays(pave_context *context, const pv_plane *plane, int32_t iterations)
{
#ifdef PAVE_HAVE_VULKAN
    const double worth_a_driver = 1e9; /* pixel steps: some seconds of one processor */
    double steps = (double)plane->width * plane->height * (iterations + 1);
    return steps >= worth_a_driver && pv_vulkan_has_gpu(context);
#else
    (void)context, (void)plane, (void)iterations;
    return 0;
#endif
}

const pv_backend *pv_backend_choose(pave_context *context, const pv_plane *plane, int32_t iterations)
{
    if (context->backend != PAVE_BACKEND_AUTO)
        return pv_backend_find(context->backend);
    return pv_backend_find(gpu_pays(context, plane, iterations) ? PAVE_BACKEND_VULKAN_COMPUTE : PAVE_BACKEND_CPU);
}
