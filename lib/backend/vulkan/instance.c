/* The Vulkan instance, the devices that it knows, and what a device must have to be of use. */
#include "backend/vulkan/vulkan.h"

#include <pthread.h>
#include <signal.h>

/* Drivers start threads of their own here; signals stay with the host's. */
static VkResult create_instance(pv_vk *vk)
{
    VkApplicationInfo application = {
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pEngineName = "libpave", .apiVersion = VK_API_VERSION_1_2,
    };
    VkInstanceCreateInfo info = { .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application };
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    VkResult result = vk->CreateInstance(&info, NULL, &vk->instance);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return result;
}

const char *pv_vk_open_instance(pv_vk *vk)
{
    const char *reason = pv_vk_load(vk);
    if (reason)
        return reason;
    VkResult result = create_instance(vk);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
        return "there is no Vulkan driver on this machine";
    if (result)
        return "the Vulkan loader cannot create an instance";
    return pv_vk_load_instance(vk) ? NULL : "the Vulkan loader lacks functions of Vulkan 1.1";
}

void pv_vk_close_instance(pv_vk *vk)
{
    if (vk->instance && vk->DestroyInstance)
        vk->DestroyInstance(vk->instance, NULL);
    vk->instance = NULL;
    pv_vk_unload(vk);
}

uint32_t pv_vk_physical_devices(pv_vk *vk, VkPhysicalDevice devices[PV_VK_MOST_DEVICES])
{
    uint32_t count = PV_VK_MOST_DEVICES;
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    VkResult result = vk->EnumeratePhysicalDevices(vk->instance, &count, devices);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return result == VK_SUCCESS || result == VK_INCOMPLETE ? count : 0;
}

static int find_queue(pv_vk *vk)
{
    VkQueueFamilyProperties families[32];
    uint32_t count = 32;
    VkQueueFlags wanted = VK_QUEUE_COMPUTE_BIT | vk->work;
    vk->GetPhysicalDeviceQueueFamilyProperties(vk->physical, &count, families);
    for (vk->family = 0; vk->family < count; vk->family++)
        if ((families[vk->family].queueFlags & wanted) == wanted)
            return 1;
    return 0;
}

static const char *lacking_feature(pv_vk *vk)
{
    VkPhysicalDeviceVulkan12Features twelve = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES };
    VkPhysicalDeviceFeatures2 features = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &twelve };
    vk->GetPhysicalDeviceFeatures2(vk->physical, &features);
    if (!features.features.shaderInt64)
        return "it has no 64-bit integers (shaderInt64)";
    return twelve.shaderBufferInt64Atomics ? NULL : "it has no 64-bit atomics (shaderBufferInt64Atomics)";
}

static const char *lacking_subgroups(pv_vk *vk)
{
    VkPhysicalDeviceSubgroupProperties groups = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES };
    VkPhysicalDeviceProperties2 properties = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &groups,
    };
    vk->GetPhysicalDeviceProperties2(vk->physical, &properties);
    vk->subgroup = groups.subgroupSize;
    VkSubgroupFeatureFlags wanted = VK_SUBGROUP_FEATURE_SHUFFLE_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT;
    int complete = (groups.supportedOperations & wanted) == wanted &&
                   (groups.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT);
    return complete ? NULL : "its compute shaders have no subgroup shuffle";
}

const char *pv_vk_take(pv_vk *vk, VkPhysicalDevice device)
{
    vk->physical = device;
    vk->GetPhysicalDeviceProperties(device, &vk->properties);
    vk->GetPhysicalDeviceMemoryProperties(device, &vk->memory);
    if (vk->properties.apiVersion < VK_API_VERSION_1_2)
        return "it is older than Vulkan 1.2";
    if (!find_queue(vk))
        return vk->work & VK_QUEUE_GRAPHICS_BIT ? "it has no queue that draws and computes" : "it has no compute queue";
    if (vk->properties.limits.maxPerStageDescriptorStorageBuffers < PV_VK_BUFFERS)
        return "its shaders take too few buffers (maxPerStageDescriptorStorageBuffers)";
    const char *reason = lacking_feature(vk);
    return reason ? reason : lacking_subgroups(vk);
}
