/* All backends agree on the labels and the sites of three drawings after 20 iterations: brute force, portable C, AVX2
 * and every graphics backend that there is. The drawings are parts of the shared reference drawings where
 * PAVE_SHARED names them, and else of our own. */
#include "devices.h"

enum { SIDE = 200 };

/* The middle of a drawing file; brute force takes too long for the whole. */
static pave_image *read_part(pave_context *context, const char *path)
{
    pave_image *image = NULL, *drawing = NULL;
    uint8_t *pixels = malloc(SIDE * SIDE);
    assert_ok(pave_image_read(context, path, &image));
    assert_ok(pave_image_threshold(context, image, NULL, &drawing));
    int32_t width = pave_image_width(drawing), left = (width - SIDE) / 2, top = (pave_image_height(drawing) - SIDE) / 2;
    const uint8_t *from = pave_image_pixels(drawing);
    for (int32_t y = 0; y < SIDE; y++)
        memcpy(pixels + y * SIDE, from + (int64_t)(top + y) * width + left, SIDE);
    pave_image_free(&image);
    pave_image_free(&drawing);
    return take_pixels(context, SIDE, SIDE, pixels);
}

static pave_image *drawing_number(pave_context *context, int number)
{
    static const char *const names[] = { "waves", "flower", "text" };
    const char *shared = getenv("PAVE_SHARED");
    char path[1024];
    if (shared && *shared)
        snprintf(path, sizeof path, "%s/data/reference-drawings/%s.png", shared, names[number]);
    else if (number == 0)
        snprintf(path, sizeof path, "%s/../../examples/drawings/copacabana.png", PAVE_TEST_DATA);
    else
        return draw_shapes(context, SIDE, SIDE - 10 * number);
    return read_part(context, path);
}

static void all_backends_agree_on_three_drawings(void **state)
{
    pave_context *context = *state;
    int32_t backends[MOST_BACKENDS], count = usable_backends(context, backends);
    for (int number = 0; number < 3; number++) {
        pave_image *drawing = drawing_number(context, number);
        pave_context *reference = make_context(2, PAVE_BACKEND_CPU_REFERENCE);
        pave_field *field = NULL;
        pave_cvd *expected = NULL;
        assert_ok(pave_field_create(context, drawing, NULL, &field));
        assert_ok(pave_cvd_create(reference, field, NULL, &expected));
        print_message("drawing %d, %d sites\n", number + 1, (int)pave_cvd_site_count(expected));
        for (int32_t i = 0; i < count; i++)
            assert_agrees(field, NULL, 2, backends[i], expected);
        pave_cvd_free(&expected);
        pave_field_free(&field);
        pave_context_free(&reference);
        pave_image_free(&drawing);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(all_backends_agree_on_three_drawings) };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
