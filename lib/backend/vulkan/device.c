/* The Vulkan device: choose, open, close. */
#include "backend/vulkan/vulkan.h"

#include <pthread.h>
#include <signal.h>

pave_result pv_vk_check(pave_context *context, const pv_vk *vk, VkResult result, const char *what)
{
    const char *name = vk->properties.deviceName;
    switch (result) {
    case VK_SUCCESS:
        return PAVE_OK;
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return pv_fail(context, PAVE_ERR_DEVICE, "%s: its driver was out of memory when it was to %s", name, what);
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return pv_fail(context, PAVE_ERR_DEVICE, "%s: out of device memory when it was to %s", name, what);
    case VK_ERROR_DEVICE_LOST:
        return pv_fail(context, PAVE_ERR_DEVICE, "%s: the device was lost when it was to %s", name, what);
    default:
        return pv_fail(context, PAVE_ERR_DEVICE, "%s: cannot %s (VkResult %d)", name, what, (int)result);
    }
}

static int rank(const pv_vk *vk)
{
    switch (vk->properties.deviceType) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return 2;
    default: return 1;
    }
}

static pave_result choose(pave_context *context, pv_vk *vk)
{
    VkPhysicalDevice devices[PV_VK_MOST_DEVICES], best = NULL;
    uint32_t count = pv_vk_physical_devices(vk, devices);
    const char *reason = "there is none";
    int highest = 0;
    for (uint32_t i = 0; i < count; i++) {
        const char *lacking = pv_vk_take(vk, devices[i]);
        if (lacking)
            reason = lacking;
        else if (rank(vk) > highest)
            highest = rank(vk), best = devices[i];
    }
    if (!best)
        return pv_fail(context, PAVE_ERR_DEVICE, "no Vulkan device can be used: %s", reason);
    pv_vk_take(vk, best);
    return PAVE_OK;
}

static VkResult create_device(pv_vk *vk)
{
    float priority = 1;
    VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueFamilyIndex = vk->family, .queueCount = 1,
        .pQueuePriorities = &priority,
    };
    VkPhysicalDeviceVulkan12Features twelve = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, .shaderBufferInt64Atomics = VK_TRUE,
    };
    VkPhysicalDeviceFeatures features = { .shaderInt64 = VK_TRUE };
    VkDeviceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = &twelve, .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue, .pEnabledFeatures = &features,
    };
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    VkResult result = vk->CreateDevice(vk->physical, &info, NULL, &vk->device);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return result;
}

static VkResult create_commands(pv_vk *vk)
{
    VkCommandPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = vk->family,
        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
    };
    VkFenceCreateInfo fence = { .sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO };
    VkResult result = vk->CreateCommandPool(vk->device, &pool, NULL, &vk->pool);
    if (result)
        return result;
    VkCommandBufferAllocateInfo commands = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = vk->pool,
        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY, .commandBufferCount = 1,
    };
    result = vk->AllocateCommandBuffers(vk->device, &commands, &vk->commands);
    return result ? result : vk->CreateFence(vk->device, &fence, NULL, &vk->fence);
}

pave_result pv_vk_open(pave_context *context, pv_vk *vk)
{
    const char *reason = pv_vk_open_instance(vk);
    if (reason)
        return pv_fail(context, PAVE_ERR_DEVICE, "no Vulkan device can be used: %s", reason);
    pave_result result = choose(context, vk);
    if (!result)
        result = pv_vk_check(context, vk, create_device(vk), "open the device");
    if (!result && !pv_vk_load_device(vk))
        result = pv_fail(context, PAVE_ERR_DEVICE, "%s: its driver lacks functions", vk->properties.deviceName);
    if (!result) {
        vk->GetDeviceQueue(vk->device, vk->family, 0, &vk->queue);
        result = pv_vk_check(context, vk, create_commands(vk), "make a command buffer");
    }
    return result;
}

void pv_vk_close(pv_vk *vk)
{
    if (vk->stuck)
        return;
    if (vk->fence)
        vk->DestroyFence(vk->device, vk->fence, NULL);
    if (vk->pool)
        vk->DestroyCommandPool(vk->device, vk->pool, NULL);
    if (vk->device && vk->DestroyDevice)
        vk->DestroyDevice(vk->device, NULL);
    pv_vk_close_instance(vk);
}
