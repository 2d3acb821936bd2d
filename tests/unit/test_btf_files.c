/* BTFs in files of pictures: folders, archives, OpenEXR of many parts, BIG; there and back, and damaged. */
#include "test.h"

#include "btf/btf.h"
#include "io/folder.h"
#include "util/half.h"

#include <math.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

static char folder[] = "/tmp/pave-btf-files-XXXXXX";

static const char *at(const char *name)
{
    static char path[4][256];
    static int next;
    char *out = path[next++ % 4];
    snprintf(out, sizeof path[0], "%s/%s", folder, name);
    return out;
}

static void put_file(const char *path, const void *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

static uint8_t *get_file(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    uint8_t *bytes = malloc(1 << 20);
    *size = fread(bytes, 1, 1 << 20, file);
    fclose(file);
    return bytes;
}

/* Three views, four lights, 3 x 2 texels; every sample is another. */
static pave_btf *sample_btf(pave_context *context, int32_t type)
{
    static const pave_direction views[3] = { { 0, 0 }, { 0.3f, -1 }, { 0.9f, 2.5f } };
    static const pave_direction lights[4] = { { 0.1f, 0.25f }, { 0.3f, 1 }, { 0.3f, -1 }, { 1.2f, 3 } };
    pave_btf_params shape = PAVE_BTF_PARAMS_INIT;
    pave_btf *btf = NULL;
    shape.width = 3;
    shape.height = 2;
    shape.type = type;
    shape.views = 3;
    shape.lights = 4;
    shape.view_directions = views;
    shape.light_directions = lights;
    assert_ok(pave_btf_create(context, &shape, NULL, &btf));
    for (int64_t t = 0; t < 6; t++) {
        float values[36];
        for (int i = 0; i < 36; i++)
            values[i] = (float)(t * 36 + i) / 128;
        pv_btf_put(btf, t, 0, 36, values);
    }
    return btf;
}

/* The pair of `b` whose directions are nearest to those of a pair of `a`; angles may have been rounded to 0.001. */
static int64_t same_pair(const pave_btf *a, const pave_btf *b, int64_t pair)
{
    int64_t best[2] = { -1, -1 };
    for (int k = 0; k < 2; k++) {
        const pv_directions *from = k ? &a->lights : &a->views, *to = k ? &b->lights : &b->views;
        double v[3], u[3];
        pv_direction_vector(from->direction[k ? pair % a->lights.count : pair / a->lights.count], v);
        for (int32_t i = 0; i < to->count; i++) {
            pv_direction_vector(to->direction[i], u);
            if (v[0] * u[0] + v[1] * u[1] + v[2] * u[2] > 1 - 1e-9)
                best[k] = i;
        }
        assert_true(best[k] >= 0);
    }
    return best[0] * b->lights.count + best[1];
}

static void assert_same(const pave_btf *a, const pave_btf *b, double tolerance)
{
    float x[3], y[3];
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->channels, b->channels);
    for (int64_t t = 0; t < pv_btf_texels(a); t++)
        for (int64_t p = 0; p < (int64_t)a->views.count * a->lights.count; p++) {
            pv_btf_sample(a, t, p, x);
            pv_btf_sample(b, t, same_pair(a, b, p), y);
            for (int c = 0; c < 3; c++)
                assert_true(fabs((double)x[c] - y[c]) <= tolerance);
        }
}

static void names_are_read_by_key(void **state)
{
    (void)state;
    static const struct { const char *name; double angle[4]; } good[] = {
        { "00008 tl000 pl015 tv030 pv045.jpg", { 0, 15, 30, 45 } },
        { "tl000_pl015_tv030_pv045.exr", { 0, 15, 30, 45 } },
        { "tv030_pv045/x/pv045-tv030-pl15.25-tl7.5.png", { 7.5, 15.25, 30, 45 } },
        { "tv030_pv045/tl007_pl-60.5.png", { 7, -60.5, 30, 45 } },
        { "TL1PL2TV3PV4", { 1, 2, 3, 4 } },
    };
    static const char *const bad[] = { "", "tl000_pl000_tv000.png", "tl_pl000_tv000_pv000", "xtl0_pl0_tv0_pv0",
                                       "tlx0_pl0_tv0_pv0" };
    double light[2], view[2];
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        assert_true(pv_parse_angles(good[i].name, light, view));
        assert_true(light[0] == good[i].angle[0] && light[1] == good[i].angle[1] && view[0] == good[i].angle[2] &&
                    view[1] == good[i].angle[3]);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_false(pv_parse_angles(bad[i], light, view));
}

static void there_and_back(pave_context *context, const pave_btf *btf, const char *path,
                           const pave_btf_file_params *params, double tolerance)
{
    pave_btf *read = NULL;
    assert_ok(pave_btf_write(context, btf, params, path));
    assert_ok(pave_btf_read(context, path, params, &read));
    assert_same(btf, read, tolerance);
    assert_null(pave_btf_missing(read));
    pave_btf_free(&read);
}

static void pictures_come_back(void **state)
{
    pave_btf *half = sample_btf(*state, PAVE_F16), *real = sample_btf(*state, PAVE_F32);
    there_and_back(*state, half, at("half.exr"), NULL, 0);
    there_and_back(*state, real, at("real.exr"), NULL, 0);
    there_and_back(*state, half, at("half/"), NULL, 0);
    there_and_back(*state, real, at("real/"), NULL, 0);
    assert_int_equal(access(at("real/tv000_pv000"), F_OK), 0);
    assert_int_equal(pave_btf_write(*state, real, NULL, at("real")), PAVE_ERR_IO); /* it is not empty */
    pave_btf_free(&half);
    pave_btf_free(&real);
}

/* A spool in a file holds what one in memory does. */
static void a_small_memory_is_enough(void **state)
{
    pave_btf *btf = sample_btf(*state, PAVE_F32), *read = NULL;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    pave_limits limits;
    pave_context *context = NULL;
    pave_limits_init(&limits, sizeof limits);
    limits.max_bytes = 6000; /* the samples take 864 */
    params.limits = &limits;
    assert_ok(pave_btf_write(*state, btf, NULL, at("spool/")));
    limits.max_bytes = 1 << 20;
    assert_ok(pave_context_create(&params, &context));
    context->limits.max_bytes = 2000; /* the share of the spool; memory is counted apart */
    assert_ok(pave_btf_read(context, at("spool"), NULL, &read));
    assert_non_null(read->samples.map);
    assert_same(btf, read, 0);
    pave_btf_free(&read);
    pave_btf_free(&btf);
    pave_context_free(&context);
}

static void missing_pictures_make_a_mask(void **state)
{
    pave_btf *btf = sample_btf(*state, PAVE_F16), *read = NULL;
    float values[3];
    assert_ok(pave_btf_write(*state, btf, NULL, at("gap/")));
    assert_int_equal(unlink(at("gap/tv000_pv000/tl005.73_pl014.324_tv000_pv000.exr")), 0);
    assert_ok(pave_btf_read(*state, at("gap"), NULL, &read));
    const uint8_t *missing = pave_btf_missing(read);
    assert_non_null(missing);
    int count = 0;
    for (int i = 0; i < 12; i++)
        count += missing[i];
    assert_true(count == 1 && missing[0]);
    pv_btf_sample(read, 0, 0, values);
    assert_true(values[0] == 0 && values[2] == 0);
    assert_ok(pave_btf_write(*state, read, NULL, at("gap.exr"))); /* the mask goes with it */
    pave_btf_free(&read);
    assert_ok(pave_btf_read(*state, at("gap.exr"), NULL, &read));
    assert_true(pave_btf_missing(read) && pave_btf_missing(read)[0] && !pave_btf_missing(read)[1]);
    pave_btf_free(&read);
    pave_btf_free(&btf);
}

static uint8_t *put(uint8_t *p, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        *p++ = (uint8_t)(value >> 8 * i);
    return p;
}

/* An archive of the pictures of a folder, every second one deflated; returns its size. */
static size_t make_zip(const pave_btf *btf, const char *of, uint8_t *out)
{
    uint8_t *p = out, directory[65536], *d = directory;
    int count = 0;
    for (int v = 0; v < btf->views.count; v++)
        for (int l = 0; l < btf->lights.count; l++, count++) {
            char name[128], path[256];
            size_t size, packed_size = 65536;
            const pave_direction *a = &btf->views.direction[v], *b = &btf->lights.direction[l];
            double degrees[4] = { b->theta * 180 / M_PI, fmod(b->phi * 180 / M_PI + 360, 360), a->theta * 180 / M_PI,
                                  fmod(a->phi * 180 / M_PI + 360, 360) };
            snprintf(name, sizeof name, "set/%05d tl%.3f pl%.3f tv%.3f pv%.3f.exr", count, degrees[0], degrees[1],
                     degrees[2], degrees[3]);
            snprintf(path, sizeof path, "%s/%d.exr", of, count);
            uint8_t *bytes = get_file(path, &size), packed[65536];
            z_stream z = { 0 };
            deflateInit2(&z, 6, Z_DEFLATED, -15, 8, 0);
            z.next_in = bytes, z.avail_in = (uInt)size, z.next_out = packed, z.avail_out = sizeof packed;
            deflate(&z, Z_FINISH);
            packed_size = z.total_out;
            deflateEnd(&z);
            int method = count % 2 ? 8 : 0;
            uint64_t crc = crc32(0, bytes, (uInt)size), stored = method ? packed_size : size, here = (uint64_t)(p - out);
            size_t length = strlen(name);
            d = put(put(put(put(d, 0x02014b50, 4), 20, 2), 20, 2), 0, 2);
            d = put(put(put(put(put(d, (uint64_t)method, 2), 0, 4), crc, 4), stored, 4), size, 4);
            d = put(put(put(put(put(d, length, 2), 0, 8), 0, 4), here, 4), 0, 0);
            memcpy(d, name, length), d += length;
            p = put(put(put(put(p, 0x04034b50, 4), 20, 2), 0, 2), (uint64_t)method, 2);
            p = put(put(put(put(put(put(p, 0, 4), crc, 4), stored, 4), size, 4), length, 2), 0, 2);
            memcpy(p, name, length), p += length;
            memcpy(p, method ? packed : bytes, stored), p += stored;
            free(bytes);
        }
    uint64_t start = (uint64_t)(p - out), size = (uint64_t)(d - directory);
    memcpy(p, directory, size), p += size;
    p = put(put(put(put(put(p, 0x06054b50, 4), 0, 4), (uint64_t)count, 2), (uint64_t)count, 2), size, 4);
    p = put(put(p, start, 4), 0, 2);
    return (size_t)(p - out);
}

static size_t sample_zip(pave_context *context, const pave_btf *btf, uint8_t *out)
{
    mkdir(at("flat"), 0777);
    for (int i = 0; i < 12; i++) {
        pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
        pave_image *image = NULL;
        float texture[18];
        char name[32];
        shape.width = 3, shape.height = 2, shape.channels = 3, shape.type = PAVE_F32, shape.encoding = PAVE_LINEAR;
        shape.alpha = -1;
        shape.names = "R,G,B";
        pave_btf_texture(btf, i / 4, i % 4, texture);
        assert_ok(pave_image_create(context, &shape, texture, &image));
        snprintf(name, sizeof name, "flat/%d.exr", i);
        assert_ok(pave_image_write(context, image, at(name)));
        pave_image_free(&image);
    }
    return make_zip(btf, at("flat"), out);
}

static void archives_are_read(void **state)
{
    pave_btf *btf = sample_btf(*state, PAVE_F32), *read = NULL;
    uint8_t *bytes = malloc(1 << 20);
    size_t size = sample_zip(*state, btf, bytes);
    put_file(at("set.zip"), bytes, size);
    assert_ok(pave_btf_read(*state, at("set.zip"), NULL, &read));
    assert_same(btf, read, 0);
    pave_btf_free(&read);
    pave_btf_free(&btf);
    free(bytes);
}

static uint8_t *chunk(uint8_t *p, uint64_t id, uint64_t length)
{
    return put(put(p, id, 8), length, 8);
}

static uint8_t *put_number(uint8_t *p, double value, int bytes)
{
    float narrow = (float)value;
    memcpy(p, bytes == 8 ? (void *)&value : (void *)&narrow, (size_t)bytes);
    return p + bytes;
}

static uint8_t *put_angles(uint8_t *p, const pave_btf *btf, int bytes)
{
    for (int i = 0; i < 12; i++) {
        const pave_direction *l = &btf->lights.direction[i % 4], *v = &btf->views.direction[i / 4];
        p = put_number(put_number(p, l->theta * 180 / M_PI, bytes), l->phi * 180 / M_PI, bytes);
        p = put_number(put_number(p, v->theta * 180 / M_PI, bytes), v->phi * 180 / M_PI, bytes);
    }
    return p;
}

/* BIG 3.0 in either order: image by image, or texel by texel (mapped). */
static size_t make_big(const pave_btf *btf, int by_texel, uint8_t *out)
{
    static const uint64_t order[5] = { 3, 4, 1, 5, 2 };
    float value[3];
    uint8_t *p = put(out, 0x474942, 8);
    uint64_t extent[5] = { 12, 1, 2, 3, 3 };
    for (uint64_t i = 0; i < 5; i++)
        p = put(chunk(p, i + 1, 8), extent[i], 8);
    p = by_texel ? chunk(p, 6, 40) : p;
    for (int i = 0; i < 5 && by_texel; i++)
        p = put(p, order[i], 8);
    p = put(chunk(p, 7, 8), 2, 8);
    p = put_angles(put(chunk(p, 16, 8 + 12 * 32), 3, 8), btf, 8);
    p = chunk(p, 8, 12 * 6 * 3 * 4);
    for (int i = 0; i < 72; i++) {
        pv_btf_sample(btf, by_texel ? i / 12 : i % 6, by_texel ? i % 12 : i / 6, value);
        for (int c = 0; c < 3; c++)
            p = put_number(p, value[c], 4);
    }
    return (size_t)(p - out);
}

/* BIG 2.37, with halves and floats side by side. */
static size_t make_old_big(const pave_btf *btf, uint8_t *out)
{
    uint8_t *p = put(chunk(out, 4, 8), 12, 8);
    float value[3];
    p = put(chunk(p, 1, 8), 3, 8);
    p = put(chunk(p, 2, 8), 2, 8);
    p = put(chunk(p, 3, 8), 3, 8);
    p = put(chunk(p, 5, 8), UINT64_MAX, 8);
    p = put_angles(chunk(p, 14, 12 * 16), btf, 4);
    p = chunk(p, 7, 12);
    for (int i = 0; i < 12; i++)
        *p++ = i % 3 ? 2 : 4;
    p = put(p, 0, 4); /* up to 8 bytes */
    p = chunk(p, 6, 6 * 3 * (4 * 4 + 8 * 2));
    for (int i = 0; i < 72; i++) {
        pv_btf_sample(btf, i % 6, i / 6, value);
        for (int c = 0; c < 3; c++) /* halves hold these values exactly */
            p = i / 6 % 3 ? put(p, pv_half(value[c]), 2) : put_number(p, value[c], 4);
    }
    return (size_t)(p - out);
}

static void big_files_are_read(void **state)
{
    pave_btf *btf = sample_btf(*state, PAVE_F16), *read = NULL;
    uint8_t *bytes = malloc(1 << 16);
    for (int kind = 0; kind < 3; kind++) {
        put_file(at("x.big"), bytes, kind < 2 ? make_big(btf, kind, bytes) : make_old_big(btf, bytes));
        assert_ok(pave_btf_read(*state, at("x.big"), NULL, &read));
        assert_int_equal(read->samples.map != NULL, kind == 1);
        assert_same(btf, read, 0);
        pave_btf_free(&read);
    }
    free(bytes);
    pave_btf_free(&btf);
}

/* Rows from the top, from the bottom, as ATRIUM says it, and run-length encoded. */
static void radiance_pictures_are_read(void **state)
{
    static const char *const sizes[3] = { "-Y 2 +X 8", "+Y 2 +X 8", "+X 8 -Y 2" };
    for (int kind = 0; kind < 6; kind++) {
        uint8_t bytes[512], *p = bytes;
        pave_image *image = NULL;
        p += sprintf((char *)p, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n%s\n", sizes[kind % 3]);
        for (int y = 0; y < 2; y++) {
            if (kind >= 3)
                p = put(p, 0x08000202, 4);
            for (int i = 0; i < (kind < 3 ? 8 : 0); i++)
                p = put(p, (uint64_t)(10 * y + i) | 100 << 8 | 50 << 16 | 129ull << 24, 4);
            for (int i = 0; i < 9 && kind >= 3; i++) /* red as it is, the others as runs */
                *p++ = (uint8_t)(i ? 10 * y + i - 1 : 8);
            if (kind >= 3)
                p = put(p, 136 | 100 << 8 | 136 << 16 | 50ull << 24 | 136ull << 32 | 129ull << 40, 6);
        }
        put_file(at("x.hdr"), bytes, (size_t)(p - bytes));
        assert_ok(pave_image_read(*state, at("x.hdr"), &image));
        assert_int_equal(pave_image_width(image), 8);
        const float *pixels = pave_image_pixels(image);
        for (int y = 0; y < 2; y++)
            for (int x = 0; x < 8; x++) {
                int row = kind % 3 ? 1 - y : y;
                assert_true(fabsf(pixels[3 * (8 * y + x)] - (10 * row + x + 0.5f) / 128 / 2) < 1e-6f);
                assert_true(fabsf(pixels[3 * (8 * y + x) + 1] - 100.5f / 256) < 1e-6f);
            }
        pave_image_free(&image);
        for (size_t cut = 12; cut < (size_t)(p - bytes); cut += 3) {
            put_file(at("x.hdr"), bytes, cut);
            assert_int_not_equal(pave_image_read(*state, at("x.hdr"), &image), PAVE_OK);
        }
    }
}

/* Every prefix is refused; with four bytes changed anywhere, it is refused or read. Returns how many were read. */
static size_t sweep(pave_context *context, const char *path, const uint8_t *bytes, size_t size, size_t step)
{
    pave_btf *read = NULL;
    size_t kept = 0;
    for (size_t cut = 1; cut < size; cut += step) {
        put_file(path, bytes, cut);
        assert_int_not_equal(pave_btf_read(context, path, NULL, &read), PAVE_OK);
        assert_null(read);
    }
    for (size_t i = 0; i + 4 <= size; i += step) {
        uint8_t *changed = malloc(size);
        memcpy(changed, bytes, size);
        memset(changed + i, i % 3 ? 0xFF : i % 2 ? 0x7F : 0, 4);
        put_file(path, changed, size);
        kept += pave_btf_read(context, path, NULL, &read) == PAVE_OK;
        pave_btf_free(&read);
        free(changed);
    }
    return kept;
}

static void damaged_pictures_are_refused(void **state)
{
    pave_context_params quiet = PAVE_CONTEXT_PARAMS_INIT;
    pave_context *context = NULL;
    pave_btf *btf = sample_btf(*state, PAVE_F32);
    uint8_t *bytes = malloc(1 << 20);
    size_t size;
    assert_ok(pave_context_create(&quiet, &context));
    size = make_big(btf, 1, bytes);
    assert_true(sweep(context, at("y.big"), bytes, size, 3) < size / 3);
    size = make_old_big(btf, bytes);
    sweep(context, at("y.big"), bytes, size, 3);
    size = sample_zip(context, btf, bytes);
    assert_true(sweep(context, at("y.zip"), bytes, size, 11) < size / 44);
    free(bytes);
    assert_ok(pave_btf_write(context, btf, NULL, at("y.exr")));
    bytes = get_file(at("y.exr"), &size);
    sweep(context, at("y.exr"), bytes, size, 7);
    free(bytes);
    pave_btf_free(&btf);
    pave_context_free(&context);
}

/* Two pictures of a pair, pictures of another size, values that are no numbers, nothing at all. */
static void wrong_sets_are_refused(void **state)
{
    pave_btf *btf = sample_btf(*state, PAVE_F32), *read = NULL;
    float nan[36] = { NAN };
    mkdir(at("none"), 0777);
    assert_int_equal(pave_btf_read(*state, at("none"), NULL, &read), PAVE_ERR_FORMAT);
    assert_ok(pave_btf_write(*state, btf, NULL, at("twins/")));
    assert_int_equal(link(at("twins/tv000_pv000/tl005.73_pl014.324_tv000_pv000.exr"), at("twins/tl5.730pl14.324.exr")), 0);
    assert_ok(pave_btf_read(*state, at("twins"), NULL, &read)); /* its name lacks the view */
    pave_btf_free(&read);
    assert_int_equal(rename(at("twins/tl5.730pl14.324.exr"), at("twins/tl5.730_pl14.324_tv0_pv0.exr")), 0);
    assert_int_equal(pave_btf_read(*state, at("twins"), NULL, &read), PAVE_ERR_FORMAT);
    pv_btf_put(btf, 0, 0, 36, nan);
    assert_ok(pave_btf_write(*state, btf, NULL, at("nan/")));
    assert_int_equal(pave_btf_read(*state, at("nan"), NULL, &read), PAVE_ERR_FORMAT);
    assert_ok(pave_btf_write(*state, btf, NULL, at("nan.exr")));
    assert_int_equal(pave_btf_read(*state, at("nan.exr"), NULL, &read), PAVE_ERR_FORMAT);
    pave_btf_free(&btf);
}

/* How much of a file that is mapped is in this process's memory, in KiB. */
static long resident(const char *name)
{
    char line[512];
    long found = -1, here = 0;
    FILE *file = fopen("/proc/self/smaps", "r");
    assert_non_null(file);
    while (found < 0 && fgets(line, sizeof line, file)) {
        here |= strstr(line, name) != NULL;
        if (here)
            sscanf(line, "Rss: %ld kB", &found);
    }
    fclose(file);
    assert_true(found >= 0);
    return found;
}

/* Samples that are mapped and have been read do not add up in memory. */
static void mapped_samples_are_left(void **state)
{
    pave_btf_synthesis_params params = PAVE_BTF_SYNTHESIS_PARAMS_INIT;
    pave_btf *made = NULL, *read = NULL;
    params.class_of = PAVE_BTF_FLAT;
    params.texels = 16;
    assert_ok(pave_btf_synthesize(*state, &params, &made));
    assert_ok(pave_btf_write(*state, made, NULL, at("left.bdi")));
    assert_ok(pave_btf_read(*state, at("left.bdi"), NULL, &read));
    float *first = malloc(6561 * 3 * sizeof *first), *again = malloc(6561 * 3 * sizeof *first);
    pave_btf_abrdf(read, 0, 0, first);
    for (int32_t t = 0; t < 256; t++)
        pave_btf_abrdf(read, t % 16, t / 16, again);
    assert_true(resident("left.bdi") < 256l * 6561 * 3 * 2 / 2048);
    pave_btf_abrdf(read, 0, 0, again);
    assert_memory_equal(first, again, 6561 * 3 * sizeof *first);
    free(first);
    free(again);
    pave_btf_free(&made);
    pave_btf_free(&read);
}

static int open_folder(void **state)
{
    return !mkdtemp(folder) || open_context(state);
}

static int close_folder(void **state)
{
    char command[64];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command) || close_context(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_read_by_key),
        cmocka_unit_test(pictures_come_back),
        cmocka_unit_test(a_small_memory_is_enough),
        cmocka_unit_test(missing_pictures_make_a_mask),
        cmocka_unit_test(archives_are_read),
        cmocka_unit_test(big_files_are_read),
        cmocka_unit_test(radiance_pictures_are_read),
        cmocka_unit_test(damaged_pictures_are_refused),
        cmocka_unit_test(wrong_sets_are_refused),
        cmocka_unit_test(mapped_samples_are_left),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
