/* image: storage, limits, threshold. */
#include "test.h"

#include "image/bitmap.h"
#include "image/image.h"

#include <fcntl.h>
#include <math.h>
#include <unistd.h>

static pave_image *image_of(pave_context *context, int32_t channels, int32_t type, int32_t encoding, int32_t alpha,
                            const void *pixels, int32_t width)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    params.width = width;
    params.height = 1;
    params.channels = channels;
    params.type = type;
    params.encoding = encoding;
    params.alpha = alpha;
    assert_ok(pave_image_create(context, &params, pixels, &image));
    return image;
}

static void expect_drawing(pave_context *context, pave_image *image, const pave_threshold_params *params,
                           const char *expected)
{
    pave_image *drawing = NULL;
    assert_ok(pave_image_threshold(context, image, params, &drawing));
    const uint8_t *pixels = pave_image_pixels(drawing);
    for (int32_t i = 0; i < pave_image_width(drawing); i++)
        assert_int_equal(pixels[i], expected[i] == '#' ? 0 : 255);
    pave_image_free(&drawing);
    pave_image_free(&image);
}

static void grey_is_cut_at_one_half(void **state)
{
    pave_context *context = *state;
    const uint8_t bytes[] = { 0, 127, 128, 255 };
    const uint16_t words[] = { 0, 32767, 32768, 65535 };
    const float floats[] = { -1, 0.4999f, 0.5f, INFINITY, NAN };
    expect_drawing(context, image_of(context, 1, PAVE_U8, PAVE_DISPLAY, -1, bytes, 4), NULL, "##..");
    expect_drawing(context, image_of(context, 1, PAVE_U16, PAVE_DISPLAY, -1, words, 4), NULL, "##..");
    expect_drawing(context, image_of(context, 1, PAVE_F32, PAVE_DATA, -1, floats, 5), NULL, "##..#");
}

static void linear_light_is_cut_in_display_space(void **state)
{
    pave_context *context = *state;
    const float floats[] = { 0.2139f, 0.2142f }; /* sRGB codes 0.5 as 0.21404 */
    const uint16_t halves[] = { 0x3266, 0x3333 }; /* 0.2 and 0.225 */
    expect_drawing(context, image_of(context, 1, PAVE_F32, PAVE_LINEAR, -1, floats, 2), NULL, "#.");
    expect_drawing(context, image_of(context, 1, PAVE_F16, PAVE_LINEAR, -1, halves, 2), NULL, "#.");
}

static void colour_becomes_luma_and_alpha_shows_white_paper(void **state)
{
    pave_context *context = *state;
    const uint8_t colours[] = { 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 0 };
    const uint8_t clear[] = { 0, 0, 0, 255, 0, 0, 0, 100, 0, 0, 0, 0, 255, 255, 255, 255 };
    const uint8_t grey_alpha[] = { 0, 127, 0, 128 };
    expect_drawing(context, image_of(context, 3, PAVE_U8, PAVE_DISPLAY, -1, colours, 4), NULL, "#.#.");
    expect_drawing(context, image_of(context, 4, PAVE_U8, PAVE_DISPLAY, 3, clear, 4), NULL, "#...");
    expect_drawing(context, image_of(context, 2, PAVE_U8, PAVE_DISPLAY, 1, grey_alpha, 2), NULL, ".#");
}

static void threshold_and_invert_are_parameters(void **state)
{
    pave_context *context = *state;
    const uint8_t bytes[] = { 0, 100, 200, 255 };
    pave_threshold_params params = PAVE_THRESHOLD_PARAMS_INIT;
    params.threshold = 0.9;
    expect_drawing(context, image_of(context, 1, PAVE_U8, PAVE_DISPLAY, -1, bytes, 4), &params, "###.");
    params.invert = 1;
    expect_drawing(context, image_of(context, 1, PAVE_U8, PAVE_DISPLAY, -1, bytes, 4), &params, "...#");
    params.threshold = NAN;
    pave_image *image = image_of(context, 1, PAVE_U8, PAVE_DISPLAY, -1, bytes, 4), *drawing = image;
    assert_int_equal(pave_image_threshold(context, image, &params, &drawing), PAVE_ERR_ARGUMENT);
    assert_null(drawing);
    pave_image_free(&image);
}

static void impossible_images_are_refused(void **state)
{
    pave_context *context = *state;
    static const struct {
        int32_t width, height, channels, type, alpha;
        pave_result result;
    } wrong[] = {
        { 0, 1, 1, PAVE_U8, -1, PAVE_ERR_ARGUMENT },
        { 1, -1, 1, PAVE_U8, -1, PAVE_ERR_ARGUMENT },
        { 1, 1, 33, PAVE_U8, -1, PAVE_ERR_ARGUMENT },
        { 1, 1, 1, 9, -1, PAVE_ERR_ARGUMENT },
        { 1, 1, 2, PAVE_U8, 2, PAVE_ERR_ARGUMENT },
        { 1 << 20, 1 << 20, 1, PAVE_U8, -1, PAVE_ERR_LIMIT },
        { INT32_MAX, 1, 1, PAVE_U8, -1, PAVE_ERR_ARGUMENT },
        { 1 << 14, 1 << 14, 32, PAVE_F32, -1, PAVE_ERR_LIMIT },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
        pave_image *image = (pave_image *)1;
        params.width = wrong[i].width;
        params.height = wrong[i].height;
        params.channels = wrong[i].channels;
        params.type = wrong[i].type;
        params.alpha = wrong[i].alpha;
        assert_int_equal(pave_image_create(context, &params, NULL, &image), wrong[i].result);
        assert_null(image);
        assert_true(*pave_context_message(context));
    }
}

static void channels_have_names(void **state)
{
    pave_context *context = *state;
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    params.width = params.height = 2;
    params.channels = 3;
    params.names = "distance,,gradient.y";
    assert_ok(pave_image_create(context, &params, NULL, &image));
    assert_string_equal(pave_image_channel_name(image, 0), "distance");
    assert_string_equal(pave_image_channel_name(image, 1), "c01");
    assert_string_equal(pave_image_channel_name(image, 2), "gradient.y");
    assert_null(pave_image_channel_name(image, 3));
    assert_int_equal(pv_image_channel(image, "gradient.y"), 2);
    assert_int_equal(pv_image_channel(image, "Y"), -1);
    pave_image_free(&image);
}

/* A drawing's bits in a file are those in memory, however they were stored; what cannot be kept is one sentence. */
static void bitmaps_in_files_are_those_in_memory(void **state)
{
    enum { WIDTH = 301, HEIGHT = 203, ROWS = 16 };
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, WIDTH, HEIGHT), *a, *b;
    pv_bitmap memory, file, small;
    uint64_t hash[2];
    FILE *temporary = tmpfile();
    assert_ok(pv_bitmap_create(context, WIDTH, HEIGHT, 1, &memory));
    pv_bitmap_store(&memory, 0, 0, drawing);
    assert_ok(pv_bitmap_create_in(context, WIDTH, HEIGHT, 1, dup(fileno(temporary)), &file));
    fclose(temporary);
    for (int32_t y = 0; y < HEIGHT; y += ROWS) {
        int32_t rows = HEIGHT - y < ROWS ? HEIGHT - y : ROWS;
        pv_bitmap band;
        assert_ok(pv_bitmap_create(context, WIDTH, rows, 1, &band));
        for (int32_t x = 0, columns; x < WIDTH; x += columns) {
            columns = WIDTH - x < 61 ? WIDTH - x : 61;
            assert_ok(pv_bitmap_cut(context, &memory, x, y, columns, rows, &a));
            pv_bitmap_store(&band, x, 0, a);
            pave_image_free(&a);
        }
        assert_ok(pv_bitmap_put(context, &file, y, &band));
        pv_bitmap_free(&band);
    }
    assert_ok(pv_bitmap_hash(context, &memory, &hash[0]));
    assert_ok(pv_bitmap_hash(context, &file, &hash[1]));
    assert_true(hash[0] == hash[1]);
    static const int32_t cuts[][4] = { { 0, 0, WIDTH, HEIGHT }, { 7, 5, 1, 1 }, { 300, 202, 1, 1 }, { 13, 50, 90, 77 } };
    for (int i = 0; i < 4; i++) {
        const int32_t *c = cuts[i];
        assert_ok(pv_bitmap_cut(context, &memory, c[0], c[1], c[2], c[3], &a));
        assert_ok(pv_bitmap_cut(context, &file, c[0], c[1], c[2], c[3], &b));
        assert_memory_equal(a->pixels, b->pixels, (size_t)c[2] * (size_t)c[3]);
        assert_memory_equal(&a->place, &b->place, sizeof a->place);
        pave_image_free(&a);
        pave_image_free(&b);
    }
    pv_bitmap_free(&file);
    int full = open("/dev/full", O_RDWR);
    assert_int_equal(pv_bitmap_create_in(context, WIDTH, HEIGHT, 1, full, &small), PAVE_ERR_IO);
    assert_int_equal(pv_bitmap_put(context, &small, 0, &memory), PAVE_ERR_IO);
    assert_non_null(strstr(pave_context_message(context), "No space left"));
    pv_bitmap_free(&small);
    pv_bitmap_free(&memory);
    pave_image_free(&drawing);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grey_is_cut_at_one_half),
        cmocka_unit_test(linear_light_is_cut_in_display_space),
        cmocka_unit_test(colour_becomes_luma_and_alpha_shows_white_paper),
        cmocka_unit_test(threshold_and_invert_are_parameters),
        cmocka_unit_test(impossible_images_are_refused),
        cmocka_unit_test(channels_have_names),
        cmocka_unit_test(bitmaps_in_files_are_those_in_memory),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
