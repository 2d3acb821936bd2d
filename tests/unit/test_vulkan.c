/* The Vulkan engines give the same labels and sites as the CPU, bit for bit. */
#include "backend/vulkan/compute.h"

#include "problem.h"

enum { ENGINES = 2 };
static const pv_backend *const engines[ENGINES] = { &pv_vulkan_compute_backend, &pv_vulkan_raster_backend };
static char ran_on[ENGINES][128]; /* told at the end: tests/run.sh looks for it */

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

static int open_shared_context(void **state)
{
    (void)state;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    params.message = on_message;
    params.threads = 2;
    return pave_context_create(&params, &context);
}

static int close_shared_context(void **state)
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

/* Pyramids over squares and rhombs, oriented by a given field, with pixels that count for nobody. */
static void mosaics(void **state)
{
    static const double h[] = { 1, 4, 16, 64 };
    (void)state;
    need_device();
    for (int metric = PAVE_METRIC_SQUARE; metric <= PAVE_METRIC_DIAMOND; metric++) {
        compare(context, &pv_cpu_reference_backend, as_mosaic(pose(97, 61, 4, SPREAD, 0, 0), metric, 1, 1, 1), 5);
        compare(context, &pv_cpu_reference_backend, as_mosaic(pose(97, 61, 4, CLUSTERED, 1, 300), metric, 4, 3, 1), 5);
        for (int k = 0; k < 4; k++)
            compare(context, &pv_cpu_portable_backend,
                    as_mosaic(pose(256, 203, h[k], SPREAD, 0, 0), metric, 1 + k, 1 + k % 2, k % 2), 10);
        compare(context, &pv_cpu_portable_backend, as_mosaic(pose(203, 157, 8, SPREAD, 0, 0), metric, 60, 40, 1), 4);
    }
    compare(context, &pv_cpu_portable_backend,
            as_mosaic(pose(900, 900, 10, SPREAD, 0, 2000), PAVE_METRIC_SQUARE, 2, 1, 1), 6);
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

/* Too many pixels, or more sites than a buffer holds: refused before anything of that size is made. */
static void refuses_what_is_too_large(void **state)
{
    (void)state;
    need_device();
    problem p = pose(64, 48, 4, SPREAD, 0, 0);
    p.plane.width = p.plane.height = 1 << 15;
    for (int k = 0; k < ENGINES; k++) {
        void *engine = NULL;
        char name[128];
        assert_int_equal(engines[k]->open(context, &p.plane, &engine, name), PAVE_ERR_UNSUPPORTED);
        assert_null(engine);
        assert_non_null(strstr(pave_context_message(context), "32768 x 32768 px are beyond the 2^28 px"));
    }
    pave_site *sites = calloc(1 << 24, sizeof *sites); /* never written, so they take no memory */
    pv_home *homes = calloc(1 << 24, sizeof *homes);
    p.plane.width = p.plane.height = 1 << 13;
    p.plane.start = sites;
    p.plane.home = homes;
    p.plane.sites = 1 << 24;
    for (int k = 0; k < ENGINES && sites && homes; k++) {
        void *engine = NULL;
        char name[128];
        pave_result result = engines[k]->open(context, &p.plane, &engine, name);
        if (result == PAVE_OK) { /* a device with larger buffers than lavapipe's */
            engines[k]->close(engine);
            continue;
        }
        assert_int_equal(result, PAVE_ERR_UNSUPPORTED);
        assert_non_null(strstr(pave_context_message(context), "lay it in windows"));
    }
    free(sites);
    free(homes);
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
        pv_step step = { .deep = 0 };
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
        cmocka_unit_test(mosaics),
        cmocka_unit_test(long_planes),
        cmocka_unit_test(beyond_images),
        cmocka_unit_test(gives_up_rather_than_guess),
        cmocka_unit_test(refuses_what_is_too_large),
        cmocka_unit_test(can_be_cancelled),
    };
    return cmocka_run_group_tests_name("vulkan", tests, open_shared_context, close_shared_context);
}
