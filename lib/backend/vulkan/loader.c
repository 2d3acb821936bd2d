/* The Vulkan loader, opened when it is first needed, and the functions in it. */
#include "backend/vulkan/vulkan.h"

#include <dlfcn.h>

const char *pv_vk_load(pv_vk *vk)
{
    vk->library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!vk->library)
        return "there is no Vulkan loader on this machine (libvulkan.so.1)";
    *(void **)&vk->GetInstanceProcAddr = dlsym(vk->library, "vkGetInstanceProcAddr");
    if (!vk->GetInstanceProcAddr)
        return "the Vulkan loader is damaged: it has no vkGetInstanceProcAddr";
#define GLOBAL(name) vk->name = (PFN_vk##name)vk->GetInstanceProcAddr(NULL, "vk" #name);
    PV_VK_GLOBAL(GLOBAL)
    return vk->CreateInstance && vk->EnumerateInstanceVersion ? NULL : "the Vulkan loader is older than Vulkan 1.1";
}

int pv_vk_load_instance(pv_vk *vk)
{
    int complete = 1;
#define INSTANCE(name) complete &= (vk->name = (PFN_vk##name)vk->GetInstanceProcAddr(vk->instance, "vk" #name)) != NULL;
    PV_VK_INSTANCE(INSTANCE)
    return complete;
}

int pv_vk_load_device(pv_vk *vk)
{
    int complete = 1;
#define DEVICE(name) complete &= (vk->name = (PFN_vk##name)vk->GetDeviceProcAddr(vk->device, "vk" #name)) != NULL;
    PV_VK_DEVICE(DEVICE)
    return complete;
}

void pv_vk_unload(pv_vk *vk)
{
    if (vk->library)
        dlclose(vk->library);
    vk->library = NULL;
}
