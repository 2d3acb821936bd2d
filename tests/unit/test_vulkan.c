/* The Vulkan engines give the same labels and sites as the CPU, bit for bit. */
#include "backend/backend.h"
#include "backend/vulkan/compute.h"
#include "util/random.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SPREAD, CLUSTERED, DOUBLED };

typedef struct problem {
    pv_plane plane;
    pave_site *sites;
    pv_home *homes;
    uint16_t *edge;
} problem;

typedef struct outcome {
    int32_t *labels;
    pave_site *sites;
    int64_t empty, moved; /* of all steps, weighted */
    char name[128];
} outcome;

static int32_t fixed(double v)
{
    return (int32_t)(256 * v + 0.5);
}

static void place(const problem *p, int kind, int32_t i, int32_t n, pave_site *site)
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
static void draw_edges(problem *p)
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

static problem pose(int32_t width, int32_t height, double h, int kind, int edges, int32_t n)
{
    problem p = { .plane = { .width = width, .height = height } };
    p.plane.cell = fixed(2 * h);
    p.plane.push_within = fixed(1.5 * h);
    p.plane.push_to = fixed(h);
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
        p.homes[i] = (pv_home){ p.sites[i].x / p.plane.cell, p.sites[i].y / p.plane.cell, i % 64 };
    }
    p.plane.sites = n;
    p.plane.start = p.sites;
    p.plane.home = p.homes;
    if (edges)
        draw_edges(&p);
    return p;
}

static void forget(problem *p)
{
    free(p->sites);
    free(p->homes);
    free(p->edge);
}

static outcome solve(pave_context *context, const pv_backend *backend, const pv_plane *plane, int32_t iterations)
{
    outcome o = { 0 };
    void *engine = NULL;
    o.labels = malloc((size_t)plane->width * (size_t)plane->height * sizeof *o.labels);
    o.sites = malloc((size_t)plane->sites * sizeof *o.sites);
    assert_int_equal(backend->open(context, plane, &engine, o.name), PAVE_OK);
    for (int32_t i = 0; i < iterations; i++) {
        pv_step step;
        assert_int_equal(backend->step(context, engine, i, 0, 0, &step), PAVE_OK);
        o.empty += (i + 1) * step.empty;
        o.moved += (i + 1) * step.moved;
    }
    assert_int_equal(backend->labels(context, engine, 0, 1, o.labels), PAVE_OK);
    assert_int_equal(backend->sites(context, engine, o.sites), PAVE_OK);
    backend->close(engine);
    return o;
}

enum { ENGINES = 2 };
static const pv_backend *const engines[ENGINES] = { &pv_vulkan_compute_backend, &pv_vulkan_raster_backend };
static char ran_on[ENGINES][128]; /* told at the end: tests/run.sh looks for it */

static void assert_same(const outcome *a, const outcome *b, const pv_plane *plane)
{
    assert_memory_equal(a->labels, b->labels, (size_t)plane->width * (size_t)plane->height * sizeof *a->labels);
    assert_memory_equal(a->sites, b->sites, (size_t)plane->sites * sizeof *a->sites);
    assert_int_equal(a->empty, b->empty);
    assert_int_equal(a->moved, b->moved);
}

static void compare(pave_context *context, const pv_backend *other, problem p, int32_t iterations)
{
    outcome a = solve(context, other, &p.plane, iterations);
    for (int k = 0; k < ENGINES; k++) {
        outcome b = solve(context, engines[k], &p.plane, iterations);
        snprintf(ran_on[k], sizeof ran_on[k], "%s", b.name);
        assert_same(&a, &b, &p.plane);
        free(b.labels), free(b.sites);
    }
    free(a.labels), free(a.sites);
    forget(&p);
}

static void on_message(void *user, int32_t level, const char *text)
{
    (void)user, (void)level;
    print_message("%s\n", text);
}

static pave_context *context;

static int open_context(void **state)
{
    (void)state;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    params.message = on_message;
    params.threads = 2;
    return pave_context_create(&params, &context);
}

static int close_context(void **state)
{
    (void)state;
    pave_context_free(&context);
    for (int k = 0; k < ENGINES; k++)
        if (*ran_on[k])
            print_message("the Vulkan backend ran: %s\n", ran_on[k]);
    return 0;
}

/* Skips, and says why, where there is no device that can draw. Where there is one, all must work. */
static void need_device(void)
{
    pave_device devices[16] = { 0 };
    int32_t count = 0;
    pv_vulkan_raster_backend.list(context, devices, 16, &count);
    assert_true(count > 0);
    for (int32_t i = 0; i < count && i < 16; i++)
        if (devices[i].usable)
            return;
    print_message("skipped: %s\n", devices[0].name);
    skip();
}

static void lists_devices(void **state)
{
    (void)state;
    for (int k = 0; k < ENGINES; k++) {
        pave_device devices[16] = { 0 };
        int32_t count = 0, all = 0;
        engines[k]->list(context, devices, 16, &count);
        engines[k]->list(context, NULL, 0, &all);
        assert_true(count > 0);
        assert_int_equal(count, all);
        assert_int_equal(devices[0].backend, engines[k]->id);
        assert_true(strlen(devices[0].name) > 0);
    }
    assert_in_range(pv_vulkan_has_gpu(context), 0, 1);
}

static void matches_the_definition(void **state)
{
    static const double h[] = { 1, 2.5, 4, 16, 64, 300 };
    static const int32_t size[][2] = { { 1, 1 }, { 7, 5 }, { 97, 61 } };
    (void)state;
    need_device();
    for (int s = 0; s < 3; s++)
        for (int k = 0; k < 6; k++)
            for (int edges = 0; edges < 2; edges++)
                compare(context, &pv_cpu_reference_backend, pose(size[s][0], size[s][1], h[k], SPREAD, edges, 0), 5);
}

static void matches_the_cpu(void **state)
{
    static const double h[] = { 1, 2.5, 4, 16, 64, 300 };
    (void)state;
    need_device();
    for (int k = 0; k < 6; k++) {
        compare(context, &pv_cpu_portable_backend, pose(203, 157, h[k], SPREAD, 1, 0), 20);
        compare(context, &pv_cpu_portable_backend, pose(256, 256, h[k], SPREAD, k % 2, 0), 20);
    }
    compare(context, &pv_cpu_portable_backend, pose(1024, 1024, 4, SPREAD, 1, 0), 4);
    compare(context, &pv_cpu_portable_backend, pose(1024, 1024, 300, SPREAD, 1, 0), 4);
}

static void clusters_overflow_exactly(void **state)
{
    (void)state;
    need_device();
    compare(context, &pv_cpu_reference_backend, pose(203, 157, 4, CLUSTERED, 0, 572), 6);
    compare(context, &pv_cpu_reference_backend, pose(203, 157, 4, CLUSTERED, 1, 572), 6);
    compare(context, &pv_cpu_reference_backend, pose(640, 320, 4, CLUSTERED, 0, 600), 2);
    compare(context, &pv_cpu_reference_backend, pose(203, 157, 4, DOUBLED, 1, 600), 6);
    compare(context, &pv_cpu_reference_backend, pose(300, 20, 16, CLUSTERED, 0, 2), 3);
}

/* Farther than 2^24 / 256 px from the origin floats no longer hold a place. */
static void long_planes(void **state)
{
    (void)state;
    need_device();
    compare(context, &pv_cpu_portable_backend, pose(400003, 9, 4, SPREAD, 1, 0), 3);
    compare(context, &pv_cpu_portable_backend, pose(9, 200001, 2.5, SPREAD, 1, 0), 3);
    compare(context, &pv_cpu_portable_backend, pose(1000003, 3, 64, SPREAD, 0, 0), 2);
}

/* Wider and taller than any image that a device may draw to; and somewhere in the whole. */
static problem moved(problem p, int32_t x, int32_t y)
{
    p.plane.origin_x = x * p.plane.cell;
    p.plane.origin_y = y * p.plane.cell;
    for (int32_t i = 0; i < p.plane.sites; i++) {
        p.homes[i].x += x;
        p.homes[i].y += y;
    }
    return p;
}

static void beyond_images(void **state)
{
    (void)state;
    need_device();
    compare(context, &pv_cpu_portable_backend, pose(17000, 40, 4, SPREAD, 1, 0), 3);
    compare(context, &pv_cpu_portable_backend, pose(40, 17000, 4, SPREAD, 1, 0), 3);
    compare(context, &pv_cpu_portable_backend, pose(17000, 40, 4, DOUBLED, 0, 0), 3);
    compare(context, &pv_cpu_portable_backend, moved(pose(2100, 300, 2.5, SPREAD, 1, 0), 3, 5), 5);
    compare(context, &pv_cpu_portable_backend, moved(pose(203, 157, 16, SPREAD, 0, 0), 70, 0), 20);
}

/* Where a search would take too long for the device it ends with a sentence, never with other labels. */
static void gives_up_rather_than_guess(void **state)
{
    (void)state;
    need_device();
    problem p = pose(64, 48, 4, CLUSTERED, 0, 60000);
    outcome right = solve(context, &pv_cpu_portable_backend, &p.plane, 0);
    for (int k = 0; k < ENGINES; k++) {
        void *engine = NULL;
        char name[128];
        int32_t labels[64 * 48];
        assert_int_equal(engines[k]->open(context, &p.plane, &engine, name), PAVE_OK);
        pave_result result = engines[k]->labels(context, engine, 0, 1, labels);
        engines[k]->close(engine);
        assert_true(result == PAVE_OK || result == PAVE_ERR_UNSUPPORTED);
        if (result == PAVE_OK)
            assert_memory_equal(labels, right.labels, sizeof labels);
    }
    free(right.labels), free(right.sites);
    forget(&p);
}

static void can_be_cancelled(void **state)
{
    (void)state;
    need_device();
    problem p = pose(1024, 1024, 4, SPREAD, 1, 0);
    for (int k = 0; k < ENGINES; k++) {
        void *engine = NULL;
        char name[128];
        pv_step step;
        assert_int_equal(engines[k]->open(context, &p.plane, &engine, name), PAVE_OK);
        pave_context_cancel(context);
        assert_int_equal(engines[k]->step(context, engine, 0, 0, 1, &step), PAVE_ERR_CANCELLED);
        engines[k]->close(engine);
    }
    forget(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lists_devices),
        cmocka_unit_test(matches_the_definition),
        cmocka_unit_test(matches_the_cpu),
        cmocka_unit_test(clusters_overflow_exactly),
        cmocka_unit_test(long_planes),
        cmocka_unit_test(beyond_images),
        cmocka_unit_test(gives_up_rather_than_guess),
        cmocka_unit_test(can_be_cancelled),
    };
    return cmocka_run_group_tests_name("vulkan", tests, open_context, close_context);
}
