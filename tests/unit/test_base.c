/* base: contexts, params, memory, progress, threads. */
#include "failing.h"

#include "base/params.h"
#include "base/parallel.h"

#include <math.h>
#include <pthread.h>
#include <unistd.h>

static void results_have_names(void **state)
{
    (void)state;
    assert_string_equal(pave_result_name(PAVE_OK), "PAVE_OK");
    assert_string_equal(pave_result_name(PAVE_ERR_CANCELLED), "PAVE_ERR_CANCELLED");
    assert_string_equal(pave_result_name(PAVE_ERR_INTERNAL), "PAVE_ERR_INTERNAL");
    assert_string_equal(pave_result_name(1), "unknown result");
    assert_string_equal(pave_result_name(-99), "unknown result");
    assert_string_equal(pave_version(), PAVE_VERSION_STRING);
}

static void every_row_of_every_table_makes_sense(void **state)
{
    (void)state;
    for (int32_t table = PAVE_PARAMS_CONTEXT; table <= PAVE_PARAMS_STREAM; table++) {
        assert_true(pave_params_count(table) > 0);
        for (int32_t i = 0; i < pave_params_count(table); i++) {
            pave_param p;
            assert_ok(pave_params_describe(table, i, &p));
            assert_true(p.initial >= p.least && p.initial <= p.greatest);
            assert_true(*p.name && *p.help && p.unit);
            assert_true((p.type == PAVE_PARAM_CHOICE) == (p.choices != NULL));
        }
        pave_param p;
        assert_int_equal(pave_params_describe(table, -1, &p), PAVE_ERR_ARGUMENT);
        assert_int_equal(pave_params_describe(table, pave_params_count(table), &p), PAVE_ERR_ARGUMENT);
    }
    assert_int_equal(pave_params_count(0), 0);
    assert_int_equal(pave_params_count(99), 0);
}

static void params_are_set_from_text(void **state)
{
    (void)state;
    pave_context *context = make_context(1, PAVE_BACKEND_CPU);
    pave_cvd_params p = PAVE_CVD_PARAMS_INIT;
    assert_ok(pave_params_set(context, PAVE_PARAMS_CVD, &p, "half_side", "2.5"));
    assert_ok(pave_params_set(context, PAVE_PARAMS_CVD, &p, "noise-angle", "90"));
    assert_ok(pave_params_set(context, PAVE_PARAMS_CVD, &p, "seed", "18446744073709551615"));
    assert_ok(pave_params_set(context, PAVE_PARAMS_CVD, &p, "iterations", "7"));
    assert_true(p.half_side == 2.5 && p.noise_angle == 90 && p.seed == UINT64_MAX && p.iterations == 7);
    static const char *const wrong[][2] = {
        { "half_side", "0.5" }, { "half_side", "nan" }, { "half_side", "4px" }, { "half_side", "" },
        { "iterations", "1.5" }, { "iterations", "-1" }, { "iterations", "99999999999" }, { "seed", "-1" },
        { "colour", "1" },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(pave_params_set(context, PAVE_PARAMS_CVD, &p, wrong[i][0], wrong[i][1]), PAVE_ERR_ARGUMENT);
        assert_non_null(strstr(pave_context_message(context), wrong[i][0]));
    }
    assert_true(p.half_side == 2.5 && p.iterations == 7);
    pave_field_params f = PAVE_FIELD_PARAMS_INIT;
    assert_ok(pave_params_set(context, PAVE_PARAMS_FIELD, &f, "metric", "euclid"));
    assert_int_equal(f.metric, PAVE_METRIC_EUCLID);
    assert_int_equal(pave_params_set(context, PAVE_PARAMS_FIELD, &f, "metric", "eucli"), PAVE_ERR_ARGUMENT);
    assert_non_null(strstr(pave_context_message(context), "chamfer|euclid"));
    pave_context_free(&context);
}

static void structs_of_other_versions_are_read(void **state)
{
    (void)state;
    pave_context *context = make_context(1, PAVE_BACKEND_CPU);
    pave_cvd_params out;
    struct {
        pave_cvd_params known;
        int64_t later;
    } newer = { PAVE_CVD_PARAMS_INIT, 0 };
    newer.known.size = sizeof newer;
    newer.known.half_side = 9;
    assert_ok(pv_params_read(context, &pv_limits_table, NULL, &(pave_limits){ 0 }));
    extern const pv_table pv_cvd_table;
    assert_ok(pv_params_read(context, &pv_cvd_table, &newer, &out));
    assert_true(out.half_side == 9);
    newer.later = 1;
    assert_int_equal(pv_params_read(context, &pv_cvd_table, &newer, &out), PAVE_ERR_TOO_NEW);

    pave_cvd_params older = PAVE_CVD_PARAMS_INIT;
    older.size = offsetof(pave_cvd_params, stones);
    older.half_side = 7;
    older.iterations = -5; /* beyond what an older caller knew: not looked at */
    assert_ok(pv_params_read(context, &pv_cvd_table, &older, &out));
    assert_true(out.half_side == 7 && out.iterations == 20);

    pave_cvd_params never = { 0 };
    assert_int_equal(pv_params_read(context, &pv_cvd_table, &never, &out), PAVE_ERR_ARGUMENT);
    pave_cvd_params bad = PAVE_CVD_PARAMS_INIT;
    bad.cap = NAN;
    assert_int_equal(pv_params_read(context, &pv_cvd_table, &bad, &out), PAVE_ERR_ARGUMENT);
    assert_non_null(strstr(pave_context_message(context), "cap is nan"));
    pave_context_free(&context);
}

static void structs_are_compared_by_their_fields(void **state)
{
    (void)state;
    extern const pv_table pv_stones_table;
    pave_stones_params a, b;
    memset(&a, 0xaa, sizeof a); /* padding differs */
    memset(&b, 0x55, sizeof b);
    a.mode = b.mode = 0;
    a.grout = b.grout = 1;
    a.wide_angle = b.wide_angle = 120;
    a.passes = b.passes = 5;
    a.drop_angle = b.drop_angle = 120;
    a.small_edge = b.small_edge = 0.5;
    a.joint_style = b.joint_style = 0;
    a.thin = b.thin = 0;
    a.border = b.border = 0;
    a.thin_width = b.thin_width = 1;
    a.aspect = b.aspect = 4;
    assert_true(pv_params_same(&pv_stones_table, &a, &b, sizeof a));
    b.small_edge = 0.25;
    assert_false(pv_params_same(&pv_stones_table, &a, &b, sizeof a));
    assert_true(pv_params_same(&pv_stones_table, &a, &b, offsetof(pave_stones_params, small_edge)));
}

static void initialisers_and_init_functions_agree(void **state)
{
    (void)state;
    extern const pv_table pv_cvd_table;
    pave_cvd_params a = PAVE_CVD_PARAMS_INIT, b;
    pave_cvd_params_init(&b, sizeof b);
    assert_true(pv_params_same(&pv_cvd_table, &a, &b, sizeof a));
    pave_stones_params c = PAVE_STONES_PARAMS_INIT, d;
    pave_stones_params_init(&d, sizeof d);
    assert_true(c.grout == d.grout && c.passes == d.passes && c.size == d.size);
}

static void handles_outlive_their_context_and_free_everything(void **state)
{
    (void)state;
    failing counted = { 0 };
    pave_context_params params = failing_params(&counted);
    pave_context *context;
    assert_ok(pave_context_create(&params, &context));
    pave_image *image = draw_shapes(context, 40, 30);
    pave_context_free(&context);
    assert_null(context);
    assert_int_equal(pave_image_width(image), 40);
    assert_true(counted.blocks > 0);
    pave_image_free(&image);
    pave_image_free(&image);
    assert_int_equal(counted.blocks, 0);
}

static void memory_is_held_against_the_limit(void **state)
{
    (void)state;
    pave_limits limits = PAVE_LIMITS_INIT;
    limits.max_bytes = 1 << 20;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    params.limits = &limits;
    pave_context *context;
    assert_ok(pave_context_create(&params, &context));
    pave_result result = PAVE_OK;
    void *half = pv_allocate(context, 600, 1024, &result);
    assert_non_null(half);
    assert_int_equal((uintptr_t)half % 64, 0);
    assert_null(pv_allocate(context, 600, 1024, &result));
    assert_int_equal(result, PAVE_ERR_LIMIT);
    pv_release(half);
    half = pv_allocate(context, 600, 1024, &result);
    assert_non_null(half);
    pv_release(half);
    assert_null(pv_allocate(context, SIZE_MAX / 2, 16, &result));
    pave_context_free(&context);
}

static void impossible_contexts_are_refused(void **state)
{
    (void)state;
    pave_context *context = (pave_context *)1;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    params.threads = -1;
    assert_int_equal(pave_context_create(&params, &context), PAVE_ERR_ARGUMENT);
    assert_null(context);
    pave_context_params_init(&params, sizeof params);
    params.alloc = failing_alloc;
    assert_int_equal(pave_context_create(&params, &context), PAVE_ERR_ARGUMENT);
    assert_int_equal(pave_context_create(NULL, NULL), PAVE_ERR_ARGUMENT);
    pave_context_free(NULL);
    pave_context_cancel(NULL);
}

typedef struct tally {
    atomic_int done[1000];
} tally;

static void count_task(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    atomic_fetch_add(&((tally *)data)->done[index], 1);
}

static void every_task_runs_once(void **state)
{
    (void)state;
    static const int32_t threads[] = { 1, 2, 7 };
    for (int t = 0; t < 3; t++) {
        pave_context *context = make_context(threads[t], PAVE_BACKEND_CPU);
        for (int32_t tasks = 0; tasks <= 1000; tasks += 250) {
            static tally sum;
            memset(&sum, 0, sizeof sum);
            assert_ok(pv_parallel(context, tasks, count_task, &sum, 0, 1));
            for (int32_t i = 0; i < 1000; i++)
                assert_int_equal(atomic_load(&sum.done[i]), i < tasks);
        }
        pave_context_free(&context);
    }
}

typedef struct watch {
    double last;
    int calls, stop_at;
    pthread_t thread;
} watch;

static int32_t watch_progress(void *user, const char *stage, double done)
{
    watch *w = user;
    assert_true(*stage);
    assert_true(done >= w->last && done <= 1);
    assert_true(pthread_equal(pthread_self(), w->thread));
    w->last = done;
    return ++w->calls == w->stop_at;
}

static pave_result lay_watched(watch *w, int32_t threads)
{
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    pave_context *context;
    pave_stones *stones = NULL;
    w->thread = pthread_self();
    params.threads = threads;
    params.backend = PAVE_BACKEND_CPU;
    params.progress = watch_progress;
    params.progress_user = w;
    assert_ok(pave_context_create(&params, &context));
    pave_image *drawing = draw_shapes(context, 300, 200);
    pave_result result = pave_lay(context, drawing, NULL, &stones);
    assert_true((result == PAVE_OK) == (stones != NULL));
    pave_stones_free(&stones);
    pave_image_free(&drawing);
    pave_context_free(&context);
    return result;
}

static void progress_is_monotone_and_can_cancel(void **state)
{
    (void)state;
    for (int32_t threads = 1; threads <= 3; threads += 2) {
        watch whole = { .stop_at = -1 };
        assert_ok(lay_watched(&whole, threads));
        assert_true(whole.last == 1);
        assert_in_range(whole.calls, 20, 500);
        for (int stop = 1; stop < whole.calls; stop += 7) {
            watch cut = { .stop_at = stop };
            pave_result result = lay_watched(&cut, threads);
            assert_true(result == PAVE_ERR_CANCELLED || cut.calls < stop);
        }
    }
}

static void *cancel_soon(void *context)
{
    usleep(30000);
    pave_context_cancel(context);
    return NULL;
}

static void cancel_from_another_thread_ends_the_call(void **state)
{
    (void)state;
    pave_context *context = make_context(2, PAVE_BACKEND_CPU);
    pave_image *drawing = draw_shapes(context, 500, 500);
    pave_field *field = NULL;
    assert_ok(pave_field_create(context, drawing, NULL, &field));
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    params.iterations = 10000;
    pave_cvd *cvd = NULL;
    pthread_t thread;
    pthread_create(&thread, NULL, cancel_soon, context);
    assert_int_equal(pave_cvd_create(context, field, &params, &cvd), PAVE_ERR_CANCELLED);
    pthread_join(thread, NULL);
    assert_null(cvd);
    assert_string_equal(pave_context_message(context), "cancelled");
    params.iterations = 1; /* the request is used up */
    assert_ok(pave_cvd_create(context, field, &params, &cvd));
    pave_cvd_free(&cvd);
    pave_field_free(&field);
    pave_image_free(&drawing);
    pave_context_free(&context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(results_have_names),
        cmocka_unit_test(every_row_of_every_table_makes_sense),
        cmocka_unit_test(params_are_set_from_text),
        cmocka_unit_test(structs_of_other_versions_are_read),
        cmocka_unit_test(structs_are_compared_by_their_fields),
        cmocka_unit_test(initialisers_and_init_functions_agree),
        cmocka_unit_test(handles_outlive_their_context_and_free_everything),
        cmocka_unit_test(memory_is_held_against_the_limit),
        cmocka_unit_test(impossible_contexts_are_refused),
        cmocka_unit_test(every_task_runs_once),
        cmocka_unit_test(progress_is_monotone_and_can_cancel),
        cmocka_unit_test(cancel_from_another_thread_ends_the_call),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
