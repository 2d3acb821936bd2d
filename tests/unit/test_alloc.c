/* Allocation failures: every allocation of the whole job, of tilings, and of maps and models, fails once; the call must fail cleanly, leak
 * nothing, leave the context usable, and give the same the next time. */
#include "failing.h"

static uint64_t lay_once(pave_context *context, int32_t round, pave_result *result)
{
    pave_field_params field = PAVE_FIELD_PARAMS_INIT;
    pave_lay_params params = PAVE_LAY_PARAMS_INIT;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    pave_stones *stones = NULL;
    uint64_t hash = 0;
    uint8_t pixels[40 * 30];
    for (int i = 0; i < 40 * 30; i++)
        pixels[i] = i % 40 < 17 ? 0 : 255;
    shape.width = 40;
    shape.height = 30;
    field.metric = round == 1;
    field.periodic = round == 3;
    params.field = &field;
    pave_cvd_params cvd = PAVE_CVD_PARAMS_INIT;
    cvd.half_side = round == 3 ? 2 : 4;
    cvd.iterations = round < 2 ? 20 : 1;
    params.cvd = &cvd;
    pave_stones_params how = PAVE_STONES_PARAMS_INIT; /* in paper mode, in colours, in best mode, and where it repeats */
    how.mode = round < 2 ? PAVE_MODE_PAPER : PAVE_MODE_BEST;
    how.thin = round == 3 ? PAVE_THIN_WIDEN : PAVE_THIN_KEEP;
    how.border = PAVE_BORDER_CUT;
    params.stones = &how;
    pave_palette_params palette = PAVE_PALETTE_PARAMS_INIT;
    palette.colours = round == 1 ? 2 : 0;
    params.palette = &palette;
    *result = pave_image_create(context, &shape, pixels, &image);
    if (!*result)
        *result = pave_lay(context, image, &params, &stones);
    if (!*result) {
        pave_stones_measures measures = { .size = sizeof measures };
        *result = pave_stones_measure(context, image, stones, NULL, &measures);
        assert_true(*result || measures.stones > 0);
        hash = hash_bytes(pave_stones_vertices(stones),
                          (size_t)pave_stones_starts(stones)[pave_stones_count(stones)] * 16);
    } else {
        assert_null(stones);
    }
    pave_stones_free(&stones);
    pave_image_free(&image);
    return hash;
}

/* A tiling, its companion, its sources and its judgement: in every mode, with a guide, kept and as a Wang set. */
static uint64_t tile_once(pave_context *context, int32_t round, pave_result *result)
{
    enum { SIDE = 20, FAST = 1, PAPER = 2, GUIDED = 3, KEPT = 4, WANG = 5 };
    uint8_t pixels[SIDE * SIDE];
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
    pave_image *image = NULL, *laid = NULL, *sources = NULL;
    pave_tiling *tiling = NULL;
    uint64_t hash = 0;
    for (int i = 0; i < SIDE * SIDE; i++)
        pixels[i] = (uint8_t)(i % 7 < 2 || i / SIDE % 6 < 2 ? 20 : 100 + i * i % 90);
    shape.width = shape.height = SIDE;
    params.mode = round == FAST || round == PAPER ? round : PAVE_TILING_BEST;
    params.search = round == FAST || round == PAPER ? PAVE_SEARCH_FFT : PAVE_SEARCH_AUTO;
    params.extent[0] = params.extent[1] = round == WANG ? 40 : SIDE;
    params.fraction = round == PAPER ? 8 : 0;
    params.rounds = 2;
    params.keep = round == KEPT;
    params.wang = round == WANG ? 2 : 0;
    *result = pave_image_create(context, &shape, pixels, &image);
    const pave_image *const images[1] = { image };
    if (!*result)
        *result = pave_tiling_create(context, images, 1, round == GUIDED ? image : NULL, &params, &tiling);
    assert_true(!*result == !!tiling);
    if (!*result)
        *result = pave_tiling_apply(context, tiling, images, 1, &laid);
    if (!*result)
        *result = pave_tiling_source_image(context, tiling, &sources);
    if (!*result && !round) {
        pave_tiling_measure measure = { .size = sizeof measure };
        *result = pave_tiling_judge(context, tiling, images, 1, &measure);
    }
    if (!*result)
        hash = hash_bytes(pave_image_pixels(laid), (size_t)params.extent[0] * (size_t)params.extent[1]);
    pave_image_free(&sources);
    pave_image_free(&laid);
    pave_tiling_free(&tiling);
    pave_image_free(&image);
    return hash;
}

/* Maps and a model of some stones, cut from a texture, from a volume, and plain with a colour at each vertex. */
static uint64_t map_once(pave_context *context, int32_t round, pave_result *result)
{
    enum { SIDE = 12, TEXTURE = 0, VOLUME = 1 };
    static const uint8_t values[SIDE * SIDE * SIDE] = { 200, 10, 30, 40 };
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_volume_params box = PAVE_VOLUME_PARAMS_INIT;
    pave_lay_params lay = PAVE_LAY_PARAMS_INIT;
    pave_cvd_params cvd = PAVE_CVD_PARAMS_INIT;
    pave_maps_params params = PAVE_MAPS_PARAMS_INIT;
    pave_model_params model_params = PAVE_MODEL_PARAMS_INIT;
    pave_maps_input input = PAVE_MAPS_INPUT_INIT;
    pave_image *image = NULL;
    pave_volume *volume = NULL;
    pave_stones *stones = NULL;
    pave_maps *maps = NULL;
    pave_model *model = NULL;
    uint64_t hash = 0;
    shape.width = shape.height = box.width = box.height = box.depth = SIDE;
    cvd.iterations = 1;
    lay.cvd = &cvd;
    params.scale = 1;
    model_params.skin = round > VOLUME ? PAVE_SKIN_VERTICES : PAVE_SKIN_MAPS;
    *result = pave_image_create(context, &shape, values, &image);
    if (!*result)
        *result = pave_volume_create(context, &box, values, NULL, &volume);
    if (!*result)
        *result = pave_lay(context, image, &lay, &stones);
    const pave_image *const textures[1] = { image };
    const pave_volume *const volumes[1] = { volume };
    input.stones = stones;
    input.textures = textures;
    input.volumes = volumes;
    input.texture_count = round == TEXTURE;
    input.volume_count = round == VOLUME;
    input.joint = round == TEXTURE ? image : NULL;
    if (!*result)
        *result = pave_maps_create(context, &input, &params, &maps);
    if (!*result)
        *result = pave_model_create(context, &input, &params, &model_params, &model);
    if (!*result)
        *result = pave_model_write(context, model, "/dev/null");
    if (!*result)
        hash = hash_bytes(pave_image_pixels(pave_maps_image(maps, PAVE_MAP_COLOUR)), 3 * SIDE * SIDE) ^
               hash_bytes(pave_model_positions(model), (size_t)pave_model_vertex_count(model) * 12);
    assert_true(*result || (maps && model));
    pave_model_free(&model);
    pave_maps_free(&maps);
    pave_stones_free(&stones);
    pave_volume_free(&volume);
    pave_image_free(&image);
    return hash;
}

typedef uint64_t a_job(pave_context *context, int32_t round, pave_result *result);

static void fail_every_allocation(a_job *once, int32_t rounds)
{
    for (int32_t round = 0; round < rounds; round++) {
        failing f = { 0 };
        pave_context_params params = failing_params(&f);
        pave_context *context;
        pave_result result;
        params.backend = PAVE_BACKEND_CPU;
        assert_ok(pave_context_create(&params, &context));
        int64_t idle = f.blocks, before = f.calls;
        uint64_t expected = once(context, round, &result);
        assert_ok(result);
        int64_t points = f.calls - before;
        assert_true(points > 20);
        for (int64_t k = 1; k <= points; k++) {
            f.fail_at = f.calls + k;
            once(context, round, &result);
            assert_int_equal(result, PAVE_ERR_MEMORY);
            assert_non_null(strstr(pave_context_message(context), "out of memory"));
            assert_int_equal(f.blocks, idle);
        }
        f.fail_at = 0;
        assert_true(once(context, round, &result) == expected);
        pave_context_free(&context);
        assert_int_equal(f.blocks, 0);
    }
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    fail_every_allocation(lay_once, 4);
}

static void every_allocation_of_tilings_may_fail(void **state)
{
    (void)state;
    fail_every_allocation(tile_once, 6);
}

static void every_allocation_of_maps_may_fail(void **state)
{
    (void)state;
    fail_every_allocation(map_once, 3);
}

static void contexts_may_fail_too(void **state)
{
    (void)state;
    for (int64_t k = 1; k <= 2; k++) {
        failing f = { .fail_at = k };
        pave_context_params params = failing_params(&f);
        pave_context *context = (pave_context *)1;
        params.threads = 0;
        assert_int_equal(pave_context_create(&params, &context), PAVE_ERR_MEMORY);
        assert_null(context);
        assert_int_equal(f.blocks, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(every_allocation_of_tilings_may_fail),
        cmocka_unit_test(every_allocation_of_maps_may_fail),
        cmocka_unit_test(contexts_may_fail_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
