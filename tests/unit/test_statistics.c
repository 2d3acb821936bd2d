/* The statistics of textures: the pyramid they are measured in, each step that imposes some, and all together. */
#include "test.h"

#include "failing.h"

#include "statistics/periodic.h"
#include "statistics/texture.h"
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
        assert_ok(pv_steerable_analyse(*state, &s, plane, 0, &p));
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
        assert_true(sqrt(error / all) < 1e-3);
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


/* What is said of changes is what differences are; and the gradient is what belongs to them. */
static void changes_and_gradients_fit(void **state)
{
    enum { SIDE = 64, N = SIDE * SIDE };
    static const float step = 1e-3f;
    bench b = open_bench(*state, SIDE, 3);
    pv_texture change;
    pv_statistics *before, *after, *told;
    float *direction = malloc(3 * N * sizeof *direction), *moved = direction + N, *slope = direction + 2 * N;
    assert_ok(pv_texture_create(*state, b.wanted, SIDE, SIDE, &change));
    assert_ok(pv_statistics_create_like(*state, b.wanted, &before));
    assert_ok(pv_statistics_create_like(*state, b.wanted, &after));
    assert_ok(pv_statistics_create_like(*state, b.wanted, &told));
    draw_cells(b.plane, SIDE, SIDE);
    draw_noise(direction, N, 8, 0, 0.3f);
    assert_ok(pv_texture_analyse(&b.texture, b.plane));
    assert_ok(pv_texture_differentiate(&b.texture, direction, &change));
    assert_ok(pv_texture_gather_change(&b.texture, &change, b.plane, direction, 0, told));
    double weighted = 0;
    for (int32_t i = 0; i < told->count; i++) {
        before->values[i] = cos(i); /* any weights */
        weighted += before->values[i] * told->values[i];
    }
    assert_ok(pv_texture_gradient(&b.texture, b.plane, 0, before->values, &change, slope));
    assert_true(fabs(pv_mean_product(slope, direction, SIDE, SIDE, 0, 0) / weighted - 1) < 1e-3);
    for (int sign = -1; sign < 2; sign += 2) {
        for (int i = 0; i < N; i++)
            moved[i] = b.plane[i] + (float)sign * step * direction[i];
        assert_ok(pv_texture_analyse(&b.texture, moved));
        assert_ok(pv_texture_gather(&b.texture, moved, 0, sign < 0 ? before : after));
    }
    for (int32_t i = 0; i < told->stretch_count; i++) {
        const pv_stretch *t = &told->stretches[i];
        double error = 0, all = 0;
        for (int32_t k = t->first; k < t->first + t->count; k++) {
            double is = (after->values[k] - before->values[k]) / (2 * step);
            int smooth = t->group != PV_PIXELS || k == t->first + 1;
            error += smooth ? (is - told->values[k]) * (is - told->values[k]) : 0;
            all += is * is;
        }
        assert_true(sqrt(error) < 0.05 * sqrt(all));
    }
    pv_statistics_free(before);
    pv_statistics_free(after);
    pv_statistics_free(told);
    pv_texture_free(&change);
    free(direction);
    close_bench(&b);
}

/* Four copies are the same texture, and a ramp across it is none of its statistics, for it jumps at the border. */
static void statistics_do_not_depend_on_size_or_border(void **state)
{
    enum { SIDE = 64 };
    static const pv_statistics_settings settings = { 3, 4, 7, 0 };
    float *one = malloc(SIDE * SIDE * sizeof *one), *four = malloc(4 * SIDE * SIDE * sizeof *four);
    pv_statistics *of_one, *of_four, *of_part, *of_ramp;
    draw_cells(one, SIDE, SIDE);
    for (int i = 0; i < 4 * SIDE * SIDE; i++)
        four[i] = one[i / (2 * SIDE) % SIDE * SIDE + i % SIDE];
    assert_ok(pv_statistics_measure(*state, SIDE, SIDE, 1, one, &settings, &of_one));
    assert_ok(pv_statistics_measure(*state, 2 * SIDE, 2 * SIDE, 1, four, &settings, &of_four));
    assert_true(pv_statistics_distance(of_one, of_four) < 5e-3);
    assert_ok(pv_statistics_measure(*state, 2 * SIDE, 2 * SIDE - 5, 1, four, &settings, &of_part));
    assert_true(pv_statistics_group(of_one, of_part, PV_MAGNITUDE) < 0.1); /* five rows less leave a seam */
    pv_statistics *small, *large; /* whose lags go one and three pixels far at the coarsest level */
    static const pv_statistics_settings deep = { 4, 4, 7, 0 };
    assert_ok(pv_statistics_measure(*state, SIDE, SIDE, 1, one, &deep, &small));
    assert_ok(pv_statistics_measure(*state, 2 * SIDE, 2 * SIDE, 1, four, &deep, &large));
    assert_true(small->reach[4] == 1 && large->reach[4] == 3);
    assert_true(pv_statistics_distance(small, large) < 0.01 && pv_statistics_distance(large, small) < 0.01);
    pv_statistics_free(small);
    pv_statistics_free(large);
    for (int i = 0; i < SIDE * SIDE; i++)
        one[i] += (float)(i % SIDE - SIDE / 2) / SIDE;
    assert_ok(pv_statistics_measure(*state, SIDE, SIDE, 1, one, &settings, &of_ramp));
    assert_true(pv_statistics_group(of_one, of_ramp, PV_MAGNITUDE) < 0.05);
    assert_true(pv_statistics_group(of_one, of_ramp, PV_HIGH) < 0.05);
    pv_statistics_free(of_one);
    pv_statistics_free(of_four);
    pv_statistics_free(of_part);
    pv_statistics_free(of_ramp);
    free(one);
    free(four);
}

/* A ramp is all smooth; what repeats is left as it is. */
static void only_what_jumps_is_taken_out(void **state)
{
    enum { W = 48, H = 40 };
    float plane[W * H], smooth[W * H];
    draw_noise(plane, W * H, 2, 0, 0.1f);
    for (int i = 0; i < W * H; i++)
        plane[i] += (float)(cos(6.2831853 * (i % W) / W) + sin(6.2831853 * 2 * (i / W) / H));
    assert_ok(pv_smooth_part(*state, plane, W, H, smooth));
    double taken = 0, ramp = 0;
    for (int i = 0; i < W * H; i++)
        taken = fmax(taken, fabs(smooth[i]));
    assert_true(taken == 0);
    for (int i = 0; i < W * H; i++)
        plane[i] = (float)(i % W) / W;
    assert_ok(pv_smooth_part(*state, plane, W, H, smooth));
    for (int i = 0; i < W * H; i++)
        ramp = fmax(ramp, fabs(plane[i] - smooth[i] - 0.5));
    assert_true(ramp < 0.05);
}

static pave_image *take_plane(pave_context *context, int32_t width, int32_t height, int32_t channels,
                              const float *values)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    params.width = width, params.height = height, params.channels = channels;
    params.type = PAVE_F32, params.encoding = PAVE_DATA;
    params.names = channels == 1 ? "Y" : "R,G,B";
    assert_ok(pave_image_create(context, &params, values, &image));
    return image;
}

static pave_image *cells(pave_context *context, int32_t side)
{
    float *plane = malloc((size_t)side * (size_t)side * sizeof *plane);
    draw_cells(plane, side, side);
    pave_image *image = take_plane(context, side, side, 1, plane);
    free(plane);
    return image;
}

/* Fibres on a slant: noise drawn out along its rows, so that some stand out, with dark knots. */
static pave_image *fibres(pave_context *context, int32_t side)
{
    float *plane = malloc((size_t)side * (size_t)side * sizeof *plane);
    for (int32_t y = 0; y < side; y++)
        for (int32_t x = 0; x < side; x++) {
            int32_t row = (y + x) % side;
            double sum = 0;
            for (int32_t k = 0; k < 12; k++)
                sum += pv_draw(1, 93, (uint32_t)((x + k) % side), (uint32_t)row, 0).word[0] * 0x1p-32 / 12;
            pv_random knot = pv_draw(1, 94, (uint32_t)(x / 4), (uint32_t)(row / 4), 0);
            double light = 0.5 + 1.5 * (sum - 0.5);
            plane[y * side + x] = (float)(knot.word[0] < 0x08000000u ? 0.3 * light : light + 4 * pow(sum - 0.5, 2));
        }
    pave_image *image = take_plane(context, side, side, 1, plane);
    free(plane);
    return image;
}

static void below(const pave_statistics_report *r, double most)
{
    const double groups[] = { r->pixels, r->shape, r->low_shape, r->low_correlation, r->high, r->magnitude,
                              r->magnitude_correlation, r->orientations, r->scales, r->phase };
    double worst = 0;
    for (size_t i = 0; i < sizeof groups / sizeof *groups; i++) {
        assert_true(groups[i] < most);
        worst = fmax(worst, groups[i]);
    }
    assert_true(worst > 0 && r->distance >= worst);
}

/* From noise, in 50 rounds, every group of statistics to within a per cent: as it is told, and as the picture that
 * comes out is measured. */
static void converges(pave_context *context, const pave_image *texture, int32_t scales, int32_t side)
{
    pave_statistics_params params = PAVE_STATISTICS_PARAMS_INIT;
    pave_statistics_synthesis_params synthesis = PAVE_STATISTICS_SYNTHESIS_PARAMS_INIT;
    pave_statistics_report told = { .size = sizeof told }, is = { .size = sizeof is };
    pave_statistics *wanted = NULL;
    pave_image *made = NULL;
    params.scales = scales;
    synthesis.extent[0] = synthesis.extent[1] = side;
    synthesis.iterations = SANITIZED ? 12 : 50;
    assert_ok(pave_statistics_create(context, texture, &params, &wanted));
    assert_ok(pave_statistics_synthesize(context, wanted, &synthesis, &told, &made));
    assert_int_equal(pave_image_width(made), side);
    assert_ok(pave_statistics_compare(context, wanted, made, &is));
    if (!SANITIZED) {
        below(&told, 0.01);
        below(&is, 0.01);
    }
    pave_image_free(&made);
    pave_statistics_free(&wanted);
}

static void textures_converge(void **state)
{
    int32_t side = THREAD_SANITIZED ? 32 : 128, scales = THREAD_SANITIZED ? 2 : 3;
    pave_image *textures[2] = { cells(*state, side), fibres(*state, side) };
    for (int i = 0; i < 2; i++) {
        converges(*state, textures[i], scales, side);
        pave_image_free(&textures[i]);
    }
}

/* The upper left corner of a photograph, its first channel. */
static pave_image *corner(pave_context *context, const char *path, int32_t side)
{
    pave_image *image = NULL;
    pave_result result = pave_image_read(context, path, &image);
    if (result == PAVE_ERR_UNSUPPORTED)
        return NULL;
    assert_ok(result);
    const uint8_t *pixels = pave_image_pixels(image);
    float *plane = malloc((size_t)side * (size_t)side * sizeof *plane);
    assert_int_equal(pave_image_type(image), PAVE_U8);
    for (int32_t i = 0; i < side * side; i++)
        plane[i] = pixels[((int64_t)(i / side) * pave_image_width(image) + i % side) * pave_image_channels(image)] / 255.f;
    pave_image_free(&image);
    image = take_plane(context, side, side, 1, plane);
    free(plane);
    return image;
}

static void photographs_converge(void **state)
{
    static const char *const names[] = { "gravel-grey.png", "bark-grey.png", "pebbles-colour.jpg" };
    const char *shared = getenv("PAVE_SHARED");
    char path[4096];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(path, sizeof path, "%s/data/textures/%s", shared ? shared : "", names[i]);
        FILE *file = shared && !SANITIZED ? fopen(path, "rb") : NULL;
        if (!file) {
            print_message("skipped: PAVE_SHARED does not name a folder with data/textures\n");
            skip();
        }
        fclose(file);
        pave_image *texture = corner(*state, path, 128);
        if (!texture)
            skip(); /* no reader for it was built */
        converges(*state, texture, 3, 128);
        pave_image_free(&texture);
    }
}

/* Colours that belong together do so in the result, of another size and one that does not divide. */
static void colours_go_together(void **state)
{
    enum { SIDE = 64, WIDTH = 75, HEIGHT = 61 };
    pave_statistics_params params = PAVE_STATISTICS_PARAMS_INIT;
    pave_statistics_synthesis_params synthesis = PAVE_STATISTICS_SYNTHESIS_PARAMS_INIT;
    pave_statistics_report told = { .size = sizeof told };
    pave_statistics *wanted = NULL;
    float *grey = malloc(SIDE * SIDE * sizeof *grey), *rgb = malloc(3 * SIDE * SIDE * sizeof *rgb);
    draw_cells(grey, SIDE, SIDE);
    for (int i = 0; i < SIDE * SIDE; i++) {
        pv_random r = pv_draw(4, 95, (uint32_t)i, 0, 0);
        rgb[3 * i] = grey[i], rgb[3 * i + 1] = 0.7f * grey[i] * grey[i];
        rgb[3 * i + 2] = 0.3f * (float)(r.word[0] * 0x1p-32);
    }
    pave_image *texture = take_plane(*state, SIDE, SIDE, 3, rgb), *made = NULL;
    params.scales = 2;
    synthesis.extent[0] = WIDTH, synthesis.extent[1] = HEIGHT;
    synthesis.iterations = SANITIZED ? 11 : 30;
    assert_ok(pave_statistics_create(*state, texture, &params, &wanted));
    assert_ok(pave_statistics_synthesize(*state, wanted, &synthesis, &told, &made));
    assert_int_equal(pave_image_width(made), WIDTH);
    assert_int_equal(pave_image_height(made), HEIGHT);
    assert_string_equal(pave_image_channel_name(made, 1), "G");
    const float *is = pave_image_pixels(made);
    double error = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        error += fabs(is[3 * i + 1] - 0.7 * is[3 * i] * is[3 * i]) / (WIDTH * HEIGHT);
    if (!SANITIZED) {
        assert_true(told.channels < 0.01 && told.channel_magnitudes < 0.01 && told.distance < 0.03);
        assert_true(error < 0.06); /* of independent channels it is 0.15 */
    }
    pave_image_free(&made);
    pave_image_free(&texture);
    pave_statistics_free(&wanted);
    free(grey);
    free(rgb);
}

/* What enlargement does: planes of any size, which do not repeat, nearer to statistics of others. */
static void planes_are_changed_in_place(void **state)
{
    enum { SIDE = 64, WIDTH = 90, HEIGHT = 70, CHANNELS = 3 };
    static const pv_statistics_settings settings = { 3, 4, 5, 1 };
    float *sample = malloc(CHANNELS * SIDE * SIDE * sizeof *sample);
    float *planes = malloc(CHANNELS * WIDTH * HEIGHT * sizeof *planes), *ramp;
    pv_statistics *wanted, *before, *after;
    draw_cells(sample, SIDE, SIDE);
    draw_noise(sample + SIDE * SIDE, SIDE * SIDE, 3, 0, 7);
    for (int i = 0; i < SIDE * SIDE; i++)
        sample[2 * SIDE * SIDE + i] = 0.01f * sample[i] + 0.0002f * sample[SIDE * SIDE + i];
    draw_noise(planes, CHANNELS * WIDTH * HEIGHT, 6, 0, 1);
    ramp = planes + WIDTH * HEIGHT;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        ramp[i] += 0.05f * (float)(i % WIDTH);
    assert_ok(pv_statistics_measure(*state, SIDE, SIDE, CHANNELS, sample, &settings, &wanted));
    assert_ok(pv_statistics_measure_like(*state, wanted, WIDTH, HEIGHT, planes, &before));
    assert_ok(pv_statistics_impose(*state, wanted, WIDTH, HEIGHT, planes, 6, 0, 1));
    assert_ok(pv_statistics_measure_like(*state, wanted, WIDTH, HEIGHT, planes, &after));
    for (int32_t group = 0; group <= PV_CHANNELS; group++) {
        double was = pv_statistics_group(wanted, before, group), is = pv_statistics_group(wanted, after, group);
        assert_true(group == PV_SHAPE || is < (group == PV_LOW_CORRELATION ? 0.6 : 0.5) * was || is < 0.03);
    }
    assert_true(pv_statistics_distance(wanted, before) > 0.5);
    pv_statistics_free(wanted);
    pv_statistics_free(before);
    pv_statistics_free(after);
    free(sample);
    free(planes);
}

static void threads_do_not_matter(void **state)
{
    static const int32_t threads[] = { 1, 2, 5 };
    pave_statistics_params params = PAVE_STATISTICS_PARAMS_INIT;
    pave_statistics_synthesis_params synthesis = PAVE_STATISTICS_SYNTHESIS_PARAMS_INIT;
    float first[48 * 48];
    (void)state;
    params.scales = 2;
    synthesis.iterations = 11;
    for (int i = 0; i < 3; i++) {
        pave_context *context = make_context(threads[i], PAVE_BACKEND_CPU);
        pave_image *texture = cells(context, 48), *made = NULL;
        pave_statistics *wanted = NULL;
        assert_ok(pave_statistics_create(context, texture, &params, &wanted));
        assert_ok(pave_statistics_synthesize(context, wanted, &synthesis, NULL, &made));
        if (i == 0)
            memcpy(first, pave_image_pixels(made), sizeof first);
        assert_memory_equal(first, pave_image_pixels(made), sizeof first);
        pave_image_free(&made);
        pave_image_free(&texture);
        pave_statistics_free(&wanted);
        pave_context_free(&context);
    }
}

enum { APART = 5, APART_SIDE = 32 };

/* Of noise, the statistics of stripes, `count` channels from one on, each by itself. */
static pave_result impose_stripes(pave_context *context, int32_t first, int32_t count, float *planes)
{
    enum { N = APART_SIDE * APART_SIDE };
    static const pv_statistics_settings settings = { 2, 4, 5, 0 };
    pv_statistics *wanted = NULL;
    float *stripes = malloc(sizeof *stripes * N * (size_t)count);
    for (int32_t i = 0; i < N * count; i++) {
        int32_t x = i % APART_SIDE, y = i / APART_SIDE % APART_SIDE, c = first + i / N;
        stripes[i] = (float)((x * (c + 1) / 2 + y * y / 9) % 7) + 0.01f * (float)(x * y % 5);
    }
    for (int32_t c = 0; c < count; c++)
        draw_noise(planes + c * N, N, (uint64_t)(first + c), 1, 1);
    pave_result result = pv_statistics_measure(context, APART_SIDE, APART_SIDE, count, stripes, &settings, &wanted);
    if (!result)
        result = pv_statistics_impose(context, wanted, APART_SIDE, APART_SIDE, planes, 2, 0, 1);
    pv_statistics_free(wanted);
    free(stripes);
    return result;
}

/* Channels that know of no other: all at once, by any number of threads, is one after the other. */
static void channels_apart_are_done_at_once(void **state)
{
    enum { N = APART_SIDE * APART_SIDE };
    static const int32_t threads[] = { 1, 2, 5 };
    static float alone[APART * N], together[APART * N];
    for (int32_t c = 0; c < APART; c++)
        assert_ok(impose_stripes(*state, c, 1, alone + c * N));
    for (int i = 0; i < 3; i++) {
        pave_context *context = make_context(threads[i], PAVE_BACKEND_CPU);
        assert_ok(impose_stripes(context, 0, APART, together));
        assert_memory_equal(alone, together, sizeof alone);
        pave_context_free(&context);
    }
    failing memory = { .calls = 0 };
    pave_context_params params = failing_params(&memory);
    pave_context *context = NULL;
    assert_ok(pave_context_create(&params, &context));
    memory.calls = 0;
    assert_ok(impose_stripes(context, 0, APART, together));
    int64_t calls = memory.calls, held = memory.blocks;
    for (int64_t at = 1; at <= calls; at += 9) {
        memory.calls = 0;
        memory.fail_at = at;
        assert_int_equal(impose_stripes(context, 0, APART, together), PAVE_ERR_MEMORY);
        assert_non_null(strstr(pave_context_message(context), "out of memory"));
        assert_int_equal(memory.blocks, held);
    }
    pave_context_free(&context);
}

static void refuse(pave_context *context, const pave_image *image, const pave_statistics_params *params,
                   const char *words)
{
    pave_statistics *statistics = (pave_statistics *)(uintptr_t)image;
    assert_int_equal(pave_statistics_create(context, image, params, &statistics), PAVE_ERR_ARGUMENT);
    assert_null(statistics);
    assert_non_null(strstr(pave_context_message(context), words));
}

static void what_cannot_be_is_refused(void **state)
{
    static const int32_t sides[][2] = { { 5, 5 }, { 1, 300 }, { 40, 63 } };
    static const char *const words[] = { "too small for statistics", "too small for statistics", "it allows 3" };
    float values[300 * 300] = { 0 };
    pave_statistics_params params = PAVE_STATISTICS_PARAMS_INIT;
    for (int i = 0; i < 3; i++) {
        pave_image *image = take_plane(*state, sides[i][0], sides[i][1], 1, values);
        refuse(*state, image, NULL, words[i]);
        pave_image_free(&image);
    }
    for (int i = 0; i < 2; i++) {
        values[64 * 7 + 9] = i ? NAN : INFINITY;
        pave_image *image = take_plane(*state, 64, 64, 1, values);
        refuse(*state, image, NULL, "channel 0 at 9, 7");
        pave_image_free(&image);
    }
    pave_image *image = cells(*state, 64);
    params.neighbourhood = 4;
    refuse(*state, image, &params, "odd neighbourhood");
    params = (pave_statistics_params)PAVE_STATISTICS_PARAMS_INIT;
    params.scales = 9;
    refuse(*state, image, &params, "scales");
    params.scales = 3;
    pave_statistics *wanted = NULL;
    pave_statistics_synthesis_params synthesis = PAVE_STATISTICS_SYNTHESIS_PARAMS_INIT;
    pave_statistics_report report = { .size = sizeof report };
    pave_image *made = image, *colours = take_plane(*state, 64, 64, 3, values);
    assert_ok(pave_statistics_create(*state, image, &params, &wanted));
    synthesis.extent[0] = 8, synthesis.extent[1] = 8;
    assert_int_equal(pave_statistics_synthesize(*state, wanted, &synthesis, NULL, &made), PAVE_ERR_ARGUMENT);
    assert_null(made);
    assert_int_equal(pave_statistics_compare(*state, wanted, colours, &report), PAVE_ERR_ARGUMENT);
    pave_statistics_free(&wanted);
    pave_image_free(&image);
    pave_image_free(&colours);
}

/* Of nothing comes nothing: of one colour the same colour; and from two, those two and what lies between. */
static void plain_textures_stay_plain(void **state)
{
    float values[64 * 64];
    pave_statistics *wanted = NULL;
    pave_statistics_report report = { .size = sizeof report };
    pave_image *made = NULL;
    for (int i = 0; i < 64 * 64; i++)
        values[i] = 0.3f;
    pave_image *image = take_plane(*state, 64, 64, 1, values);
    assert_ok(pave_statistics_create(*state, image, NULL, &wanted));
    assert_ok(pave_statistics_synthesize(*state, wanted, NULL, &report, &made));
    assert_memory_equal(pave_image_pixels(made), values, sizeof values);
    assert_true(report.distance < 1e-3);
    pave_image_free(&made);
    pave_image_free(&image);
    pave_statistics_free(&wanted);
}

/* Measures and makes; NULL if it failed on the way. */
static pave_image *whole_job(pave_context *context, const pave_image *texture)
{
    pave_statistics_params params = PAVE_STATISTICS_PARAMS_INIT;
    pave_statistics_synthesis_params synthesis = PAVE_STATISTICS_SYNTHESIS_PARAMS_INIT;
    pave_statistics *wanted = NULL;
    pave_image *made = NULL;
    params.scales = 2;
    synthesis.iterations = 11;
    if (!pave_statistics_create(context, texture, &params, &wanted))
        (void)!pave_statistics_synthesize(context, wanted, &synthesis, NULL, &made);
    pave_statistics_free(&wanted);
    return made;
}

static void running_out_of_memory_leaks_nothing(void **state)
{
    enum { SIDE = 16 };
    float values[3 * SIDE * SIDE];
    failing memory = { .calls = 0 };
    pave_context_params params = failing_params(&memory);
    pave_context *context = NULL;
    draw_noise(values, 3 * SIDE * SIDE, 5, 0.5f, 0.1f);
    pave_image *texture = take_plane(*state, SIDE, SIDE, 3, values);
    assert_ok(pave_context_create(&params, &context));
    pave_image *made = whole_job(context, texture);
    assert_non_null(made);
    pave_image_free(&made);
    int64_t calls = memory.calls, held = memory.blocks;
    for (int64_t at = 1; at < calls; at += 1 + (at > 120) * (calls / 60)) {
        memory.calls = 0;
        memory.fail_at = at;
        made = whole_job(context, texture);
        assert_null(made);
        assert_int_equal(memory.blocks, held);
    }
    memory.fail_at = 0;
    pave_context_free(&context);
    pave_image_free(&texture);
    assert_int_equal(memory.blocks, 0);
}

static int32_t stop_at(void *user, const char *stage, double done)
{
    (void)stage;
    return done >= *(const double *)user;
}

static void it_stops_when_told(void **state)
{
    double when = 0.5;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    pave_context *context = NULL;
    pave_image *texture = cells(*state, 32);
    params.progress = stop_at;
    params.progress_user = &when;
    assert_ok(pave_context_create(&params, &context));
    assert_null(whole_job(context, texture));
    assert_non_null(strstr(pave_context_message(context), "cancelled"));
    pave_context_free(&context);
    pave_image_free(&texture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pyramids_are_inverted),
        cmocka_unit_test(autocorrelations_are_imposed),
        cmocka_unit_test(covariances_are_imposed),
        cmocka_unit_test(moments_are_imposed),
        cmocka_unit_test(changes_and_gradients_fit),
        cmocka_unit_test(only_what_jumps_is_taken_out),
        cmocka_unit_test(statistics_do_not_depend_on_size_or_border),
        cmocka_unit_test(textures_converge),
        cmocka_unit_test(photographs_converge),
        cmocka_unit_test(colours_go_together),
        cmocka_unit_test(planes_are_changed_in_place),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(channels_apart_are_done_at_once),
        cmocka_unit_test(what_cannot_be_is_refused),
        cmocka_unit_test(plain_textures_stay_plain),
        cmocka_unit_test(running_out_of_memory_leaks_nothing),
        cmocka_unit_test(it_stops_when_told),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
