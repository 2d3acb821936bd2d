/* Allocation failures: every allocation of the whole job fails once; the call must fail cleanly, leak nothing, leave
 * the context usable, and give the same stones the next time. */
#include "failing.h"

static uint64_t lay_once(pave_context *context, int32_t round, pave_result *result)
{
    pave_field_params field = PAVE_FIELD_PARAMS_INIT;
    pave_lay_params params = PAVE_LAY_PARAMS_INIT;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    pave_stones *stones = NULL;
    uint64_t hash = 0;
    uint8_t pixels[40 * 30];
    for (int i = 0; i < 40 * 30; i++)
        pixels[i] = i % 40 < 17 ? 0 : 255;
    shape.width = 40;
    shape.height = 30;
    field.metric = round == 1;
    field.periodic = round == 3;
    params.field = &field;
    pave_cvd_params cvd = PAVE_CVD_PARAMS_INIT;
    cvd.half_side = round == 3 ? 2 : 4;
    cvd.iterations = round < 2 ? 20 : 1;
    params.cvd = &cvd;
    pave_stones_params how = PAVE_STONES_PARAMS_INIT; /* in paper mode, in colours, in best mode, and where it repeats */
    how.mode = round < 2 ? PAVE_MODE_PAPER : PAVE_MODE_BEST;
    how.thin = round == 3 ? PAVE_THIN_WIDEN : PAVE_THIN_KEEP;
    how.border = PAVE_BORDER_CUT;
    params.stones = &how;
    pave_palette_params palette = PAVE_PALETTE_PARAMS_INIT;
    palette.colours = round == 1 ? 2 : 0;
    params.palette = &palette;
    *result = pave_image_create(context, &shape, pixels, &image);
    if (!*result)
        *result = pave_lay(context, image, &params, &stones);
    if (!*result) {
        pave_stones_measures measures = { .size = sizeof measures };
        *result = pave_stones_measure(context, image, stones, NULL, &measures);
        assert_true(*result || measures.stones > 0);
        hash = hash_bytes(pave_stones_vertices(stones),
                          (size_t)pave_stones_starts(stones)[pave_stones_count(stones)] * 16);
    } else {
        assert_null(stones);
    }
    pave_stones_free(&stones);
    pave_image_free(&image);
    return hash;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    for (int32_t round = 0; round < 4; round++) {
        failing f = { 0 };
        pave_context_params params = failing_params(&f);
        pave_context *context;
        pave_result result;
        params.backend = PAVE_BACKEND_CPU;
        assert_ok(pave_context_create(&params, &context));
        int64_t idle = f.blocks, before = f.calls;
        uint64_t expected = lay_once(context, round, &result);
        assert_ok(result);
        int64_t points = f.calls - before;
        assert_true(points > 20);
        for (int64_t k = 1; k <= points; k++) {
            f.fail_at = f.calls + k;
            lay_once(context, round, &result);
            assert_int_equal(result, PAVE_ERR_MEMORY);
            assert_non_null(strstr(pave_context_message(context), "out of memory"));
            assert_int_equal(f.blocks, idle);
        }
        f.fail_at = 0;
        assert_true(lay_once(context, round, &result) == expected);
        pave_context_free(&context);
        assert_int_equal(f.blocks, 0);
    }
}

static void contexts_may_fail_too(void **state)
{
    (void)state;
    for (int64_t k = 1; k <= 2; k++) {
        failing f = { .fail_at = k };
        pave_context_params params = failing_params(&f);
        pave_context *context = (pave_context *)1;
        params.threads = 0;
        assert_int_equal(pave_context_create(&params, &context), PAVE_ERR_MEMORY);
        assert_null(context);
        assert_int_equal(f.blocks, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(contexts_may_fail_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
