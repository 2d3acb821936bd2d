/* Matching by a compute shader. */
#include "backend/match.h"
#include "backend/vulkan/compute.h"
#include "backend/vulkan/vulkan.h"

#include "shaders/match.spv.h"

#include <math.h>

enum { VALUES, BLOCK, COSTS, BUFFERS, GROUP = 64, SLICE = 1 << 16, STAGING = 1 << 20 };

#define FIRST_BUDGET 1e6
#define TARGET 0.01

typedef struct parameters { int32_t first, stride, depth, across, base, count, entries; } parameters;

struct pv_matcher {
    pave_context *context;
    pv_vk vk;
    pv_vk_buffer buffers[BUFFERS];
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    double budget; /* differences that a submit makes in about 10 ms */
};

void pv_matcher_close(pv_matcher *m)
{
    if (!m)
        return;
    pv_vk *vk = &m->vk;
    if (vk->device && vk->DestroyDevice && !vk->stuck) {
        if (m->pipeline)
            vk->DestroyPipeline(vk->device, m->pipeline, NULL);
        if (m->layout)
            vk->DestroyPipelineLayout(vk->device, m->layout, NULL);
        if (m->pool)
            vk->DestroyDescriptorPool(vk->device, m->pool, NULL);
        if (m->set_layout)
            vk->DestroyDescriptorSetLayout(vk->device, m->set_layout, NULL);
        for (int i = 0; i < BUFFERS; i++)
            pv_vk_buffer_destroy(vk, &m->buffers[i]);
        pv_vk_buffer_destroy(vk, &vk->staging);
    }
    pv_vk_close(vk);
    pv_release(m);
}

static VkResult create_set(pv_matcher *m)
{
    pv_vk *vk = &m->vk;
    VkDescriptorSetLayoutBinding bindings[BUFFERS];
    for (uint32_t i = 0; i < BUFFERS; i++)
        bindings[i] = (VkDescriptorSetLayoutBinding){
            .binding = i, .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .descriptorCount = 1,
            .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
        };
    VkDescriptorSetLayoutCreateInfo layout = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = BUFFERS, .pBindings = bindings,
    };
    VkDescriptorPoolSize size = { VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, BUFFERS };
    VkDescriptorPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = 1, .pPoolSizes = &size,
    };
    VkDescriptorSetAllocateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, .descriptorSetCount = 1, .pSetLayouts = &m->set_layout,
    };
    VkResult result = vk->CreateDescriptorSetLayout(vk->device, &layout, NULL, &m->set_layout);
    if (!result)
        result = vk->CreateDescriptorPool(vk->device, &pool, NULL, &m->pool);
    set.descriptorPool = m->pool;
    return result ? result : vk->AllocateDescriptorSets(vk->device, &set, &m->set);
}

static void bind_buffers(pv_matcher *m)
{
    for (uint32_t i = 0; i < BUFFERS; i++) {
        VkDescriptorBufferInfo info = { m->buffers[i].buffer, 0, VK_WHOLE_SIZE };
        VkWriteDescriptorSet write = {
            .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, .dstSet = m->set, .dstBinding = i, .descriptorCount = 1,
            .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .pBufferInfo = &info,
        };
        m->vk.UpdateDescriptorSets(m->vk.device, 1, &write, 0, NULL);
    }
}

static VkResult create_pipeline(pv_matcher *m)
{
    pv_vk *vk = &m->vk;
    VkShaderModule module;
    VkPushConstantRange push = { VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(parameters) };
    VkPipelineLayoutCreateInfo layout = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &m->set_layout,
        .pushConstantRangeCount = 1, .pPushConstantRanges = &push,
    };
    VkResult result = vk->CreatePipelineLayout(vk->device, &layout, NULL, &m->layout);
    if (!result)
        result = pv_vk_shader_create(vk, pv_spirv_match, sizeof pv_spirv_match, &module);
    if (result)
        return result;
    VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO, .layout = m->layout,
        .stage = {
            .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = VK_SHADER_STAGE_COMPUTE_BIT,
            .module = module, .pName = "main",
        },
    };
    result = vk->CreateComputePipelines(vk->device, VK_NULL_HANDLE, 1, &info, NULL, &m->pipeline);
    vk->DestroyShaderModule(vk->device, module, NULL);
    return result;
}

static pave_result create_buffers(pv_matcher *m, const int16_t *values, int64_t count, int32_t most_entries)
{
    VkDeviceSize bytes = 2 * (VkDeviceSize)count;
    VkDeviceSize block = sizeof(pv_match_entry) * (VkDeviceSize)most_entries;
    VkDeviceSize size[BUFFERS] = { [VALUES] = (bytes + 3) / 4 * 4, [BLOCK] = block, [COSTS] = 8 * SLICE };
    if (size[VALUES] > m->vk.properties.limits.maxStorageBufferRange ||
        size[BLOCK] > m->vk.properties.limits.maxStorageBufferRange)
        return pv_fail(m->context, PAVE_ERR_UNSUPPORTED, "%s: the exemplars are too large for its buffers",
                       m->vk.properties.deviceName);
    pave_result result = pv_vk_staging_create(m->context, &m->vk, STAGING);
    for (int i = 0; i < BUFFERS && !result; i++)
        result = pv_vk_buffer_create(m->context, &m->vk, size[i], &m->buffers[i]);
    return result ? result : pv_vk_upload(m->context, &m->vk, values, bytes, &m->buffers[VALUES]);
}

int pv_matcher_has_gpu(pave_context *context)
{
    return pv_vulkan_has_gpu(context);
}

pave_result pv_matcher_open(pave_context *context, const int16_t *values, int64_t count, int32_t most_entries,
                            pv_matcher **out)
{
    pave_result result = PAVE_OK;
    pv_matcher *m = pv_allocate_zeroed(context, 1, sizeof *m, &result);
    *out = NULL;
    if (!m)
        return result;
    m->context = context;
    m->budget = FIRST_BUDGET;
    m->vk.work = VK_QUEUE_COMPUTE_BIT;
    result = pv_vk_open(context, &m->vk);
    if (!result)
        result = create_buffers(m, values, count, most_entries);
    if (!result)
        result = pv_vk_check(context, &m->vk, create_set(m), "make a descriptor set");
    if (!result)
        bind_buffers(m);
    if (!result)
        result = pv_vk_check(context, &m->vk, create_pipeline(m), "compile a shader");
    if (result)
        pv_matcher_close(m);
    else
        *out = m;
    return result;
}

static pave_result run_slice(pv_matcher *m, const parameters *p, uint64_t *costs)
{
    pv_vk *vk = &m->vk;
    double began = pv_seconds();
    pave_result result = pv_vk_begin(m->context, vk);
    if (result)
        return result;
    vk->CmdBindPipeline(vk->commands, VK_PIPELINE_BIND_POINT_COMPUTE, m->pipeline);
    vk->CmdBindDescriptorSets(vk->commands, VK_PIPELINE_BIND_POINT_COMPUTE, m->layout, 0, 1, &m->set, 0, NULL);
    vk->CmdPushConstants(vk->commands, m->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof *p, p);
    vk->CmdDispatch(vk->commands, (uint32_t)(p->count + GROUP - 1) / GROUP, 1, 1);
    pv_vk_barrier(vk);
    result = pv_vk_finish(m->context, vk);
    if (!result)
        result = pv_vk_download(m->context, vk, &m->buffers[COSTS], 8 * (VkDeviceSize)p->count, costs);
    double took = pv_seconds() - began;
    m->budget *= took > TARGET ? fmax(0.25, TARGET / took) : took < TARGET / 2 ? 2 : 1;
    return result ? result : pv_progress(m->context, 0);
}

pave_result pv_matcher_run(pv_matcher *m, const pv_match_entry *entries, int32_t count, const pv_match_places *places,
                           uint64_t *costs)
{
    int32_t all = places->across * places->down;
    parameters p = { places->first, places->stride, places->depth, places->across, 0, 0, count };
    pave_result result = PAVE_OK;
    if (count)
        result = pv_vk_upload(m->context, &m->vk, entries, sizeof *entries * (VkDeviceSize)count, &m->buffers[BLOCK]);
    for (; p.base < all && !result; p.base += p.count) {
        double fits = fmin(SLICE, fmax(GROUP, m->budget / (count ? count : 1)));
        p.count = all - p.base < fits ? all - p.base : (int32_t)fits;
        result = run_slice(m, &p, costs + p.base);
    }
    return result;
}
