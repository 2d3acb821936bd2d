/* Drawings made from greys: the contour is where these cross the threshold, in whatever way the drawing is kept. */
#include "test.h"

#include "cvd/cvd.h"
#include "image/bitmap.h"
#include "stones/contour.h"

#include <math.h>

enum { SIDE = 256, FINE = 8, KINDS = 4 };

/* How far a place is outside of a disk, or of a half plane. */
static double outside(int kind, double x, double y)
{
    static const double slope[KINDS] = { 0, 0.05, 0.3, 0.93 };
    double dx = x - SIDE * 0.5 - 0.3, dy = y - SIDE * 0.5 + 0.7, s = slope[kind];
    return kind ? dy * sqrt(1 - s * s) - dx * s : sqrt(dx * dx + dy * dy) - SIDE * 0.4;
}

/* Of each pixel the share that is outside; or all or nothing. */
static pave_image *render(pave_context *context, int kind, int hard)
{
    uint8_t *pixels = malloc(SIDE * SIDE);
    for (int32_t y = 0; y < SIDE; y++)
        for (int32_t x = 0; x < SIDE; x++) {
            int share = 0;
            for (int k = 0; k < FINE * FINE; k++)
                share += outside(kind, x + (k % FINE + 0.5) / FINE, y + (k / FINE + 0.5) / FINE) > 0;
            pixels[y * SIDE + x] = (uint8_t)(hard ? (2 * share >= FINE * FINE ? 255 : 0) : share * 255 / FINE / FINE);
        }
    return take_pixels(context, SIDE, SIDE, pixels);
}

typedef struct distance {
    double sum, most;
    int32_t count;
} distance;

static void add(distance *d, double v)
{
    d->sum += fabs(v);
    d->most = fabs(v) > d->most ? fabs(v) : d->most;
    d->count++;
}

/* Vertices on the contour, and points on its sides. */
static void look_at_contour(const pv_tess *tess, int kind, distance *corners, distance *sides)
{
    for (int32_t f = 0; f < tess->face_count; f++)
        for (int64_t p = tess->first[f]; tess->colour[f] && p < tess->first[f + 1]; p++) {
            int32_t v = tess->corner[p], w = tess->corner[pv_tess_next(tess, p)], between = 0;
            for (int64_t i = tess->star[v]; i < tess->star[v + 1]; i++) {
                int64_t place = tess->spoke[i];
                between |= !tess->colour[tess->face_of[place]] && tess->corner[pv_tess_previous(tess, place)] == w;
            }
            if (!between || ((tess->kind[v] | tess->kind[w]) & PV_BORDER))
                continue;
            double ax = tess->at[v].x / 1000.0, ay = tess->at[v].y / 1000.0;
            double bx = tess->at[w].x / 1000.0, by = tess->at[w].y / 1000.0;
            add(corners, outside(kind, ax, ay));
            for (int k = 1; k < 8; k++)
                add(sides, outside(kind, ax + (bx - ax) * k / 8, ay + (by - ay) * k / 8));
        }
}

/* The contour as it is drawn, between cells that are squares. */
static void trace_squares(pave_context *context, const pave_image *drawing, pv_tess *tess)
{
    enum { CELL = 9, CELLS = (SIDE + CELL - 1) / CELL };
    int32_t *labels = malloc(SIDE * SIDE * sizeof *labels);
    for (int32_t i = 0; i < SIDE * SIDE; i++)
        labels[i] = i / SIDE / CELL * CELLS + i % SIDE / CELL;
    pv_label_image image = { .width = SIDE, .height = SIDE, .labels = labels, .stride = SIDE,
                             .label_count = CELLS * CELLS, .colours = drawing->pixels, .colour_width = SIDE,
                             .scale = 1 };
    pv_tess_place place = { 0, 0, 1, 4, { 0, 0 }, drawing->levels ? drawing : NULL };
    pv_pieces pieces;
    assert_ok(pv_pieces_split(context, &image, 16, 0, &pieces));
    assert_ok(pv_tess_trace(context, &pieces, &place, tess));
    pv_pieces_free(&pieces);
    free(labels);
}

/* The contour as it is where its stones are quadrilaterals. */
static void trace_stones(pave_context *context, const pave_image *drawing, pv_tess *tess)
{
    pave_cvd_params cvd_params = PAVE_CVD_PARAMS_INIT;
    pave_stones_params params = PAVE_STONES_PARAMS_INIT;
    pave_field *field = NULL;
    pave_cvd *cvd = NULL;
    params.mode = PAVE_MODE_BEST;
    cvd_params.supersample = 2;
    assert_ok(pave_field_create(context, drawing, NULL, &field));
    assert_ok(pave_cvd_create(context, field, &cvd_params, &cvd));
    assert_ok(pv_best_tess(context, drawing, cvd, &params, tess));
    pave_cvd_free(&cvd);
    pave_field_free(&field);
}

/* Mean distance of the contour from the truth, of its corners and of its sides. */
static void judge_contour(pave_context *context, int kind, int hard, int stones, double mean[2])
{
    pave_image *image = render(context, kind, hard), *drawing = NULL;
    distance corners = { 0, 0, 0 }, sides = corners;
    pv_tess tess;
    assert_ok(pave_image_threshold(context, image, NULL, &drawing));
    assert_int_equal(!drawing->levels, hard);
    (stones ? trace_stones : trace_squares)(context, drawing, &tess);
    assert_ok(pv_tess_check(context, &tess));
    look_at_contour(&tess, kind, &corners, &sides);
    pv_tess_free(&tess);
    pave_image_free(&drawing);
    pave_image_free(&image);
    assert_true(corners.count > 20);
    mean[0] = corners.sum / corners.count;
    mean[1] = sides.sum / sides.count;
    print_message("  %s, %s, %s: corners %.3f px off, sides %.3f, at most %.3f\n", kind ? "half plane" : "disk",
                  stones ? "stones" : "squares", hard ? "hard" : "grey", mean[0], mean[1], sides.most);
}

static void the_contour_is_where_greys_say(void **state)
{
    not_for_threads();
    for (int kind = 0; kind < KINDS; kind++)
        for (int stones = 0; stones < 2; stones++) {
            double grey[2], hard[2];
            judge_contour(*state, kind, 0, stones, grey);
            judge_contour(*state, kind, 1, stones, hard);
            for (int i = 0; i < 2; i++)
                assert_true(grey[i] <= (stones ? 0.1 : 0.05) && grey[i] < hard[i]);
        }
}

/* What is only black and white is not kept as greys, whatever the threshold; and colours are on the right side. */
static void levels_agree_with_pixels(void **state)
{
    static const double thresholds[] = { 0, 0.2, 0.5, 0.50196, 0.9, 1 };
    for (size_t k = 0; k < sizeof thresholds / sizeof *thresholds; k++)
        for (int invert = 0; invert < 2; invert++) {
            pave_threshold_params params = { sizeof params, thresholds[k], invert };
            uint8_t *pixels = malloc(256);
            pave_image *drawing = NULL;
            for (int32_t i = 0; i < 256; i++)
                pixels[i] = (uint8_t)i;
            pave_image *image = take_pixels(*state, 16, 16, pixels);
            assert_ok(pave_image_threshold(*state, image, &params, &drawing));
            const uint8_t *black_or_white = pave_image_pixels(drawing);
            assert_non_null(drawing->levels);
            for (int32_t i = 0; i < 256; i++) {
                int32_t level = drawing->levels[i], value = invert ? 255 - i : i;
                assert_in_range(level - value + 1, 0, 2);
                assert_int_equal(256 * level > drawing->cut, black_or_white[i] == 255);
            }
            pave_image_free(&drawing);
            pave_image_free(&image);
        }
    for (int hard = 0; hard < 2; hard++) {
        pave_image *image = render(*state, 0, hard), *drawing = NULL;
        assert_ok(pave_image_threshold(*state, image, NULL, &drawing));
        assert_int_equal(!drawing->levels, hard);
        pave_image_free(&drawing);
        pave_image_free(&image);
    }
}

/* Flat greys with hard edges are as good as black and white: the contour is that of the same drawing in these. */
static void flat_greys_are_hard(void **state)
{
    pave_stones *stones[2] = { NULL, NULL };
    pave_stones_params params = PAVE_STONES_PARAMS_INIT;
    pave_lay_params lay = PAVE_LAY_PARAMS_INIT;
    params.mode = PAVE_MODE_BEST;
    lay.stones = &params;
    for (int flat = 0; flat < 2; flat++) {
        pave_image *image = render(*state, 0, 1);
        uint8_t *pixels = image->pixels;
        for (int32_t i = 0; flat && i < SIDE * SIDE; i++)
            pixels[i] = (uint8_t)(pixels[i] ? (i % SIDE < SIDE / 2 ? 130 : 251) : 60);
        assert_ok(pave_lay(*state, image, &lay, &stones[flat]));
        pave_image_free(&image);
    }
    int32_t count = pave_stones_count(stones[0]);
    assert_int_equal(pave_stones_count(stones[1]), count);
    size_t corners = (size_t)pave_stones_starts(stones[0])[count];
    assert_memory_equal(pave_stones_vertices(stones[0]), pave_stones_vertices(stones[1]), 2 * corners * sizeof(double));
    pave_stones_free(&stones[0]);
    pave_stones_free(&stones[1]);
}

/* Levels come back from a bitmap in which bits were first. */
static void bits_become_levels(void **state)
{
    enum { ROWS = 40 };
    pave_image *image = render(*state, 1, 0), *drawing = NULL, *part = NULL;
    pv_bitmap bits, deep;
    uint64_t hash[2];
    assert_ok(pave_image_threshold(*state, image, NULL, &drawing));
    assert_ok(pv_bitmap_create(*state, SIDE, SIDE, 1, &bits));
    assert_ok(pv_bitmap_create(*state, SIDE, SIDE, 8, &deep));
    uint8_t *levels = drawing->levels;
    drawing->levels = NULL;
    pv_bitmap_store(&bits, 0, 0, drawing);
    drawing->levels = levels;
    deep.cut = drawing->cut;
    pv_bitmap_store(&deep, 0, 0, drawing);
    assert_ok(pv_bitmap_hash(*state, &deep, &hash[0]));
    assert_ok(pv_bitmap_deepen(*state, &bits, ROWS, &deep));
    assert_ok(pv_bitmap_hash(*state, &deep, &hash[1]));
    assert_ok(pv_bitmap_cut(*state, &deep, -7, -9, SIDE + 20, SIDE + 20, &part));
    for (int32_t y = 0; y < part->height; y++)
        for (int32_t x = 0; x < part->width; x++) {
            int32_t from = (y - 9 + SIDE) % SIDE * SIDE + (x - 7 + SIDE) % SIDE, at = y * part->width + x;
            uint8_t pixel = ((const uint8_t *)drawing->pixels)[from];
            assert_int_equal(((const uint8_t *)part->pixels)[at], pixel);
            assert_int_equal(part->levels[at], from < ROWS * SIDE ? pixel : levels[from]);
        }
    pave_image_free(&part);
    pave_image_free(&drawing);
    pave_image_free(&image);
    pv_bitmap_free(&bits);
    pv_bitmap_free(&deep);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_contour_is_where_greys_say),
        cmocka_unit_test(levels_agree_with_pixels),
        cmocka_unit_test(flat_greys_are_hard),
        cmocka_unit_test(bits_become_levels),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
