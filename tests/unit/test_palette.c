/* palette: colours found and given, smooth edges without seams, parts like the whole. */
#include "test.h"

#include "image/image.h"
#include "image/palette.h"
#include "util/random.h"

#include <math.h>

typedef struct picture {
    int32_t width, height;
    uint8_t rgb[3 * 64 * 64];
} picture;

static pave_image *image_of(pave_context *context, const picture *p)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL;
    params.width = p->width;
    params.height = p->height;
    params.channels = 3;
    assert_ok(pave_image_create(context, &params, p->rgb, &image));
    return image;
}

static pave_palette palette_of(const char *text)
{
    pave_context *context = make_context(1, PAVE_BACKEND_CPU);
    pave_palette_params params = PAVE_PALETTE_PARAMS_INIT;
    assert_ok(pave_params_set(context, PAVE_PARAMS_PALETTE, &params, "palette", text));
    pave_context_free(&context);
    return params.palette;
}

static double light(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static double code(double v)
{
    return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
}

/* A line along x cos + y sin = off divides two colours; pixels are mixed by how much of them is on either side. */
static void divide(picture *p, double angle, double off, double blur, const uint8_t *a, const uint8_t *b, int linear)
{
    for (int32_t y = 0; y < p->height; y++)
        for (int32_t x = 0; x < p->width; x++) {
            double t = ((x + 0.5) * cos(angle) + (y + 0.5) * sin(angle) - off) / blur + 0.5;
            t = t < 0 ? 0 : t > 1 ? 1 : t;
            for (int c = 0; c < 3; c++) {
                double u = a[c] / 255.0, v = b[c] / 255.0;
                double mixed = linear ? code(light(u) * (1 - t) + light(v) * t) : u * (1 - t) + v * t;
                p->rgb[3 * (y * p->width + x) + c] = (uint8_t)(mixed * 255 + 0.5);
            }
        }
}

static void oklab_is_what_it_is_in_floating_point(void **state)
{
    (void)state;
    static pv_oklab tables;
    pv_oklab_begin(&tables);
    for (uint32_t n = 0; n < 3000; n++) {
        uint32_t w = pv_draw(1, 1, n, 0, 0).word[0];
        pv_rgb c = { (uint8_t)w, (uint8_t)(w >> 8), (uint8_t)(w >> 16) };
        double r = light(c.r / 255.0), g = light(c.g / 255.0), b = light(c.b / 255.0);
        double l = cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
        double m = cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
        double s = cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
        pv_lab lab = pv_oklab_of(&tables, c);
        assert_true(fabs(lab.l / 16384.0 - (0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s)) < 0.001);
        assert_true(fabs(lab.a / 16384.0 - (1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s)) < 0.004);
        assert_true(fabs(lab.b / 16384.0 - (0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s)) < 0.004);
        assert_int_equal(pv_display_of(&tables, tables.light[c.r]), c.r);
    }
    pv_lab white = pv_oklab_of(&tables, (pv_rgb){ 255, 255, 255 });
    assert_true(labs((long)white.l - 16384) < 4 && labs((long)white.a) < 4 && labs((long)white.b) < 4);
}

static void assert_palette(const pave_palette *found, const char *text)
{
    pave_palette expected = palette_of(text);
    assert_int_equal(found->count, expected.count);
    assert_memory_equal(found->rgb, expected.rgb, sizeof expected.rgb);
}

/* Three fields with smooth edges between them; the third is small. */
static picture three_fields(void)
{
    picture p = { 64, 64, { 0 } }, q = p;
    static const uint8_t blue[] = { 20, 40, 160 }, sand[] = { 240, 220, 170 }, red[] = { 200, 30, 40 };
    divide(&p, 0.4, 40, 1.2, blue, sand, 0);
    divide(&q, 2.1, -2, 1.2, sand, red, 0);
    for (int32_t i = 0; i < 64 * 64; i++) /* below the second line only */
        if (q.rgb[3 * i + 1] != 220)
            memcpy(p.rgb + 3 * i, q.rgb + 3 * i, 3);
    return p;
}

static void flat_colours_are_found_exactly(void **state)
{
    pave_context *context = *state;
    picture p = three_fields();
    pave_image *image = image_of(context, &p);
    pave_palette found;
    assert_ok(pave_palette_find(context, image, 3, &found));
    assert_palette(&found, "#1428a0 #c81e28 #f0dcaa");
    pave_image_free(&image);
    memset(p.rgb, 77, sizeof p.rgb);
    image = image_of(context, &p);
    assert_ok(pave_palette_find(context, image, 8, &found)); /* there are no eight */
    assert_palette(&found, "#4d4d4d");
    assert_int_equal(pave_palette_find(context, image, 1, &found), PAVE_ERR_ARGUMENT);
    assert_int_equal(pave_palette_find(context, image, 257, &found), PAVE_ERR_ARGUMENT);
    pave_image_free(&image);
}

static void noise_round_flat_colours_is_averaged(void **state)
{
    pave_context *context = *state;
    static const uint8_t true_colours[2][3] = { { 40, 90, 60 }, { 220, 180, 120 } };
    picture p = { 64, 64, { 0 } };
    for (uint32_t i = 0; i < 64 * 64; i++) {
        pv_random r = pv_draw(1, 3, i, 0, 0);
        for (int c = 0; c < 3; c++)
            p.rgb[3 * i + (uint32_t)c] = (uint8_t)(true_colours[i % 64 > 20][c] - 4 + (int)pv_below(r.word[c], 9));
    }
    pave_image *image = image_of(context, &p);
    pave_palette found;
    assert_ok(pave_palette_find(context, image, 2, &found));
    assert_int_equal(found.count, 2);
    for (int i = 0; i < 6; i++)
        assert_true(abs(found.rgb[i] - true_colours[i / 3][i % 3]) <= 1);
    pave_image_free(&image);
}

/* However pixels come: all at once, or row by row from below. */
static void a_palette_does_not_depend_on_parts(void **state)
{
    pave_context *context = *state;
    picture p = { 64, 64, { 0 } };
    for (uint32_t i = 0; i < sizeof p.rgb; i++)
        p.rgb[i] = (uint8_t)(pv_draw(2, 3, i / 192, 0, 0).word[0] >> (8 * (i % 3)));
    pave_image *image = image_of(context, &p);
    pave_palette whole, parts;
    pv_histogram *histogram;
    assert_ok(pave_palette_find(context, image, 7, &whole));
    assert_ok(pv_histogram_create(context, &histogram));
    for (int32_t y = 63; y >= 0; y--) {
        picture row = { 64, 1, { 0 } };
        memcpy(row.rgb, p.rgb + 192 * y, 192);
        pave_image *part = image_of(context, &row);
        assert_ok(pv_histogram_add(context, histogram, part));
        pave_image_free(&part);
    }
    assert_ok(pv_histogram_palette(context, histogram, 7, &parts));
    assert_int_equal(whole.count, 7);
    assert_memory_equal(&whole, &parts, sizeof whole);
    pv_histogram_free(histogram);
    pave_image_free(&image);
}

/* No third entry along an edge, though there is one between the two, or one that a mixture is nearest to; and the edge
 * is where the two have equal parts. */
static void smooth_edges_have_no_seams(void **state)
{
    pave_context *context = *state;
    pave_palette palette = palette_of("#000000 #808080 #ffffff #1a3fa8 #f4d03f #c0392b #7d9a6a");
    for (int32_t a = 0; a < palette.count; a++)
        for (int32_t b = 0; b < palette.count; b++)
            for (int k = 0; k < 12 && a != b; k++) {
                picture p = { 30, 30, { 0 } };
                double angle = 0.53 * k, blur = k % 3 == 2 ? 2.5 : 1.2;
                double off = 15 * cos(angle) + 15 * sin(angle);
                divide(&p, angle, off, blur, palette.rgb + 3 * a, palette.rgb + 3 * b, k % 2);
                pave_image *image = image_of(context, &p), *drawing = NULL;
                assert_ok(pave_image_quantise(context, image, &palette, &drawing));
                const uint8_t *entry = pave_image_pixels(drawing);
                for (int32_t i = 0; i < 900; i++) {
                    double from = (i % 30 + 0.5) * cos(angle) + (i / 30 + 0.5) * sin(angle) - off;
                    if (entry[i] != a && entry[i] != b)
                        fail_msg("%d at %d,%d between %d and %d (%d)", entry[i], i % 30, i / 30, a, b, k);
                    if (fabs(from) > (k % 2 ? 0.6 * blur : 0.3))
                        assert_int_equal(entry[i], from < 0 ? a : b);
                }
                pave_image_free(&drawing);
                pave_image_free(&image);
            }
}

static int32_t count_of(pave_context *context, const picture *p, const pave_palette *palette, uint8_t entry)
{
    pave_image *image = image_of(context, p), *drawing = NULL;
    int32_t count = 0;
    assert_ok(pave_image_quantise(context, image, palette, &drawing));
    for (int32_t i = 0; i < p->width * p->height; i++)
        count += ((const uint8_t *)pave_image_pixels(drawing))[i] == entry;
    pave_image_free(&drawing);
    pave_image_free(&image);
    return count;
}

/* A line between two fields: of a colour of its own even if it is one px wide; of their mixture if it is two. */
static void thin_lines_stay(void **state)
{
    pave_context *context = *state;
    pave_palette palette = palette_of("#000000 #808080 #ffffff #c0392b");
    for (int32_t wide = 1; wide <= 3; wide++)
        for (int32_t entry = 1; entry <= 3; entry += 2) {
            picture p = { 20, 20, { 0 } };
            for (int32_t i = 0; i < 400; i++)
                memcpy(p.rgb + 3 * i, palette.rgb + 3 * (i % 20 < 8 ? 0 : i % 20 < 8 + wide ? entry : 2), 3);
            assert_int_equal(count_of(context, &p, &palette, (uint8_t)entry), entry == 1 && wide == 1 ? 0 : 20 * wide);
        }
    picture dot = { 9, 9, { 0 } }; /* one px of another colour in a field */
    memset(dot.rgb, 255, sizeof dot.rgb);
    memcpy(dot.rgb + 3 * 40, palette.rgb + 9, 3);
    assert_int_equal(count_of(context, &dot, &palette, 3), 1);
}

/* Greys in black and white come out as by threshold. */
static void black_and_white_is_a_palette_too(void **state)
{
    pave_context *context = *state;
    static const uint8_t black[3] = { 0, 0, 0 }, white[3] = { 255, 255, 255 };
    pave_palette palette = palette_of("#000000,#ffffff");
    picture p = { 50, 50, { 0 } };
    divide(&p, 0.7, 32, 1.3, black, white, 0);
    pave_image *image = image_of(context, &p), *drawing = NULL, *cut = NULL;
    assert_ok(pave_image_quantise(context, image, &palette, &drawing));
    assert_ok(pave_image_threshold(context, image, NULL, &cut));
    for (int32_t i = 0; i < 2500; i++)
        assert_int_equal(((const uint8_t *)pave_image_pixels(drawing))[i] * 255,
                         ((const uint8_t *)pave_image_pixels(cut))[i]);
    assert_int_equal(pave_image_palette(drawing)->count, 2);
    assert_int_equal(pave_image_palette(cut)->count, 0);
    palette.count = 0;
    pave_image_free(&drawing);
    assert_int_equal(pave_image_quantise(context, image, &palette, &drawing), PAVE_ERR_ARGUMENT);
    assert_null(drawing);
    pave_image_free(&cut);
    pave_image_free(&image);
}

/* Half transparent red over white is pink; transparent black is white. */
static void alpha_lies_over_white(void **state)
{
    pave_context *context = *state;
    const uint8_t pixels[] = { 255, 0, 0, 128, 0, 0, 0, 0, 0, 0, 0, 255 };
    pave_palette palette = palette_of("#000000 #ff7f7f #ffffff");
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    pave_image *image = NULL, *drawing = NULL;
    params.width = 3;
    params.height = 1;
    params.channels = 4;
    params.alpha = 3;
    assert_ok(pave_image_create(context, &params, pixels, &image));
    assert_ok(pave_image_quantise(context, image, &palette, &drawing));
    assert_memory_equal(pave_image_pixels(drawing), ((uint8_t[]){ 1, 2, 0 }), 3);
    pave_image_free(&drawing);
    pave_image_free(&image);
}

/* Parts that are cut from codes are what they are in the whole. */
static void parts_are_cut_from_codes(void **state)
{
    pave_context *context = *state;
    pave_palette palette = palette_of("#000000 #808080 #ffffff #c0392b");
    picture p = { 64, 64, { 0 } };
    for (uint32_t i = 0; i < 64 * 64; i++) { /* specks, and mixtures all over */
        pv_random r = pv_draw(9, 3, i / 3, 0, 0);
        for (uint32_t c = 0; c < 3; c++)
            p.rgb[3 * i + c] = (uint8_t)((palette.rgb[3 * (r.word[0] % 4) + c] * 2 + palette.rgb[3 * (r.word[1] % 4) + c]) / 3);
    }
    pave_image *image = image_of(context, &p), *whole = NULL, *codes = NULL, *part = NULL;
    pv_codebook *book;
    pv_bitmap bitmap;
    assert_ok(pave_image_quantise(context, image, &palette, &whole));
    assert_ok(pv_codebook_create(context, &palette, &book));
    assert_ok(pv_encode_image(context, book, image, &codes));
    assert_ok(pv_bitmap_create(context, 64, 64, 8, &bitmap));
    pv_bitmap_store(&bitmap, 0, 0, codes);
    for (int32_t k = 0; k < 40; k++) {
        pv_random r = pv_draw(9, 4, (uint32_t)k, 0, 0);
        int32_t x = (int32_t)pv_below(r.word[0], 60), y = (int32_t)pv_below(r.word[1], 60);
        int32_t w = 1 + (int32_t)pv_below(r.word[2], (uint32_t)(64 - x));
        int32_t h = 1 + (int32_t)pv_below(r.word[3], (uint32_t)(64 - y));
        assert_ok(pv_drawing_cut(context, &bitmap, &palette, x, y, w, h, &part));
        for (int32_t row = 0; row < h; row++)
            assert_memory_equal((const uint8_t *)part->pixels + row * w,
                                (const uint8_t *)whole->pixels + (y + row) * 64 + x, (size_t)w);
        assert_int_equal(part->place.x, x);
        assert_int_equal(part->palette.count, 4);
        pave_image_free(&part);
    }
    uint64_t hash;
    assert_ok(pv_bitmap_hash(context, &bitmap, &hash));
    assert_true(hash == whole->hash);
    pv_bitmap_free(&bitmap);
    pv_release(book);
    pave_image_free(&codes);
    pave_image_free(&whole);
    pave_image_free(&image);
}

static void stones_carry_their_entry(void **state)
{
    pave_context *context = *state;
    picture p = three_fields();
    pave_image *image = image_of(context, &p), *drawing = NULL;
    pave_palette_params palette = PAVE_PALETTE_PARAMS_INIT;
    pave_lay_params params = PAVE_LAY_PARAMS_INIT;
    pave_stones *stones = NULL;
    pave_cvd_params cvd = PAVE_CVD_PARAMS_INIT;
    palette.colours = 3;
    cvd.half_side = 2;
    params.palette = &palette;
    params.cvd = &cvd;
    assert_ok(pave_lay(context, image, &params, &stones));
    assert_palette(pave_stones_palette(stones), "#1428a0 #c81e28 #f0dcaa");
    int32_t counts[256] = { 0 };
    for (int32_t i = 0; i < pave_stones_count(stones); i++)
        counts[pave_stones_colours(stones)[i]]++;
    assert_true(counts[0] > 10 && counts[1] > 10 && counts[2] > 10);
    assert_int_equal(counts[0] + counts[1] + counts[2], pave_stones_count(stones));
    pave_stones_measures m = { .size = sizeof m };
    assert_ok(pave_image_quantise(context, image, pave_stones_palette(stones), &drawing));
    assert_ok(pave_stones_measure(context, drawing, stones, NULL, &m));
    assert_true(m.mismatch < 0.05 && m.edge_mean < 1);
    pave_image_free(&drawing);
    pave_stones_free(&stones);
    pave_image_free(&image);
}

static void palettes_are_read_from_text(void **state)
{
    pave_context *context = *state;
    static const char *const bad[] = { "", "  ", "#12345", "#1234567", "123456", "#12345g", "#123456;#123456", "red" };
    pave_palette_params params = PAVE_PALETTE_PARAMS_INIT;
    assert_ok(pave_params_set(context, PAVE_PARAMS_PALETTE, &params, "palette", " #00fF10,\n#123456 "));
    assert_int_equal(params.palette.count, 2);
    assert_memory_equal(params.palette.rgb, ((uint8_t[]){ 0, 255, 16, 0x12, 0x34, 0x56, 0 }), 7);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(pave_params_set(context, PAVE_PARAMS_PALETTE, &params, "palette", bad[i]), PAVE_ERR_ARGUMENT);
        assert_non_null(strstr(pave_context_message(context), "colours like #rrggbb"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(oklab_is_what_it_is_in_floating_point),
        cmocka_unit_test(flat_colours_are_found_exactly),
        cmocka_unit_test(noise_round_flat_colours_is_averaged),
        cmocka_unit_test(a_palette_does_not_depend_on_parts),
        cmocka_unit_test(smooth_edges_have_no_seams),
        cmocka_unit_test(thin_lines_stay),
        cmocka_unit_test(black_and_white_is_a_palette_too),
        cmocka_unit_test(alpha_lies_over_white),
        cmocka_unit_test(parts_are_cut_from_codes),
        cmocka_unit_test(stones_carry_their_entry),
        cmocka_unit_test(palettes_are_read_from_text),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
