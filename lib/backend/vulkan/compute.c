/* The Vulkan compute engine: sort the sites into buckets, list each tile's candidates, label, move the sites.
 *
 * Everything stays on the device; two numbers come back from a step. The work is cut into slices, so many to a submit
 * that it is done in about TARGET seconds: that is how soon the engine can be cancelled. */
#include "backend/vulkan/compute.h"
#include "backend/vulkan/vulkan.h"

#include "util/fixed.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define TARGET 0.01

enum {
    TILE = 8,
    GROUP = 64,
    BAND = 32768,           /* tiles that share the candidate lists and labels on the device */
    MOST_GROUPS = 65535,    /* in one dispatch */
    SITE_COST = 64,         /* of a dispatch over sites, in pixels labelled */
    LEAST_BUDGET = 64 * 64, /* of a submit, in pixels labelled */
    FIRST_BUDGET = 65536,
    STAGING = 8 << 20,
    EDGE_PART = 1 << 26,    /* px */
    CPU_PATIENCE = 4000,    /* shaders/search.glsl: 65535 rounds, shared by up to 16 lanes */
    GPU_PATIENCE = 200000,
};

/* The buffers, in the order of their bindings in shaders/plane.glsl. */
enum { SITES, HOMES, SUMS, SORTED, FIRST, LISTS, QUEUE, LABELS, TOTALS, EDGE = PV_VK_EDGE };

/* The push constants of shaders/plane.glsl. */
typedef struct parameters {
    int32_t width, height, sites, origin_x, origin_y, cell, across, down, tiles_across, reach, capacity;
    int32_t edge_shift, push_within, push_to, noise_wave, noise_swing;
    uint32_t noise_key, seed_low, seed_high;
    int32_t iteration, base, count, write, patience;
} parameters;

typedef struct totals {
    uint32_t sorted, empty, moved, lost, radius;
} totals;

typedef struct compute {
    pv_vk vk;
    pv_vk_pipelines pipelines;
    pv_vk_buffer buffers[PV_VK_BUFFERS];
    parameters plane;
    int32_t tiles;
    double budget; /* cost of a submit */
    int32_t *labels; /* of a band */
} compute;

/* One pass over the plane: what it covers of the stage, and how far it has come. */
typedef struct pass {
    pave_context *context;
    compute *c;
    double from, to;
    double total, done, pending; /* cost; pending: recorded but not submitted */
} pass;

static pave_result submit(pass *p)
{
    compute *c = p->c;
    double began = pv_seconds();
    pave_result result = pv_vk_finish(p->context, &c->vk);
    double took = pv_seconds() - began;
    if (took > TARGET)
        c->budget = fmax(LEAST_BUDGET, fmin(c->budget, p->pending * TARGET / took));
    else if (took < TARGET / 2 && p->pending > c->budget / 2)
        c->budget *= 2;
    p->done += p->pending;
    p->pending = 0;
    return result ? result : pv_progress(p->context, p->from + (p->to - p->from) * fmin(1, p->done / p->total));
}

static pave_result spend(pass *p, double cost)
{
    p->pending += cost;
    return p->pending < p->c->budget ? PAVE_OK : submit(p);
}

/* How many items of a cost still go into the submit under way. */
static int32_t slice(const pass *p, int32_t left, int32_t most, double cost)
{
    double room = fmax(p->c->budget - p->pending, p->c->budget / 4);
    double fits = fmax(GROUP, floor(room / cost));
    most = left < most ? left : most;
    return fits < most ? (int32_t)fits : most;
}

static void bind(compute *c, int shader, int32_t base, int32_t count)
{
    VkCommandBuffer commands = c->vk.commands;
    c->plane.base = base;
    c->plane.count = count;
    c->vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, c->pipelines.pipeline[shader]);
    c->vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, c->pipelines.layout, 0, 1, &c->pipelines.set,
                                0, NULL);
    c->vk.CmdPushConstants(commands, c->pipelines.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof c->plane, &c->plane);
}

static void dispatch(compute *c, int shader, int32_t base, int32_t count, int32_t per_group)
{
    bind(c, shader, base, count);
    c->vk.CmdDispatch(c->vk.commands, (uint32_t)((count + per_group - 1) / per_group), 1, 1);
    pv_vk_barrier(&c->vk);
}

static pave_result over(pass *p, int shader, int32_t items, int32_t per_group, double cost)
{
    pave_result result = PAVE_OK;
    for (int32_t base = 0, count; base < items && !result; base += count) {
        count = slice(p, items - base, MOST_GROUPS * per_group, cost);
        result = pv_vk_begin(p->context, &p->c->vk);
        if (!result) {
            dispatch(p->c, shader, base, count, per_group);
            result = spend(p, count * cost);
        }
    }
    return result;
}

/* A counting sort into the buckets. */
static pave_result sort_sites(pass *p)
{
    compute *c = p->c;
    pave_result result = pv_vk_begin(p->context, &c->vk);
    if (result)
        return result;
    c->vk.CmdFillBuffer(c->vk.commands, c->buffers[FIRST].buffer, 0, VK_WHOLE_SIZE, 0);
    c->vk.CmdFillBuffer(c->vk.commands, c->buffers[TOTALS].buffer, 0, VK_WHOLE_SIZE, 0);
    pv_vk_barrier(&c->vk);
    result = over(p, PV_VK_COUNT, c->plane.sites, GROUP, SITE_COST / 4.0);
    if (!result)
        result = over(p, PV_VK_ROWS, c->plane.down, 1, c->plane.across);
    if (!result)
        result = over(p, PV_VK_SORT, c->plane.sites, GROUP, SITE_COST / 4.0);
    return result;
}

static void label_band(compute *c, int32_t base, int32_t count)
{
    static const uint32_t nothing[] = { 0, 1, 1 };
    int32_t lanes = c->vk.subgroup < TILE ? (int32_t)c->vk.subgroup : TILE;
    c->vk.CmdUpdateBuffer(c->vk.commands, c->buffers[QUEUE].buffer, 0, sizeof nothing, nothing);
    pv_vk_barrier(&c->vk);
    dispatch(c, PV_VK_LIST, base, count, GROUP);
    dispatch(c, PV_VK_LABEL, base, count, GROUP / lanes);
    bind(c, PV_VK_WIDE, base, count);
    c->vk.CmdDispatchIndirect(c->vk.commands, c->buffers[QUEUE].buffer, 0);
    pv_vk_barrier(&c->vk);
}

/* From tiles, one after another, to rows of pixels. */
static void lay_out(const compute *c, int32_t base, int32_t count, int32_t *labels)
{
    for (int32_t at = 0; at < count; at++) {
        int32_t x = (base + at) % c->plane.tiles_across * TILE, y = (base + at) / c->plane.tiles_across * TILE;
        int32_t columns = c->plane.width - x < TILE ? c->plane.width - x : TILE;
        int32_t rows = c->plane.height - y < TILE ? c->plane.height - y : TILE;
        for (int32_t row = 0; row < rows; row++)
            memcpy(labels + (int64_t)(y + row) * c->plane.width + x, c->labels + (at * TILE + row) * TILE,
                   (size_t)columns * sizeof *labels);
    }
}

static pave_result fetch_band(pass *p, int32_t base, int32_t count, int32_t *labels)
{
    compute *c = p->c;
    pave_result result = submit(p);
    if (!result)
        result = pv_vk_download(p->context, &c->vk, &c->buffers[LABELS], (VkDeviceSize)count * TILE * TILE * 4,
                                c->labels);
    if (!result)
        lay_out(c, base, count, labels);
    return result;
}

/* Labels the plane, band by band: into the sums, or into `labels`. */
static pave_result label_tiles(pass *p, int32_t *labels)
{
    compute *c = p->c;
    pave_result result = PAVE_OK;
    c->plane.write = labels != NULL;
    for (int32_t base = 0, count; base < c->tiles && !result; base += count) {
        count = slice(p, c->tiles - base, BAND, TILE * TILE);
        result = pv_vk_begin(p->context, &c->vk);
        if (result)
            break;
        label_band(c, base, count);
        result = spend(p, (double)count * TILE * TILE);
        if (!result && labels)
            result = fetch_band(p, base, count, labels);
    }
    return result;
}

static pave_result read_totals(pave_context *context, compute *c, totals *t)
{
    pave_result result = pv_vk_download(context, &c->vk, &c->buffers[TOTALS], sizeof *t, t);
    if (!result && t->lost)
        result = pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: the sites are spread too unevenly for the Vulkan engine",
                         c->vk.properties.deviceName);
    return result;
}

static double sort_cost(const compute *c)
{
    return c->plane.sites * (double)SITE_COST / 2 + (double)c->plane.across * c->plane.down;
}

static pave_result compute_step(pave_context *context, void *engine, int32_t iteration, double from, double to,
                                pv_step *out)
{
    compute *c = engine;
    pass p = { .context = context, .c = c, .from = from, .to = to };
    p.total = sort_cost(c) + (double)c->tiles * TILE * TILE + (double)c->plane.sites * SITE_COST;
    c->plane.iteration = iteration;
    pave_result result = sort_sites(&p);
    if (!result)
        result = label_tiles(&p, NULL);
    if (!result)
        result = over(&p, PV_VK_RELAX, c->plane.sites, GROUP, SITE_COST);
    if (!result)
        result = submit(&p);
    totals t = { 0 };
    if (!result)
        result = read_totals(context, c, &t);
    out->empty = t.empty;
    out->moved = t.moved;
    out->radius = (int32_t)t.radius;
    return result;
}

static pave_result compute_labels(pave_context *context, void *engine, double from, double to, int32_t *labels)
{
    compute *c = engine;
    pass p = { .context = context, .c = c, .from = from, .to = to };
    p.total = sort_cost(c) + (double)c->tiles * TILE * TILE;
    pave_result result = sort_sites(&p);
    if (!result)
        result = label_tiles(&p, labels);
    totals t;
    return result ? result : read_totals(context, c, &t);
}

static pave_result compute_sites(pave_context *context, void *engine, pave_site *sites)
{
    compute *c = engine;
    return pv_vk_download(context, &c->vk, &c->buffers[SITES], (VkDeviceSize)c->plane.sites * sizeof *sites, sites);
}

static void compute_close(void *engine)
{
    compute *c = engine;
    if (!c)
        return;
    if (!c->vk.stuck) {
        pv_vk_pipelines_destroy(&c->vk, &c->pipelines);
        for (int i = 0; i < PV_VK_BUFFERS; i++)
            pv_vk_buffer_destroy(&c->vk, &c->buffers[i]);
        pv_vk_buffer_destroy(&c->vk, &c->vk.staging);
    }
    pv_vk_close(&c->vk);
    pv_release(c->labels);
    pv_release(c);
}

/* Twice the candidates that a tile may expect, and some more. */
static int32_t list_capacity(int32_t cell, int32_t reach)
{
    double radius = (2 * 1268 + cell / 2.0 + reach / 2.0) / cell;
    return (int32_t)fmin(256, fmax(32, 16 + 2 * 3.2 * radius * radius));
}

static parameters describe(const pv_plane *plane)
{
    parameters p = {
        .width = plane->width, .height = plane->height, .sites = plane->sites,
        .origin_x = plane->origin_x, .origin_y = plane->origin_y, .cell = plane->cell,
        .across = (int32_t)pv_ceil_div(256 * (int64_t)plane->width, plane->cell),
        .down = (int32_t)pv_ceil_div(256 * (int64_t)plane->height, plane->cell),
        .tiles_across = (int32_t)pv_ceil_div(plane->width, TILE), .reach = pv_plane_reach(plane),
        .edge_shift = plane->edge ? plane->edge_shift : -1, .push_within = plane->push_within,
        .push_to = plane->push_to, .noise_wave = plane->noise_wave, .noise_swing = plane->noise_swing,
        .noise_key = plane->noise_key, .seed_low = (uint32_t)plane->seed, .seed_high = (uint32_t)(plane->seed >> 32),
    };
    p.capacity = list_capacity(p.cell, p.reach);
    return p;
}

static int64_t edge_part(const pv_plane *plane, int part)
{
    int64_t left = plane->edge ? (int64_t)plane->width * plane->height - part * (int64_t)EDGE_PART : 0;
    return left < 0 ? 0 : left < EDGE_PART ? left : EDGE_PART;
}

static pave_result create_buffers(pave_context *context, compute *c, const pv_plane *plane)
{
    VkDeviceSize n = (VkDeviceSize)plane->sites, band = (VkDeviceSize)(c->tiles < BAND ? c->tiles : BAND);
    VkDeviceSize size[PV_VK_BUFFERS] = {
        [SITES] = n * sizeof(pave_site), [HOMES] = n * sizeof(pv_home), [SUMS] = n * 32, [SORTED] = n * 32,
        [FIRST] = 4 * (VkDeviceSize)(c->plane.across + 1) * (VkDeviceSize)c->plane.down,
        [LISTS] = band * 4 * (VkDeviceSize)(c->plane.capacity + 1), [QUEUE] = 4 * (3 + band),
        [LABELS] = band * TILE * TILE * 4, [TOTALS] = sizeof(totals),
    };
    for (int part = 0; part < PV_VK_EDGE_PARTS; part++)
        size[EDGE + part] = (VkDeviceSize)(edge_part(plane, part) + 2) / 2 * 4;
    pave_result result = pv_vk_staging_create(context, &c->vk, STAGING);
    for (int i = 0; i < PV_VK_BUFFERS && !result; i++)
        result = pv_vk_buffer_create(context, &c->vk, size[i], &c->buffers[i]);
    if (!result)
        c->labels = pv_allocate(context, band, TILE * TILE * sizeof *c->labels, &result);
    return result;
}

static pave_result upload(pave_context *context, compute *c, const pv_plane *plane)
{
    VkDeviceSize n = (VkDeviceSize)plane->sites;
    pave_result result = pv_vk_upload(context, &c->vk, plane->start, n * sizeof(pave_site), &c->buffers[SITES]);
    if (!result)
        result = pv_vk_upload(context, &c->vk, plane->home, n * sizeof(pv_home), &c->buffers[HOMES]);
    for (int part = 0; part < PV_VK_EDGE_PARTS && !result && edge_part(plane, part); part++)
        result = pv_vk_upload(context, &c->vk, plane->edge + part * (int64_t)EDGE_PART,
                              2 * (VkDeviceSize)edge_part(plane, part), &c->buffers[EDGE + part]);
    if (!result)
        result = pv_vk_begin(context, &c->vk);
    if (result)
        return result;
    c->vk.CmdFillBuffer(c->vk.commands, c->buffers[SUMS].buffer, 0, VK_WHOLE_SIZE, 0);
    return pv_vk_finish(context, &c->vk);
}

static pave_result set_up(pave_context *context, compute *c, const pv_plane *plane)
{
    if ((int64_t)plane->width * plane->height > (int64_t)PV_VK_EDGE_PARTS * EDGE_PART)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%d x %d px are beyond the 2^28 of the Vulkan engine",
                       (int)plane->width, (int)plane->height);
    pave_result result = pv_vk_open(context, &c->vk);
    if (!result)
        result = create_buffers(context, c, plane);
    if (!result)
        result = pv_vk_pipelines_create(context, &c->vk, c->buffers, SORTED, sizeof c->plane, &c->pipelines);
    return result ? result : upload(context, c, plane);
}

static pave_result compute_open(pave_context *context, const pv_plane *plane, void **engine, char *name)
{
    pave_result result;
    compute *c = pv_allocate_zeroed(context, 1, sizeof *c, &result);
    if (!c)
        return result;
    c->plane = describe(plane);
    c->tiles = c->plane.tiles_across * (int32_t)pv_ceil_div(plane->height, TILE);
    c->budget = FIRST_BUDGET;
    result = set_up(context, c, plane);
    c->plane.patience = c->vk.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU ? CPU_PATIENCE : GPU_PATIENCE;
    if (result) {
        compute_close(c);
        return result;
    }
    snprintf(name, 128, "vulkan-compute on %.100s", c->vk.properties.deviceName);
    *engine = c;
    return PAVE_OK;
}

const pv_backend pv_vulkan_compute_backend = {
    PAVE_BACKEND_VULKAN_COMPUTE, compute_open, compute_step, compute_labels, compute_sites, compute_close,
    pv_vulkan_list,
};
