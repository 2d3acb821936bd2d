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
    pv_drawing pixels = { 4, 4, pave_image_pixels(image), 0 };
    int32_t edges[16];
    for (int y = 0; y < 4; y++)
        pv_edge_row(&pixels, y, edges + 4 * y);
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

static int32_t lesser(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* The textbook's two raster scans. */
static void chamfer_by_raster_scans(int32_t *d, int32_t width, int32_t height)
{
    for (int pass = 0; pass < 2; pass++)
        for (int32_t i = 0; i < width * height; i++) {
            int32_t p = pass ? width * height - 1 - i : i, back = pass ? 1 : -1;
            int32_t x = p % width, y = p / width;
            for (int32_t k = 0; k < 4; k++) {
                int32_t u = x + (k == 3 ? back : k - 1), v = y + (k == 3 ? 0 : back);
                if (u < 0 || u >= width || v < 0 || v >= height)
                    continue;
                int32_t way = k % 2 ? PV_FIELD_ONE : 92682;
                if (d[v * width + u] <= PV_FIELD_FAR - way)
                    d[p] = lesser(d[p], d[v * width + u] + way);
            }
        }
}

/* One white pixel in a corner: distances saturate. */
static pave_image *draw_dot(pave_context *context, int32_t width, int32_t height)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    params.width = width;
    params.height = height;
    uint8_t *pixels = calloc((size_t)width, (size_t)height);
    pixels[width * height - 1] = 255;
    assert_ok(pave_image_create(context, &params, pixels, &image));
    free(pixels);
    return image;
}

static void agrees_with_raster_scans(pave_context *context, pave_image *image)
{
    pv_drawing drawing = { pave_image_width(image), pave_image_height(image), pave_image_pixels(image), 0 };
    int32_t count = drawing.width * drawing.height, *expected = malloc((size_t)count * sizeof *expected);
    pave_field *field = field_of(context, image, PAVE_METRIC_CHAMFER);
    for (int32_t y = 0; y < drawing.height; y++)
        pv_edge_row(&drawing, y, expected + y * drawing.width);
    chamfer_by_raster_scans(expected, drawing.width, drawing.height);
    for (int32_t i = 0; i < count; i++) {
        float want = expected[i] == PV_FIELD_FAR ? INFINITY : (float)expected[i] / PV_FIELD_ONE;
        assert_true(pave_field_distance(field)[i] == want);
    }
    free(expected);
    pave_field_free(&field);
    pave_image_free(&image);
}

/* Many bands and several strides of each march, which small drawings leave out. */
static void large_drawings_agree_with_raster_scans(void **state)
{
    pave_context *context = *state;
    static const int32_t sides[][2] = { { 700, 3300 }, { 3300, 700 }, { 3, 40000 }, { 40000, 3 } };
    for (int i = 0; i < 4; i++) {
        agrees_with_raster_scans(context, draw_shapes(context, sides[i][0], sides[i][1]));
        agrees_with_raster_scans(context, draw_dot(context, sides[i][0], sides[i][1]));
    }
}

static float distance_at(const pave_field *field, int32_t x, int32_t y)
{
    int32_t last_x = pave_field_width(field) - 1, last_y = pave_field_height(field) - 1;
    x = lesser(x > 0 ? x : 0, last_x);
    y = lesser(y > 0 ? y : 0, last_y);
    return pave_field_distance(field)[y * (last_x + 1) + x];
}

static void gradient_is_sobel(void **state)
{
    pave_context *context = *state;
    static const int weight[3] = { 1, 2, 1 };
    for (uint32_t key = 0; key < 20; key++) {
        int32_t width = 1 + (int32_t)(key * 7 % 31), height = 1 + (int32_t)(key * 5 % 23);
        pave_image *image = draw_random(context, width, height, key);
        pave_field *field = field_of(context, image, PAVE_METRIC_CHAMFER);
        float gx[31 * 23], gy[31 * 23];
        pave_field_gradient(field, gx, gy);
        for (int32_t i = 0; i < width * height; i++) {
            double across = 0, down = 0;
            int32_t x = i % width, y = i / width;
            for (int k = 0; k < 3; k++) {
                int32_t u = x + k - 1, v = y + k - 1;
                across += weight[k] / 8.0 * (distance_at(field, x + 1, v) - distance_at(field, x - 1, v));
                down += weight[k] / 8.0 * (distance_at(field, u, y + 1) - distance_at(field, u, y - 1));
            }
            int known = isfinite(across) && isfinite(down);
            assert_true(fabs(gx[i] - (known ? across : 0)) < 1e-4 && fabs(gy[i] - (known ? down : 0)) < 1e-4);
        }
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

/* The field of a drawing that repeats is the middle of that of nine copies, for no edge is farther than half a period. */
static void compare_periodic(pave_context *context, const pave_image *drawing, int32_t metric)
{
    pave_field_params params = PAVE_FIELD_PARAMS_INIT;
    pave_field *torus = NULL, *plane = NULL;
    pave_image *nine = repeat_image(context, drawing, 3, 3);
    int32_t width = pave_image_width(drawing), height = pave_image_height(drawing), across = 3 * width;
    size_t floats = 2 * 9 * sizeof(float) * (size_t)width * (size_t)height;
    float *gradient = malloc(floats), *expected = malloc(floats);
    params.metric = metric;
    assert_ok(pave_field_create(context, nine, &params, &plane));
    params.periodic = 1;
    assert_ok(pave_field_create(context, drawing, &params, &torus));
    pave_field_gradient(torus, gradient, gradient + width * height);
    pave_field_gradient(plane, expected, expected + 9 * width * height);
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++) {
            int32_t here = y * width + x, there = (y + height) * across + x + width;
            assert_true(pave_field_distance(torus)[here] == pave_field_distance(plane)[there]);
            assert_true(gradient[here] == expected[there]);
            assert_true(gradient[width * height + here] == expected[9 * width * height + there]);
        }
    free(gradient);
    free(expected);
    pave_field_free(&torus);
    pave_field_free(&plane);
    pave_image_free(&nine);
}

static void periodic_fields_are_those_of_the_repeated_drawing(void **state)
{
    pave_context *context = *state;
    static const int32_t sides[] = { 1, 2, 3, 5, 17, 40 };
    for (uint32_t key = 0; key < 36; key++) {
        pave_image *drawing = draw_random(context, sides[key % 6], sides[key / 6], key);
        for (int32_t metric = 0; metric < 3; metric++)
            compare_periodic(context, drawing, metric);
        pave_image_free(&drawing);
    }
    uint8_t *pixels = calloc(37, 52);
    pave_image *dot = NULL;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = 37;
    shape.height = 52;
    pixels[3 * 37 + 1] = 255; /* far from most, and near only across the borders */
    assert_ok(pave_image_create(context, &shape, pixels, &dot));
    for (int32_t metric = 0; metric < 3; metric++)
        compare_periodic(context, dot, metric);
    pave_image_free(&dot);
    free(pixels);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figure_3_comes_out),
        cmocka_unit_test(euclid_is_the_distance_to_the_frontier),
        cmocka_unit_test(chamfer_is_the_shortest_path),
        cmocka_unit_test(large_drawings_agree_with_raster_scans),
        cmocka_unit_test(gradient_is_sobel),
        cmocka_unit_test(gradient_points_away_from_the_edge_with_y_down),
        cmocka_unit_test(drawings_without_an_edge_are_infinitely_far_from_one),
        cmocka_unit_test(periodic_fields_are_those_of_the_repeated_drawing),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(only_drawings_are_taken),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
