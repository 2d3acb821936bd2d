/* Which Vulkan devices this machine has. */
#include "backend/vulkan/compute.h"
#include "backend/vulkan/vulkan.h"

#include <stdio.h>

static const char *type_name(VkPhysicalDeviceType type)
{
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU: return "cpu";
    default: return "other";
    }
}

/* "llvmpipe (LLVM 15.0.6, 256 bits), Vulkan 1.3.230 (cpu)", and the reason if it cannot be used. */
static void describe(const pv_vk *vk, const char *reason, char *text, size_t size)
{
    uint32_t version = vk->properties.apiVersion;
    snprintf(text, size, "%s, Vulkan %u.%u.%u (%s)%s%s", vk->properties.deviceName, VK_API_VERSION_MAJOR(version),
             VK_API_VERSION_MINOR(version), VK_API_VERSION_PATCH(version), type_name(vk->properties.deviceType),
             reason ? ": " : "", reason ? reason : "");
}

static void list(int32_t backend, VkQueueFlags work, pave_device *devices, int32_t capacity, int32_t *count)
{
    pv_vk vk = { .work = work };
    VkPhysicalDevice found[PV_VK_MOST_DEVICES];
    const char *reason = pv_vk_open_instance(&vk);
    uint32_t n = reason ? 0 : pv_vk_physical_devices(&vk, found);
    for (uint32_t i = 0; i < n; i++) {
        char text[512];
        const char *lacking = pv_vk_take(&vk, found[i]);
        describe(&vk, lacking, text, sizeof text);
        pv_device_add(devices, capacity, count, backend, !lacking, text);
    }
    if (!n)
        pv_device_add(devices, capacity, count, backend, 0,
                      reason ? reason : "there is no Vulkan device on this machine");
    pv_vk_close_instance(&vk);
}

void pv_vulkan_list_compute(pave_context *context, pave_device *devices, int32_t capacity, int32_t *count)
{
    (void)context;
    list(PAVE_BACKEND_VULKAN_COMPUTE, VK_QUEUE_COMPUTE_BIT, devices, capacity, count);
}

void pv_vulkan_list_raster(pave_context *context, pave_device *devices, int32_t capacity, int32_t *count)
{
    (void)context;
    list(PAVE_BACKEND_VULKAN_RASTER, VK_QUEUE_GRAPHICS_BIT, devices, capacity, count);
}

int32_t pv_vulkan_has_gpu(pave_context *context)
{
    (void)context;
    pv_vk vk = { 0 };
    VkPhysicalDevice found[PV_VK_MOST_DEVICES];
    uint32_t n = pv_vk_open_instance(&vk) ? 0 : pv_vk_physical_devices(&vk, found);
    int32_t has = 0;
    for (uint32_t i = 0; i < n && !has; i++)
        has = !pv_vk_take(&vk, found[i]) && (vk.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU ||
                                             vk.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU);
    pv_vk_close_instance(&vk);
    return has;
}
