/* The Vulkan engines from inside: the plane on the device, and all that labelling by compute and by raster share. */
#pragma once

#include "backend/backend.h"
#include "backend/vulkan/vulkan.h"

enum {
    PV_VK_TILE = 8,
    PV_VK_GROUP = 64,
    PV_VK_BAND = 32768, /* tiles that share the lists and labels on the device */
    PV_VK_FAR = 256,    /* classes of distance, each half a pixel */
    PV_VK_CHUNK = 1024, /* sites that are drawn, or left out, together */
};

/* The buffers, in the order of their bindings in shaders/plane.glsl. */
enum { SITES, HOMES, SUMS, SORTED, FIRST, LISTS, QUEUE, LABELS, TOTALS, CHUNKS, MASK, EDGE = PV_VK_EDGE };

/* The push constants of shaders/parameters.glsl. */
typedef struct pv_vk_parameters {
    int32_t width, height, sites, origin_x, origin_y, period_x, period_y;
    int32_t cell, across, down, tiles_across, reach, capacity;
    int32_t edge_shift, push_within, push_to, noise_wave, noise_swing;
    uint32_t noise_key, seed_low, seed_high;
    int32_t iteration, base, count, write, patience;
    int32_t block, columns, rows, excess, margin;
    uint32_t unwatched;
} pv_vk_parameters;

_Static_assert(sizeof(pv_vk_parameters) <= 128, "what every device has room for");

typedef struct pv_vk_totals {
    uint32_t sorted, empty, moved, lost, radius, stray;
    uint64_t way;
    uint32_t far[PV_VK_FAR]; /* raster: tiles by their farthest pixel */
} pv_vk_totals;

/* One pass over the plane: what it covers of the stage, and how far it has come. */
typedef struct pv_vk_pass {
    pave_context *context;
    struct pv_vk_engine *e;
    double from, to;
    double total, done, pending; /* cost; pending: recorded but not submitted */
    double *budget;              /* the engine's for the work under way */
} pv_vk_pass;

/* Labels the plane: into the sums, or into `labels`. */
typedef pave_result pv_vk_label(pv_vk_pass *p, int32_t *labels);

typedef struct pv_vk_engine {
    pv_vk vk;
    pv_vk_pipelines pipelines;
    pv_vk_buffer buffers[PV_VK_BUFFERS];
    pv_vk_parameters plane;
    pv_vk_label *label;
    pv_vk_kind kind;
    int32_t tiles, copies, open;
    double site_budget, label_budget; /* cost of a submit, in pixels labelled: what is done in about 10 ms */
    int32_t *labels; /* of a band */
} pv_vk_engine;

/* Describes the plane, opens a device whose queue does `work` and brings the plane there; `capacity` is that of a
 * tile's candidate list. Frees nothing on failure: pv_vk_engine_close does. */
pave_result pv_vk_engine_open(pave_context *context, pv_vk_engine *e, const pv_plane *plane, VkQueueFlags work,
                              int32_t capacity, pv_vk_label *label);
void pv_vk_engine_close(pv_vk_engine *e);

/* Ops of the table. */
pave_result pv_vk_engine_step(pave_context *context, void *engine, int32_t iteration, double from, double to,
                              pv_step *out);
pave_result pv_vk_engine_labels(pave_context *context, void *engine, double from, double to, int32_t *labels);
pave_result pv_vk_engine_sites(pave_context *context, void *engine, pave_site *sites);

/* The work is cut into slices, so many to a submit that it is done in about 10 ms: that is how soon an engine can be
 * cancelled. `submit` waits and reports progress; `spend` does so when enough is pending. */
pave_result pv_vk_submit(pv_vk_pass *p);
pave_result pv_vk_spend(pv_vk_pass *p, double cost);
/* How many items of a cost still go into the submit under way. */
int32_t pv_vk_slice(const pv_vk_pass *p, int32_t left, int32_t most, double cost);

void pv_vk_push(pv_vk_engine *e);
void pv_vk_bind(pv_vk_engine *e, int shader, int32_t base, int32_t count);
/* Runs a shader over items base .. base + count - 1, or, in slices, over all. */
void pv_vk_dispatch(pv_vk_engine *e, int shader, int32_t base, int32_t count, int32_t per_group);
pave_result pv_vk_over(pv_vk_pass *p, int shader, int32_t items, int32_t per_group, double cost);

/* Empties the queue; and labels the tiles in it by the exact search. */
void pv_vk_clear_queue(pv_vk_engine *e);
void pv_vk_label_queued(pv_vk_engine *e);

/* Brings the labels of a block of tiles to their places among those of the plane. */
pave_result pv_vk_fetch_block(pv_vk_pass *p, int32_t count, int32_t *labels);
