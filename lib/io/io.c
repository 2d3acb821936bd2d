/* Files in and out: which format, and who does it. */
#include <pave/io.h>

#include "io/drawing.h"
#include "io/exr.h"
#include "io/output.h"
#include "io/pavement.h"
#include "io/radiance.h"
#include "io/raster.h"
#include "util/text.h"

#include <errno.h>
#include <string.h>

pave_result pv_image_read_input(pave_context *context, pv_input *input, const pv_target *target)
{
    uint8_t magic[16] = { 0 };
    pave_result result = pv_input_read(input, 0, magic, input->size < 16 ? input->size : 16);
    if (result)
        return result;
    return !memcmp(magic, "\x76\x2F\x31\x01", 4)   ? pv_exr_read(context, input, target)
           : pv_is_radiance(magic, sizeof magic) ? pv_radiance_read(context, input, target)
                                                 : pv_raster_read(context, input, target);
}

static pave_result read_file(pave_context *context, const char *path, const pv_target *target)
{
    pv_input input;
    pave_result result = pv_input_open(context, path, &input);
    if (!result)
        result = pv_image_read_input(context, &input, target);
    if (!result)
        result = pv_input_unchanged(&input);
    pv_input_close(&input);
    return result ? result : pv_progress(context, 1);
}

pave_result pave_image_read(pave_context *context, const char *path, pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!path || !out)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_image_read: path or out is NULL");
    int before = errno;
    pv_target target = { .image = out };
    pv_call outer = pv_call_begin(context, "read", 0, 1);
    pave_result result = read_file(context, path, &target);
    if (result)
        pave_image_free(out);
    pv_call_end(context, outer);
    errno = before;
    return result;
}

pave_result pv_drawing_read(pave_context *context, const char *path, const pave_threshold_params *threshold,
                            const pave_palette *palette, const pv_room *room, pv_bitmap *out)
{
    int before = errno;
    pv_codebook *book = NULL;
    *out = (pv_bitmap){ .file = -1 };
    pv_call outer = pv_call_begin(context, "read", 0, 1);
    pave_result result = palette && palette->count ? pv_codebook_create(context, palette, &book) : PAVE_OK;
    pv_target target = { .threshold = threshold, .book = book, .room = room, .drawing = out };
    if (!result)
        result = read_file(context, path, &target);
    if (result)
        pv_bitmap_free(out);
    pv_release(book);
    pv_call_end(context, outer);
    errno = before;
    return result;
}

pave_result pv_palette_read(pave_context *context, const char *path, int32_t colours, const pv_room *room,
                            pave_palette *out)
{
    int before = errno;
    pv_histogram *histogram = NULL;
    pv_call outer = pv_call_begin(context, "read", 0, 1);
    pave_result result = pv_histogram_create(context, &histogram);
    pv_target target = { .histogram = histogram, .room = room };
    if (!result)
        result = read_file(context, path, &target);
    if (!result)
        result = pv_histogram_palette(context, histogram, colours, out);
    pv_histogram_free(histogram);
    pv_call_end(context, outer);
    errno = before;
    return result;
}

typedef pave_result image_writer(pave_context *context, const pave_image *image, const char *path, const char *format);
typedef pave_result pile_writer(pave_context *context, pv_pile *pile, const char *path);

static pave_result write_exr(pave_context *context, const pave_image *image, const char *path, const char *format)
{
    (void)format;
    return pv_exr_write(context, image, path);
}

static const struct { const char *ending, *format; image_writer *write; } image_formats[] = {
    { ".exr", NULL, write_exr },
    { ".png", "png", pv_raster_write },
    { ".tif", "tiff", pv_raster_write },
    { ".tiff", "tiff", pv_raster_write },
    { ".jpg", "jpeg", pv_raster_write },
    { ".jpeg", "jpeg", pv_raster_write },
};

static pave_result write_preview(pave_context *context, pv_pile *pile, const char *path)
{
    if (pile->head.count && !pile->head.vertices)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: a picture is made of stones in memory", path);
    return pv_preview_write(context, &pile->head, path);
}

static pave_result write_report(pave_context *context, pv_pile *pile, const char *path)
{
    return pv_report_write(context, pile, path);
}

static const struct { const char *ending; pile_writer *write; } stones_formats[] = {
    { ".svg", pv_svg_write },
    { ".png", write_preview },
    { ".json", write_report },
    { ".stones", pv_stones_file_write },
};

static pave_result write_image(pave_context *context, const pave_image *image, const char *path)
{
    for (size_t i = 0; i < sizeof image_formats / sizeof *image_formats; i++)
        if (pv_text_ends_with(path, image_formats[i].ending))
            return image_formats[i].write(context, image, path, image_formats[i].format);
    return pv_fail(context, PAVE_ERR_UNSUPPORTED,
                   "%s: an image is written as .exr, .png, .tif, .tiff, .jpg or .jpeg, by the ending of its name",
                   path);
}

const char *pave_stones_format(const char *path)
{
    for (size_t i = 0; path && i < sizeof stones_formats / sizeof *stones_formats; i++)
        if (pv_text_ends_with(path, stones_formats[i].ending))
            return stones_formats[i].ending + 1;
    return path && !strcmp(path, "-") ? "svg" : NULL;
}

static pave_result write_pile(pave_context *context, pv_pile *pile, const char *path, const char *format)
{
    format = format ? format : pave_stones_format(path);
    for (size_t i = 0; format && i < sizeof stones_formats / sizeof *stones_formats; i++)
        if (!strcmp(format, stones_formats[i].ending + 1))
            return stones_formats[i].write(context, pile, path);
    return pv_fail(context, PAVE_ERR_UNSUPPORTED,
                   "%s: stones are written as .svg, .png, .json or .stones, by the ending of the name", path);
}

pave_result pave_image_write(pave_context *context, const pave_image *image, const char *path)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!image || !path)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_image_write: image or path is NULL");
    int before = errno;
    pv_call outer = pv_call_begin(context, "write", 0, 1);
    pave_result result = write_image(context, image, path);
    pv_call_end(context, outer);
    errno = before;
    return result;
}

pave_result pave_stones_write(pave_context *context, const pave_stones *stones, const char *path,
                              const char *format)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!stones || !path)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_stones_write: stones or path is NULL");
    int before = errno;
    pv_pile pile;
    pv_call outer = pv_call_begin(context, "write", 0, 1);
    pave_result result = pv_pile_of(context, stones, &pile);
    if (!result)
        result = write_pile(context, &pile, path, format);
    pv_pile_close(&pile);
    pv_call_end(context, outer);
    errno = before;
    return result;
}

pave_result pave_stones_merge(pave_context *context, const char *const *paths, int32_t count, const char *path,
                              const char *format)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!paths || count < 1 || !path)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_stones_merge: no files to merge");
    int before = errno;
    pv_pile pile;
    pv_call outer = pv_call_begin(context, "merge", 0, 1);
    pave_result result = pv_pile_open(context, paths, count, &pile);
    if (!result) {
        result = write_pile(context, &pile, path, format);
        pv_pile_close(&pile);
    }
    pv_call_end(context, outer);
    errno = before;
    return result;
}
