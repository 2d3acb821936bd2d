/* tiling's parts: cuts in bands against the least cut, places on a raster, and measures of pictures whose figures are
 * known beforehand. */
#include "test.h"

#include "tiling/best.h"
#include "image/fft.h"

#include <math.h>

enum { WIDTH = 37, HEIGHT = 30, NODES = WIDTH * HEIGHT };

static uint32_t draw(uint32_t key, int32_t i, uint32_t what)
{
    return pv_draw(key, 97, (uint32_t)i, what, 0).word[0];
}

/* Nodes that are drawn to either side in patches, as a copy is by what is around it. */
static void fill_flow(pv_flow *flow, uint32_t key)
{
    pv_flow_begin(flow, WIDTH, HEIGHT);
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++) {
            pv_node *node = &flow->node[pv_flow_node(flow, x, y)];
            int32_t i = y * WIDTH + x, border = x == 0 || y == 0 || x + 1 == WIDTH || y + 1 == HEIGHT;
            int32_t patch = (int32_t)(draw(key, y / 6 * WIDTH + x / 6, 1) % 61) - 30;
            node->terminal = border ? -40 : patch + (int32_t)(draw(key, i, 2) % 21) - 10;
            for (int way = 0; way < 2; way++)
                if (way ? y + 1 < HEIGHT : x + 1 < WIDTH)
                    (node + flow->step[way])->capacity[way ^ 2] = node->capacity[way] = (int32_t)(draw(key, i, 3) % 50);
        }
}

/* What a set of nodes gains: its terminals, less the arcs that leave it. */
static int64_t gain_of(const pv_flow *flow, const uint8_t *taken)
{
    int64_t gain = 0;
    for (int32_t i = 0; i < NODES; i++) {
        int32_t x = i % WIDTH, y = i / WIDTH;
        const pv_node *node = &flow->node[pv_flow_node(flow, x, y)];
        if (!taken[i])
            continue;
        gain += node->terminal;
        gain -= x + 1 < WIDTH && !taken[i + 1] ? node->capacity[PV_RIGHT] : 0;
        gain -= x > 0 && !taken[i - 1] ? node->capacity[PV_LEFT] : 0;
        gain -= y + 1 < HEIGHT && !taken[i + WIDTH] ? node->capacity[PV_DOWN] : 0;
        gain -= y > 0 && !taken[i - WIDTH] ? node->capacity[PV_UP] : 0;
    }
    return gain;
}

/* The gain told is that of the pixels taken, never more than the least cut's, and in all nearly as much. */
static void bands_gain_nearly_as_much(void **state)
{
    pv_cut cut;
    pv_flow same;
    uint8_t taken[NODES];
    int64_t all = 0, most = 0;
    assert_ok(pv_cut_create(*state, WIDTH, HEIGHT, &cut));
    assert_ok(pv_flow_create(*state, WIDTH, HEIGHT, &same));
    for (uint32_t key = 0; key < 40; key++) {
        int64_t gain, least = 0;
        fill_flow(&cut.flow, key);
        assert_true(pv_band_find(&cut, &gain));
        fill_flow(&same, key);
        for (int32_t i = 0; i < NODES; i++) {
            int32_t node = pv_flow_node(&cut.flow, i % WIDTH, i / WIDTH), left = cut.flow.node[node].terminal;
            taken[i] = (uint8_t)pv_band_taken(&cut, i % WIDTH, i / WIDTH);
            gain += left > 0 ? left : 0;
        }
        assert_true(gain == gain_of(&same, taken) && gain >= 0);
        pv_flow_solve(&same);
        for (int32_t i = 0; i < NODES; i++)
            taken[i] = (uint8_t)pv_flow_chosen(&same, pv_flow_node(&same, i % WIDTH, i / WIDTH));
        fill_flow(&same, key);
        least = gain_of(&same, taken);
        assert_true(gain <= least);
        all += gain, most += least;
    }
    assert_true(most > 0 && (double)all > 0.85 * (double)most);
    pv_flow_free(&same);
    pv_cut_free(&cut);
}

/* A pixel that must be taken has no block to share its lot. */
static void a_must_is_no_band(void **state)
{
    pv_cut cut;
    int64_t gain;
    assert_ok(pv_cut_create(*state, WIDTH, HEIGHT, &cut));
    fill_flow(&cut.flow, 1);
    cut.flow.node[pv_flow_node(&cut.flow, 9, 9)].terminal = PV_MUST;
    assert_false(pv_band_find(&cut, &gain));
    fill_flow(&cut.flow, 1);
    cut.flow.node[pv_flow_node(&cut.flow, 9, 9)].terminal = -PV_MUST;
    assert_true(pv_band_find(&cut, &gain));
    assert_false(pv_band_taken(&cut, 9, 9));
    pv_cut_free(&cut);
}

static void even_places_are_an_even_way_off(void **state)
{
    const pv_sheet sheet = { .width = 40, .height = 31 };
    (void)state;
    for (int32_t k = 0; k < 4; k++) {
        pv_places all = pv_places_all(&sheet, 9, 6), even = pv_places_even(all, 13 + k % 2, 8 + k / 2);
        assert_true(even.step == 2 && even.across >= all.across / 2 && even.down >= all.down / 2);
        assert_int_equal((even.x - 13 - k % 2) & 1, 0);
        assert_int_equal((even.y - 8 - k / 2) & 1, 0);
        assert_true(even.x + 2 * (even.across - 1) < all.across && even.y + 2 * (even.down - 1) < all.down);
    }
    assert_int_equal(pv_places_even(pv_places_all(&sheet, 36, 6), 1, 1).step, 1); /* few: all of them */
}

static void set_all(float *rgb, int32_t n, float value)
{
    for (int32_t i = 0; i < 3 * n; i++)
        rgb[i] = value;
}

/* Pictures of one grey each, d apart: along a direction patches are d times its components' sum apart, in the mean
 * sqrt(2 / pi) d. */
static void the_sliced_distance_of_plain_pictures(void **state)
{
    static float a[32 * 24 * 3], b[32 * 24 * 3];
    pv_picture of_a = { 32, 24, a }, of_b = { 32, 24, b };
    double distance, twice;
    set_all(a, 32 * 24, 100);
    set_all(b, 32 * 24, 100);
    assert_ok(pv_sliced_distance(*state, &of_a, &of_b, &distance));
    assert_true(distance == 0);
    set_all(b, 32 * 24, 110);
    assert_ok(pv_sliced_distance(*state, &of_a, &of_b, &distance));
    assert_true(distance > 6 && distance < 10);
    set_all(b, 32 * 24, 120);
    assert_ok(pv_sliced_distance(*state, &of_a, &of_b, &twice));
    assert_true(fabs(twice - 2 * distance) < 1e-3 * twice);
}

/* Noise of 128 x 128 px; `streak` neighbours in a row have the mean of what they cover; x repeats after `period`. */
static void make_noise(float *rgb, int32_t streak, int32_t period)
{
    for (int32_t i = 0; i < 128 * 128; i++) {
        double sum = 0;
        for (int32_t k = 0; k < streak; k++)
            sum += draw(7, i / 128 * 128 + (i % 128 + k) % period, 5) % 256 / (double)streak;
        for (int32_t c = 0; c < 3; c++)
            rgb[3 * i + c] = (float)sum;
    }
}

/* What repeats shows as a peak; streaks, whose flanks are high at 16 px too, do not. */
static void flanks_are_no_peaks(void **state)
{
    static float rgb[128 * 128 * 3];
    double repeat;
    make_noise(rgb, 1, 128);
    assert_ok(pv_fft_repeat(*state, rgb, 128, 128, &repeat));
    assert_true(repeat < 0.1);
    make_noise(rgb, 1, 64);
    assert_ok(pv_fft_repeat(*state, rgb, 128, 128, &repeat));
    assert_true(repeat > 0.95);
    make_noise(rgb, 40, 128);
    assert_ok(pv_fft_repeat(*state, rgb, 128, 128, &repeat));
    assert_true(repeat < 0.3); /* at 17 px it is about 0.5 */
}

/* Cells of 16 px with dark lines between; of every `open`-th row of cells the upright lines are left out. */
static int encloses(pave_context *context, int32_t open, int32_t noise)
{
    enum { SIDE = 96, CELL = 16 };
    int16_t bright[SIDE * SIDE];
    pv_joints joints;
    for (int32_t i = 0; i < SIDE * SIDE; i++) {
        int32_t x = i % SIDE, y = i / SIDE;
        int across = y % CELL < 2, up = (x + y / CELL * 5) % CELL < 2 && (!open || y / CELL % open);
        bright[i] = (int16_t)(noise ? (int32_t)(draw(7, i, 0) % 200) : (across && !open) || up ? 20 : 150 + x % 3);
    }
    pv_grey grey = { SIDE, SIDE, SIDE, 255, bright };
    assert_ok(pv_joints_find(context, &grey, &joints));
    int result = joints.enclose;
    pv_joints_free(&joints);
    return result;
}

static void joints_enclose_or_not(void **state)
{
    assert_true(encloses(*state, 0, 0));
    assert_false(encloses(*state, 2, 0));
    assert_false(encloses(*state, 0, 1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bands_gain_nearly_as_much),
        cmocka_unit_test(a_must_is_no_band),
        cmocka_unit_test(even_places_are_an_even_way_off),
        cmocka_unit_test(the_sliced_distance_of_plain_pictures),
        cmocka_unit_test(flanks_are_no_peaks),
        cmocka_unit_test(joints_enclose_or_not),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
