/* One Lloyd step by the portable and the AVX2 kernel in turn: least time of several runs in ns per pixel and step. */
#include "cvd/cvd.h"
#include "util/random.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 20, KERNELS = 2 };

static const pv_backend *const kernels[KERNELS] = { &pv_cpu_portable_backend, &pv_cpu_backend };

typedef struct timing {
    double half_side;
    int32_t sites;
    double start[KERNELS], mean[KERNELS]; /* first step, and mean of all, ns/px */
    int same;
} timing;

static void fail(const pave_context *context, const char *what)
{
    fprintf(stderr, "step: %s: %s\n", what, context ? pave_context_message(context) : "no context");
    exit(1);
}

/* Distance to a ring and a diagonal, as a drawing would give it. */
static void draw_edges(uint16_t *edge, int32_t side)
{
    for (int32_t y = 0; y < side; y++)
        for (int32_t x = 0; x < side; x++) {
            int64_t cx = x - side / 2, cy = y - side / 2, line = 181 * (cx > cy ? cx - cy : cy - cx);
            int64_t ring = (cx * cx + cy * cy - (int64_t)side * side / 16) * 512 / side;
            ring = ring < 0 ? -ring : ring;
            int64_t d = ring < line ? ring : line;
            edge[(int64_t)y * side + x] = (uint16_t)(d < UINT16_MAX ? d : UINT16_MAX);
        }
}

static void make_plane(pave_context *context, int32_t side, double h, pv_plane *plane)
{
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    pave_result result = PAVE_OK;
    params.half_side = h;
    memset(plane, 0, sizeof *plane);
    plane->width = plane->height = side;
    plane->cell = (int32_t)(512 * h);
    plane->push_within = (int32_t)(384 * h);
    plane->push_to = (int32_t)(256 * h);
    plane->noise_wave = (int32_t)(8192 * h);
    plane->noise_swing = 32768;
    plane->seed = 1;
    uint16_t *edge = pv_allocate(context, (size_t)side * (size_t)side, sizeof *edge, &result);
    if (!edge)
        fail(context, "edges");
    draw_edges(edge, side);
    plane->edge = edge;
    pv_place place = { 0, 0, side, side };
    pv_seeds seeds;
    if (pv_seeds_draw(context, &params, plane, &place, &seeds))
        fail(context, "seeds");
    plane->start = seeds.sites;
    plane->home = seeds.homes;
    plane->sites = seeds.count;
    pv_release(seeds.numbers);
}

static void release_plane(pv_plane *plane)
{
    pv_release((void *)(uintptr_t)plane->edge);
    pv_release((void *)(uintptr_t)plane->start);
    pv_release((void *)(uintptr_t)plane->home);
}

/* Runs all steps once; keeps the least time of each. Returns the sites' checksum. */
static uint64_t run(pave_context *context, const pv_backend *kernel, const pv_plane *plane, double *least)
{
    void *engine;
    char name[128];
    if (kernel->open(context, plane, &engine, name))
        fail(context, "open");
    for (int32_t i = 0; i < STEPS; i++) {
        pv_step step;
        double since = pv_seconds();
        if (kernel->step(context, engine, i, 0, 1, &step))
            fail(context, name);
        double took = pv_seconds() - since;
        least[i] = took < least[i] ? took : least[i];
    }
    pave_result result = PAVE_OK;
    pave_site *sites = pv_allocate(context, (size_t)plane->sites, sizeof *sites, &result);
    if (!sites || kernel->sites(context, engine, sites))
        fail(context, "sites");
    uint64_t sum = 0;
    for (int32_t i = 0; i < plane->sites; i++)
        sum = (sum ^ (uint32_t)sites[i].x ^ (uint64_t)(uint32_t)sites[i].y << 32) * 0x9E3779B97F4A7C15u;
    pv_release(sites);
    kernel->close(engine);
    return sum;
}

static timing compare(pave_context *context, int32_t side, double h, int32_t rounds)
{
    pv_plane plane;
    make_plane(context, side, h, &plane);
    timing t = { .half_side = h, .sites = plane.sites, .same = 1 };
    double least[KERNELS][STEPS];
    uint64_t sum[KERNELS];
    for (int k = 0; k < KERNELS; k++)
        for (int i = 0; i < STEPS; i++)
            least[k][i] = 1e9;
    for (int32_t round = 0; round < rounds; round++)
        for (int k = 0; k < KERNELS; k++)
            sum[k] = run(context, kernels[k], &plane, least[k]);
    for (int k = 0; k < KERNELS; k++) {
        double scale = 1e9 / side / side;
        for (int i = 0; i < STEPS; i++)
            t.mean[k] += least[k][i] * scale / STEPS;
        t.start[k] = least[k][0] * scale;
        t.same &= sum[k] == sum[0];
    }
    release_plane(&plane);
    return t;
}

static void print(const timing *t)
{
    printf("h %4.1f  %6d sites  portable %6.2f (first step %6.2f)  AVX2 %5.2f (first step %5.2f)  ratio %5.2f  %s\n",
           t->half_side, (int)t->sites, t->mean[0], t->start[0], t->mean[1], t->start[1], t->mean[0] / t->mean[1],
           t->same ? "same sites" : "SITES DIFFER");
    fflush(stdout);
}

static int write_json(const char *path, const timing *t, int count)
{
    FILE *file = fopen(path, "w");
    if (!file)
        return 0;
    fprintf(file, "[\n");
    for (int i = 0; i < count; i++)
        fprintf(file,
                "  { \"half_side\": %.1f, \"sites\": %d, \"portable_ns\": %.3f, \"portable_first_ns\": %.3f, "
                "\"avx2_ns\": %.3f, \"avx2_first_ns\": %.3f, \"ratio\": %.3f, \"same\": %s }%s\n",
                t[i].half_side, (int)t[i].sites, t[i].mean[0], t[i].start[0], t[i].mean[1], t[i].start[1],
                t[i].mean[0] / t[i].mean[1], t[i].same ? "true" : "false", i + 1 < count ? "," : "");
    fprintf(file, "]\n");
    return !fclose(file);
}

int main(int argc, char **argv)
{
    static const double sizes[] = { 2.5, 4, 8, 16, 32 };
    enum { SIZES = sizeof sizes / sizeof *sizes };
    int32_t side = 1024, rounds = 7;
    const char *json = NULL;
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--quick"))
            side = 256, rounds = 2;
        else if (!strcmp(argv[i], "--json") && i + 1 < argc)
            json = argv[++i];
        else
            return fprintf(stderr, "usage: step [--quick] [--json FILE]\n"), 2;
    }
    pave_context_params shape = PAVE_CONTEXT_PARAMS_INIT;
    shape.threads = 1;
    pave_context *context;
    if (pave_context_create(&shape, &context))
        fail(NULL, "context");
    timing t[SIZES];
    int same = 1;
    for (int i = 0; i < SIZES; i++) {
        t[i] = compare(context, side, sizes[i], rounds);
        print(&t[i]);
        same &= t[i].same;
    }
    int written = !json || write_json(json, t, SIZES);
    if (!written)
        fprintf(stderr, "step: cannot write %s\n", json);
    pave_context_free(&context);
    return same && written ? 0 : 1;
}
