/* Bidirectional texture functions: directions, the generator against what is known of light, factors, files. */
#include "test.h"

#include "btf/algebra.h"
#include "btf/btf.h"
#include "btf/scene.h"
#include "image/image.h"

#include <math.h>
#include <unistd.h>

static pave_btf *synthesize(pave_context *context, pave_btf_synthesis_params params)
{
    pave_btf *btf = NULL;
    assert_ok(pave_btf_synthesize(context, &params, &btf));
    return btf;
}

static pave_btf_synthesis_params params_of(int32_t class_of, int32_t texels)
{
    pave_btf_synthesis_params params = PAVE_BTF_SYNTHESIS_PARAMS_INIT;
    params.class_of = class_of;
    params.texels = texels;
    return params;
}

static void direction_sets_are_those_of_the_devices(void **state)
{
    (void)state;
    pave_direction d[151];
    assert_int_equal(pave_directions(PAVE_DIRECTIONS_UBO81, d, 151), 81);
    assert_true(fabs(d[80].theta - 75 * M_PI / 180) < 1e-6 && fabs(d[80].phi + 15 * M_PI / 180) < 1e-6);
    assert_int_equal(pave_directions(PAVE_DIRECTIONS_DOME151, d, 151), 151);
    assert_true(fabs(d[1].theta - 11 * M_PI / 180) < 1e-6 && fabs(d[1].phi - 15 * M_PI / 180) < 1e-6);
    assert_int_equal(pave_directions(7, d, 151), 0);
    assert_int_equal(pave_directions(PAVE_DIRECTIONS_UBO81, NULL, 0), 81);
}

/* Weights are a partition of unity, reproduce linear functions of the plane, and are 1 at a direction itself. */
static void weights_interpolate(void **state)
{
    pave_btf *btf = synthesize(*state, params_of(PAVE_BTF_FLAT, 1));
    const pave_direction *views = pave_btf_view_directions(btf);
    int32_t index[3];
    double weight[3];
    for (int32_t i = 0; i < pave_btf_views(btf); i++) {
        pave_btf_weights(btf, 0, views[i], index, weight);
        double own = 0;
        for (int k = 0; k < 3; k++)
            own += index[k] == i ? weight[k] : 0;
        assert_true(fabs(own - 1) < 1e-6);
    }
    for (int t = 0; t < 3000; t++) {
        pave_direction d = { (float)(t % 89) * 0.0135f, (float)t * 0.37f };
        pave_btf_weights(btf, 1, d, index, weight);
        double sum = 0, x = 0, y = 0;
        for (int k = 0; k < 3; k++) {
            double radius = tan(views[index[k]].theta / 2.0);
            assert_true(weight[k] >= 0 && index[k] >= 0 && index[k] < 81);
            sum += weight[k];
            x += weight[k] * radius * cos(views[index[k]].phi);
            y += weight[k] * radius * sin(views[index[k]].phi);
        }
        assert_true(fabs(sum - 1) < 1e-12);
        double radius = tan(d.theta / 2.0);
        if (d.theta < 70 * M_PI / 180) /* within the lowest ring */
            assert_true(fabs(x - radius * cos(d.phi)) < 1e-5 && fabs(y - radius * sin(d.phi)) < 1e-5);
    }
    pave_btf_free(&btf);
}

static void directions_that_cannot_be_are_refused(void **state)
{
    pave_btf_params params = PAVE_BTF_PARAMS_INIT;
    pave_direction one[2] = { { 0, 0 }, { 0.5f, 1 } }, twice[2] = { { 0, 0 }, { 0, 1 } }, below[2] = { { 0, 0 }, { 2, 0 } };
    pave_direction nan[2] = { { 0, 0 }, { NAN, 0 } };
    pave_btf *btf = NULL;
    params.width = params.height = 2;
    params.views = params.lights = 2;
    params.view_directions = params.light_directions = one;
    assert_ok(pave_btf_create(*state, &params, NULL, &btf));
    pave_btf_free(&btf);
    const pave_direction *bad[3] = { twice, below, nan };
    for (int i = 0; i < 3; i++) {
        params.light_directions = bad[i];
        assert_int_equal(pave_btf_create(*state, &params, NULL, &btf), PAVE_ERR_FORMAT);
        assert_null(btf);
    }
    params.light_directions = one;
    params.width = 1 << 20;
    params.height = 1 << 20;
    assert_int_equal(pave_btf_create(*state, &params, NULL, &btf), PAVE_ERR_LIMIT);
}

/* Every ABRDF of a plane of one material is its BRDF times the cosine, and reciprocal without it. */
static void a_plane_of_one_material_is_its_brdf(void **state)
{
    pave_btf *btf = synthesize(*state, params_of(PAVE_BTF_FLAT, 4));
    int32_t n = pave_btf_views(btf);
    const pave_direction *d = pave_btf_view_directions(btf);
    float *first = malloc((size_t)(n * n * 3) * sizeof *first), *other = malloc((size_t)(n * n * 3) * sizeof *other);
    pave_btf_abrdf(btf, 0, 0, first);
    pave_btf_abrdf(btf, 3, 2, other);
    for (int32_t i = 0; i < n * n * 3; i++)
        assert_true(fabsf(first[i] - other[i]) <= 1e-3f * first[i]);
    for (int32_t v = 0; v < n; v++)
        for (int32_t l = 0; l < v; l++) {
            double a = first[3 * (v * n + l)] / cos(d[l].theta), b = first[3 * (l * n + v)] / cos(d[v].theta);
            assert_true(fabs(a - b) < 2e-3 * a); /* halves */
        }
    free(first);
    free(other);
    pave_btf_free(&btf);
}

static double reciprocity(pave_context *context, int32_t texels)
{
    pave_btf_synthesis_params params = params_of(PAVE_BTF_COBBLE, texels);
    params.bounces = 0;
    params.samples = 2;
    pave_btf *btf = synthesize(context, params);
    int32_t n = pave_btf_views(btf);
    const pave_direction *d = pave_btf_view_directions(btf);
    double *mean = calloc((size_t)(n * n), sizeof *mean), wrong = 0, whole = 0;
    float *values = malloc((size_t)(n * n * 3) * sizeof *values);
    for (int32_t t = 0; t < texels * texels; t++) {
        pave_btf_abrdf(btf, t % texels, t / texels, values);
        for (int32_t i = 0; i < n * n; i++)
            mean[i] += values[3 * i];
    }
    for (int32_t v = 0; v < n; v++)
        for (int32_t l = 0; l < n; l++) {
            double a = mean[v * n + l] / cos(d[l].theta), b = mean[l * n + v] / cos(d[v].theta);
            wrong += (a - b) * (a - b);
            whole += a * a;
        }
    free(mean);
    free(values);
    pave_btf_free(&btf);
    return sqrt(wrong / whole);
}

/* Any periodic relief is reciprocal on the mean over its texels, although no texel is. */
static void the_mean_is_reciprocal_and_the_more_so_the_finer(void **state)
{
    not_for_threads();
    double coarse = reciprocity(*state, 12), fine = reciprocity(*state, 36);
    assert_true(fine < 0.015 && fine < coarse);
}

/* In a furnace, where light comes from everywhere and nothing is absorbed, every point sends what reaches it. */
static void a_white_furnace_shows_nothing(void **state)
{
    pave_btf_synthesis_params params = params_of(PAVE_BTF_GRAVEL, 16);
    pave_direction up = { 0, 0 };
    pv_scene *scene = NULL;
    params.bounces = 0;
    params.rays = 64;
    assert_ok(pv_scene_create(*state, &params, &up, 1, 1, &scene));
    int32_t points = scene->relief.side * scene->relief.side, *seen = malloc((size_t)points * 64 * sizeof *seen);
    double *sent = calloc((size_t)points, sizeof *sent), *next = calloc((size_t)points, sizeof *next);
    int32_t hits = 0;
    for (int32_t p = 0; p < points; p++)
        pv_scene_sight(scene, p, seen + 64 * p);
    for (int round = 0; round < 60; round++) {
        for (int32_t p = 0; p < points; p++) {
            double sum = 0;
            for (int k = 0; k < 64; k++)
                sum += seen[64 * p + k] < 0 ? 1 : sent[seen[64 * p + k]];
            next[p] = sum / 64;
        }
        memcpy(sent, next, (size_t)points * sizeof *sent);
    }
    for (int32_t p = 0; p < points; p++)
        assert_true(fabs(sent[p] - 1) < 1e-3);
    for (int32_t i = 0; i < points * 64; i++)
        hits += seen[i] >= 0;
    assert_true(hits > points * 8); /* the relief does hide much of the sky */
    free(seen);
    free(sent);
    free(next);
    pv_scene_free(&scene);
}

/* A step of the relief casts a shadow that is as long as its height says. */
static void shadows_have_the_length_of_geometry(void **state)
{
    pave_btf_synthesis_params params = params_of(PAVE_BTF_TILE, 32);
    pave_direction low = { 60 * (float)M_PI / 180, 0 }; /* from the right: x grows towards the light */
    pv_scene *scene = NULL;
    params.bounces = 0;
    assert_ok(pv_scene_create(*state, &params, &low, 1, 1, &scene));
    const pv_relief *r = &scene->relief;
    double wrong = 0;
    for (int32_t p = 0; p < r->side * r->side; p++) {
        float most = -INFINITY;
        for (int32_t t = 1; t < 200; t++) {
            int32_t x = (p % r->side + t) % r->side;
            most = fmaxf(most, r->height[p / r->side * r->side + x] - (float)t * r->spacing / tanf(low.theta));
        }
        int by_hand = most > r->height[p] + 0.05f, told = scene->shade[p] > r->height[p] + 0.05f;
        wrong += by_hand != told;
    }
    assert_true(wrong == 0);
    pv_scene_free(&scene);
}

static double difference(pave_context *context, const pave_btf *a, const pave_btf *b)
{
    int64_t length = pv_btf_length(a);
    float *x = malloc((size_t)length * sizeof *x), *y = malloc((size_t)length * sizeof *y);
    double most = 0;
    (void)context;
    for (int32_t t = 0; t < pave_btf_width(a) * pave_btf_height(a); t++) {
        pave_btf_abrdf(a, t % a->width, t / a->width, x);
        pave_btf_abrdf(b, t % a->width, t / a->width, y);
        for (int64_t i = 0; i < length; i++)
            most = fmax(most, fabs((double)x[i] - y[i]) / (fabs(x[i]) + 1e-3));
    }
    free(x);
    free(y);
    return most;
}

static int has_algebra(pave_context *context)
{
    pv_algebra algebra;
    if (pv_algebra_open(context, &algebra))
        return 0;
    pv_algebra_close(&algebra);
    return 1;
}

/* A plane of k minerals has rank k, filtered or not: k components hold it. */
static void minerals_have_the_rank_of_their_number(void **state)
{
    not_for_threads();
    if (!has_algebra(*state))
        skip();
    pave_btf *btf = synthesize(*state, params_of(PAVE_BTF_MINERALS, 16)), *small = NULL;
    pave_btf_compress_params params = PAVE_BTF_COMPRESS_PARAMS_INIT;
    params.colour = PAVE_BTF_COLOUR_PLAIN;
    params.components = 4;
    params.type = PAVE_F32;
    assert_ok(pave_btf_compress(*state, btf, &params, &small));
    for (int32_t c = 0; c < 3; c++)
        assert_true(pave_btf_error(small, c) < 1e-3);
    pave_btf_free(&small);
    params.components = 2;
    assert_ok(pave_btf_compress(*state, btf, &params, &small));
    assert_true(pave_btf_error(small, 0) > 1e-3);
    pave_btf_free(&small);
    pave_btf_free(&btf);
}

/* The error by the full singular value decomposition: of the Gram matrix of texels, in double. */
static double exact_error(pave_context *context, const pave_btf *btf, int32_t components)
{
    int32_t n = btf->width * btf->height;
    int64_t length = pv_btf_length(btf), pairs = length / 3;
    float *samples = malloc((size_t)length * sizeof *samples), *coded = malloc((size_t)length * sizeof *coded);
    double *rows = malloc((size_t)n * (size_t)pairs * sizeof *rows), *gram = malloc((size_t)(n * n) * sizeof *gram);
    double *values = malloc((size_t)n * sizeof *values), whole = 0, left = 0;
    for (int32_t t = 0; t < n; t++) {
        pave_btf_abrdf(btf, t % btf->width, t / btf->width, samples);
        pv_colour_encode(PV_COLOUR_LOG_YUV, PV_LEAST_LIGHT, 3, samples, pairs, coded);
        for (int64_t p = 0; p < pairs; p++)
            rows[t * pairs + p] = coded[3 * p];
    }
    pv_algebra algebra;
    assert_ok(pv_algebra_open(context, &algebra));
    pv_multiply_double(&algebra, 0, 1, n, n, (int)pairs, rows, (int)pairs, rows, (int)pairs, 0, gram, n);
    assert_ok(pv_eigen(context, &algebra, n, gram, values));
    pv_algebra_close(&algebra);
    for (int32_t i = 0; i < n; i++) {
        whole += values[i];
        left += i < components ? 0 : fmax(values[i], 0);
    }
    free(samples);
    free(coded);
    free(rows);
    free(gram);
    free(values);
    return sqrt(left / whole);
}

static void compression_is_within_a_hundredth_of_the_exact(void **state)
{
    not_for_threads();
    if (!has_algebra(*state))
        skip();
    pave_btf *btf = synthesize(*state, params_of(PAVE_BTF_GRAVEL, 16)), *small = NULL;
    pave_btf_compress_params params = PAVE_BTF_COMPRESS_PARAMS_INIT;
    params.components = 24;
    assert_ok(pave_btf_compress(*state, btf, &params, &small));
    double exact = exact_error(*state, btf, 24);
    assert_true(pave_btf_error(small, 0) < 1.01 * exact && pave_btf_error(small, 0) > 0.999 * exact);
    pave_btf_free(&small);
    params.components = 256;
    params.error = 0.1;
    assert_ok(pave_btf_compress(*state, btf, &params, &small));
    assert_true(pave_btf_error(small, 0) <= 0.1 && exact_error(*state, btf, pave_btf_components(small, 0) - 1) > 0.099);
    pave_btf_free(&small);
    pave_btf_free(&btf);
}

static void threads_do_not_matter(void **state)
{
    pave_context *one = make_context(1, PAVE_BACKEND_CPU), *seven = make_context(7, PAVE_BACKEND_CPU);
    int32_t side = THREAD_SANITIZED ? 5 : 10;
    size_t texels = (size_t)(side * side);
    pave_btf *a = synthesize(one, params_of(PAVE_BTF_ASPHALT, side));
    pave_btf *b = synthesize(seven, params_of(PAVE_BTF_ASPHALT, side));
    assert_memory_equal(a->samples.first, b->samples.first, texels * a->samples.texel_bytes);
    if (has_algebra(*state)) {
        pave_btf *x = NULL, *y = NULL;
        assert_ok(pave_btf_compress(one, a, NULL, &x));
        assert_ok(pave_btf_compress(seven, b, NULL, &y));
        for (int32_t c = 0; c < 3; c++) {
            size_t k = (size_t)x->factors[c].components;
            assert_memory_equal(x->factors[c].left, y->factors[c].left, (size_t)pv_btf_rows(x) * k * sizeof(float));
            assert_memory_equal(x->factors[c].right, y->factors[c].right, texels * k * sizeof(float));
        }
        pave_btf_free(&x);
        pave_btf_free(&y);
    }
    pave_btf_free(&a);
    pave_btf_free(&b);
    pave_context_free(&one);
    pave_context_free(&seven);
}

/* Through BDI nothing is lost; a BTF that is made as it is read is the same as a stored one. */
static void samples_come_back_from_files(void **state)
{
    char path[] = "/tmp/pave-btf-XXXXXX.bdi";
    int file = mkstemps(path, 4);
    pave_btf_synthesis_params params = params_of(PAVE_BTF_CONCRETE, 9);
    pave_btf *stored = synthesize(*state, params), *read = NULL;
    params.stored = 0;
    pave_btf *made = synthesize(*state, params);
    close(file);
    assert_ok(pave_btf_write(*state, made, NULL, path));
    assert_ok(pave_btf_read(*state, path, NULL, &read));
    assert_true(difference(*state, stored, read) == 0);
    float a[3], b[3], *texture = malloc(81 * 3 * sizeof *texture);
    pave_btf_texture(read, 17, 5, texture);
    pave_btf_lookup(read, 4, 3, pave_btf_view_directions(read)[17], pave_btf_light_directions(read)[5], a);
    pave_btf_lookup(made, 4, 3, pave_btf_view_directions(read)[17], pave_btf_light_directions(read)[5], b);
    for (int c = 0; c < 3; c++)
        assert_true(fabsf(a[c] - texture[3 * (3 * 9 + 4) + c]) < 1e-5f && fabsf(a[c] - b[c]) < 1e-3f * b[c] + 1e-5f);
    free(texture);
    unlink(path);
    pave_btf_free(&stored);
    pave_btf_free(&made);
    pave_btf_free(&read);
}

static void factors_come_back_from_files(void **state)
{
    not_for_threads();
    if (!has_algebra(*state))
        skip();
    pave_btf *btf = synthesize(*state, params_of(PAVE_BTF_SAWN, 8));
    for (int joint = 0; joint < 2; joint++) {
        char path[] = "/tmp/pave-btf-XXXXXX.btf";
        pave_btf_compress_params params = PAVE_BTF_COMPRESS_PARAMS_INIT;
        pave_btf *small = NULL, *read = NULL;
        close(mkstemps(path, 4));
        params.type = PAVE_F32;
        params.components = 128; /* all there are, for U/Y and V/Y too */
        params.joint = joint;
        assert_ok(pave_btf_compress(*state, btf, &params, &small));
        assert_ok(pave_btf_write(*state, small, NULL, path));
        assert_ok(pave_btf_read(*state, path, NULL, &read));
        assert_true(difference(*state, small, read) == 0);
        assert_true(difference(*state, btf, read) < 0.01);
        unlink(path);
        pave_btf_free(&small);
        pave_btf_free(&read);
    }
    pave_btf_free(&btf);
}

static void put(const char *path, const char *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    fwrite(bytes, 1, size, file);
    fclose(file);
}

/* Every prefix of a file, and every file with one word of its head changed, is refused or read, and never more than
 * that. */
static void sweep(pave_context *context, const pave_btf *btf, const char *path, size_t head)
{
    static char bytes[1 << 16], changed[1 << 16];
    pave_btf *read = NULL;
    assert_ok(pave_btf_write(context, btf, NULL, path));
    FILE *file = fopen(path, "rb");
    size_t size = fread(bytes, 1, sizeof bytes, file), kept = 0, tried = 0;
    fclose(file);
    assert_true(size < sizeof bytes);
    head = head < size ? head : size;
    for (size_t cut = 1; cut < size; cut += cut < 600 ? 7 : size < 8192 ? 1 : 97) {
        put(path, bytes, cut);
        assert_int_equal(pave_btf_read(context, path, NULL, &read), PAVE_ERR_FORMAT);
        assert_null(read);
    }
    for (size_t at = 10; at + 4 <= head; at += 2, tried++) {
        memcpy(changed, bytes, size);
        memset(changed + at, at % 4 ? 0xFF : 0x7F, 4);
        put(path, changed, size);
        kept += pave_btf_read(context, path, NULL, &read) == PAVE_OK;
        pave_btf_free(&read);
    }
    assert_true(kept > 0 && kept < tried);
    unlink(path);
}

static void damaged_files_are_refused(void **state)
{
    char path[] = "/tmp/pave-btf-XXXXXX.btf", bdi[64];
    pave_btf_params shape = PAVE_BTF_PARAMS_INIT;
    pave_direction d[3] = { { 0, 0 }, { 0.5f, 1 }, { 0.7f, 3 } };
    pave_btf *btf = NULL, *small = NULL;
    pave_context_params quiet = PAVE_CONTEXT_PARAMS_INIT;
    pave_context *context = NULL;
    float samples[3 * 3 * 9 * 3];
    assert_ok(pave_context_create(&quiet, &context)); /* the test's own would print thousands of sentences */
    close(mkstemps(path, 4));
    snprintf(bdi, sizeof bdi, "%s.bdi", path);
    shape.width = shape.height = 3;
    shape.type = PAVE_F32;
    shape.views = shape.lights = 3;
    shape.view_directions = shape.light_directions = d;
    for (size_t i = 0; i < sizeof samples / sizeof *samples; i++)
        samples[i] = 0.1f + (float)(i * 7919 % 101) / 101;
    assert_ok(pave_btf_create(context, &shape, samples, &btf));
    sweep(context, btf, bdi, SIZE_MAX);
    for (int joint = 0; joint < 2 && has_algebra(*state); joint++) {
        pave_btf_compress_params params = PAVE_BTF_COMPRESS_PARAMS_INIT;
        params.components = 3;
        params.joint = joint;
        assert_ok(pave_btf_compress(context, btf, &params, &small));
        sweep(context, small, path, 600);
        pave_btf_free(&small);
    }
    unlink(path);
    pave_btf_free(&btf);
    samples[27 * 5 + 4] = NAN;
    assert_ok(pave_btf_create(context, &shape, samples, &btf));
    if (has_algebra(*state)) {
        assert_int_equal(pave_btf_compress(context, btf, NULL, &small), PAVE_ERR_FORMAT);
        assert_non_null(strstr(pave_context_message(context), "texel 2,1 "));
    }
    pave_btf_free(&btf);
    pave_context_free(&context);
}

/* The singular values of two materials side by side, by the exact decomposition of all their texels. */
static void exact_values(pave_context *context, const pave_btf *const *btfs, int32_t channel, double *values)
{
    int32_t n = 0;
    int64_t length = pv_btf_length(btfs[0]), pairs = length / 3;
    float *samples = malloc((size_t)length * sizeof *samples), *coded = malloc((size_t)length * sizeof *coded);
    double *rows = malloc(128 * (size_t)pairs * sizeof *rows), *gram = malloc(128 * 128 * sizeof *gram);
    for (int b = 0; b < 2; b++)
        for (int32_t t = 0; t < 64; t++, n++) {
            pave_btf_abrdf(btfs[b], t % 8, t / 8, samples);
            pv_colour_encode(PV_COLOUR_LOG_YUV, PV_LEAST_LIGHT, 3, samples, pairs, coded);
            for (int64_t p = 0; p < pairs; p++)
                rows[n * pairs + p] = coded[3 * p + channel];
        }
    pv_algebra algebra;
    assert_ok(pv_algebra_open(context, &algebra));
    pv_multiply_double(&algebra, 0, 1, n, n, (int)pairs, rows, (int)pairs, rows, (int)pairs, 0, gram, n);
    assert_ok(pv_eigen(context, &algebra, n, gram, values));
    pv_algebra_close(&algebra);
    free(samples);
    free(coded);
    free(rows);
    free(gram);
}

/* Merging all components of two materials gives the decomposition of both, and loses nothing. */
static void merging_is_the_svd_of_the_concatenation(void **state)
{
    if (!has_algebra(*state))
        skip();
    pave_btf *btf[2], *small[2] = { NULL, NULL }, *merged = NULL;
    pave_btf_compress_params params = PAVE_BTF_COMPRESS_PARAMS_INIT;
    params.type = PAVE_F32;
    params.components = params.second = params.third = 64;
    for (int i = 0; i < 2; i++) {
        btf[i] = synthesize(*state, params_of(i ? PAVE_BTF_COBBLE : PAVE_BTF_GRAVEL, 8));
        assert_ok(pave_btf_compress(*state, btf[i], &params, &small[i]));
    }
    const pave_btf *const all[2] = { small[0], small[1] }, *const exact[2] = { btf[0], btf[1] };
    assert_ok(pave_btf_merge(*state, all, 2, 128, &merged));
    assert_int_equal(pave_btf_height(merged), 16);
    for (int32_t c = 0; c < 3; c++) {
        double values[128];
        exact_values(*state, exact, c, values);
        for (int k = 0; k < 128; k++)
            assert_true(fabs((double)merged->factors[c].singular[k] - sqrt(fmax(values[k], 0))) < 1e-4 * sqrt(values[0]));
    }
    for (int i = 0; i < 2; i++)
        for (int64_t t = 0; t < 64; t += 9)
            for (int64_t p = 0; p < 81 * 81; p += 37) {
                float x[3], y[3];
                pv_btf_sample(small[i], t, p, x);
                pv_btf_sample(merged, 64 * i + t, p, y);
                for (int c = 0; c < 3; c++)
                    assert_true(fabsf(x[c] - y[c]) < 2e-3f * fabsf(x[c]) + 1e-4f);
            }
    pave_btf_free(&merged);
    assert_ok(pave_btf_merge(*state, all, 2, 10, &merged));
    assert_true(pave_btf_components(merged, 0) == 10 && pave_btf_error(merged, 0) > 0);
    pave_btf_free(&merged);
    for (int i = 0; i < 2; i++) {
        pave_btf_free(&small[i]);
        pave_btf_free(&btf[i]);
    }
}

/* White and diffuse: albedo 1, reciprocal; what is done to it is found. */
static void diagnosis_finds_what_was_done(void **state)
{
    pave_direction d[81];
    pave_btf_params shape = PAVE_BTF_PARAMS_INIT;
    pave_btf_diagnosis found = { .size = sizeof found };
    pave_btf_texels_params all = PAVE_BTF_TEXELS_PARAMS_INIT;
    pave_btf *btf = NULL;
    float values[81 * 81 * 3];
    all.texels = 0;
    shape.width = shape.height = 2;
    shape.type = PAVE_F32;
    shape.views = shape.lights = pave_directions(PAVE_DIRECTIONS_UBO81, d, 81);
    shape.view_directions = shape.light_directions = d;
    assert_ok(pave_btf_create(*state, &shape, NULL, &btf));
    for (int i = 0; i < 81 * 81 * 3; i++)
        values[i] = (float)(cos(d[i / 3 % 81].theta) / M_PI);
    for (int t = 0; t < 4; t++)
        pv_btf_put(btf, t, 0, 81 * 81 * 3, values);
    assert_ok(pave_btf_diagnose(*state, btf, &all, &found));
    assert_true(fabs(found.albedo - 1) < 1e-6 && found.reciprocity < 1e-6 && found.view_set == PAVE_DIRECTIONS_UBO81);
    assert_true(found.samples == 4 * 81 * 81 * 3 && !found.missing && !found.negative && !found.not_finite);
    assert_true(found.saturated == 4 * 81 * 3); /* the light at the pole */
    values[3 * 81 * 40 + 7] = NAN, values[5] = -1;
    for (int i = 0; i < 81 * 3; i++)
        values[80 * 81 * 3 + i] *= 2; /* one view is too bright */
    pv_btf_put(btf, 3, 0, 81 * 81 * 3, values);
    assert_ok(pave_btf_diagnose(*state, btf, &all, &found));
    assert_true(found.negative == 1 && found.not_finite == 1 && found.least == -1);
    assert_true(found.albedo_over >= 3.0 / (4 * 81 * 3) - 1e-12);
    pave_btf_difference same = { .size = sizeof same };
    assert_ok(pave_btf_measure(*state, btf, btf, NULL, &same));
    assert_true(same.direction_error == 0);
    pave_btf_free(&btf);
}

static double pixel(const pave_image *image, int32_t x, int32_t y, int32_t c)
{
    return pv_image_value(image, ((int64_t)y * image->width + x) * image->channels + c);
}

static pave_result draw(pave_context *context, const pave_btf *btf, const pave_image *sky, pave_image **out)
{
    pave_btf_view_params params = PAVE_BTF_VIEW_PARAMS_INIT;
    params.side = 20;
    params.view_theta = 20;
    return pave_btf_view(context, btf, sky, &params, out);
}

/* What a graphics device draws is what the processor draws, but for rounding. */
static void a_device_draws_the_same(void **state)
{
    if (SANITIZED || !has_algebra(*state))
        skip(); /* drivers leak, and lock as they like */
    pave_context *device = make_context(2, PAVE_BACKEND_VULKAN_COMPUTE);
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    uint8_t pixels[4 * 8 * 3];
    pave_image *sky = NULL;
    shape.width = 8, shape.height = 4, shape.channels = 3;
    for (size_t i = 0; i < sizeof pixels; i++)
        pixels[i] = (uint8_t)(i * 37);
    assert_ok(pave_image_create(*state, &shape, pixels, &sky));
    pave_btf *btf = synthesize(*state, params_of(PAVE_BTF_GRAVEL, 8)), *small = NULL;
    pave_result result = PAVE_OK;
    for (int k = 0; k < 4 && !result; k++) {
        pave_btf_compress_params params = PAVE_BTF_COMPRESS_PARAMS_INIT;
        pave_image *here = NULL, *there = NULL;
        params.components = 12;
        params.joint = k / 2;
        assert_ok(pave_btf_compress(*state, btf, &params, &small));
        assert_ok(draw(*state, small, k % 2 ? sky : NULL, &here));
        result = draw(device, small, k % 2 ? sky : NULL, &there);
        const float *a = here->pixels, *b = result ? a : there->pixels;
        for (int32_t i = 0; i < 20 * 20 * 4; i++)
            assert_true(fabs((double)a[i] - b[i]) <= 1e-5 * (1 + fabs((double)a[i])));
        pave_image_free(&here);
        pave_image_free(&there);
        pave_btf_free(&small);
    }
    assert_true(!result || result == PAVE_ERR_DEVICE || result == PAVE_ERR_UNSUPPORTED);
    print_message(result ? "skipped: %s\n" : "", pave_context_message(device));
    pave_image_free(&sky);
    assert_int_equal(draw(device, btf, NULL, &sky), PAVE_ERR_UNSUPPORTED); /* its samples are not factored */
    pave_btf_free(&btf);
    pave_context_free(&device);
}

/* A disc shows a view's samples where their lights are; a contact sheet its textures; a BTF differs not from itself. */
static void sheets_show_the_samples(void **state)
{
    pave_btf *btf = synthesize(*state, params_of(PAVE_BTF_TILE, 4));
    pave_btf_sheet_params params = PAVE_BTF_SHEET_PARAMS_INIT;
    pave_btf_view_params view = PAVE_BTF_VIEW_PARAMS_INIT;
    pave_image *image = NULL;
    float values[3];
    params.x = 1, params.y = 2, params.tile = 401, params.views = 2;
    assert_ok(pave_btf_plot(*state, btf, &params, &image));
    for (int32_t l = 0; l < 81; l++) {
        const pave_direction *d = &pave_btf_light_directions(btf)[l];
        double r = tan(d->theta / 2.0) * 200.5;
        pv_btf_sample(btf, 9, 80 * 81 + l, values);
        double shown = pixel(image, 403 + (int32_t)(200.5 + r * cos(d->phi)), (int32_t)(200.5 - r * sin(d->phi)), 1);
        assert_true(fabs(shown - M_PI * values[1]) < 0.03 * M_PI * values[1] + 0.003);
    }
    pave_image_free(&image);
    params.tile = 4, params.lights = 81;
    assert_ok(pave_btf_contact_sheet(*state, btf, &params, &image));
    assert_int_equal(image->width, 81 * 6 - 2);
    pv_btf_sample(btf, 9, 80 * 81 + 33, values);
    assert_true(fabs(pixel(image, 33 * 6 + 1, 6 + 2, 2) - M_PI * values[2]) < 1e-5);
    pave_image_free(&image);
    view.side = 24;
    assert_ok(pave_btf_view_difference(*state, btf, btf, NULL, &view, 20, &image));
    assert_true(pixel(image, 12, 12, 0) == 0 && pixel(image, 12, 12, 3) == 1);
    pave_image_free(&image);
    pave_btf_free(&btf);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(direction_sets_are_those_of_the_devices),
        cmocka_unit_test(weights_interpolate),
        cmocka_unit_test(directions_that_cannot_be_are_refused),
        cmocka_unit_test(a_plane_of_one_material_is_its_brdf),
        cmocka_unit_test(the_mean_is_reciprocal_and_the_more_so_the_finer),
        cmocka_unit_test(a_white_furnace_shows_nothing),
        cmocka_unit_test(shadows_have_the_length_of_geometry),
        cmocka_unit_test(minerals_have_the_rank_of_their_number),
        cmocka_unit_test(compression_is_within_a_hundredth_of_the_exact),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(samples_come_back_from_files),
        cmocka_unit_test(factors_come_back_from_files),
        cmocka_unit_test(damaged_files_are_refused),
        cmocka_unit_test(merging_is_the_svd_of_the_concatenation),
        cmocka_unit_test(diagnosis_finds_what_was_done),
        cmocka_unit_test(a_device_draws_the_same),
        cmocka_unit_test(sheets_show_the_samples),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
