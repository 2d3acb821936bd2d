/* The raster engine from inside: what it keeps, and how a tile is drawn. */
#pragma once

#include "backend/cpu.h"
#include "backend/egl/egl.h"

enum {
    PV_GL_RECORDS = 1 << 14, /* sites in a slice */
    PV_GL_SLACK = 10,        /* more than the metric's errors within its narrow range, twice: 1/256 px */
    PV_GL_UNPROVEN = UINT8_MAX,
};

/* A site as the vertex shader takes it, relative to the tile. */
typedef struct pv_gl_record {
    int32_t x, y, cosine, sine, half_x, half_y, index;
} pv_gl_record;

typedef struct pv_gl_tile {
    int32_t x, y, width, height; /* px */
} pv_gl_tile;

typedef struct pv_gl_raster {
    pv_gl gl;
    pv_cpu *cpu;
    int32_t width, height;   /* of the targets, px */
    int32_t margin, most;    /* px */
    pv_gl_record *records;         /* the slice */
    int32_t count;
    double fragments;
    uint64_t *marks;         /* a bit for each site that is near the tile */
    int32_t low, high;       /* words of it, from .. to, that may have bits */
    uint32_t *labels;        /* of the tile, as seen */
    uint8_t *worst;          /* for each CPU tile, the greatest distance of a pixel in px; or PV_GL_UNPROVEN */
    int64_t found[UINT8_MAX + 1]; /* CPU tiles of this pass, by their worst */
    atomic_int radius;            /* no pixel of this pass is farther from its site, 1/256 px */
    int64_t tiles, mended;        /* CPU tiles since the engine was opened, and those that were unproven */
} pv_gl_raster;

static inline int32_t pv_gl_min(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static inline int32_t pv_gl_max(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

/* draw.c: makes the context current; leaves it, and fails if anything went wrong with it meanwhile. Between the two
 * nothing may call back. */
pave_result pv_gl_raster_enter(pave_context *context, const pv_gl_raster *r, pv_gl_host *host);
pave_result pv_gl_raster_leave(pave_context *context, const pv_gl_raster *r, const pv_gl_host *host);

/* Draws the sites near a tile, by the margin there is, and reads the labels back; `done` of the stage is over. */
pave_result pv_gl_draw(pave_context *context, pv_gl_raster *r, const pv_gl_tile *t, double done);
