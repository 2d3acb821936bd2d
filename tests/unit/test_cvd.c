/* cvd: the number of sites, order, seeds, degenerate planes, what relaxation does. */
#include "test.h"

#include <math.h>

static pave_cvd *diagram(pave_context *context, const pave_image *drawing, const pave_cvd_params *params)
{
    pave_field *field = NULL;
    pave_cvd *cvd = NULL;
    assert_ok(pave_field_create(context, drawing, NULL, &field));
    assert_ok(pave_cvd_create(context, field, params, &cvd));
    pave_field_free(&field);
    return cvd;
}

static void equation_1_gives_the_number_of_sites(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 512, 256);
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    params.iterations = 0;
    pave_cvd *cvd = diagram(context, drawing, &params);
    assert_int_equal(pave_cvd_site_count(cvd), 512 * 256 / 64);
    pave_cvd_free(&cvd);
    params.half_side = 3.7;
    cvd = diagram(context, drawing, &params);
    double expected = 512 * 256 / (7.4 * 7.4);
    assert_true(fabs(pave_cvd_site_count(cvd) - expected) < 4 * sqrt(expected));
    pave_cvd_free(&cvd);
    params.stones = 500;
    cvd = diagram(context, drawing, &params);
    assert_true(fabs(pave_cvd_half_side(cvd) - sqrt(512 * 256 / 500.0) / 2) < 1e-12);
    assert_in_range(pave_cvd_site_count(cvd), 430, 570);
    pave_cvd_free(&cvd);
    pave_image_free(&drawing);
}

static void sites_come_in_the_order_of_their_home_blocks(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 256, 256);
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    params.iterations = 0;
    pave_cvd *cvd = diagram(context, drawing, &params);
    const pave_site *sites = pave_cvd_sites(cvd);
    int64_t before = -1;
    for (int32_t i = 0; i < pave_cvd_site_count(cvd); i++) {
        int64_t cx = sites[i].x / 2048, cy = sites[i].y / 2048;
        int64_t key = ((cy / 8 * 4 + cx / 8) * 8 + cy % 8) * 8 + cx % 8;
        assert_true(key >= before);
        before = key;
        assert_in_range(sites[i].half_x, 256, 1024);
        assert_int_equal(sites[i].half_y, 512);
    }
    pave_cvd_free(&cvd);
    pave_image_free(&drawing);
}

/* A pavement is a function of the plane: the sites of a part are those of the whole. */
static void a_smaller_drawing_has_the_same_first_sites(void **state)
{
    pave_context *context = *state;
    static const char *const blank[] = { "." };
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_image *small = NULL, *large = NULL, *dot = draw_text(context, blank, 1);
    params.iterations = 0;
    shape.width = 64;
    shape.height = 64;
    assert_ok(pave_image_create(context, &shape, NULL, &small));
    shape.width = 200;
    assert_ok(pave_image_create(context, &shape, NULL, &large));
    pave_cvd *a = diagram(context, small, &params), *b = diagram(context, large, &params);
    assert_int_equal(pave_cvd_site_count(a), 64);
    assert_memory_equal(pave_cvd_sites(a), pave_cvd_sites(b), 64 * sizeof(pave_site));
    pave_cvd_free(&a);
    pave_cvd_free(&b);
    pave_image_free(&small);
    pave_image_free(&large);
    pave_image_free(&dot);
}

static void every_pixel_of_tiny_and_blank_planes_has_a_site(void **state)
{
    pave_context *context = *state;
    static const char *const drawings[][3] = { { "#" }, { "." }, { "#.#.#.#.#.#" }, { "#", ".", "#" }, { "...", "..." } };
    static const int32_t heights[] = { 1, 1, 1, 3, 2 };
    for (int d = 0; d < 5; d++) {
        pave_image *drawing = draw_text(context, drawings[d], heights[d]);
        for (double h = 1; h <= 4096; h *= 16) {
            pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
            params.half_side = h;
            pave_cvd *cvd = diagram(context, drawing, &params);
            assert_true(pave_cvd_site_count(cvd) >= 1);
            for (int32_t i = 0; i < pave_cvd_width(cvd) * pave_cvd_height(cvd); i++)
                assert_in_range(pave_cvd_labels(cvd)[i], 0, pave_cvd_site_count(cvd) - 1);
            pave_cvd_free(&cvd);
        }
        pave_image_free(&drawing);
    }
}

static void another_seed_is_another_diagram(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 128, 128);
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    pave_cvd *a = diagram(context, drawing, &params), *b = diagram(context, drawing, &params);
    params.seed = (uint64_t)1 << 40;
    pave_cvd *c = diagram(context, drawing, &params);
    size_t bytes = 128 * 128 * sizeof(int32_t);
    assert_memory_equal(pave_cvd_labels(a), pave_cvd_labels(b), bytes);
    assert_memory_not_equal(pave_cvd_labels(a), pave_cvd_labels(c), bytes);
    pave_cvd_free(&a);
    pave_cvd_free(&b);
    pave_cvd_free(&c);
    pave_image_free(&drawing);
}

static double area_variation(const pave_cvd *cvd)
{
    int32_t n = pave_cvd_site_count(cvd), pixels = pave_cvd_width(cvd) * pave_cvd_height(cvd);
    double *area = calloc((size_t)n, sizeof *area), mean = (double)pixels / n, sum = 0;
    for (int32_t i = 0; i < pixels; i++)
        area[pave_cvd_labels(cvd)[i]]++;
    for (int32_t i = 0; i < n; i++)
        sum += (area[i] - mean) * (area[i] - mean);
    free(area);
    return sqrt(sum / n) / mean;
}

static void relaxation_evens_the_cells_out(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 256, 256);
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    params.iterations = 0;
    pave_cvd *start = diagram(context, drawing, &params);
    params.iterations = 20;
    pave_cvd *end = diagram(context, drawing, &params);
    assert_true(area_variation(end) < 0.6 * area_variation(start));
    pave_cvd_free(&start);
    pave_cvd_free(&end);
    pave_image_free(&drawing);
}

static void over_relaxation_is_sooner_there(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 256, 256);
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    double variation[3];
    for (int i = 0; i < 3; i++) {
        static const double relaxation[] = { 0.4, 1, 1.6 };
        params.iterations = 6;
        params.relaxation = relaxation[i];
        pave_cvd *cvd = diagram(context, drawing, &params);
        variation[i] = area_variation(cvd);
        pave_cvd_free(&cvd);
    }
    assert_true(variation[2] < variation[1] && variation[1] < variation[0]);
    pave_image_free(&drawing);
}

/* The diagram of so many steps as were done; none stiller before. */
static void it_ends_when_sites_are_still(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 256, 256);
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    params.until_still = 0.25;
    pave_cvd *still = diagram(context, drawing, &params), *same;
    assert_in_range(pave_cvd_steps(still), 2, 19);
    assert_true(pave_cvd_movement(still) > 0 && pave_cvd_movement(still) <= 0.25);
    params.until_still = 0;
    params.iterations = pave_cvd_steps(still) - 1;
    same = diagram(context, drawing, &params);
    assert_true(pave_cvd_movement(same) > 0.25);
    pave_cvd_free(&same);
    params.iterations++;
    same = diagram(context, drawing, &params);
    assert_memory_equal(pave_cvd_labels(same), pave_cvd_labels(still), 256 * 256 * sizeof(int32_t));
    assert_true(pave_cvd_movement(same) == pave_cvd_movement(still));
    pave_cvd_free(&same);
    pave_cvd_free(&still);
    pave_image_free(&drawing);
}

static void a_window_cannot_tell_when_all_is_still(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 64, 64);
    pave_field *field = NULL;
    pave_cvd *cvd = NULL;
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    assert_ok(pave_field_create(context, drawing, NULL, &field));
    params.window[2] = params.window[3] = 32;
    assert_ok(pave_cvd_create(context, field, &params, &cvd));
    assert_true(pave_cvd_movement(cvd) == -1);
    pave_cvd_free(&cvd);
    params.until_still = 0.25;
    assert_int_equal(pave_cvd_create(context, field, &params, &cvd), PAVE_ERR_ARGUMENT);
    assert_non_null(strstr(pave_context_message(context), "until_still"));
    pave_field_free(&field);
    pave_image_free(&drawing);
}

/* Away from the ends of a straight edge the sites nearest to it stand at h and are turned along it. */
static void sites_line_up_along_an_edge(void **state)
{
    pave_context *context = *state;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_image *drawing = NULL;
    uint8_t *pixels = malloc(256 * 256);
    shape.width = shape.height = 256;
    for (int i = 0; i < 256 * 256; i++)
        pixels[i] = i < 256 * 128 ? 0 : 255;
    assert_ok(pave_image_create(context, &shape, pixels, &drawing));
    free(pixels);
    pave_cvd *cvd = diagram(context, drawing, NULL);
    int near = 0;
    for (int32_t i = 0; i < pave_cvd_site_count(cvd); i++) {
        const pave_site *s = &pave_cvd_sites(cvd)[i];
        double away = fabs(s->y / 256.0 - 128);
        if (away > 5.9)
            continue;
        near++;
        assert_true(fabs(away - 4) < 0.51);
        assert_int_equal(abs(s->cosine), 65536);
        assert_int_equal(s->sine, 0);
    }
    assert_in_range(near, 45, 90);
    pave_cvd_free(&cvd);
    pave_image_free(&drawing);
}

/* A window is a part of the whole: labels by number, and the sites that own them. */
static void compare_window(const pave_cvd *whole, const pave_cvd *part)
{
    int32_t width = pave_cvd_width(part), x0 = pave_cvd_x(part), y0 = pave_cvd_y(part);
    for (int32_t i = 0; i < width * pave_cvd_height(part); i++) {
        int32_t here = pave_cvd_labels(part)[i];
        int32_t there = pave_cvd_labels(whole)[(y0 + i / width) * pave_cvd_width(whole) + x0 + i % width];
        assert_int_equal(pave_cvd_site_numbers(part)[here], there);
        assert_memory_equal(&pave_cvd_sites(part)[here], &pave_cvd_sites(whole)[there], sizeof(pave_site));
    }
}

static void windows_are_parts_of_the_whole(void **state)
{
    pave_context *context = *state;
    static const int32_t windows[][4] = {
        { 0, 0, 100, 80 }, { 130, 170, 64, 64 }, { 299, 0, 1, 400 }, { 0, 399, 300, 1 }, { 17, 23, 1, 1 },
    };
    pave_image *drawing = draw_shapes(context, 300, 400);
    for (int32_t iterations = 0; iterations <= 4; iterations += 2) {
        pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
        params.half_side = 2.3;
        params.iterations = iterations;
        params.relaxation = iterations == 2 ? 1.8 : 1;
        pave_cvd *whole = diagram(context, drawing, &params);
        for (int i = 0; i < pave_cvd_site_count(whole); i++)
            assert_int_equal(pave_cvd_site_numbers(whole)[i], i);
        for (size_t w = 0; w < sizeof windows / sizeof *windows; w++) {
            memcpy(params.window, windows[w], sizeof params.window);
            params.window_margin = (double)w;
            pave_cvd *part = diagram(context, drawing, &params);
            assert_int_equal(pave_cvd_width(part), windows[w][2]);
            assert_true(iterations == 4 || pave_cvd_site_count(part) < pave_cvd_site_count(whole));
            compare_window(whole, part);
            pave_cvd_free(&part);
        }
        pave_cvd_free(&whole);
    }
    pave_image_free(&drawing);
}

static void windows_outside_the_plane_are_refused(void **state)
{
    pave_context *context = *state;
    static const int32_t windows[][4] = {
        { 0, 0, 101, 10 }, { 100, 0, 1, 1 }, { 0, -1, 5, 5 }, { 5, 5, 0, 5 }, { 5, 5, INT32_MAX, 5 },
    };
    pave_image *drawing = draw_shapes(context, 100, 100);
    pave_field *field = NULL;
    assert_ok(pave_field_create(context, drawing, NULL, &field));
    for (size_t w = 0; w < sizeof windows / sizeof *windows; w++) {
        pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
        pave_cvd *cvd = NULL;
        memcpy(params.window, windows[w], sizeof params.window);
        assert_int_equal(pave_cvd_create(context, field, &params, &cvd), PAVE_ERR_ARGUMENT);
        assert_non_null(strstr(pave_context_message(context), "window"));
    }
    pave_field_free(&field);
    pave_image_free(&drawing);
}

static void impossible_params_are_refused(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 64, 64);
    pave_field *field = NULL;
    pave_cvd *cvd = (pave_cvd *)1;
    assert_ok(pave_field_create(context, drawing, NULL, &field));
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    params.half_side = NAN;
    assert_int_equal(pave_cvd_create(context, field, &params, &cvd), PAVE_ERR_ARGUMENT);
    assert_null(cvd);
    pave_cvd_params_init(&params, sizeof params);
    params.scale_min = 3;
    assert_int_equal(pave_cvd_create(context, field, &params, &cvd), PAVE_ERR_ARGUMENT);
    pave_cvd_params_init(&params, sizeof params);
    params.stones = 5000;
    assert_int_equal(pave_cvd_create(context, field, &params, &cvd), PAVE_ERR_ARGUMENT);
    assert_non_null(strstr(pave_context_message(context), "too many"));
    assert_int_equal(pave_cvd_create(context, NULL, NULL, &cvd), PAVE_ERR_ARGUMENT);
    assert_int_equal(pave_cvd_create(NULL, field, NULL, &cvd), PAVE_ERR_ARGUMENT);
    pave_field_free(&field);
    pave_image_free(&drawing);
}

static void the_label_image_holds_the_labels(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 50, 40), *image = NULL;
    pave_cvd *cvd = diagram(context, drawing, NULL);
    assert_ok(pave_cvd_image(context, cvd, &image));
    assert_int_equal(pave_image_type(image), PAVE_U32);
    assert_memory_equal(pave_image_pixels(image), pave_cvd_labels(cvd), 50 * 40 * 4);
    pave_image_free(&image);
    pave_cvd_free(&cvd);
    pave_image_free(&drawing);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equation_1_gives_the_number_of_sites),
        cmocka_unit_test(sites_come_in_the_order_of_their_home_blocks),
        cmocka_unit_test(a_smaller_drawing_has_the_same_first_sites),
        cmocka_unit_test(every_pixel_of_tiny_and_blank_planes_has_a_site),
        cmocka_unit_test(another_seed_is_another_diagram),
        cmocka_unit_test(relaxation_evens_the_cells_out),
        cmocka_unit_test(over_relaxation_is_sooner_there),
        cmocka_unit_test(it_ends_when_sites_are_still),
        cmocka_unit_test(a_window_cannot_tell_when_all_is_still),
        cmocka_unit_test(sites_line_up_along_an_edge),
        cmocka_unit_test(windows_are_parts_of_the_whole),
        cmocka_unit_test(windows_outside_the_plane_are_refused),
        cmocka_unit_test(impossible_params_are_refused),
        cmocka_unit_test(the_label_image_holds_the_labels),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
