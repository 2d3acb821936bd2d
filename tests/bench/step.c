/* Lloyd steps of several engines in turn, on one drawing: the least time of each step over all rounds, as JSON.
 *
 * usage: bench_step [--side PX] [--half-side H] [--rounds N] [--sites FILE] BACKEND:THREADS ...
 *
 * "step_s" is by the clock; "cpu_s" is the processors' time, which other work beside disturbs less. Says, too, whether
 * all engines ended with the same sites; writes where they are (px, a line each) to FILE. */
#include "cvd/cvd.h"
#include "util/random.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { STEPS = 20, MOST_ENGINES = 8 };

typedef struct engine {
    const char *spec;
    char name[128];
    pave_context *context;
    const pv_backend *backend;
    double least[STEPS], least_cpu[STEPS]; /* s */
    uint64_t sum;        /* over the sites at the end */
} engine;

typedef struct options {
    int32_t side, rounds, engines;
    double half_side;
    const char *sites;
    engine engine[MOST_ENGINES];
} options;

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

/* "vulkan-compute:2" */
static void open_engine(engine *e, const char *spec)
{
    pave_context_params shape = PAVE_CONTEXT_PARAMS_INIT;
    char backend[64];
    size_t length = strcspn(spec, ":");
    snprintf(backend, sizeof backend, "%.*s", (int)length, spec);
    shape.threads = spec[length] ? atoi(spec + length + 1) : 0;
    if (pave_context_create(NULL, &e->context))
        fail(NULL, spec);
    if (pave_params_set(e->context, PAVE_PARAMS_CONTEXT, &shape, "backend", backend))
        fail(e->context, spec);
    pave_context_free(&e->context);
    if (pave_context_create(&shape, &e->context))
        fail(NULL, spec);
    e->spec = spec;
    e->backend = pv_backend_find(shape.backend);
    if (!e->backend)
        fail(e->context, spec);
    for (int i = 0; i < STEPS; i++)
        e->least[i] = e->least_cpu[i] = 1e9;
}

static uint64_t look_at_sites(const pave_site *sites, int32_t count, const char *path)
{
    FILE *file = path ? fopen(path, "w") : NULL;
    uint64_t sum = 0;
    for (int32_t i = 0; i < count; i++) {
        sum = (sum ^ (uint32_t)sites[i].x ^ (uint64_t)(uint32_t)sites[i].y << 32) * 0x9E3779B97F4A7C15u;
        if (file)
            fprintf(file, "%.8f %.8f\n", sites[i].x / 256.0, sites[i].y / 256.0);
    }
    if (path && (!file || fclose(file)))
        fail(NULL, path);
    return sum;
}

static double cpu_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* Runs all steps once; keeps the least time of each. */
static void run(engine *e, const pv_plane *plane, const char *path)
{
    void *state;
    if (e->backend->open(e->context, plane, &state, e->name))
        fail(e->context, e->spec);
    for (int32_t i = 0; i < STEPS; i++) {
        pv_step step = { .deep = 0 };
        double since = pv_seconds(), spent = cpu_seconds();
        if (e->backend->step(e->context, state, i, 0, 1, &step))
            fail(e->context, e->spec);
        e->least[i] = fmin(e->least[i], pv_seconds() - since);
        e->least_cpu[i] = fmin(e->least_cpu[i], cpu_seconds() - spent);
    }
    pave_result result = PAVE_OK;
    pave_site *sites = pv_allocate(e->context, (size_t)plane->sites, sizeof *sites, &result);
    if (!sites || e->backend->sites(e->context, state, sites))
        fail(e->context, "sites");
    e->sum = look_at_sites(sites, plane->sites, path);
    pv_release(sites);
    e->backend->close(state);
}

static int report(const options *o, int32_t sites)
{
    int same = 1;
    printf("{\"side\": %d, \"half_side\": %g, \"sites\": %d, \"steps\": %d, \"engines\": [", (int)o->side,
           o->half_side, (int)sites, STEPS);
    for (int k = 0; k < o->engines; k++) {
        const engine *e = &o->engine[k];
        double sum = 0, cpu = 0;
        for (int i = 0; i < STEPS; i++)
            sum += e->least[i], cpu += e->least_cpu[i];
        printf("%s{\"engine\": \"%s\", \"name\": \"%s\", \"step_s\": %.9f, \"cpu_s\": %.9f, "
               "\"first_step_s\": %.9f}", k ? ", " : "", e->spec, e->name, sum / STEPS, cpu / STEPS, e->least[0]);
        same &= e->sum == o->engine[0].sum;
    }
    printf("], \"same_sites\": %s}\n", same ? "true" : "false");
    return same;
}

static int read_option(options *o, const char *name, const char *value)
{
    if (!strcmp(name, "--side"))
        o->side = atoi(value);
    else if (!strcmp(name, "--half-side"))
        o->half_side = atof(value);
    else if (!strcmp(name, "--rounds"))
        o->rounds = atoi(value);
    else if (!strcmp(name, "--sites"))
        o->sites = value;
    else
        return 0;
    return o->side > 0 && o->half_side >= 1 && o->rounds > 0;
}

int main(int argc, char **argv)
{
    options o = { .side = 1024, .half_side = 4, .rounds = 1 };
    for (int i = 1; i < argc; i++)
        if (argv[i][0] != '-' && o.engines < MOST_ENGINES)
            open_engine(&o.engine[o.engines++], argv[i]);
        else if (i + 1 == argc || !read_option(&o, argv[i], argv[i + 1]))
            return fprintf(stderr, "step: cannot use %s\n", argv[i]), 2;
        else
            i++;
    if (!o.engines)
        return fprintf(stderr, "step: which engines?\n"), 2;
    pv_plane plane;
    make_plane(o.engine[0].context, o.side, o.half_side, &plane);
    for (int32_t round = 0; round < o.rounds; round++)
        for (int k = 0; k < o.engines; k++)
            run(&o.engine[k], &plane, round || k ? NULL : o.sites);
    int same = report(&o, plane.sites);
    release_plane(&plane);
    for (int k = 0; k < o.engines; k++)
        pave_context_free(&o.engine[k].context);
    return !same;
}
