/* Recording commands, and waiting for them with a time limit. */
#include "backend/vulkan/vulkan.h"

enum { PATIENCE = 20, MILLISECOND = 1000000 };

pave_result pv_vk_begin(pave_context *context, pv_vk *vk)
{
    if (vk->recording)
        return PAVE_OK;
    VkCommandBufferBeginInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
    };
    pave_result result = pv_vk_check(context, vk, vk->BeginCommandBuffer(vk->commands, &info), "record commands");
    vk->recording = !result;
    return result;
}

void pv_vk_barrier(pv_vk *vk)
{
    int draws = vk->work & VK_QUEUE_GRAPHICS_BIT;
    VkPipelineStageFlags work = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT |
                                VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT | (draws ? VK_PIPELINE_STAGE_VERTEX_INPUT_BIT : 0);
    VkMemoryBarrier all = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                         VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT | VK_ACCESS_HOST_READ_BIT |
                         (draws ? VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT : 0),
    };
    vk->CmdPipelineBarrier(vk->commands, work, work | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &all, 0, NULL, 0, NULL);
}

static pave_result wait(pave_context *context, pv_vk *vk)
{
    VkResult result = VK_TIMEOUT;
    double until = pv_seconds() + PATIENCE;
    while (result == VK_TIMEOUT && pv_seconds() < until)
        result = vk->WaitForFences(vk->device, 1, &vk->fence, VK_TRUE, (uint64_t)100 * MILLISECOND);
    vk->stuck = result && result != VK_ERROR_DEVICE_LOST; /* the work may be under way for all that is known */
    if (result == VK_TIMEOUT)
        return pv_fail(context, PAVE_ERR_DEVICE, "%s: the device has not answered for %d seconds",
                       vk->properties.deviceName, (int)PATIENCE);
    if (!result)
        result = vk->ResetFences(vk->device, 1, &vk->fence);
    return pv_vk_check(context, vk, result, "finish its work");
}

pave_result pv_vk_finish(pave_context *context, pv_vk *vk)
{
    if (!vk->recording)
        return PAVE_OK;
    vk->recording = 0;
    pv_vk_barrier(vk);
    pave_result result = pv_vk_check(context, vk, vk->EndCommandBuffer(vk->commands), "record commands");
    if (result)
        return result;
    VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &vk->commands,
    };
    result = pv_vk_check(context, vk, vk->QueueSubmit(vk->queue, 1, &submit, vk->fence), "take on work");
    return result ? result : wait(context, vk);
}
