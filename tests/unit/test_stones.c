/* stones: every polygon valid, colours, grout, counts, bad input. */
#include "test.h"

#include "util/polygon.h"
#include "util/random.h"

#include <math.h>

static pave_stones *lay(pave_context *context, const pave_image *drawing, double half_side,
                        const pave_stones_params *stones_params)
{
    pave_cvd_params cvd = PAVE_CVD_PARAMS_INIT;
    pave_lay_params params = PAVE_LAY_PARAMS_INIT;
    pave_stones *stones = NULL;
    cvd.half_side = half_side;
    params.cvd = &cvd;
    params.stones = stones_params;
    assert_ok(pave_lay(context, drawing, &params, &stones));
    return stones;
}

static int32_t ring_of(const pave_stones *stones, int32_t s, pv_cell *ring)
{
    int32_t count = 0;
    for (int64_t i = pave_stones_starts(stones)[s]; i < pave_stones_starts(stones)[s + 1]; i++) {
        const double *p = pave_stones_vertices(stones) + 2 * i;
        assert_true(p[0] >= 0 && p[0] <= pave_stones_width(stones));
        assert_true(p[1] >= 0 && p[1] <= pave_stones_height(stones));
        ring[count++] = (pv_cell){ (int32_t)lround(p[0] * 1000), (int32_t)lround(p[1] * 1000) };
        assert_true(p[0] == ring[count - 1].x / 1000.0 && p[1] == ring[count - 1].y / 1000.0);
    }
    return count;
}

static void assert_all_valid(const pave_stones *stones)
{
    pv_cell ring[300];
    for (int32_t s = 0; s < pave_stones_count(stones); s++) {
        assert_true(pv_ring_valid(ring, ring_of(stones, s, ring)));
        assert_true(s == 0 || pave_stones_sites(stones)[s] >= pave_stones_sites(stones)[s - 1]);
    }
}

static void every_stone_is_valid_whatever_the_parameters(void **state)
{
    pave_context *context = *state;
    static const double half_sides[] = { 1, 1.5, 2.5, 4, 9, 40 }, grouts[] = { 0, 1, 3, 50 };
    pave_image *drawing = draw_shapes(context, 160, 130);
    for (int h = 0; h < 6; h++)
        for (int g = 0; g < 4; g += 1 + THREAD_SANITIZED) {
            pave_stones_params params = PAVE_STONES_PARAMS_INIT;
            params.mode = (h + g) & 1;
            params.grout = grouts[g];
            params.passes = g * 2;
            params.wide_angle = 120 - 5 * h;
            params.small_edge = 0.25 * g;
            pave_stones *stones = lay(context, drawing, half_sides[h], &params);
            assert_true(pave_stones_count(stones) > 0 || grouts[g] >= half_sides[h]); /* joints leave nothing */
            assert_all_valid(stones);
            pave_stones_free(&stones);
        }
    pave_image_free(&drawing);
}

static void most_stones_are_quads_in_the_colour_below(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 400, 300);
    pave_stones_params params = PAVE_STONES_PARAMS_INIT;
    params.grout = 0;
    params.mode = PAVE_MODE_PAPER;
    pave_stones *stones = lay(context, drawing, 4, &params);
    pave_report m = { .size = sizeof m };
    assert_ok(pave_stones_report(context, stones, &m));
    assert_true(m.corners_after[4] > 0.95 * m.stones);
    assert_true(m.corners_before[6] > m.corners_before[5] && m.corners_before[6] > m.corners_before[7]);
    assert_true(m.coverage > 0.97 && m.coverage < 1.0);
    assert_int_equal(m.stones + m.lost, m.sites);
    int64_t areas = 0, corners = 0;
    for (int i = 0; i < PAVE_REPORT_BINS; i++)
        areas += m.areas[i], corners += m.corners_after[i];
    assert_int_equal(areas, m.stones);
    assert_int_equal(corners, m.stones);
    const uint8_t *pixels = pave_image_pixels(drawing);
    int wrong = 0;
    for (int32_t s = 0; s < m.stones; s++) {
        double x = 0, y = 0, count = 0;
        for (int64_t i = pave_stones_starts(stones)[s]; i < pave_stones_starts(stones)[s + 1]; i++, count++)
            x += pave_stones_vertices(stones)[2 * i], y += pave_stones_vertices(stones)[2 * i + 1];
        wrong += pixels[(int)(y / count) * 400 + (int)(x / count)] != pave_stones_colours(stones)[s];
    }
    assert_true(wrong < 0.01 * m.stones);
    pave_stones_free(&stones);
    pave_image_free(&drawing);
}

static double coverage(pave_context *context, const pave_image *drawing, double grout)
{
    pave_stones_params params = PAVE_STONES_PARAMS_INIT;
    pave_report m = { .size = sizeof m };
    params.grout = grout;
    pave_stones *stones = lay(context, drawing, 4, &params);
    assert_ok(pave_stones_report(context, stones, &m));
    pave_stones_free(&stones);
    return m.coverage;
}

static void grout_opens_the_joints(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 200, 200);
    double none = coverage(context, drawing, 0), one = coverage(context, drawing, 1), two = coverage(context, drawing, 2);
    assert_true(none > one + 0.1 && one > two + 0.1);
    pave_image_free(&drawing);
}

static void a_one_pixel_drawing_is_one_stone(void **state)
{
    pave_context *context = *state;
    static const char *const pixel[] = { "#" };
    pave_image *drawing = draw_text(context, pixel, 1);
    pave_stones_params params = PAVE_STONES_PARAMS_INIT;
    params.grout = 0;
    pave_stones *stones = lay(context, drawing, 4, &params);
    static const double square[] = { 0, 0, 0, 1, 1, 1, 1, 0 };
    assert_int_equal(pave_stones_count(stones), 1);
    assert_int_equal(pave_stones_starts(stones)[1], 4);
    assert_int_equal(pave_stones_colours(stones)[0], 0);
    for (int i = 0; i < 4; i++) {
        int found = 0;
        for (int k = 0; k < 4; k++)
            found |= !memcmp(&square[2 * k], pave_stones_vertices(stones) + 2 * i, 2 * sizeof(double));
        assert_true(found);
    }
    pave_stones_free(&stones);
    pave_image_free(&drawing);
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    static const int32_t threads[] = { 1, 2, 7 };
    uint64_t hash[2] = { 0, 0 };
    for (int t = 0; t < 6; t++) {
        pave_context *context = make_context(threads[t / 2], PAVE_BACKEND_CPU);
        pave_image *drawing = draw_shapes(context, 301, 207);
        pave_stones_params params = PAVE_STONES_PARAMS_INIT;
        params.mode = t % 2;
        pave_stones *stones = lay(context, drawing, 3, &params);
        int64_t count = pave_stones_starts(stones)[pave_stones_count(stones)];
        uint64_t now = hash_bytes(pave_stones_vertices(stones), (size_t)count * 16);
        assert_true(t < 2 || now == hash[t % 2]);
        hash[t % 2] = now;
        pave_stones_free(&stones);
        pave_image_free(&drawing);
        pave_context_free(&context);
    }
}

static void parts_that_do_not_belong_together_are_refused(void **state)
{
    pave_context *context = *state;
    pave_image *drawing = draw_shapes(context, 60, 50), *other = draw_shapes(context, 50, 60);
    pave_field *field = NULL;
    pave_cvd *cvd = NULL;
    pave_stones *stones = (pave_stones *)1;
    assert_ok(pave_field_create(context, drawing, NULL, &field));
    assert_ok(pave_cvd_create(context, field, NULL, &cvd));
    assert_int_equal(pave_stones_create(context, other, field, cvd, NULL, &stones), PAVE_ERR_ARGUMENT);
    assert_null(stones);
    assert_int_equal(pave_stones_create(context, drawing, field, NULL, NULL, &stones), PAVE_ERR_ARGUMENT);
    pave_stones_params params = PAVE_STONES_PARAMS_INIT;
    params.grout = INFINITY;
    assert_int_equal(pave_stones_create(context, drawing, field, cvd, &params, &stones), PAVE_ERR_ARGUMENT);
    params.grout = 1;
    params.mode = 7;
    assert_int_equal(pave_stones_create(context, drawing, field, cvd, &params, &stones), PAVE_ERR_ARGUMENT);
    pave_cvd_free(&cvd);
    pave_field_free(&field);
    pave_image_free(&drawing);
    pave_image_free(&other);
}

/* Small drawings at random: noise, checkerboards, islands, stripes, spirals, blanks; `kind` says which. */
static pave_image *draw_random(pave_context *context, uint32_t which, int kind)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pv_random r = pv_draw(7, 99, which, (uint32_t)kind, 0);
    shape.width = 1 + (int32_t)pv_below(r.word[0], kind == 5 ? 4 : 40);
    shape.height = 1 + (int32_t)pv_below(r.word[1], kind == 5 ? 600 : 40);
    uint8_t pixels[40 * 600];
    for (int32_t y = 0; y < shape.height; y++)
        for (int32_t x = 0; x < shape.width; x++) {
            uint32_t word = pv_draw(7, 98, (uint32_t)x, (uint32_t)y, which).word[0];
            int32_t ring = abs(2 * x - shape.width) > abs(2 * y - shape.height) ? abs(2 * x - shape.width)
                                                                                  : abs(2 * y - shape.height);
            int black = kind == 0 ? (int)(word & 1) : kind == 1 ? (x + y) & 1 : kind == 2 ? word < 1u << 27 :
                        kind == 3 ? x * 3 / (1 + (int32_t)pv_below(r.word[2], 9)) & 1 : kind == 4 ? (ring / 3 + (x > y)) & 1 :
                        kind == 5 ? (word >> 7) % 5 == 0 : 0;
            pixels[y * shape.width + x] = black ? 0 : 255;
        }
    pave_image *image = NULL;
    assert_ok(pave_image_create(context, &shape, pixels, &image));
    return image;
}

/* Exactly: do the insides of two convex rings meet? Not if some side of one has all of the other on its outer side. */
static int apart(const pv_cell *a, int32_t n, const pv_cell *b, int32_t m)
{
    for (int32_t i = 0; i < n; i++) {
        int32_t k = 0;
        while (k < m && pv_cell_turn(a[i], a[(i + 1) % n], b[k]) <= 0)
            k++;
        if (k == m)
            return 1;
    }
    return 0;
}

static int is_convex(const pv_cell *ring, int32_t count)
{
    for (int32_t i = 0; i < count; i++)
        if (pv_cell_turn(ring[i], ring[(i + 1) % count], ring[(i + 2) % count]) < 0)
            return 0;
    return 1;
}

static void assert_no_overlap(const pave_stones *stones)
{
    const int64_t *starts = pave_stones_starts(stones);
    int32_t count = pave_stones_count(stones);
    pv_cell *cells = malloc(((size_t)starts[count] + 1) * sizeof *cells);
    char *convex = malloc((size_t)count + 1);
    for (int32_t s = 0; s < count; s++) {
        pv_cell *a = cells + starts[s];
        int32_t n = ring_of(stones, s, a);
        assert_true(n >= 3 && pv_ring_valid(a, n));
        convex[s] = (char)is_convex(a, n);
        for (int32_t t = 0; t < s && convex[s]; t++) {
            pv_cell *b = cells + starts[t];
            int32_t m = (int32_t)(starts[t + 1] - starts[t]);
            if (convex[t])
                assert_true(apart(a, n, b, m) || apart(b, m, a, n));
        }
    }
    free(convex);
    free(cells);
}

static void nothing_overlaps_in_any_drawing(void **state)
{
    static const double half_sides[] = { 1, 1.3, 2.5, 4, 30 };
    pave_context *context = *state;
    uint32_t drawings = THREAD_SANITIZED ? 35 : SANITIZED ? 210 : 2000; /* 210: each kind in each way */
    for (uint32_t which = 0; which < drawings; which++) {
        pave_image *drawing = draw_random(context, which, (int)(which % 7));
        pave_stones_params params = PAVE_STONES_PARAMS_INIT;
        params.mode = PAVE_MODE_BEST;
        params.grout = which & 1 ? 0 : 0.4;
        params.thin = which % 5 == 0;
        params.joint_style = which % 3 == 0;
        pave_stones *stones = lay(context, drawing, half_sides[which % 5], &params);
        assert_no_overlap(stones);
        pave_stones_free(&stones);
        pave_image_free(&drawing);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_stone_is_valid_whatever_the_parameters),
        cmocka_unit_test(most_stones_are_quads_in_the_colour_below),
        cmocka_unit_test(nothing_overlaps_in_any_drawing),
        cmocka_unit_test(grout_opens_the_joints),
        cmocka_unit_test(a_one_pixel_drawing_is_one_stone),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(parts_that_do_not_belong_together_are_refused),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
