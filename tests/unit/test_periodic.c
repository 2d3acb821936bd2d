/* Planes that repeat: the diagram is the same wherever one looks at it, by a whole period or by windows, on any
 * backend, and no pixel feels the border. */
#include "devices.h"

static pave_field *periodic_field(pave_context *context, const pave_image *drawing)
{
    pave_field_params params = PAVE_FIELD_PARAMS_INIT;
    pave_field *field = NULL;
    params.periodic = 1;
    assert_ok(pave_field_create(context, drawing, &params, &field));
    return field;
}

static pave_cvd *diagram(pave_context *context, const pave_field *field, const pave_cvd_params *params)
{
    pave_cvd *cvd = NULL;
    assert_ok(pave_cvd_create(context, field, params, &cvd));
    return cvd;
}

/* The site of a pixel as seen from there. */
static pave_site seen(const pave_cvd *cvd, int32_t i, int32_t *number)
{
    int32_t x = pave_cvd_x(cvd) + i % pave_cvd_width(cvd), y = pave_cvd_y(cvd) + i / pave_cvd_width(cvd);
    int32_t label = pave_cvd_labels(cvd)[i];
    pave_site site = pave_cvd_sites(cvd)[label];
    *number = pave_cvd_site_numbers(cvd)[label];
    site.x -= 256 * x;
    site.y -= 256 * y;
    return site;
}

static void compare_window(const pave_cvd *whole, const pave_cvd *part)
{
    int32_t width = pave_cvd_width(whole), height = pave_cvd_height(whole);
    for (int32_t i = 0; i < pave_cvd_width(part) * pave_cvd_height(part); i++) {
        int32_t x = (pave_cvd_x(part) + i % pave_cvd_width(part)) % width, here, there;
        int32_t y = (pave_cvd_y(part) + i / pave_cvd_width(part)) % height;
        pave_site a = seen(part, i, &here), b = seen(whole, y * width + x, &there);
        assert_int_equal(here, there);
        assert_memory_equal(&a, &b, sizeof a);
    }
}

static void windows_show_the_same_everywhere(void **state)
{
    pave_context *context = *state;
    static const int32_t windows[][4] = {
        { 0, 0, 90, 80 }, { 280, 170, 64, 64 }, { 299, 380, 1, 40 }, { 280, 390, 300, 400 }, { 17, 23, 1, 1 },
        { 150, 200, 300, 400 },
    };
    pave_image *drawing = draw_shapes(context, 300, 400);
    pave_field *field = periodic_field(context, drawing);
    for (int32_t iterations = THREAD_SANITIZED ? 4 : 0; iterations <= 4; iterations += 2) {
        pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
        params.half_side = 2.3;
        params.iterations = iterations;
        pave_cvd *whole = diagram(context, field, &params);
        for (size_t w = 0; w < (THREAD_SANITIZED ? 2 : sizeof windows / sizeof *windows); w++) {
            memcpy(params.window, windows[w], sizeof params.window);
            params.window_margin = 2.0 * (double)w;
            pave_cvd *part = diagram(context, field, &params);
            compare_window(whole, part);
            pave_cvd_free(&part);
        }
        pave_cvd_free(&whole);
    }
    pave_field_free(&field);
    pave_image_free(&drawing);
}

/* Down to a single stone that meets itself. */
static void small_planes_tile_with_themselves(void **state)
{
    pave_context *context = *state;
    static const int32_t sides[] = { 3, 5, 8, 9, 13, 31, 64 };
    for (int i = 0; i < 49; i += THREAD_SANITIZED ? 8 : 1) {
        pave_image *drawing = draw_shapes(context, sides[i % 7], sides[i / 7]);
        pave_field *field = periodic_field(context, drawing);
        pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
        params.iterations = 6;
        params.window_margin = 8;
        params.half_side = i % 2 && sides[i % 7] >= 8 && sides[i / 7] >= 8 ? 4 : 1.5;
        pave_cvd *whole = diagram(context, field, &params);
        params.window[0] = sides[i % 7] / 2;
        params.window[1] = sides[i / 7] / 3;
        params.window[2] = sides[i % 7];
        params.window[3] = sides[i / 7];
        pave_cvd *part = diagram(context, field, &params);
        compare_window(whole, part);
        pave_cvd_free(&part);
        pave_cvd_free(&whole);
        pave_field_free(&field);
        pave_image_free(&drawing);
    }
}

static void stones_must_fit(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 40, 30);
    pave_field *field = periodic_field(context, drawing);
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    pave_cvd *cvd = NULL;
    params.iterations = 1;
    params.supersample = 2;
    params.half_side = 17.3;
    assert_ok(pave_cvd_create(context, field, &params, &cvd));
    pave_cvd_free(&cvd);
    params.half_side = 17.4;
    assert_int_equal(pave_cvd_create(context, field, &params, &cvd), PAVE_ERR_ARGUMENT);
    assert_string_equal(pave_context_message(context),
                        "a stone of 34.8 x 34.8 px is more than a drawing that repeats every 40 x 30 px");
    pave_field_free(&field);
    pave_image_free(&drawing);
}

/* Buckets far from the corner and wider than what their number times that leaves of 32 bits. */
static void large_stones_find_their_sites(void **state)
{
    not_for_threads();
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 256, 192);
    pave_field *field = periodic_field(context, drawing);
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    params.half_side = 40;
    params.iterations = 1;
    pave_cvd *cvd = diagram(context, field, &params);
    pave_context *slow = make_context(2, PAVE_BACKEND_CPU_PORTABLE);
    pave_cvd *expected = diagram(slow, field, &params);
    assert_memory_equal(pave_cvd_labels(cvd), pave_cvd_labels(expected), 256 * 192 * sizeof(int32_t));
    pave_cvd_free(&expected);
    pave_cvd_free(&cvd);
    pave_context_free(&slow);
    pave_field_free(&field);
    pave_image_free(&drawing);
}

static void all_backends_agree(void **state)
{
    pave_context *context = *state;
    int32_t backends[MOST_BACKENDS], count = usable_backends(context, backends);
    pave_image *drawing = draw_shapes(context, THREAD_SANITIZED ? 40 : 97, THREAD_SANITIZED ? 53 : 130);
    pave_field *field = periodic_field(context, drawing);
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    params.half_side = 3;
    params.cap = 1; /* boxes overlap, and some sites must be drawn again */
    params.window_margin = 4;
    params.iterations = THREAD_SANITIZED ? 1 : 8;
    pave_cvd *expected = diagram(context, field, &params);
    assert_agrees(field, &params, 2, PAVE_BACKEND_CPU_REFERENCE, expected);
    for (int32_t i = 0; i < count; i++)
        assert_agrees(field, &params, i % 2 ? 7 : 2, backends[i], expected);
    pave_cvd_free(&expected);
    pave_field_free(&field);
    pave_image_free(&drawing);
}

static void the_number_of_sites_is_that_of_the_cells_that_fit(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 100, 60);
    pave_field *field = periodic_field(context, drawing);
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    params.iterations = 0;
    params.window_margin = 0;
    pave_cvd *cvd = diagram(context, field, &params);
    int32_t most = 0;
    for (int32_t i = 0; i < pave_cvd_site_count(cvd); i++)
        most = pave_cvd_site_numbers(cvd)[i] > most ? pave_cvd_site_numbers(cvd)[i] : most;
    assert_int_equal(most + 1, 13 * 8); /* cells of 7.7 x 7.5 px */
    pave_cvd_free(&cvd);
    pave_field_free(&field);
    pave_image_free(&drawing);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_number_of_sites_is_that_of_the_cells_that_fit),
        cmocka_unit_test(windows_show_the_same_everywhere),
        cmocka_unit_test(small_planes_tile_with_themselves),
        cmocka_unit_test(stones_must_fit),
        cmocka_unit_test(large_stones_find_their_sites),
        cmocka_unit_test(all_backends_agree),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
