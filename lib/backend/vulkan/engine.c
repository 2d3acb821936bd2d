/* What the two Vulkan engines share: sort the sites into buckets, have them labelled, move them.
 *
 * Everything stays on the device; some numbers come back from a step. */
#include "backend/vulkan/engine.h"

#include "util/fixed.h"

#include <math.h>
#include <string.h>

#define TARGET 0.01

enum {
    TILE = PV_VK_TILE,
    MOST_GROUPS = 65535,    /* in one dispatch */
    SITE_COST = 64,         /* of a dispatch over sites, in pixels labelled */
    LEAST_BUDGET = 64 * 64, /* of a submit, in pixels labelled */
    FIRST_BUDGET = 65536,
    STAGING = 8 << 20,
    EDGE_PART = 1 << 26,    /* px */
    CPU_PATIENCE = 4000,    /* shaders/search.glsl: 65535 rounds, shared by up to 16 lanes */
    GPU_PATIENCE = 200000,
};

pave_result pv_vk_submit(pv_vk_pass *p)
{
    double began = pv_seconds();
    pave_result result = pv_vk_finish(p->context, &p->e->vk);
    double took = pv_seconds() - began;
    if (took > TARGET)
        *p->budget = fmax(LEAST_BUDGET, fmin(*p->budget, p->pending * TARGET / took));
    else if (took < TARGET / 2 && p->pending > *p->budget / 2)
        *p->budget *= 2;
    p->done += p->pending;
    p->pending = 0;
    return result ? result : pv_progress(p->context, p->from + (p->to - p->from) * fmin(1, p->done / p->total));
}

pave_result pv_vk_spend(pv_vk_pass *p, double cost)
{
    p->pending += cost;
    return p->pending < *p->budget ? PAVE_OK : pv_vk_submit(p);
}

int32_t pv_vk_slice(const pv_vk_pass *p, int32_t left, int32_t most, double cost)
{
    double room = fmax(*p->budget - p->pending, *p->budget / 4);
    double fits = fmax(PV_VK_GROUP, floor(room / cost));
    most = left < most ? left : most;
    return fits < most ? (int32_t)fits : most;
}

void pv_vk_push(pv_vk_engine *e)
{
    e->vk.CmdPushConstants(e->vk.commands, e->pipelines.layout, PV_VK_PUSH_STAGES, 0, sizeof e->plane, &e->plane);
}

void pv_vk_bind(pv_vk_engine *e, int shader, int32_t base, int32_t count)
{
    VkCommandBuffer commands = e->vk.commands;
    e->plane.base = base;
    e->plane.count = count;
    e->vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, e->pipelines.pipeline[shader]);
    e->vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, e->pipelines.layout, 0, 1, &e->pipelines.set,
                                0, NULL);
    pv_vk_push(e);
}

void pv_vk_dispatch(pv_vk_engine *e, int shader, int32_t base, int32_t count, int32_t per_group)
{
    pv_vk_bind(e, shader, base, count);
    e->vk.CmdDispatch(e->vk.commands, (uint32_t)((count + per_group - 1) / per_group), 1, 1);
    pv_vk_barrier(&e->vk);
}

pave_result pv_vk_over(pv_vk_pass *p, int shader, int32_t items, int32_t per_group, double cost)
{
    pave_result result = PAVE_OK;
    for (int32_t base = 0, count; base < items && !result; base += count) {
        count = pv_vk_slice(p, items - base, MOST_GROUPS * per_group, cost);
        result = pv_vk_begin(p->context, &p->e->vk);
        if (!result) {
            pv_vk_dispatch(p->e, shader, base, count, per_group);
            result = pv_vk_spend(p, count * cost);
        }
    }
    return result;
}

void pv_vk_clear_queue(pv_vk_engine *e)
{
    static const uint32_t nothing[] = { 0, 1, 1 };
    e->vk.CmdUpdateBuffer(e->vk.commands, e->buffers[QUEUE].buffer, 0, sizeof nothing, nothing);
    pv_vk_barrier(&e->vk);
}

void pv_vk_label_queued(pv_vk_engine *e)
{
    pv_vk_bind(e, PV_VK_WIDE, 0, 0);
    e->vk.CmdDispatchIndirect(e->vk.commands, e->buffers[QUEUE].buffer, 0);
    pv_vk_barrier(&e->vk);
}

/* From tiles, one after another, to rows of pixels. */
static void lay_out(const pv_vk_engine *e, int32_t count, int32_t *labels)
{
    const pv_vk_parameters *plane = &e->plane;
    for (int32_t at = 0; at < count; at++) {
        int32_t tile = plane->block + at / plane->columns * plane->tiles_across + at % plane->columns;
        int32_t x = tile % plane->tiles_across * TILE, y = tile / plane->tiles_across * TILE;
        int32_t columns = plane->width - x < TILE ? plane->width - x : TILE;
        int32_t rows = plane->height - y < TILE ? plane->height - y : TILE;
        for (int32_t row = 0; row < rows; row++)
            memcpy(labels + (int64_t)(y + row) * plane->width + x, e->labels + (at * TILE + row) * TILE,
                   (size_t)columns * sizeof *labels);
    }
}

pave_result pv_vk_fetch_block(pv_vk_pass *p, int32_t count, int32_t *labels)
{
    pv_vk_engine *e = p->e;
    pave_result result = pv_vk_submit(p);
    if (!result)
        result = pv_vk_download(p->context, &e->vk, &e->buffers[LABELS], (VkDeviceSize)count * TILE * TILE * 4,
                                e->labels);
    if (!result)
        lay_out(e, count, labels);
    return result;
}

/* A counting sort into the buckets. */
static pave_result sort_sites(pv_vk_pass *p)
{
    pv_vk_engine *e = p->e;
    pave_result result = pv_vk_begin(p->context, &e->vk);
    if (result)
        return result;
    e->vk.CmdFillBuffer(e->vk.commands, e->buffers[FIRST].buffer, 0, VK_WHOLE_SIZE, 0);
    e->vk.CmdFillBuffer(e->vk.commands, e->buffers[TOTALS].buffer, 0, VK_WHOLE_SIZE, 0);
    pv_vk_barrier(&e->vk);
    result = pv_vk_over(p, PV_VK_COUNT, e->plane.sites, PV_VK_GROUP, SITE_COST / 4.0);
    if (!result)
        result = pv_vk_over(p, PV_VK_ROWS, e->plane.down, 1, e->plane.across);
    if (!result)
        result = pv_vk_over(p, PV_VK_SORT, e->plane.sites, PV_VK_GROUP, SITE_COST / 4.0);
    return result;
}

/* How long the work on sites takes says nothing of how long labels do: each has a budget. */
static pave_result label_all(pv_vk_pass *p, int32_t *labels)
{
    pave_result result = pv_vk_submit(p);
    p->budget = &p->e->label_budget;
    if (!result)
        result = p->e->label(p, labels);
    if (!result)
        result = pv_vk_submit(p);
    p->budget = &p->e->site_budget;
    return result;
}

static pave_result read_totals(pave_context *context, pv_vk_engine *e, pv_vk_totals *t)
{
    pave_result result = pv_vk_download(context, &e->vk, &e->buffers[TOTALS], sizeof *t, t);
    if (!result && t->lost)
        result = pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: the sites are spread too unevenly for the Vulkan engine",
                         e->vk.properties.deviceName);
    return result;
}

static double label_cost(const pv_vk_engine *e)
{
    return e->plane.sites * (double)SITE_COST / 2 + (double)e->plane.across * e->plane.down +
           (double)e->tiles * TILE * TILE;
}

pave_result pv_vk_engine_step(pave_context *context, void *engine, int32_t iteration, double from, double to,
                              pv_step *out)
{
    pv_vk_engine *e = engine;
    pv_vk_pass p = { .context = context, .e = e, .from = from, .to = to, .budget = &e->site_budget };
    p.total = label_cost(e) + (double)e->plane.sites * SITE_COST;
    e->plane.iteration = iteration;
    e->plane.unwatched = (uint32_t)out->deep << 4 | (uint32_t)e->open;
    pave_result result = sort_sites(&p);
    if (!result)
        result = label_all(&p, NULL);
    if (!result)
        result = pv_vk_over(&p, PV_VK_RELAX, e->plane.sites, PV_VK_GROUP, SITE_COST);
    if (!result && e->copies)
        result = pv_vk_over(&p, PV_VK_COPY, e->plane.sites, PV_VK_GROUP, SITE_COST / 4.0);
    if (!result)
        result = pv_vk_submit(&p);
    pv_vk_totals t = { 0 };
    if (!result)
        result = read_totals(context, e, &t);
    out->empty = t.empty;
    out->moved = t.moved;
    out->way = (int64_t)t.way;
    out->radius = (int32_t)t.radius;
    out->stray = (int32_t)t.stray;
    return result;
}

pave_result pv_vk_engine_labels(pave_context *context, void *engine, double from, double to, int32_t *labels)
{
    pv_vk_engine *e = engine;
    pv_vk_pass p = { .context = context, .e = e, .from = from, .to = to, .budget = &e->site_budget };
    p.total = label_cost(e);
    pave_result result = sort_sites(&p);
    if (!result)
        result = label_all(&p, labels);
    pv_vk_totals t;
    return result ? result : read_totals(context, e, &t);
}

pave_result pv_vk_engine_sites(pave_context *context, void *engine, pave_site *sites)
{
    pv_vk_engine *e = engine;
    return pv_vk_download(context, &e->vk, &e->buffers[SITES], (VkDeviceSize)e->plane.sites * sizeof *sites, sites);
}

void pv_vk_engine_close(pv_vk_engine *e)
{
    if (!e->vk.stuck) {
        pv_vk_pipelines_destroy(&e->vk, &e->pipelines);
        for (int i = 0; i < PV_VK_BUFFERS; i++)
            pv_vk_buffer_destroy(&e->vk, &e->buffers[i]);
        pv_vk_buffer_destroy(&e->vk, &e->vk.staging);
    }
    pv_vk_close(&e->vk);
    pv_release(e->labels);
}

static pv_vk_parameters describe(const pv_plane *plane, int32_t capacity)
{
    return (pv_vk_parameters){
        .width = plane->width, .height = plane->height, .sites = plane->sites,
        .origin_x = plane->origin_x, .origin_y = plane->origin_y, .period_x = plane->period_x,
        .period_y = plane->period_y, .cell = plane->cell,
        .across = (int32_t)pv_ceil_div(256 * (int64_t)plane->width, plane->cell),
        .down = (int32_t)pv_ceil_div(256 * (int64_t)plane->height, plane->cell),
        .tiles_across = (int32_t)pv_ceil_div(plane->width, TILE), .reach = pv_plane_reach(plane), .capacity = capacity,
        .edge_shift = plane->direction ? -2 : plane->edge ? plane->edge_shift : -1, .push_within = plane->push_within,
        .push_to = plane->push_to, .excess = plane->excess,
        .noise_wave = plane->noise_wave, .noise_swing = plane->noise_swing,
        .noise_key = plane->noise_key, .seed_low = (uint32_t)plane->seed, .seed_high = (uint32_t)(plane->seed >> 32),
    };
}

/* Directions take the place of edges. */
static const uint16_t *edge_of(const pv_plane *plane)
{
    return plane->direction ? plane->direction : plane->edge;
}

static int64_t edge_part(const pv_plane *plane, int part)
{
    int64_t left = edge_of(plane) ? (int64_t)plane->width * plane->height - part * (int64_t)EDGE_PART : 0;
    return left < 0 ? 0 : left < EDGE_PART ? left : EDGE_PART;
}

static pave_result create_buffers(pave_context *context, pv_vk_engine *e, const pv_plane *plane)
{
    VkDeviceSize n = (VkDeviceSize)plane->sites, band = (VkDeviceSize)(e->tiles < PV_VK_BAND ? e->tiles : PV_VK_BAND);
    VkDeviceSize size[PV_VK_BUFFERS] = {
        [SITES] = n * sizeof(pave_site), [HOMES] = n * sizeof(pv_home), [SUMS] = n * 32, [SORTED] = n * 32,
        [FIRST] = 4 * (VkDeviceSize)(e->plane.across + 1) * (VkDeviceSize)e->plane.down,
        [LISTS] = band * 4 * (VkDeviceSize)(e->plane.capacity + 1), [QUEUE] = 4 * (3 + band),
        [LABELS] = band * TILE * TILE * 4, [TOTALS] = sizeof(pv_vk_totals),
        [CHUNKS] = 32 * ((n + PV_VK_CHUNK - 1) / PV_VK_CHUNK),
        [MASK] = plane->mask ? 8 * (VkDeviceSize)e->tiles : 8,
    };
    for (int part = 0; part < PV_VK_EDGE_PARTS; part++) { /* 2 px a word; an empty part has one too */
        int64_t words = pv_ceil_div(edge_part(plane, part), 2);
        size[EDGE + part] = 4 * (VkDeviceSize)(words ? words : 1);
    }
    pave_result result = pv_vk_staging_create(context, &e->vk, STAGING);
    for (int i = 0; i < PV_VK_BUFFERS && !result; i++)
        result = pv_vk_buffer_create(context, &e->vk, size[i], &e->buffers[i]);
    if (!result)
        e->labels = pv_allocate(context, band, TILE * TILE * sizeof *e->labels, &result);
    return result;
}

static pave_result upload(pave_context *context, pv_vk_engine *e, const pv_plane *plane)
{
    VkDeviceSize n = (VkDeviceSize)plane->sites;
    pave_result result = pv_vk_upload(context, &e->vk, plane->start, n * sizeof(pave_site), &e->buffers[SITES]);
    if (!result)
        result = pv_vk_upload(context, &e->vk, plane->home, n * sizeof(pv_home), &e->buffers[HOMES]);
    for (int part = 0; part < PV_VK_EDGE_PARTS && !result && edge_part(plane, part); part++)
        result = pv_vk_upload(context, &e->vk, edge_of(plane) + part * (int64_t)EDGE_PART,
                              2 * (VkDeviceSize)edge_part(plane, part), &e->buffers[EDGE + part]);
    if (!result && plane->mask)
        result = pv_vk_upload(context, &e->vk, plane->mask, 8 * (VkDeviceSize)e->tiles, &e->buffers[MASK]);
    if (!result)
        result = pv_vk_begin(context, &e->vk);
    if (result)
        return result;
    e->vk.CmdFillBuffer(e->vk.commands, e->buffers[SUMS].buffer, 0, VK_WHOLE_SIZE, 0);
    return pv_vk_finish(context, &e->vk);
}

pave_result pv_vk_engine_open(pave_context *context, pv_vk_engine *e, const pv_plane *plane, VkQueueFlags work,
                              int32_t capacity, pv_vk_label *label)
{
    if ((int64_t)plane->width * plane->height > (int64_t)PV_VK_EDGE_PARTS * EDGE_PART)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED,
                       "%d x %d px are beyond the 2^28 px of the Vulkan engines; lay them in windows",
                       (int)plane->width, (int)plane->height);
    e->plane = describe(plane, capacity);
    e->copies = plane->copies;
    e->open = plane->open;
    e->kind = (pv_vk_kind){ plane->metric, plane->mask != NULL, (float)pv_plane_stretch(plane) };
    e->tiles = e->plane.tiles_across * (int32_t)pv_ceil_div(plane->height, TILE);
    e->site_budget = e->label_budget = FIRST_BUDGET;
    e->label = label;
    e->vk.work = work;
    pave_result result = pv_vk_open(context, &e->vk);
    if (!result)
        result = create_buffers(context, e, plane);
    if (!result)
        result = pv_vk_pipelines_create(context, &e->vk, e->buffers, SORTED, sizeof e->plane, e->kind,
                                        &e->pipelines);
    e->plane.patience = e->vk.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU ? CPU_PATIENCE : GPU_PATIENCE;
    return result ? result : upload(context, e, plane);
}
