/* Vulkan from inside: an opened device with its functions, buffers and pipelines. */
#pragma once

#include "base/context.h"

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>

#define PV_VK_GLOBAL(X) X(CreateInstance) X(EnumerateInstanceVersion)
#define PV_VK_INSTANCE(X) \
    X(DestroyInstance) X(EnumeratePhysicalDevices) X(GetPhysicalDeviceProperties) X(GetPhysicalDeviceProperties2) \
    X(GetPhysicalDeviceFeatures2) X(GetPhysicalDeviceQueueFamilyProperties) X(GetPhysicalDeviceMemoryProperties) \
    X(CreateDevice) X(GetDeviceProcAddr)
#define PV_VK_DEVICE(X) \
    X(DestroyDevice) X(GetDeviceQueue) X(QueueSubmit) X(CreateFence) X(DestroyFence) X(ResetFences) X(WaitForFences) \
    X(CreateCommandPool) X(DestroyCommandPool) X(AllocateCommandBuffers) X(BeginCommandBuffer) X(EndCommandBuffer) \
    X(CreateBuffer) X(DestroyBuffer) X(CreateBufferView) X(DestroyBufferView) X(GetBufferMemoryRequirements) \
    X(AllocateMemory) X(FreeMemory) X(BindBufferMemory) X(MapMemory) X(CreateShaderModule) X(DestroyShaderModule) \
    X(CreateDescriptorSetLayout) X(DestroyDescriptorSetLayout) X(CreateDescriptorPool) X(DestroyDescriptorPool) \
    X(AllocateDescriptorSets) X(UpdateDescriptorSets) X(CreatePipelineLayout) X(DestroyPipelineLayout) \
    X(CreateComputePipelines) X(DestroyPipeline) X(CmdBindPipeline) X(CmdBindDescriptorSets) X(CmdPushConstants) \
    X(CmdDispatch) \
    X(CmdDispatchIndirect) X(CmdPipelineBarrier) X(CmdCopyBuffer) X(CmdFillBuffer) X(CmdUpdateBuffer) X(CreateImage) \
    X(DestroyImage) X(GetImageMemoryRequirements) X(BindImageMemory) X(CreateImageView) X(DestroyImageView) \
    X(CreateRenderPass) X(DestroyRenderPass) X(CreateFramebuffer) X(DestroyFramebuffer) X(CreateGraphicsPipelines) \
    X(CmdBeginRenderPass) X(CmdEndRenderPass) X(CmdSetViewport) X(CmdSetScissor) X(CmdBindVertexBuffers) \
    X(CmdDrawIndirect)

typedef struct pv_vk_buffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkDeviceSize size;
    void *host; /* where it is mapped; NULL: only the device can reach it */
} pv_vk_buffer;

typedef struct pv_vk_image {
    VkImage image;
    VkDeviceMemory memory;
    VkImageView view;
} pv_vk_image;

typedef struct pv_vk {
    void *library;
    PFN_vkGetInstanceProcAddr GetInstanceProcAddr;
#define PV_VK_FIELD(name) PFN_vk##name name;
    PV_VK_GLOBAL(PV_VK_FIELD)
    PV_VK_INSTANCE(PV_VK_FIELD)
    PV_VK_DEVICE(PV_VK_FIELD)
#undef PV_VK_FIELD
    VkInstance instance;
    VkPhysicalDevice physical;
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceMemoryProperties memory;
    uint32_t subgroup; /* invocations */
    VkQueueFlags work; /* what its queue must do: set before anything else */
    uint32_t family;
    VkDevice device;
    VkQueue queue;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
    int recording;
    int stuck; /* work never came back: nothing may be destroyed any more */
    pv_vk_buffer staging;
} pv_vk;

/* loader.c: the library and its functions. NULL, or the reason why there are none. */
const char *pv_vk_load(pv_vk *vk);
int pv_vk_load_instance(pv_vk *vk);
int pv_vk_load_device(pv_vk *vk);
void pv_vk_unload(pv_vk *vk);

/* instance.c: which devices there are. NULL or a reason, as above; close it with pv_vk_close_instance even so. */
enum { PV_VK_MOST_DEVICES = 16 };
const char *pv_vk_open_instance(pv_vk *vk);
void pv_vk_close_instance(pv_vk *vk);
uint32_t pv_vk_physical_devices(pv_vk *vk, VkPhysicalDevice devices[PV_VK_MOST_DEVICES]);
/* Takes `device` for its own, or says why it cannot be used. Its properties are there in both cases. */
const char *pv_vk_take(pv_vk *vk, VkPhysicalDevice device);

/* device.c: opens the best usable device. pv_vk_close frees everything, of a half opened one too. */
pave_result pv_vk_open(pave_context *context, pv_vk *vk);
void pv_vk_close(pv_vk *vk);
/* Passes VK_SUCCESS on as PAVE_OK and fails with a sentence for anything else. */
pave_result pv_vk_check(pave_context *context, const pv_vk *vk, VkResult result, const char *what);

/* commands.c: one command buffer. Recording begins with the first command and ends when it is submitted and done. */
pave_result pv_vk_begin(pave_context *context, pv_vk *vk);
/* Everything recorded before is done and seen by everything after: shaders, copies, indirect work, draws, host. What
 * is drawn is seen after pv_vk_target_end. */
void pv_vk_barrier(pv_vk *vk);
pave_result pv_vk_finish(pave_context *context, pv_vk *vk);

/* buffer.c */
pave_result pv_vk_buffer_create(pave_context *context, pv_vk *vk, VkDeviceSize size, pv_vk_buffer *buffer);
pave_result pv_vk_staging_create(pave_context *context, pv_vk *vk, VkDeviceSize size);
void pv_vk_buffer_destroy(pv_vk *vk, pv_vk_buffer *buffer);
/* An image to draw to and to read in shaders. */
pave_result pv_vk_image_create(pave_context *context, pv_vk *vk, VkExtent2D size, VkFormat format, pv_vk_image *image);
void pv_vk_image_destroy(pv_vk *vk, pv_vk_image *image);
/* Both finish the commands recorded so far. */
pave_result pv_vk_upload(pave_context *context, pv_vk *vk, const void *data, VkDeviceSize size, pv_vk_buffer *buffer);
pave_result pv_vk_download(pave_context *context, pv_vk *vk, const pv_vk_buffer *buffer, VkDeviceSize size, void *data);

/* pipeline.c: the shaders, and the one set of buffers that they share. */
enum {
    PV_VK_COUNT, PV_VK_ROWS, PV_VK_SORT, PV_VK_WIDE, PV_VK_RELAX, PV_VK_COPY, /* both engines */
    PV_VK_LIST, PV_VK_LABEL,                                      /* compute */
    PV_VK_BOUNDS, PV_VK_CULL, PV_VK_GATHER,                       /* raster */
    PV_VK_SHADERS,
};
enum { PV_VK_EDGE = 11, PV_VK_EDGE_PARTS = 4, PV_VK_BUFFERS = PV_VK_EDGE + PV_VK_EDGE_PARTS };
enum { PV_VK_PUSH_STAGES = VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT };

typedef struct pv_vk_pipelines {
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    VkBufferView texels;
    VkPipelineLayout layout;
    VkPipeline pipeline[PV_VK_SHADERS];
} pv_vk_pipelines;

/* What shaders are made for: the metric (PAVE_METRIC_), whether there is a mask, and pv_plane_stretch. */
typedef struct pv_vk_kind {
    int32_t metric, masked;
    float stretch;
} pv_vk_kind;

/* `buffers` in the order of their bindings; PV_VK_EDGE is an array, the edge's parts. Buffer `texels` is also bound as
 * texels, after them all. Of the shaders of one engine only, those are made that the queue's work asks for. */
pave_result pv_vk_pipelines_create(pave_context *context, pv_vk *vk, const pv_vk_buffer buffers[PV_VK_BUFFERS],
                                   int texels, uint32_t push_bytes, pv_vk_kind kind, pv_vk_pipelines *pipelines);
/* How many invocations share a tile: shaders/tile.glsl. */
int32_t pv_vk_lanes(const pv_vk *vk);
void pv_vk_pipelines_destroy(pv_vk *vk, pv_vk_pipelines *pipelines);
VkResult pv_vk_shader_create(pv_vk *vk, const uint32_t *words, size_t bytes, VkShaderModule *module);
/* For PV_VK_GATHER. */
void pv_vk_bind_images(pv_vk *vk, const pv_vk_pipelines *pipelines, const pv_vk_image *label, const pv_vk_image *depth);

/* target.c: what the raster engine draws to, labels and distances, and the pipelines that draw. */
typedef struct pv_vk_target {
    VkExtent2D size;
    pv_vk_image label, depth;
    VkRenderPass pass;
    VkFramebuffer frame;
    VkPipeline draw[2]; /* by whether 32 bits are enough */
} pv_vk_target;

/* What is drawn are sites, as they lie in memory, under a metric (PAVE_METRIC_). */
pave_result pv_vk_target_create(pave_context *context, pv_vk *vk, VkPipelineLayout layout, VkExtent2D size,
                                int32_t metric, pv_vk_target *target);
void pv_vk_target_destroy(pv_vk *vk, pv_vk_target *target);
/* Clears the corner of the target that is to be drawn to, and begins to draw; ends, for shaders to read it. */
void pv_vk_target_begin(pv_vk *vk, const pv_vk_target *target, VkExtent2D part, int narrow);
void pv_vk_target_end(pv_vk *vk);
