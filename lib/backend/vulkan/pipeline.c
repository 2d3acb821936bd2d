/* The shaders as pipelines, over one set of buffers. */
#include "backend/vulkan/vulkan.h"

#include "shaders/bounds.spv.h"
#include "shaders/copy.spv.h"
#include "shaders/count.spv.h"
#include "shaders/cull.spv.h"
#include "shaders/gather.spv.h"
#include "shaders/label.spv.h"
#include "shaders/list.spv.h"
#include "shaders/relax.spv.h"
#include "shaders/rows.spv.h"
#include "shaders/sort.spv.h"
#include "shaders/wide.spv.h"

enum { TEXELS = PV_VK_EDGE + 1, BUFFER_BINDINGS, LABEL_IMAGE = BUFFER_BINDINGS, DEPTH_IMAGE, BINDINGS };

typedef struct shader {
    const uint32_t *words;
    size_t bytes;
} shader;

#define SHADER(name) { pv_spirv_##name, sizeof pv_spirv_##name }
static const shader shaders[PV_VK_SHADERS] = {
    [PV_VK_COUNT] = SHADER(count), [PV_VK_ROWS] = SHADER(rows), [PV_VK_SORT] = SHADER(sort),
    [PV_VK_LIST] = SHADER(list), [PV_VK_LABEL] = SHADER(label), [PV_VK_WIDE] = SHADER(wide),
    [PV_VK_RELAX] = SHADER(relax), [PV_VK_COPY] = SHADER(copy), [PV_VK_BOUNDS] = SHADER(bounds),
    [PV_VK_CULL] = SHADER(cull),
    [PV_VK_GATHER] = SHADER(gather),
};

static VkDescriptorType type_of(uint32_t binding)
{
    if (binding >= LABEL_IMAGE)
        return VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
    return binding == TEXELS ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

static uint32_t count_of(uint32_t binding)
{
    return binding == PV_VK_EDGE ? PV_VK_EDGE_PARTS : 1;
}

static VkResult create_set_layout(pv_vk *vk, pv_vk_pipelines *p)
{
    VkDescriptorSetLayoutBinding bindings[BINDINGS];
    for (uint32_t i = 0; i < BINDINGS; i++)
        bindings[i] = (VkDescriptorSetLayoutBinding){
            .binding = i, .descriptorType = type_of(i), .descriptorCount = count_of(i),
            .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
        };
    VkDescriptorSetLayoutCreateInfo layout = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = BINDINGS, .pBindings = bindings,
    };
    return vk->CreateDescriptorSetLayout(vk->device, &layout, NULL, &p->set_layout);
}

static VkResult create_set(pv_vk *vk, pv_vk_pipelines *p)
{
    VkDescriptorPoolSize sizes[] = {
        { VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, PV_VK_BUFFERS }, { VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 1 },
        { VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 2 },
    };
    VkDescriptorPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = 3, .pPoolSizes = sizes,
    };
    VkResult result = vk->CreateDescriptorPool(vk->device, &pool, NULL, &p->pool);
    if (result)
        return result;
    VkDescriptorSetAllocateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, .descriptorPool = p->pool, .descriptorSetCount = 1,
        .pSetLayouts = &p->set_layout,
    };
    return vk->AllocateDescriptorSets(vk->device, &set, &p->set);
}

static VkResult create_view(pv_vk *vk, const pv_vk_buffer *buffer, VkBufferView *view)
{
    VkBufferViewCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO, .buffer = buffer->buffer,
        .format = VK_FORMAT_R32G32B32A32_SINT, .range = VK_WHOLE_SIZE,
    };
    return vk->CreateBufferView(vk->device, &info, NULL, view);
}

static void bind_buffers(pv_vk *vk, const pv_vk_buffer *buffers, pv_vk_pipelines *p)
{
    VkDescriptorBufferInfo infos[PV_VK_BUFFERS];
    VkWriteDescriptorSet writes[BUFFER_BINDINGS];
    for (uint32_t i = 0; i < PV_VK_BUFFERS; i++)
        infos[i] = (VkDescriptorBufferInfo){ buffers[i].buffer, 0, VK_WHOLE_SIZE };
    for (uint32_t i = 0; i < BUFFER_BINDINGS; i++)
        writes[i] = (VkWriteDescriptorSet){
            .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, .dstSet = p->set, .dstBinding = i,
            .descriptorCount = count_of(i), .descriptorType = type_of(i),
            .pBufferInfo = i < TEXELS ? &infos[i] : NULL, .pTexelBufferView = &p->texels,
        };
    vk->UpdateDescriptorSets(vk->device, BUFFER_BINDINGS, writes, 0, NULL);
}

static void bind_image(pv_vk *vk, const pv_vk_pipelines *p, uint32_t binding, VkImageView view, VkImageLayout layout)
{
    VkDescriptorImageInfo image = { .imageView = view, .imageLayout = layout };
    VkWriteDescriptorSet write = {
        .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, .dstSet = p->set, .dstBinding = binding, .descriptorCount = 1,
        .descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, .pImageInfo = &image,
    };
    vk->UpdateDescriptorSets(vk->device, 1, &write, 0, NULL);
}

void pv_vk_bind_images(pv_vk *vk, const pv_vk_pipelines *p, const pv_vk_image *label, const pv_vk_image *depth)
{
    bind_image(vk, p, LABEL_IMAGE, label->view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    bind_image(vk, p, DEPTH_IMAGE, depth->view, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL);
}

static VkResult create_layout(pv_vk *vk, uint32_t push_bytes, pv_vk_pipelines *p)
{
    VkPushConstantRange push = { PV_VK_PUSH_STAGES, 0, push_bytes };
    VkPipelineLayoutCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &p->set_layout,
        .pushConstantRangeCount = 1, .pPushConstantRanges = &push,
    };
    return vk->CreatePipelineLayout(vk->device, &info, NULL, &p->layout);
}

VkResult pv_vk_shader_create(pv_vk *vk, const uint32_t *words, size_t bytes, VkShaderModule *module)
{
    VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = bytes, .pCode = words,
    };
    return vk->CreateShaderModule(vk->device, &info, NULL, module);
}

int32_t pv_vk_lanes(const pv_vk *vk)
{
    return vk->subgroup < 8 ? (int32_t)vk->subgroup : 8;
}

static VkResult create_pipeline(pv_vk *vk, const shader *code, VkPipelineLayout layout, pv_vk_kind kind,
                                VkPipeline *pipeline)
{
    VkShaderModule module;
    VkResult result = pv_vk_shader_create(vk, code->words, code->bytes, &module);
    if (result)
        return result;
    struct { int32_t lanes; pv_vk_kind kind; } constants = { pv_vk_lanes(vk), kind };
    VkSpecializationMapEntry entries[] = { { 0, 0, 4 }, { 1, 4, 4 }, { 2, 8, 4 }, { 3, 12, 4 } };
    VkSpecializationInfo special = { 4, entries, sizeof constants, &constants };
    VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO, .layout = layout,
        .stage = {
            .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = VK_SHADER_STAGE_COMPUTE_BIT,
            .module = module, .pName = "main", .pSpecializationInfo = &special,
        },
    };
    result = vk->CreateComputePipelines(vk->device, VK_NULL_HANDLE, 1, &info, NULL, pipeline);
    vk->DestroyShaderModule(vk->device, module, NULL);
    return result;
}

static int needed(const pv_vk *vk, int which)
{
    int draws = (vk->work & VK_QUEUE_GRAPHICS_BIT) != 0;
    return which < PV_VK_LIST || draws == (which >= PV_VK_BOUNDS);
}

pave_result pv_vk_pipelines_create(pave_context *context, pv_vk *vk, const pv_vk_buffer buffers[PV_VK_BUFFERS],
                                   int texels, uint32_t push_bytes, pv_vk_kind kind, pv_vk_pipelines *p)
{
    pave_result result = pv_vk_check(context, vk, create_set_layout(vk, p), "make a descriptor set layout");
    if (!result)
        result = pv_vk_check(context, vk, create_set(vk, p), "make a descriptor set");
    if (!result)
        result = pv_vk_check(context, vk, create_view(vk, &buffers[texels], &p->texels), "make a buffer view");
    if (result)
        return result;
    bind_buffers(vk, buffers, p);
    result = pv_vk_check(context, vk, create_layout(vk, push_bytes, p), "make a pipeline layout");
    for (int i = 0; i < PV_VK_SHADERS && !result; i++)
        if (needed(vk, i))
            result = pv_vk_check(context, vk, create_pipeline(vk, &shaders[i], p->layout, kind, &p->pipeline[i]),
                                 "compile a shader");
    return result;
}

void pv_vk_pipelines_destroy(pv_vk *vk, pv_vk_pipelines *p)
{
    for (int i = 0; i < PV_VK_SHADERS; i++)
        if (p->pipeline[i])
            vk->DestroyPipeline(vk->device, p->pipeline[i], NULL);
    if (p->layout)
        vk->DestroyPipelineLayout(vk->device, p->layout, NULL);
    if (p->texels)
        vk->DestroyBufferView(vk->device, p->texels, NULL);
    if (p->pool)
        vk->DestroyDescriptorPool(vk->device, p->pool, NULL);
    if (p->set_layout)
        vk->DestroyDescriptorSetLayout(vk->device, p->set_layout, NULL);
}
