/* Maps and models: pixels of a texture stay what they are, the same bytes whoever looks how, and what is refused. */
#include "failing.h"

#include <math.h>

enum { WIDE = 48, HIGH = 40, SIDE = 64, MANY = 3 };

static pave_stones *lay(pave_context *context, int32_t periodic)
{
    pave_lay_params params = PAVE_LAY_PARAMS_INIT;
    pave_field_params field = PAVE_FIELD_PARAMS_INIT;
    pave_cvd_params cvd = PAVE_CVD_PARAMS_INIT;
    pave_image *drawing = draw_shapes(context, WIDE, HIGH);
    pave_stones *stones = NULL;
    field.periodic = periodic;
    cvd.iterations = 4;
    params.field = &field;
    params.cvd = &cvd;
    assert_ok(pave_lay(context, drawing, &params, &stones));
    pave_image_free(&drawing);
    return stones;
}

/* Every pixel tells where it is: a value for each channel, and the floats and 16 bits of them alike. */
static pave_image *make_texture(pave_context *context, int32_t width, int32_t height, int32_t type)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    shape.width = width;
    shape.height = height;
    shape.channels = 3;
    shape.type = type;
    shape.encoding = type == PAVE_F32 ? PAVE_DATA : PAVE_DISPLAY;
    float *floats = calloc((size_t)width * (size_t)height, 3 * sizeof *floats);
    for (int32_t i = 0; i < width * height; i++) {
        int32_t value[3] = { i % width, i / width, 7 };
        for (int c = 0; c < 3; c++)
            if (type == PAVE_U8)
                ((uint8_t *)floats)[3 * i + c] = (uint8_t)(value[c] * 3);
            else if (type == PAVE_U16)
                ((uint16_t *)floats)[3 * i + c] = (uint16_t)(value[c] * 900 + 5);
            else
                floats[3 * i + c] = (float)value[c] / 8;
    }
    assert_ok(pave_image_create(context, &shape, floats, &image));
    free(floats);
    return image;
}

static double texel(const pave_image *image, int64_t at)
{
    switch (pave_image_type(image)) {
    case PAVE_U8: return ((const uint8_t *)pave_image_pixels(image))[at] / 3.0;
    case PAVE_U16: return (((const uint16_t *)pave_image_pixels(image))[at] - 5) / 900.0;
    default: return (double)((const float *)pave_image_pixels(image))[at] * 8;
    }
}

static pave_maps_input input_of(const pave_stones *stones, const pave_image *const *textures, int32_t count)
{
    pave_maps_input input = PAVE_MAPS_INPUT_INIT;
    input.stones = stones;
    input.textures = textures;
    input.texture_count = count;
    return input;
}

static pave_maps *make(pave_context *context, const pave_maps_input *input, const pave_maps_params *params)
{
    pave_maps *maps = NULL;
    assert_ok(pave_maps_create(context, input, params, &maps));
    return maps;
}

/* A pixel, and those around it, are all of one stone: a mask of 255 alone may stand for a little less. */
static int is_within(const pave_maps *maps, int32_t i)
{
    const pave_image *image = pave_maps_image(maps, PAVE_MAP_MASK);
    const uint8_t *mask = pave_image_pixels(image);
    const uint32_t *id = pave_image_pixels(pave_maps_image(maps, PAVE_MAP_ID));
    int32_t width = pave_image_width(image), height = pave_image_height(image), x = i % width, y = i / width;
    if (x < 1 || y < 1 || x + 1 >= width || y + 1 >= height)
        return 0;
    for (int k = 0; k < 9; k++) {
        int32_t j = i + (k / 3 - 1) * width + k % 3 - 1;
        if (mask[j] != mask[i] || id[2 * j] != id[2 * i] || id[2 * j + 1] != id[2 * i + 1])
            return 0;
    }
    return mask[i] == 255 || !mask[i];
}

static int is_stone(const pave_maps *maps, int32_t i)
{
    return ((const uint8_t *)pave_image_pixels(pave_maps_image(maps, PAVE_MAP_MASK)))[i] == 255 && is_within(maps, i);
}

static int32_t wrapped(double difference)
{
    return ((int32_t)difference % SIDE + SIDE + SIDE / 2) % SIDE - SIDE / 2;
}

/* A pixel that is all stone shows one texel, and its neighbours show that texel's neighbours, by quarter turns. */
static void pixels_are_those_of_the_texture(void **state)
{
    static const int32_t types[] = { PAVE_U8, PAVE_U16, PAVE_F32 };
    pave_stones *stones = lay(*state, 0);
    for (int t = 0; t < (THREAD_SANITIZED ? 1 : 3); t++) {
        pave_image *texture = make_texture(*state, SIDE, SIDE, types[t]);
        const pave_image *const textures[1] = { texture };
        const pave_maps_input input = input_of(stones, textures, 1);
        pave_maps_params params = PAVE_MAPS_PARAMS_INIT;
        params.turns = PAVE_TURNS_QUARTER;
        params.repeat = PAVE_REPEAT_WRAP;
        params.tint = PAVE_TINT_NO;
        params.variation = 0;
        params.scale = 3;
        pave_maps *maps = make(*state, &input, &params);
        const pave_image *colour = pave_maps_image(maps, PAVE_MAP_COLOUR);
        const uint32_t *id = pave_image_pixels(pave_maps_image(maps, PAVE_MAP_ID));
        int32_t width = pave_image_width(colour), whole = 0, ways = 0, starts = 0;
        uint8_t known[4096] = { 0 };
        uint64_t columns = 0; /* of the texture, that stones' first pixels show */
        assert_int_equal(pave_image_type(colour), types[t]);
        assert_int_equal(width, 3 * WIDE);
        for (int32_t i = 0; i + width < width * 3 * HIGH; i++) {
            double u = texel(colour, 3 * i), v = texel(colour, 3 * i + 1);
            if (!is_stone(maps, i))
                continue;
            whole++;
            assert_true(u == floor(u) && v == floor(v) && texel(colour, 3 * i + 2) == 7);
            for (int n = 0; n < 2; n++) {
                int32_t j = i + (n ? width : 1);
                if (!is_stone(maps, j))
                    continue;
                int32_t du = wrapped(texel(colour, 3 * j) - u), dv = wrapped(texel(colour, 3 * j + 1) - v);
                assert_int_equal(abs(du) + abs(dv), 1);
                ways |= 1 << (n ? 4 : 0) << (du > 0 ? 0 : du < 0 ? 1 : dv > 0 ? 2 : 3);
            }
            columns |= known[id[2 * i] % 4096] ? 0 : (uint64_t)1 << (int32_t)u;
            known[id[2 * i] % 4096] = 1;
        }
        for (; columns; columns &= columns - 1)
            starts++;
        assert_true(whole > width * HIGH && starts > 10); /* each stone is from elsewhere */
        assert_int_equal(ways, 255);                      /* and every quarter turn occurs */
        pave_maps_free(&maps);
        pave_image_free(&texture);
    }
    pave_stones_free(&stones);
}

/* A volume's plane at a whole place is its voxels, and what pave_volume_sample says. */
static void faces_are_planes_of_the_volume(void **state)
{
    enum { N = 32 };
    pave_volume_params shape = PAVE_VOLUME_PARAMS_INIT;
    pave_stones *stones = lay(*state, 0);
    pave_volume *volume = NULL;
    shape.width = shape.height = shape.depth = N;
    shape.channels = 3;
    shape.type = PAVE_F32;
    float *values = malloc(N * N * N * 3 * sizeof *values);
    for (int32_t i = 0; i < N * N * N; i++)
        values[3 * i] = (float)(i % N), values[3 * i + 1] = (float)(i / N % N), values[3 * i + 2] = (float)(i / N / N);
    assert_ok(pave_volume_create(*state, &shape, values, NULL, &volume));
    free(values);
    const pave_volume *const volumes[1] = { volume };
    pave_maps_input input = input_of(stones, NULL, 0);
    input.volumes = volumes;
    input.volume_count = 1;
    pave_maps_params params = PAVE_MAPS_PARAMS_INIT;
    params.tint = PAVE_TINT_NO;
    params.variation = 0;
    params.bevel = 0;
    params.scale = 2;
    for (int32_t turns = PAVE_TURNS_ANY; turns <= PAVE_TURNS_NONE; turns++) {
        params.turns = turns;
        params.repeat = PAVE_REPEAT_MIRROR;
        params.texels = 1;
        pave_maps *maps = make(*state, &input, &params);
        const float *colour = pave_image_pixels(pave_maps_image(maps, PAVE_MAP_COLOUR));
        int32_t width = 2 * WIDE, pairs = 0;
        for (int32_t i = 0; i + 1 < width * 2 * HIGH; i++) {
            float sample[3];
            double way = 0;
            if (!is_stone(maps, i) || !is_stone(maps, i + 1))
                continue;
            const float *a = colour + 3 * i, *b = colour + 3 * i + 3;
            assert_true(pave_volume_sample(volume, (double)a[0], (double)a[1], (double)a[2], sample));
            for (int c = 0; c < 3; c++) {
                assert_true(a[c] >= 0 && a[c] <= N - 1 && fabsf(sample[c] - a[c]) < 1e-4f);
                way += ((double)b[c] - (double)a[c]) * ((double)b[c] - (double)a[c]);
            }
            if (turns)
                assert_true(a[2] == floorf(a[2]));
            assert_true(way < 0.25 + 1e-4); /* half a voxel a pixel, less where the volume is mirrored */
            pairs += way > 0.25 - 1e-4;
        }
        assert_true(pairs > width * HIGH / 3);
        pave_maps_free(&maps);
    }
    pave_volume_free(&volume);
    pave_stones_free(&stones);
}

static uint64_t hash_maps(const pave_maps *maps)
{
    static const size_t bytes[PAVE_MAP_COUNT] = { 3, 4, 6, 1, 1, 1, 8 };
    uint64_t hash = 0;
    for (int32_t i = 0; i < PAVE_MAP_COUNT; i++) {
        const pave_image *image = pave_maps_image(maps, i);
        size_t pixels = (size_t)pave_image_width(image) * (size_t)pave_image_height(image);
        hash = hash * 31 + hash_bytes(pave_image_pixels(image), pixels * bytes[i]);
    }
    return hash;
}

static uint64_t hash_model(const pave_model *model)
{
    const pave_image *colour = pave_model_picture(model, PAVE_SKIN_COLOUR);
    size_t pixels = (size_t)pave_image_width(colour) * (size_t)pave_image_height(colour);
    size_t vertices = (size_t)pave_model_vertex_count(model), triangles = (size_t)pave_model_triangle_count(model);
    uint64_t hash = hash_bytes(pave_model_positions(model), vertices * 12);
    hash ^= 3 * hash_bytes(pave_model_normals(model), vertices * 12);
    hash ^= 5 * hash_bytes(pave_model_coordinates(model), vertices * 8);
    hash ^= 7 * hash_bytes(pave_model_triangles(model), triangles * 12);
    hash ^= 9 * hash_bytes(pave_image_pixels(colour), pixels * 3);
    return hash ^ 11 * hash_bytes(pave_image_pixels(pave_model_picture(model, PAVE_SKIN_SURFACE)), pixels * 3);
}

static void threads_do_not_matter(void **state)
{
    static const int32_t threads[MANY] = { 1, 2, 7 };
    uint64_t maps_hash[MANY], model_hash[MANY];
    (void)state;
    for (int i = 0; i < MANY; i++) {
        pave_context *context = make_context(threads[i], PAVE_BACKEND_CPU);
        pave_stones *stones = lay(context, 0);
        pave_image *texture = make_texture(context, 17, 9, PAVE_U8);
        const pave_image *const textures[2] = { texture, texture };
        const pave_maps_input input = input_of(stones, textures, 2);
        pave_maps *maps = make(context, &input, NULL);
        pave_model *model = NULL;
        assert_ok(pave_model_create(context, &input, NULL, NULL, &model));
        maps_hash[i] = hash_maps(maps);
        model_hash[i] = hash_model(model);
        pave_model_free(&model);
        pave_maps_free(&maps);
        pave_image_free(&texture);
        pave_stones_free(&stones);
        pave_context_free(&context);
    }
    for (int i = 1; i < MANY; i++)
        assert_true(maps_hash[i] == maps_hash[0] && model_hash[i] == model_hash[0]);
}

/* Every map of a window is the crop of the whole's, which may repeat. */
static void check_crop(const pave_maps *whole, const pave_maps *part, int32_t repeats)
{
    static const size_t bytes[PAVE_MAP_COUNT] = { 3, 4, 6, 1, 1, 1, 8 };
    int64_t left = pave_maps_x(part) - pave_maps_x(whole), top = pave_maps_y(part) - pave_maps_y(whole);
    for (int32_t m = 0; m < PAVE_MAP_COUNT; m++) {
        const pave_image *a = pave_maps_image(whole, m), *b = pave_maps_image(part, m);
        const char *from = pave_image_pixels(a), *to = pave_image_pixels(b);
        int64_t width = pave_image_width(a), height = pave_image_height(a);
        for (int64_t y = 0; y < pave_image_height(b); y++)
            for (int64_t x = 0; x < pave_image_width(b); x++) {
                int64_t u = x + left, v = y + top;
                if (repeats)
                    u = (u % width + width) % width, v = (v % height + height) % height;
                assert_true(u >= 0 && v >= 0 && u < width && v < height);
                assert_memory_equal(from + (size_t)(v * width + u) * bytes[m],
                                    to + (size_t)(y * pave_image_width(b) + x) * bytes[m], bytes[m]);
            }
    }
}

static void windows_are_crops(void **state)
{
    static const double scales[] = { 0.75, 2, 2.3 };
    for (int32_t periodic = 0; periodic < 2; periodic++)
        for (int i = 0; i < (THREAD_SANITIZED ? 1 : 3); i++) {
            pave_stones *stones = lay(*state, periodic);
            pave_image *texture = make_texture(*state, 16, 16, PAVE_U8);
            const pave_image *const textures[1] = { texture };
            const pave_maps_input input = input_of(stones, textures, 1);
            pave_maps_params params = PAVE_MAPS_PARAMS_INIT;
            params.scale = periodic && i == 2 ? 2.5 : scales[i];
            pave_maps *whole = make(*state, &input, &params);
            params.window[0] = periodic ? 40 : 11;
            params.window[1] = periodic ? 33 : 7;
            params.window[2] = 24;
            params.window[3] = 21;
            pave_maps *part = make(*state, &input, &params);
            check_crop(whole, part, periodic);
            pave_maps_free(&part);
            pave_maps_free(&whole);
            pave_image_free(&texture);
            pave_stones_free(&stones);
        }
}

/* With nothing rounded, tilted, lifted or sandy there are two heights, and a flat face's normal points at us. */
static void plain_stones_are_plain(void **state)
{
    pave_stones *stones = lay(*state, 0);
    const pave_maps_input input = input_of(stones, NULL, 0);
    pave_maps_params params = PAVE_MAPS_PARAMS_INIT;
    params.bevel = params.tilt = params.lift = params.relief = params.joint_sand = params.variation = 0;
    params.roughness = 0.2;
    params.roughness_variation = 0;
    params.joint_roughness = 1;
    params.occlusion = 0;
    params.half_side = 4;
    params.joint_colour.count = 1;
    params.joint_colour.rgb[0] = 200;
    pave_maps *maps = make(*state, &input, &params);
    const float *height = pave_image_pixels(pave_maps_image(maps, PAVE_MAP_HEIGHT));
    const uint8_t *mask = pave_image_pixels(pave_maps_image(maps, PAVE_MAP_MASK));
    const uint8_t *rough = pave_image_pixels(pave_maps_image(maps, PAVE_MAP_ROUGHNESS));
    const uint8_t *colour = pave_image_pixels(pave_maps_image(maps, PAVE_MAP_COLOUR));
    const uint8_t *sky = pave_image_pixels(pave_maps_image(maps, PAVE_MAP_OCCLUSION));
    int32_t stone = 0, joint = 0;
    for (int32_t i = 0; i < 16 * WIDE * HIGH; i++) {
        assert_int_equal(sky[i], 255);
        if (is_stone(maps, i)) {
            assert_true(height[i] == 0 && rough[i] == 51 && (colour[3 * i] == 0xF4 || colour[3 * i] == 0x1F));
            stone++;
        } else if (!mask[i] && is_within(maps, i)) {
            assert_true(height[i] == -1.2f && rough[i] == 255 && colour[3 * i] == 200 && !colour[3 * i + 1]);
            joint++;
        } else {
            assert_true(height[i] <= 0 && height[i] >= -1.2f);
        }
    }
    assert_true(stone > 4 * WIDE * HIGH && joint > 50);
    assert_true(pave_maps_lowest(maps) == -1.2 && pave_maps_highest(maps) == 0);
    pave_maps_free(&maps);
    pave_stones_free(&stones);
}

/* A texture of one pixel, or of many for each pixel of the maps, is its mean. */
static void small_and_fine_textures(void **state)
{
    pave_stones *stones = lay(*state, 0);
    pave_maps_params params = PAVE_MAPS_PARAMS_INIT;
    params.variation = 0;
    params.tint = PAVE_TINT_NO;
    params.scale = 1;
    for (int fine = 0; fine < 2; fine++) {
        pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
        static uint8_t board[64 * 64];
        pave_image *texture = NULL;
        shape.width = shape.height = fine ? 64 : 1;
        for (int i = 0; i < 64 * 64; i++)
            board[i] = fine ? (i ^ i / 64) & 1 ? 255 : 0 : 77;
        assert_ok(pave_image_create(*state, &shape, board, &texture));
        const pave_image *const textures[1] = { texture };
        const pave_maps_input input = input_of(stones, textures, 1);
        params.texels = fine ? 16 : 0;
        params.turns = PAVE_TURNS_QUARTER;
        pave_maps *maps = make(*state, &input, &params);
        const uint8_t *colour = pave_image_pixels(pave_maps_image(maps, PAVE_MAP_COLOUR));
        for (int32_t i = 0; i < WIDE * HIGH; i++)
            if (is_stone(maps, i)) /* half the light is 188 for display */
                assert_int_equal(colour[3 * i], fine ? 188 : 77);
        pave_maps_free(&maps);
        pave_image_free(&texture);
    }
    pave_stones_free(&stones);
}

/* With tint a texture has the stones' colours on average, and by itself does so where it is the only one. */
static void tint_gives_the_stones_colours(void **state)
{
    pave_stones *stones = lay(*state, 0);
    pave_image *texture = make_texture(*state, 5, 5, PAVE_U8);
    const pave_image *const textures[2] = { texture, texture };
    uint64_t hash[4];
    for (int i = 0; i < 4; i++) {
        const pave_maps_input input = input_of(stones, textures, i < 3 ? 1 : 2);
        pave_maps_params params = PAVE_MAPS_PARAMS_INIT;
        params.tint = i == 3 ? PAVE_TINT_AUTO : i;
        pave_maps *maps = make(*state, &input, &params);
        hash[i] = hash_maps(maps);
        pave_maps_free(&maps);
    }
    assert_true(hash[PAVE_TINT_AUTO] == hash[PAVE_TINT_YES] && hash[PAVE_TINT_NO] != hash[PAVE_TINT_YES]);
    assert_true(hash[3] == hash[PAVE_TINT_NO]);
    pave_image_free(&texture);
    pave_stones_free(&stones);
}

static void refuse(pave_context *context, const pave_maps_input *input, const pave_maps_params *params,
                   pave_result expected, const char *words)
{
    pave_maps *maps = (pave_maps *)1;
    pave_model *model = (pave_model *)1;
    assert_int_equal(pave_maps_create(context, input, params, &maps), expected);
    assert_null(maps);
    if (!strstr(pave_context_message(context), words))
        fail_msg("says '%s'", pave_context_message(context));
    assert_int_equal(pave_model_create(context, input, params, NULL, &model), expected);
    assert_null(model);
}

static pave_volume *make_volume(pave_context *context, int32_t channels, uint8_t state)
{
    pave_volume_params shape = PAVE_VOLUME_PARAMS_INIT;
    pave_volume *volume = NULL;
    uint8_t values[54] = { 0 }, states[27];
    memset(states, PAVE_VOXEL_FILLED, sizeof states);
    states[5] = state;
    shape.width = shape.height = shape.depth = 3;
    shape.channels = channels;
    assert_ok(pave_volume_create(context, &shape, values, states, &volume));
    return volume;
}

static void bad_input_is_refused(void **state)
{
    pave_stones *stones = lay(*state, 0), *tile = lay(*state, 1);
    pave_maps_params params = PAVE_MAPS_PARAMS_INIT;
    pave_image *texture = make_texture(*state, 4, 4, PAVE_F32), *labels = NULL;
    const pave_image *textures[3] = { texture, texture, texture };
    pave_maps_input input = input_of(NULL, NULL, 0);
    refuse(*state, &input, NULL, PAVE_ERR_ARGUMENT, "no stones");
    input = input_of(stones, textures, 3);
    refuse(*state, &input, NULL, PAVE_ERR_ARGUMENT, "3 textures, but stones of 2 colours");
    input.texture_count = -1;
    refuse(*state, &input, NULL, PAVE_ERR_ARGUMENT, "NULL");
    input.texture_count = 1;
    input.textures = NULL;
    refuse(*state, &input, NULL, PAVE_ERR_ARGUMENT, "NULL");
    textures[1] = NULL;
    input = input_of(stones, textures, 2);
    refuse(*state, &input, NULL, PAVE_ERR_ARGUMENT, "texture 2: is NULL");

    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = shape.height = 1;
    shape.type = PAVE_U32;
    assert_ok(pave_image_create(*state, &shape, NULL, &labels));
    textures[0] = labels;
    input = input_of(stones, textures, 1);
    refuse(*state, &input, NULL, PAVE_ERR_UNSUPPORTED, "labels");
    pave_image_free(&labels);
    const float bad[4] = { 0, 0, NAN, 0 };
    shape.width = 4;
    shape.type = PAVE_F32;
    assert_ok(pave_image_create(*state, &shape, bad, &labels));
    textures[0] = labels;
    refuse(*state, &input, NULL, PAVE_ERR_ARGUMENT, "texture 1: has a value that is no number at 2,0");
    input = input_of(stones, NULL, 0);
    input.joint = labels;
    refuse(*state, &input, NULL, PAVE_ERR_ARGUMENT, "joints' texture: has a value that is no number");

    pave_volume *hollow = make_volume(*state, 1, PAVE_VOXEL_OUTSIDE), *two = make_volume(*state, 2, PAVE_VOXEL_FILLED);
    const pave_volume *volumes[1] = { hollow };
    input = input_of(stones, NULL, 0);
    input.volumes = volumes;
    input.volume_count = 1;
    refuse(*state, &input, NULL, PAVE_ERR_ARGUMENT, "voxel 2,1,0 has no value");
    volumes[0] = two;
    refuse(*state, &input, NULL, PAVE_ERR_UNSUPPORTED, "2 channels");
    textures[0] = texture;
    input.textures = textures;
    input.texture_count = 1;
    refuse(*state, &input, NULL, PAVE_ERR_ARGUMENT, "not from both");

    input = input_of(stones, NULL, 0);
    params.scale = 65;
    refuse(*state, &input, &params, PAVE_ERR_ARGUMENT, "scale is 65");
    params.scale = NAN;
    refuse(*state, &input, &params, PAVE_ERR_ARGUMENT, "scale is nan");
    params = (pave_maps_params)PAVE_MAPS_PARAMS_INIT;
    params.joint_colour.count = 2;
    refuse(*state, &input, &params, PAVE_ERR_ARGUMENT, "one colour");
    params = (pave_maps_params)PAVE_MAPS_PARAMS_INIT;
    params.scale = 1.3;
    input.stones = tile;
    refuse(*state, &input, &params, PAVE_ERR_ARGUMENT, "must be whole");
    params.scale = 4;
    params.window[2] = 5;
    pave_maps *maps = NULL;
    assert_int_equal(pave_maps_create(*state, &input, &params, &maps), PAVE_ERR_ARGUMENT);
    assert_non_null(strstr(pave_context_message(*state), "no area"));
    pave_volume_free(&hollow);
    pave_volume_free(&two);
    pave_image_free(&labels);
    pave_image_free(&texture);
    pave_stones_free(&tile);
    pave_stones_free(&stones);
}

/* Sizes are looked at before anything of the size is made. */
static void limits_hold(void **state)
{
    (void)state;
    failing f = { 0 };
    pave_context_params context_params = failing_params(&f);
    pave_limits limits = PAVE_LIMITS_INIT;
    pave_context *context = NULL;
    limits.max_pixels = 1 << 20;
    limits.max_bytes = 1 << 26;
    context_params.limits = &limits;
    assert_ok(pave_context_create(&context_params, &context));
    pave_stones *stones = lay(context, 0);
    const pave_maps_input input = input_of(stones, NULL, 0);
    pave_maps_params params = PAVE_MAPS_PARAMS_INIT;
    params.scale = 64;
    int64_t blocks = f.blocks;
    refuse(context, &input, &params, PAVE_ERR_LIMIT, "beyond the limit of 1048576 pixels");
    assert_int_equal(f.blocks, blocks);
    pave_model_params model_params = PAVE_MODEL_PARAMS_INIT;
    pave_model *model = NULL;
    model_params.skin = PAVE_SKIN_VERTICES;
    assert_ok(pave_model_create(context, &input, &params, &model_params, &model)); /* has no pixels */
    pave_model_free(&model);
    pave_stones_free(&stones);
    pave_context_free(&context);
    assert_int_equal(f.blocks, 0);
}

/* Volume by Gauss, and what it should be: area times height. */
static double volume_of(const pave_model *model, int64_t from, int64_t to)
{
    const float *p = pave_model_positions(model);
    const uint32_t *t = pave_model_triangles(model);
    double sum = 0;
    for (int64_t i = from; i < to; i++) {
        const float *a = p + 3 * (int64_t)t[3 * i], *b = p + 3 * (int64_t)t[3 * i + 1], *c = p + 3 * (int64_t)t[3 * i + 2];
        sum += (double)a[0] * ((double)b[1] * (double)c[2] - (double)b[2] * (double)c[1]) -
               (double)a[1] * ((double)b[0] * (double)c[2] - (double)b[2] * (double)c[0]) +
               (double)a[2] * ((double)b[0] * (double)c[1] - (double)b[1] * (double)c[0]);
    }
    return sum / 6;
}

static double area_of(const pave_stones *stones, int32_t s)
{
    const double *v = pave_stones_vertices(stones);
    int64_t first = pave_stones_starts(stones)[s], end = pave_stones_starts(stones)[s + 1];
    double area = 0;
    for (int64_t i = first; i < end; i++) {
        const double *a = v + 2 * i, *b = v + 2 * (i + 1 < end ? i + 1 : first);
        area += (a[1] * b[0] - a[0] * b[1]) / 2;
    }
    return area;
}

static void solids_have_their_volume(void **state)
{
    pave_stones *stones = lay(*state, 0);
    const pave_maps_input input = input_of(stones, NULL, 0);
    pave_maps_params maps = PAVE_MAPS_PARAMS_INIT;
    pave_model_params params = PAVE_MODEL_PARAMS_INIT;
    maps.half_side = 4;
    maps.tilt = maps.lift = 0;
    maps.scale = 1;
    params.pixels_per_metre = 10;
    params.skin = PAVE_SKIN_VERTICES;
    params.thickness = 2;
    double sums[2] = { 0, 0 };
    for (int32_t segments = 0; segments <= 8; segments += 8) {
        pave_model *model = NULL;
        params.segments = segments;
        assert_ok(pave_model_create(*state, &input, &maps, &params, &model));
        assert_int_equal(pave_model_stone_count(model), pave_stones_count(stones));
        assert_null(pave_model_coordinates(model));
        assert_null(pave_model_picture(model, PAVE_SKIN_COLOUR));
        const int64_t *starts = pave_model_starts(model);
        assert_int_equal(starts[pave_stones_count(stones)] + 2, pave_model_triangle_count(model));
        for (int32_t s = 0; s < pave_stones_count(stones); s++) {
            double whole = area_of(stones, s) * 8 / 1000, found = volume_of(model, starts[s], starts[s + 1]);
            assert_true(found < whole * 1.01 + 1e-6 && found > whole * (segments ? 0.7 : 0.98) - 2e-4);
            sums[segments / 8] += found;
        }
        pave_model_free(&model);
    }
    assert_true(sums[1] < sums[0] * 0.995); /* what the rounding takes away */
    pave_stones_free(&stones);
}

/* A hook, a stone that goes round the other way, one that crosses itself, and one that is hardly there. */
static void odd_stones_become_solids(void **state)
{
    char path[] = "/tmp/pave-odd-XXXXXX.svg";
    static const char text[] = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 60 40\">"
                               "<polygon fill=\"#fff\" points=\"1,1 1,20 20,20 20,14 8,14 8,6 20,6 20,1\"/>"
                               "<polygon fill=\"#000\" points=\"30,1 50,1 50,20 40,20 30,20\"/>"
                               "<polygon fill=\"#000\" points=\"1,30 20,38 20,30 1,38\"/>"
                               "<polygon fill=\"#000\" points=\"30,30 50,30 50,30.004 30,30.004\"/></svg>";
    int file = mkstemps(path, 4);
    assert_true(file >= 0);
    FILE *out = fdopen(file, "w");
    fputs(text, out);
    fclose(out);
    pave_stones *stones = NULL;
    pave_model *model = NULL;
    assert_ok(pave_stones_read(*state, path, &stones));
    remove(path);
    const pave_maps_input input = input_of(stones, NULL, 0);
    pave_model_params params = PAVE_MODEL_PARAMS_INIT;
    params.ground = 0;
    assert_ok(pave_model_create(*state, &input, NULL, &params, &model));
    const int64_t *starts = pave_model_starts(model);
    for (int32_t s = 0; s < 2; s++)
        assert_true(volume_of(model, starts[s], starts[s + 1]) > 0);
    assert_true(starts[2] == starts[4] && starts[4] == pave_model_triangle_count(model));
    assert_int_equal(starts[2] - starts[1], 4 * 6 + 4); /* of five corners one lies on a straight side */
    pave_model_free(&model);
    pave_maps *maps = make(*state, &input, NULL);
    const uint8_t *mask = pave_image_pixels(pave_maps_image(maps, PAVE_MAP_MASK));
    assert_int_equal(mask[40 * 240 + 12], 255); /* the hook's spine, and the room in it */
    assert_int_equal(mask[40 * 240 + 60], 0);
    pave_maps_free(&maps);
    pave_stones_free(&stones);
}

static int32_t stop(void *user, const char *stage, double done)
{
    (void)stage;
    return done >= *(double *)user;
}

static void can_be_cancelled(void **state)
{
    (void)state;
    for (double when = 0; when < 1; when += 0.2) {
        failing f = { 0 };
        pave_context_params params = failing_params(&f);
        pave_context *quiet = make_context(1, PAVE_BACKEND_CPU), *context = NULL;
        pave_stones *stones = lay(quiet, 0);
        const pave_maps_input input = input_of(stones, NULL, 0);
        params.progress = stop;
        params.progress_user = &when;
        assert_ok(pave_context_create(&params, &context));
        int64_t idle = f.blocks;
        pave_maps *maps = NULL;
        pave_model *model = NULL;
        assert_int_equal(pave_maps_create(context, &input, NULL, &maps), PAVE_ERR_CANCELLED);
        assert_int_equal(pave_model_create(context, &input, NULL, NULL, &model), PAVE_ERR_CANCELLED);
        assert_true(!maps && !model && f.blocks == idle);
        pave_context_free(&context);
        pave_stones_free(&stones);
        pave_context_free(&quiet);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_are_those_of_the_texture), cmocka_unit_test(faces_are_planes_of_the_volume),
        cmocka_unit_test(threads_do_not_matter),           cmocka_unit_test(windows_are_crops),
        cmocka_unit_test(plain_stones_are_plain),          cmocka_unit_test(small_and_fine_textures),
        cmocka_unit_test(tint_gives_the_stones_colours),   cmocka_unit_test(bad_input_is_refused),
        cmocka_unit_test(limits_hold),                     cmocka_unit_test(solids_have_their_volume),
        cmocka_unit_test(odd_stones_become_solids),        cmocka_unit_test(can_be_cancelled),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
