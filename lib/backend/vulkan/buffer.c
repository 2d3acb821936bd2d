/* Device memory: buffers, mapped where the host can read them at full speed and reached through staging elsewhere, and
 * images, which only the device reads. */
#include "backend/vulkan/vulkan.h"

#include <string.h>

enum {
    MAPPED = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
    CACHED = MAPPED | VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
    NEAR = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
};

/* The first memory type with all of `wanted` that `allowed` has; -1: none. */
static int find_type(const pv_vk *vk, uint32_t allowed, VkMemoryPropertyFlags wanted)
{
    for (uint32_t i = 0; i < vk->memory.memoryTypeCount; i++)
        if (allowed >> i & 1 && (vk->memory.memoryTypes[i].propertyFlags & wanted) == wanted)
            return (int)i;
    return -1;
}

static int first_type(const pv_vk *vk, uint32_t allowed, const VkMemoryPropertyFlags *wishes, int count)
{
    int type = -1;
    for (int i = 0; i < count && type < 0; i++)
        type = find_type(vk, allowed, wishes[i]);
    return type;
}

static VkResult allocate(pv_vk *vk, const VkMemoryRequirements *needs, int type, VkDeviceMemory *memory)
{
    if (type < 0)
        return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    VkMemoryAllocateInfo info = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs->size,
        .memoryTypeIndex = (uint32_t)type,
    };
    return vk->AllocateMemory(vk->device, &info, NULL, memory);
}

static VkResult back_buffer(pv_vk *vk, const VkMemoryPropertyFlags *wishes, int count, pv_vk_buffer *buffer)
{
    VkMemoryRequirements needs;
    vk->GetBufferMemoryRequirements(vk->device, buffer->buffer, &needs);
    int type = first_type(vk, needs.memoryTypeBits, wishes, count);
    VkResult result = allocate(vk, &needs, type, &buffer->memory);
    if (!result)
        result = vk->BindBufferMemory(vk->device, buffer->buffer, buffer->memory, 0);
    if (!result && (vk->memory.memoryTypes[type].propertyFlags & wishes[0] & MAPPED) == MAPPED)
        result = vk->MapMemory(vk->device, buffer->memory, 0, VK_WHOLE_SIZE, 0, &buffer->host);
    return result;
}

static pave_result create(pave_context *context, pv_vk *vk, VkDeviceSize size, const VkMemoryPropertyFlags *wishes,
                          int count, pv_vk_buffer *buffer)
{
    if (size > vk->properties.limits.maxStorageBufferRange)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED,
                       "%s: the drawing and its sites need a buffer of %lld bytes, and the device has %lld at most; "
                       "lay it in windows", vk->properties.deviceName, (long long)size,
                       (long long)vk->properties.limits.maxStorageBufferRange);
    VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size,
        .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                 VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT |
                 VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
    };
    buffer->size = size;
    VkResult result = vk->CreateBuffer(vk->device, &info, NULL, &buffer->buffer);
    return pv_vk_check(context, vk, result ? result : back_buffer(vk, wishes, count, buffer), "make a buffer");
}

pave_result pv_vk_buffer_create(pave_context *context, pv_vk *vk, VkDeviceSize size, pv_vk_buffer *buffer)
{
    static const VkMemoryPropertyFlags wishes[] = { NEAR | CACHED, NEAR, 0 };
    return create(context, vk, size, wishes, 3, buffer);
}

pave_result pv_vk_staging_create(pave_context *context, pv_vk *vk, VkDeviceSize size)
{
    static const VkMemoryPropertyFlags wishes[] = { CACHED, MAPPED };
    return create(context, vk, size, wishes, 2, &vk->staging);
}

void pv_vk_buffer_destroy(pv_vk *vk, pv_vk_buffer *buffer)
{
    if (buffer->buffer)
        vk->DestroyBuffer(vk->device, buffer->buffer, NULL);
    if (buffer->memory)
        vk->FreeMemory(vk->device, buffer->memory, NULL);
    *buffer = (pv_vk_buffer){ 0 };
}

static pave_result copy(pave_context *context, pv_vk *vk, VkBuffer from, VkDeviceSize from_at, VkBuffer to,
                        VkDeviceSize to_at, VkDeviceSize size)
{
    pave_result result = pv_vk_begin(context, vk);
    if (result)
        return result;
    VkBufferCopy region = { from_at, to_at, size };
    pv_vk_barrier(vk);
    vk->CmdCopyBuffer(vk->commands, from, to, 1, &region);
    return pv_vk_finish(context, vk);
}

static VkDeviceSize piece(const pv_vk *vk, VkDeviceSize left)
{
    return left < vk->staging.size ? left : vk->staging.size;
}

pave_result pv_vk_upload(pave_context *context, pv_vk *vk, const void *data, VkDeviceSize size, pv_vk_buffer *buffer)
{
    pave_result result = pv_vk_finish(context, vk);
    if (!result && buffer->host) {
        memcpy(buffer->host, data, size);
        return PAVE_OK;
    }
    for (VkDeviceSize at = 0, step; at < size && !result; at += step) {
        step = piece(vk, size - at);
        memcpy(vk->staging.host, (const char *)data + at, step);
        result = copy(context, vk, vk->staging.buffer, 0, buffer->buffer, at, step);
    }
    return result;
}

pave_result pv_vk_download(pave_context *context, pv_vk *vk, const pv_vk_buffer *buffer, VkDeviceSize size, void *data)
{
    pave_result result = buffer->host ? pv_vk_finish(context, vk) : PAVE_OK;
    if (!result && buffer->host) {
        memcpy(data, buffer->host, size);
        return PAVE_OK;
    }
    for (VkDeviceSize at = 0, step; at < size && !result; at += step) {
        step = piece(vk, size - at);
        result = copy(context, vk, buffer->buffer, at, vk->staging.buffer, 0, step);
        if (!result)
            memcpy((char *)data + at, vk->staging.host, step);
    }
    return result;
}

static VkResult back_image(pv_vk *vk, pv_vk_image *image)
{
    static const VkMemoryPropertyFlags wishes[] = { NEAR, 0 };
    VkMemoryRequirements needs;
    vk->GetImageMemoryRequirements(vk->device, image->image, &needs);
    VkResult result = allocate(vk, &needs, first_type(vk, needs.memoryTypeBits, wishes, 2), &image->memory);
    return result ? result : vk->BindImageMemory(vk->device, image->image, image->memory, 0);
}

static VkResult create_image_view(pv_vk *vk, VkFormat format, VkImageAspectFlags aspect, pv_vk_image *image)
{
    VkImageViewCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO, .image = image->image, .viewType = VK_IMAGE_VIEW_TYPE_2D,
        .format = format, .subresourceRange = { aspect, 0, 1, 0, 1 },
    };
    return vk->CreateImageView(vk->device, &info, NULL, &image->view);
}

pave_result pv_vk_image_create(pave_context *context, pv_vk *vk, VkExtent2D size, VkFormat format, pv_vk_image *image)
{
    int depth = format == VK_FORMAT_D32_SFLOAT;
    VkImageCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO, .imageType = VK_IMAGE_TYPE_2D, .format = format,
        .extent = { size.width, size.height, 1 }, .mipLevels = 1, .arrayLayers = 1, .samples = VK_SAMPLE_COUNT_1_BIT,
        .usage = VK_IMAGE_USAGE_SAMPLED_BIT | (depth ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT
                                                     : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT),
    };
    VkResult result = vk->CreateImage(vk->device, &info, NULL, &image->image);
    if (!result)
        result = back_image(vk, image);
    if (!result)
        result = create_image_view(vk, format, depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT, image);
    return pv_vk_check(context, vk, result, "make an image");
}

void pv_vk_image_destroy(pv_vk *vk, pv_vk_image *image)
{
    if (image->view)
        vk->DestroyImageView(vk->device, image->view, NULL);
    if (image->image)
        vk->DestroyImage(vk->device, image->image, NULL);
    if (image->memory)
        vk->FreeMemory(vk->device, image->memory, NULL);
    *image = (pv_vk_image){ 0 };
}
