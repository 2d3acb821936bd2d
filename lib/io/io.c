/* Files in and out: which format, and who does it. */
#include <pave/io.h>

#include "io/drawing.h"
#include "io/exr.h"
#include "io/output.h"
#include "io/pavement.h"
#include "io/raster.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static pave_result unreadable(pave_context *context, const char *path, int error)
{
    return pv_fail(context, PAVE_ERR_IO, "%s: cannot be read: %s", path, pv_system_error(error));
}

/* Not blocking, for a pipe would wait for a writer before it can be refused. */
static pave_result open_file(pave_context *context, const char *path, int *file, int64_t *size)
{
    struct stat info;
    *file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (*file < 0 || fstat(*file, &info))
        return unreadable(context, path, errno);
    if (S_ISDIR(info.st_mode))
        return unreadable(context, path, EISDIR);
    if (!S_ISREG(info.st_mode))
        return pv_fail(context, PAVE_ERR_IO, "%s: cannot be read: it is a device or a pipe", path);
    if (!info.st_size)
        return pv_fail(context, PAVE_ERR_FORMAT, "%s: is empty", path);
    *size = info.st_size;
    return PAVE_OK;
}

static pave_result read_whole(pave_context *context, const char *path, int file, size_t size, uint8_t *bytes)
{
    for (size_t done = 0; done < size;) {
        ssize_t n = read(file, bytes + done, size - done < 1 << 24 ? size - done : 1 << 24);
        if (n < 0 && errno != EINTR)
            return unreadable(context, path, errno);
        if (n == 0)
            return pv_fail(context, PAVE_ERR_IO, "%s: cannot be read: it became shorter meanwhile", path);
        done += n > 0 ? (size_t)n : 0;
        pave_result result = pv_progress(context, 0);
        if (result)
            return result;
    }
    return PAVE_OK;
}

/* What a file is read as: an image, or else a drawing. */
typedef struct reading {
    pave_image **image;
    const pave_threshold_params *threshold;
    pv_bitmap *drawing;
} reading;

static pave_result read_raster(pave_context *context, const char *path, int file, int64_t size, const reading *as)
{
    pave_result result = PAVE_OK;
    uint8_t *bytes = pv_allocate(context, (size_t)size, 1, &result);
    if (!result)
        result = read_whole(context, path, file, (size_t)size, bytes);
    if (!result)
        result = as->image ? pv_raster_read(context, path, bytes, (size_t)size, as->image)
                           : pv_raster_read_drawing(context, path, bytes, (size_t)size, as->threshold, as->drawing);
    pv_release(bytes);
    return result;
}

static pave_result read_exr(pave_context *context, const char *path, int file, int64_t size, const reading *as)
{
    pave_image *image = NULL, *drawing = NULL;
    pave_result result = pv_exr_read(context, path, file, size, as->image ? as->image : &image);
    if (result || as->image)
        return result;
    result = pave_image_threshold(context, image, as->threshold, &drawing);
    pave_image_free(&image);
    if (!result)
        result = pv_bitmap_create(context, drawing->width, drawing->height, as->drawing);
    if (!result)
        pv_bitmap_store(as->drawing, 0, drawing);
    pave_image_free(&drawing);
    return result;
}

static pave_result read_file(pave_context *context, const char *path, const reading *as)
{
    int file;
    int64_t size = 0;
    uint8_t magic[4] = { 0 };
    pave_result result = open_file(context, path, &file, &size);
    if (!result && pread(file, magic, sizeof magic, 0) < 0)
        result = unreadable(context, path, errno);
    if (!result)
        result = !memcmp(magic, "\x76\x2F\x31\x01", 4) ? read_exr(context, path, file, size, as)
                                                        : read_raster(context, path, file, size, as);
    if (file >= 0)
        close(file);
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
    reading as = { .image = out };
    pv_call outer = pv_call_begin(context, "read", 0, 1);
    pave_result result = read_file(context, path, &as);
    if (result)
        pave_image_free(out);
    pv_call_end(context, outer);
    errno = before;
    return result;
}

pave_result pv_drawing_read(pave_context *context, const char *path, const pave_threshold_params *threshold,
                            pv_bitmap *out)
{
    int before = errno;
    reading as = { .threshold = threshold, .drawing = out };
    out->bits = NULL;
    pv_call outer = pv_call_begin(context, "read", 0, 1);
    pave_result result = read_file(context, path, &as);
    if (result)
        pv_bitmap_free(out);
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
    return pv_report_write(context, &pile->head, path);
}

static const struct { const char *ending; pile_writer *write; } stones_formats[] = {
    { ".svg", pv_svg_write },
    { ".png", write_preview },
    { ".json", write_report },
    { ".stones", pv_stones_file_write },
};

/* Case does not matter, and neither does what the locale says about it. */
static int ends_with(const char *path, const char *ending)
{
    size_t length = strlen(path), n = strlen(ending);
    if (length < n)
        return 0;
    for (path += length - n; *path; path++, ending++)
        if ((*path >= 'A' && *path <= 'Z' ? *path + 32 : *path) != *ending)
            return 0;
    return 1;
}

static pave_result write_image(pave_context *context, const pave_image *image, const char *path)
{
    for (size_t i = 0; i < sizeof image_formats / sizeof *image_formats; i++)
        if (ends_with(path, image_formats[i].ending))
            return image_formats[i].write(context, image, path, image_formats[i].format);
    return pv_fail(context, PAVE_ERR_UNSUPPORTED,
                   "%s: an image is written as .exr, .png, .tif, .tiff, .jpg or .jpeg, by the ending of its name",
                   path);
}

const char *pave_stones_format(const char *path)
{
    for (size_t i = 0; path && i < sizeof stones_formats / sizeof *stones_formats; i++)
        if (ends_with(path, stones_formats[i].ending))
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
