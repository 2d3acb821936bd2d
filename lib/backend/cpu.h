/* The CPU engine from inside: the frame that its three kernels share. */
#pragma once

#include "backend/relax.h"

enum {
    PV_TILE = 8,           /* pixels a side */
    PV_TILE_RADIUS = 1268, /* tile centre to the farthest pixel centre: 3.5*sqrt(2) px, rounded up */
    PV_LANES = 8,
};

typedef struct pv_cpu pv_cpu;

/* Labels row `ty` of tiles: adds its pixels to `sums` and, unless NULL, writes them to `labels` (whole plane). Returns
 * an upper bound of the distance from a pixel that counts to its site, 1/256 px. */
typedef int32_t pv_label_row(const pv_cpu *cpu, int32_t ty, pv_sum *sums, int32_t *labels);

/* Sorted sites member by member, for vectors: PV_LANES can be read from any place on. */
typedef struct pv_columns {
    int32_t *x, *y, *cosine, *sine;
    int32_t *box; /* half_x in the low 16 bits, half_y in the high ones; extents are cut to 32767 */
} pv_columns;

/* Where pixels count for the radius, px. */
typedef struct pv_watch {
    int32_t left, top, right, bottom;
} pv_watch;

struct pv_cpu {
    pv_plane plane;
    pv_watch watch;
    pv_label_row *label_row;
    pave_site *sites;
    int32_t workers;
    pv_sum *sums; /* workers * sites */
    uint8_t *near; /* plane.near */
    /* Sites sorted into square buckets, row by row: bucket k has the places first[k] .. first[k+1]-1. */
    int32_t bucket, across, down; /* side in 1/256 px, buckets in x and y */
    int64_t buckets;
    uint64_t per_bucket; /* 2^32 / bucket, rounded up */
    int32_t reach; /* pv_plane_reach and pv_plane_stretch */
    double stretch;
    int32_t *first;
    int32_t *index;     /* which site, in sorted order */
    pave_site *sorted;  /* copies, so that neighbours lie together: */
    pv_columns columns; /* the one or the other */
    uint64_t squeeze[1 << PV_LANES]; /* of the bits set in a mask of lanes, the lanes, in a byte each */
    int32_t parts;      /* that are sorted side by side */
    int32_t *place, *block_first;
};

static inline const pave_site *pv_cpu_sorted(const pv_cpu *cpu, int32_t at)
{
    return cpu->sorted ? &cpu->sorted[at] : &cpu->sites[cpu->index[at]];
}

/* kernels */
pv_label_row pv_label_row_reference, pv_label_row_portable;
#ifdef __x86_64__
#define PV_AVX2 1
pv_label_row pv_label_row_avx2;

/* Turns four sites by the noise if they all lie in this one cell of it; else 0. */
int pv_sites_turn_avx2(const pv_plane *plane, const pv_noise_cell *cell, pave_site *const site[4]);
#endif

/* The frame: `sites` begin as the plane's, pv_cpu_sort sorts them into the buckets (progress stays `at`), and
 * pv_cpu_relax moves them by the sums of all workers, which it clears. */
pave_result pv_cpu_open(pave_context *context, const pv_plane *plane, pv_label_row *kernel, void **engine);
pave_result pv_cpu_sort(pave_context *context, pv_cpu *cpu, double at);
int32_t pv_cpu_blocks(int64_t buckets); /* the length of block_first */
pave_result pv_cpu_relax(pave_context *context, pv_cpu *cpu, int32_t iteration, double from, double to, pv_step *out);
void pv_cpu_close(void *engine);

/* Lets only pixels count for the radius that are so deep inside, px. */
void pv_cpu_watch(pv_cpu *cpu, int32_t deep);

/* Does a tile count, the first pixel of which is (x, y)? */
static inline int pv_watched(const pv_cpu *cpu, int32_t x, int32_t y)
{
    return x + PV_TILE > cpu->watch.left && x < cpu->watch.right && y + PV_TILE > cpu->watch.top &&
           y < cpu->watch.bottom;
}

/* Labels the one tile whose first pixel is (x, y), and returns that bound. */
int32_t pv_label_tile_portable(const pv_cpu *cpu, int32_t x, int32_t y, pv_sum *sums, int32_t *labels);

/* The exact label of one pixel by a ring search over the buckets: the slow path for tiles with too many candidates. */
int32_t pv_label_pixel(const pv_cpu *cpu, int32_t px, int32_t py);

/* How far a site at a distance, as the metric has it, may lie; 1/256 px. */
static inline int32_t pv_cpu_range(const pv_cpu *cpu, double distance)
{
    double range = distance * cpu->stretch + cpu->reach + 1;
    return range < INT32_MAX / 4 ? (int32_t)range : INT32_MAX / 4;
}

/* The mask of the tile whose first pixel is (x, y). */
static inline uint64_t pv_tile_mask(const pv_plane *plane, int32_t x, int32_t y)
{
    int64_t across = (plane->width + PV_TILE - 1) / PV_TILE;
    return plane->mask ? plane->mask[y / PV_TILE * across + x / PV_TILE] : 0;
}

static inline int pv_masked(const pv_plane *plane, int32_t x, int32_t y)
{
    return pv_tile_mask(plane, x, y) >> (y % PV_TILE * PV_TILE + x % PV_TILE) & 1;
}

/* Raises a number that several threads look for the greatest of. */
static inline void pv_raise(atomic_int *most, int value)
{
    for (int known = atomic_load(most); value > known;)
        if (atomic_compare_exchange_weak(most, &known, value))
            break;
}

/* Adds a run of pixels of one site to its sum. */
static inline void pv_sum_add(pv_sum *sum, int64_t count, int64_t x, int64_t y)
{
    sum->count += count;
    sum->x += x;
    sum->y += y;
}
