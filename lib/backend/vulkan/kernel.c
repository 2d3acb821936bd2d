/* One compute shader and its buffers. */
#include "backend/kernel.h"
#include "backend/vulkan/vulkan.h"

#include "shaders/blend.spv.h"
#include "shaders/exhaust.spv.h"
#include "shaders/match.spv.h"
#include "shaders/voxels.spv.h"

#include <math.h>

enum { STAGING = 1 << 20, PUSH = 128 };

#define FIRST_BUDGET 1e6
#define TARGET 0.01

static const struct { const uint32_t *words; size_t bytes; } shaders[PV_KERNELS] = {
    [PV_KERNEL_MATCH] = { pv_spirv_match, sizeof pv_spirv_match },
    [PV_KERNEL_VOXELS] = { pv_spirv_voxels, sizeof pv_spirv_voxels },
    [PV_KERNEL_EXHAUST] = { pv_spirv_exhaust, sizeof pv_spirv_exhaust },
    [PV_KERNEL_BLEND] = { pv_spirv_blend, sizeof pv_spirv_blend },
};

struct pv_kernel {
    pave_context *context;
    pv_vk vk;
    int32_t count;
    pv_vk_buffer buffers[PV_KERNEL_BUFFERS];
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    double budget; /* cost of what is done in about 10 ms */
};

void pv_kernel_close(pv_kernel *k)
{
    if (!k)
        return;
    pv_vk *vk = &k->vk;
    if (vk->device && vk->DestroyDevice && !vk->stuck) {
        if (k->pipeline)
            vk->DestroyPipeline(vk->device, k->pipeline, NULL);
        if (k->layout)
            vk->DestroyPipelineLayout(vk->device, k->layout, NULL);
        if (k->pool)
            vk->DestroyDescriptorPool(vk->device, k->pool, NULL);
        if (k->set_layout)
            vk->DestroyDescriptorSetLayout(vk->device, k->set_layout, NULL);
        for (int i = 0; i < k->count; i++)
            pv_vk_buffer_destroy(vk, &k->buffers[i]);
        pv_vk_buffer_destroy(vk, &vk->staging);
    }
    pv_vk_close(vk);
    pv_release(k);
}

static VkResult create_set(pv_kernel *k)
{
    pv_vk *vk = &k->vk;
    VkDescriptorSetLayoutBinding bindings[PV_KERNEL_BUFFERS];
    for (int32_t i = 0; i < k->count; i++)
        bindings[i] = (VkDescriptorSetLayoutBinding){
            .binding = (uint32_t)i, .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .descriptorCount = 1,
            .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
        };
    VkDescriptorSetLayoutCreateInfo layout = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = (uint32_t)k->count,
        .pBindings = bindings,
    };
    VkDescriptorPoolSize size = { VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, (uint32_t)k->count };
    VkDescriptorPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = 1, .pPoolSizes = &size,
    };
    VkDescriptorSetAllocateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, .descriptorSetCount = 1, .pSetLayouts = &k->set_layout,
    };
    VkResult result = vk->CreateDescriptorSetLayout(vk->device, &layout, NULL, &k->set_layout);
    if (!result)
        result = vk->CreateDescriptorPool(vk->device, &pool, NULL, &k->pool);
    set.descriptorPool = k->pool;
    return result ? result : vk->AllocateDescriptorSets(vk->device, &set, &k->set);
}

static void bind_buffers(pv_kernel *k)
{
    for (int32_t i = 0; i < k->count; i++) {
        VkDescriptorBufferInfo info = { k->buffers[i].buffer, 0, VK_WHOLE_SIZE };
        VkWriteDescriptorSet write = {
            .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, .dstSet = k->set, .dstBinding = (uint32_t)i,
            .descriptorCount = 1, .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .pBufferInfo = &info,
        };
        k->vk.UpdateDescriptorSets(k->vk.device, 1, &write, 0, NULL);
    }
}

static VkResult create_pipeline(pv_kernel *k, const pv_kernel_params *params)
{
    pv_vk *vk = &k->vk;
    VkShaderModule module;
    VkSpecializationMapEntry entries[PV_KERNEL_CONSTANTS];
    for (uint32_t i = 0; i < PV_KERNEL_CONSTANTS; i++)
        entries[i] = (VkSpecializationMapEntry){ i, i * (uint32_t)sizeof(int32_t), sizeof(int32_t) };
    VkSpecializationInfo constants = { PV_KERNEL_CONSTANTS, entries, sizeof params->constants, params->constants };
    VkPushConstantRange push = { VK_SHADER_STAGE_COMPUTE_BIT, 0, PUSH };
    VkPipelineLayoutCreateInfo layout = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &k->set_layout,
        .pushConstantRangeCount = 1, .pPushConstantRanges = &push,
    };
    VkResult result = vk->CreatePipelineLayout(vk->device, &layout, NULL, &k->layout);
    if (!result)
        result = pv_vk_shader_create(vk, shaders[params->shader].words, shaders[params->shader].bytes, &module);
    if (result)
        return result;
    VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO, .layout = k->layout,
        .stage = {
            .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = VK_SHADER_STAGE_COMPUTE_BIT,
            .module = module, .pName = "main", .pSpecializationInfo = &constants,
        },
    };
    result = vk->CreateComputePipelines(vk->device, VK_NULL_HANDLE, 1, &info, NULL, &k->pipeline);
    vk->DestroyShaderModule(vk->device, module, NULL);
    return result;
}

static pave_result create_buffers(pv_kernel *k, const pv_kernel_params *params)
{
    pave_result result = pv_vk_staging_create(k->context, &k->vk, STAGING);
    for (int32_t i = 0; i < params->buffers && !result; i++) {
        if (params->bytes[i] > (int64_t)k->vk.properties.limits.maxStorageBufferRange)
            return pv_fail(k->context, PAVE_ERR_UNSUPPORTED, "%s: %s too large for its buffers",
                           k->vk.properties.deviceName, params->what);
        result = pv_vk_buffer_create(k->context, &k->vk, (VkDeviceSize)(params->bytes[i] + 3) / 4 * 4, &k->buffers[i]);
        k->count = i + 1;
    }
    return result;
}

pave_result pv_kernel_open(pave_context *context, const pv_kernel_params *params, pv_kernel **out)
{
    pave_result result = PAVE_OK;
    pv_kernel *k = pv_allocate_zeroed(context, 1, sizeof *k, &result);
    *out = NULL;
    if (!k)
        return result;
    k->context = context;
    k->budget = FIRST_BUDGET;
    k->vk.work = VK_QUEUE_COMPUTE_BIT;
    result = pv_vk_open(context, &k->vk);
    if (!result)
        result = create_buffers(k, params);
    if (!result)
        result = pv_vk_check(context, &k->vk, create_set(k), "make a descriptor set");
    if (!result)
        bind_buffers(k);
    if (!result)
        result = pv_vk_check(context, &k->vk, create_pipeline(k, params), "compile a shader");
    if (result)
        pv_kernel_close(k);
    else
        *out = k;
    return result;
}

pave_result pv_kernel_write(pv_kernel *k, int32_t buffer, const void *data, int64_t bytes)
{
    return bytes ? pv_vk_upload(k->context, &k->vk, data, (VkDeviceSize)bytes, &k->buffers[buffer]) : PAVE_OK;
}

pave_result pv_kernel_read(pv_kernel *k, int32_t buffer, void *data, int64_t bytes)
{
    return bytes ? pv_vk_download(k->context, &k->vk, &k->buffers[buffer], (VkDeviceSize)bytes, data) : PAVE_OK;
}

int32_t pv_kernel_slice(const pv_kernel *k, int32_t left, int32_t group, double cost)
{
    enum { MOST = 65535 };
    double fits = fmin(MOST, fmax(group, k->budget / fmax(cost, 1)));
    return left < fits ? left : (int32_t)fits;
}

pave_result pv_kernel_run(pv_kernel *k, const void *push, int32_t push_bytes, int32_t groups, double cost)
{
    pv_vk *vk = &k->vk;
    double began = pv_seconds();
    pave_result result = pv_vk_begin(k->context, vk);
    if (result)
        return result;
    vk->CmdBindPipeline(vk->commands, VK_PIPELINE_BIND_POINT_COMPUTE, k->pipeline);
    vk->CmdBindDescriptorSets(vk->commands, VK_PIPELINE_BIND_POINT_COMPUTE, k->layout, 0, 1, &k->set, 0, NULL);
    vk->CmdPushConstants(vk->commands, k->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, (uint32_t)push_bytes, push);
    vk->CmdDispatch(vk->commands, (uint32_t)groups, 1, 1);
    pv_vk_barrier(vk);
    result = pv_vk_finish(k->context, vk);
    double took = pv_seconds() - began;
    if (took > TARGET)
        k->budget *= fmax(0.25, TARGET / took);
    else if (took < TARGET / 2 && cost > k->budget / 2) /* what is small says nothing of what is large */
        k->budget *= 2;
    return result;
}
