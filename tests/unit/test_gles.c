/* The OpenGL ES engine gives the same labels and sites as the CPU, bit for bit. */
#include "backend/backend.h"
#include "backend/egl/egl.h"
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

/* `n` sites, or about as many as h asks for. */
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

static char ran_on[128]; /* told at the end: tests/run.sh looks for it */

static void compare(pave_context *context, const pv_backend *other, problem p, int32_t iterations)
{
    outcome a = solve(context, other, &p.plane, iterations);
    outcome b = solve(context, &pv_gles_backend, &p.plane, iterations);
    snprintf(ran_on, sizeof ran_on, "%s", b.name);
    assert_memory_equal(a.labels, b.labels, (size_t)p.plane.width * (size_t)p.plane.height * sizeof *a.labels);
    assert_memory_equal(a.sites, b.sites, (size_t)p.plane.sites * sizeof *a.sites);
    assert_int_equal(a.empty, b.empty);
    assert_int_equal(a.moved, b.moved);
    free(a.labels), free(a.sites);
    free(b.labels), free(b.sites);
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
    if (*ran_on)
        print_message("the GLES backend ran: %s\n", ran_on);
    return 0;
}

/* Skips, and says why, where there is no device. Where there is one, all must work. */
static void need_device(void)
{
    pave_device devices[16] = { 0 };
    int32_t count = 0;
    pv_gles_list(context, devices, 16, &count);
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
    pave_device devices[16] = { 0 };
    int32_t count = 0, all = 0;
    pv_gles_list(context, devices, 16, &count);
    pv_gles_list(context, NULL, 0, &all);
    assert_true(count > 0);
    assert_int_equal(count, all);
    assert_int_equal(devices[0].backend, PAVE_BACKEND_GLES);
    assert_true(strlen(devices[0].name) > 0);
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

/* More than one tile of targets, whatever their sides; farther than 2^24 / 256 px from the origin. */
static void long_planes(void **state)
{
    (void)state;
    need_device();
    compare(context, &pv_cpu_portable_backend, pose(17000, 40, 4, SPREAD, 1, 0), 3);
    compare(context, &pv_cpu_portable_backend, pose(41, 17001, 16, SPREAD, 1, 0), 3);
    compare(context, &pv_cpu_portable_backend, pose(2049, 1033, 8, SPREAD, 1, 0), 3);
    compare(context, &pv_cpu_portable_backend, pose(400003, 9, 4, SPREAD, 1, 0), 2);
    compare(context, &pv_cpu_portable_backend, pose(3, 1000003, 64, SPREAD, 0, 0), 2);
}

/* The plane's place in the whole turns its sites; its labels belong to the pixels of the plane. */
static void planes_lie_anywhere(void **state)
{
    (void)state;
    need_device();
    for (int edges = 0; edges < 2; edges++) {
        problem p = pose(203, 157, 4, SPREAD, edges, 0);
        p.plane.origin_x = 256 * 100000;
        p.plane.origin_y = 77 * 256 + 3;
        compare(context, &pv_cpu_reference_backend, p, 5);
    }
}

/* More sites than a slice, and so many on one spot that each pixel is drawn thousands of times. */
static void many_sites(void **state)
{
    (void)state;
    need_device();
    compare(context, &pv_cpu_portable_backend, pose(1024, 600, 1, SPREAD, 0, 0), 2);
    compare(context, &pv_cpu_portable_backend, pose(64, 48, 4, CLUSTERED, 0, 3000), 2);
}

/* Boxes that stretch from near nothing to beyond the reach of 32 bits. */
static void extreme_boxes(void **state)
{
    (void)state;
    need_device();
    for (int32_t k = 0; k < 4; k++) {
        problem p = pose(401, 203, 16, SPREAD, 1, 0);
        for (int32_t i = 0; i < p.plane.sites; i++) {
            p.sites[i].half_x = k == 0 ? 0 : k == 1 ? 10 * 4096 : k == 2 ? 256 * 80 : 256 * (i % 90);
            p.sites[i].half_y = k == 0 ? 0 : k == 3 ? 256 * (i % 7) : 410;
        }
        compare(context, &pv_cpu_portable_backend, p, 4);
    }
}

/* A host that draws with OpenGL itself finds its own context current after every call, and in every callback. */
static void leaves_the_host_alone(void **state)
{
    (void)state;
    need_device();
    pv_gl host = { 0 };
    pv_gl_host before;
    assert_null(pv_gl_open(&host));
    assert_true(pv_gl_enter(&host, &before));
    compare(context, &pv_cpu_portable_backend, pose(203, 157, 4, SPREAD, 1, 0), 2);
    assert_ptr_equal(host.egl_GetCurrentContext(), host.context);
    assert_int_equal(host.egl_QueryAPI(), EGL_OPENGL_ES_API);
    pv_gl_leave(&host, &before);
    assert_ptr_equal(host.egl_GetCurrentContext(), EGL_NO_CONTEXT);
    compare(context, &pv_cpu_portable_backend, pose(203, 157, 4, SPREAD, 1, 0), 2);
    assert_ptr_equal(host.egl_GetCurrentContext(), EGL_NO_CONTEXT);
    pv_gl_close(&host);
}

/* The CPU mends what the device leaves out, so equal labels alone do not tell that it draws. */
static void the_device_does_the_work(void **state)
{
    static const double h[] = { 1, 4, 16, 32 };
    (void)state;
    need_device();
    for (int k = 0; k < 4; k++) {
        problem p = pose(640, 480, h[k], SPREAD, 0, 0);
        void *engine = NULL;
        char name[128];
        pv_step step;
        assert_int_equal(pv_gles_backend.open(context, &p.plane, &engine, name), PAVE_OK);
        for (int32_t i = 0; i < 5; i++)
            assert_int_equal(pv_gles_backend.step(context, engine, i, 0, 0, &step), PAVE_OK);
        assert_true(pv_gles_mended(engine) < 0.05);
        pv_gles_backend.close(engine);
        forget(&p);
    }
}

typedef struct watch {
    pv_gl *gl;
    int32_t calls, stop_at;
} watch;

static int32_t on_progress(void *user, const char *stage, double done)
{
    watch *w = user;
    (void)stage, (void)done;
    assert_ptr_equal(w->gl->egl_GetCurrentContext(), EGL_NO_CONTEXT);
    return ++w->calls == w->stop_at;
}

/* Stopped at the first, second, ... look, until a step gets through; and nothing is current meanwhile. */
static void can_be_cancelled(void **state)
{
    (void)state;
    need_device();
    problem p = pose(1500, 1500, 4, SPREAD, 1, 0);
    pv_gl gl = { 0 };
    watch w = { &gl, 0, 0 };
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    pave_context *watched;
    params.progress = on_progress;
    params.progress_user = &w;
    assert_null(pv_gl_load(&gl));
    assert_int_equal(pave_context_create(&params, &watched), PAVE_OK);
    for (pave_result result = PAVE_ERR_CANCELLED; result; w.stop_at += 7) {
        void *engine = NULL;
        char name[128];
        pv_step step;
        w.calls = w.stop_at ? 0 : -1;
        assert_int_equal(pv_gles_backend.open(watched, &p.plane, &engine, name), PAVE_OK);
        if (!w.stop_at)
            pave_context_cancel(watched);
        pv_call call = pv_call_begin(watched, "test", 0, 1);
        result = pv_gles_backend.step(watched, engine, 0, 0, 1, &step);
        pv_call_end(watched, call);
        pv_gles_backend.close(engine);
        assert_true(result == PAVE_OK || result == PAVE_ERR_CANCELLED);
        assert_true(result || w.stop_at);
    }
    assert_true(w.stop_at > 7);
    pave_context_free(&watched);
    pv_gl_unload(&gl);
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
        cmocka_unit_test(planes_lie_anywhere),
        cmocka_unit_test(many_sites),
        cmocka_unit_test(extreme_boxes),
        cmocka_unit_test(the_device_does_the_work),
        cmocka_unit_test(leaves_the_host_alone),
        cmocka_unit_test(can_be_cancelled),
    };
    return cmocka_run_group_tests_name("gles", tests, open_context, close_context);
}
