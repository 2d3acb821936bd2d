/* field: Fig. 3 of the paper, both metrics against their definitions, the gradient's signs. */
#include "test.h"

#include "field/field.h"
#include "util/random.h"

#include <math.h>

static pave_field *field_of(pave_context *context, pave_image *drawing, int32_t metric)
{
    pave_field_params params = PAVE_FIELD_PARAMS_INIT;
    pave_field *field = NULL;
    params.metric = metric;
    assert_ok(pave_field_create(context, drawing, &params, &field));
    return field;
}

/* The drawing whose edges start as in Fig. 3 (a); the printed figure leaves the fifth row and column empty. */
static void figure_3_comes_out(void **state)
{
    pave_context *context = *state;
    static const char *const drawing[] = { "####", "##..", "#...", "...." };
    static const double first[4][4] = {
        { 0, 0.707, 0.500, 0.500 }, { 0.707, 0.500, 0.500, 0.500 }, { 0.500, 0.500, 0.707, 0 }, { 0.500, 0.707, 0, 0 },
    };
    static const double final[4][4] = {
        { 1.207, 0.707, 0.500, 0.500 },
        { 0.707, 0.500, 0.500, 0.500 },
        { 0.500, 0.500, 0.707, 1.000 },
        { 0.500, 0.707, 1.207, 1.414 },
    };
    pave_image *image = draw_text(context, drawing, 4);
    pv_drawing pixels = { 4, 4, pave_image_pixels(image) };
    uint32_t edges[16];
    assert_ok(pv_edges(context, &pixels, edges));
    pave_field *field = field_of(context, image, PAVE_METRIC_FIGURE3);
    for (int i = 0; i < 16; i++) {
        double expected = first[i / 4][i % 4];
        assert_true(expected == 0 ? edges[i] == PV_FIELD_FAR : fabs(edges[i] / 65536.0 - expected) < 0.0005);
        assert_true(fabs(pave_field_distance(field)[i] - final[i / 4][i % 4]) < 0.0005);
    }
    pave_field_free(&field);
    pave_image_free(&image);
}

static pave_image *draw_random(pave_context *context, int32_t width, int32_t height, uint32_t key)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    params.width = width;
    params.height = height;
    uint8_t *pixels = malloc((size_t)width * (size_t)height);
    for (int32_t i = 0; i < width * height; i++) {
        uint32_t x = (uint32_t)(i % width), y = (uint32_t)(i / width);
        pixels[i] = pv_draw(key, 99, x / (1 + key % 9), y / (1 + key % 7), 0).word[0] % 11 < key % 5 + 1 ? 0 : 255;
    }
    assert_ok(pave_image_create(context, &params, pixels, &image));
    free(pixels);
    return image;
}

static double square_gap(int32_t d)
{
    double gap = abs(d) - 0.5;
    return gap > 0 ? gap * gap : 0;
}

/* By the definition: the nearest point of any pixel of another colour. */
static double exact_distance(const pave_image *image, int32_t x, int32_t y)
{
    int32_t width = pave_image_width(image), height = pave_image_height(image);
    const uint8_t *pixels = pave_image_pixels(image);
    double least = INFINITY;
    for (int32_t v = 0; v < height; v++)
        for (int32_t u = 0; u < width; u++)
            if (pixels[v * width + u] != pixels[y * width + x])
                least = fmin(least, square_gap(u - x) + square_gap(v - y));
    return sqrt(least);
}

static void euclid_is_the_distance_to_the_frontier(void **state)
{
    pave_context *context = *state;
    for (uint32_t key = 0; key < 40; key++) {
        pave_image *image = draw_random(context, 1 + (int32_t)(key * 7 % 31), 1 + (int32_t)(key * 5 % 23), key);
        pave_field *field = field_of(context, image, PAVE_METRIC_EUCLID);
        int32_t width = pave_field_width(field), height = pave_field_height(field);
        for (int32_t i = 0; i < width * height; i++) {
            double expected = exact_distance(image, i % width, i / width), got = pave_field_distance(field)[i];
            assert_true(isinf(expected) ? isinf(got) : fabs(expected - got) < 1.0 / 65536);
        }
        pave_field_free(&field);
        pave_image_free(&image);
    }
}

/* Relaxes every pixel by its eight neighbours until nothing changes. */
static void chamfer_by_definition(const pave_image *image, double *d)
{
    int32_t width = pave_image_width(image), height = pave_image_height(image);
    const uint8_t *pixels = pave_image_pixels(image);
    for (int pass = 0, changed = 1; changed; pass++) {
        changed = 0;
        for (int32_t i = 0; i < width * height; i++) {
            double least = pass ? d[i] : INFINITY;
            for (int32_t k = 0; k < 9; k++) {
                int32_t x = i % width + k % 3 - 1, y = i / width + k / 3 - 1;
                if (k == 4 || x < 0 || y < 0 || x >= width || y >= height)
                    continue;
                double step = k % 2 ? 1 : sqrt(2);
                if (pixels[y * width + x] != pixels[i])
                    least = fmin(least, step / 2);
                else if (pass)
                    least = fmin(least, d[y * width + x] + step);
            }
            changed |= !pass || least < d[i] - 1e-9;
            d[i] = least;
        }
    }
}

static void chamfer_is_the_shortest_path(void **state)
{
    pave_context *context = *state;
    for (uint32_t key = 0; key < 40; key++) {
        pave_image *image = draw_random(context, 1 + (int32_t)(key * 11 % 37), 1 + (int32_t)(key * 3 % 29), key);
        pave_field *field = field_of(context, image, PAVE_METRIC_CHAMFER);
        int32_t count = pave_field_width(field) * pave_field_height(field);
        double *expected = malloc((size_t)count * sizeof *expected);
        chamfer_by_definition(image, expected);
        for (int32_t i = 0; i < count; i++) {
            double got = pave_field_distance(field)[i];
            assert_true(isinf(expected[i]) ? isinf(got) : fabs(expected[i] - got) < 0.001);
        }
        free(expected);
        pave_field_free(&field);
        pave_image_free(&image);
    }
}

static void gradient_points_away_from_the_edge_with_y_down(void **state)
{
    pave_context *context = *state;
    char *rows[30];
    for (int y = 0; y < 30; y++)
        rows[y] = y < 15 ? "##############################" : "..............................";
    pave_image *image = draw_text(context, (const char *const *)rows, 30);
    pave_field *field = field_of(context, image, PAVE_METRIC_CHAMFER);
    float gx[900], gy[900];
    pave_field_gradient(field, gx, gy);
    for (int x = 0; x < 30; x++) {
        assert_true(gx[20 * 30 + x] == 0 && gy[20 * 30 + x] == 1);
        assert_true(gx[8 * 30 + x] == 0 && gy[8 * 30 + x] == -1);
    }
    pave_image *as_image = NULL;
    assert_ok(pave_field_image(context, field, &as_image));
    assert_string_equal(pave_image_channel_name(as_image, 2), "gradient.y");
    const float *pixel = (const float *)pave_image_pixels(as_image) + 3 * (20 * 30 + 5);
    assert_true(pixel[0] == 5.5f && pixel[1] == 0 && pixel[2] == 1);
    pave_image_free(&as_image);
    pave_field_free(&field);
    pave_image_free(&image);
}

static void drawings_without_an_edge_are_infinitely_far_from_one(void **state)
{
    pave_context *context = *state;
    static const char *const blank[] = { "....", "...." }, *const pixel[] = { "#" };
    for (int32_t metric = 0; metric < 3; metric++) {
        pave_image *a = draw_text(context, blank, 2), *b = draw_text(context, pixel, 1);
        pave_field *fa = field_of(context, a, metric), *fb = field_of(context, b, metric);
        float x[8], y[8];
        for (int i = 0; i < 8; i++)
            assert_true(isinf(pave_field_distance(fa)[i]));
        assert_true(isinf(pave_field_distance(fb)[0]));
        pave_field_gradient(fa, x, y);
        for (int i = 0; i < 8; i++)
            assert_true(x[i] == 0 && y[i] == 0);
        pave_field_free(&fa);
        pave_field_free(&fb);
        pave_image_free(&a);
        pave_image_free(&b);
    }
}

static void threads_do_not_matter(void **state)
{
    pave_context *context = *state, *one = make_context(1, PAVE_BACKEND_CPU);
    pave_image *image = draw_shapes(context, 333, 517);
    for (int32_t metric = 0; metric < 3; metric++) {
        pave_field *a = field_of(context, image, metric), *b = field_of(one, image, metric);
        assert_memory_equal(pave_field_distance(a), pave_field_distance(b), 333 * 517 * sizeof(float));
        pave_field_free(&a);
        pave_field_free(&b);
    }
    pave_image_free(&image);
    pave_context_free(&one);
}

static void only_drawings_are_taken(void **state)
{
    pave_context *context = *state;
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    pave_field *field = (pave_field *)1;
    params.width = params.height = 3;
    params.type = PAVE_F32;
    assert_ok(pave_image_create(context, &params, NULL, &image));
    assert_int_equal(pave_field_create(context, image, NULL, &field), PAVE_ERR_ARGUMENT);
    assert_null(field);
    assert_int_equal(pave_field_create(context, NULL, NULL, &field), PAVE_ERR_ARGUMENT);
    pave_image_free(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figure_3_comes_out),
        cmocka_unit_test(euclid_is_the_distance_to_the_frontier),
        cmocka_unit_test(chamfer_is_the_shortest_path),
        cmocka_unit_test(gradient_points_away_from_the_edge_with_y_down),
        cmocka_unit_test(drawings_without_an_edge_are_infinitely_far_from_one),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(only_drawings_are_taken),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
