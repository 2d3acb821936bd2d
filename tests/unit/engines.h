/* The cases that every graphics engine must pass: the labels and the sites of the CPU, bit for bit. */
#pragma once

#include "problem.h"

/* What is tested; main says which before it runs the tests. */
static struct {
    const char *family;
    const pv_backend *engine[2];
    int count;
    char ran_on[2][128]; /* told at the end: tests/run.sh looks for it */
    pave_context *context;
} tested;

static void compare(const pv_backend *other, problem p, int32_t iterations)
{
    outcome a = solve(tested.context, other, &p.plane, iterations);
    for (int k = 0; k < tested.count; k++) {
        outcome b = solve(tested.context, tested.engine[k], &p.plane, iterations);
        snprintf(tested.ran_on[k], sizeof tested.ran_on[k], "%s", b.name);
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

static int open_tested(void **state)
{
    (void)state;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    params.message = on_message;
    params.threads = 2;
    return pave_context_create(&params, &tested.context);
}

static int close_tested(void **state)
{
    (void)state;
    pave_context_free(&tested.context);
    for (int k = 0; k < tested.count; k++)
        if (*tested.ran_on[k])
            print_message("the %s backend ran: %s\n", tested.family, tested.ran_on[k]);
    return 0;
}

/* Skips, and says why, where there is no device that can draw. Where there is one, all must work. */
static void need_device(void)
{
    pave_device devices[16] = { 0 };
    int32_t count = 0;
    tested.engine[tested.count - 1]->list(tested.context, devices, 16, &count);
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
    for (int k = 0; k < tested.count; k++) {
        pave_device devices[16] = { 0 };
        int32_t count = 0, all = 0;
        tested.engine[k]->list(tested.context, devices, 16, &count);
        tested.engine[k]->list(tested.context, NULL, 0, &all);
        assert_true(count > 0);
        assert_int_equal(count, all);
        assert_int_equal(devices[0].backend, tested.engine[k]->id);
        assert_true(strlen(devices[0].name) > 0);
    }
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
                compare(&pv_cpu_reference_backend, pose(size[s][0], size[s][1], h[k], SPREAD, edges, 0), 5);
}

static void matches_the_cpu(void **state)
{
    static const double h[] = { 1, 2.5, 4, 16, 64, 300 };
    (void)state;
    need_device();
    for (int k = 0; k < 6; k++) {
        compare(&pv_cpu_portable_backend, pose(203, 157, h[k], SPREAD, 1, 0), 20);
        compare(&pv_cpu_portable_backend, pose(256, 256, h[k], SPREAD, k % 2, 0), 20);
    }
    compare(&pv_cpu_portable_backend, pose(1024, 1024, 4, SPREAD, 1, 0), 4);
    compare(&pv_cpu_portable_backend, pose(1024, 1024, 300, SPREAD, 1, 0), 4);
}

static void clusters_overflow_exactly(void **state)
{
    (void)state;
    need_device();
    compare(&pv_cpu_reference_backend, pose(203, 157, 4, CLUSTERED, 0, 572), 6);
    compare(&pv_cpu_reference_backend, pose(203, 157, 4, CLUSTERED, 1, 572), 6);
    compare(&pv_cpu_reference_backend, pose(640, 320, 4, CLUSTERED, 0, 600), 2);
    compare(&pv_cpu_reference_backend, pose(203, 157, 4, DOUBLED, 1, 600), 6);
    compare(&pv_cpu_reference_backend, pose(300, 20, 16, CLUSTERED, 0, 2), 3);
}

/* Pyramids over squares and rhombs, oriented by a given field, with pixels that count for nobody. */
static void mosaics(void **state)
{
    static const double h[] = { 1, 4, 16, 64 };
    (void)state;
    need_device();
    for (int metric = PAVE_METRIC_SQUARE; metric <= PAVE_METRIC_DIAMOND; metric++) {
        compare(&pv_cpu_reference_backend, as_mosaic(pose(97, 61, 4, SPREAD, 0, 0), metric, 1, 1, 1), 5);
        compare(&pv_cpu_reference_backend, as_mosaic(pose(97, 61, 4, CLUSTERED, 1, 300), metric, 4, 3, 1), 5);
        for (int k = 0; k < 4; k++)
            compare(&pv_cpu_portable_backend,
                    as_mosaic(pose(256, 203, h[k], SPREAD, 0, 0), metric, 1 + k, 1 + k % 2, k % 2), 10);
        compare(&pv_cpu_portable_backend, as_mosaic(pose(203, 157, 8, SPREAD, 0, 0), metric, 60, 40, 1), 4);
    }
    compare(&pv_cpu_portable_backend, as_mosaic(pose(900, 900, 10, SPREAD, 0, 2000), PAVE_METRIC_SQUARE, 2, 1, 1), 6);
}

#define EVERY_ENGINE \
    cmocka_unit_test(lists_devices), cmocka_unit_test(matches_the_definition), cmocka_unit_test(matches_the_cpu), \
        cmocka_unit_test(clusters_overflow_exactly), cmocka_unit_test(mosaics)
