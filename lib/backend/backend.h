/* The engine's op table: what every backend must do, and give the same bytes for. */
#pragma once

#include "base/context.h"

#include <pave/cvd.h>
#include <pave/pave.h>

/* The lattice cell that a site was first drawn in, and the number of the draw in its block: its name for ever, and
 * what its random numbers are counted by. A site with an original, the one of index original - 1, has no home but
 * stays (x, y) away from it (1/256 px): its copy, some periods away. */
typedef struct pv_home {
    int32_t x, y, slot, original;
} pv_home;

enum { PV_NEAR = 8 };
enum { PV_LEFT = 1, PV_TOP = 2, PV_RIGHT = 4, PV_BOTTOM = 8 };

/* The problem: a plane of pixels with sites on it, and how they move. Lengths are in 1/256 px. */
typedef struct pv_plane {
    int32_t width, height;      /* px */
    int32_t origin_x, origin_y; /* of the corner in the whole plane, which homes and noise belong to: 1/256 px */
    int32_t period_x, period_y; /* after which home lattice and noise repeat, 1/256 px; 0: never */
    int32_t copies;             /* some sites have an original */
    int32_t open;               /* PV_LEFT and so on: borders beyond which the whole plane goes on */
    int32_t sites;
    const pave_site *start; /* in index order, which is the order of their home blocks and cells */
    const pv_home *home;
    const uint16_t *edge;   /* distance to the nearest edge in 2^edge_shift / 256 px, saturated; NULL: no edges */
    int32_t edge_shift;
    const uint8_t *near;    /* for each PV_NEAR x PV_NEAR px: is one within push_within of an edge? NULL: not known */
    int32_t cell;           /* side of the home lattice's cells, 2h */
    int32_t push_within, push_to;
    int32_t excess;             /* relaxation - 1, 1/65536: how far a site goes beyond the centroid */
    int32_t noise_wave;
    int32_t noise_swing;    /* greatest rotation, 65536 to a turn */
    uint32_t noise_key;
    uint64_t seed;
    int32_t metric;            /* PAVE_METRIC_; the slopes of pyramids are 1 .. pv_steepest(metric) */
    const uint16_t *direction; /* how a site is turned at each pixel, 65536 to a turn; NULL: by edges and noise */
    const uint64_t *mask;      /* for each tile of 8 x 8 px, row by row, the pixels that count for no centroid: bit
                                  8 * y + x; NULL: none */
} pv_plane;

/* What a step is asked, and reports back. */
typedef struct pv_step {
    int32_t deep;  /* asked: pixels nearer than that to an open border need not count for the radius, px */
    int64_t empty; /* cells without a pixel */
    int64_t moved; /* sites that are not where they were */
    int64_t way;   /* of all sites: the larger of the moves in x and in y, 1/256 px */
    int32_t radius; /* no pixel that counts was farther from its site; an upper bound, 1/256 px */
    int32_t stray; /* where sites have copies: no original is farther from its home cell, in x or in y, 1/256 px */
} pv_step;

typedef struct pv_backend {
    int32_t id;
    /* The engine's name for messages and reports, "cpu (AVX2)", written to `name` of 128 bytes. The plane's arrays
     * must stay valid until close. */
    pave_result (*open)(pave_context *context, const pv_plane *plane, void **engine, char *name);
    /* Labels every pixel, then moves every site: centroid, push, turn. Progress covers from..to of the stage. */
    pave_result (*step)(pave_context *context, void *engine, int32_t iteration, double from, double to, pv_step *out);
    /* Labels every pixel with the sites where they are. */
    pave_result (*labels)(pave_context *context, void *engine, double from, double to, int32_t *labels);
    pave_result (*sites)(pave_context *context, void *engine, pave_site *sites);
    void (*close)(void *engine);
    /* Adds its devices to the list; see pave_devices. */
    void (*list)(pave_context *context, pave_device *devices, int32_t capacity, int32_t *count);
} pv_backend;

extern const pv_backend pv_cpu_backend, pv_cpu_portable_backend, pv_cpu_reference_backend;
extern const pv_backend pv_vulkan_compute_backend, pv_vulkan_raster_backend;
extern const pv_backend pv_gles_backend;

/* The backend of an id; NULL if it is not in this build. */
const pv_backend *pv_backend_find(int32_t id);

/* Resolves PAVE_BACKEND_AUTO for a job of so many pixel steps. */
const pv_backend *pv_backend_choose(pave_context *context, const pv_plane *plane, int32_t iterations);

/* A point at distance d from a site, as the metric has it, lies within d * stretch + reach of it (1/256 px). The reach
 * is the greatest distance from a site of the plane to the corner of its box, rounded up, and 0 for pyramids; the
 * stretch is 1 for boxes. No metric grows faster than the way walked. */
int32_t pv_plane_reach(const pv_plane *plane);
double pv_plane_stretch(const pv_plane *plane);

/* The greatest slope of a pyramid, 1/65536, so that it grows no faster than the way walked. */
static inline int32_t pv_steepest(int32_t metric)
{
    return metric == PAVE_METRIC_DIAMOND ? 46340 : 65535;
}

/* Adds one entry to a device list. */
void pv_device_add(pave_device *devices, int32_t capacity, int32_t *count, int32_t backend, int32_t usable,
                   const char *name);
