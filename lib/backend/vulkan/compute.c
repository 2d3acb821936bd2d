/* The Vulkan compute engine: list each tile's candidates, label it, and search where a list will not do. */
#include "backend/vulkan/compute.h"
#include "backend/vulkan/engine.h"

#include <math.h>
#include <stdio.h>

static void label_band(pv_vk_engine *e, int32_t base, int32_t count)
{
    e->plane.block = base;
    pv_vk_clear_queue(e);
    pv_vk_dispatch(e, PV_VK_LIST, 0, count, PV_VK_GROUP);
    pv_vk_dispatch(e, PV_VK_LABEL, 0, count, PV_VK_GROUP / pv_vk_lanes(&e->vk));
    pv_vk_label_queued(e);
}

/* Labels the plane, band by band: into the sums, or into `labels`. */
static pave_result label_tiles(pv_vk_pass *p, int32_t *labels)
{
    enum { PIXELS = PV_VK_TILE * PV_VK_TILE };
    pv_vk_engine *e = p->e;
    pave_result result = PAVE_OK;
    e->plane.write = labels != NULL;
    for (int32_t base = 0, count; base < e->tiles && !result; base += count) {
        count = pv_vk_slice(p, e->tiles - base, PV_VK_BAND, PIXELS);
        result = pv_vk_begin(p->context, &e->vk);
        if (result)
            break;
        label_band(e, base, count);
        result = pv_vk_spend(p, (double)count * PIXELS);
        if (!result && labels)
            result = pv_vk_fetch_block(p, count, labels);
    }
    return result;
}

/* Twice the candidates that a tile may expect, and some more. */
static int32_t list_capacity(int32_t cell, int32_t reach, double stretch)
{
    double radius = (2 * 1268 + cell / 2.0 + reach / 2.0) / cell * stretch;
    return (int32_t)fmin(256, fmax(32, 16 + 2 * 3.2 * radius * radius));
}

static void compute_close(void *engine)
{
    if (engine)
        pv_vk_engine_close(engine);
    pv_release(engine);
}

static pave_result compute_open(pave_context *context, const pv_plane *plane, void **engine, char *name)
{
    pave_result result;
    pv_vk_engine *e = pv_allocate_zeroed(context, 1, sizeof *e, &result);
    if (!e)
        return result;
    int32_t capacity = list_capacity(plane->cell, pv_plane_reach(plane), pv_plane_stretch(plane));
    result = pv_vk_engine_open(context, e, plane, VK_QUEUE_COMPUTE_BIT, capacity, label_tiles);
    if (result) {
        compute_close(e);
        return result;
    }
    e->plane.columns = e->plane.tiles_across;
    snprintf(name, 128, "vulkan-compute on %.100s", e->vk.properties.deviceName);
    *engine = e;
    return PAVE_OK;
}

const pv_backend pv_vulkan_compute_backend = {
    PAVE_BACKEND_VULKAN_COMPUTE, compute_open, pv_vk_engine_step, pv_vk_engine_labels, pv_vk_engine_sites,
    compute_close, pv_vulkan_list_compute,
};
