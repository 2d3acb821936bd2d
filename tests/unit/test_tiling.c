/* tiling: the paper's numbers, exact searches and cuts against their definitions, and what every tiling promises. */
#include "test.h"

#include "tiling/flow.h"
#include "tiling/search.h"
#include "tiling/tiling.h"
#include "util/random.h"

#include <math.h>

/* Cells of stone with dark joints, one value a channel; the same for the same key. */
static pave_image *make_stones(pave_context *context, int32_t width, int32_t height, int32_t channels, int32_t type,
                               uint32_t key)
{
    enum { CELL = 14 };
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    params.width = width;
    params.height = height;
    params.channels = channels;
    params.type = type;
    params.encoding = type >= PAVE_F16 ? PAVE_LINEAR : PAVE_DISPLAY;
    assert_ok(pave_image_create(context, &params, NULL, &image));
    for (int32_t i = 0; i < width * height; i++) {
        int32_t x = i % width, y = i / width, near = 1 << 20, second = 1 << 20, tone = 0;
        for (int32_t k = 0; k < 25; k++) {
            int32_t cx = x / CELL + k % 5 - 2, cy = y / CELL + k / 5 - 2;
            pv_random r = pv_draw(key, 99, (uint32_t)(cx + 8), (uint32_t)(cy + 8), 0);
            int32_t dx = cx * CELL + (int32_t)(r.word[0] % CELL) - x, dy = cy * CELL + (int32_t)(r.word[1] % CELL) - y;
            int32_t d = (int32_t)(16 * sqrt(dx * dx + dy * dy));
            second = d < near ? near : d < second ? d : second;
            tone = d < near ? (int32_t)(r.word[2] % 96) + 120 : tone;
            near = d < near ? d : near;
        }
        int32_t v = second - near < 36 ? 30 : tone + (int32_t)(pv_draw(key, 98, (uint32_t)x, (uint32_t)y, 0).word[0] % 20);
        for (int32_t c = 0; c < channels; c++) {
            int32_t at = i * channels + c, value = v * (4 + c) / (4 + channels);
            switch (type) {
            case PAVE_U8: ((uint8_t *)image->pixels)[at] = (uint8_t)value; break;
            case PAVE_U16: ((uint16_t *)image->pixels)[at] = (uint16_t)(value * 257); break;
            default: ((float *)image->pixels)[at] = (float)value / 64;
            }
        }
    }
    return image;
}

static pave_tiling *tile(pave_context *context, pave_image *exemplar, const pave_tiling_params *params)
{
    const pave_image *const images[1] = { exemplar };
    pave_tiling *tiling = NULL;
    assert_ok(pave_tiling_create(context, images, 1, NULL, params, &tiling));
    return tiling;
}

static pave_image *apply(pave_context *context, const pave_tiling *tiling, pave_image *map)
{
    const pave_image *const images[1] = { map };
    pave_image *out = NULL;
    assert_ok(pave_tiling_apply(context, tiling, images, 1, &out));
    return out;
}

static uint64_t hash_sources(const pave_tiling *tiling)
{
    return hash_bytes(pave_tiling_sources(tiling),
                      sizeof(pave_source) * (size_t)pave_tiling_width(tiling) * (size_t)pave_tiling_height(tiling));
}

static void table_1_comes_out(void **state)
{
    (void)state;
    assert_int_equal(pave_tiling_fractions(128, 128, 20, 20), 11881);
    assert_int_equal(pave_tiling_fractions(128, 128, 40, 40), 7921);
    assert_int_equal(pave_tiling_fractions(128, 128, 50, 50), 6241);
    assert_int_equal(pave_tiling_fractions(128, 128, 100, 100), 841);
    assert_int_equal(pave_tiling_fractions(128, 128, 129, 1), 0);
    assert_int_equal(pave_tiling_fractions(1 << 20, 1 << 20, 1, 1), (int64_t)1 << 40);
}

/* A bank of one image, or of one with holes, and a query of random pixels that count. */
static void fill_query(pv_query *query, const pv_bank *bank, int32_t side, uint32_t key)
{
    pv_query_begin(query, side, side);
    for (int32_t i = 0; i < side * side; i++) {
        pv_random r = pv_draw(key, 97, (uint32_t)i, 0, 0);
        int32_t other = bank->sheet[0].first + (int32_t)(r.word[0] % 30) * bank->stride + (int32_t)(r.word[1] % 30);
        if (r.word[2] % 3)
            pv_query_set(query, i % side, i / side, other);
    }
    pv_query_end(query);
}

static void assert_searches_agree(pave_context *context, pave_image *image, int32_t turns)
{
    static const int32_t ways[] = { PAVE_SEARCH_REFERENCE, PAVE_SEARCH_DIRECT, PAVE_SEARCH_FFT, PAVE_SEARCH_AUTO };
    const pave_image *const images[1] = { image };
    pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
    pv_bank bank;
    params.turns = turns;
    assert_ok(pv_bank_create(context, images, 1, &params, &bank));
    for (uint32_t key = 0; key < 6; key++) {
        pv_query query;
        int32_t side = 3 + 5 * (int32_t)key, place[4];
        int64_t difference[4];
        assert_ok(pv_query_create(context, &bank, side, side, &query));
        fill_query(&query, &bank, side, key);
        for (int k = 0; k < 4; k++) {
            pv_searcher searcher = { .bank = &bank, .search = ways[k] };
            assert_ok(pv_search_least(context, &searcher, &query, &place[k], &difference[k]));
            assert_int_equal(place[k], place[0]);
            assert_int_equal(difference[k], difference[0]);
            pv_searcher_free(&searcher);
        }
        int32_t at = bank.sheet[0].first + 7 * bank.stride + 5;
        int64_t exact = pv_compare_reference(&query, at, PV_NO_PLACE);
        assert_int_equal(pv_compare_portable(&query, at, PV_NO_PLACE), exact);
        assert_int_equal(pv_compare_choose(PAVE_SEARCH_DIRECT)(&query, at, PV_NO_PLACE), exact);
        pv_query_free(&query);
    }
    pv_bank_free(&bank);
}

static void all_searches_find_the_same(void **state)
{
    static const int32_t channels[] = { 1, 3, 4, 7, 3, 3 };
    static const int32_t types[] = { PAVE_U8, PAVE_U8, PAVE_U8, PAVE_U8, PAVE_U16, PAVE_F32 };
    for (int k = 0; k < 6; k++) {
        pave_image *image = make_stones(*state, 45, 39, channels[k], types[k], (uint32_t)k);
        assert_searches_agree(*state, image, k == 1);
        if (types[k] == PAVE_U8) /* all alike: the first in scan order */
            memset(image->pixels, 77, (size_t)(45 * 39 * channels[k]));
        assert_searches_agree(*state, image, 0);
        pave_image_free(&image);
    }
}

/* The compute shader, where there is a device. */
static void a_device_finds_the_same(void **state)
{
    if (SANITIZED)
        skip(); /* drivers leak, and lock as they like */
    pave_image *image = make_stones(*state, 40, 36, 3, PAVE_F32, 3);
    const pave_image *const images[1] = { image };
    float *p = image->pixels;
    p[3 * (20 * 40 + 5)] = NAN;
    uint64_t hashes[2][2];
    for (int32_t mode = PAVE_TILING_FAST; mode <= PAVE_TILING_PAPER; mode++)
        for (int k = 0; k < 2; k++) {
            pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
            pave_tiling *tiling = NULL;
            params.mode = mode;
            params.fraction = 12;
            params.search = k ? PAVE_SEARCH_VULKAN : PAVE_SEARCH_DIRECT;
            pave_result result = pave_tiling_create(*state, images, 1, NULL, &params, &tiling);
            if (result == PAVE_ERR_DEVICE || result == PAVE_ERR_UNSUPPORTED) {
                pave_image_free(&image);
                print_message("skipped: %s\n", pave_context_message(*state));
                return;
            }
            assert_ok(result);
            hashes[mode - 1][k] = hash_sources(tiling);
            pave_tiling_free(&tiling);
        }
    assert_true(hashes[0][0] == hashes[0][1] && hashes[1][0] == hashes[1][1]);
    pave_image_free(&image);
}

/* What messages say. */
static void remember(void *user, int32_t level, const char *text)
{
    (void)level;
    if (strstr(text, "going on with the CPU"))
        ++*(int32_t *)user;
}

/* Without any driver: who named a device gets an error, who did not gets the same from the CPU. */
static void a_device_that_fails(void **state)
{
    (void)state;
    not_for_threads();
    if (SANITIZED)
        skip();
    int32_t told = 0;
    pave_context_params with = PAVE_CONTEXT_PARAMS_INIT;
    pave_context *context = NULL;
    with.message = remember;
    with.message_user = &told;
    assert_ok(pave_context_create(&with, &context));
    pave_image *image = make_stones(context, 40, 36, 3, PAVE_U8, 3);
    setenv("VK_DRIVER_FILES", "/nonexistent.json", 1);
    setenv("VK_ICD_FILENAMES", "/nonexistent.json", 1);
    pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
    params.mode = PAVE_TILING_FAST;
    params.search = PAVE_SEARCH_VULKAN;
    const pave_image *const images[1] = { image };
    pave_tiling *tiling = NULL;
    pave_result result = pave_tiling_create(context, images, 1, NULL, &params, &tiling);
    assert_true(result == PAVE_ERR_DEVICE || result == PAVE_ERR_UNSUPPORTED);
    pv_bank bank;
    pv_query query;
    int64_t costs[2][25 * 21];
    assert_ok(pv_bank_create(context, images, 1, &params, &bank));
    assert_ok(pv_query_create(context, &bank, 16, 16, &query));
    fill_query(&query, &bank, 16, 1);
    pv_places places = pv_places_all(&bank.sheet[0], 16, 16);
    for (int k = 0; k < 2; k++) {
        pv_searcher searcher = { .bank = &bank, .search = PAVE_SEARCH_AUTO, .may_gpu = k ? PV_GPU_ALWAYS : 0 };
        assert_ok(pv_search_costs(context, &searcher, &query, &places, costs[k]));
        assert_ok(pv_search_costs(context, &searcher, &query, &places, costs[k])); /* says it once */
        pv_searcher_free(&searcher);
    }
    assert_memory_equal(costs[0], costs[1], sizeof costs[0]);
    assert_int_equal(told, 1);
    unsetenv("VK_DRIVER_FILES");
    unsetenv("VK_ICD_FILENAMES");
    pv_query_free(&query);
    pv_bank_free(&bank);
    pave_image_free(&image);
    pave_context_free(&context);
}

static void modes_do_not_depend_on_the_search(void **state)
{
    not_for_threads();
    pave_image *image = make_stones(*state, 48, 48, 3, PAVE_U8, 3);
    for (int32_t mode = 0; mode < 3; mode++) {
        uint64_t first = 0;
        for (int32_t search = PAVE_SEARCH_AUTO; search <= PAVE_SEARCH_FFT; search++) {
            pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
            params.mode = mode;
            params.search = search;
            params.rounds = 8;
            pave_tiling *tiling = tile(*state, image, &params);
            uint64_t hash = hash_sources(tiling);
            first = search ? first : hash;
            assert_true(hash == first);
            pave_tiling_free(&tiling);
        }
    }
    pave_image_free(&image);
}

enum { GRID = 4 };

typedef struct grid { int32_t terminal[GRID * 3], right[GRID * 3][2], down[GRID * 3][2]; } grid;

/* What a set of nodes on the source's side costs: bit i for node i. */
static int64_t cut_cost(const grid *g, int32_t set)
{
    int64_t cost = 0;
    for (int32_t i = 0; i < GRID * 3; i++) {
        int in = set >> i & 1;
        cost += in ? (g->terminal[i] < 0 ? -g->terminal[i] : 0) : (g->terminal[i] > 0 ? g->terminal[i] : 0);
        if (i % GRID + 1 < GRID && in != (set >> (i + 1) & 1))
            cost += g->right[i][!in];
        if (i + GRID < GRID * 3 && in != (set >> (i + GRID) & 1))
            cost += g->down[i][!in];
    }
    return cost;
}

/* Against all cuts of small grids: the least, and of the least ones the smallest. */
static void cuts_are_least_and_smallest(void **state)
{
    not_for_threads();
    pv_flow flow;
    assert_ok(pv_flow_create(*state, GRID, 3, &flow));
    for (uint32_t key = 0; key < 60; key++) {
        grid g = { { 0 }, { { 0 } }, { { 0 } } };
        int32_t best = 0;
        pv_flow_begin(&flow, GRID, 3);
        for (int32_t i = 0; i < GRID * 3; i++) {
            pv_random r = pv_draw(key, 96, (uint32_t)i, 0, 0), s = pv_draw(key, 96, (uint32_t)i, 1, 0);
            pv_node *node = &flow.node[pv_flow_node(&flow, i % GRID, i / GRID)];
            node->terminal = g.terminal[i] = (int32_t)(r.word[0] % 15) - 7;
            if (i % GRID + 1 < GRID) {
                node->capacity[PV_RIGHT] = g.right[i][0] = (int32_t)(r.word[1] % 6);
                (node + 1)->capacity[PV_LEFT] = g.right[i][1] = (int32_t)(r.word[2] % 6);
            }
            if (i + GRID < GRID * 3) {
                node->capacity[PV_DOWN] = g.down[i][0] = (int32_t)(s.word[0] % 6);
                (node + flow.stride)->capacity[PV_UP] = g.down[i][1] = (int32_t)(s.word[1] % 6);
            }
        }
        for (int32_t set = 1; set < 1 << (GRID * 3); set++) {
            int64_t cost = cut_cost(&g, set), least = cut_cost(&g, best);
            if (cost < least || (cost == least && __builtin_popcount((unsigned)set) < __builtin_popcount((unsigned)best)))
                best = set;
        }
        pv_flow_solve(&flow);
        for (int32_t i = 0; i < GRID * 3; i++)
            assert_int_equal(pv_flow_chosen(&flow, pv_flow_node(&flow, i % GRID, i / GRID)), best >> i & 1);
    }
    pv_flow_free(&flow);
}

/* The text's algorithm once more, pixel by pixel. */
static void paper_mode_is_the_text(void **state)
{
    not_for_threads();
    enum { SIDE = 24, OUT = 40, F = 9, OVER = 2, STEP = F - OVER };
    pave_image *image = make_stones(*state, SIDE, SIDE, 3, PAVE_U8, 5);
    pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
    params.mode = PAVE_TILING_PAPER;
    params.extent[0] = params.extent[1] = OUT;
    params.fraction = F;
    params.overlap = OVER;
    pave_tiling *tiling = tile(*state, image, &params);
    pave_image *laid = apply(*state, tiling, image);
    const uint8_t *e = image->pixels;
    uint8_t out[OUT * OUT * 3] = { 0 }, done[OUT * OUT] = { 0 };
    for (int32_t k = 0; k < 36; k++) {
        int32_t x0 = k % 6 * STEP, y0 = k / 6 * STEP, best = -1;
        int64_t least = INT64_MAX;
        for (int32_t at = 0; at < (SIDE - F + 1) * (SIDE - F + 1); at++) {
            int32_t ex = at % (SIDE - F + 1), ey = at / (SIDE - F + 1);
            int64_t sum = 0;
            for (int32_t i = 0; i < F * F * 3; i++) {
                int32_t x = x0 + i / 3 % F, y = y0 + i / 3 / F;
                if (x >= OUT || y >= OUT || !done[y * OUT + x])
                    continue;
                int32_t d = out[(y * OUT + x) * 3 + i % 3] - e[((ey + i / 3 / F) * SIDE + ex + i / 3 % F) * 3 + i % 3];
                sum += d * d;
            }
            if (sum < least)
                least = sum, best = at;
        }
        const pave_source *first = &pave_tiling_sources(tiling)[0];
        if (!k)
            best = first->y * (SIDE - F + 1) + first->x;
        for (int32_t i = 0; i < F * F; i++) {
            int32_t x = x0 + i % F, y = y0 + i / F;
            if (x >= OUT || y >= OUT)
                continue;
            for (int32_t c = 0; c < 3; c++) {
                int32_t new = e[((best / (SIDE - F + 1) + i / F) * SIDE + best % (SIDE - F + 1) + i % F) * 3 + c];
                uint8_t *there = &out[(y * OUT + x) * 3 + c];
                *there = (uint8_t)(done[y * OUT + x] ? (*there + new + 1) / 2 : new);
            }
            done[y * OUT + x] = 1;
        }
    }
    assert_memory_equal(out, laid->pixels, sizeof out);
    pave_image_free(&laid);
    pave_image_free(&image);
    pave_tiling_free(&tiling);
}

/* Mean step across the lines where fractions begin, against the mean of all lines (Fig. 9). */
static double visible_seams(pave_context *context, pave_image *image, int32_t fraction)
{
    pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
    double at_seams = 0, all = 0;
    int32_t seams = 0, lines = 0;
    params.mode = PAVE_TILING_PAPER;
    params.fraction = fraction;
    pave_tiling *tiling = tile(context, image, &params);
    pave_image *laid = apply(context, tiling, image);
    for (int32_t x = 1; x < laid->width; x++) {
        double sum = 0;
        for (int32_t y = 0; y < laid->height; y++)
            sum += abs(((uint8_t *)laid->pixels)[y * laid->width + x] - ((uint8_t *)laid->pixels)[y * laid->width + x - 1]);
        all += sum;
        lines++;
        if (x % (fraction - 3) == 0 || (x > 3 && (x - 3) % (fraction - 3) == 0))
            at_seams += sum, seams++;
    }
    pave_image_free(&laid);
    pave_tiling_free(&tiling);
    return at_seams / seams / (all / lines);
}

static void smaller_fractions_show_fewer_seams(void **state)
{
    not_for_threads();
    pave_image *image = make_stones(*state, 128, 128, 1, PAVE_U8, 1);
    double small = visible_seams(*state, image, 20), large = visible_seams(*state, image, 100);
    assert_true(small < large);
    pave_image_free(&image);
}

static void threads_do_not_matter(void **state)
{
    static const int32_t threads[] = { 1, 2, 7 };
    (void)state;
    for (int32_t mode = 0; mode < 3; mode++) {
        uint64_t first = 0;
        for (int k = 0; k < 3; k++) {
            pave_context *context = make_context(threads[k], PAVE_BACKEND_CPU);
            pave_image *image = make_stones(context, 64, 56, 3, PAVE_U8, 1);
            pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
            params.mode = mode;
            params.rounds = THREAD_SANITIZED ? 3 : 12;
            params.extent[0] = THREAD_SANITIZED ? 100 : 210;
            params.extent[1] = THREAD_SANITIZED ? 90 : 199;
            pave_tiling *tiling = tile(context, image, &params);
            first = k ? first : hash_sources(tiling);
            assert_true(hash_sources(tiling) == first);
            pave_tiling_free(&tiling);
            pave_image_free(&image);
            pave_context_free(&context);
        }
    }
}

/* An image that holds its own coordinates, laid like the exemplar, tells the sources. */
static void companions_are_laid_alike(void **state)
{
    not_for_threads();
    enum { W = 50, H = 40 };
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    float place[W * H * 2];
    pave_image *map = NULL, *image = make_stones(*state, W, H, 3, PAVE_U8, 2);
    shape.width = W;
    shape.height = H;
    shape.channels = 2;
    shape.type = PAVE_F32;
    shape.encoding = PAVE_DATA;
    shape.names = "x,y";
    for (int32_t i = 0; i < W * H; i++)
        place[2 * i] = (float)(i % W), place[2 * i + 1] = (float)(i / W);
    assert_ok(pave_image_create(*state, &shape, place, &map));
    for (int32_t turned = 0; turned < 2; turned++) {
        pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
        params.rounds = 10;
        params.turns = params.flips = turned;
        pave_tiling *tiling = tile(*state, image, &params);
        pave_image *laid = apply(*state, tiling, image), *places = apply(*state, tiling, map);
        const pave_source *source = pave_tiling_sources(tiling);
        int32_t turns = 0;
        for (int32_t i = 0; i < 4 * W * H; i++) {
            const uint8_t *from = (const uint8_t *)image->pixels + 3 * (source[i].y * W + source[i].x);
            assert_memory_equal(from, (const uint8_t *)laid->pixels + 3 * i, 3);
            assert_true(((float *)places->pixels)[2 * i] == (float)source[i].x);
            assert_true(((float *)places->pixels)[2 * i + 1] == (float)source[i].y);
            turns |= 1 << source[i].turn;
        }
        assert_true(turned ? turns > 1 : turns == 1);
        pave_image_free(&laid);
        pave_image_free(&places);
        pave_tiling_free(&tiling);
    }
    pave_image *wrong = make_stones(*state, W, H + 1, 3, PAVE_U8, 2), *out = NULL;
    const pave_image *const images[1] = { wrong };
    pave_tiling *tiling = tile(*state, image, &(pave_tiling_params){ .size = sizeof(size_t) });
    assert_int_equal(pave_tiling_apply(*state, tiling, images, 1, &out), PAVE_ERR_ARGUMENT);
    assert_null(out);
    pave_tiling_free(&tiling);
    pave_image_free(&wrong);
    pave_image_free(&map);
    pave_image_free(&image);
}

/* A map of one pixel value everywhere, as large as an image. */
static pave_image *make_even(pave_context *context, const pave_image *image, int32_t type, const void *value)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_image *map = NULL;
    shape.width = image->width;
    shape.height = image->height;
    shape.channels = 3;
    shape.type = type;
    shape.encoding = PAVE_DATA;
    assert_ok(pave_image_create(context, &shape, NULL, &map));
    size_t bytes = 3 * pv_type_bytes(type);
    for (int32_t i = 0; i < image->width * image->height; i++)
        memcpy((char *)map->pixels + (size_t)i * bytes, value, bytes);
    return map;
}

static int adjoin(const pave_source *a, const pave_source *b)
{
    return a->turn == b->turn && abs(a->x - b->x) + abs(a->y - b->y) == 1;
}

/* A slope of 3 to the right and 5 down in the exemplar: within a copy, however it is turned, the laid normals are the
 * laid heights' differences. A few pixels look like neighbours across a cut. */
static void assert_slopes_are_turned(const pave_tiling *tiling, const pave_image *down, const pave_image *up)
{
    const pave_source *source = pave_tiling_sources(tiling);
    const float *d = down->pixels, *u = up->pixels;
    int32_t width = down->width, turned = 0, wrong = 0;
    for (int32_t i = 0; i < width * (down->height - 1); i++) {
        const pave_source *s = &source[i];
        assert_true(u[3 * i] == d[3 * i] && u[3 * i + 1] == -d[3 * i + 1] && d[3 * i + 2] == 7);
        int32_t height = 3 * s->x + 5 * s->y;
        if (i % width + 1 < width && adjoin(s, s + 1))
            wrong += 3 * s[1].x + 5 * s[1].y - height != (int32_t)d[3 * i];
        if (adjoin(s, s + width))
            wrong += 3 * s[width].x + 5 * s[width].y - height != (int32_t)d[3 * i + 1];
        turned += (s->turn & 1) && s->turn > 4;
    }
    assert_true(turned > 100 && wrong * 100 < width * down->height);
}

static void normals_are_turned_with_their_copies(void **state)
{
    not_for_threads();
    static const float slope_down[3] = { 3, 5, 7 }, slope_up[3] = { 3, -5, 7 };
    static const uint8_t tinted[3] = { 200, 130, 250 };
    pave_image *image = make_stones(*state, 50, 40, 3, PAVE_U8, 2), *map[3], *laid[3];
    pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
    params.turns = params.flips = 1;
    for (int32_t mode = PAVE_TILING_FAST; mode <= PAVE_TILING_PAPER; mode++) {
        params.mode = mode;
        params.overlap = mode == PAVE_TILING_PAPER;
        params.fraction = 12;
        pave_tiling *tiling = tile(*state, image, &params);
        map[0] = make_even(*state, image, PAVE_F32, slope_down);
        map[1] = make_even(*state, image, PAVE_F32, slope_up);
        map[2] = make_even(*state, image, PAVE_U8, tinted);
        for (int k = 0; k < 3; k++) {
            const pave_image *const maps[1] = { map[k] };
            assert_ok(pave_tiling_apply_normals(*state, tiling, maps, 1, k == 1, &laid[k]));
        }
        if (mode == PAVE_TILING_FAST)
            assert_slopes_are_turned(tiling, laid[0], laid[1]);
        int32_t mirrored = 0;
        for (int32_t i = 0; i < 4 * 50 * 40 && mode == PAVE_TILING_FAST; i++) {
            const uint8_t *p = (const uint8_t *)laid[2]->pixels + 3 * i;
            mirrored += pave_tiling_sources(tiling)[i].turn == 4;
            if (pave_tiling_sources(tiling)[i].turn == 4)
                assert_true(p[0] == 55 && p[1] == 130 && p[2] == 250);
        }
        assert_true(mode == PAVE_TILING_PAPER || mirrored);
        for (int k = 0; k < 3; k++) {
            pave_image_free(&map[k]);
            pave_image_free(&laid[k]);
        }
        pave_tiling_free(&tiling);
    }
    pave_image *grey = make_stones(*state, 50, 40, 1, PAVE_U8, 2), *out = NULL;
    const pave_image *const greys[1] = { grey };
    pave_tiling *tiling = tile(*state, grey, &(pave_tiling_params){ .size = sizeof(size_t) });
    assert_int_equal(pave_tiling_apply_normals(*state, tiling, greys, 1, 1, &out), PAVE_ERR_ARGUMENT);
    pave_tiling_free(&tiling);
    pave_image_free(&grey);
    pave_image_free(&image);
}

static double seam_ratio(const pave_image *image, int across)
{
    int32_t w = image->width, h = image->height, lines = across ? w : h, along = across ? h : w;
    const uint8_t *p = image->pixels;
    double border = 0, inside = 0;
    for (int32_t i = 0; i < lines; i++)
        for (int32_t k = 0; k < along; k++) {
            int32_t a = across ? k * w + i : i * w + k, b = across ? k * w + (i + 1) % w : (i + 1) % h * w + k;
            for (int32_t c = 0; c < image->channels; c++)
                *(i + 1 < lines ? &inside : &border) += abs(p[a * image->channels + c] - p[b * image->channels + c]);
        }
    return border / (inside / (lines - 1));
}

/* Means over some seeds, for one line of a flawless texture scatters, too. */
static void borders_close_where_asked(void **state)
{
    not_for_threads();
    enum { SEEDS = 4 };
    pave_image *image = make_stones(*state, 72, 72, 3, PAVE_U8, 4);
    for (int32_t mode = 0; mode < 2; mode++)
        for (int32_t periodic = 0; periodic < 4; periodic++) {
            double x = 0, y = 0;
            for (int32_t seed = 1; seed <= SEEDS; seed++) {
                pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
                params.mode = mode;
                params.periodic = periodic;
                params.seed = (uint64_t)seed;
                params.rounds = 20;
                pave_tiling *tiling = tile(*state, image, &params);
                pave_image *laid = apply(*state, tiling, image);
                x += seam_ratio(laid, 1) / SEEDS;
                y += seam_ratio(laid, 0) / SEEDS;
                pave_image_free(&laid);
                pave_tiling_free(&tiling);
            }
            assert_true(periodic == PAVE_PERIODIC_XY || periodic == PAVE_PERIODIC_X ? x < 1.3 : x > 2);
            assert_true(periodic == PAVE_PERIODIC_XY || periodic == PAVE_PERIODIC_Y ? y < 1.3 : y > 2);
        }
    pave_image_free(&image);
}

static void keep_changes_only_the_band(void **state)
{
    not_for_threads();
    enum { SIDE = 96, BAND = 20, SEEDS = 4 };
    pave_image *image = make_stones(*state, SIDE, SIDE, 3, PAVE_U8, 6);
    pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
    double seam[2] = { 0, 0 };
    params.keep = 1;
    params.band = BAND;
    for (params.seed = 1; params.seed <= SEEDS; params.seed++) {
        pave_tiling *tiling = tile(*state, image, &params);
        pave_image *laid = apply(*state, tiling, image);
        const pave_source *source = pave_tiling_sources(tiling);
        int32_t changed = 0;
        assert_int_equal(pave_tiling_width(tiling), SIDE);
        for (int32_t i = 0; i < SIDE * SIDE; i++) {
            int32_t x = i % SIDE, y = i / SIDE, same = source[i].x == x && source[i].y == y;
            int middle = x >= BAND && y >= BAND && x < SIDE - BAND && y < SIDE - BAND;
            assert_true(same || !middle);
            changed += !same;
        }
        assert_true(changed > 0);
        for (int k = 0; k < 2; k++)
            seam[k] += seam_ratio(laid, k) / SEEDS;
        pave_image_free(&laid);
        pave_tiling_free(&tiling);
    }
    assert_true(seam[0] < 1.4 && seam[1] < 1.4);
    assert_true(seam_ratio(image, 0) > 1.4 && seam_ratio(image, 1) > 1.4);
    pave_image_free(&image);
}

/* Every combination of colours once, and the same pixels along both sides of every edge of one colour. */
static void wang_sets_are_complete_and_fit(void **state)
{
    pave_image *image = make_stones(*state, 64, 64, 3, PAVE_U8, 7);
    for (int32_t colours = 2; colours <= 3 - THREAD_SANITIZED; colours++) {
        pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
        int32_t n = colours * colours, seen[81] = { 0 };
        params.wang = colours;
        params.extent[0] = params.extent[1] = n * 48;
        params.rounds = 4;
        pave_tiling *tiling = tile(*state, image, &params);
        const pave_wang_tile *tiles = pave_tiling_wang_tiles(tiling);
        const pave_source *source = pave_tiling_sources(tiling);
        assert_int_equal(pave_tiling_wang_count(tiling), n * n);
        for (int32_t i = 0; i < n * n; i++) {
            int32_t key = ((tiles[i].north * colours + tiles[i].east) * colours + tiles[i].south) * colours + tiles[i].west;
            assert_int_equal(seen[key]++, 0);
            for (int32_t k = 0; k < n * n; k++)
                for (int32_t along = 0; along < 48; along++) {
                    const pave_source *a = source + (tiles[i].y + along) * n * 48 + tiles[i].x;
                    const pave_source *b = source + (tiles[k].y + along) * n * 48 + tiles[k].x;
                    if (tiles[i].west == tiles[k].west)
                        assert_memory_equal(a, b, sizeof *a);
                    if (tiles[i].east == tiles[k].east)
                        assert_memory_equal(a + 47, b + 47, sizeof *a);
                    a = source + tiles[i].y * n * 48 + tiles[i].x + along;
                    b = source + tiles[k].y * n * 48 + tiles[k].x + along;
                    if (tiles[i].north == tiles[k].north)
                        assert_memory_equal(a, b, sizeof *a);
                    if (tiles[i].south == tiles[k].south)
                        assert_memory_equal(a + 47 * n * 48, b + 47 * n * 48, sizeof *a);
                }
        }
        pave_tiling_free(&tiling);
    }
    pave_image_free(&image);
}

/* Transparent pixels and those that are no numbers do not show. */
static void unusable_pixels_are_not_used(void **state)
{
    enum { SIDE = 80 };
    pave_image *image = make_stones(*state, SIDE, SIDE, 4, PAVE_F32, 8);
    image->alpha = 3;
    float *p = image->pixels;
    for (int32_t i = 0; i < SIDE * SIDE; i++)
        p[4 * i + 3] = i % SIDE > 60 && i / SIDE < 30 ? 0.2f : 1;
    p[4 * (70 * SIDE + 10)] = NAN;
    p[4 * (71 * SIDE + 70) + 1] = INFINITY;
    for (int32_t mode = 0; mode < 3; mode++) {
        pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
        params.mode = mode;
        params.rounds = 10;
        pave_tiling *tiling = tile(*state, image, &params);
        for (int32_t i = 0; i < 4 * SIDE * SIDE; i++) {
            const pave_source *s = &pave_tiling_sources(tiling)[i];
            const float *from = p + 4 * (s->y * SIDE + s->x);
            assert_true(from[3] >= 0.5f && isfinite(from[0]) && isfinite(from[1]));
        }
        pave_tiling_free(&tiling);
    }
    for (int32_t i = 0; i < SIDE * SIDE; i++)
        p[4 * i + 3] = 0;
    const pave_image *const images[1] = { image };
    pave_tiling *none = NULL;
    assert_int_equal(pave_tiling_create(*state, images, 1, NULL, NULL, &none), PAVE_ERR_ARGUMENT);
    assert_non_null(strstr(pave_context_message(*state), "no usable pixel"));
    pave_image_free(&image);
}

/* One value far out must not leave all others alike, nor the measures without a number. */
static void values_far_out_do_not_rule(void **state)
{
    static const float far[] = { 1, 3e38f, -3e38f };
    enum { SIDE = 64 };
    double coherence[3];
    not_for_threads();
    for (int k = 0; k < 3; k++) {
        pave_tiling_measure measure = { .size = sizeof measure };
        pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
        pave_image *image = make_stones(*state, SIDE, SIDE, 3, PAVE_F32, 8);
        const pave_image *const images[1] = { image };
        ((float *)image->pixels)[3 * (30 * SIDE + 30)] = far[k];
        params.mode = PAVE_TILING_FAST;
        pave_tiling *tiling = tile(*state, image, &params);
        assert_ok(pave_tiling_judge(*state, tiling, images, 1, &measure));
        assert_true(isfinite(measure.seam_x) && isfinite(measure.seam_energy) && isfinite(measure.histogram) &&
                    isfinite(measure.sliced) && isfinite(measure.sharpness) && isfinite(measure.repeat));
        coherence[k] = measure.coherence;
        pave_tiling_free(&tiling);
        pave_image_free(&image);
    }
    assert_true(coherence[1] < 1.3 * coherence[0] && coherence[2] < 1.3 * coherence[0]);
}

static uint64_t hash_guided(pave_context *context, pave_image *exemplar, const pave_image *guide)
{
    const pave_image *const images[1] = { exemplar };
    pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
    pave_tiling *tiling = NULL;
    params.rounds = 6;
    params.extent[0] = params.extent[1] = 96;
    assert_ok(pave_tiling_create(context, images, 1, guide, &params, &tiling));
    uint64_t hash = hash_sources(tiling);
    pave_tiling_free(&tiling);
    return hash;
}

/* What is no number in a guide is dark. */
static void a_guide_may_have_gaps(void **state)
{
    enum { SIDE = 96 };
    static const float gaps[] = { 0, NAN, INFINITY, -INFINITY };
    uint64_t part[4], all[4];
    not_for_threads();
    pave_image *image = make_stones(*state, 64, 64, 3, PAVE_F32, 8);
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = shape.height = SIDE;
    shape.channels = 1;
    shape.type = PAVE_F32;
    for (int k = 0; k < 4; k++) {
        pave_image *guide = NULL;
        float values[SIDE * SIDE];
        for (int32_t i = 0; i < SIDE * SIDE; i++)
            values[i] = i % SIDE > 20 && i % SIDE < 40 ? gaps[k] : (float)(i % SIDE) / SIDE;
        assert_ok(pave_image_create(*state, &shape, values, &guide));
        part[k] = hash_guided(*state, image, guide);
        for (int32_t i = 0; i < SIDE * SIDE; i++)
            ((float *)guide->pixels)[i] = gaps[k];
        all[k] = hash_guided(*state, image, guide);
        pave_image_free(&guide);
        assert_true(part[k] == part[0] && all[k] == all[0]);
    }
    assert_true(part[0] != all[0]);
    pave_image_free(&image);
}

/* A companion's values are carried as they are, whatever they are. */
static void maps_may_have_gaps(void **state)
{
    enum { SIDE = 64 };
    pave_image *image = make_stones(*state, SIDE, SIDE, 3, PAVE_U8, 8);
    pave_image *map = make_stones(*state, SIDE, SIDE, 2, PAVE_F32, 8);
    uint32_t *bits = map->pixels;
    for (int32_t i = 0; i < 2 * SIDE * SIDE; i += 7)
        bits[i] = i % 2 ? 0x7fc01234u + (uint32_t)i % 16 : 0xff800000u; /* no numbers of several kinds, -infinity */
    pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
    params.mode = PAVE_TILING_FAST;
    pave_tiling *tiling = tile(*state, image, &params);
    pave_image *out = apply(*state, tiling, map);
    const pave_source *source = pave_tiling_sources(tiling);
    for (int32_t i = 0; i < 4 * SIDE * SIDE; i++)
        assert_memory_equal((uint32_t *)out->pixels + 2 * i, bits + 2 * (source[i].y * SIDE + source[i].x), 8);
    pave_image_free(&out);
    pave_tiling_free(&tiling);
    pave_image_free(&map);
    pave_image_free(&image);
}

static void several_exemplars_and_a_guide(void **state)
{
    not_for_threads();
    pave_image *a = make_stones(*state, 64, 64, 3, PAVE_U8, 1), *b = make_stones(*state, 60, 70, 3, PAVE_U8, 9);
    for (int32_t i = 0; i < 64 * 64 * 3; i++)
        ((uint8_t *)a->pixels)[i] /= 3;
    const pave_image *const images[2] = { a, b };
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
    pave_image *guide = NULL;
    pave_tiling *tiling = NULL;
    shape.width = shape.height = 128;
    uint8_t wanted[128 * 128];
    for (int32_t i = 0; i < 128 * 128; i++)
        wanted[i] = i % 128 < 64 ? 40 : 200;
    assert_ok(pave_image_create(*state, &shape, wanted, &guide));
    params.extent[0] = params.extent[1] = 128;
    params.guide_weight = 2;
    params.rounds = 40;
    assert_ok(pave_tiling_create(*state, images, 2, guide, &params, &tiling));
    int32_t dark[2] = { 0, 0 }, used[2] = { 0, 0 };
    for (int32_t i = 0; i < 128 * 128; i++) {
        int32_t exemplar = pave_tiling_sources(tiling)[i].exemplar;
        used[exemplar]++;
        dark[i % 128 < 64] += exemplar == 0;
    }
    assert_true(used[0] > 1000 && used[1] > 1000);
    assert_true(dark[1] > 3 * dark[0]);
    pave_tiling_free(&tiling);
    shape.width = 127;
    pave_image_free(&guide);
    assert_ok(pave_image_create(*state, &shape, NULL, &guide));
    assert_int_equal(pave_tiling_create(*state, images, 2, guide, &params, &tiling), PAVE_ERR_ARGUMENT);
    pave_image_free(&guide);
    pave_image_free(&a);
    pave_image_free(&b);
}

static void assert_refused(pave_context *context, const pave_image *image, const pave_tiling_params *params,
                           pave_result wanted, const char *words)
{
    const pave_image *const images[1] = { image };
    pave_tiling *tiling = (pave_tiling *)(uintptr_t)1;
    assert_int_equal(pave_tiling_create(context, images, 1, NULL, params, &tiling), wanted);
    assert_null(tiling);
    assert_non_null(strstr(pave_context_message(context), words));
}

static void bad_input_is_refused(void **state)
{
    pave_image *image = make_stones(*state, 30, 30, 3, PAVE_U8, 1);
    pave_tiling_params plain = PAVE_TILING_PARAMS_INIT, p = plain;
    p.fraction = 31;
    assert_refused(*state, image, &p, PAVE_ERR_ARGUMENT, "no room for a fraction of 31 x 31");
    p.fraction = 8;
    p.overlap = 8;
    assert_refused(*state, image, &p, PAVE_ERR_ARGUMENT, "leaves nothing");
    p = plain;
    p.extent[0] = p.extent[1] = 1 << 20;
    assert_refused(*state, image, &p, PAVE_ERR_LIMIT, "beyond the limit");
    p = plain;
    p.wang = 2;
    p.extent[0] = 121;
    assert_refused(*state, image, &p, PAVE_ERR_ARGUMENT, "multiples of 4");
    p = plain;
    p.keep = 1;
    p.mode = PAVE_TILING_FAST;
    assert_refused(*state, image, &p, PAVE_ERR_ARGUMENT, "keep needs mode best");
    p = plain;
    p.joints = NAN;
    assert_refused(*state, image, &p, PAVE_ERR_ARGUMENT, "joints");
    const pave_image *const none[1] = { NULL };
    pave_tiling *tiling = NULL;
    assert_int_equal(pave_tiling_create(*state, none, 1, NULL, NULL, &tiling), PAVE_ERR_ARGUMENT);
    assert_int_equal(pave_tiling_create(*state, NULL, 1, NULL, NULL, &tiling), PAVE_ERR_ARGUMENT);
    pave_image_free(&image);
}

/* The smallest images, thin ones, and those of one colour: the obvious result. */
static void small_and_plain_images_work(void **state)
{
    not_for_threads();
    static const int32_t sizes[][2] = { { 1, 1 }, { 2, 2 }, { 1, 9 }, { 7, 5 }, { 3, 60 }, { 16, 16 } };
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
        for (int32_t mode = 0; mode < 2; mode++)
            for (int32_t periodic = 0; periodic < 4; periodic++) {
                pave_image *image = make_stones(*state, sizes[k][0], sizes[k][1], 1, PAVE_U8, 3);
                pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
                params.mode = mode;
                params.periodic = periodic;
                params.rounds = 3;
                params.extent[0] = k % 2 ? 1 : 37;
                params.extent[1] = 41;
                pave_tiling *tiling = tile(*state, image, &params);
                pave_tiling_free(&tiling);
                pave_image_free(&image);
            }
    pave_image *image = make_stones(*state, 40, 40, 3, PAVE_U8, 3);
    memset(image->pixels, 9, 40 * 40 * 3);
    pave_tiling *tiling = tile(*state, image, NULL);
    pave_image *laid = apply(*state, tiling, image);
    for (int32_t i = 0; i < 80 * 80 * 3; i++)
        assert_int_equal(((uint8_t *)laid->pixels)[i], 9);
    pave_image_free(&laid);
    pave_tiling_free(&tiling);
    pave_image_free(&image);
}

static int32_t stop_at_half(void *user, const char *stage, double done)
{
    double *last = user;
    (void)stage;
    assert_true(done >= *last);
    *last = done;
    return done > 0.5;
}

static void progress_and_cancelling(void **state)
{
    (void)state;
    for (int32_t mode = 0; mode < 3; mode++) {
        pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
        pave_tiling_params how = PAVE_TILING_PARAMS_INIT;
        pave_context *context = NULL;
        double last = 0;
        params.progress = stop_at_half;
        params.progress_user = &last;
        params.threads = 2;
        assert_ok(pave_context_create(&params, &context));
        pave_image *image = make_stones(context, 64, 64, 3, PAVE_U8, 1);
        how.mode = mode;
        assert_refused(context, image, &how, PAVE_ERR_CANCELLED, "cancelled");
        assert_true(last > 0.5 && last < 0.9);
        pave_image_free(&image);
        pave_context_free(&context);
    }
}

/* The median of three seeds, for one line across flat stones scatters: how the border's differ from others. */
static void assert_border_closes(pave_context *context, pave_image *image)
{
    const pave_image *const images[1] = { image };
    double x[3], y[3];
    for (int i = 0; i < 3; i++) {
        pave_tiling_measure measure = { .size = sizeof measure };
        pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
        params.seed = (uint64_t)i + 1;
        pave_tiling *tiling = tile(context, image, &params);
        assert_ok(pave_tiling_judge(context, tiling, images, 1, &measure));
        x[i] = measure.seam_x, y[i] = measure.seam_y;
        pave_tiling_free(&tiling);
    }
    assert_true((x[0] < 1.5) + (x[1] < 1.5) + (x[2] < 1.5) >= 2);
    assert_true((y[0] < 1.5) + (y[1] < 1.5) + (y[2] < 1.5) >= 2);
}

/* An exemplar laid side by side is the exemplar everywhere; a tiling of it has fewer seams than blocks have. */
static void measures_tell_what_they_should(void **state)
{
    not_for_threads();
    pave_image *image = make_stones(*state, 96, 96, 3, PAVE_U8, 11);
    const pave_image *const images[1] = { image };
    pave_tiling_measure measure = { .size = sizeof measure }, fast = { .size = sizeof fast };
    pave_tiling_params params = PAVE_TILING_PARAMS_INIT;
    pave_tiling *tiling = tile(*state, image, &params);
    assert_ok(pave_tiling_judge(*state, tiling, images, 1, &measure));
    assert_true(measure.coherence < 12);
    assert_border_closes(*state, image);
    assert_true(measure.entropy > 0.9 && measure.overuse < 4 && measure.histogram < 6);
    assert_true(fabs(measure.sharpness - 1) < 0.15 && measure.feature > 4 && measure.feature < 40);
    pave_tiling_free(&tiling);
    params.mode = PAVE_TILING_FAST;
    tiling = tile(*state, image, &params);
    assert_ok(pave_tiling_judge(*state, tiling, images, 1, &fast));
    assert_true(measure.seam_energy < 0.6 * fast.seam_energy);
    assert_true(measure.sliced > 0 && measure.sliced < 6 && measure.seam_inner > 0.3 && measure.seam_inner < 2);
    fast.size = 8;
    assert_int_equal(pave_tiling_judge(*state, tiling, images, 1, &fast), PAVE_ERR_ARGUMENT);
    pave_tiling_free(&tiling);
    pave_image_free(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table_1_comes_out),
        cmocka_unit_test(all_searches_find_the_same),
        cmocka_unit_test(a_device_finds_the_same),
        cmocka_unit_test(a_device_that_fails),
        cmocka_unit_test(modes_do_not_depend_on_the_search),
        cmocka_unit_test(cuts_are_least_and_smallest),
        cmocka_unit_test(paper_mode_is_the_text),
        cmocka_unit_test(smaller_fractions_show_fewer_seams),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(companions_are_laid_alike),
        cmocka_unit_test(normals_are_turned_with_their_copies),
        cmocka_unit_test(borders_close_where_asked),
        cmocka_unit_test(keep_changes_only_the_band),
        cmocka_unit_test(wang_sets_are_complete_and_fit),
        cmocka_unit_test(unusable_pixels_are_not_used),
        cmocka_unit_test(values_far_out_do_not_rule),
        cmocka_unit_test(a_guide_may_have_gaps),
        cmocka_unit_test(maps_may_have_gaps),
        cmocka_unit_test(several_exemplars_and_a_guide),
        cmocka_unit_test(bad_input_is_refused),
        cmocka_unit_test(small_and_plain_images_work),
        cmocka_unit_test(progress_and_cancelling),
        cmocka_unit_test(measures_tell_what_they_should),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
