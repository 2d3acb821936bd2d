/* Planes with sites made by hand, and what an engine makes of them: what the tests of the graphics engines share. */
#pragma once

#include "test.h"

#include "backend/backend.h"
#include "util/random.h"

enum { SPREAD, CLUSTERED, DOUBLED };

typedef struct problem {
    pv_plane plane;
    pave_site *sites;
    pv_home *homes;
    uint16_t *edge, *direction;
    uint64_t *mask;
} problem;

typedef struct outcome {
    int32_t *labels;
    pave_site *sites;
    int64_t empty, moved, way; /* of all steps, weighted */
    char name[128];
} outcome;

static inline int32_t fixed(double v)
{
    return (int32_t)(256 * v + 0.5);
}

static inline void place(const problem *p, int kind, int32_t i, int32_t n, pave_site *site)
{
    const pv_plane *plane = &p->plane;
    pv_random r = pv_draw(7, PV_DRAW_SITES, (uint32_t)(kind == DOUBLED ? i / 2 : i), 0, 0);
    site->x = (int32_t)pv_below(r.word[0], (uint32_t)(256 * plane->width));
    site->y = (int32_t)pv_below(r.word[1], (uint32_t)(256 * plane->height));
    if (kind == CLUSTERED && i >= n / 8) { /* most of them in one spot, many in the very same */
        site->x = 128 * plane->width + (int32_t)(r.word[0] % 40) / 4;
        site->y = 128 * plane->height + (int32_t)(r.word[1] % 40) / 4;
    }
    site->cosine = 65536;
    site->half_x = (int32_t)(plane->cell / 4.0 * (0.5 + 1.5 * r.word[2] / 4294967296.0));
    site->half_y = plane->cell / 4;
}

/* Two rings and a line, as chamfer-like distances, in 1/256 px. */
static inline void draw_edges(problem *p)
{
    pv_plane *plane = &p->plane;
    plane->edge = p->edge = calloc((size_t)plane->width * (size_t)plane->height, sizeof *p->edge);
    for (int32_t y = 0; y < plane->height; y++)
        for (int32_t x = 0; x < plane->width; x++) {
            int32_t line = abs(x - 2 * y + plane->height / 3) * 110, box = abs(abs(x - plane->width / 2) - 20) * 256;
            int32_t d = line < box ? line : box;
            p->edge[y * plane->width + x] = d < UINT16_MAX ? (uint16_t)d : UINT16_MAX;
        }
}

/* `n` sites, or about as many as h asks for. */
static inline problem pose(int32_t width, int32_t height, double h, int kind, int edges, int32_t n)
{
    problem p = { .plane = { .width = width, .height = height } };
    p.plane.cell = fixed(2 * h);
    p.plane.push_within = fixed(1.5 * h);
    p.plane.push_to = fixed(h);
    p.plane.excess = 13107 * (height % 5 - 2);
    p.plane.noise_wave = fixed(32 * h);
    p.plane.noise_swing = 32768;
    p.plane.noise_key = 0x12345678;
    p.plane.seed = 0x1234567890abcdef;
    if (!n)
        n = (int32_t)(width * height / (4 * h * h)) + 1;
    p.sites = calloc((size_t)n, sizeof *p.sites);
    p.homes = calloc((size_t)n, sizeof *p.homes);
    for (int32_t i = 0; i < n; i++) {
        place(&p, kind, i, n, &p.sites[i]);
        p.homes[i] = (pv_home){ p.sites[i].x / p.plane.cell, p.sites[i].y / p.plane.cell, i % 64, 0 };
    }
    p.plane.sites = n;
    p.plane.start = p.sites;
    p.plane.home = p.homes;
    if (edges)
        draw_edges(&p);
    return p;
}

static inline void forget(problem *p)
{
    free(p->sites);
    free(p->homes);
    free(p->edge);
    free(p->direction);
    free(p->mask);
}

/* Rings and a slope of directions; pixels in a ring and in every other diagonal band count for nobody. */
static inline void draw_directions(problem *p, int masked)
{
    int32_t width = p->plane.width, height = p->plane.height, across = (width + 7) / 8;
    p->plane.direction = p->direction = calloc((size_t)width * (size_t)height, sizeof *p->direction);
    p->mask = calloc((size_t)across * (size_t)((height + 7) / 8), sizeof *p->mask);
    p->plane.mask = masked ? p->mask : NULL;
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++) {
            int32_t ring = (x - width / 2) * (x - width / 2) + (y - height / 2) * (y - height / 2);
            p->direction[y * width + x] = (uint16_t)(ring * 7 + 150 * y);
            if (ring / 64 % 5 == 0 || (x + y) / 5 % 7 == 0)
                p->mask[y / 8 * across + x / 8] |= (uint64_t)1 << (y % 8 * 8 + x % 8);
        }
}

/* The same sites as the tiles of a mosaic, of sizes 1 .. `sizes` and sides in proportions up to `aspect`. */
static inline problem as_mosaic(problem p, int32_t metric, double sizes, double aspect, int masked)
{
    draw_directions(&p, masked);
    p.plane.metric = metric;
    for (int32_t i = 0; i < p.plane.sites; i++) {
        pv_random r = pv_draw(11, PV_DRAW_SCALE, (uint32_t)i, 0, 0);
        double size = 1 + (sizes - 1) * r.word[0] * 0x1p-32, proportion = 1 + (aspect - 1) * r.word[1] * 0x1p-32;
        double slope = pv_steepest(metric) / size;
        p.sites[i].half_x = (int32_t)(r.word[2] % 2 ? slope : slope / proportion);
        p.sites[i].half_y = (int32_t)(r.word[2] % 2 ? slope / proportion : slope);
    }
    return p;
}

static inline outcome solve(pave_context *context, const pv_backend *backend, const pv_plane *plane, int32_t iterations)
{
    outcome o = { 0 };
    void *engine = NULL;
    o.labels = malloc((size_t)plane->width * (size_t)plane->height * sizeof *o.labels);
    o.sites = malloc((size_t)plane->sites * sizeof *o.sites);
    assert_int_equal(backend->open(context, plane, &engine, o.name), PAVE_OK);
    for (int32_t i = 0; i < iterations; i++) {
        pv_step step = { .deep = 0 };
        assert_int_equal(backend->step(context, engine, i, 0, 0, &step), PAVE_OK);
        o.empty += (i + 1) * step.empty;
        o.moved += (i + 1) * step.moved;
        o.way += (i + 1) * step.way;
    }
    assert_int_equal(backend->labels(context, engine, 0, 1, o.labels), PAVE_OK);
    assert_int_equal(backend->sites(context, engine, o.sites), PAVE_OK);
    backend->close(engine);
    return o;
}

static inline void assert_same(const outcome *a, const outcome *b, const pv_plane *plane)
{
    assert_memory_equal(a->labels, b->labels, (size_t)plane->width * (size_t)plane->height * sizeof *a->labels);
    assert_memory_equal(a->sites, b->sites, (size_t)plane->sites * sizeof *a->sites);
    assert_int_equal(a->empty, b->empty);
    assert_int_equal(a->moved, b->moved);
    assert_int_equal(a->way, b->way);
}
