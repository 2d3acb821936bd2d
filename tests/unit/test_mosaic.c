/* Mosaics: what they must reach on a picture of our own, on every engine, and how they take bad input. */
#include "devices.h"

#include "mosaic/mosaic.h"

#include <math.h>
#include <unistd.h>

enum { SIDE = 240, TILES = 400 };

/* A disc on a ground, both shaded. */
static void paint(uint8_t *rgb, int32_t width, int32_t height)
{
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++) {
            int32_t dx = x - width / 2, dy = y - height / 2, inside = dx * dx + dy * dy < width * height / 9;
            uint8_t *p = rgb + 3 * (y * width + x);
            p[0] = (uint8_t)(inside ? 200 : 40 + x / 8);
            p[1] = (uint8_t)(inside ? 90 + y / 8 : 60);
            p[2] = (uint8_t)(inside ? 30 : 120);
        }
}

static pave_image *image_of(pave_context *context, int32_t width, int32_t height, int32_t channels, int32_t type,
                            int32_t alpha, const void *pixels)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    shape.width = width;
    shape.height = height;
    shape.channels = channels;
    shape.type = type;
    shape.alpha = alpha;
    assert_ok(pave_image_create(context, &shape, pixels, &image));
    return image;
}

static pave_image *photo_of(pave_context *context, int32_t width, int32_t height)
{
    uint8_t *rgb = malloc((size_t)(3 * width * height));
    paint(rgb, width, height);
    pave_image *image = image_of(context, width, height, 3, PAVE_U8, -1, rgb);
    free(rgb);
    return image;
}

static pave_mosaic_params params_of(int32_t mode, int32_t tiles)
{
    pave_mosaic_params params = PAVE_MOSAIC_PARAMS_INIT;
    params.mode = mode;
    params.tiles = tiles;
    return params;
}

static pave_stones *lay(pave_context *context, const pave_image *photo, const pave_mosaic_params *params)
{
    pave_mosaic_sources sources = PAVE_MOSAIC_SOURCES_INIT;
    pave_stones *stones = NULL;
    sources.photo = photo;
    assert_ok(pave_mosaic_create(context, &sources, NULL, params, &stones));
    return stones;
}

static pave_mosaic_measure measure_of(pave_context *context, const pave_stones *stones)
{
    pave_mosaic_measure measure = { .size = sizeof measure };
    assert_ok(pave_mosaic_measure_of(context, stones, &measure));
    return measure;
}

static void best_mode_reaches_its_bars(void **state)
{
    pave_context *context = *state;
    pave_image *photo = photo_of(context, SIDE, SIDE);
    pave_mosaic_params params = params_of(PAVE_MODE_BEST, TILES);
    for (int k = 0; k < 2; k++) {
        params.joint = k ? 0.05 : 0;
        pave_stones *stones = lay(context, photo, &params);
        pave_mosaic_measure m = measure_of(context, stones);
        assert_true(m.coverage >= (k ? 0.89 : 0.99) && m.coverage <= 1 + 1e-9);
        assert_true(m.overlap == 0);
        assert_true(m.corners4 >= 0.98 && m.lost <= TILES / 100);
        assert_true(m.squareness <= 15 && m.field_angle <= 7 && m.edge_angle <= 6);
        assert_true(m.straddlers <= 0.07 && m.sizes_met >= 0.9 && m.delta_e < 0.5);
        assert_int_equal(m.tiles + m.chips, pave_stones_count(stones));
        assert_non_null(pave_stones_rgb(stones));
        pave_stones_free(&stones);
    }
    pave_image_free(&photo);
}

/* Where chips take what they leave free, all tiles have four corners. */
static void chips_fill_gaps(void **state)
{
    pave_context *context = *state;
    pave_image *photo = photo_of(context, SIDE, SIDE);
    pave_mosaic_params params = params_of(PAVE_MODE_BEST, TILES);
    int32_t more = 0;
    for (int k = 0; k < 3; k++) {
        params.joint = k == 1 ? 0.05 : 0;
        params.periodic = k == 2;
        params.chips = 0;
        pave_stones *without = lay(context, photo, &params);
        params.chips = 1;
        pave_stones *stones = lay(context, photo, &params);
        pave_mosaic_measure m = measure_of(context, stones), plain = measure_of(context, without);
        assert_true(m.chips > 0 && m.chips >= plain.chips && m.tiles == plain.tiles);
        more += m.chips - plain.chips;
        assert_int_equal(m.tiles + m.chips, pave_stones_count(stones));
        assert_true(m.overlap == 0 && m.coverage > plain.coverage - 0.002 && m.corners4 >= 0.995);
        for (int32_t i = m.tiles; i < m.tiles + m.chips; i++)
            assert_int_equal(pave_stones_starts(stones)[i + 1] - pave_stones_starts(stones)[i], 3);
        pave_stones_free(&stones);
        pave_stones_free(&without);
    }
    assert_true(more > 0);
    pave_image_free(&photo);
}

static void paper_mode_lays_plain_tiles(void **state)
{
    pave_context *context = *state;
    pave_image *photo = photo_of(context, SIDE, SIDE);
    pave_mosaic_params params = params_of(PAVE_MODE_PAPER, TILES);
    for (int shape = 0; shape < 3; shape++) {
        params.shape = shape;
        params.aspect = shape == PAVE_TILE_SQUARE ? 2 : 1;
        params.start = shape == PAVE_TILE_CELL ? PAVE_START_RANDOM : PAVE_START_JITTER;
        pave_stones *stones = lay(context, photo, &params);
        pave_mosaic_measure m = measure_of(context, stones);
        assert_true(fabs(m.coverage - (shape == PAVE_TILE_CELL ? 1 : 0.64)) < 0.01);
        assert_true(m.overlap < 0.05);
        if (shape == PAVE_TILE_SQUARE)
            assert_true(m.corners4 > 0.999 && m.squareness < 0.1 && fabs(m.aspect - 2) < 0.01);
        pave_stones_free(&stones);
    }
    pave_image_free(&photo);
}

static void assert_same_stones(const pave_stones *a, const pave_stones *b)
{
    int32_t n = pave_stones_count(a);
    assert_int_equal(n, pave_stones_count(b));
    assert_memory_equal(pave_stones_starts(a), pave_stones_starts(b), ((size_t)n + 1) * sizeof(int64_t));
    assert_memory_equal(pave_stones_vertices(a), pave_stones_vertices(b),
                        2 * (size_t)pave_stones_starts(a)[n] * sizeof(double));
    assert_memory_equal(pave_stones_rgb(a), pave_stones_rgb(b), 3 * (size_t)n);
}

static void engines_and_threads_agree(void **state)
{
    int32_t backends[MOST_BACKENDS], count = usable_backends(*state, backends);
    pave_image *photo = photo_of(*state, 150, 130);
    for (int kind = 0; kind < 3; kind++) {
        pave_mosaic_params params = params_of(PAVE_MODE_BEST, 150);
        pave_stones *first = NULL;
        params.pyramid = kind == 1;
        params.aspect = 1 + (kind == 1);
        params.periodic = kind == 2;
        for (int k = 0; k < count; k++) {
            pave_mosaic_sources sources = PAVE_MOSAIC_SOURCES_INIT;
            pave_context *context = make_context(1 + k % 3, backends[k]);
            pave_stones *stones = NULL;
            sources.photo = photo;
            assert_ok(pave_mosaic_create(context, &sources, NULL, &params, &stones));
            if (first)
                assert_same_stones(first, stones);
            if (!first)
                first = stones;
            else
                pave_stones_free(&stones);
            pave_context_free(&context);
        }
        pave_stones_free(&first);
    }
    pave_image_free(&photo);
}

static int holds(const pave_stones *stones, int32_t tile, double x, double y)
{
    const double *p = pave_stones_vertices(stones);
    int64_t first = pave_stones_starts(stones)[tile], end = pave_stones_starts(stones)[tile + 1];
    int inside = 0;
    for (int64_t i = first, k = end - 1; i < end; k = i++)
        if ((p[2 * i + 1] > y) != (p[2 * k + 1] > y) &&
            x < p[2 * i] + (y - p[2 * i + 1]) * (p[2 * k] - p[2 * i]) / (p[2 * k + 1] - p[2 * i + 1]))
            inside = !inside;
    return inside;
}

/* How many tiles and copies of tiles hold a point. */
static int covers(const pave_stones *stones, int32_t width, int32_t height, double x, double y)
{
    int count = 0;
    for (int32_t i = 0; i < pave_stones_count(stones); i++)
        for (int k = 0; k < 9; k++)
            count += holds(stones, i, x + (k % 3 - 1) * width, y + (k / 3 - 1) * height);
    return count;
}

/* Shares of points of lines, along a border or not, that no tile holds; none may be held twice. */
static double bare_share(const pave_stones *stones, int32_t width, int32_t height, int border)
{
    int bare = 0, all = 0;
    for (int32_t line = 0; line < 6; line++)
        for (int32_t i = 0; i < 200; i++, all++) {
            double off = (line % 3 - 1) * 0.301 + 0.007, along = i / 200.0;
            double across = border ? off : (line < 3 ? width : height) * 0.37 + off;
            int count = covers(stones, width, height, line < 3 ? across : along * width + 0.123,
                               line < 3 ? along * height + 0.123 : across);
            assert_true(count <= 1);
            bare += !count;
        }
    return (double)bare / all;
}

static void periodic_mosaics_have_no_seam(void **state)
{
    enum { WIDTH = 150, HEIGHT = 118 };
    pave_context *context = *state;
    pave_image *photo = photo_of(context, WIDTH, HEIGHT);
    for (int kind = 0; kind < 4; kind++) {
        pave_mosaic_params params = params_of(kind < 3 ? PAVE_MODE_BEST : PAVE_MODE_PAPER, kind == 2 ? 12 : 150);
        int across = 0;
        params.periodic = 1;
        params.joint = kind == 1 ? 0.05 : 0;
        params.shape = PAVE_TILE_CELL;
        pave_stones *stones = lay(context, photo, &params);
        pave_mosaic_measure m = measure_of(context, stones);
        double bare = bare_share(stones, WIDTH, HEIGHT, 1), inside = bare_share(stones, WIDTH, HEIGHT, 0);
        assert_true(m.overlap == 0 && m.lost <= 1 && m.coverage > (kind == 1 ? 0.885 : 0.985));
        assert_true(m.coverage <= 1 + 1e-9 && bare < (kind == 1 ? 0.17 : 0.02) && fabs(bare - inside) < 0.08);
        for (int64_t i = 0; i < pave_stones_starts(stones)[pave_stones_count(stones)]; i++)
            across += pave_stones_vertices(stones)[2 * i] < -1 || pave_stones_vertices(stones)[2 * i] > WIDTH + 1;
        assert_true(across > 0);
        pave_stones_free(&stones);
    }
    pave_image_free(&photo);
}

/* Of a mask with a line that goes on across the borders; with sizes and holes that do. */
static void periodic_mosaics_of_all_that_is_given(void **state)
{
    enum { WIDTH = 131, HEIGHT = 97 };
    pave_context *context = *state;
    uint8_t *line = calloc(WIDTH * HEIGHT, 1), *rgba = malloc(4 * WIDTH * HEIGHT);
    for (int32_t i = 0; i < WIDTH * HEIGHT; i++) {
        int32_t x = i % WIDTH, y = i / WIDTH, hole = (x + 20) % WIDTH < 40 && (y + 20) % HEIGHT < 40;
        memset(rgba + 4 * i, 100 + x / 2, 4);
        rgba[4 * i + 3] = hole ? 0 : 255;
        line[i] = abs(x - y) < 2 || abs(x - y - HEIGHT) < 2 ? 255 : 0;
    }
    pave_image *photo = image_of(context, WIDTH, HEIGHT, 4, PAVE_U8, 3, rgba);
    pave_image *edges = image_of(context, WIDTH, HEIGHT, 1, PAVE_U8, -1, line);
    for (int kind = 0; kind < 4; kind++) {
        pave_mosaic_sources sources = PAVE_MOSAIC_SOURCES_INIT;
        pave_mosaic_params params = params_of(kind % 2 ? PAVE_MODE_BEST : PAVE_MODE_PAPER, 200);
        pave_stones *stones = NULL;
        params.periodic = 1;
        params.size_from = kind < 2 ? PAVE_SIZE_EVEN : PAVE_SIZE_DETAIL;
        sources.photo = photo;
        sources.edges = edges;
        assert_ok(pave_mosaic_create(context, &sources, NULL, &params, &stones));
        pave_mosaic_measure m = measure_of(context, stones);
        assert_true(m.tiles + m.lost >= 200 && m.overlap < (kind % 2 ? 1e-12 : 0.03));
        assert_int_equal(kind % 2 ? covers(stones, WIDTH, HEIGHT, 0.5, 0.5) : 0, 0);
        pave_stones_free(&stones);
    }
    pave_image_free(&photo);
    pave_image_free(&edges);
    free(line);
    free(rgba);
}

static void sizes_are_met(void **state)
{
    pave_context *context = *state;
    pave_image *photo = photo_of(context, SIDE, SIDE);
    uint8_t *zones = malloc(SIDE * SIDE);
    for (int32_t i = 0; i < SIDE * SIDE; i++)
        zones[i] = i % SIDE < SIDE / 2 ? 255 : 128;
    pave_image *sizes = image_of(context, SIDE, SIDE, 1, PAVE_U8, -1, zones);
    pave_mosaic_sources sources = PAVE_MOSAIC_SOURCES_INIT;
    pave_mosaic_params params = params_of(PAVE_MODE_BEST, TILES);
    pave_stones *stones = NULL;
    sources.photo = photo;
    sources.sizes = sizes;
    assert_int_equal(pave_mosaic_create(context, &sources, NULL, &params, &stones), PAVE_ERR_ARGUMENT);
    params.size_from = PAVE_SIZE_IMAGE;
    assert_ok(pave_mosaic_create(context, &sources, NULL, &params, &stones));
    pave_mosaic_measure m = measure_of(context, stones);
    assert_true(m.sizes_met >= 0.9 && m.overlap == 0 && m.lost <= TILES / 100);
    assert_true(m.side_cv > 0.25);
    pave_stones_free(&stones);
    pave_image_free(&sizes);
    pave_image_free(&photo);
    free(zones);
}

static void transparent_regions_stay_free(void **state)
{
    pave_context *context = *state;
    uint8_t *rgba = malloc(4 * SIDE * SIDE), *rgb = malloc(3 * SIDE * SIDE);
    paint(rgb, SIDE, SIDE);
    for (int32_t i = 0; i < SIDE * SIDE; i++) {
        memcpy(rgba + 4 * i, rgb + 3 * i, 3);
        rgba[4 * i + 3] = i % SIDE < SIDE / 2 ? 0 : 255;
    }
    pave_image *photo = image_of(context, SIDE, SIDE, 4, PAVE_U8, 3, rgba);
    for (int mode = 0; mode < 2; mode++) {
        pave_mosaic_params params = params_of(mode, TILES / 2);
        pave_stones *stones = lay(context, photo, &params);
        for (int64_t i = 0; i < pave_stones_starts(stones)[pave_stones_count(stones)]; i++)
            assert_true(pave_stones_vertices(stones)[2 * i] > SIDE / 2 - 10);
        assert_true(measure_of(context, stones).coverage > (mode ? 0.42 : 0.3));
        pave_stones_free(&stones);
    }
    pave_image_free(&photo);
    memset(rgba, 0, 4 * SIDE * SIDE);
    photo = image_of(context, SIDE, SIDE, 4, PAVE_U8, 3, rgba);
    pave_mosaic_sources sources = PAVE_MOSAIC_SOURCES_INIT;
    pave_stones *none = NULL;
    sources.photo = photo;
    assert_int_equal(pave_mosaic_create(context, &sources, NULL, NULL, &none), PAVE_ERR_ARGUMENT);
    assert_null(none);
    pave_image_free(&photo);
    free(rgba);
    free(rgb);
}

/* Grey, 16 bits and floats of one value: no edges, and rows follow the frame. */
static void any_kind_of_photo(void **state)
{
    static const int32_t types[] = { PAVE_U8, PAVE_U16, PAVE_F32 };
    pave_context *context = *state;
    float *pixels = calloc(90 * 60, sizeof *pixels);
    for (int k = 0; k < 3; k++) {
        pave_image *photo = image_of(context, 90, 60, 1, types[k], -1, pixels);
        pave_mosaic_params params = params_of(PAVE_MODE_BEST, 54);
        pave_stones *stones = lay(context, photo, &params);
        pave_mosaic_measure m = measure_of(context, stones);
        assert_true(m.coverage > 0.88 && m.overlap == 0 && m.squareness < 10 && m.singularities == 0);
        assert_int_equal(pave_stones_rgb(stones)[0], 0);
        pave_stones_free(&stones);
        pave_image_free(&photo);
    }
    free(pixels);
}

static void counts_from_one_to_too_many(void **state)
{
    pave_context *context = *state;
    pave_image *photo = photo_of(context, 40, 30);
    pave_mosaic_sources sources = PAVE_MOSAIC_SOURCES_INIT;
    static const int32_t counts[] = { 1, 2, 3, 7, 100, 300, 573, 651, 1041, 1200 };
    sources.photo = photo;
    for (int mode = 0; mode < 2; mode++)
        for (int k = 0; k < 10; k++) {
            pave_mosaic_params params = params_of(mode, counts[k]);
            pave_stones *stones = lay(context, photo, &params);
            pave_mosaic_measure m = measure_of(context, stones);
            assert_true(m.tiles >= 1 && m.tiles + m.lost >= counts[k]);
            assert_true(mode == PAVE_MODE_PAPER || m.overlap == 0);
            pave_stones_free(&stones);
        }
    pave_mosaic_params params = params_of(PAVE_MODE_BEST, 1201);
    pave_stones *stones = NULL;
    assert_int_equal(pave_mosaic_create(context, &sources, NULL, &params, &stones), PAVE_ERR_ARGUMENT);
    assert_non_null(strstr(pave_context_message(context), "1201"));
    pave_image_free(&photo);
}

static void palettes_keep_to_their_stock(void **state)
{
    static const uint8_t colours[] = { 200, 100, 30, 50, 60, 120, 255, 255, 255 };
    int32_t stock[] = { 60, 50, 10 }, used[3] = { 0, 0, 0 };
    pave_context *context = *state;
    pave_image *photo = photo_of(context, 120, 100);
    pave_mosaic_sources sources = PAVE_MOSAIC_SOURCES_INIT;
    pave_mosaic_params params = params_of(PAVE_MODE_PAPER, 120);
    pave_stones *stones = NULL;
    sources.photo = photo;
    sources.palette = colours;
    sources.stock = stock;
    sources.palette_count = 3;
    assert_ok(pave_mosaic_create(context, &sources, NULL, &params, &stones));
    for (int32_t i = 0; i < pave_stones_count(stones); i++)
        for (int k = 0; k < 3; k++)
            used[k] += !memcmp(pave_stones_rgb(stones) + 3 * i, colours + 3 * k, 3);
    assert_int_equal(used[0] + used[1] + used[2], pave_stones_count(stones));
    for (int k = 0; k < 3; k++)
        assert_true(used[k] <= stock[k]);
    pave_stones_free(&stones);
    stock[2] = 9;
    assert_int_equal(pave_mosaic_create(context, &sources, NULL, &params, &stones), PAVE_ERR_ARGUMENT);
    pave_image_free(&photo);
}

static void edges_can_be_given(void **state)
{
    static const double points[] = { 40, 40, 220, 200, -50, -50, -20, -60 };
    static const int64_t starts[] = { 0, 2, 4 };
    pave_context *context = *state;
    pave_image *photo = photo_of(context, 260, 240);
    pave_mosaic_sources sources = PAVE_MOSAIC_SOURCES_INIT;
    pave_mosaic_params params = params_of(PAVE_MODE_BEST, 1000);
    pave_curves *curves = NULL;
    pave_guide *guide = NULL;
    sources.photo = photo;
    assert_ok(pave_curves_create(context, 2, starts, points, &curves));
    sources.curves = curves;
    assert_ok(pave_guide_create(context, &sources, &params, &guide));
    assert_int_equal(pave_guide_edges(guide)[120 * 260 + 130], 1);
    double angle = pave_guide_directions(guide)[120 * 260 + 130] * 360.0 / 65536;
    assert_true(fabs(angle - 41.6) < 1); /* atan(80 / 90) */
    pave_stones *stones = NULL;
    assert_ok(pave_mosaic_create(context, &sources, guide, &params, &stones));
    assert_true(measure_of(context, stones).edge_angle < 7);
    pave_stones_free(&stones);
    pave_guide_free(&guide);
    pave_curves_free(&curves);
    assert_ok(pave_curves_create(context, 1, starts, points + 4, &curves));
    sources.curves = curves;
    assert_int_equal(pave_guide_create(context, &sources, &params, &guide), PAVE_ERR_ARGUMENT);
    pave_curves_free(&curves);
    pave_image_free(&photo);
}

static pave_curves *read_svg(pave_context *context, const char *text, pave_result expected)
{
    char path[] = "/tmp/pave-curves-XXXXXX.svg";
    pave_curves *curves = NULL;
    int file = mkstemps(path, 4);
    assert_true(file >= 0 && write(file, text, strlen(text)) == (ssize_t)strlen(text));
    close(file);
    assert_int_equal(pave_curves_read(context, path, &curves), expected);
    unlink(path);
    return curves;
}

static void curves_come_from_svg(void **state)
{
    pave_context *context = *state;
    pave_curves *c = read_svg(context,
                              "<?xml version='1.0'?><!-- <path d='M0 0'/> --><svg><defs><path d='M1 1L2 2'/></defs>"
                              "<g transform='translate(10,20) scale(2)'><path d='m1-1 2,0v3.5.5zM0 0c1 0 2 1 2 2a1 1 0 1"
                              "1 2 0'/></g><polyline points='1,2 3,4'/><circle cx='5' cy='5' r='2'/></svg>", PAVE_OK);
    assert_int_equal(pave_curves_count(c), 4);
    const double *p = pave_curves_points(c);
    const double expected[] = { 12, 18, 16, 18, 16, 25, 16, 26, 12, 18 };
    for (int i = 0; i < 10; i++)
        assert_true(fabs(p[i] - expected[i]) < 1e-9);
    int64_t end = pave_curves_starts(c)[2] - 1;
    assert_true(fabs(p[2 * end] - 18) < 1e-6 && fabs(p[2 * end + 1] - 24) < 1e-6);
    pave_curves_free(&c);
    read_svg(context, "<svg><path d='M1 1 L", PAVE_ERR_FORMAT);
    read_svg(context, "<svg></svg>", PAVE_ERR_FORMAT);
    read_svg(context, "no picture", PAVE_ERR_FORMAT);
}

static void colours_differ_as_published(void **state)
{
    static const double pairs[][7] = { { 50, 2.6772, -79.7751, 50, 0, -82.7485, 2.0425 },
                                       { 50, 2.5, 0, 73, 25, -18, 27.1492 },
                                       { 6.7747, -0.2908, -2.4247, 5.8714, -0.0985, -2.2286, 0.6377 } };
    (void)state;
    for (int i = 0; i < 3; i++)
        assert_true(fabs(pv_ciede2000(pairs[i], pairs[i] + 3) - pairs[i][6]) < 1e-4);
    for (int v = 0; v < 256; v++)
        assert_int_equal(pv_tile_code(pv_tile_light(v / 255.0)), v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(best_mode_reaches_its_bars),
        cmocka_unit_test(chips_fill_gaps),
        cmocka_unit_test(paper_mode_lays_plain_tiles),
        cmocka_unit_test(engines_and_threads_agree),
        cmocka_unit_test(periodic_mosaics_have_no_seam),
        cmocka_unit_test(periodic_mosaics_of_all_that_is_given),
        cmocka_unit_test(sizes_are_met),
        cmocka_unit_test(transparent_regions_stay_free),
        cmocka_unit_test(any_kind_of_photo),
        cmocka_unit_test(counts_from_one_to_too_many),
        cmocka_unit_test(palettes_keep_to_their_stock),
        cmocka_unit_test(edges_can_be_given),
        cmocka_unit_test(curves_come_from_svg),
        cmocka_unit_test(colours_differ_as_published),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
