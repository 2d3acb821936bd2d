/* Whole materials from a few samples: bases against their definitions, plans, reconstructions of what is known. */
#include "failing.h"

#include "btf/eigenspace.h"
#include "btf/evidence.h"
#include "btf/model.h"
#include "btf/solve.h"
#include "image/image.h"

#include <math.h>
#include <unistd.h>

enum { DIRECTIONS = 19, PAIRS = DIRECTIONS * DIRECTIONS }; /* the first rings of UBO81: both mirrors keep them */

static int has_algebra(pave_context *context)
{
    pv_algebra algebra;
    if (pv_algebra_open(context, &algebra))
        return 0;
    pv_algebra_close(&algebra);
    return 1;
}

static void needs_algebra(pave_context *context)
{
    if (!has_algebra(context))
        skip();
}

static pave_btf_params shape_of(int32_t side, int32_t channels, const pave_direction *directions)
{
    pave_btf_params shape = PAVE_BTF_PARAMS_INIT;
    shape.width = shape.height = side;
    shape.channels = channels;
    shape.type = PAVE_F32;
    shape.views = shape.lights = DIRECTIONS;
    shape.view_directions = shape.light_directions = directions;
    return shape;
}

/* A generated material seen from the first rings of directions only. */
static pave_btf *material(pave_context *context, int32_t class_of, int32_t texels, uint64_t seed)
{
    pave_btf_synthesis_params params = PAVE_BTF_SYNTHESIS_PARAMS_INIT;
    pave_btf *whole = NULL, *part = NULL;
    params.class_of = class_of;
    params.texels = texels;
    params.seed = seed;
    params.bounces = 0;
    params.samples = 2;
    assert_ok(pave_btf_synthesize(context, &params, &whole));
    pave_btf_params shape = shape_of(texels, 3, whole->views.direction);
    assert_ok(pave_btf_create(context, &shape, NULL, &part));
    for (int64_t t = 0; t < texels * texels; t++)
        for (int32_t v = 0; v < DIRECTIONS; v++)
            for (int32_t l = 0; l < DIRECTIONS; l++) {
                float sample[3];
                pv_btf_sample(whole, t, v * 81 + l, sample);
                pv_btf_put(part, t, (v * DIRECTIONS + l) * 3, 3, sample);
            }
    pave_btf_free(&whole);
    return part;
}

static float chance(uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t x = a * 0x9E3779B1u ^ b * 0x85EBCA77u ^ c * 0xC2B2AE3Du;
    x = (x ^ x >> 15) * 0x2C1B3C6Du;
    x = (x ^ x >> 12) * 0x297A2D39u;
    return (float)((x ^ x >> 15) >> 8) * 0x1p-24f - 0.5f;
}

enum { RANK = 4 };

/* One channel whose logarithms are `RANK` smooth functions of the directions, mixed by chance: texels know nothing of
 * each other. */
static pave_btf *low_rank(pave_context *context, int32_t side, uint32_t seed, float noise)
{
    pave_direction d[81];
    pave_btf *btf = NULL;
    pave_directions(PAVE_DIRECTIONS_UBO81, d, 81);
    pave_btf_params shape = shape_of(side, 1, d);
    assert_ok(pave_btf_create(context, &shape, NULL, &btf));
    for (int32_t t = 0; t < side * side; t++)
        for (int32_t p = 0; p < PAIRS; p++) {
            const pave_direction v = d[p / DIRECTIONS], l = d[p % DIRECTIONS];
            const float function[RANK] = { 1, sinf(3 * l.theta), cosf(v.phi) * v.theta, v.theta * l.theta };
            float sum = logf(0.0955f * cosf(l.theta) + 0.00032f) + noise * chance(seed + 77, (uint32_t)t, (uint32_t)p);
            for (uint32_t k = 0; k < RANK; k++)
                sum += function[k] * 0.8f * chance(seed, (uint32_t)t, k);
            float sample = expf(sum) - 0.00032f;
            pv_btf_put(btf, t, p, 1, &sample);
        }
    return btf;
}

static pave_btf_model *model_of(pave_context *context, pave_btf *const *btfs, int32_t count,
                                const pave_btf_model_params *params)
{
    pave_btf_model *model = NULL;
    assert_ok(pave_btf_model_create(context, (const pave_btf *const *)btfs, count, params, &model));
    return model;
}

static void free_all(pave_btf **btfs, int32_t count)
{
    for (int32_t i = 0; i < count; i++)
        pave_btf_free(&btfs[i]);
}

static double error_of(pave_context *context, const pave_btf *a, const pave_btf *b)
{
    pave_btf_measure_params params = PAVE_BTF_MEASURE_PARAMS_INIT;
    pave_btf_difference difference = { .size = sizeof difference };
    params.texels = 0;
    params.epsilon = 0.00032;
    assert_ok(pave_btf_measure(context, a, b, &params, &difference));
    return difference.centred * difference.variation;
}

static double reconstruct(pave_context *context, const pave_btf_model *model, const pave_btf *truth,
                          const pave_btf_plan *plan, pave_btf_reconstruct_params params)
{
    pave_btf *out = NULL;
    params.type = PAVE_F32;
    assert_ok(pave_btf_reconstruct(context, model, truth, plan, &params, &out, NULL));
    double error = error_of(context, out, truth);
    pave_btf_free(&out);
    return error;
}

static pave_btf_plan *plan_of(pave_context *context, const pave_btf_model *model, int32_t method, int32_t samples)
{
    pave_btf_plan_params params = PAVE_BTF_PLAN_PARAMS_INIT;
    pave_btf_plan *plan = NULL;
    params.method = method;
    params.samples = samples;
    params.steps = 40;
    assert_ok(pave_btf_plan_create(context, model, &params, &plan));
    return plan;
}

/* ---- Symmetry and bases ---- */

static void symmetries_are_those_of_the_directions(void **state)
{
    static const int32_t expected[2] = { 4, 2 };
    pave_direction d[151];
    pv_directions all;
    pv_symmetry symmetry;
    for (int32_t set = 0; set < 2; set++) {
        int32_t count = pave_directions(set, d, 151);
        assert_ok(pv_directions_create(*state, "view", d, count, &all));
        assert_ok(pv_symmetry_find(*state, &all, &all, 1, &symmetry));
        assert_int_equal(symmetry.count, expected[set]);
        for (int32_t k = 0; k < symmetry.count; k++)
            for (int32_t i = 0; i < count; i++)
                assert_int_equal(symmetry.view[k][symmetry.view[k][i]], i); /* each is its own inverse */
        pv_symmetry_free(&symmetry);
        assert_ok(pv_symmetry_find(*state, &all, &all, 0, &symmetry));
        assert_int_equal(symmetry.count, 1);
        pv_symmetry_free(&symmetry);
        pv_directions_free(&all);
    }
}

/* The row that a row goes to, written out once more. */
static int32_t moved(const pv_symmetry *s, int32_t patch, int32_t element, int32_t row)
{
    int32_t place = row / PAIRS, pair = row % PAIRS, x = place % patch, y = place / patch;
    x = s->flips[element] & 1 ? patch - 1 - x : x;
    y = s->flips[element] & 2 ? patch - 1 - y : y;
    return (y * patch + x) * PAIRS + s->view[element][pair / DIRECTIONS] * DIRECTIONS +
           s->light[element][pair % DIRECTIONS];
}

/* Blocks of parity give what the four copies, written out, have; each vector is even or odd under every mirror. */
static void blocks_of_parity_are_the_copies(void **state)
{
    enum { PATCH = 3, ROWS = PATCH * PATCH * PAIRS, WIDTH = 6 };
    needs_algebra(*state);
    pave_direction d[81];
    pv_algebra algebra;
    pv_directions all;
    pv_symmetry symmetry, none = { .count = 1 };
    pave_directions(PAVE_DIRECTIONS_UBO81, d, 81);
    assert_ok(pv_directions_create(*state, "view", d, DIRECTIONS, &all));
    assert_ok(pv_symmetry_find(*state, &all, &all, 1, &symmetry));
    assert_ok(pv_symmetry_find(*state, &all, &all, 0, &none));
    assert_int_equal(symmetry.count, 4);
    float *values = malloc(ROWS * WIDTH * sizeof *values), *copies = malloc(ROWS * WIDTH * 4 * sizeof *copies);
    for (int32_t r = 0; r < ROWS; r++)
        for (int32_t k = 0; k < WIDTH; k++)
            values[r * WIDTH + k] = chance((uint32_t)r, (uint32_t)k, 5) * (float)(1 + k);
    for (int32_t r = 0; r < ROWS; r++)
        for (int32_t k = 0; k < 4 * WIDTH; k++)
            copies[moved(&symmetry, PATCH, k / WIDTH, r) * 4 * WIDTH + k] = values[r * WIDTH + k % WIDTH];
    const pv_side folded = { .rows = ROWS, .patch = PATCH, .lights = DIRECTIONS, .width = WIDTH, .stride = WIDTH,
                             .values = values };
    const pv_side whole = { .rows = ROWS, .patch = PATCH, .lights = DIRECTIONS, .width = 4 * WIDTH,
                            .stride = 4 * WIDTH, .values = copies };
    int32_t found[2] = { 100, 100 };
    float *left[2], *singular[2];
    assert_ok(pv_algebra_open(*state, &algebra));
    assert_ok(pv_eigenspace(*state, &algebra, &folded, &symmetry, &found[0], &left[0], &singular[0]));
    assert_ok(pv_eigenspace(*state, &algebra, &whole, &none, &found[1], &left[1], &singular[1]));
    assert_int_equal(found[0], 4 * WIDTH);
    assert_int_equal(found[1], 4 * WIDTH);
    for (int32_t k = 0; k < 4 * WIDTH; k++)
        assert_true(fabsf(2 * singular[0][k] - singular[1][k]) < 1e-4f * singular[1][0]);
    for (int32_t k = 0; k < found[0]; k++)
        for (int32_t g = 1; g < 4; g++) {
            double even = 0, odd = 0;
            for (int32_t r = 0; r < ROWS; r++) {
                float a = left[0][r * found[0] + k], b = left[0][moved(&symmetry, PATCH, g, r) * found[0] + k];
                even += (double)((a - b) * (a - b));
                odd += (double)((a + b) * (a + b));
            }
            assert_true(fmin(even, odd) < 1e-10);
        }
    for (int i = 0; i < 2; i++) {
        pv_release(left[i]);
        pv_release(singular[i]);
    }
    pv_algebra_close(&algebra);
    pv_symmetry_free(&symmetry);
    pv_symmetry_free(&none);
    pv_directions_free(&all);
    free(values);
    free(copies);
}

/* The basis without the columns of a gap is the one of those that are left, side by side. */
static void a_material_can_be_left_out(void **state)
{
    enum { WIDTH = 9, GAP = 2, GAP_WIDTH = 4, LEFT = WIDTH - GAP_WIDTH };
    needs_algebra(*state);
    pave_direction d[81];
    pv_algebra algebra;
    pv_directions all;
    pv_symmetry symmetry;
    pave_directions(PAVE_DIRECTIONS_UBO81, d, 81);
    assert_ok(pv_directions_create(*state, "view", d, DIRECTIONS, &all));
    assert_ok(pv_symmetry_find(*state, &all, &all, 1, &symmetry));
    float *values = malloc(PAIRS * WIDTH * sizeof *values), *kept = malloc(PAIRS * LEFT * sizeof *kept);
    for (int32_t r = 0; r < PAIRS; r++)
        for (int32_t k = 0, j = 0; k < WIDTH; k++) {
            values[r * WIDTH + k] = chance((uint32_t)r, (uint32_t)k, 6);
            if (k < GAP || k >= GAP + GAP_WIDTH)
                kept[r * LEFT + j++] = values[r * WIDTH + k];
        }
    const pv_side with = { .rows = PAIRS, .patch = 1, .lights = DIRECTIONS, .width = LEFT, .stride = WIDTH, .gap = GAP,
                           .gap_width = GAP_WIDTH, .values = values };
    const pv_side without = { .rows = PAIRS, .patch = 1, .lights = DIRECTIONS, .width = LEFT, .stride = LEFT,
                              .values = kept };
    int32_t found[2] = { 100, 100 };
    float *left[2], *singular[2];
    assert_ok(pv_algebra_open(*state, &algebra));
    assert_ok(pv_eigenspace(*state, &algebra, &with, &symmetry, &found[0], &left[0], &singular[0]));
    assert_ok(pv_eigenspace(*state, &algebra, &without, &symmetry, &found[1], &left[1], &singular[1]));
    assert_int_equal(found[0], found[1]);
    assert_memory_equal(left[0], left[1], PAIRS * (size_t)found[0] * sizeof *left[0]);
    assert_memory_equal(singular[0], singular[1], (size_t)found[0] * sizeof *singular[0]);
    for (int i = 0; i < 2; i++) {
        pv_release(left[i]);
        pv_release(singular[i]);
    }
    pv_algebra_close(&algebra);
    pv_symmetry_free(&symmetry);
    pv_directions_free(&all);
    free(values);
    free(kept);
}

/* Errors of a material of that hardness, least with the noise `best`; either basis alike, and a share that is best. */
static void fill_errors(double hardness, int32_t best, double rise, double share, pv_errors *out)
{
    for (int32_t i = 0; i < PV_NOISES; i++) {
        double error = hardness * (1 + rise * abs(i - best));
        out->texels[i] = out->patches[i] = error;
        out->expected[i] = error / 4;
        for (int32_t k = 0; k < PV_ALL_NOISES; k++) {
            double bent = 0.5 * error;
            out->mixed[i][k][0] = error + (k == 9 ? 0 : error);
            out->mixed[i][k][1] = -bent * share;
            out->mixed[i][k][2] = bent;
        }
    }
}

/* Neither the hardest material rules, nor one of three that is another kind. */
static void settings_are_those_of_most_materials(void **state)
{
    pv_basis basis[1][2] = { { { .whole = 2 }, { .whole = 3 } } };
    pv_rung rung[1][PV_MOST_RUNGS];
    pave_btf_model model = { .planes = 1, .patch = 3, .basis = basis, .rung = rung };
    pv_evidence *evidence;
    pv_errors errors;
    assert_ok(pv_evidence_create(*state, 1, &evidence));
    evidence->rungs = 1, evidence->samples[0] = 8;
    fill_errors(1000, 2, 0.01, 0.3, &errors);
    pv_evidence_add(evidence, 0, 0, &errors);
    for (int i = 0; i < 2; i++) {
        fill_errors(1e-6, 6, 0.05, 0.6, &errors);
        pv_evidence_add(evidence, 0, 0, &errors);
    }
    pv_evidence_settle(evidence, &model);
    assert_int_equal(model.rungs, 1);
    assert_true(rung[0][0].samples == 8);
    assert_true(fabs(rung[0][0].noise[0] / pv_noise_at(&basis[0][0], 6) - 1) < 1e-12);
    assert_true(fabs(rung[0][0].noise[1] / pv_noise_at(&basis[0][1], 6) - 1) < 1e-12);
    assert_true(fabs(rung[0][0].rest / pv_noise_at(&basis[0][0], 9 - PV_LOUD_NOISES) - 1) < 1e-12);
    assert_true(rung[0][0].share > 0.49 && rung[0][0].share < 0.51); /* (1.04 * .3 + 2 * .6) / 3.04 */
    assert_true(rung[0][0].trust > 1.8 && rung[0][0].trust < 2);     /* both are a little better than one */
    pv_evidence_free(evidence);
}

/* A model knows the rank of its class, and its vectors are orthonormal. */
static void a_model_has_the_rank_of_its_class(void **state)
{
    needs_algebra(*state);
    pave_btf_model_params params = PAVE_BTF_MODEL_PARAMS_INIT;
    pave_btf *btfs[3] = { low_rank(*state, 8, 1, 0), low_rank(*state, 8, 2, 0), low_rank(*state, 8, 3, 0) };
    params.symmetric = params.validate = 0;
    params.abrdfs = 40;
    pave_btf_model *model = model_of(*state, btfs, 3, &params);
    const float *deviation = pave_btf_model_deviations(model, 0, 0);
    int32_t found = pave_btf_model_components(model, 0, 0);
    for (int32_t k = RANK; k < found; k++)
        assert_true(deviation[k] < 1e-3f * deviation[0]);
    assert_true(deviation[RANK - 1] > 1e-2f * deviation[0]);
    float *a = malloc(PAIRS * sizeof *a), *b = malloc(PAIRS * sizeof *b);
    for (int32_t i = 0; i < RANK; i++)
        for (int32_t k = 0; k < RANK; k++) {
            double sum = 0;
            pave_btf_model_vector(model, 0, 0, i, a);
            pave_btf_model_vector(model, 0, 0, k, b);
            for (int32_t p = 0; p < PAIRS; p++)
                sum += (double)(a[p] * b[p]);
            assert_true(fabs(sum - (i == k)) < 1e-4);
        }
    assert_int_equal(pave_btf_model_components(model, 1, 0), 0);
    assert_int_equal(pave_btf_model_materials(model), 3);
    assert_int_equal(pave_btf_model_copies(model), 1);
    free(a);
    free(b);
    pave_btf_model_free(&model);
    free_all(btfs, 3);
}

/* ---- Plans ---- */

static pave_btf_model *small_model(pave_context *context, int32_t class_of, int32_t count)
{
    pave_btf_model_params params = PAVE_BTF_MODEL_PARAMS_INIT;
    pave_btf *btfs[8];
    int32_t side = SANITIZED ? 6 : 10;
    for (int32_t i = 0; i < count; i++)
        btfs[i] = material(context, class_of, side, (uint64_t)i + 1);
    params.material = SANITIZED ? 8 : 24;
    params.stride = 1;
    params.abrdfs = SANITIZED ? 12 : 40;
    params.components = SANITIZED ? 24 : 80;
    pave_btf_model *model = model_of(context, btfs, count, &params);
    free_all(btfs, count);
    return model;
}

/* The trace of (S^-2 + sum u u' / noise)^-1, written out by Gauss and Jordan. */
static double trace_left(const pv_basis *basis, const int32_t *pairs, int32_t count, double noise)
{
    int32_t n = basis->components;
    double *m = calloc((size_t)(n * 2 * n), sizeof *m), trace = 0;
    for (int32_t i = 0; i < n; i++) {
        m[i * 2 * n + i] = 1 / ((double)basis->deviation[i] * (double)basis->deviation[i]);
        m[i * 2 * n + n + i] = 1;
        for (int32_t k = 0; k < n; k++)
            for (int32_t s = 0; s < count; s++)
                m[i * 2 * n + k] += (double)basis->left[pairs[s] * n + i] * (double)basis->left[pairs[s] * n + k] / noise;
    }
    for (int32_t i = 0; i < n; i++) {
        double pivot = m[i * 2 * n + i];
        for (int32_t k = 0; k < 2 * n; k++)
            m[i * 2 * n + k] /= pivot;
        for (int32_t j = 0; j < n; j++)
            for (int32_t k = 2 * n - 1; k >= i && j != i; k--)
                m[j * 2 * n + k] -= m[j * 2 * n + i] * m[i * 2 * n + k];
    }
    for (int32_t i = 0; i < n; i++)
        trace += m[i * 2 * n + n + i];
    free(m);
    return trace;
}

static void greedy_plans_leave_least_unknown(void **state)
{
    enum { COUNT = 5 };
    needs_algebra(*state);
    pave_btf_model *model = small_model(*state, PAVE_BTF_TILE, 2);
    const pv_basis *basis = &model->basis[0][PV_OF_TEXELS];
    double noise = 0.01, left[COUNT];
    int32_t pairs[COUNT];
    assert_ok(pv_plan_greedy(*state, model, noise, COUNT, pairs, left));
    for (int32_t i = 0; i < COUNT; i++) {
        double here = trace_left(basis, pairs, i + 1, noise);
        assert_true(fabs(here - left[i]) < 1e-6 * here);
    }
    int32_t others[COUNT];
    memcpy(others, pairs, sizeof others);
    for (int32_t p = 0; p < PAIRS; p += SANITIZED ? 40 : 7) {
        others[2] = p;
        if (p != pairs[0] && p != pairs[1])
            assert_true(trace_left(basis, others, 3, noise) >= left[2] * (1 - 1e-9));
    }
    pave_btf_model_free(&model);
}

static void plans_are_what_they_say(void **state)
{
    needs_algebra(*state);
    pave_btf_model *model = small_model(*state, PAVE_BTF_TILE, 2);
    pave_btf_plan *plan = plan_of(*state, model, PAVE_BTF_PLAN_GREEDY, 60), *fewer = NULL, *again = NULL;
    pave_btf_plan_params params = PAVE_BTF_PLAN_PARAMS_INIT;
    params.samples = 20;
    assert_ok(pave_btf_plan_create(*state, model, &params, &fewer));
    assert_memory_equal(pave_btf_plan_views(plan), pave_btf_plan_views(fewer), 20 * sizeof(int32_t)); /* nested */
    assert_memory_equal(pave_btf_plan_lights(plan), pave_btf_plan_lights(fewer), 20 * sizeof(int32_t));
    for (int32_t i = 1; i < 60; i++)
        assert_true(pave_btf_plan_expected(plan)[i] <= pave_btf_plan_expected(plan)[i - 1]);
    pave_btf_plan_free(&fewer);

    double before, after;
    fewer = plan_of(*state, model, PAVE_BTF_PLAN_SWAP, 60);
    again = plan_of(*state, model, PAVE_BTF_PLAN_SWAP, 60);
    pave_btf_plan_condition(fewer, &before, &after);
    assert_true(after < before && after >= 1);
    assert_memory_equal(pave_btf_plan_views(fewer), pave_btf_plan_views(again), 60 * sizeof(int32_t));
    pave_btf_plan_free(&fewer);
    pave_btf_plan_free(&again);

    params.dome = 1;
    params.samples = 30;
    assert_ok(pave_btf_plan_create(*state, model, &params, &fewer)); /* each view with each light */
    int32_t views = 0, lights = 0, count = pave_btf_plan_samples(fewer);
    uint8_t seen[2][DIRECTIONS] = { { 0 } };
    for (int32_t i = 0; i < count; i++) {
        views += !seen[0][fewer->view[i]]++;
        lights += !seen[1][fewer->light[i]]++;
    }
    assert_int_equal(views * lights, count);
    assert_true(count <= 30 && count > 15);
    pave_btf_plan_free(&fewer);
    pave_btf_plan_free(&plan);
    params.samples = PAIRS + 1;
    assert_int_equal(pave_btf_plan_create(*state, model, &params, &plan), PAVE_ERR_ARGUMENT);
    params.samples = 2;
    params.method = PAVE_BTF_PLAN_SWAP;
    assert_int_equal(pave_btf_plan_create(*state, model, &params, &plan), PAVE_ERR_ARGUMENT);
    assert_non_null(strstr(pave_context_message(*state), "at least"));
    pave_btf_model_free(&model);
}

/* 7 x 7 cells have 37 directions in the disc, which stay apart on Dome I: the 1369 pairs of the text. */
static void the_parabolic_map_is_the_papers(void **state)
{
    pave_direction d[151];
    pave_btf_model *model = NULL;
    int32_t count = pave_directions(PAVE_DIRECTIONS_DOME151, d, 151);
    assert_ok(pv_model_new(*state, 1, d, count, d, count, &model));
    pave_btf_plan *plan = plan_of(*state, model, PAVE_BTF_PLAN_PARABOLIC, 1369);
    assert_int_equal(pave_btf_plan_samples(plan), 1369);
    pave_btf_plan_free(&plan);
    plan = plan_of(*state, model, PAVE_BTF_PLAN_PARABOLIC, 1100);
    assert_int_equal(pave_btf_plan_samples(plan), 32 * 32);
    pave_btf_plan_free(&plan);
    pave_btf_model_free(&model);
}

/* ---- Reconstructions ---- */

/* A material of the class's rank comes back from a few samples in every mode; and with noise, best mode adds no more
 * than the noise. */
static void a_low_rank_material_comes_back(void **state)
{
    needs_algebra(*state);
    pave_btf_model_params params = PAVE_BTF_MODEL_PARAMS_INIT;
    pave_btf_reconstruct_params how = PAVE_BTF_RECONSTRUCT_PARAMS_INIT;
    pave_btf *btfs[3] = { low_rank(*state, 8, 1, 0), low_rank(*state, 8, 2, 0), low_rank(*state, 8, 3, 0) };
    pave_btf *truth = low_rank(*state, 8, 9, 0), *noisy = low_rank(*state, 8, 9, 0.17f), *out = NULL; /* 5 % */
    params.symmetric = 0;
    params.patch = 1;
    params.abrdfs = RANK;
    pave_btf_model *model = model_of(*state, btfs, 3, &params);
    pave_btf_plan *plan = plan_of(*state, model, PAVE_BTF_PLAN_GREEDY, 24);
    how.mode = PAVE_BTF_PROJECT;
    assert_true(reconstruct(*state, model, truth, NULL, how) < 2e-3);
    how.mode = PAVE_BTF_PAPER;
    assert_true(reconstruct(*state, model, truth, plan, how) < 2e-3);
    how.mode = PAVE_BTF_BEST;
    assert_true(reconstruct(*state, model, truth, plan, how) < 4e-3);
    how.noise = 0.05;
    assert_ok(pave_btf_reconstruct(*state, model, noisy, plan, &how, &out, NULL));
    double error = error_of(*state, out, truth);
    assert_true(error > 0 && error < 0.05);
    pave_btf_free(&out);
    pave_btf_free(&truth);
    pave_btf_free(&noisy);
    pave_btf_plan_free(&plan);
    pave_btf_model_free(&model);
    free_all(btfs, 3);
}

/* Of a relief: no mode beats the projection on its own basis, more samples are better, both bases together are as good
 * as either, and the error expected of a texel tells which ones are wrong. */
static void a_relief_comes_back_as_far_as_its_class_is_known(void **state)
{
    not_for_threads();
    needs_algebra(*state);
    pave_btf_model *model = small_model(*state, PAVE_BTF_TILE, SANITIZED ? 3 : 6);
    pave_btf *truth = material(*state, PAVE_BTF_TILE, SANITIZED ? 6 : 10, 9), *out = NULL;
    pave_btf_plan *plan = plan_of(*state, model, PAVE_BTF_PLAN_GREEDY, 120);
    pave_btf_reconstruct_params how = PAVE_BTF_RECONSTRUCT_PARAMS_INIT;
    pave_image *errors = NULL;
    double least[2], own[2];
    for (int32_t of = 0; of < 2; of++) {
        how.basis = of ? PAVE_BTF_ABTFS : PAVE_BTF_ABRDFS;
        how.mode = PAVE_BTF_PROJECT;
        least[of] = reconstruct(*state, model, truth, NULL, how);
        how.mode = PAVE_BTF_PAPER;
        how.samples = 60;
        assert_true(reconstruct(*state, model, truth, plan, how) > least[of]);
        how.samples = 0;
        how.mode = PAVE_BTF_BEST;
        own[of] = reconstruct(*state, model, truth, plan, how);
        assert_true(own[of] > 0.9 * least[of]);
    }
    how.basis = PAVE_BTF_BOTH;
    double many = reconstruct(*state, model, truth, plan, how);
    assert_true(SANITIZED || many < 1.1 * fmin(own[0], own[1]));
    how.samples = 12;
    assert_true(reconstruct(*state, model, truth, plan, how) > many);

    how.type = PAVE_F32;
    assert_ok(pave_btf_reconstruct(*state, model, truth, plan, &how, &out, &errors));
    double sums[5] = { 0 };
    int32_t texels = truth->width * truth->height;
    for (int32_t t = 0; t < texels; t++) {
        double error = 0, expected = (double)((const float *)errors->pixels)[t];
        for (int32_t p = 0; p < PAIRS; p++) {
            float a[3], b[3];
            pv_btf_sample(out, t, p, a);
            pv_btf_sample(truth, t, p, b);
            double away = log((double)a[1] + 0.00032) - log((double)b[1] + 0.00032);
            error += away * away / PAIRS;
        }
        error = sqrt(error);
        sums[0] += error / texels, sums[1] += expected / texels, sums[2] += error * error / texels;
        sums[3] += expected * expected / texels, sums[4] += error * expected / texels;
    }
    double correlation = (sums[4] - sums[0] * sums[1]) /
                         sqrt((sums[2] - sums[0] * sums[0]) * (sums[3] - sums[1] * sums[1]));
    assert_true(SANITIZED || (correlation > 0.3 && sums[1] > 0.4 * sums[0] && sums[1] < 2.5 * sums[0]));
    pave_image_free(&errors);
    pave_btf_free(&out);
    pave_btf_free(&truth);
    pave_btf_plan_free(&plan);
    pave_btf_model_free(&model);
}

/* Samples that are no numbers count as not measured: the others decide. */
static void samples_that_are_no_numbers_are_mended(void **state)
{
    needs_algebra(*state);
    pave_btf_model_params params = PAVE_BTF_MODEL_PARAMS_INIT;
    pave_btf_reconstruct_params how = PAVE_BTF_RECONSTRUCT_PARAMS_INIT;
    pave_btf *btfs[3] = { low_rank(*state, 8, 1, 0), low_rank(*state, 8, 2, 0), low_rank(*state, 8, 3, 0) };
    pave_btf *truth = low_rank(*state, 8, 9, 0), *holes = low_rank(*state, 8, 9, 0), *out = NULL;
    params.symmetric = 0;
    params.patch = 1;
    params.abrdfs = RANK;
    pave_btf_model *model = model_of(*state, btfs, 3, &params);
    pave_btf_plan *plan = plan_of(*state, model, PAVE_BTF_PLAN_GREEDY, 60);
    float hole = NAN;
    for (int32_t i = 0; i < 60; i += 9)
        pv_btf_put(holes, 11, plan->view[i] * DIRECTIONS + plan->light[i], 1, &hole);
    how.type = PAVE_F32;
    assert_ok(pave_btf_reconstruct(*state, model, holes, plan, &how, &out, NULL));
    assert_true(error_of(*state, out, truth) < 0.01);
    pave_btf_free(&out);
    pave_btf_free(&truth);
    pave_btf_free(&holes);
    pave_btf_plan_free(&plan);
    pave_btf_model_free(&model);
    free_all(btfs, 3);
}

/* ---- Classes ---- */

/* From all 81 x 81 directions: materials of one class are more alike than those of two. */
static void classes_are_found(void **state)
{
    enum { CLASSES = 3, EACH = 3 };
    static const int32_t kind[CLASSES] = { PAVE_BTF_POLISHED, PAVE_BTF_COBBLE, PAVE_BTF_GROOVED };
    not_for_threads();
    needs_algebra(*state);
    pave_btf *btfs[CLASSES * EACH];
    pave_btf_synthesis_params params = PAVE_BTF_SYNTHESIS_PARAMS_INIT;
    int32_t label[CLASSES * EACH];
    double within;
    params.texels = SANITIZED ? 4 : 10;
    params.bounces = 0;
    for (int32_t i = 0; i < CLASSES * EACH; i++) {
        params.class_of = kind[i % CLASSES];
        params.seed = (uint64_t)i + 1;
        assert_ok(pave_btf_synthesize(*state, &params, &btfs[i]));
    }
    assert_ok(pave_btf_cluster(*state, (const pave_btf *const *)btfs, CLASSES * EACH, CLASSES, NULL, label, &within));
    for (int32_t i = 0; i < CLASSES * EACH && !SANITIZED; i++)
        assert_int_equal(label[i], i % CLASSES);
    assert_true(within > 0 && within < 0.5);
    assert_int_equal(pave_btf_cluster(*state, (const pave_btf *const *)btfs, 2, 3, NULL, label, NULL),
                     PAVE_ERR_ARGUMENT);
    free_all(btfs, CLASSES * EACH);
}

/* ---- Files ---- */

static char *scratch(char path[64], const char *ending)
{
    snprintf(path, 64, "/tmp/pave-sparse-XXXXXX%s", ending);
    close(mkstemps(path, (int)strlen(ending)));
    return path;
}

static void models_come_back_from_files(void **state)
{
    needs_algebra(*state);
    char path[64];
    pave_btf_model *model = small_model(*state, PAVE_BTF_GRAVEL, 2), *read = NULL;
    assert_ok(pave_btf_model_write(*state, model, scratch(path, ".model")));
    assert_ok(pave_btf_model_read(*state, path, &read));
    pave_btf_plan *a = plan_of(*state, model, PAVE_BTF_PLAN_GREEDY, 30), *b = plan_of(*state, read, 0, 30);
    assert_memory_equal(a->view, b->view, 30 * sizeof(int32_t));
    assert_memory_equal(a->expected, b->expected, 30 * sizeof(double));
    for (int32_t of = 0; of < 2; of++)
        assert_memory_equal(model->basis[2][of].left, read->basis[2][of].left,
                            (size_t)pv_basis_rows(model, of) * (size_t)model->basis[2][of].components * sizeof(float));
    pave_btf_plan_free(&a);
    pave_btf_plan_free(&b);
    pave_btf_model_free(&read);
    pave_btf_model_free(&model);
    unlink(path);
}

static void write_bytes(const char *path, const uint8_t *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

/* Cut anywhere, or with any byte of the head another: refused, or read as something that can be. */
static void damaged_models_are_refused(void **state)
{
    needs_algebra(*state);
    char path[64];
    pave_btf_model_params params = PAVE_BTF_MODEL_PARAMS_INIT;
    pave_btf *btfs[2] = { low_rank(*state, 6, 1, 0), low_rank(*state, 6, 2, 0) };
    params.abrdfs = 3;
    params.components = 4;
    pave_btf_model *model = model_of(*state, btfs, 2, &params), *read = NULL;
    assert_ok(pave_btf_model_write(*state, model, scratch(path, ".model")));
    pave_btf_model_free(&model);
    FILE *file = fopen(path, "rb");
    fseek(file, 0, SEEK_END);
    size_t size = (size_t)ftell(file);
    rewind(file);
    uint8_t *bytes = malloc(size + 1);
    assert_int_equal(fread(bytes, 1, size, file), size);
    fclose(file);
    for (size_t cut = 1; cut < size; cut += cut < 1500 ? 13 : 4001) {
        write_bytes(path, bytes, cut);
        assert_int_equal(pave_btf_model_read(*state, path, &read), PAVE_ERR_FORMAT);
        assert_null(read);
    }
    bytes[size] = 0;
    write_bytes(path, bytes, size + 1);
    assert_int_equal(pave_btf_model_read(*state, path, &read), PAVE_ERR_FORMAT);
    for (size_t at = 0; at < 600; at++) {
        uint8_t before = bytes[at];
        bytes[at] ^= at % 2 ? 0xFF : 0x81;
        write_bytes(path, bytes, size);
        bytes[at] = before;
        pave_result result = pave_btf_model_read(*state, path, &read);
        assert_true(result == PAVE_OK || result == PAVE_ERR_FORMAT || result == PAVE_ERR_LIMIT ||
                    (result == PAVE_ERR_UNSUPPORTED && at >= 8 && at < 12));
        assert_true(!result == (read != NULL));
        pave_btf_model_free(&read);
    }
    float none = NAN; /* the last number of the last basis */
    memcpy(bytes + size - 4, &none, 4);
    write_bytes(path, bytes, size);
    assert_int_equal(pave_btf_model_read(*state, path, &read), PAVE_ERR_FORMAT);
    free(bytes);
    free_all(btfs, 2);
    unlink(path);
}

static void plans_come_back_from_files(void **state)
{
    static const char *const bad[] = { "", "a,b\n0,0\n", "view,light\n", "view,light\n0,19\n", "view,light\n-1,0\n",
                                       "view,light\n0\n", "view,light\n1,2\n1,2\n", "view,light\n0,1x\n" };
    pave_direction d[81];
    char path[64];
    pave_btf_model *model = NULL;
    pave_directions(PAVE_DIRECTIONS_UBO81, d, 81);
    assert_ok(pv_model_new(*state, 1, d, DIRECTIONS, d, DIRECTIONS, &model));
    pave_btf_plan *plan = plan_of(*state, model, PAVE_BTF_PLAN_PARABOLIC, 100), *read = NULL;
    int32_t count = pave_btf_plan_samples(plan);
    assert_ok(pave_btf_plan_write(*state, plan, scratch(path, ".csv")));
    assert_ok(pave_btf_plan_read(*state, model, path, &read));
    assert_int_equal(pave_btf_plan_samples(read), count);
    assert_memory_equal(plan->light, read->light, (size_t)count * sizeof(int32_t));
    pave_btf_plan_free(&read);
    pave_btf_plan_free(&plan);
    write_bytes(path, (const uint8_t *)"light, view\r\n3, 4\r\n\r\n5,6", 25);
    assert_ok(pave_btf_plan_read(*state, model, path, &read));
    assert_true(read->count == 2 && read->view[0] == 4 && read->light[1] == 5);
    pave_btf_plan_free(&read);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        write_bytes(path, (const uint8_t *)bad[i], strlen(bad[i]));
        assert_int_equal(pave_btf_plan_read(*state, model, path, &read), PAVE_ERR_FORMAT);
    }
    pave_btf_model_free(&model);
    unlink(path);
}

/* ---- What cannot be ---- */

static void expect_refused(pave_context *context, const pave_btf_model *model, const pave_btf *btf,
                           const pave_btf_reconstruct_params *how, const char *word)
{
    pave_btf *out = NULL;
    assert_int_equal(pave_btf_reconstruct(context, model, btf, NULL, how, &out, NULL), PAVE_ERR_ARGUMENT);
    assert_null(out);
    if (!strstr(pave_context_message(context), word))
        fail_msg("'%s' is not in: %s", word, pave_context_message(context));
}

static void what_cannot_be_is_refused(void **state)
{
    needs_algebra(*state);
    pave_btf_model_params params = PAVE_BTF_MODEL_PARAMS_INIT;
    pave_btf_reconstruct_params how = PAVE_BTF_RECONSTRUCT_PARAMS_INIT;
    pave_btf *btfs[3] = { low_rank(*state, 8, 1, 0), low_rank(*state, 8, 2, 0), NULL }, *other = NULL;
    pave_btf_model *model = NULL, *wrong = NULL;
    pave_direction d[81];
    pave_image *errors = NULL;
    pave_directions(PAVE_DIRECTIONS_UBO81, d, 81);
    params.abrdfs = RANK;
    params.components = 30;
    model = model_of(*state, btfs, 2, &params);

    pave_btf_params shape = shape_of(8, 1, d); /* black, and even */
    assert_ok(pave_btf_create(*state, &shape, NULL, &btfs[2]));
    assert_int_equal(pave_btf_model_create(*state, (const pave_btf *const *)btfs, 3, &params, &wrong), PAVE_ERR_ARGUMENT);
    assert_non_null(strstr(pave_context_message(*state), "material 2 is black"));
    expect_refused(*state, model, btfs[2], NULL, "black");
    pave_btf_free(&btfs[2]);

    shape = shape_of(8, 3, d); /* of other channels */
    assert_ok(pave_btf_create(*state, &shape, NULL, &btfs[2]));
    assert_int_equal(pave_btf_model_create(*state, (const pave_btf *const *)btfs, 3, &params, &wrong), PAVE_ERR_ARGUMENT);
    expect_refused(*state, model, btfs[2], NULL, "channels");
    pave_btf_free(&btfs[2]);

    shape = shape_of(8, 1, d + 30); /* of other directions */
    assert_ok(pave_btf_create(*state, &shape, NULL, &btfs[2]));
    assert_int_equal(pave_btf_model_create(*state, (const pave_btf *const *)btfs, 3, &params, &wrong), PAVE_ERR_ARGUMENT);
    expect_refused(*state, model, btfs[2], NULL, "other directions");
    pave_btf_free(&btfs[2]);

    shape = shape_of(2, 1, d); /* smaller than a patch */
    assert_ok(pave_btf_create(*state, &shape, NULL, &other));
    expect_refused(*state, model, other, NULL, "patch");
    pave_btf_free(&other);

    other = low_rank(*state, 8, 5, 0); /* three pairs measured, then none */
    pave_result result = PAVE_OK;
    other->missing = pv_allocate(*state, PAIRS, 1, &result);
    memset(other->missing, 1, PAIRS);
    other->missing[7] = other->missing[40] = other->missing[99] = 0;
    how.mode = PAVE_BTF_PAPER;
    expect_refused(*state, model, other, &how, "at least 4");
    how.mode = PAVE_BTF_PROJECT;
    expect_refused(*state, model, other, &how, "complete");
    assert_int_equal(pave_btf_model_create(*state, (const pave_btf *const *)&other, 1, &params, &wrong),
                     PAVE_ERR_ARGUMENT);
    other->missing[7] = other->missing[40] = other->missing[99] = 1;
    expect_refused(*state, model, other, NULL, "not one pair");
    pave_btf_free(&other);

    how.mode = PAVE_BTF_BEST;
    how.samples = 5;
    expect_refused(*state, model, btfs[0], &how, "there is none");
    how.samples = 0;
    how.mode = PAVE_BTF_PAPER; /* errors are the prior's */
    assert_int_equal(pave_btf_reconstruct(*state, model, btfs[0], NULL, &how, &other, &errors), PAVE_ERR_ARGUMENT);
    assert_null(errors);
    params.patch = 2;
    assert_int_equal(pave_btf_model_create(*state, (const pave_btf *const *)btfs, 2, &params, &wrong), PAVE_ERR_ARGUMENT);
    pave_btf_model_free(&model);
    free_all(btfs, 3);
}

/* ---- Threads, memory, stopping ---- */

static pave_btf *whole_job(pave_context *context, pave_btf *const *btfs)
{
    pave_btf_model_params params = PAVE_BTF_MODEL_PARAMS_INIT;
    pave_btf_plan_params planning = PAVE_BTF_PLAN_PARAMS_INIT;
    pave_btf_model *model = NULL;
    pave_btf_plan *plan = NULL;
    pave_btf *out = NULL;
    params.material = 8;
    params.abrdfs = 12;
    params.components = 16;
    planning.samples = 20;
    if (!pave_btf_model_create(context, (const pave_btf *const *)btfs, 2, &params, &model) &&
        !pave_btf_plan_create(context, model, &planning, &plan))
        pave_btf_reconstruct(context, model, btfs[0], plan, NULL, &out, NULL);
    pave_btf_plan_free(&plan);
    pave_btf_model_free(&model);
    return out;
}

static void threads_do_not_matter(void **state)
{
    needs_algebra(*state);
    pave_context *one = make_context(1, PAVE_BACKEND_CPU), *seven = make_context(7, PAVE_BACKEND_CPU);
    pave_btf *btfs[2] = { material(*state, PAVE_BTF_COBBLE, 7, 1), material(*state, PAVE_BTF_COBBLE, 7, 2) };
    pave_btf *a = whole_job(one, btfs), *b = whole_job(seven, btfs);
    assert_true(a && b);
    assert_memory_equal(a->samples.first, b->samples.first, (size_t)pv_btf_texels(a) * a->samples.texel_bytes);
    pave_btf_free(&a);
    pave_btf_free(&b);
    free_all(btfs, 2);
    pave_context_free(&one);
    pave_context_free(&seven);
}

static void running_out_of_memory_leaks_nothing(void **state)
{
    needs_algebra(*state);
    pave_btf *btfs[2] = { low_rank(*state, 6, 1, 0.1f), low_rank(*state, 6, 2, 0.1f) };
    failing memory = { .calls = 0 };
    pave_context_params params = failing_params(&memory);
    pave_context *context = NULL;
    assert_ok(pave_context_create(&params, &context));
    pave_btf *out = whole_job(context, btfs);
    assert_non_null(out);
    pave_btf_free(&out);
    int64_t calls = memory.calls, held = memory.blocks;
    for (int64_t at = 1; at < calls; at += calls / 90 + 1) {
        memory.calls = 0;
        memory.fail_at = at;
        out = whole_job(context, btfs);
        pave_btf_free(&out);
        assert_int_equal(memory.blocks, held);
    }
    memory.fail_at = 0;
    pave_context_free(&context);
    assert_int_equal(memory.blocks, 0);
    free_all(btfs, 2);
}

static int32_t stop_at(void *user, const char *stage, double done)
{
    (void)stage;
    return done >= *(const double *)user;
}

static void it_stops_when_told(void **state)
{
    needs_algebra(*state);
    pave_btf *btfs[2] = { material(*state, PAVE_BTF_TILE, 7, 1), material(*state, PAVE_BTF_TILE, 7, 2) };
    double when = 0.3;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    pave_context *context = NULL;
    pave_btf_model *model = NULL;
    params.progress = stop_at;
    params.progress_user = &when;
    assert_ok(pave_context_create(&params, &context));
    assert_int_equal(pave_btf_model_create(context, (const pave_btf *const *)btfs, 2, NULL, &model),
                     PAVE_ERR_CANCELLED);
    assert_null(model);
    pave_context_free(&context);
    free_all(btfs, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(symmetries_are_those_of_the_directions),
        cmocka_unit_test(blocks_of_parity_are_the_copies),
        cmocka_unit_test(a_material_can_be_left_out),
        cmocka_unit_test(settings_are_those_of_most_materials),
        cmocka_unit_test(a_model_has_the_rank_of_its_class),
        cmocka_unit_test(greedy_plans_leave_least_unknown),
        cmocka_unit_test(plans_are_what_they_say),
        cmocka_unit_test(the_parabolic_map_is_the_papers),
        cmocka_unit_test(a_low_rank_material_comes_back),
        cmocka_unit_test(a_relief_comes_back_as_far_as_its_class_is_known),
        cmocka_unit_test(samples_that_are_no_numbers_are_mended),
        cmocka_unit_test(classes_are_found),
        cmocka_unit_test(models_come_back_from_files),
        cmocka_unit_test(damaged_models_are_refused),
        cmocka_unit_test(plans_come_back_from_files),
        cmocka_unit_test(what_cannot_be_is_refused),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(running_out_of_memory_leaks_nothing),
        cmocka_unit_test(it_stops_when_told),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
