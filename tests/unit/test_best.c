/* Best mode: whatever the drawing, stones that hold; thin lines, slivers, no bias towards the axes. */
#include "test.h"

#include "stones/measure.h"
#include "util/polygon.h"
#include "util/random.h"

#include <math.h>

enum { MOST_SIDE = 48, CASES = SANITIZED ? 250 : 2000 };

static pave_image *make_drawing(pave_context *context, int32_t width, int32_t height, const uint8_t *pixels)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    params.width = width;
    params.height = height;
    assert_ok(pave_image_create(context, &params, pixels, &image));
    return image;
}

typedef struct dice {
    uint64_t seed;
    uint32_t thrown;
} dice;

static int32_t throw_dice(dice *d, int32_t sides)
{
    return (int32_t)pv_below(pv_draw(d->seed, PV_DRAW_SITES, 77, d->thrown++, 0).word[0], (uint32_t)sides);
}

enum { BLANK, CHECKER, NOISE, ISLANDS, SPIRAL, STRIPES, BLOBS, KINDS };

static int32_t pixel_of(int kind, int32_t x, int32_t y, int32_t width, int32_t height, int32_t size, dice *d)
{
    int32_t dx = abs(2 * x - width), dy = abs(2 * y - height);
    switch (kind) {
    case BLANK: return 0;
    case CHECKER: return x / size + y / size;
    case NOISE: return throw_dice(d, 8);
    case ISLANDS: return throw_dice(d, 9) ? 0 : 1 + throw_dice(d, 7);
    case SPIRAL: return (dx > dy ? dx : dy) / (2 * size) + (x > width / 2);
    case STRIPES: return (x + 2 * y) / size;
    default: return (int32_t)(4 + 3 * sin(0.31 * x + 0.2 * size) + 3 * cos(0.23 * y * size)); /* NOLINT */
    }
}

/* A small drawing of any kind, in two to eight colours. */
static pave_image *random_drawing(pave_context *context, dice *d)
{
    uint8_t pixels[MOST_SIDE * MOST_SIDE];
    int kind = throw_dice(d, KINDS);
    int32_t colours = 2 + throw_dice(d, 7) * throw_dice(d, 2), size = 1 + throw_dice(d, 5);
    int32_t width = 1 + throw_dice(d, MOST_SIDE), height = 1 + throw_dice(d, MOST_SIDE);
    if (!throw_dice(d, 8))
        height = 1;
    if (!throw_dice(d, 8))
        width = 1;
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++)
            pixels[y * width + x] = (uint8_t)(pixel_of(kind, x, y, width, height, size, d) % colours);
    return make_drawing(context, width, height, pixels);
}

static void assert_holds(pave_context *context, const pave_image *drawing, const pave_stones *stones, uint64_t seed)
{
    pave_stones_measures m = { .size = sizeof m };
    for (int32_t s = 0; s < pave_stones_count(stones); s++) {
        pv_cell ring[512];
        int64_t first = pave_stones_starts(stones)[s], count = pave_stones_starts(stones)[s + 1] - first;
        assert_in_range(count, 3, 512);
        for (int64_t i = 0; i < count; i++) {
            const double *p = pave_stones_vertices(stones) + 2 * (first + i);
            assert_true(p[0] >= 0 && p[0] <= pave_stones_width(stones));
            assert_true(p[1] >= 0 && p[1] <= pave_stones_height(stones));
            ring[i] = (pv_cell){ (int32_t)lround(p[0] * 1000), (int32_t)lround(p[1] * 1000) };
        }
        assert_true(pv_ring_valid(ring, (int32_t)count)); /* simple, and counter-clockwise */
    }
    pave_stones_measure_params params = PAVE_STONES_MEASURE_PARAMS_INIT;
    pv_survey survey;
    assert_ok(pv_survey_make(context, drawing, stones, &params, &survey, &m.clockwise));
    assert_ok(pv_measure_shapes(context, &survey, &m));
    assert_ok(pv_measure_overlap(context, &survey, &m));
    pv_survey_free(&survey);
    if (m.invalid || m.overlapping || m.overlap > 0)
        fail_msg("seed %d: %d invalid, %d overlap, by %g of the area", (int)seed, (int)m.invalid, (int)m.overlapping,
                 m.overlap);
}

static void whatever_the_drawing_stones_hold(void **state)
{
    (void)state;
    not_for_threads();
    pave_context *context = make_context(1, PAVE_BACKEND_CPU);
    static const double half_sides[] = { 1, 1.3, 2, 2.5, 4, 7, 60 }, grouts[] = { 0, 0, 0.5, 1, 3 };
    for (uint64_t seed = 1; seed <= CASES; seed++) {
        dice d = { seed, 0 };
        pave_image *drawing = random_drawing(context, &d);
        pave_field_params field_params = PAVE_FIELD_PARAMS_INIT;
        pave_cvd_params cvd_params = PAVE_CVD_PARAMS_INIT;
        pave_stones_params params = PAVE_STONES_PARAMS_INIT;
        pave_field *field = NULL;
        pave_cvd *cvd = NULL;
        pave_stones *stones = NULL;
        field_params.periodic = !throw_dice(&d, 24);
        cvd_params.half_side = half_sides[throw_dice(&d, 7)];
        cvd_params.seed = seed;
        cvd_params.iterations = throw_dice(&d, 6);
        cvd_params.supersample = 1 + throw_dice(&d, 3);
        params.mode = PAVE_MODE_BEST;
        params.grout = grouts[throw_dice(&d, 5)];
        params.joint_style = throw_dice(&d, 2);
        params.thin = throw_dice(&d, 2);
        params.aspect = throw_dice(&d, 3) ? 4 : 0;
        int32_t width = pave_image_width(drawing), height = pave_image_height(drawing);
        if (2 * cvd_params.half_side > (width < height ? width : height) || cvd_params.half_side > 2)
            field_params.periodic = 0;
        if (field_params.periodic) {
            pave_lay_params lay = PAVE_LAY_PARAMS_INIT;
            lay.field = &field_params, lay.cvd = &cvd_params, lay.stones = &params;
            params.border = PAVE_BORDER_CUT;
            if (pave_lay(context, drawing, &lay, &stones))
                fail_msg("seed %d: %s", (int)seed, pave_context_message(context));
        } else {
            pv_tess tess;
            assert_ok(pave_field_create(context, drawing, &field_params, &field));
            assert_ok(pave_cvd_create(context, field, &cvd_params, &cvd));
            assert_ok(pv_best_tess(context, drawing, cvd, &params, &tess));
            if (pv_tess_check(context, &tess))
                fail_msg("seed %d: %s", (int)seed, pave_context_message(context));
            pv_tess_free(&tess);
            assert_ok(pave_stones_create(context, drawing, field, cvd, &params, &stones));
        }
        assert_holds(context, drawing, stones, seed);
        pave_stones_free(&stones);
        pave_cvd_free(&cvd);
        pave_field_free(&field);
        pave_image_free(&drawing);
    }
    pave_context_free(&context);
}

static pave_stones *lay(pave_context *context, const pave_image *drawing, double half_side, int32_t supersample,
                        const pave_stones_params *given)
{
    pave_cvd_params cvd = PAVE_CVD_PARAMS_INIT;
    pave_stones_params stones_params = *given;
    pave_lay_params params = PAVE_LAY_PARAMS_INIT;
    pave_stones *stones = NULL;
    cvd.half_side = half_side;
    cvd.supersample = supersample;
    stones_params.mode = PAVE_MODE_BEST;
    params.cvd = &cvd;
    params.stones = &stones_params;
    assert_ok(pave_lay(context, drawing, &params, &stones));
    return stones;
}

/* Numbers the connected sets of pixels of one colour, and counts their pixels. */
static int32_t find_features(const pave_image *drawing, int32_t *feature, int32_t *pixels)
{
    int32_t width = pave_image_width(drawing), height = pave_image_height(drawing), count = 0;
    const uint8_t *colour = pave_image_pixels(drawing);
    int32_t todo[MOST_SIDE * MOST_SIDE];
    for (int32_t i = 0; i < width * height; i++)
        feature[i] = -1;
    for (int32_t i = 0; i < width * height; i++) {
        int32_t waiting = 0;
        if (feature[i] >= 0)
            continue;
        feature[i] = count;
        pixels[count] = 0;
        for (todo[waiting++] = i; waiting;) {
            int32_t at = todo[--waiting], x = at % width, y = at / width;
            const int32_t next[4] = { x ? at - 1 : at, x < width - 1 ? at + 1 : at, y ? at - width : at,
                                      y < height - 1 ? at + width : at };
            pixels[count]++;
            for (int k = 0; k < 4; k++)
                if (feature[next[k]] < 0 && colour[next[k]] == colour[i]) {
                    feature[next[k]] = count;
                    todo[waiting++] = next[k];
                }
        }
        count++;
    }
    return count;
}

static int covers(const double *ring, int64_t count, double x, double y)
{
    int inside = 0;
    for (int64_t i = 0; i < count; i++) {
        const double *a = ring + 2 * i, *b = ring + 2 * ((i + 1) % count);
        if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
            inside = !inside;
    }
    return inside;
}

/* Takes from each feature what its stones cover of it. */
static void take_covered(const pave_image *drawing, const pave_stones *stones, const int32_t *feature, int32_t *bare)
{
    int32_t width = pave_image_width(drawing), height = pave_image_height(drawing);
    const uint8_t *colour = pave_image_pixels(drawing);
    for (int32_t s = 0; s < pave_stones_count(stones); s++) {
        int64_t first = pave_stones_starts(stones)[s], count = pave_stones_starts(stones)[s + 1] - first;
        const double *ring = pave_stones_vertices(stones) + 2 * first;
        for (int32_t i = 0; i < width * height; i++)
            if (colour[i] == pave_stones_colours(stones)[s] && covers(ring, count, i % width + 0.5, i / width + 0.5))
                bare[feature[i]]--;
    }
}

/* No site may lie in a feature, but stones do: cells are split by colour, and what is no sliver becomes a stone. */
static void every_feature_has_stones(void **state)
{
    (void)state;
    not_for_threads();
    static const double half_sides[] = { 2, 2.5, 3, 4 };
    static int32_t feature[MOST_SIDE * MOST_SIDE], pixels[MOST_SIDE * MOST_SIDE], bare[MOST_SIDE * MOST_SIDE];
    pave_context *context = make_context(1, PAVE_BACKEND_CPU);
    int32_t features = 0, stoneless = 0, covered = 0, area = 0;
    for (uint64_t seed = 1; seed <= CASES / 10; seed++) {
        dice d = { seed, 0 };
        double h = half_sides[seed % 4];
        pave_stones_params params = PAVE_STONES_PARAMS_INIT;
        pave_image *image = random_drawing(context, &d);
        pave_stones *stones = NULL;
        pave_field *field = NULL;
        pave_cvd *cvd = NULL;
        pave_cvd_params cvd_params = PAVE_CVD_PARAMS_INIT;
        params.mode = PAVE_MODE_BEST;
        params.grout = 0;
        cvd_params.half_side = h;
        cvd_params.supersample = 2;
        cvd_params.iterations = 6;
        assert_ok(pave_field_create(context, image, NULL, &field));
        assert_ok(pave_cvd_create(context, field, &cvd_params, &cvd));
        assert_ok(pave_stones_create(context, image, field, cvd, &params, &stones));
        int32_t count = find_features(image, feature, pixels);
        memcpy(bare, pixels, sizeof bare);
        take_covered(image, stones, feature, bare);
        for (int32_t f = 0; f < count; f++) {
            if (pixels[f] < h * h)
                continue;
            features++;
            stoneless += bare[f] == pixels[f];
            covered += pixels[f] - bare[f];
            area += pixels[f];
        }
        pave_stones_free(&stones);
        pave_cvd_free(&cvd);
        pave_field_free(&field);
        pave_image_free(&image);
    }
    print_message("  %d features, %d without a stone; %.2f %% of their pixels under stones of their colour\n", features,
                  stoneless, 100.0 * covered / area);
    assert_true(features > CASES / 10 && 100 * (int64_t)covered > 96 * (int64_t)area);
    assert_int_equal(stoneless, 0);
    pave_context_free(&context);
}

static void a_long_strip_is_laid(void **state)
{
    enum { LENGTH = SANITIZED ? 5000 : 100000 };
    uint8_t *pixels = malloc(LENGTH);
    for (int32_t i = 0; i < LENGTH; i++)
        pixels[i] = i / 7 % 3 ? 255 : 0;
    pave_stones_params params = PAVE_STONES_PARAMS_INIT;
    params.grout = 0;
    for (int upright = 0; upright < 2; upright++) {
        pave_image *drawing = make_drawing(*state, upright ? 1 : LENGTH, upright ? LENGTH : 1, pixels);
        pave_stones *stones = lay(*state, drawing, 4, 0, &params);
        assert_in_range(pave_stones_count(stones), LENGTH / 21, LENGTH);
        assert_holds(*state, drawing, stones, 0);
        pave_stones_free(&stones);
        pave_image_free(&drawing);
    }
    free(pixels);
}

static int is_in(const double *v, int64_t count, double x, double y)
{
    int in = 0;
    for (int64_t i = 0, j = count - 1; i < count; j = i++)
        if ((v[2 * i + 1] > y) != (v[2 * j + 1] > y) &&
            x < v[2 * i] + (v[2 * j] - v[2 * i]) * (y - v[2 * i + 1]) / (v[2 * j + 1] - v[2 * i + 1]))
            in ^= 1;
    return in;
}

enum { LINES = 4, WIDTH = 420, HEIGHT = 240 };
static const int line_width[LINES] = { 10, 6, 4, 2 };

static int line_of(int32_t x, int32_t y, double slant)
{
    for (int k = 0; k < LINES; k++)
        if (fabs(y + 0.5 - 30 - 60 * k - slant * (x - WIDTH / 2)) < line_width[k] * sqrt(1 + slant * slant) / 2)
            return k;
    return -1;
}

static pave_image *draw_lines(pave_context *context, double slant)
{
    uint8_t *pixels = malloc(WIDTH * HEIGHT);
    for (int32_t i = 0; i < WIDTH * HEIGHT; i++)
        pixels[i] = line_of(i % WIDTH, i / WIDTH, slant) >= 0 ? 0 : 255;
    pave_image *drawing = make_drawing(context, WIDTH, HEIGHT, pixels);
    free(pixels);
    return drawing;
}

/* How much of each line lies under black stones. */
static void measure_lines(const pave_stones *stones, double slant, double kept[LINES])
{
    double all[LINES] = { 0 }, black[LINES] = { 0 };
    uint8_t *under = calloc(WIDTH * HEIGHT, 1);
    for (int32_t s = 0; s < pave_stones_count(stones); s++) {
        int64_t first = pave_stones_starts(stones)[s], count = pave_stones_starts(stones)[s + 1] - first;
        const double *v = pave_stones_vertices(stones) + 2 * first;
        for (int32_t y = (int32_t)v[1] - 40; y < v[1] + 40 && !pave_stones_colours(stones)[s]; y++)
            for (int32_t x = (int32_t)v[0] - 40; x < v[0] + 40; x++)
                if (x >= 0 && y >= 0 && x < WIDTH && y < HEIGHT && is_in(v, count, x + 0.5, y + 0.5))
                    under[y * WIDTH + x] = 1;
    }
    for (int32_t i = 0; i < WIDTH * HEIGHT; i++) {
        int k = line_of(i % WIDTH, i / WIDTH, slant);
        if (k >= 0)
            all[k]++, black[k] += under[i];
    }
    for (int k = 0; k < LINES; k++)
        kept[k] = black[k] / all[k];
    free(under);
}

static void thin_lines_stay(void **state)
{
    static const double slants[] = { 0, 0.21 };
    static const double least[2][LINES] = { { 0.99, 0.99, 0.99, 0.98 }, { 0.99, 0.98, 0.98, 0.95 } };
    for (int i = 0; i < 2; i++)
        for (int thin = 0; thin < 3; thin += 2) {
            double kept[LINES];
            pave_stones_params params = PAVE_STONES_PARAMS_INIT;
            params.grout = 0;
            params.thin = thin;
            pave_image *drawing = draw_lines(*state, slants[i]);
            pave_stones *stones = lay(*state, drawing, 4, 0, &params);
            measure_lines(stones, slants[i], kept);
            print_message("  slant %.2f, %s: 10, 6, 4, 2 px keep %.2f %.2f %.2f %.2f %%\n", slants[i],
                          thin ? "widened" : "kept", 100 * kept[0], 100 * kept[1], 100 * kept[2], 100 * kept[3]);
            for (int k = 0; k < LINES; k++)
                assert_true(kept[k] >= least[i][k]);
            pave_stones_free(&stones);
            pave_image_free(&drawing);
        }
}

static void thin_spots_can_be_dropped(void **state)
{
    pave_stones_params params = PAVE_STONES_PARAMS_INIT;
    params.thin = PAVE_THIN_DROP;
    params.grout = 0;
    static const char *const speck[] = {
        "................", "................", "................", "................", "................",
        "................", "................", ".......#........", "................", "................",
        "................", "................", "................", "................", "................",
    };
    pave_image *drawing = draw_text(*state, speck, 15);
    pave_stones *stones = lay(*state, drawing, 4, 0, &params);
    for (int32_t s = 0; s < pave_stones_count(stones); s++)
        assert_int_equal(pave_stones_colours(stones)[s], 255);
    pave_stones_free(&stones);
    pave_image_free(&drawing);
}

static int32_t black_in_column(const pave_image *drawing, int32_t x, int32_t from, int32_t to)
{
    const uint8_t *pixels = pave_image_pixels(drawing);
    int32_t count = 0;
    for (int32_t y = from; y < to; y++)
        count += !pixels[y * pave_image_width(drawing) + x];
    return count;
}

static void thin_features_are_widened_and_no_others(void **state)
{
    pave_image *drawing = draw_lines(*state, 0), *wide = NULL;
    assert_ok(pave_image_widen(*state, drawing, 6, 0, &wide));
    for (int32_t x = 0; x < WIDTH; x++)
        for (int k = 0; k < LINES; k++)
            assert_int_equal(black_in_column(wide, x, 60 * k, 60 * k + 60), line_width[k] < 6 ? 6 : line_width[k]);
    pave_image_free(&wide);
    assert_int_equal(pave_image_widen(*state, drawing, 201, 0, &wide), PAVE_ERR_ARGUMENT);
    assert_null(wide);
    pave_image_free(&drawing);
    uint8_t square[60 * 60]; /* with its corners; and a dot that grows */
    for (int32_t i = 0; i < 60 * 60; i++)
        square[i] = i % 60 >= 10 && i % 60 < 40 && i / 60 >= 10 && i / 60 < 40 ? 0 : i == 50 * 60 + 50 ? 0 : 255;
    drawing = make_drawing(*state, 60, 60, square);
    assert_ok(pave_image_widen(*state, drawing, 5, 0, &wide));
    const uint8_t *pixels = pave_image_pixels(wide);
    for (int32_t i = 0; i < 45 * 60; i++)
        assert_int_equal(pixels[i], square[i]);
    assert_int_equal(black_in_column(wide, 50, 45, 60), 5);
    pave_image_free(&wide);
    pave_image_free(&drawing);
}

/* Extent along the longest side over that across it. What lies on sharp tips stays long. */
static double aspect_of(const pave_stones *stones, int32_t s, double *area)
{
    int64_t first = pave_stones_starts(stones)[s], count = pave_stones_starts(stones)[s + 1] - first;
    const double *v = pave_stones_vertices(stones) + 2 * first;
    double longest = *area = 0, x = 1, y = 0, low[2] = { 1e9, 1e9 }, high[2] = { -1e9, -1e9 };
    for (int64_t i = 0; i < count; i++) {
        const double *a = v + 2 * i, *b = v + 2 * ((i + 1) % count);
        double dx = b[0] - a[0], dy = b[1] - a[1], length = sqrt(dx * dx + dy * dy);
        if (length > longest)
            longest = length, x = dx / length, y = dy / length;
        *area += (b[0] * a[1] - a[0] * b[1]) / 2;
    }
    for (int64_t i = 0; i < count; i++) {
        double along = v[2 * i] * x + v[2 * i + 1] * y, across = v[2 * i + 1] * x - v[2 * i] * y;
        low[0] = fmin(low[0], along), high[0] = fmax(high[0], along);
        low[1] = fmin(low[1], across), high[1] = fmax(high[1], across);
    }
    return (high[0] - low[0]) / (high[1] - low[1]);
}

static void slivers_are_cut_across(void **state)
{
    double slivers[2] = { 0, 0 };
    pave_image *drawing = draw_lines(*state, 0.1);
    for (int cut = 0; cut < 2; cut++) {
        pave_stones_params params = PAVE_STONES_PARAMS_INIT;
        params.grout = 0;
        params.aspect = cut ? 3 : 0;
        pave_stones *stones = lay(*state, drawing, 4, 0, &params);
        assert_holds(*state, drawing, stones, 0);
        for (int32_t s = 0; s < pave_stones_count(stones); s++) {
            double area, aspect = aspect_of(stones, s, &area);
            slivers[cut] += aspect > 4 ? area : 0;
        }
        pave_stones_free(&stones);
    }
    print_message("  longer than 4 widths: %.0f px^2, %.0f where 3 is the limit\n", slivers[0], slivers[1]);
    assert_true(slivers[0] > 200 && 8 * slivers[1] < slivers[0]);
    pave_image_free(&drawing);
}

static void stones_lie_as_they_like(void **state)
{
    enum { SIDE = SANITIZED ? 256 : 1024 };
    pave_stones_params params = PAVE_STONES_PARAMS_INIT;
    uint8_t *white = malloc(SIDE * SIDE);
    memset(white, 255, SIDE * SIDE);
    params.grout = 0;
    pave_image *drawing = make_drawing(*state, SIDE, SIDE, white);
    double bias[2];
    for (int k = 0; k < 2; k++) {
        pave_stones_measures m = { .size = sizeof m };
        pave_stones *stones = lay(*state, drawing, 4, k ? 0 : 1, &params);
        assert_ok(pave_stones_measure(*state, drawing, stones, NULL, &m));
        bias[k] = m.axis_bias;
        assert_true(m.quads > 0.98);
        pave_stones_free(&stones);
    }
    print_message("  R4 on a blank drawing: %.3f, on the drawing's own pixels %.3f\n", bias[1], bias[0]);
    assert_true(SANITIZED || (bias[1] <= 0.10 && bias[0] > 1.5 * bias[1]));
    pave_image_free(&drawing);
    free(white);
}

static void small_stones_are_stones_too(void **state)
{
    pave_stones_params params = PAVE_STONES_PARAMS_INIT;
    pave_stones_measures m = { .size = sizeof m };
    params.grout = 0;
    pave_image *drawing = draw_shapes(*state, 300, 260);
    pave_stones *stones = lay(*state, drawing, 2.5, 0, &params);
    assert_ok(pave_stones_measure(*state, drawing, stones, NULL, &m));
    assert_holds(*state, drawing, stones, 0);
    assert_true(m.quads > 0.98 && m.mismatch < 0.001 && m.near_mean < 12);
    pave_stones_free(&stones);
    pave_image_free(&drawing);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whatever_the_drawing_stones_hold),
        cmocka_unit_test(every_feature_has_stones),
        cmocka_unit_test(a_long_strip_is_laid),
        cmocka_unit_test(thin_lines_stay),
        cmocka_unit_test(thin_spots_can_be_dropped),
        cmocka_unit_test(thin_features_are_widened_and_no_others),
        cmocka_unit_test(slivers_are_cut_across),
        cmocka_unit_test(stones_lie_as_they_like),
        cmocka_unit_test(small_stones_are_stones_too),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
