/* util: fixed point, random numbers, noise, text, polygons. */
#include "test.h"

#include "util/fixed.h"
#include "util/half.h"
#include "util/noise.h"
#include "util/polygon.h"
#include "util/random.h"
#include "util/text.h"

#include <locale.h>
#include <math.h>

static void philox_gives_its_published_answers(void **state)
{
    (void)state;
    static const struct {
        pv_random counter;
        uint32_t key[2];
        pv_random answer;
    } known[] = {
        { { { 0, 0, 0, 0 } }, { 0, 0 }, { { 0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8 } } },
        { { { 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff } }, { 0xffffffff, 0xffffffff },
          { { 0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd } } },
        { { { 0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344 } }, { 0xa4093822, 0x299f31d0 },
          { { 0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1 } } },
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        pv_random got = pv_philox(known[i].counter, known[i].key[0], known[i].key[1]);
        assert_memory_equal(&got, &known[i].answer, sizeof got);
    }
}

static void square_roots_are_floored(void **state)
{
    (void)state;
    for (uint64_t r = 0; r < 100000; r += 37) {
        assert_int_equal(pv_isqrt(r * r), r);
        assert_int_equal(pv_isqrt(r * r + 2 * r), r);
    }
    assert_int_equal(pv_isqrt(UINT64_MAX), UINT32_MAX);
}

static void turns_are_on_the_unit_circle(void **state)
{
    (void)state;
    for (int32_t a = -70000; a < 70000; a += 13) {
        int32_t c, s;
        pv_turn(a, &c, &s);
        double angle = a * (2 * 3.14159265358979323846 / 65536);
        assert_true(fabs(c - 65536 * cos(angle)) < 0.6);
        assert_true(fabs(s - 65536 * sin(angle)) < 0.6);
    }
}

static void floor_division_rounds_down(void **state)
{
    (void)state;
    assert_int_equal(pv_floor_div(7, 3), 2);
    assert_int_equal(pv_floor_div(-7, 3), -3);
    assert_int_equal(pv_floor_div(-6, 3), -2);
}

static void noise_is_smooth_bounded_and_zero_at_the_lattice(void **state)
{
    (void)state;
    pv_noise_cell kept = { 0 };
    pv_lattice waves = pv_lattice_of(1024, 0);
    int32_t least = 0, most = 0, before = pv_noise(&kept, 9, &waves, &waves, -5000, 777);
    for (int32_t x = -4990; x < 90000; x += 10) {
        pv_noise_cell fresh = { 0 };
        int32_t v = pv_noise(&kept, 9, &waves, &waves, x, 777);
        assert_int_equal(v, pv_noise(&fresh, 9, &waves, &waves, x, 777));
        assert_true(abs(v - before) < 3000);
        before = v;
        least = v < least ? v : least;
        most = v > most ? v : most;
        assert_int_equal(pv_noise(&fresh, 9, &waves, &waves, x / 10 * 1024, 2048), 0);
    }
    assert_true(least < -30000 && least >= -65536);
    assert_true(most > 30000 && most <= 65536);
}

static void numbers_survive_text_in_every_locale(void **state)
{
    (void)state;
    static const double values[] = { 0, 0.1, 4.5, -3e-7, 1e300, 123456.789, 1.0 / 3 };
    static const char *const locales[] = { "C", "de_DE.UTF-8", "pt_BR.UTF-8", "fa_IR.UTF-8" };
    for (size_t l = 0; l < sizeof locales / sizeof *locales; l++) {
        setlocale(LC_ALL, locales[l]);
        for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
            char text[32];
            double back = -1;
            pv_text_number(text, sizeof text, values[i]);
            assert_null(strchr(text, ','));
            assert_true(pv_parse_number(text, &back));
            assert_true(back == values[i]);
        }
    }
    setlocale(LC_ALL, "C");
    double number;
    assert_false(pv_parse_number("", &number));
    assert_false(pv_parse_number("4,5", &number));
    assert_false(pv_parse_number("4 ", &number));
    assert_false(pv_parse_number("nan", &number));
    assert_false(pv_parse_number("1e999", &number));
}

static void whole_numbers_are_parsed_to_the_last_one(void **state)
{
    (void)state;
    uint64_t v;
    assert_true(pv_parse_whole("18446744073709551615", &v));
    assert_true(v == UINT64_MAX);
    assert_false(pv_parse_whole("18446744073709551616", &v));
    assert_false(pv_parse_whole("-1", &v));
    assert_false(pv_parse_whole("", &v));
}

static void thousandths_are_exact(void **state)
{
    (void)state;
    static const struct {
        int64_t value;
        const char *text;
    } known[] = { { 0, "0" },        { 5, "0.005" },   { 50, "0.05" },    { -50, "-0.05" },
                  { 1000, "1" },     { 12300, "12.3" }, { 12345, "12.345" }, { 1048576000, "1048576" } };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        char text[32];
        assert_int_equal(pv_text_thousandths(text, known[i].value), strlen(known[i].text));
        assert_string_equal(text, known[i].text);
    }
}

static void halves_are_read(void **state)
{
    (void)state;
    assert_true(pv_half_value(0x3c00) == 1.0f);
    assert_true(pv_half_value(0xc000) == -2.0f);
    assert_true(pv_half_value(0x0001) == 0x1p-24f);
    assert_true(pv_half_value(0x7bff) == 65504.0f);
    assert_true(isinf(pv_half_value(0x7c00)));
    assert_true(isnan(pv_half_value(0x7e00)));
}

static void corner_widths_grow_with_the_angle(void **state)
{
    (void)state;
    double before = -2;
    for (int degrees = 1; degrees < 360; degrees++) {
        double a = degrees * (3.14159265358979323846 / 180);
        /* seen with y down, the ring turns left at b: from the direction `a` to the positive x axis */
        double w = pv_corner_width(cos(a), -sin(a), 0, 0, 1, 0);
        assert_true(w > before);
        if (degrees <= 180)
            assert_true(fabs(w - pv_width_of_degrees(degrees)) < 1e-4);
        before = w;
    }
}

static void rings_are_judged_exactly(void **state)
{
    (void)state;
    pv_cell square[] = { { 0, 0 }, { 0, 10 }, { 10, 10 }, { 10, 0 } };
    pv_cell inverted[] = { { 0, 0 }, { 10, 0 }, { 10, 10 }, { 0, 10 } };
    pv_cell bow[] = { { 0, 0 }, { 0, 10 }, { 10, 0 }, { 10, 11 } };
    pv_cell spike[] = { { 0, 0 }, { 0, 10 }, { 10, 10 }, { 20, 10 }, { 10, 10 }, { 10, 0 } };
    pv_cell touch[] = { { 0, 0 }, { 0, 10 }, { 5, 0 }, { 10, 10 }, { 10, 0 } };
    assert_int_equal(pv_ring_area(square, 4), 200);
    assert_true(pv_ring_valid(square, 4));
    assert_false(pv_ring_valid(inverted, 4));
    assert_false(pv_ring_valid(bow, 4));
    assert_false(pv_ring_valid(spike, 6));
    assert_false(pv_ring_valid(touch, 5));
    assert_false(pv_ring_valid(square, 2));
}

static void hulls_are_valid_and_hold_their_points(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < 500; k++) {
        pv_cell points[20], hull[21];
        int32_t count = 3 + (int32_t)(k % 17);
        for (int32_t i = 0; i < count; i++) {
            pv_random r = pv_draw(k, 77, (uint32_t)i, 0, 0);
            points[i] = (pv_cell){ (int32_t)pv_below(r.word[0], 30), (int32_t)pv_below(r.word[1], 30) };
        }
        int32_t n = pv_convex_hull(points, count, hull);
        if (n < 3)
            continue;
        assert_true(pv_ring_valid(hull, n));
        for (int32_t i = 0; i < count; i++)
            for (int32_t j = 0; j < n; j++) {
                pv_cell side[3] = { hull[j], hull[(j + 1) % n], points[i] };
                assert_true(pv_ring_area(side, 3) >= 0);
            }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(philox_gives_its_published_answers),
        cmocka_unit_test(square_roots_are_floored),
        cmocka_unit_test(turns_are_on_the_unit_circle),
        cmocka_unit_test(floor_division_rounds_down),
        cmocka_unit_test(noise_is_smooth_bounded_and_zero_at_the_lattice),
        cmocka_unit_test(numbers_survive_text_in_every_locale),
        cmocka_unit_test(whole_numbers_are_parsed_to_the_last_one),
        cmocka_unit_test(thousandths_are_exact),
        cmocka_unit_test(halves_are_read),
        cmocka_unit_test(corner_widths_grow_with_the_angle),
        cmocka_unit_test(rings_are_judged_exactly),
        cmocka_unit_test(hulls_are_valid_and_hold_their_points),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
