/* The CPU engine: sort the sites into buckets, label tile rows in parallel, move the sites. Its frame serves raster
 * engines too, which label most pixels elsewhere. */
#include "backend/cpu.h"

#include "base/parallel.h"
#include "util/fixed.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PARTS = 16 };

void pv_cpu_close(void *engine)
{
    pv_cpu *cpu = engine;
    if (!cpu)
        return;
    pv_release(cpu->sites);
    pv_release(cpu->sums);
    pv_release(cpu->first);
    pv_release(cpu->index);
    pv_release(cpu->sorted);
    pv_release(cpu->columns.x);
    pv_release(cpu->place);
    pv_release(cpu->block_first);
    pv_release(cpu->near);
    pv_release(cpu);
}

static int by_columns(const pv_cpu *cpu)
{
#ifdef PV_AVX2
    return cpu->label_row == pv_label_row_avx2;
#else
    return cpu->label_row == NULL;
#endif
}

/* One block for the five columns. */
static pave_result allocate_columns(pave_context *context, pv_cpu *cpu)
{
    pave_result result = PAVE_OK;
    size_t length = (size_t)cpu->plane.sites + PV_LANES;
    pv_columns *c = &cpu->columns;
    c->x = pv_allocate_zeroed(context, 5 * length, sizeof *c->x, &result);
    if (!result) {
        c->y = c->x + length;
        c->cosine = c->y + length;
        c->sine = c->cosine + length;
        c->box = c->sine + length;
        for (size_t i = length - PV_LANES; i < length; i++)
            c->x[i] = c->y[i] = 1 << 30; /* beyond any reach */
    }
    return result;
}

static void fill_squeeze(uint64_t *squeeze)
{
    for (uint32_t mask = 0; mask < 1 << PV_LANES; mask++) {
        squeeze[mask] = 0;
        for (uint64_t lane = 0, at = 0; lane < PV_LANES; lane++)
            if (mask >> lane & 1) {
                squeeze[mask] |= lane << at;
                at += 8;
            }
    }
}

static pave_result allocate_buckets(pave_context *context, pv_cpu *cpu)
{
    pave_result result = PAVE_OK;
    cpu->first = pv_allocate(context, (size_t)cpu->buckets + 1, sizeof *cpu->first, &result);
    if (!result)
        cpu->place = pv_allocate(context, (size_t)cpu->buckets * (size_t)cpu->parts, sizeof *cpu->place, &result);
    if (!result)
        cpu->block_first = pv_allocate(context, (size_t)pv_cpu_blocks(cpu->buckets), sizeof *cpu->block_first, &result);
    if (!result)
        cpu->first[cpu->buckets] = cpu->plane.sites;
    return result;
}

static size_t near_across(const pv_cpu *cpu)
{
    return (size_t)pv_ceil_div(cpu->plane.width, PV_NEAR);
}

static size_t near_rows(const pv_cpu *cpu)
{
    return (size_t)pv_ceil_div(cpu->plane.height, PV_NEAR);
}

static pave_result allocate(pave_context *context, pv_cpu *cpu)
{
    size_t n = (size_t)cpu->plane.sites;
    pave_result result = allocate_buckets(context, cpu);
    if (!result && cpu->plane.edge)
        cpu->near = pv_allocate(context, near_across(cpu) * near_rows(cpu), 1, &result);
    if (!result)
        cpu->sites = pv_allocate(context, n, sizeof *cpu->sites, &result);
    if (!result)
        cpu->sums = pv_allocate_zeroed(context, n * (size_t)cpu->workers, sizeof *cpu->sums, &result);
    if (!result)
        cpu->index = pv_allocate_zeroed(context, n + PV_LANES, sizeof *cpu->index, &result);
    if (!result && by_columns(cpu))
        result = allocate_columns(context, cpu);
    else if (!result)
        cpu->sorted = pv_allocate(context, n, sizeof *cpu->sorted, &result);
    return result;
}

pave_result pv_cpu_open(pave_context *context, const pv_plane *plane, pv_label_row *kernel, void **engine)
{
    pave_result result;
    pv_cpu *cpu = pv_allocate_zeroed(context, 1, sizeof *cpu, &result);
    if (!cpu)
        return result;
    cpu->plane = *plane;
    cpu->label_row = kernel;
    cpu->workers = pv_workers(context);
    cpu->bucket = plane->cell + plane->cell / 4; /* then a row of a window is about a vector of sites */
    cpu->across = (int32_t)pv_ceil_div(256 * (int64_t)plane->width, cpu->bucket);
    cpu->down = (int32_t)pv_ceil_div(256 * (int64_t)plane->height, cpu->bucket);
    cpu->buckets = (int64_t)cpu->across * cpu->down;
    cpu->per_bucket = (uint64_t)pv_ceil_div((int64_t)1 << 32, cpu->bucket);
    cpu->parts = cpu->workers < MOST_PARTS ? cpu->workers : MOST_PARTS;
    cpu->reach = pv_plane_reach(plane);
    fill_squeeze(cpu->squeeze);
    cpu->stretch = pv_plane_stretch(plane);
    result = allocate(context, cpu);
    if (result) {
        pv_cpu_close(cpu);
        return result;
    }
    memcpy(cpu->sites, plane->start, (size_t)plane->sites * sizeof *cpu->sites);
    *engine = cpu;
    return PAVE_OK;
}

static pave_result reference_open(pave_context *context, const pv_plane *plane, void **engine, char *name)
{
    snprintf(name, 128, "cpu-reference");
    return pv_cpu_open(context, plane, pv_label_row_reference, engine);
}

static pave_result portable_open(pave_context *context, const pv_plane *plane, void **engine, char *name)
{
    snprintf(name, 128, "cpu-portable");
    return pv_cpu_open(context, plane, pv_label_row_portable, engine);
}

static int have_avx2(void)
{
#ifdef PV_AVX2
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
           __builtin_cpu_supports("popcnt");
#else
    return 0;
#endif
}

static pave_result cpu_open(pave_context *context, const pv_plane *plane, void **engine, char *name)
{
#ifdef PV_AVX2
    if (have_avx2()) {
        snprintf(name, 128, "cpu (AVX2)");
        return pv_cpu_open(context, plane, pv_label_row_avx2, engine);
    }
#endif
    snprintf(name, 128, "cpu");
    return pv_cpu_open(context, plane, pv_label_row_portable, engine);
}

typedef struct label_job {
    pv_cpu *cpu;
    int32_t *labels;
    atomic_int radius;
} label_job;

static void label_task(void *data, int32_t ty, int32_t worker)
{
    label_job *job = data;
    pv_cpu *cpu = job->cpu;
    pv_sum *sums = cpu->sums + (size_t)worker * (size_t)cpu->plane.sites;
    pv_raise(&job->radius, cpu->label_row(cpu, ty, sums, job->labels));
}

static pave_result label_all(pave_context *context, pv_cpu *cpu, int32_t *labels, double from, double to,
                             int32_t *radius)
{
    label_job job = { .cpu = cpu, .labels = labels };
    int32_t rows = (int32_t)pv_ceil_div(cpu->plane.height, PV_TILE);
    pave_result result = pv_cpu_sort(context, cpu, from);
    if (!result)
        result = pv_parallel(context, rows, label_task, &job, from, to);
    *radius = atomic_load(&job.radius);
    return result;
}

typedef struct relax_job {
    pv_cpu *cpu;
    int32_t iteration;
    atomic_llong empty, moved, way;
    atomic_int stray;
} relax_job;

enum { CHUNK = 4096, AHEAD = 12, FOUR = 4 };

static int32_t move_of(const pave_site *before, const pave_site *after)
{
    int32_t x = abs(after->x - before->x), y = abs(after->y - before->y);
    return x > y ? x : y;
}

/* Sites that the noise is to turn, some at a time. */
typedef struct turns {
    pave_site *site[FOUR];
    int32_t count;
    pv_noise_cell cell;
} turns;

/* Turns those that wait, or if they do not lie in one cell, the first: then its cell is the one for the others. */
static void turn_some(const pv_cpu *cpu, turns *t)
{
#ifdef PV_AVX2
    if (t->count == FOUR && by_columns(cpu) && pv_sites_turn_avx2(&cpu->plane, &t->cell, t->site)) {
        t->count = 0;
        return;
    }
#endif
    pv_site_turn_by_noise(&cpu->plane, &t->cell, t->site[0]);
    memmove(t->site, t->site + 1, (size_t)--t->count * sizeof *t->site);
}

/* What all workers found of a site's pixels; takes it from them. */
static pv_sum sum_of(const pv_cpu *cpu, int32_t i)
{
    pv_sum sum = { 0, 0, 0 };
    for (int32_t w = 0; w < cpu->workers; w++) {
        pv_sum *part = &cpu->sums[(size_t)w * (size_t)cpu->plane.sites + (size_t)i];
        pv_sum_add(&sum, part->count, part->x, part->y);
        *part = (pv_sum){ 0, 0, 0 };
    }
    return sum;
}

static void relax_task(void *data, int32_t chunk, int32_t worker)
{
    (void)worker;
    relax_job *job = data;
    pv_cpu *cpu = job->cpu;
    int32_t n = cpu->plane.sites, to = (chunk + 1) * CHUNK < n ? (chunk + 1) * CHUNK : n;
    int64_t empty = 0, moved = 0, way = 0;
    int32_t stray = 0;
    turns waiting = { .count = 0 };
    for (int32_t i = chunk * CHUNK; i < to; i++) {
        pv_sum sum = sum_of(cpu, i);
        if (i + AHEAD < to)
            pv_site_prefetch(&cpu->plane, &cpu->sites[i + AHEAD]);
        if (cpu->plane.copies && cpu->plane.home[i].original)
            continue;
        pave_site before = cpu->sites[i];
        if (pv_site_relax(&cpu->plane, i, job->iteration, &sum, &cpu->sites[i]))
            waiting.site[waiting.count++] = &cpu->sites[i];
        if (waiting.count == FOUR)
            turn_some(cpu, &waiting);
        empty += !sum.count;
        int32_t move = move_of(&before, &cpu->sites[i]);
        moved += move > 0;
        way += move;
        if (cpu->plane.copies && pv_site_stray(&cpu->plane, i, &cpu->sites[i]) > stray)
            stray = pv_site_stray(&cpu->plane, i, &cpu->sites[i]);
    }
    while (waiting.count)
        turn_some(cpu, &waiting);
    pv_raise(&job->stray, stray);
    atomic_fetch_add(&job->empty, empty);
    atomic_fetch_add(&job->moved, moved);
    atomic_fetch_add(&job->way, way);
}

static void near_task(void *data, int32_t row, int32_t worker)
{
    (void)worker;
    pv_cpu *cpu = data;
    pv_near_row(&cpu->plane, row, cpu->near + (size_t)row * near_across(cpu));
}

/* Before the first sites move. */
static pave_result find_near(pave_context *context, pv_cpu *cpu, double at)
{
    if (!cpu->near || cpu->plane.near)
        return PAVE_OK;
    pave_result result = pv_parallel(context, (int32_t)near_rows(cpu), near_task, cpu, at, at);
    cpu->plane.near = result ? NULL : cpu->near;
    return result;
}

pave_result pv_cpu_relax(pave_context *context, pv_cpu *cpu, int32_t iteration, double from, double to, pv_step *out)
{
    relax_job job = { .cpu = cpu, .iteration = iteration };
    int32_t chunks = (int32_t)pv_ceil_div(cpu->plane.sites, CHUNK);
    pave_result result = find_near(context, cpu, from);
    if (!result)
        result = pv_parallel(context, chunks, relax_task, &job, from, to);
    for (int32_t i = 0; i < cpu->plane.sites && cpu->plane.copies; i++)
        if (cpu->plane.home[i].original)
            pv_site_copy(&cpu->plane, i, cpu->sites);
    out->stray = atomic_load(&job.stray);
    out->empty = atomic_load(&job.empty);
    out->moved = atomic_load(&job.moved);
    out->way = atomic_load(&job.way);
    return result;
}

void pv_cpu_watch(pv_cpu *cpu, int32_t deep)
{
    const pv_plane *p = &cpu->plane;
    cpu->watch = (pv_watch){ p->open & PV_LEFT ? deep : 0, p->open & PV_TOP ? deep : 0,
                             p->width - (p->open & PV_RIGHT ? deep : 0), p->height - (p->open & PV_BOTTOM ? deep : 0) };
}

static pave_result cpu_step(pave_context *context, void *engine, int32_t iteration, double from, double to,
                            pv_step *out)
{
    double middle = from + 0.9 * (to - from);
    pv_cpu_watch(engine, out->deep);
    pave_result result = label_all(context, engine, NULL, from, middle, &out->radius);
    return result ? result : pv_cpu_relax(context, engine, iteration, middle, to, out);
}

static pave_result cpu_labels(pave_context *context, void *engine, double from, double to, int32_t *labels)
{
    int32_t radius;
    return label_all(context, engine, labels, from, to, &radius);
}

static pave_result cpu_sites(pave_context *context, void *engine, pave_site *sites)
{
    const pv_cpu *cpu = engine;
    (void)context;
    memcpy(sites, cpu->sites, (size_t)cpu->plane.sites * sizeof *sites);
    return PAVE_OK;
}

static void cpu_list(pave_context *context, pave_device *devices, int32_t capacity, int32_t *count)
{
    char text[64];
    snprintf(text, sizeof text, "%s, %d thread%s", have_avx2() ? "AVX2" : "portable C", (int)pv_workers(context),
             pv_workers(context) > 1 ? "s" : "");
    pv_device_add(devices, capacity, count, PAVE_BACKEND_CPU, 1, text);
}

static void list_nothing(pave_context *context, pave_device *devices, int32_t capacity, int32_t *count)
{
    (void)context, (void)devices, (void)capacity, (void)count;
}

const pv_backend pv_cpu_backend = {
    PAVE_BACKEND_CPU, cpu_open, cpu_step, cpu_labels, cpu_sites, pv_cpu_close, cpu_list,
};
const pv_backend pv_cpu_portable_backend = {
    PAVE_BACKEND_CPU_PORTABLE, portable_open, cpu_step, cpu_labels, cpu_sites, pv_cpu_close, list_nothing,
};
const pv_backend pv_cpu_reference_backend = {
    PAVE_BACKEND_CPU_REFERENCE, reference_open, cpu_step, cpu_labels, cpu_sites, pv_cpu_close, list_nothing,
};
