/* All CPU kernels, on any number of threads, give the same labels, sites and reports. */
#include "test.h"

#include "backend/cpu.h"
#include "cvd/cvd.h"
#include "util/random.h"

enum { STEPS = 3, AFFORDABLE = SANITIZED ? 500000 : 8000000 /* metrics for the reference */ };

typedef struct outcome {
    int32_t *labels;
    pave_site *sites;
    pv_step step[STEPS];
} outcome;

static uint32_t drawn;

/* 0 .. range-1, the same in every run. */
static int32_t draw(int32_t range)
{
    return (int32_t)pv_below(pv_draw(7, 99, drawn++, 0, 0).word[0], (uint32_t)range);
}

static double pick(const double *from, int count)
{
    return from[draw(count)];
}

static outcome run(const pv_backend *backend, const pv_plane *plane, int32_t threads)
{
    pave_context *context = make_context(threads, PAVE_BACKEND_CPU);
    outcome o = { .step = { { .deep = 0 } }, .labels = malloc(sizeof *o.labels * (size_t)plane->width * (size_t)plane->height),
                  .sites = malloc(sizeof *o.sites * (size_t)plane->sites) };
    void *engine;
    char name[128];
    assert_int_equal(backend->open(context, plane, &engine, name), PAVE_OK);
    for (int32_t i = 0; i < STEPS; i++)
        assert_int_equal(backend->step(context, engine, i, 0, 1, &o.step[i]), PAVE_OK);
    assert_int_equal(backend->labels(context, engine, 0, 1, o.labels), PAVE_OK);
    assert_int_equal(backend->sites(context, engine, o.sites), PAVE_OK);
    backend->close(engine);
    pave_context_free(&context);
    return o;
}

static void release(outcome *o)
{
    free(o->labels);
    free(o->sites);
}

static void assert_same(const outcome *a, const outcome *b, const pv_plane *plane)
{
    for (int32_t i = 0; i < STEPS; i++) { /* radius is a bound, not the same for all */
        assert_int_equal(a->step[i].empty, b->step[i].empty);
        assert_int_equal(a->step[i].moved, b->step[i].moved);
        assert_int_equal(a->step[i].way, b->step[i].way);
    }
    assert_memory_equal(a->sites, b->sites, sizeof *a->sites * (size_t)plane->sites);
    assert_memory_equal(a->labels, b->labels, sizeof *a->labels * (size_t)plane->width * (size_t)plane->height);
}

static void compare(const pv_plane *plane)
{
    static const int32_t threads[] = { 1, 2, 7 };
    outcome first = run(&pv_cpu_portable_backend, plane, 1);
    for (int i = 0; i < 3; i++) {
        outcome other = run(&pv_cpu_backend, plane, threads[i]);
        assert_same(&first, &other, plane);
        release(&other);
    }
    if ((int64_t)plane->width * plane->height * plane->sites < AFFORDABLE) {
        outcome other = run(&pv_cpu_reference_backend, plane, 2);
        assert_same(&first, &other, plane);
        release(&other);
    }
    release(&first);
}

static uint16_t *draw_edges(const pv_plane *plane)
{
    uint16_t *edge = malloc(sizeof *edge * (size_t)plane->width * (size_t)plane->height);
    int32_t column = draw(plane->width), row = draw(plane->height);
    for (int32_t y = 0; y < plane->height; y++)
        for (int32_t x = 0; x < plane->width; x++) {
            int32_t a = 256 * abs(x - column) + 128, b = 181 * abs(x - column + y - row) + 128;
            int32_t d = a < b ? a : b;
            edge[y * plane->width + x] = (uint16_t)(d < UINT16_MAX ? d : UINT16_MAX);
        }
    return edge;
}

static pv_plane make_plane(int32_t width, int32_t height, double h)
{
    pv_plane plane = { .width = width, .height = height, .cell = (int32_t)(512 * h),
                       .push_within = (int32_t)(384 * h), .push_to = (int32_t)(256 * h),
                       .noise_wave = (int32_t)(8192 * h), .noise_swing = draw(65536),
                       .noise_key = (uint32_t)draw(1 << 30), .seed = (uint64_t)draw(1 << 30) };
    plane.excess = draw(2) ? draw(124519) - 58982 : 0;
    plane.edge = draw(3) ? draw_edges(&plane) : NULL;
    return plane;
}

/* A plane as pave_cvd_create makes it. */
static void compare_drawn(int32_t width, int32_t height, double h, double cap, double low, double high)
{
    pave_context *context = make_context(1, PAVE_BACKEND_CPU);
    pave_cvd_params params = PAVE_CVD_PARAMS_INIT;
    pv_plane plane = make_plane(width, height, h);
    pv_place place = { 0, 0, width, height };
    pv_seeds seeds;
    params.half_side = h;
    params.cap = cap;
    params.scale_min = low;
    params.scale_max = high;
    params.seed = plane.seed;
    assert_int_equal(pv_seeds_draw(context, &params, &plane, &place, &seeds), PAVE_OK);
    plane.start = seeds.sites;
    plane.home = seeds.homes;
    plane.sites = seeds.count;
    compare(&plane);
    pv_seeds_free(&seeds);
    free((void *)(uintptr_t)plane.edge);
    pave_context_free(&context);
}

static int32_t rounds(int32_t most)
{
    const char *more = getenv("PAVE_TEST_ROUNDS");
    return more ? atoi(more) : THREAD_SANITIZED ? most / 8 : SANITIZED ? most / 3 : most;
}

static void test_random_planes(void **state)
{
    (void)state;
    static const double sides[] = { 1, 1.5, 2.5, 4, 7.3, 16, 40, 64, 300 }, caps[] = { 0, 0.1, 0.5, 1 };
    static const double lows[] = { 0.1, 0.5, 1 }, highs[] = { 1, 2, 10 };
    for (int32_t i = 0, n = rounds(60); i < n; i++) {
        int32_t side = draw(4) ? 90 : 300;
        compare_drawn(1 + draw(side), 1 + draw(side), pick(sides, 9), pick(caps, 4), pick(lows, 3), pick(highs, 3));
    }
}

static void test_thin_planes(void **state)
{
    (void)state;
    for (int32_t length = 1; length <= 300; length += THREAD_SANITIZED ? 92 : 23) {
        compare_drawn(length, 1, 2.5, 0.5, 0.5, 2);
        compare_drawn(1, length, 1, 0.5, 0.5, 2);
        compare_drawn(8, length, 4, 0.5, 0.5, 2);
    }
}

typedef enum spread { SPOT, SPOTS, COPIES, CORNERS, ANYWHERE, SPREADS } spread;

static void place_site(const pv_plane *plane, spread how, pave_site *site)
{
    int32_t w = 256 * plane->width, h = 256 * plane->height;
    site->x = how == SPOT ? w / 2 : how == CORNERS ? draw(2) * (w - 1) : draw(w);
    site->y = how == SPOT ? h / 3 : how == CORNERS ? draw(2) * (h - 1) : draw(h);
    if (how == SPOTS) {
        site->x = draw(3) * (w / 3) + draw(256 < w / 3 ? 256 : 1);
        site->y = draw(3) * (h / 3) + draw(256 < h / 3 ? 256 : 1);
    }
}

/* Compares what starts at `count` places, and frees it all but for what else the plane points at. */
static void compare_sites(pv_plane *plane, pave_site *start, int32_t count)
{
    pv_home *home = calloc((size_t)count, sizeof *home);
    for (int32_t i = 0; i < count; i++) {
        home[i] = (pv_home){ start[i].x / plane->cell, start[i].y / plane->cell, i % 64, 0 };
        pv_site_turn(plane, &start[i]);
    }
    plane->start = start;
    plane->home = home;
    plane->sites = count;
    compare(plane);
    free(start);
    free(home);
    free((void *)(uintptr_t)plane->edge);
}

/* Sites that no drawing would get. */
static void compare_odd(spread how, int32_t count, double h, int32_t greatest)
{
    pv_plane plane = make_plane(1 + draw(200), 1 + draw(200), h);
    pave_site *start = calloc((size_t)count, sizeof *start);
    for (int32_t i = 0; i < count; i++) {
        place_site(&plane, how, &start[i]);
        start[i].half_x = draw(greatest + 1);
        start[i].half_y = draw(greatest + 1);
        if (how == COPIES && i)
            start[i] = start[draw(i)];
    }
    compare_sites(&plane, start, count);
}

/* As a mosaic has them: pyramids, oriented by a field, with pixels that count for nobody. */
static void compare_pyramids(spread how, int32_t count, double h, double sizes, double aspect)
{
    int32_t metric = 1 + draw(2), width = 1 + draw(200), height = 1 + draw(200), across = (width + 7) / 8;
    pv_plane plane = make_plane(width, height, h);
    pave_site *start = calloc((size_t)count, sizeof *start);
    uint16_t *direction = malloc(sizeof *direction * (size_t)width * (size_t)height);
    uint64_t *mask = calloc((size_t)across * (size_t)((height + 7) / 8), sizeof *mask);
    for (int32_t i = 0; i < width * height; i++)
        direction[i] = (uint16_t)draw(65536);
    for (int32_t i = draw(width * height); i > 0; i--)
        mask[draw((height + 7) / 8) * across + draw(across)] |= (uint64_t)1 << draw(64);
    plane.metric = metric;
    plane.direction = direction;
    plane.mask = draw(2) ? mask : NULL;
    for (int32_t i = 0; i < count; i++) {
        double slope = pv_steepest(metric) / (1 + (sizes - 1) * draw(1000) / 1000);
        place_site(&plane, how, &start[i]);
        start[i].half_x = slope > 1 ? (int32_t)slope : 1;
        start[i].half_y = (int32_t)(slope / aspect) > 0 ? (int32_t)(slope / aspect) : 1;
    }
    compare_sites(&plane, start, count);
    free(direction);
    free(mask);
}

static void test_pyramids(void **state)
{
    (void)state;
    static const double sides[] = { 1, 4, 16, 50 }, sizes[] = { 1, 1.5, 3, 20, 70000 }, aspects[] = { 1, 2, 30 };
    static const int32_t counts[] = { 1, 2, 33, 120, 257, 700 };
    for (int32_t i = 0, n = rounds(30); i < n; i++)
        compare_pyramids(draw(2) ? ANYWHERE : (spread)draw(SPREADS), counts[draw(6)], pick(sides, 4),
                         pick(sizes, draw(4) ? 3 : 5), pick(aspects, 3));
}

static void test_odd_planes(void **state)
{
    (void)state;
    static const double sides[] = { 1, 4, 16, 50 };
    static const int32_t counts[] = { 1, 2, 9, 33, 60, 256, 257, 700 }, extents[] = { 0, 500, 9000, 40000, 3000000 };
    for (int32_t count = 254; count < 260; count += THREAD_SANITIZED ? 3 : 1) /* the most that the fast path takes in one bucket */
        compare_odd(SPOT, count, 16, 500);
    for (int32_t i = 0, n = rounds(40); i < n; i++)
        compare_odd((spread)draw(SPREADS), counts[draw(8)], pick(sides, 4), extents[draw(5)]);
}

static void test_roots(void **state)
{
    (void)state;
    not_for_threads();
    static const uint64_t ends[] = { 0, 1, 2, 3, UINT64_MAX, UINT64_MAX - 1, 0xfffffffe00000001u, 0xfffffffe00000000u };
    for (int i = 0; i < 8; i++) {
        uint64_t root = pv_isqrt(ends[i]);
        assert_true(root * root <= ends[i] && ends[i] - root * root <= 2 * root);
    }
    for (int32_t i = 0; i < 300000; i++) {
        pv_random r = pv_draw(3, 98, (uint32_t)i, 0, 0);
        uint64_t any = ((uint64_t)r.word[0] << 32 | r.word[1]) >> r.word[2] % 64, root = pv_isqrt(any);
        uint64_t exact = (uint64_t)r.word[3] * r.word[3];
        assert_true(root * root <= any && any - root * root <= 2 * root);
        assert_int_equal(pv_isqrt(exact), r.word[3]);
        assert_int_equal(pv_isqrt(exact - 1), r.word[3] - 1);
    }
}

static void test_noise_cell_is_only_a_memory(void **state)
{
    (void)state;
    pv_noise_cell kept = { .known = 0 };
    pv_lattice waves = pv_lattice_of(8192, 0);
    for (int32_t i = 0; i < 20000; i++) {
        int32_t x = draw(1 << 14), y = draw(1 << 14);
        pv_noise_cell fresh = { .known = 0 };
        assert_int_equal(pv_noise(&kept, 5, &waves, &waves, x, y), pv_noise(&fresh, 5, &waves, &waves, x, y));
    }
}

#ifdef PV_AVX2
/* Four at a time turn as one alone does, in a cell and beyond its border. */
static void test_turns_together(void **state)
{
    (void)state;
    int turned = 0;
    if (!__builtin_cpu_supports("avx2"))
        skip();
    for (int32_t i = 0; i < 20000; i++) {
        pv_plane plane = { .noise_wave = 1 + draw(1 << draw(24)), .noise_swing = draw(65537), .noise_key = 7,
                           .origin_x = draw(1 << 20) - (1 << 19), .origin_y = draw(1 << 20) - (1 << 19) };
        pv_noise_cell kept = { .known = 0 };
        pave_site together[4] = { { .x = draw(1 << 20), .y = draw(1 << 20) } }, *four[4];
        for (int32_t k = 0; k < 4; k++) {
            together[k].x = together[0].x + (k ? draw(plane.noise_wave / 4 + 1) : 0);
            together[k].y = together[0].y + (k ? draw(plane.noise_wave / 4 + 1) : 0);
            four[k] = &together[k];
        }
        pv_site_turn_by_noise(&plane, &kept, four[0]);
        if (!pv_sites_turn_avx2(&plane, &kept, four))
            continue;
        turned++;
        for (int32_t k = 0; k < 4; k++) {
            pave_site alone = { .x = together[k].x, .y = together[k].y };
            pv_site_turn(&plane, &alone);
            assert_memory_equal(&alone, &together[k], sizeof alone);
        }
    }
    assert_true(turned > 4000);
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_planes),
        cmocka_unit_test(test_thin_planes),
        cmocka_unit_test(test_odd_planes),
        cmocka_unit_test(test_pyramids),
        cmocka_unit_test(test_roots),
        cmocka_unit_test(test_noise_cell_is_only_a_memory),
#ifdef PV_AVX2
        cmocka_unit_test(test_turns_together),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
