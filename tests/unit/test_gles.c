/* The OpenGL ES engine gives the same labels and sites as the CPU, bit for bit. */
#include "backend/egl/egl.h"

#include "engines.h"

/* More than one tile of targets, whatever their sides; farther than 2^24 / 256 px from the origin. */
static void long_planes(void **state)
{
    (void)state;
    need_device();
    compare(&pv_cpu_portable_backend, pose(17000, 40, 4, SPREAD, 1, 0), 3);
    compare(&pv_cpu_portable_backend, pose(41, 17001, 16, SPREAD, 1, 0), 3);
    compare(&pv_cpu_portable_backend, pose(2049, 1033, 8, SPREAD, 1, 0), 3);
    compare(&pv_cpu_portable_backend, pose(400003, 9, 4, SPREAD, 1, 0), 2);
    compare(&pv_cpu_portable_backend, pose(3, 1000003, 64, SPREAD, 0, 0), 2);
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
        compare(&pv_cpu_reference_backend, p, 5);
    }
}

/* More sites than a slice, and so many on one spot that each pixel is drawn thousands of times. */
static void many_sites(void **state)
{
    (void)state;
    need_device();
    compare(&pv_cpu_portable_backend, pose(1024, 600, 1, SPREAD, 0, 0), 2);
    compare(&pv_cpu_portable_backend, pose(64, 48, 4, CLUSTERED, 0, 3000), 2);
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
        compare(&pv_cpu_portable_backend, p, 4);
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
    compare(&pv_cpu_portable_backend, pose(203, 157, 4, SPREAD, 1, 0), 2);
    assert_ptr_equal(host.egl_GetCurrentContext(), host.context);
    assert_int_equal(host.egl_QueryAPI(), EGL_OPENGL_ES_API);
    pv_gl_leave(&host, &before);
    assert_ptr_equal(host.egl_GetCurrentContext(), EGL_NO_CONTEXT);
    compare(&pv_cpu_portable_backend, pose(203, 157, 4, SPREAD, 1, 0), 2);
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
        pv_step step = { .deep = 0 };
        assert_int_equal(pv_gles_backend.open(tested.context, &p.plane, &engine, name), PAVE_OK);
        for (int32_t i = 0; i < 5; i++)
            assert_int_equal(pv_gles_backend.step(tested.context, engine, i, 0, 0, &step), PAVE_OK);
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
        pv_step step = { .deep = 0 };
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
    tested.family = "GLES";
    tested.engine[0] = &pv_gles_backend;
    tested.count = 1;
    const struct CMUnitTest tests[] = {
        EVERY_ENGINE,
        cmocka_unit_test(long_planes),
        cmocka_unit_test(planes_lie_anywhere),
        cmocka_unit_test(many_sites),
        cmocka_unit_test(extreme_boxes),
        cmocka_unit_test(the_device_does_the_work),
        cmocka_unit_test(leaves_the_host_alone),
        cmocka_unit_test(can_be_cancelled),
    };
    return cmocka_run_group_tests_name("gles", tests, open_tested, close_tested);
}
