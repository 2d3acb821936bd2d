/* Whole materials from a small region and a few photographs: the parts against their definitions, and what comes out. */
#include "failing.h"

#include "btf/windows.h"
#include "image/image.h"

#include <math.h>

enum { DIRECTIONS = 7, PAIRS = DIRECTIONS * DIRECTIONS };
enum { SAMPLE = SANITIZED ? 16 : 24, WHOLE = SANITIZED ? 24 : 40, LEFT = SANITIZED ? 4 : 8 };

/* Figures need their sizes. */
#define assert_figure(claim) assert_true(SANITIZED || (claim))

static void needs_algebra(pave_context *context)
{
    pv_algebra algebra;
    if (pv_algebra_open(context, &algebra))
        skip();
    else
        pv_algebra_close(&algebra);
}

static float chance(uint32_t a, uint32_t b)
{
    uint32_t x = a * 0x9E3779B1u ^ b * 0x85EBCA77u;
    x = (x ^ x >> 15) * 0x2C1B3C6Du;
    x = (x ^ x >> 12) * 0x297A2D39u;
    return (float)((x ^ x >> 15) >> 8) * 0x1p-24f - 0.5f;
}

/* ---- Materials: two smooth patterns, which light and view bring out in their own ways ---- */

static pave_btf *frame(pave_context *context, int32_t side, int32_t channels)
{
    pave_direction d[81];
    pave_btf *btf = NULL;
    pave_btf_params shape = PAVE_BTF_PARAMS_INIT;
    pave_directions(PAVE_DIRECTIONS_UBO81, d, 81);
    shape.width = shape.height = side;
    shape.channels = channels;
    shape.type = PAVE_F32;
    shape.views = shape.lights = DIRECTIONS;
    shape.view_directions = shape.light_directions = d;
    assert_ok(pave_btf_create(context, &shape, NULL, &btf));
    return btf;
}

static void pattern(int32_t x, int32_t y, float out[2])
{
    float u = (float)x, v = (float)y;
    out[0] = sinf(0.9f * u + 0.3f * sinf(0.5f * v)) * cosf(0.35f * v);
    out[1] = sinf(0.55f * v - 0.4f * u) + 0.3f * sinf(1.7f * u);
}

/* The part from (left, left) on. Hidden: what the top view under the top light does not show. */
static pave_btf *material(pave_context *context, int32_t side, int32_t left, int32_t channels)
{
    pave_btf *btf = frame(context, side, channels);
    for (int32_t t = 0; t < side * side; t++)
        for (int32_t p = 0; p < PAIRS; p++) {
            float of[2], samples[3], view = (float)(p / DIRECTIONS), light = (float)(p % DIRECTIONS);
            pattern(t % side + left, t / side + left, of);
            float log_y = -2 + (0.5f + 0.1f * light) * of[0] + 0.2f * view * of[1] + 0.05f * view * light * of[0] * of[1];
            for (int32_t c = 0; c < channels; c++)
                samples[c] = expf(log_y + 0.1f * (float)c * of[0]);
            pv_btf_put(btf, t, (int64_t)p * channels, channels, samples);
        }
    return btf;
}

static pave_btf_plan *plan_of(pave_context *context, const pave_btf *btf, int32_t count)
{
    int32_t views[PAIRS], lights[PAIRS];
    pave_btf_plan *plan = NULL;
    for (int32_t i = 0; i < count; i++) {
        views[i] = i * 18 % PAIRS / DIRECTIONS;
        lights[i] = i * 18 % PAIRS % DIRECTIONS;
    }
    assert_ok(pave_btf_plan_of_pairs(context, btf, views, lights, count, &plan));
    return plan;
}

static pave_btf_enlarge_params small_params(void)
{
    pave_btf_enlarge_params params = PAVE_BTF_ENLARGE_PARAMS_INIT;
    params.components = 8;
    params.chroma = 4;
    params.neighbourhood = 4;
    params.type = PAVE_F32;
    params.symmetric = 0;
    return params;
}

/* Root mean square error of logarithms, outside of the sample. */
static double error_of(const pave_btf *a, const pave_btf *b)
{
    double sum = 0;
    int64_t count = 0;
    for (int32_t t = 0; t < WHOLE * WHOLE; t++) {
        int32_t x = t % WHOLE - LEFT, y = t / WHOLE - LEFT;
        if (x >= 0 && x < SAMPLE && y >= 0 && y < SAMPLE)
            continue;
        for (int32_t p = 0; p < PAIRS; p++, count++) {
            float of_a[3], of_b[3];
            pv_btf_sample(a, t, p, of_a);
            pv_btf_sample(b, t, p, of_b);
            double apart = log(fmax((double)of_a[0], 1e-4)) - log(fmax((double)of_b[0], 1e-4));
            sum += apart * apart;
        }
    }
    return sqrt(sum / (double)count);
}

static double enlarge(pave_context *context, const pave_btf *sample, const pave_btf *truth, int32_t photographs,
                      pave_btf_enlarge_params params, pave_btf_enlargement *report)
{
    pave_btf_plan *plan = plan_of(context, truth, photographs);
    pave_btf *out = NULL;
    report->size = sizeof *report;
    assert_ok(pave_btf_enlarge(context, sample, truth, plan, NULL, &params, &out, report));
    assert_int_equal(pave_btf_width(out), WHOLE);
    assert_int_equal(report->photographs, photographs);
    double error = error_of(out, truth);
    pave_btf_free(&out);
    pave_btf_plan_free(&plan);
    return error;
}

/* ---- Parts ---- */

static pv_texels texels(pave_context *context, int32_t width, int32_t height, int32_t channels, uint32_t seed)
{
    pv_texels t;
    assert_ok(pv_texels_new(context, width, height, channels, &t));
    for (int64_t i = 0; i < pv_texels_count(&t) * channels; i++)
        t.values[i] = chance(seed, (uint32_t)(i / 3)) + 0.1f * chance(seed + 1, (uint32_t)i);
    return t;
}

static double apart(const pv_texels *a, int32_t ax, int32_t ay, const pv_texels *b, int32_t bx, int32_t by, int32_t side)
{
    double sum = 0;
    for (int32_t y = 0; y < side; y++)
        for (int32_t i = 0; i < side * a->channels; i++) {
            double d = (double)a->values[((int64_t)(ay + y) * a->width + ax) * a->channels + i] -
                       (double)b->values[((int64_t)(by + y) * b->width + bx) * b->channels + i];
            sum += d * d;
        }
    return sum;
}

/* No window of the sample is nearer than the one that was found, though few were looked at. */
static void windows_are_the_nearest(void **state)
{
    needs_algebra(*state);
    pv_algebra algebra;
    assert_ok(pv_algebra_open(*state, &algebra));
    pv_texels sample = texels(*state, 21, 17, 5, 3), whole = texels(*state, 26, 19, 5, 9);
    memcpy(whole.values, sample.values, 21 * 5 * sizeof(float)); /* some are alike */
    for (int32_t step = 1; step < 4; step++) {
        pv_windows w = pv_windows_of(&whole, 4, step);
        pave_result result = PAVE_OK;
        int32_t *nearest = pv_allocate(*state, (size_t)(w.across * w.down), sizeof *nearest, &result);
        assert_ok(pv_windows_match(*state, &algebra, &sample, &whole, &w, nearest, 0, 1));
        for (int32_t i = 0; i < w.across * w.down; i++) {
            int32_t x = pv_window_corner(&w, i % w.across, whole.width), y = pv_window_corner(&w, i / w.across, 19);
            double least = INFINITY;
            for (int32_t k = 0; k < 18 * 14; k++)
                least = fmin(least, apart(&sample, k % 18, k / 18, &whole, x, y, 4));
            double found = apart(&sample, nearest[i] % 18, nearest[i] / 18, &whole, x, y, 4);
            assert_true(found <= least * (1 + 1e-5) + 1e-9);
        }
        pv_release(nearest);
    }
    pv_release(sample.values);
    pv_release(whole.values);
    pv_algebra_close(&algebra);
}

static double mean_power(const double *power, int32_t octave)
{
    return power[2 * octave] + power[2 * octave + 1];
}

/* The power that a whole ends up with over the sample's, octave by octave, when it was this much weaker and the
 * photographs are so much stronger where the sample does not lie. */
static void sharpen(pv_enlarge *e, float weaker, float stronger, double *ratio)
{
    double own[2 * PV_OCTAVES], made[2 * PV_OCTAVES];
    for (int64_t i = 0; i < 33 * 30; i++)
        e->given.values[i] = stronger * e->seen.values[i];
    for (int64_t i = 0; i < 33 * 30 * 2; i++)
        e->made.values[i] = weaker * e->known.values[i];
    assert_ok(pv_enlarge_sharpen(e));
    assert_ok(pv_enlarge_octaves(e, own, made));
    for (int32_t o = 0; o < PV_OCTAVES; o++)
        ratio[o] = mean_power(made, o) / mean_power(own, o);
}

/* A whole that is half as strong as the sample gets its power back, and one that is the sample stays as it is; of what
 * one photograph tells of the rest half is believed. */
static void octaves_get_the_samples_power(void **state)
{
    needs_algebra(*state);
    pv_enlarge e = { .context = *state, .coefficients = 2, .planes = 1, .guides = 1, .first = { 0, 2 } };
    double ratio[PV_OCTAVES];
    assert_ok(pv_algebra_open(*state, &e.algebra));
    e.known = texels(*state, 33, 30, 2, 5);
    e.made = texels(*state, 33, 30, 2, 5);
    e.seen = texels(*state, 33, 30, 1, 6);
    e.given = texels(*state, 33, 30, 1, 6);
    sharpen(&e, 1, 1, ratio);
    for (int64_t i = 0; i < 33 * 30 * 2; i++)
        assert_float_equal(e.made.values[i], e.known.values[i], 1e-5);
    sharpen(&e, 0.6f, 1, ratio);
    for (int32_t o = 0; o < PV_OCTAVES; o++)
        assert_true(fabs(ratio[o] - 1) < (o < 2 ? 0.02 : 0.2)); /* octaves overlap */
    sharpen(&e, 1, 2, ratio);
    for (int32_t o = 0; o < PV_OCTAVES; o++)
        assert_true(fabs(ratio[o] / 2 - 1) < (o < 2 ? 0.02 : 0.2));
    pv_algebra_close(&e.algebra);
    pv_release(e.known.values);
    pv_release(e.made.values);
    pv_release(e.seen.values);
    pv_release(e.given.values);
}

/* One that is blurred, too, though its octaves can't be scaled one by one. */
static void blurred_octaves_get_the_samples_power(void **state)
{
    needs_algebra(*state);
    pv_enlarge e = { .context = *state, .coefficients = 2, .planes = 1, .guides = 1, .first = { 0, 2 } };
    double own[2 * PV_OCTAVES], made[2 * PV_OCTAVES];
    assert_ok(pv_algebra_open(*state, &e.algebra));
    e.known = texels(*state, 33, 30, 2, 5);
    e.made = texels(*state, 33, 30, 2, 5);
    e.seen = texels(*state, 33, 30, 1, 6);
    e.given = texels(*state, 33, 30, 1, 6);
    for (int64_t i = 0; i + 2 < 33 * 30 * 2; i++)
        e.made.values[i] = 0.6f * e.known.values[i] + 0.4f * e.known.values[i + 2];
    assert_ok(pv_enlarge_sharpen(&e));
    assert_ok(pv_enlarge_octaves(&e, own, made));
    for (int32_t o = 0; o < PV_OCTAVES; o++)
        assert_true(fabs(mean_power(made, o) / mean_power(own, o) - 1) < 0.1);
    pv_algebra_close(&e.algebra);
    pv_release(e.known.values);
    pv_release(e.made.values);
    pv_release(e.seen.values);
    pv_release(e.given.values);
}

/* Right sides as rows, and y' z. */
static void systems_are_solved(void **state)
{
    needs_algebra(*state);
    pv_algebra algebra;
    double matrix[9] = { 4, 1, 0, 1, 3, 1, 0, 1, 2 }, sides[6] = { 6, 10, 8, 4, 1, 0 }, cross[2 * 3];
    const double wanted[6] = { 1, 2, 3, 1, 0, 0 };
    float z[40 * 3], y[40 * 2];
    assert_ok(pv_algebra_open(*state, &algebra));
    assert_true(pv_solve_positive(&algebra, 3, matrix, 2, sides));
    for (int32_t i = 0; i < 6; i++)
        assert_float_equal(sides[i], wanted[i], 1e-12);
    double bad[4] = { 1, 2, 2, 1 };
    assert_false(pv_solve_positive(&algebra, 2, bad, 1, sides));
    for (uint32_t i = 0; i < 120; i++)
        z[i] = chance(1, i), y[i % 80] = chance(2, i % 80);
    assert_ok(pv_cross(*state, &algebra, 40, 3, z, 2, y, cross));
    for (int32_t k = 0; k < 6; k++) {
        double sum = 0;
        for (int32_t r = 0; r < 40; r++)
            sum += (double)y[r * 2 + k / 3] * (double)z[r * 3 + k % 3];
        assert_float_equal(cross[k], sum, 1e-9);
    }
    pv_algebra_close(&algebra);
}

/* ---- Copies ---- */

static void slope(int32_t texel, double out[2])
{
    out[0] = 0.4 * sin(0.7 * (texel % SAMPLE) + 0.2 * (texel / SAMPLE));
    out[1] = 0.3 * cos(0.5 * (texel / SAMPLE));
}

/* Light from above the slope is bright; views see alike. */
static pave_btf *slopes(pave_context *context)
{
    pave_btf *btf = frame(context, SAMPLE, 1);
    for (int32_t t = 0; t < SAMPLE * SAMPLE; t++)
        for (int32_t p = 0; p < PAIRS; p++) {
            double of[2], towards[3];
            pv_direction_vector(btf->lights.direction[p % DIRECTIONS], towards);
            slope(t, of);
            float value = (float)exp(-2 + 4 * (towards[0] * of[0] - towards[1] * of[1]));
            pv_btf_put(btf, t, p, 1, &value);
        }
    return btf;
}

/* Three photographs of slopes by themselves. */
static void open_enlargement(pave_context *context, pave_btf_enlarge_params *params, pv_enlarge *e)
{
    *params = small_params();
    params->symmetric = 1;
    *e = (pv_enlarge){ .context = context, .params = params };
    e->sample = e->photos = slopes(context);
    e->plan = plan_of(context, e->sample, 3);
    assert_ok(pv_algebra_open(e->context, &e->algebra));
    assert_ok(pv_btf_copy_frame(e->context, e->sample, &e->out));
    e->out->colour = PV_COLOUR_LOG;
    e->planes = 1;
    assert_ok(pv_enlarge_factor(e));
    assert_ok(pv_enlarge_guide(e));
}

static void close_enlargement(pv_enlarge *e)
{
    pv_enlarge_free_copies(e);
    pv_release(e->guide->own);
    pv_release(e->guide);
    pv_release(e->given_pair);
    pv_release(e->sample_pair);
    pv_release(e->middle);
    pv_release(e->spread);
    pv_release(e->known.values);
    pv_release(e->given.values);
    pave_btf_free(&e->out);
    pave_btf_plan_free((pave_btf_plan **)&e->plan);
    pave_btf_free((pave_btf **)&e->sample);
    pv_algebra_close(&e->algebra);
}

/* A copy's slope is the sample's, turned: its photographs show that, and so do its coefficients. */
static void copies_are_turned_material(void **state)
{
    needs_algebra(*state);
    pave_btf_enlarge_params params;
    pv_enlarge e;
    open_enlargement(*state, &params, &e);
    assert_int_equal(e.copies, 12); /* a ring of six */
    assert_int_equal(e.straight, 4);
    for (int32_t i = 0; i < e.copies; i++)
        for (int32_t t = 0; t < SAMPLE * SAMPLE; t += 11) {
            const pv_turned *copy = &e.copy[i];
            double of[2], turned[2], towards[3];
            float coefficients[8];
            slope(t, of);
            turned[0] = copy->place[0] * of[0] + copy->place[2] * of[1];
            turned[1] = copy->place[1] * of[0] + copy->place[3] * of[1];
            pv_enlarge_copied(&e, copy, t, coefficients);
            for (int32_t g = 0; g < e.guides; g++) {
                pv_direction_vector(e.sample->lights.direction[e.sample_pair[g] % DIRECTIONS], towards);
                double wanted = -2 + 4 * (towards[0] * turned[0] - towards[1] * turned[1]), shown = 0;
                assert_float_equal(copy->seen.values[t * e.guides + g], wanted, 1e-3);
                for (int32_t k = 0; k < e.coefficients; k++)
                    shown += (double)e.guide[g].row[k] * (double)coefficients[k];
                assert_float_equal(shown, wanted, 1e-2);
            }
        }
    close_enlargement(&e);
}

/* What is around a texel of a copy is what would be around it if the copy lay there as a picture. */
static void windows_of_copies_lie_as_they_do(void **state)
{
    needs_algebra(*state);
    pave_btf_enlarge_params params;
    pv_enlarge e;
    pv_around around;
    float of_copy[128], of_picture[128];
    open_enlargement(*state, &params, &e);
    assert_ok(pv_around_learn(&e, 2, &around));
    for (int32_t i = 0; i < e.straight; i++) {
        const pv_turned *copy = &e.copy[i];
        int32_t flip_x = copy->place[0] < 0, flip_y = copy->place[3] < 0;
        int64_t texel = 5 * SAMPLE + 9, place = (flip_y ? SAMPLE - 6 : 5) * SAMPLE + (flip_x ? SAMPLE - 10 : 9);
        for (int32_t t = 0; t < SAMPLE * SAMPLE; t++) {
            int32_t x = flip_x ? SAMPLE - 1 - t % SAMPLE : t % SAMPLE, y = flip_y ? SAMPLE - 1 - t / SAMPLE : t / SAMPLE;
            memcpy(e.given.values + (y * SAMPLE + x) * e.guides, copy->seen.values + t * e.guides,
                   (size_t)e.guides * sizeof(float));
        }
        assert_ok(pv_around_describe(&around, copy, &texel, 1, of_copy));
        assert_ok(pv_around_describe(&around, NULL, &place, 1, of_picture));
        for (int32_t k = 0; k < around.windows.to; k++)
            assert_float_equal(of_copy[k], of_picture[k], 1e-4);
    }
    pv_around_free(&around);
    close_enlargement(&e);
}

/* ---- Mixing ---- */

/* A regression that errs by so much, and windows by so much, of the same pattern. */
static double share_of(float regression, float windows)
{
    enum { TEXELS = 50 };
    float known[TEXELS * 2], made[TEXELS * 2], missed[TEXELS * 2 / 2];
    int64_t texel[TEXELS / 2];
    pv_enlarge e = { .coefficients = 2, .known = { TEXELS, 1, 2, known }, .held = { TEXELS / 2, texel, missed } };
    for (uint32_t i = 0; i < TEXELS * 2; i++) {
        known[i] = chance(3, i);
        made[i] = known[i] + windows * chance(4, i);
    }
    for (uint32_t k = 0; k < TEXELS / 2; k++) {
        texel[k] = 2 * k + 1; /* every other */
        for (uint32_t c = 0; c < 2; c++)
            missed[2 * k + c] = regression * chance(4, 2 * (2 * k + 1) + c);
    }
    return pv_enlarge_share(&e, made);
}

/* Errors of other signs cancel; of one sign, the lesser is taken. */
static void shares_miss_least(void **state)
{
    (void)state;
    assert_float_equal(share_of(0.3f, -0.1f), 0.75, 1e-3);
    assert_float_equal(share_of(0.1f, -0.3f), 0.25, 1e-3);
    assert_float_equal(share_of(0.1f, 0.3f), 0, 0);
    assert_float_equal(share_of(0.3f, 0.1f), 1, 0);
    assert_float_equal(share_of(0, 0), 0, 0);
}

/* ---- Enlargements ---- */

/* Two patterns are known from two photographs; one shows the one only. */
static void photographs_tell_what_they_show(void **state)
{
    not_for_threads();
    needs_algebra(*state);
    pave_btf *sample = material(*state, SAMPLE, LEFT, 1), *truth = material(*state, WHOLE, 0, 1);
    pave_btf_enlargement report;
    pave_btf_enlarge_params params = small_params(), paper = small_params();
    double one = enlarge(*state, sample, truth, 1, params, &report), alone = report.explained;
    assert_figure(report.explained > 0.2 && report.explained < 0.9);
    double three = enlarge(*state, sample, truth, 3, params, &report);
    assert_figure(report.explained > 0.97 && report.missed < 0.05);
    double eight = enlarge(*state, sample, truth, 8, params, &report);
    assert_figure(three < 0.25 * one && eight < 1.01 * three);

    params.symmetric = 1; /* the patterns are no friends of mirrors, and parts that are held out tell */
    enlarge(*state, sample, truth, 1, params, &report);
    assert_figure(report.explained > alone - 0.02);
    params.aim = PAVE_BTF_AIM_LOOK;
    double look = enlarge(*state, sample, truth, 3, params, &report);
    assert_figure(look < 0.5 * one && report.sharpness > 0.9 && report.sharpness < 1.1);

    paper.mode = PAVE_BTF_PAPER;
    paper.stage = 1;
    double optimized = enlarge(*state, sample, truth, 3, paper, &report);
    assert_figure(optimized > three && report.rounds > 1);
    paper.stage = 2;
    enlarge(*state, sample, truth, 3, paper, &report);
    double loose = report.missed;
    paper.stage = 3;
    enlarge(*state, sample, truth, 3, paper, &report);
    assert_figure(report.missed < 1e-3 && report.missed < 0.1 * loose); /* forced */
    pave_btf_free(&sample);
    pave_btf_free(&truth);
}

/* The sample comes back where it lies, and the picture under even light serves about as well as one photograph. */
static void even_light_and_place_are_used(void **state)
{
    not_for_threads();
    needs_algebra(*state);
    pave_btf *sample = material(*state, SAMPLE, LEFT, 3), *truth = material(*state, WHOLE, 0, 3), *out = NULL;
    pave_btf_enlarge_params params = small_params();
    pave_btf_enlargement report = { .size = sizeof report };
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_image *mean = NULL;
    shape.width = shape.height = WHOLE;
    shape.channels = 3;
    shape.type = PAVE_F32;
    shape.encoding = PAVE_LINEAR;
    assert_ok(pv_image_new(*state, &shape, &mean));
    memset(mean->pixels, 0, WHOLE * WHOLE * 3 * sizeof(float));
    for (int32_t t = 0; t < WHOLE * WHOLE; t++)
        for (int32_t l = 0; l < DIRECTIONS; l++) {
            float of[3];
            pv_btf_sample(truth, t, l, of);
            for (int32_t c = 0; c < 3; c++)
                ((float *)mean->pixels)[t * 3 + c] += of[c] / DIRECTIONS;
        }
    params.x = params.y = LEFT;
    assert_ok(pave_btf_enlarge(*state, sample, NULL, NULL, mean, &params, &out, &report));
    double even = error_of(out, truth), one = enlarge(*state, sample, truth, 1, params, &report);
    assert_figure(even < 1.2 * one);
    for (int32_t t = 0; t < SAMPLE * SAMPLE; t += 7) {
        float a[3], b[3];
        pv_btf_sample(out, (t / SAMPLE + LEFT) * WHOLE + t % SAMPLE + LEFT, 30, a);
        pv_btf_sample(sample, t, 30, b);
        for (int32_t c = 0; c < 3; c++)
            assert_float_equal(a[c], b[c], 0.02 * (double)b[c]);
    }
    assert_non_null(pave_btf_coefficients(out, 2));
    assert_null(pave_btf_eigenvectors(out, 3));
    assert_null(pave_btf_coefficients(sample, 0));
    pave_btf_free(&out);
    pave_btf_free(&sample);
    pave_btf_free(&truth);
    pave_image_free(&mean);
}

static uint64_t hash_of(const pave_btf *btf)
{
    uint64_t hash = 0;
    for (int32_t c = 0; c < pave_btf_channels(btf); c++)
        hash ^= hash_bytes(pave_btf_coefficients(btf, c), (size_t)WHOLE * WHOLE * sizeof(float) *
                           (size_t)pave_btf_components(btf, c)) * (uint64_t)(2 * c + 1);
    return hash;
}

static void threads_do_not_matter(void **state)
{
    needs_algebra(*state);
    uint64_t hash[3];
    for (int32_t mode = SANITIZED; mode < 3; mode++) { /* to look at, there is all that there is for the least error */
        for (int32_t i = SANITIZED; i < 3; i++) {
            pave_context *context = make_context(i == 2 ? 7 : i + 1, PAVE_BACKEND_CPU);
            pave_btf *sample = material(context, SAMPLE, LEFT, 1), *truth = material(context, WHOLE, 0, 1), *out = NULL;
            pave_btf_plan *plan = plan_of(context, truth, 2);
            pave_btf_enlarge_params params = small_params();
            params.mode = mode == 2 ? PAVE_BTF_PAPER : PAVE_BTF_BEST;
            params.aim = mode == 1 ? PAVE_BTF_AIM_LOOK : PAVE_BTF_AIM_ERROR;
            params.symmetric = mode == 1;
            assert_ok(pave_btf_enlarge(context, sample, truth, plan, NULL, &params, &out, NULL));
            hash[i] = hash_of(out);
            pave_btf_free(&out);
            pave_btf_free(&sample);
            pave_btf_free(&truth);
            pave_btf_plan_free(&plan);
            pave_context_free(&context);
        }
        assert_true((SANITIZED || hash[0] == hash[1]) && hash[1] == hash[2]);
    }
}

/* ---- What is refused ---- */

static void refuse(pave_context *context, const pave_btf *sample, const pave_btf *photographs, const pave_image *mean,
                   pave_btf_enlarge_params params, pave_result wanted, const char *words)
{
    pave_btf *out = (pave_btf *)&params;
    pave_result result = pave_btf_enlarge(context, sample, photographs, NULL, mean, &params, &out, NULL);
    if (result != wanted)
        fail_msg("%d, not %d, where \"%s\" is meant", (int)result, (int)wanted, words);
    assert_null(out);
    if (!strstr(pave_context_message(context), words))
        fail_msg("\"%s\" does not tell of \"%s\"", pave_context_message(context), words);
}

static void scale_all(pave_btf *btf, float factor)
{
    for (int64_t t = 0; t < pv_btf_texels(btf); t++)
        for (int64_t i = 0; i < pv_btf_length(btf); i++) {
            float sample;
            pv_btf_samples(btf, t, i, 1, &sample);
            sample *= factor;
            pv_btf_put(btf, t, i, 1, &sample);
        }
}

static void mistakes_are_named(void **state)
{
    needs_algebra(*state);
    pave_btf *sample = material(*state, SAMPLE, LEFT, 1), *truth = material(*state, WHOLE, 0, 1);
    pave_btf *tiny = material(*state, 10, 0, 1), *rgb = material(*state, WHOLE, 0, 3), *odd = NULL;
    pave_btf_enlarge_params params = small_params(), placed = small_params();
    pave_direction d[81], turned[2] = { { 0, 0 }, { 0.5f, 0.3f } };
    float bad = NAN;
    refuse(*state, sample, NULL, NULL, params, PAVE_ERR_ARGUMENT, "not one photograph");
    refuse(*state, tiny, truth, NULL, params, PAVE_ERR_ARGUMENT, "too few");
    refuse(*state, sample, tiny, NULL, params, PAVE_ERR_ARGUMENT, "10 x 10 texels, fewer than the sample's");
    refuse(*state, sample, rgb, NULL, params, PAVE_ERR_ARGUMENT, "channels (1 and 3)");
    placed.x = placed.y = 17;
    refuse(*state, sample, truth, NULL, placed, PAVE_ERR_ARGUMENT, "does not lie in a whole of");
    placed.y = -1;
    refuse(*state, sample, truth, NULL, placed, PAVE_ERR_ARGUMENT, "does not lie in");

    pave_btf_params shape = PAVE_BTF_PARAMS_INIT;
    pave_directions(PAVE_DIRECTIONS_UBO81, d, 81);
    shape.width = shape.height = WHOLE;
    shape.channels = 1;
    shape.type = PAVE_F32;
    shape.views = 2;
    shape.lights = 1;
    shape.view_directions = turned;
    shape.light_directions = d;
    assert_ok(pave_btf_create(*state, &shape, NULL, &odd));
    refuse(*state, sample, odd, NULL, params, PAVE_ERR_ARGUMENT, "the sample is of other directions: view 1");
    pave_btf_free(&odd);
    shape.view_directions = d;
    assert_ok(pave_btf_create(*state, &shape, NULL, &odd));
    refuse(*state, sample, odd, NULL, params, PAVE_ERR_ARGUMENT, "is black");

    scale_all(truth, 0.02f); /* another exposure */
    refuse(*state, sample, truth, NULL, params, PAVE_ERR_ARGUMENT, "contradicts the sample: its mean is");
    scale_all(truth, 50);
    placed.x = placed.y = 0; /* not where it lies */
    refuse(*state, sample, truth, NULL, placed, PAVE_ERR_ARGUMENT, "contradicts the sample at 0,0");
    pv_btf_put(truth, WHOLE + 1, 0, 1, &bad);
    refuse(*state, sample, truth, NULL, params, PAVE_ERR_FORMAT, "texel 1,1 of a photograph");
    pv_btf_put(sample, SAMPLE + 1, 0, 1, &bad);
    refuse(*state, sample, truth, NULL, params, PAVE_ERR_FORMAT, "the sample's texel 1,1");
    params.components = 0;
    refuse(*state, sample, truth, NULL, params, PAVE_ERR_ARGUMENT, "components");

    const int32_t views[2] = { 0, 0 }, lights[2] = { 1, 1 }, far[2] = { 0, DIRECTIONS };
    pave_btf_plan *plan = NULL;
    assert_int_equal(pave_btf_plan_of_pairs(*state, truth, views, lights, 2, &plan), PAVE_ERR_ARGUMENT);
    assert_int_equal(pave_btf_plan_of_pairs(*state, truth, views, far, 2, &plan), PAVE_ERR_ARGUMENT);
    assert_null(plan);
    pave_btf_free(&odd);
    pave_btf_free(&rgb);
    pave_btf_free(&tiny);
    pave_btf_free(&truth);
    pave_btf_free(&sample);
}

/* Allocations fail, ever later ones: a clean failure, nothing lost, and the context goes on. */
static void memory_runs_out(void **state)
{
    needs_algebra(*state);
    failing f = { 0 };
    pave_context_params memory = failing_params(&f);
    pave_context *context = NULL;
    pave_result result = PAVE_ERR_MEMORY;
    assert_ok(pave_context_create(&memory, &context));
    for (int32_t mode = 0; mode < 2; mode++) {
        pave_btf *sample = material(context, SAMPLE, LEFT, 1), *truth = material(context, WHOLE, 0, 1), *out = NULL;
        pave_btf_plan *plan = plan_of(context, truth, 2);
        pave_btf_enlarge_params params = small_params();
        pave_btf_enlargement report = { .size = sizeof report };
        params.mode = mode ? PAVE_BTF_PAPER : PAVE_BTF_BEST;
        params.aim = PAVE_BTF_AIM_LOOK;
        int64_t before = f.blocks;
        for (int64_t at = 1; result; at += 1 + at / (SANITIZED ? 2 : 8)) {
            f.calls = 0;
            f.fail_at = at;
            result = pave_btf_enlarge(context, sample, truth, plan, NULL, &params, &out, &report);
            f.fail_at = 0;
            if (result) {
                assert_int_equal(result, PAVE_ERR_MEMORY);
                assert_null(out);
                assert_int_equal(f.blocks, before);
            }
            pave_btf_free(&out);
        }
        pave_btf_free(&sample);
        pave_btf_free(&truth);
        pave_btf_plan_free(&plan);
        result = PAVE_ERR_MEMORY;
    }
    pave_context_free(&context);
    assert_int_equal(f.blocks, 0);
}

static int32_t stop_late(void *user, const char *stage, double done)
{
    (void)stage;
    return done > *(double *)user;
}

static void it_can_be_stopped(void **state)
{
    needs_algebra(*state);
    pave_btf *sample = material(*state, SAMPLE, LEFT, 1), *truth = material(*state, WHOLE, 0, 1);
    for (int32_t i = 0; i < 6; i++) {
        double when = 0.15 * i;
        pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
        pave_context *context = NULL;
        pave_btf *out = NULL;
        pave_btf_enlarge_params how = small_params();
        params.progress = stop_late;
        params.progress_user = &when;
        how.aim = PAVE_BTF_AIM_LOOK;
        how.mode = i % 2 ? PAVE_BTF_PAPER : PAVE_BTF_BEST;
        assert_ok(pave_context_create(&params, &context));
        pave_btf_plan *plan = plan_of(context, truth, 2);
        assert_int_equal(pave_btf_enlarge(context, sample, truth, plan, NULL, &how, &out, NULL), PAVE_ERR_CANCELLED);
        assert_null(out);
        pave_btf_plan_free(&plan);
        pave_context_free(&context);
    }
    pave_btf_free(&sample);
    pave_btf_free(&truth);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(windows_are_the_nearest),
        cmocka_unit_test(octaves_get_the_samples_power),
        cmocka_unit_test(blurred_octaves_get_the_samples_power),
        cmocka_unit_test(systems_are_solved),
        cmocka_unit_test(copies_are_turned_material),
        cmocka_unit_test(windows_of_copies_lie_as_they_do),
        cmocka_unit_test(shares_miss_least),
        cmocka_unit_test(photographs_tell_what_they_show),
        cmocka_unit_test(even_light_and_place_are_used),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(mistakes_are_named),
        cmocka_unit_test(memory_runs_out),
        cmocka_unit_test(it_can_be_stopped),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
