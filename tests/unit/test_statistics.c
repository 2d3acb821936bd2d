/* btf's statistics of textures: the pyramid they are measured in, each step that imposes some, and all together. */
#include "test.h"

#include "btf/periodic.h"
#include "btf/texture.h"
#include "util/random.h"

#include <math.h>
#include <string.h>

/* 0..1, sharp blobs with dark joints between: something with edges, phases and a skewed histogram. */
static void draw_cells(float *plane, int32_t width, int32_t height)
{
    enum { SITES = 24 };
    for (int32_t y = 0; y < height; y++)
        for (int32_t x = 0; x < width; x++) {
            double first = 4, second = 4, tone = 0;
            for (int32_t i = 0; i < SITES; i++) {
                pv_random r = pv_draw(3, 90, (uint32_t)i, 0, 0);
                double u = fabs((x + 0.5) / width - r.word[0] * 0x1p-32), v = fabs((y + 0.5) / height - r.word[1] * 0x1p-32);
                u = fmin(u, 1 - u), v = fmin(v, 1 - v);
                double d = u * u + v * v;
                second = fmin(second, fmax(d, first));
                tone = d < first ? r.word[2] * 0x1p-32 : tone;
                first = fmin(first, d);
            }
            pv_random grain = pv_draw(3, 91, (uint32_t)x, (uint32_t)y, 0);
            double joint = fmin(1, (sqrt(second) - sqrt(first)) * 12);
            plane[(int64_t)y * width + x] = (float)(joint * (0.5 + 0.3 * tone + 0.1 * grain.word[0] * 0x1p-32));
        }
}

static void draw_noise(float *plane, size_t count, uint64_t seed, float mean, float deviation)
{
    for (size_t i = 0; i < count; i++) {
        pv_random r = pv_draw(seed, 92, (uint32_t)i, 0, 0);
        double sum = -2;
        for (int k = 0; k < 4; k++)
            sum += r.word[k] * 0x1p-32;
        plane[i] = mean + deviation * (float)(sum * 1.7320508);
    }
}

/* Whatever the size, the scales and the orientations: there and back, and as much energy in the parts as in the whole. */
static void pyramids_are_inverted(void **state)
{
    static const int32_t cases[][4] = { { 64, 64, 4, 4 }, { 96, 64, 3, 4 }, { 80, 112, 4, 6 }, { 40, 24, 3, 3 },
                                        { 256, 128, 5, 4 }, { 16, 16, 1, 2 } };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        int32_t width = cases[c][0], height = cases[c][1];
        size_t n = (size_t)width * (size_t)height;
        pv_steerable s;
        pv_pyramid p;
        float *plane = malloc(n * sizeof *plane), *back = malloc(n * sizeof *back);
        draw_noise(plane, n, c, 1, 2);
        assert_ok(pv_steerable_create(*state, width, height, cases[c][2], cases[c][3], &s));
        assert_ok(pv_pyramid_create(*state, &s, &p));
        assert_ok(pv_steerable_analyse(*state, &s, plane, &p));
        double energy = 0, parts = 0, error = 0;
        for (size_t i = 0; i < n; i++)
            parts += p.high[i].r * p.high[i].r / (double)n;
        for (int32_t l = 0; l <= s.scales; l++)
            for (int32_t k = 0; k < (l < s.scales ? s.orientations : 1); k++)
                for (size_t i = 0; i < pv_level_size(&s, l); i++) {
                    pv_complex *z = l < s.scales ? &p.band[l][k][i] : &p.low[l][i];
                    z->i = 0;
                    parts += z->r * z->r / (double)pv_level_size(&s, l);
                }
        assert_ok(pv_steerable_collect(*state, &s, &p, 0, back));
        for (size_t i = 0; i < n; i++) {
            energy += plane[i] * plane[i] / (double)n;
            error += (plane[i] - back[i]) * (plane[i] - back[i]) / (double)n;
        }
        assert_true(sqrt(error / energy) < 1e-6);
        assert_true(fabs(parts / energy - 1) < 1e-5);
        pv_pyramid_free(&p);
        pv_steerable_free(&s);
        free(plane);
        free(back);
    }
}


/* A texture and its channel taken apart: what the steps work on. */
typedef struct bench {
    pv_statistics *wanted;
    pv_texture texture;
    float *plane;
} bench;

static bench open_bench(pave_context *context, int32_t side, int32_t scales)
{
    bench b;
    pv_statistics_settings settings = { scales, 4, 7, 0 };
    size_t n = (size_t)side * (size_t)side;
    b.plane = malloc(n * sizeof *b.plane);
    draw_cells(b.plane, side, side);
    assert_ok(pv_statistics_measure(context, side, side, 1, b.plane, &settings, &b.wanted));
    assert_ok(pv_texture_create(context, b.wanted, side, side, &b.texture));
    draw_noise(b.plane, n, 5, 0.4f, 0.2f);
    assert_ok(pv_texture_analyse(&b.texture, b.plane));
    return b;
}

static void close_bench(bench *b)
{
    pv_texture_free(&b->texture);
    pv_statistics_free(b->wanted);
    free(b->plane);
}

static void autocorrelations_are_imposed(void **state)
{
    bench b = open_bench(*state, 64, 3);
    for (int32_t s = 0; s < 3; s++) {
        const double *wanted = pv_statistics_at(b.wanted, PV_LOW_CORRELATION, 0, s);
        double error = 0, all = 0;
        int32_t x, y, reach = b.wanted->reach[s];
        for (int i = 0; i < 8; i++)
            assert_ok(pv_impose_autocorrelation(&b.texture, s, reach, wanted, b.texture.low[s]));
        for (int32_t i = 0; i < pv_lags(reach); i++) {
            pv_lag(reach, i, &x, &y);
            double is = pv_mean_product(b.texture.low[s], b.texture.low[s], 64 >> s, 64 >> s, x, y);
            error += (is - wanted[i]) * (is - wanted[i]);
            all += wanted[i] * wanted[i];
        }
        printf("level %d: %g\n", s, sqrt(error / all));
        assert_true(sqrt(error / all) < 1e-2);
    }
    close_bench(&b);
}

static void covariances_are_imposed(void **state)
{
    bench b = open_bench(*state, 64, 3);
    pv_texture *t = &b.texture;
    const double *pairs = pv_statistics_at(b.wanted, PV_ORIENTATIONS, 0, 1);
    const double *own = pv_statistics_at(b.wanted, PV_MAGNITUDE_CORRELATION, 0, 1);
    double among[16], with[16], worst = 0;
    for (int32_t k = 0; k < 4; k++)
        for (int32_t j = 0; j <= k; j++)
            among[4 * k + j] = among[4 * j + k] = j == k ? own[k * 25] : pairs[k * (k - 1) / 2 + j];
    for (int32_t i = 0; i < 16; i++) /* of opposite sign, and small enough to be possible */
        with[i] = -0.1 * pv_mean_product(t->magnitude[1][i / 4], t->parent_magnitude[1][i % 4], 32, 32, 0, 0);
    assert_ok(pv_impose_covariance(*state, 4, t->magnitude[1], 4, t->parent_magnitude[1], 1024, among, with));
    for (int32_t k = 0; k < 4; k++)
        for (int32_t j = 0; j < 4; j++) {
            double is = pv_mean_product(t->magnitude[1][k], t->magnitude[1][j], 32, 32, 0, 0);
            double is_with = pv_mean_product(t->magnitude[1][k], t->parent_magnitude[1][j], 32, 32, 0, 0);
            worst = fmax(worst, fmax(fabs(is - among[4 * k + j]), fabs(is_with - with[4 * k + j])) / among[0]);
        }
    printf("worst %g\n", worst);
    assert_true(worst < 1e-4);
    close_bench(&b);
}

static void moments_are_imposed(void **state)
{
    float plane[4096];
    (void)state;
    for (int i = 0; i < 8; i++) {
        double wanted[2] = { -0.9 + 0.25 * i, 2.2 + 0.3 * i };
        draw_noise(plane, 4096, (uint64_t)i, 3, 0.5f);
        for (int k = 0; k < 20; k++) {
            pv_move_moment(plane, 4096, 3, wanted[0]);
            pv_move_moment(plane, 4096, 4, wanted[1]);
        }
        pv_moments m = pv_moments_of(plane, 4096);
        assert_true(fabs(m.skewness - wanted[0]) < 1e-2 && fabs(m.kurtosis - wanted[1]) < 1e-3);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pyramids_are_inverted),
        cmocka_unit_test(autocorrelations_are_imposed),
        cmocka_unit_test(covariances_are_imposed),
        cmocka_unit_test(moments_are_imposed),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
