/* The Vulkan raster engine, the paper's own way: each site is drawn, and the depth buffer keeps the nearest.
 *
 * What is drawn is the site's box grown by a margin. Where a pixel finds a site within the margin it has met all that
 * could be as near, and in index order, so that the lower index stays: it is exact. Other tiles are drawn again with a
 * greater margin; the last few, and those beyond what a depth can hold, are searched as the compute engine does. */
#include "backend/metric.h"
#include "backend/vulkan/compute.h"
#include "backend/vulkan/engine.h"

#include "util/fixed.h"

#include <stdio.h>

enum {
    SIDE = 256,               /* most tiles of a block in x and y */
    PIXELS = PV_VK_TILE * PV_VK_TILE,
    MOST_MARGIN = 126 * 256,  /* shaders/metric.glsl: FARTHEST */
    GUARD = 64,               /* what is drawn beyond the margin */
    MANY = 8,                 /* a block is drawn again where more than 1 / MANY of its tiles are left */
    FEW = 64,                 /* margins are chosen so that 1 / FEW are */
    SEARCH_COST = 8,          /* of a pixel, in pixels drawn */
};

typedef struct raster {
    pv_vk_engine e;
    pv_vk_target target;
    int32_t chunks;
} raster;

static int32_t less(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* The metric rounds by up to PV_METRIC_SLACK and 2^-14 of the way, rasterisers move a corner by up to 1/16 px in x and
 * in y, floats are exact to 2^-22 of a box or a block: in all less than GUARD and 2^-12 of the box. */
static int32_t grown(const pv_vk_parameters *plane)
{
    return plane->margin + GUARD + (plane->reach >> 12);
}

static void set_margin(pv_vk_parameters *plane, int32_t margin)
{
    plane->margin = less(margin, MOST_MARGIN);
}

/* Is every pixel of a box drawn within 127 px of its site? Its corner is farthest. */
static int narrow(const pv_vk_engine *e)
{
    return e->plane.reach + 1.5 * grown(&e->plane) * (double)e->kind.stretch + 256 < PV_METRIC_NARROW;
}

static void draw_chunk(raster *r, int32_t chunk)
{
    pv_vk *vk = &r->e.vk;
    VkDeviceSize sites = (VkDeviceSize)chunk * PV_VK_CHUNK * sizeof(pave_site);
    r->e.plane.base = chunk * PV_VK_CHUNK;
    pv_vk_push(&r->e);
    vk->CmdBindVertexBuffers(vk->commands, 0, 1, &r->e.buffers[SITES].buffer, &sites);
    vk->CmdDrawIndirect(vk->commands, r->e.buffers[CHUNKS].buffer, (VkDeviceSize)chunk * 32 + 16, 1, 0);
}

static void draw_block(raster *r)
{
    pv_vk_parameters *plane = &r->e.plane;
    VkExtent2D part = { (uint32_t)(plane->columns * PV_VK_TILE), (uint32_t)(plane->rows * PV_VK_TILE) };
    pv_vk_dispatch(&r->e, PV_VK_CULL, 0, r->chunks, PV_VK_GROUP);
    pv_vk_target_begin(&r->e.vk, &r->target, part, narrow(&r->e));
    for (int32_t chunk = 0; chunk < r->chunks; chunk++)
        draw_chunk(r, chunk);
    pv_vk_target_end(&r->e.vk);
    pv_vk_dispatch(&r->e, PV_VK_GATHER, 0, plane->columns * plane->rows, PV_VK_GROUP / pv_vk_lanes(&r->e.vk));
}

/* Draws the tiles of the block that are not done, and tells how many are still not. */
static pave_result try_block(pv_vk_pass *p, uint32_t *left)
{
    raster *r = (raster *)p->e;
    pave_result result = pv_vk_begin(p->context, &r->e.vk);
    if (result)
        return result;
    pv_vk_clear_queue(&r->e);
    draw_block(r);
    p->pending += (double)r->e.plane.columns * r->e.plane.rows * PIXELS;
    result = pv_vk_submit(p);
    return result ? result : pv_vk_download(p->context, &r->e.vk, &r->e.buffers[QUEUE], sizeof *left, left);
}

static pave_result search_block(pv_vk_pass *p, uint32_t left)
{
    pave_result result = pv_vk_begin(p->context, &p->e->vk);
    if (result)
        return result;
    pv_vk_label_queued(p->e);
    return pv_vk_spend(p, (double)left * PIXELS * SEARCH_COST);
}

static pave_result label_block(pv_vk_pass *p, int32_t *labels)
{
    pv_vk_engine *e = p->e;
    pv_vk_parameters *plane = &e->plane;
    uint32_t left = 0, tiles = (uint32_t)(plane->columns * plane->rows);
    int32_t usual = plane->margin;
    pave_result result = pv_vk_begin(p->context, &e->vk);
    if (result)
        return result;
    e->vk.CmdFillBuffer(e->vk.commands, e->buffers[LISTS].buffer, 0, 4 * (VkDeviceSize)tiles, 0);
    result = try_block(p, &left);
    while (!result && left > tiles / MANY && plane->margin < MOST_MARGIN) {
        set_margin(plane, plane->margin * 3 / 2);
        result = try_block(p, &left);
    }
    set_margin(plane, usual);
    if (!result && left)
        result = search_block(p, left);
    return result || !labels ? result : pv_vk_fetch_block(p, (int32_t)tiles, labels);
}

/* The margin for the next step: what would have done for all but a few tiles in this. */
static pave_result adapt(pv_vk_pass *p)
{
    pv_vk_parameters *plane = &p->e->plane;
    pv_vk_totals t;
    pave_result result = pv_vk_download(p->context, &p->e->vk, &p->e->buffers[TOTALS], sizeof t, &t);
    if (result)
        return result;
    int64_t beyond = p->e->tiles;
    for (int k = 0; k < PV_VK_FAR; k++) {
        beyond -= t.far[k];
        if (beyond <= p->e->tiles / FEW) {
            set_margin(plane, 128 * (k + 1));
            return PAVE_OK;
        }
    }
    set_margin(plane, plane->margin * 3 / 2);
    return PAVE_OK;
}

static pave_result label_blocks(pv_vk_pass *p, int32_t *labels)
{
    raster *r = (raster *)p->e;
    pv_vk_parameters *plane = &p->e->plane;
    int32_t across = plane->tiles_across, down = p->e->tiles / across;
    int32_t width = (int32_t)r->target.size.width / PV_VK_TILE, height = (int32_t)r->target.size.height / PV_VK_TILE;
    plane->write = labels != NULL;
    pave_result result = pv_vk_over(p, PV_VK_BOUNDS, r->chunks, 1, PV_VK_CHUNK);
    for (int32_t x = 0; x < across && !result; x += width)
        for (int32_t y = 0; y < down && !result; y += plane->rows) {
            int32_t fit = pv_vk_slice(p, PV_VK_BAND, PV_VK_BAND, PIXELS) / width;
            plane->block = y * across + x;
            plane->columns = less(width, across - x);
            plane->rows = less(less(height, down - y), fit < 1 ? 1 : fit);
            result = label_block(p, labels);
        }
    return result ? result : adapt(p);
}

static void raster_close(void *engine)
{
    raster *r = engine;
    if (r && !r->e.vk.stuck)
        pv_vk_target_destroy(&r->e.vk, &r->target);
    if (r)
        pv_vk_engine_close(&r->e);
    pv_release(r);
}

/* Blocks of equal width, none larger than a band of tiles, nor than any device can draw to. */
static VkExtent2D block_size(const pv_vk_engine *e)
{
    int32_t across = e->plane.tiles_across, down = e->tiles / across;
    int32_t width = (int32_t)pv_ceil_div(across, pv_ceil_div(across, SIDE));
    int32_t height = less(less(down, SIDE), PV_VK_BAND / width);
    return (VkExtent2D){ (uint32_t)(width * PV_VK_TILE), (uint32_t)(height * PV_VK_TILE) };
}

static pave_result set_up(pave_context *context, raster *r, const pv_plane *plane)
{
    pv_vk_engine *e = &r->e;
    pave_result result = pv_vk_engine_open(context, e, plane, VK_QUEUE_GRAPHICS_BIT, 0, label_blocks);
    if (!result)
        result = pv_vk_target_create(context, &e->vk, e->pipelines.layout, block_size(e), plane->metric, &r->target);
    if (!result)
        pv_vk_bind_images(&e->vk, &e->pipelines, &r->target.label, &r->target.depth);
    r->chunks = (int32_t)pv_ceil_div(plane->sites, PV_VK_CHUNK);
    set_margin(&e->plane, plane->cell);
    return result;
}

static pave_result raster_open(pave_context *context, const pv_plane *plane, void **engine, char *name)
{
    pave_result result;
    raster *r = pv_allocate_zeroed(context, 1, sizeof *r, &result);
    if (!r)
        return result;
    result = set_up(context, r, plane);
    if (result) {
        raster_close(r);
        return result;
    }
    snprintf(name, 128, "vulkan-raster on %.100s", r->e.vk.properties.deviceName);
    *engine = r;
    return PAVE_OK;
}

const pv_backend pv_vulkan_raster_backend = {
    PAVE_BACKEND_VULKAN_RASTER, raster_open, pv_vk_engine_step, pv_vk_engine_labels, pv_vk_engine_sites, raster_close,
    pv_vulkan_list_raster,
};
