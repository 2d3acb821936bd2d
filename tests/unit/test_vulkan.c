/* The Vulkan engines give the same labels and sites as the CPU, bit for bit. */
#include "backend/vulkan/compute.h"

#include "engines.h"

/* Farther than 2^24 / 256 px from the origin floats no longer hold a place. */
static void long_planes(void **state)
{
    (void)state;
    need_device();
    compare(&pv_cpu_portable_backend, pose(140003, 9, 4, SPREAD, 1, 0), 3);
    compare(&pv_cpu_portable_backend, pose(9, 100001, 2.5, SPREAD, 1, 0), 3);
    compare(&pv_cpu_portable_backend, pose(270001, 3, 64, SPREAD, 0, 0), 2);
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
    compare(&pv_cpu_portable_backend, pose(17000, 40, 4, SPREAD, 1, 0), 3);
    compare(&pv_cpu_portable_backend, pose(40, 17000, 4, SPREAD, 1, 0), 3);
    compare(&pv_cpu_portable_backend, pose(17000, 40, 4, DOUBLED, 0, 0), 3);
    compare(&pv_cpu_portable_backend, moved(pose(2100, 300, 2.5, SPREAD, 1, 0), 3, 5), 5);
    compare(&pv_cpu_portable_backend, moved(pose(203, 157, 16, SPREAD, 0, 0), 70, 0), 20);
}

/* Where a search would take too long for the device it ends with a sentence, never with other labels. */
static void gives_up_rather_than_guess(void **state)
{
    (void)state;
    need_device();
    problem p = pose(64, 48, 4, CLUSTERED, 0, 60000);
    outcome right = solve(tested.context, &pv_cpu_portable_backend, &p.plane, 0);
    for (int k = 0; k < tested.count; k++) {
        void *engine = NULL;
        char name[128];
        int32_t labels[64 * 48];
        assert_int_equal(tested.engine[k]->open(tested.context, &p.plane, &engine, name), PAVE_OK);
        pave_result result = tested.engine[k]->labels(tested.context, engine, 0, 1, labels);
        tested.engine[k]->close(engine);
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
    for (int k = 0; k < tested.count; k++) {
        void *engine = NULL;
        char name[128];
        assert_int_equal(tested.engine[k]->open(tested.context, &p.plane, &engine, name), PAVE_ERR_UNSUPPORTED);
        assert_null(engine);
        assert_non_null(strstr(pave_context_message(tested.context), "32768 x 32768 px are beyond the 2^28 px"));
    }
    pave_site *sites = calloc(1 << 24, sizeof *sites); /* never written, so they take no memory */
    pv_home *homes = calloc(1 << 24, sizeof *homes);
    p.plane.width = p.plane.height = 1 << 13;
    p.plane.start = sites;
    p.plane.home = homes;
    p.plane.sites = 1 << 24;
    for (int k = 0; k < tested.count && sites && homes; k++) {
        void *engine = NULL;
        char name[128];
        pave_result result = tested.engine[k]->open(tested.context, &p.plane, &engine, name);
        if (result == PAVE_OK) { /* a device with larger buffers than lavapipe's */
            tested.engine[k]->close(engine);
            continue;
        }
        assert_int_equal(result, PAVE_ERR_UNSUPPORTED);
        assert_non_null(strstr(pave_context_message(tested.context), "lay it in windows"));
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
    for (int k = 0; k < tested.count; k++) {
        void *engine = NULL;
        char name[128];
        pv_step step = { .deep = 0 };
        assert_int_equal(tested.engine[k]->open(tested.context, &p.plane, &engine, name), PAVE_OK);
        pave_context_cancel(tested.context);
        assert_int_equal(tested.engine[k]->step(tested.context, engine, 0, 0, 1, &step), PAVE_ERR_CANCELLED);
        tested.engine[k]->close(engine);
    }
    forget(&p);
}

static void tells_whether_there_is_a_gpu(void **state)
{
    (void)state;
    assert_in_range(pv_vulkan_has_gpu(tested.context), 0, 1);
}

int main(void)
{
    tested.family = "Vulkan";
    tested.engine[0] = &pv_vulkan_compute_backend;
    tested.engine[1] = &pv_vulkan_raster_backend;
    tested.count = 2;
    const struct CMUnitTest tests[] = {
        EVERY_ENGINE,
        cmocka_unit_test(tells_whether_there_is_a_gpu),
        cmocka_unit_test(long_planes),
        cmocka_unit_test(beyond_images),
        cmocka_unit_test(gives_up_rather_than_guess),
        cmocka_unit_test(refuses_what_is_too_large),
        cmocka_unit_test(can_be_cancelled),
    };
    return cmocka_run_group_tests_name("vulkan", tests, open_tested, close_tested);
}
