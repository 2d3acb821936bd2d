/* Curves out of SVG files, thousands of them damaged: what is read can be drawn, what is not has a clear reason. */
#include "test.h"

#include <stdio.h>
#include <unistd.h>

enum { ROUNDS = 6000, ROOM = 2048 };

static const char *const models[] = {
    "<?xml version='1.0'?><!-- <path d='M0 0'/> --><svg viewBox='0 0 90 60'><defs><path id='a' d='M1 1L2 2'/></defs>"
    "<g transform='translate(10,20) scale(2)'><path d='m1-1 2,0v3.5.5zM0 0c1 0 2 1 2 2a1 1 0 11 2 0'/></g>"
    "<polyline points='1,2 3,4 -5e1 6'/><circle cx='5' cy='5' r='2'/></svg>",
    "<svg><g><path d='M 10 10 H 20 V 30 h-5 v-5 Q 3 4 5 6 T 7 8 S 1 2 3 4 C 1 2 3 4 5 6 s 1 1 2 2 q 1 1 2 2 t 3 3 Z'/>"
    "</g><rect x='1' y='2' width='30' height='40' transform='rotate(30 5 5) skewX(10)'/></svg>",
    "<svg><ellipse cx='20' cy='20' rx='10' ry='4' transform='matrix(1 0.5 -0.5 1 3 4)'/><line x1='0' y1='1' x2='80'"
    " y2='50'/><polygon points='1 1 40 3 20 50'/><text><path d='M0 0L1 1'/></text><path d=\"M1e3-1e3.5.5L0 0\"/></svg>",
    "<svg><path d='M 5 5 A 25 10 -30 0 1 50 25 A 0 0 0 0 0 9 9 a 1e-9 1e9 400 1 0 3 3 z z M 1 1'/></svg>",
};

static const char *const pieces[] = { "'", "\"", "<", ">", "/>", "<!--", "-->", "<g>", "</g>", "<svg", "1e999", "-1e308",
                                      "nan", "inf", "M", "z", "a 1 1 0 1 1", "transform='scale(0)'", "d='", " ", ",",
                                      "0x1p9", "matrix(", ")", ".", "-", "e", "9999999999", "C", "Q 1", "points='" };

static uint32_t draw(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    return *state ^= *state << 5;
}

/* Takes a part away, writes over a byte, doubles a part, or puts a piece in. */
static size_t damage(uint32_t *state, char *text, size_t length)
{
    size_t at = draw(state) % (length + 1), part = draw(state) % 24;
    const char *piece = pieces[draw(state) % (sizeof pieces / sizeof *pieces)];
    switch (draw(state) % 4) {
    case 0:
        part = part < length - at ? part : length - at;
        memmove(text + at, text + at + part, length - at - part);
        return length - part;
    case 1:
        if (at < length)
            text[at] = (char)draw(state);
        return length;
    case 2:
        part = part < length - at ? part : length - at;
        memmove(text + at + part, text + at, length - at);
        return length + part;
    default:
        memmove(text + at + strlen(piece), text + at, length - at);
        memcpy(text + at, piece, strlen(piece));
        return length + strlen(piece);
    }
}

static void write_text(const char *path, const char *text, size_t length)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, length, file), length);
    assert_int_equal(fclose(file), 0);
}

static void assert_can_be_drawn(pave_context *context, const pave_image *photo, const pave_curves *curves, int periodic)
{
    pave_mosaic_sources sources = PAVE_MOSAIC_SOURCES_INIT;
    pave_mosaic_params params = PAVE_MOSAIC_PARAMS_INIT;
    pave_guide *guide = NULL;
    sources.photo = photo;
    sources.curves = curves;
    params.tiles = 8;
    params.periodic = periodic;
    pave_result result = pave_guide_create(context, &sources, &params, &guide);
    assert_true(result == PAVE_OK || result == PAVE_ERR_ARGUMENT);
    if (result)
        assert_non_null(strstr(pave_context_message(context), "none of the edges"));
    pave_guide_free(&guide);
}

static void check_curves(const pave_curves *curves)
{
    const int64_t *starts = pave_curves_starts(curves);
    assert_true(pave_curves_count(curves) > 0 && starts[0] == 0);
    for (int32_t i = 0; i < pave_curves_count(curves); i++)
        assert_true(starts[i] <= starts[i + 1]);
    for (int64_t i = 0; i < 2 * starts[pave_curves_count(curves)]; i++)
        assert_true(pave_curves_points(curves)[i] - pave_curves_points(curves)[i] == 0); /* finite */
}

static void damaged_files_are_read_or_refused(void **state)
{
    pave_context *context = *state;
    char path[] = "/tmp/pave-damaged-XXXXXX.svg", text[ROOM + 64];
    int file = mkstemps(path, 4), read = 0, refused = 0;
    uint32_t random = 2463534242u;
    uint8_t grey[30 * 20] = { 0 };
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_image *photo = NULL;
    assert_true(file >= 0);
    close(file);
    shape.width = 30;
    shape.height = 20;
    assert_ok(pave_image_create(context, &shape, grey, &photo));
    for (int round = 0; round < ROUNDS; round++) {
        pave_curves *curves = NULL;
        const char *source = models[draw(&random) % 4];
        size_t length = strlen(source);
        memcpy(text, source, length);
        for (uint32_t k = draw(&random) % 8; k && length < ROOM; k--)
            length = damage(&random, text, length);
        write_text(path, text, length);
        pave_result result = pave_curves_read(context, path, &curves);
        assert_true(result == PAVE_OK || result == PAVE_ERR_FORMAT);
        assert_true((result == PAVE_OK) == (curves != NULL));
        if (result)
            assert_non_null(strstr(pave_context_message(context), path));
        else
            check_curves(curves);
        if (!result && round % 4 == 0)
            assert_can_be_drawn(context, photo, curves, round % 8 == 0);
        read += !result;
        refused += result != PAVE_OK;
        pave_curves_free(&curves);
    }
    assert_true(read > ROUNDS / 8 && refused > ROUNDS / 50);
    pave_image_free(&photo);
    unlink(path);
}

static void some_are_refused_for_a_reason(void **state)
{
    static const char *const cases[][2] = { { "", "no SVG" },
                                            { "<svg></svg>", "no curves" },
                                            { "<svg><path d='M1 1L2 2'", "within a tag" },
                                            { "<svg><path transform='scale(1e200)' d='M1 1L1e200 2'/></svg>", "beyond" } };
    pave_context *context = *state;
    char path[] = "/tmp/pave-refused-XXXXXX.svg";
    int file = mkstemps(path, 4);
    assert_true(file >= 0);
    close(file);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        pave_curves *curves = NULL;
        write_text(path, cases[i][0], strlen(cases[i][0]));
        assert_int_equal(pave_curves_read(context, path, &curves), PAVE_ERR_FORMAT);
        assert_non_null(strstr(pave_context_message(context), cases[i][1]));
    }
    char deep[1024] = "<svg>";
    for (int i = 0; i < 80; i++)
        strcat(deep, "<g>");
    write_text(path, deep, strlen(deep));
    pave_curves *curves = NULL;
    assert_int_equal(pave_curves_read(context, path, &curves), PAVE_ERR_FORMAT);
    assert_non_null(strstr(pave_context_message(context), "nested"));
    unlink(path);
    assert_int_equal(pave_curves_read(context, path, &curves), PAVE_ERR_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_files_are_read_or_refused),
        cmocka_unit_test(some_are_refused_for_a_reason),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
