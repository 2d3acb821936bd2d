/* Files in and out: round trips, hostile files, limits, memory, silence, and what is left on the disk. */
#include "failing.h"

#include "base/context.h"
#include "io/convert.h"
#include "io/drawing.h"
#include "io/output.h"
#include "stones/stones.h"
#include "util/half.h"
#include "util/random.h"
#include "util/json.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <sys/stat.h>
#include <unistd.h>

#ifndef PAVE_TEST_DATA
#define PAVE_TEST_DATA "tests/data"
#endif

static pave_context *context;
static char folder[64];

static const char *in_folder(const char *name)
{
    static char path[4][4200];
    static int next;
    char *out = path[next++ % 4];
    snprintf(out, sizeof path[0], "%s/%s", folder, name);
    return out;
}

static const char *sample(const char *name)
{
    static char path[4200];
    snprintf(path, sizeof path, "%s/%s", PAVE_TEST_DATA, name);
    return path;
}

static int set_up(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/pave-test-io-XXXXXX");
    return !mkdtemp(folder) || pave_context_create(NULL, &context);
}

/* Also the proof that no test left a temporary file. */
static int tear_down(void **state)
{
    (void)state;
    int strays = 0;
    DIR *dir = opendir(folder);
    for (struct dirent *entry; (entry = readdir(dir));) {
        strays += !strncmp(entry->d_name, ".pave-", 6);
        if (entry->d_name[0] != '.' || entry->d_name[1])
            unlinkat(dirfd(dir), entry->d_name, 0);
    }
    closedir(dir);
    rmdir(folder);
    pave_context_free(&context);
    return strays;
}

static pave_image *must_read(const char *path)
{
    pave_image *image;
    if (pave_image_read(context, path, &image))
        fail_msg("%s", pave_context_message(context));
    return image;
}

static void must_fail(const char *path, pave_result expected)
{
    pave_image *image = (pave_image *)1;
    pave_result result = pave_image_read(context, path, &image);
    if (result != expected)
        fail_msg("%s: %s: %s", path, pave_result_name(result), pave_context_message(context));
    assert_null(image);
    assert_true(strlen(pave_context_message(context)) > 10);
    assert_null(strchr(pave_context_message(context), '\n'));
}

static pave_image *make(int32_t width, int32_t height, int32_t channels, int32_t type, int32_t encoding, int32_t alpha,
                        const char *names)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    params.width = width, params.height = height, params.channels = channels;
    params.type = type, params.encoding = encoding, params.alpha = alpha, params.names = names;
    pave_image *image;
    assert_int_equal(pave_image_create(context, &params, NULL, &image), PAVE_OK);
    for (int64_t i = 0; i < (int64_t)width * height * channels; i++) {
        uint32_t h = (uint32_t)(i + 1) * 2654435761u;
        switch (type) {
        case PAVE_U8: ((uint8_t *)image->pixels)[i] = (uint8_t)(h >> 24); break;
        case PAVE_U16: ((uint16_t *)image->pixels)[i] = (uint16_t)(h >> 16); break;
        case PAVE_U32: ((uint32_t *)image->pixels)[i] = h; break;
        case PAVE_F16: ((uint16_t *)image->pixels)[i] = pv_half((float)(h >> 22) / 1024); break;
        default: ((float *)image->pixels)[i] = (float)(h >> 8) / 16777216;
        }
    }
    return image;
}

static void assert_same_pixels(const pave_image *a, const pave_image *b)
{
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->channels, b->channels);
    assert_int_equal(a->type, b->type);
    assert_int_equal(a->encoding, b->encoding);
    assert_int_equal(a->alpha, b->alpha);
    for (int32_t c = 0; c < a->channels; c++)
        assert_string_equal(a->names[c], b->names[c]);
    size_t bytes = (size_t)a->width * (size_t)a->height * (size_t)a->channels * pv_type_bytes(a->type);
    assert_memory_equal(a->pixels, b->pixels, bytes);
}

static void round_trip(pave_image *image, const char *name)
{
    const char *path = in_folder(name);
    if (pave_image_write(context, image, path))
        fail_msg("%s", pave_context_message(context));
    pave_image *back = must_read(path);
    assert_same_pixels(image, back);
    pave_image_free(&back);
    pave_image_free(&image);
    unlink(path);
}

static void exr_round_trips(void **state)
{
    (void)state;
    round_trip(make(37, 35, 1, PAVE_F32, PAVE_DATA, -1, "depth"), "a.exr");
    round_trip(make(37, 35, 3, PAVE_F16, PAVE_LINEAR, -1, NULL), "b.EXR");
    round_trip(make(1, 1, 1, PAVE_U32, PAVE_DATA, -1, "label"), "c.exr");
    round_trip(make(300, 20, 1, PAVE_U32, PAVE_DATA, -1, "label"), "d.exr");
    round_trip(make(5, 40, 3, PAVE_F32, PAVE_DATA, -1, "distance,gradient.x,gradient.y"), "e.exr");
    round_trip(make(5, 40, 7, PAVE_F32, PAVE_LINEAR, -1, "R,G,B,N.x,N.y,N.z,a name of more than thirty-one bytes"),
               "f.exr");
}

static void exr_converts(void **state)
{
    (void)state;
    pave_image *image = make(64, 64, 4, PAVE_U8, PAVE_DISPLAY, 3, NULL);
    assert_int_equal(pave_image_write(context, image, in_folder("a.exr")), PAVE_OK);
    pave_image *back = must_read(in_folder("a.exr"));
    assert_int_equal(back->type, PAVE_F16);
    assert_int_equal(back->encoding, PAVE_LINEAR);
    assert_int_equal(back->alpha, 3);
    for (int64_t i = 0; i < 64 * 64; i++) {
        double alpha = pv_image_value(image, 4 * i + 3), coded = pv_display_code(pv_image_value(back, 4 * i));
        assert_true(fabs(pv_image_value(back, 4 * i + 3) - alpha) < 0.001);
        assert_true(alpha < 0.1 || fabs(coded - pv_image_value(image, 4 * i)) < 0.004);
    }
    pave_image_free(&back);
    pave_image_free(&image);
}

static void png_and_tiff_round_trips(void **state)
{
    (void)state;
    for (int32_t channels = 1; channels <= 4; channels++)
        for (int32_t type = PAVE_U8; type <= PAVE_U16; type++) {
            int32_t alpha = channels % 2 ? -1 : channels - 1;
            round_trip(make(31, 9, channels, type, PAVE_DISPLAY, alpha, NULL), "a.png");
            round_trip(make(31, 9, channels, type, PAVE_DISPLAY, alpha, NULL), "a.tif");
        }
    round_trip(make(31, 9, 3, PAVE_F32, PAVE_LINEAR, -1, NULL), "a.TIFF");
    round_trip(make(3000, 700, 3, PAVE_U8, PAVE_DISPLAY, -1, NULL), "large.png");
}

static void png_of_light_is_coded(void **state)
{
    (void)state;
    pave_image *image = make(40, 40, 3, PAVE_F32, PAVE_LINEAR, -1, NULL), *back;
    assert_int_equal(pave_image_write(context, image, in_folder("a.png")), PAVE_OK);
    back = must_read(in_folder("a.png"));
    assert_int_equal(back->type, PAVE_U16);
    for (int64_t i = 0; i < 40 * 40 * 3; i++)
        assert_true(fabs(pv_image_value(back, i) - pv_display_code(pv_image_value(image, i))) < 1e-4);
    pave_image_free(&back);
    pave_image_free(&image);
}

static void refuses_what_a_format_cannot_hold(void **state)
{
    (void)state;
    pave_image *labels = make(4, 4, 1, PAVE_U32, PAVE_DATA, -1, NULL);
    pave_image *five = make(4, 4, 5, PAVE_U8, PAVE_DISPLAY, -1, NULL);
    pave_image *rgba = make(4, 4, 4, PAVE_U8, PAVE_DISPLAY, 3, NULL);
    assert_int_equal(pave_image_write(context, labels, in_folder("a.png")), PAVE_ERR_UNSUPPORTED);
    assert_int_equal(pave_image_write(context, five, in_folder("a.png")), PAVE_ERR_UNSUPPORTED);
    assert_int_equal(pave_image_write(context, rgba, in_folder("a.jpg")), PAVE_ERR_UNSUPPORTED);
    assert_int_equal(pave_image_write(context, rgba, in_folder("a.gif")), PAVE_ERR_UNSUPPORTED);
    assert_non_null(strstr(pave_context_message(context), ".exr"));
    assert_int_equal(pave_image_write(context, rgba, ""), PAVE_ERR_UNSUPPORTED);
    assert_int_equal(pave_image_write(context, NULL, "a.png"), PAVE_ERR_ARGUMENT);
    assert_int_equal(pave_image_write(NULL, rgba, "a.png"), PAVE_ERR_ARGUMENT);
    pave_image *none = rgba;
    assert_int_equal(pave_image_read(context, NULL, &none), PAVE_ERR_ARGUMENT);
    assert_null(none);
    pave_image_free(&rgba);
    pave_image_free(&labels);
    pave_image_free(&five);
}

/* tests/data/make.py: red is x * 10, green y * 15, blue 40, alpha (x + y) * 6 of 255. */
static void check_picture(const char *name, int32_t channels, double tolerance)
{
    pave_image *image = must_read(sample(name));
    assert_int_equal(image->width, 24);
    assert_int_equal(image->height, 16);
    assert_int_equal(image->channels, channels);
    assert_int_equal(image->alpha, channels == 4 ? 3 : channels == 2 ? 1 : -1);
    for (int32_t y = 0; y < 16; y++)
        for (int32_t x = 0; x < 24; x++) {
            double expected[4] = { x * 10, y * 15, 40, (x + y) * 6 };
            if (channels == 2)
                expected[1] = (x + y) * 6;
            for (int32_t c = 0; c < channels; c++) {
                double value = pv_image_value(image, (int64_t)(y * 24 + x) * channels + c) * 255;
                double alpha = channels == 4 && c < 3 ? expected[3] / 255 : 1; /* its rounding was divided by it */
                if (fabs(value - expected[c]) > tolerance / (alpha + 1e-9) + 1e-3)
                    fail_msg("%s: channel %d at %d, %d is %g, not %g", name, c, x, y, value, expected[c]);
            }
        }
    pave_image_free(&image);
}

static void reads_pictures(void **state)
{
    (void)state;
    static const char *const exact[] = { "interlaced.png", "orientation-6.png", "rgb.webp", "rgb.ppm", "rgb-lzw.tif",
                                         "orientation-6.tif", "tiled.tif" };
    for (size_t i = 0; i < sizeof exact / sizeof *exact; i++)
        check_picture(exact[i], 3, 0);
    for (int o = 1; o <= 8; o++) {
        char name[32];
        snprintf(name, sizeof name, "orientation-%d.jpg", o);
        check_picture(name, 3, 5);
    }
    check_picture("rgba.png", 4, 0);
    check_picture("grey-alpha.png", 2, 0);
    check_picture("premultiplied.tif", 4, 1.1);
    check_picture("rgba.webp", 4, 1.1);
    check_picture("grey.pgm", 1, 0);
    check_picture("float-big-endian.tif", 1, 0);
    check_picture("tiled-half.exr", 3, 0.1);
}

static void check_values(const char *name, const int32_t *expected, int32_t count)
{
    pave_image *image = must_read(sample(name));
    for (int32_t i = 0; i < count; i++)
        if (fabs(pv_image_value(image, i) * 255 - expected[i]) > 1)
            fail_msg("%s: value %d is %g, not %d", name, i, pv_image_value(image, i) * 255, expected[i]);
    pave_image_free(&image);
}

static void reads_bilevel_palette_and_text(void **state)
{
    (void)state;
    const int32_t checker[] = { 0, 0, 0, 0, 255, 255, 255, 255, 0 };
    check_values("bilevel.png", checker, 9);
    check_values("bilevel-g4.tif", checker, 9);
    check_values("bilevel.pbm", (const int32_t[]){ 255, 255, 255, 255, 0 }, 5);
    check_values("ascii.pbm", (const int32_t[]){ 0, 255, 0, 255, 0, 255 }, 6);
    check_values("ascii.pgm", (const int32_t[]){ 0, 128, 255, 255, 128, 0 }, 6);
    check_values("palette.png", (const int32_t[]){ 255, 0, 0, 255, 0, 0, 255, 0, 0, 0, 255, 0 }, 12);
    check_values("palette-alpha.png",
                 (const int32_t[]){ 255, 0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255, 0, 255, 0, 128 }, 16);
    pave_image *image = must_read(sample("grey16.png"));
    assert_int_equal(image->type, PAVE_U16);
    for (int32_t i = 0; i < 24 * 16; i++)
        assert_int_equal(((uint16_t *)image->pixels)[i], i % 24 * 2000 + i / 24 * 7);
    pave_image_free(&image);
}

static void reads_windows_and_mixed_types(void **state)
{
    (void)state;
    pave_image *image = must_read(sample("window-zip.exr"));
    assert_int_equal(image->type, PAVE_F32);
    assert_string_equal(image->names[3], "Z");
    for (int32_t i = 0; i < 24 * 16; i++) {
        assert_true(fabs(pv_image_value(image, 4 * i) - i % 24 * 10 / 255.0) < 0.001);
        assert_true(pv_image_value(image, 4 * i + 3) == i % 24);
    }
    pave_image_free(&image);
    must_fail(sample("label-and-half.exr"), PAVE_ERR_UNSUPPORTED);
    must_fail(sample("short-chunk.exr"), PAVE_ERR_FORMAT);
}

static void clear_sentences(void **state)
{
    (void)state;
    must_fail(in_folder("absent.png"), PAVE_ERR_IO);
    assert_non_null(strstr(pave_context_message(context), "No such file"));
    must_fail(folder, PAVE_ERR_IO);
    assert_non_null(strstr(pave_context_message(context), "Is a directory"));
    must_fail("/dev/zero", PAVE_ERR_IO);
    assert_int_equal(mkfifo(in_folder("pipe.png"), 0600), 0);
    must_fail(in_folder("pipe.png"), PAVE_ERR_IO);
    close(open(in_folder("empty.png"), O_CREAT | O_WRONLY, 0600));
    must_fail(in_folder("empty.png"), PAVE_ERR_FORMAT);
    assert_non_null(strstr(pave_context_message(context), "is empty"));
    must_fail(sample("make.py"), PAVE_ERR_FORMAT);
    must_fail(sample("bad-filter.png"), PAVE_ERR_FORMAT);
    must_fail(sample("too-short.png"), PAVE_ERR_FORMAT);
    must_fail(sample("too-long.png"), PAVE_ERR_FORMAT);
    must_fail(sample("bomb.png"), PAVE_ERR_LIMIT);
}

static pave_context *with_limits(pave_limits limits)
{
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    pave_context *made;
    params.limits = &limits;
    assert_int_equal(pave_context_create(&params, &made), PAVE_OK);
    return made;
}

static void keeps_limits(void **state)
{
    (void)state;
    static const char *const names[] = { "rgba.png", "orientation-1.jpg", "rgb-lzw.tif", "rgb.ppm", "rgba.webp",
                                         "tiled-half.exr" };
    pave_context *usual = context;
    pave_limits few = PAVE_LIMITS_INIT, narrow = PAVE_LIMITS_INIT;
    few.max_pixels = 24 * 16 - 1;
    narrow.max_side = 23;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        for (int which = 0; which < 2; which++) {
            context = with_limits(which ? narrow : few);
            must_fail(sample(names[i]), PAVE_ERR_LIMIT);
            pave_context_free(&context);
        }
    context = usual;
}

/* What the process prints while hostile files are read. */
static int captured[2];
static FILE *capture;

static void begin_capture(void)
{
    capture = tmpfile();
    fflush(stdout);
    fflush(stderr);
    for (int i = 0; i < 2; i++) {
        captured[i] = dup(i + 1);
        dup2(fileno(capture), i + 1);
    }
}

static int64_t end_capture(void)
{
    struct stat info;
    fflush(stdout);
    fflush(stderr);
    for (int i = 0; i < 2; i++) {
        dup2(captured[i], i + 1);
        close(captured[i]);
    }
    fstat(fileno(capture), &info);
    fclose(capture);
    return info.st_size;
}

static const struct { const char *name; pave_result result; } verdicts[] = {
    { "png-decompression-dos.png", PAVE_OK },
    { "png-fuzz-sample-2.png", PAVE_OK },
    { "exr-heap-oob-2.exr", PAVE_ERR_UNSUPPORTED }, /* deep */
    { "exr-stack-oob.exr", PAVE_ERR_UNSUPPORTED },  /* B44 or PXR24 */
    { "jpeg-bomb-65500.jpg", PAVE_ERR_LIMIT },
    { "jpeg-corrupt-icc.jpg", PAVE_ERR_LIMIT },
};

static pave_result verdict(const char *name)
{
    for (size_t i = 0; i < sizeof verdicts / sizeof *verdicts; i++)
        if (!strcmp(verdicts[i].name, name))
            return verdicts[i].result;
    return PAVE_ERR_FORMAT;
}

static void read_hostile(const char *hostile, const char *name, char *wrong)
{
    char path[4400];
    pave_image *image;
    snprintf(path, sizeof path, "%s/%s", hostile, name);
    pave_result result = pave_image_read(context, path, &image);
    const char *text = pave_context_message(context);
    if (result != verdict(name) || (result && (!*text || strchr(text, '\n') || image)))
        snprintf(wrong, 2048, "%.1000s: %s: %.900s", path, pave_result_name(result), text);
    pave_image_free(&image);
}

static void hostile_files(void **state)
{
    (void)state;
    const char *shared = getenv("PAVE_SHARED");
    char hostile[4096], wrong[2048] = "";
    snprintf(hostile, sizeof hostile, "%s/data/hostile", shared ? shared : "");
    DIR *dir = shared ? opendir(hostile) : NULL;
    if (!dir) {
        print_message("skipped: PAVE_SHARED does not name a folder with data/hostile\n");
        skip();
    }
    begin_capture();
    for (struct dirent *entry; (entry = readdir(dir));)
        if (entry->d_name[0] != '.')
            read_hostile(hostile, entry->d_name, wrong);
    int64_t printed = end_capture();
    closedir(dir);
    if (*wrong)
        fail_msg("%s", wrong);
    assert_int_equal(printed, 0);
}

static uint64_t hash_of_image(const char *path)
{
    uint64_t hash = 0;
    pave_image *image = must_read(path), *drawing = NULL;
    pv_bitmap bitmap;
    assert_int_equal(pave_image_threshold(context, image, NULL, &drawing), PAVE_OK);
    assert_int_equal(pv_bitmap_create(context, drawing->width, drawing->height, drawing->levels ? 8 : 1, &bitmap),
                     PAVE_OK);
    bitmap.cut = drawing->cut;
    pv_bitmap_store(&bitmap, 0, 0, drawing);
    assert_int_equal(pv_bitmap_hash(context, &bitmap, &hash), PAVE_OK);
    pv_bitmap_free(&bitmap);
    pave_image_free(&drawing);
    pave_image_free(&image);
    return hash;
}

/* Every sample that can be read, part by part as a drawing and at once as an image, in memory and in a file. */
static void drawings_are_their_images(void **state)
{
    (void)state;
    int same = 0;
    DIR *dir = opendir(PAVE_TEST_DATA);
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));) {
        const pave_threshold_params threshold = PAVE_THRESHOLD_PARAMS_INIT;
        pv_room room = { 1 << 30, in_folder("drawing") };
        pv_bitmap bitmap;
        uint64_t hash = 0, again = 0;
        if (pv_drawing_read(context, sample(entry->d_name), &threshold, NULL, &room, &bitmap))
            continue; /* refused, or lying on its side */
        assert_non_null(bitmap.bits);
        assert_int_equal(pv_bitmap_hash(context, &bitmap, &hash), PAVE_OK);
        room.bytes = bitmap.stride * bitmap.height * 7;
        pv_bitmap_free(&bitmap);
        assert_true(hash == hash_of_image(sample(entry->d_name)));
        same++;
        pave_result result = pv_drawing_read(context, sample(entry->d_name), &threshold, NULL, &room, &bitmap);
        assert_true(result == PAVE_OK || result == PAVE_ERR_LIMIT); /* what is decoded at once does not fit */
        if (result)
            continue;
        assert_null(bitmap.bits);
        assert_int_equal(pv_bitmap_hash(context, &bitmap, &again), PAVE_OK);
        assert_true(hash == again);
        pv_bitmap_free(&bitmap);
    }
    closedir(dir);
    assert_true(same > 15);
}

/* Every sample cut short at many places and with flipped bytes: no crash, no word, a documented result. */
static void damaged_samples(void **state)
{
    (void)state;
    char bad[2048] = "";
    DIR *dir = opendir(PAVE_TEST_DATA);
    assert_non_null(dir);
    begin_capture();
    for (struct dirent *entry; (entry = readdir(dir)) && !*bad;) {
        uint8_t bytes[8192], copy[8192];
        FILE *file = fopen(sample(entry->d_name), "rb");
        size_t size = file ? fread(bytes, 1, sizeof bytes, file) : 0;
        if (file)
            fclose(file);
        for (uint32_t trial = 0; trial < 60 && size > 4; trial++) {
            pave_image *image;
            uint32_t h = (trial + 1) * 2654435761u;
            size_t length = trial % 2 ? size : 1 + (h >> 8) % size;
            memcpy(copy, bytes, size);
            if (trial % 2)
                copy[trial < 30 ? (h >> 8) % (size < 64 ? size : 64) : (h >> 8) % size] ^= (uint8_t)(1u << (h & 7));
            file = fopen(in_folder("damaged"), "wb");
            fwrite(copy, 1, length, file);
            fclose(file);
            pave_result result = pave_image_read(context, in_folder("damaged"), &image);
            if (result > 0 || result < PAVE_ERR_INTERNAL || result == PAVE_ERR_INTERNAL || (result && image))
                snprintf(bad, sizeof bad, "%s, trial %u: %d %.1500s", entry->d_name, trial, result,
                         pave_context_message(context));
            pave_image_free(&image);
            pv_bitmap bitmap;
            pv_room room = { 1 << 20, in_folder("drawing") };
            const pave_threshold_params threshold = PAVE_THRESHOLD_PARAMS_INIT;
            if (!pv_drawing_read(context, in_folder("damaged"), &threshold, NULL, &room, &bitmap))
                pv_bitmap_free(&bitmap);
        }
    }
    closedir(dir);
    int64_t printed = end_capture();
    if (*bad)
        fail_msg("%s", bad);
    assert_int_equal(printed, 0);
}

typedef pave_result job(pave_context *c, const char *path);

static pave_result reading_job(pave_context *c, const char *path)
{
    pave_image *image;
    pave_result result = pave_image_read(c, path, &image);
    pave_image_free(&image);
    return result;
}

static const pave_image *to_write;
static const pave_stones *stones_to_write;

static pave_result writing_job(pave_context *c, const char *path)
{
    return pave_image_write(c, to_write, path);
}

static pave_result stones_job(pave_context *c, const char *path)
{
    return pave_stones_write(c, stones_to_write, path, NULL);
}

static pave_result stones_reading_job(pave_context *c, const char *path)
{
    pave_stones *stones;
    pave_result result = pave_stones_read(c, path, &stones);
    pave_stones_free(&stones);
    return result;
}

static void sweep(job *work, const char *path)
{
    pave_result result = PAVE_ERR_MEMORY;
    for (long n = 1; result; n++) {
        failing f = { .fail_at = n, .for_good = 1 };
        pave_context_params params = failing_params(&f);
        pave_context *made;
        result = pave_context_create(&params, &made);
        if (!result)
            result = work(made, path);
        if (result && result != PAVE_ERR_MEMORY)
            fail_msg("%s, allocation %ld: %s: %s", path, n, pave_result_name(result), pave_context_message(made));
        pave_context_free(&made);
        if (f.blocks)
            fail_msg("%s, allocation %ld: %lld blocks leaked", path, n, (long long)f.blocks);
        assert_true(n < 1000);
    }
}

static pave_stones *make_stones(void)
{
    static int64_t starts[] = { 0, 4, 8, 11, 15 };
    static double vertices[] = { 1.25, 1, 1.25, 9.5, 9, 9.5, 9, 1, /**/ 10, 0, 10, 10, 20, 10, 20, 0,
                                 /**/ 0, 10.125, 5, 20, 10, 10.125, /**/ 10, 10, 10, 20, 20, 20, 20, 10 };
    static uint8_t colours[] = { 0, 255, 128, 0 };
    static int32_t sites[] = { 3, 5, 8, 13 };
    static pave_stones stones = { .width = 20, .height = 20, .plane_width = 20, .plane_height = 20, .count = 4,
                                  .starts = starts, .vertices = vertices,
                                  .colours = colours, .sites = sites, .cvd = PAVE_CVD_PARAMS_INIT,
                                  .params = PAVE_STONES_PARAMS_INIT, .field = PAVE_FIELD_PARAMS_INIT,
                                  .threshold = PAVE_THRESHOLD_PARAMS_INIT, .backend_name = "by \"hand\"" };
    stones.cvd.seed = UINT64_MAX;
    stones.report.size = sizeof stones.report;
    stones.report.sites = 5, stones.report.stones = 4, stones.report.lost = 1;
    stones.report.corners_after[3] = 1, stones.report.corners_after[4] = 3;
    stones.report.corners_before[31] = 4;
    return &stones;
}

static void survives_lack_of_memory(void **state)
{
    (void)state;
    static const char *const inputs[] = { "rgba.png", "orientation-6.jpg", "rgb-lzw.tif", "rgb.ppm", "rgba.webp",
                                          "tiled-half.exr", "window-zip.exr" };
    static const char *const outputs[] = { "m.png", "m.tif", "m.jpg", "m.exr" };
    static const char *const pavements[] = { "m.svg", "n.png", "m.json", "m.stones" };
    for (size_t i = 0; i < sizeof inputs / sizeof *inputs; i++)
        sweep(reading_job, sample(inputs[i]));
    pave_image *image = make(30, 40, 3, PAVE_U8, PAVE_DISPLAY, -1, NULL);
    to_write = image;
    stones_to_write = make_stones();
    begin_capture();
    for (size_t i = 0; i < sizeof outputs / sizeof *outputs; i++)
        sweep(writing_job, in_folder(outputs[i]));
    for (size_t i = 0; i < sizeof pavements / sizeof *pavements; i++)
        sweep(stones_job, in_folder(pavements[i]));
    sweep(stones_reading_job, in_folder("m.svg"));
    sweep(stones_reading_job, in_folder("m.stones"));
    assert_int_equal(end_capture(), 0);
    pave_image_free(&image);
}

static char *contents(const char *path)
{
    static char text[20000];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    return text;
}

static void writes_svg(void **state)
{
    (void)state;
    assert_int_equal(pave_stones_write(context, make_stones(), in_folder("a.SVG"), NULL), PAVE_OK);
    const char *text = contents(in_folder("a.SVG"));
    assert_non_null(strstr(text, "viewBox=\"0 0 20 20\""));
    assert_non_null(strstr(text, "<polygon id=\"s8\" points=\"0,10.125 5,20 10,10.125\"/>"));
    assert_non_null(strstr(text, "<g id=\"grey128\" fill=\"#808080\">"));
    assert_non_null(strstr(text, "<polygon id=\"s13\""));
    assert_true(strstr(text, "\"s13\"") < strstr(text, "\"s5\"")); /* black before white */
    assert_int_equal(pave_stones_write(context, make_stones(), in_folder("a.dxf"), NULL), PAVE_ERR_UNSUPPORTED);
    assert_int_equal(pave_stones_write(context, NULL, "a.svg", NULL), PAVE_ERR_ARGUMENT);
}

static void writes_picture(void **state)
{
    (void)state;
    assert_int_equal(pave_stones_write(context, make_stones(), in_folder("p.png"), NULL), PAVE_OK);
    pave_image *image = must_read(in_folder("p.png"));
    assert_int_equal(image->width, 20);
    const uint8_t *p = image->pixels;
    const uint8_t grout[3] = { 0x8C, 0x85, 0x79 }, black[3] = { 0x1F, 0x1D, 0x1B }, white[3] = { 0xF4, 0xF1, 0xEA };
    assert_memory_equal(p, grout, 3);
    assert_memory_equal(p + 3 * (5 * 20 + 5), black, 3);
    assert_memory_equal(p + 3 * (5 * 20 + 15), white, 3);
    double half = (pv_linear_light(0x1F / 255.0) + pv_linear_light(0x8C / 255.0)) / 2;
    assert_true(fabs(p[3 * (9 * 20 + 5)] - pv_display_code(half) * 255) <= 1); /* the stone ends at y = 9.5 */
    double most = pv_linear_light(0x1F / 255.0) * 0.75 + pv_linear_light(0x8C / 255.0) * 0.25;
    assert_true(fabs(p[3 * (5 * 20 + 1)] - pv_display_code(most) * 255) <= 1); /* and begins at x = 1.25 */
    pave_image_free(&image);
}

/* The area of each pixel that a random polygon covers, against the sum over the picture: the polygon's area. */
static void picture_keeps_areas(void **state)
{
    (void)state;
    uint32_t h = 1;
    for (int trial = 0; trial < 50; trial++) {
        double vertices[14], area = 0, sum = 0;
        int64_t starts[] = { 0, 7 };
        uint8_t colour = 255;
        int32_t site = 0;
        for (int i = 0; i < 7; i++) {
            double r = 20 + (double)((h = h * 1664525u + 1013904223u) >> 8) / 16777216 * 75, turn = i * 6.283185307 / 7;
            vertices[2 * i] = 100 + r * cos(turn);
            vertices[2 * i + 1] = 100 + r * sin(turn) * (trial % 2 ? 1 : -1);
        }
        for (int i = 0, j = 6; i < 7; j = i++)
            area += vertices[2 * j] * vertices[2 * i + 1] - vertices[2 * i] * vertices[2 * j + 1];
        pave_stones stones = { .width = 200, .height = 200, .count = 1, .starts = starts, .vertices = vertices,
                               .colours = &colour, .sites = &site };
        assert_int_equal(pave_stones_write(context, &stones, in_folder("q.png"), NULL), PAVE_OK);
        pave_image *image = must_read(in_folder("q.png"));
        double grout = pv_linear_light(0x8C / 255.0), light = pv_linear_light(0xF4 / 255.0);
        for (int64_t i = 0; i < 200 * 200; i++)
            sum += (pv_linear_light(pv_image_value(image, 3 * i)) - grout) / (light - grout);
        assert_true(fabs(sum - fabs(area) / 2) < 3);
        pave_image_free(&image);
    }
}

static void writes_report(void **state)
{
    (void)state;
    assert_int_equal(pave_stones_write(context, make_stones(), in_folder("r.json"), NULL), PAVE_OK);
    const char *text = contents(in_folder("r.json"));
    assert_non_null(strstr(text, "\"seed\": \"18446744073709551615\""));
    assert_non_null(strstr(text, "\"backend\": \"by \\\"hand\\\"\""));
    assert_non_null(strstr(text, "\"31+\": 4"));
    assert_non_null(strstr(text, "\"quads\": 0.75"));
    assert_non_null(strstr(text, "\"metric\": \"chamfer\""));
    assert_non_null(strstr(text, "\"OpenEXR\": \"3."));
    assert_true(text[strlen(text) - 2] == '}');
}

static void collect(void *user, const char *text, size_t length)
{
    strncat(user, text, length);
}

static void json_escapes(void **state)
{
    (void)state;
    char text[400] = "";
    pv_json json;
    pv_json_begin(&json, collect, text);
    pv_json_array(&json, NULL);
    pv_json_string(&json, NULL, "a\"\\\n\x01\x7F\xC3\xA9\xFF\xE2\x82\xAC\xC0\xAF");
    pv_json_number(&json, NULL, NAN);
    pv_json_number(&json, NULL, -0.25);
    pv_json_whole(&json, NULL, INT64_MIN);
    pv_json_unsigned(&json, NULL, (uint64_t)1 << 53);
    pv_json_unsigned(&json, NULL, ((uint64_t)1 << 53) + 1);
    pv_json_close(&json);
    assert_string_equal(text, "[\"a\\\"\\\\\\u000a\\u0001\\u007f\xC3\xA9\xEF\xBF\xBD\xE2\x82\xAC\xEF\xBF\xBD"
                              "\xEF\xBF\xBD\", null, -0.25, -9223372036854775808, 9007199254740992, "
                              "\"9007199254740993\"]\n");
}

/* OpenEXR takes a chunk of the length of its pixels for bare ones: a packed one of that length must not be written. */
static void chunks_that_pack_to_their_own_length_come_back(void **state)
{
    (void)state;
    pave_image *image = make(8, 8, 3, PAVE_F16, PAVE_DATA, -1, "a,b,c");
    uint16_t *pixels = image->pixels;
    for (uint32_t which = 0; which < 600; which++) {
        for (uint32_t i = 0; i < 192; i++) { /* more and more of them by chance: longer and longer packed */
            uint32_t word = pv_draw(which, 97, i, 0, 0).word[0];
            pixels[i] = (uint16_t)(i < which % 192 ? word % 0x7C00 : 0x3000 + (word & 255));
        }
        assert_int_equal(pave_image_write(context, image, in_folder("chunk.exr")), PAVE_OK);
        pave_image *back = must_read(in_folder("chunk.exr"));
        assert_memory_equal(back->pixels, pixels, 384);
        pave_image_free(&back);
    }
    pave_image_free(&image);
}

static void halves_round(void **state)
{
    (void)state;
    for (uint32_t h = 0; h < 65536; h++)
        if (!isnan(pv_half_value((uint16_t)h)))
            assert_int_equal(pv_half(pv_half_value((uint16_t)h)), h);
    assert_int_equal(pv_half(NAN) & 0x7C00, 0x7C00);
    assert_int_equal(pv_half(65519.0f), 0x7BFF);
    assert_int_equal(pv_half(65520.0f), 0x7C00);
    assert_int_equal(pv_half(1.00048828125f), 0x3C00); /* a tie goes to even */
}

static void all_kinds(const char *path_of_kind(const char *kind), pave_result expected)
{
    static const char *const kinds[] = { ".svg", ".json", ".png", ".exr", ".tif", ".jpg" };
    pave_image *image = make(300, 300, 3, PAVE_U8, PAVE_DISPLAY, -1, NULL);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        const char *path = path_of_kind(kinds[i]);
        pave_result result = i < 2 ? pave_stones_write(context, make_stones(), path, NULL)
                                   : pave_image_write(context, image, path);
        if (result != expected)
            fail_msg("%s: %s: %s", path, pave_result_name(result), pave_context_message(context));
        if (result)
            assert_non_null(strstr(pave_context_message(context), "cannot be written: "));
    }
    pave_image_free(&image);
}

static const char *in_no_folder(const char *kind)
{
    static char path[100];
    snprintf(path, sizeof path, "%s/no/such%s", folder, kind);
    return path;
}

static const char *at_full_device(const char *kind)
{
    static char path[100];
    snprintf(path, sizeof path, "%s/full%s", folder, kind);
    unlink(path);
    assert_int_equal(symlink("/dev/full", path), 0);
    return path;
}

static const char *at_null_device(const char *kind)
{
    static char path[100];
    snprintf(path, sizeof path, "%s/null%s", folder, kind);
    unlink(path);
    assert_int_equal(symlink("/dev/null", path), 0);
    return path;
}

static const char *at_folder(const char *kind)
{
    static char path[100];
    snprintf(path, sizeof path, "%s/dir%s", folder, kind);
    rmdir(path);
    assert_int_equal(mkdir(path, 0700), 0);
    return path;
}

static void write_errors(void **state)
{
    (void)state;
    begin_capture();
    all_kinds(in_no_folder, PAVE_ERR_IO);
    all_kinds(at_full_device, PAVE_ERR_IO);
    assert_non_null(strstr(pave_context_message(context), "No space left on device"));
    all_kinds(at_null_device, PAVE_OK);
    all_kinds(at_folder, PAVE_ERR_IO);
    assert_int_equal(end_capture(), 0);
    static const char *const kinds[] = { ".svg", ".json", ".png", ".exr", ".tif", ".jpg" };
    for (size_t i = 0; i < 6; i++) {
        char path[100];
        snprintf(path, sizeof path, "%s/dir%s", folder, kinds[i]);
        rmdir(path);
    }
}

static void leaves_errno(void **state)
{
    (void)state;
    pave_image *image;
    errno = 1234;
    pave_image_read(context, in_folder("absent.png"), &image);
    assert_int_equal(errno, 1234);
    pave_stones_write(context, make_stones(), in_no_folder(".svg"), NULL);
    assert_int_equal(errno, 1234);
    pave_stones_write(context, make_stones(), in_folder("e.svg"), NULL);
    assert_int_equal(errno, 1234);
}

static void put_text(const char *path, const char *text, mode_t mode)
{
    FILE *file = fopen(path, "wb");
    fputs(text, file);
    fclose(file);
    chmod(path, mode);
}

static int32_t stop(void *user, const char *stage, double done)
{
    (void)user;
    (void)stage;
    return done >= 0.1;
}

/* Cancelled in the middle, or out of memory: the old file stays as it was. */
static void old_file_stays(void **state)
{
    (void)state;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    params.progress = stop;
    pave_context *stopping;
    assert_int_equal(pave_context_create(&params, &stopping), PAVE_OK);
    pave_image *image = make(1000, 3000, 3, PAVE_U8, PAVE_DISPLAY, -1, NULL);
    static const char *const names[] = { "old.png", "old.exr", "old.tif", "blank.png", "old.jpg" };
    begin_capture();
    for (size_t i = 0; i < 5; i++) {
        if (i == 3)
            memset(image->pixels, 0, 1000 * 3000 * 3);
        put_text(in_folder(names[i]), "old", 0640);
        assert_int_equal(pave_image_write(stopping, image, in_folder(names[i])), PAVE_ERR_CANCELLED);
        assert_string_equal(contents(in_folder(names[i])), "old");
    }
    assert_int_equal(end_capture(), 0);
    pave_image_free(&image);
    pave_context_free(&stopping);
}

static void replaces_and_keeps_modes_and_links(void **state)
{
    (void)state;
    struct stat info;
    mode_t before = umask(027);
    assert_int_equal(pave_stones_write(context, make_stones(), in_folder("new.svg"), NULL), PAVE_OK);
    umask(before);
    stat(in_folder("new.svg"), &info);
    assert_int_equal(info.st_mode & 0777, 0640);
    put_text(in_folder("was.svg"), "old", 0604);
    assert_int_equal(symlink("was.svg", in_folder("link.svg")), 0);
    assert_int_equal(symlink("yet.svg", in_folder("dangling.svg")), 0);
    assert_int_equal(pave_stones_write(context, make_stones(), in_folder("link.svg"), NULL), PAVE_OK);
    assert_int_equal(pave_stones_write(context, make_stones(), in_folder("dangling.svg"), NULL), PAVE_OK);
    lstat(in_folder("link.svg"), &info);
    assert_true(S_ISLNK(info.st_mode));
    stat(in_folder("was.svg"), &info);
    assert_int_equal(info.st_mode & 0777, 0604);
    assert_true(info.st_size > 100);
    stat(in_folder("yet.svg"), &info);
    assert_true(S_ISREG(info.st_mode));
    assert_int_equal(symlink("loop.svg", in_folder("loop.svg")), 0);
    assert_int_equal(pave_stones_write(context, make_stones(), in_folder("loop.svg"), NULL), PAVE_ERR_IO);
}

/* All bytes reach a pipe, also of formats that go back to fill in what they left open. */
static void pipes(void **state)
{
    (void)state;
    static const char *const names[] = { "to.exr", "to.tif", "to.png" };
    pave_image *image = make(20, 30, 3, PAVE_U8, PAVE_DISPLAY, -1, NULL);
    for (size_t i = 0; i < 3; i++) {
        char link[100], target[64], bytes[20000];
        int ends[2];
        assert_int_equal(pipe(ends), 0);
        snprintf(target, sizeof target, "/proc/self/fd/%d", ends[1]);
        snprintf(link, sizeof link, "%s", in_folder(names[i]));
        assert_int_equal(symlink(target, link), 0);
        if (pave_image_write(context, image, link))
            fail_msg("%s", pave_context_message(context));
        ssize_t size = read(ends[0], bytes, sizeof bytes);
        close(ends[0]), close(ends[1]);
        unlink(link);
        assert_int_equal(pave_image_write(context, image, link), PAVE_OK);
        FILE *file = fopen(link, "rb");
        char expected[20000];
        assert_int_equal(fread(expected, 1, sizeof expected, file), size);
        fclose(file);
        assert_memory_equal(bytes, expected, (size_t)size);
    }
    pave_image_free(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exr_round_trips),
        cmocka_unit_test(exr_converts),
        cmocka_unit_test(png_and_tiff_round_trips),
        cmocka_unit_test(png_of_light_is_coded),
        cmocka_unit_test(refuses_what_a_format_cannot_hold),
        cmocka_unit_test(reads_pictures),
        cmocka_unit_test(reads_bilevel_palette_and_text),
        cmocka_unit_test(reads_windows_and_mixed_types),
        cmocka_unit_test(clear_sentences),
        cmocka_unit_test(keeps_limits),
        cmocka_unit_test(hostile_files),
        cmocka_unit_test(drawings_are_their_images),
        cmocka_unit_test(damaged_samples),
        cmocka_unit_test(survives_lack_of_memory),
        cmocka_unit_test(writes_svg),
        cmocka_unit_test(writes_picture),
        cmocka_unit_test(picture_keeps_areas),
        cmocka_unit_test(writes_report),
        cmocka_unit_test(json_escapes),
        cmocka_unit_test(chunks_that_pack_to_their_own_length_come_back),
        cmocka_unit_test(halves_round),
        cmocka_unit_test(write_errors),
        cmocka_unit_test(leaves_errno),
        cmocka_unit_test(old_file_stays),
        cmocka_unit_test(replaces_and_keeps_modes_and_links),
        cmocka_unit_test(pipes),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
