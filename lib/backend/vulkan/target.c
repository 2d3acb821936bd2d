/* What the raster engine draws to, labels and distances, and the pipelines that draw sites. */
#include "backend/vulkan/vulkan.h"

#include "shaders/raster_frag.spv.h"
#include "shaders/raster_vert.spv.h"

#include <pave/cvd.h>

#include <stddef.h>

static const VkFormat label_format = VK_FORMAT_R32_UINT, depth_format = VK_FORMAT_D32_SFLOAT;

enum {
    FRAGMENT_TESTS = VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT,
    DRAWING = FRAGMENT_TESTS | VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
    DRAWN = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
    DRAWS = DRAWN | VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT,
};

static VkAttachmentDescription attachment(VkFormat format, VkImageLayout layout)
{
    return (VkAttachmentDescription){
        .format = format, .samples = VK_SAMPLE_COUNT_1_BIT, .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
        .storeOp = VK_ATTACHMENT_STORE_OP_STORE, .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
        .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE, .finalLayout = layout,
    };
}

/* Shaders have read the last drawing before the next, and it is complete before they read it. */
static VkResult create_pass(pv_vk *vk, pv_vk_target *target)
{
    VkAttachmentDescription attachments[] = {
        attachment(label_format, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL),
        attachment(depth_format, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL),
    };
    VkAttachmentReference label = { 0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL };
    VkAttachmentReference depth = { 1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL };
    VkSubpassDescription subpass = {
        .pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS, .colorAttachmentCount = 1, .pColorAttachments = &label,
        .pDepthStencilAttachment = &depth,
    };
    VkSubpassDependency around[] = {
        { VK_SUBPASS_EXTERNAL, 0, DRAWING | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, DRAWING, DRAWN, DRAWS, 0 },
        { 0, VK_SUBPASS_EXTERNAL, DRAWING, DRAWING | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, DRAWN,
          VK_ACCESS_SHADER_READ_BIT, 0 },
    };
    VkRenderPassCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO, .attachmentCount = 2, .pAttachments = attachments,
        .subpassCount = 1, .pSubpasses = &subpass, .dependencyCount = 2, .pDependencies = around,
    };
    return vk->CreateRenderPass(vk->device, &info, NULL, &target->pass);
}

static VkResult create_frame(pv_vk *vk, pv_vk_target *target)
{
    VkImageView views[] = { target->label.view, target->depth.view };
    VkFramebufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO, .renderPass = target->pass, .attachmentCount = 2,
        .pAttachments = views, .width = target->size.width, .height = target->size.height, .layers = 1,
    };
    return vk->CreateFramebuffer(vk->device, &info, NULL, &target->frame);
}

/* Sites are drawn as they lie in memory, one to an instance. */
static const VkVertexInputBindingDescription site_binding = { 0, sizeof(pave_site), VK_VERTEX_INPUT_RATE_INSTANCE };
static const VkVertexInputAttributeDescription site_members[] = {
    { 0, 0, VK_FORMAT_R32G32B32A32_SINT, offsetof(pave_site, x) },
    { 1, 0, VK_FORMAT_R32G32_SINT, offsetof(pave_site, half_x) },
};

static VkResult create_pipeline(pv_vk *vk, VkShaderModule vertex, VkShaderModule fragment, VkPipelineLayout layout,
                                const int32_t constants[2], const pv_vk_target *target, VkPipeline *pipeline)
{
    VkSpecializationMapEntry entries[] = { { 0, 0, 4 }, { 1, 4, 4 } };
    VkSpecializationInfo special = { 2, entries, 8, constants };
    VkPipelineShaderStageCreateInfo stages[] = {
        { .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = VK_SHADER_STAGE_VERTEX_BIT,
          .module = vertex, .pName = "main", .pSpecializationInfo = &special },
        { .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = VK_SHADER_STAGE_FRAGMENT_BIT,
          .module = fragment, .pName = "main", .pSpecializationInfo = &special },
    };
    VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO, .vertexBindingDescriptionCount = 1,
        .pVertexBindingDescriptions = &site_binding, .vertexAttributeDescriptionCount = 2,
        .pVertexAttributeDescriptions = site_members,
    };
    VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP,
    };
    VkPipelineViewportStateCreateInfo viewport = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1,
    };
    VkPipelineRasterizationStateCreateInfo rasterization = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .cullMode = VK_CULL_MODE_NONE,
        .lineWidth = 1,
    };
    VkPipelineMultisampleStateCreateInfo samples = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT,
    };
    VkPipelineDepthStencilStateCreateInfo depth = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO, .depthTestEnable = VK_TRUE,
        .depthWriteEnable = VK_TRUE, .depthCompareOp = VK_COMPARE_OP_LESS,
    };
    VkPipelineColorBlendAttachmentState red = { .colorWriteMask = VK_COLOR_COMPONENT_R_BIT };
    VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO, .attachmentCount = 1, .pAttachments = &red,
    };
    VkDynamicState states[] = { VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR };
    VkPipelineDynamicStateCreateInfo dynamic = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO, .dynamicStateCount = 2, .pDynamicStates = states,
    };
    VkGraphicsPipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, .stageCount = 2, .pStages = stages,
        .pVertexInputState = &input, .pInputAssemblyState = &assembly, .pViewportState = &viewport,
        .pRasterizationState = &rasterization, .pMultisampleState = &samples, .pDepthStencilState = &depth,
        .pColorBlendState = &blend, .pDynamicState = &dynamic, .layout = layout, .renderPass = target->pass,
    };
    return vk->CreateGraphicsPipelines(vk->device, VK_NULL_HANDLE, 1, &info, NULL, pipeline);
}

static VkResult create_pipelines(pv_vk *vk, VkPipelineLayout layout, int32_t metric, pv_vk_target *target)
{
    VkShaderModule vertex = VK_NULL_HANDLE, fragment = VK_NULL_HANDLE;
    VkResult result = pv_vk_shader_create(vk, pv_spirv_raster_vert, sizeof pv_spirv_raster_vert, &vertex);
    if (!result)
        result = pv_vk_shader_create(vk, pv_spirv_raster_frag, sizeof pv_spirv_raster_frag, &fragment);
    for (int32_t narrow = 0; narrow < 2 && !result; narrow++) {
        const int32_t constants[] = { narrow, metric };
        result = create_pipeline(vk, vertex, fragment, layout, constants, target, &target->draw[narrow]);
    }
    if (vertex)
        vk->DestroyShaderModule(vk->device, vertex, NULL);
    if (fragment)
        vk->DestroyShaderModule(vk->device, fragment, NULL);
    return result;
}

pave_result pv_vk_target_create(pave_context *context, pv_vk *vk, VkPipelineLayout layout, VkExtent2D size,
                                int32_t metric, pv_vk_target *target)
{
    target->size = size;
    pave_result result = pv_vk_image_create(context, vk, size, label_format, &target->label);
    if (!result)
        result = pv_vk_image_create(context, vk, size, depth_format, &target->depth);
    if (!result)
        result = pv_vk_check(context, vk, create_pass(vk, target), "make a render pass");
    if (!result)
        result = pv_vk_check(context, vk, create_frame(vk, target), "make a framebuffer");
    if (!result)
        result = pv_vk_check(context, vk, create_pipelines(vk, layout, metric, target), "compile a shader");
    return result;
}

void pv_vk_target_destroy(pv_vk *vk, pv_vk_target *target)
{
    for (int narrow = 0; narrow < 2; narrow++)
        if (target->draw[narrow])
            vk->DestroyPipeline(vk->device, target->draw[narrow], NULL);
    if (target->frame)
        vk->DestroyFramebuffer(vk->device, target->frame, NULL);
    if (target->pass)
        vk->DestroyRenderPass(vk->device, target->pass, NULL);
    pv_vk_image_destroy(vk, &target->label);
    pv_vk_image_destroy(vk, &target->depth);
}

void pv_vk_target_begin(pv_vk *vk, const pv_vk_target *target, VkExtent2D part, int narrow)
{
    VkClearValue clear[] = { { .color = { .uint32 = { UINT32_MAX } } }, { .depthStencil = { 1, 0 } } };
    VkRect2D area = { .extent = part };
    VkViewport viewport = { 0, 0, (float)part.width, (float)part.height, 0, 1 };
    VkRenderPassBeginInfo info = {
        .sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO, .renderPass = target->pass, .framebuffer = target->frame,
        .renderArea = area, .clearValueCount = 2, .pClearValues = clear,
    };
    vk->CmdBeginRenderPass(vk->commands, &info, VK_SUBPASS_CONTENTS_INLINE);
    vk->CmdBindPipeline(vk->commands, VK_PIPELINE_BIND_POINT_GRAPHICS, target->draw[narrow]);
    vk->CmdSetViewport(vk->commands, 0, 1, &viewport);
    vk->CmdSetScissor(vk->commands, 0, 1, &area);
}

void pv_vk_target_end(pv_vk *vk)
{
    vk->CmdEndRenderPass(vk->commands);
}
