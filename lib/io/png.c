/* PNG through libpng: vetted files to pixels, row after row, and back. */
#include "base/context.h"
#include "io/codec.h"

#include <png.h>
#include <stdio.h>
#include <string.h>

struct pv_codec_job {
    pave_context *context;
    png_struct *png;
    png_info *info;
    pv_codec_file file;
    pv_codec_sink sink;
    void *user;
    int64_t at; /* in the file */
    int32_t height, interlaced;
    size_t row_bytes;
    uint8_t *whole; /* the picture, if it is interlaced and was begun */
    pave_result memory;
    char *text; /* for the reason of a failure in the call under way */
};

/* libpng's way out of everything is a jump to where the call began. */
static void fail(png_struct *png, const char *message)
{
    pv_codec_job *job = png_get_error_ptr(png);
    snprintf(job->text, PV_CODEC_TEXT, "%s", job->memory ? "" : message);
    png_longjmp(png, 1);
}

static void stay_silent(png_struct *png, const char *message)
{
    (void)png, (void)message;
}

static void *take(png_struct *png, png_alloc_size_t size)
{
    pv_codec_job *job = png_get_mem_ptr(png);
    return pv_allocate(job->context, size, 1, &job->memory);
}

static void give_back(png_struct *png, void *bytes)
{
    (void)png;
    pv_release(bytes);
}

static void pull(png_struct *png, uint8_t *bytes, size_t size)
{
    pv_codec_job *job = png_get_io_ptr(png);
    const pv_codec_file *file = &job->file;
    if (job->at + (int64_t)size > (int64_t)file->size)
        png_error(png, "the file ends too early");
    if (file->bytes)
        memcpy(bytes, (const uint8_t *)file->bytes + job->at, size);
    else if (!file->read(file->user, job->at, bytes, size))
        png_error(png, "the file cannot be read");
    job->at += (int64_t)size;
}

static void push(png_struct *png, uint8_t *bytes, size_t size)
{
    pv_codec_job *job = png_get_io_ptr(png);
    if (!job->sink(job->user, job->at, bytes, size))
        png_error(png, "the file cannot be written");
    job->at += (int64_t)size;
}

static void flush(png_struct *png)
{
    (void)png;
}

static int is_little_endian(void)
{
    const uint16_t one = 1;
    return *(const uint8_t *)&one;
}

static void close_job(pv_codec_job *job)
{
    if (job->sink)
        png_destroy_write_struct(&job->png, &job->info);
    else
        png_destroy_read_struct(&job->png, &job->info, NULL);
    pv_release(job->whole);
    pv_release(job);
}

static pave_result failed(const pv_codec_job *job, pave_result otherwise)
{
    return job->memory ? job->memory : otherwise;
}

static pave_result begin(pave_context *context, const pv_codec_job *from, char *text, pv_codec_job **out)
{
    pave_result result = PAVE_OK;
    pv_codec_job *job = *out = pv_allocate(context, 1, sizeof *job, &result);
    *text = 0;
    if (!job)
        return result;
    *job = *from;
    job->context = context;
    job->text = text;
    job->png = (job->sink ? png_create_write_struct_2 : png_create_read_struct_2)(
        PNG_LIBPNG_VER_STRING, job, fail, stay_silent, job, take, give_back);
    if (job->png)
        job->info = png_create_info_struct(job->png);
    if (job->info)
        return PAVE_OK;
    result = failed(job, PAVE_ERR_MEMORY);
    close_job(job);
    *out = NULL;
    return result;
}

/* Whole bytes or pairs of them; colours instead of places in a palette; alpha where a colour is transparent. */
static void read_head(pv_codec_job *job, pv_picture *picture)
{
    static const char *const names[] = { "", "Y", "Y,A", "R,G,B", "R,G,B,A" };
    png_struct *png = job->png;
    png_set_read_fn(png, job, pull);
    png_read_info(png, job->info);
    png_set_expand(png);
    if (is_little_endian())
        png_set_swap(png);
    job->interlaced = png_set_interlace_handling(png) > 1;
    png_read_update_info(png, job->info);
    job->height = (int32_t)png_get_image_height(png, job->info);
    job->row_bytes = png_get_rowbytes(png, job->info);
    memset(picture, 0, sizeof *picture);
    picture->columns = picture->width = (int32_t)png_get_image_width(png, job->info);
    picture->height = job->height;
    picture->rows = 1;
    picture->channels = png_get_channels(png, job->info);
    picture->type = png_get_bit_depth(png, job->info) > 8 ? PAVE_U16 : PAVE_U8;
    picture->alpha = picture->channels % 2 ? -1 : picture->channels - 1;
    snprintf(picture->names, sizeof picture->names, "%s", names[picture->channels]);
}

static pave_result decode(pave_context *context, const char *format, const pv_codec_file *file, pv_picture *picture,
                          pv_codec_job **out, char *text)
{
    pv_codec_job from = { .file = *file };
    pave_result result = begin(context, &from, text, out);
    (void)format;
    if (result)
        return result;
    if (setjmp(png_jmpbuf((*out)->png))) {
        result = failed(*out, PAVE_ERR_FORMAT);
        close_job(*out);
        *out = NULL;
        return result;
    }
    read_head(*out, picture);
    return PAVE_OK;
}

/* Interlaced pictures come whole. */
static void read_whole(pv_codec_job *job)
{
    job->whole = pv_allocate(job->context, (size_t)job->height, job->row_bytes, &job->memory);
    if (!job->whole)
        png_error(job->png, "");
    for (int pass = 0; pass < PNG_INTERLACE_ADAM7_PASSES; pass++)
        for (int32_t y = 0; y < job->height; y++)
            png_read_row(job->png, job->whole + (size_t)y * job->row_bytes, NULL);
}

static pave_result read_rows(pv_codec_job *job, int32_t x, int32_t y, int32_t width, int32_t height, void *pixels,
                             char *text)
{
    (void)x, (void)width;
    job->text = text;
    *text = 0;
    if (setjmp(png_jmpbuf(job->png)))
        return failed(job, PAVE_ERR_FORMAT);
    if (job->interlaced && !job->whole)
        read_whole(job);
    if (job->whole)
        memcpy(pixels, job->whole + (size_t)y * job->row_bytes, (size_t)height * job->row_bytes);
    else
        for (int32_t i = 0; i < height; i++)
            png_read_row(job->png, (uint8_t *)pixels + (size_t)i * job->row_bytes, NULL);
    return PAVE_OK;
}

static void write_head(pv_codec_job *job, const pv_picture *picture)
{
    static const int colours[] = { 0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                   PNG_COLOR_TYPE_RGB_ALPHA };
    int bytes = picture->type == PAVE_U16 ? 2 : 1;
    job->height = picture->height;
    job->row_bytes = (size_t)picture->width * (size_t)picture->channels * (size_t)bytes;
    png_set_write_fn(job->png, job, push, flush);
    png_set_IHDR(job->png, job->info, (uint32_t)picture->width, (uint32_t)picture->height, 8 * bytes,
                 colours[picture->channels], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
    if (!picture->linear)
        png_set_sRGB(job->png, job->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(job->png, job->info);
    if (is_little_endian())
        png_set_swap(job->png);
}

static pave_result encode(pave_context *context, const char *format, const pv_picture *picture, pv_codec_sink sink,
                          void *user, pv_codec_job **out, char *text)
{
    pv_codec_job from = { .sink = sink, .user = user };
    pave_result result = begin(context, &from, text, out);
    (void)format;
    if (result)
        return result;
    if (setjmp(png_jmpbuf((*out)->png))) {
        result = failed(*out, PAVE_ERR_IO);
        close_job(*out);
        *out = NULL;
        return result;
    }
    write_head(*out, picture);
    return PAVE_OK;
}

static pave_result write_rows(pv_codec_job *job, int32_t from, int32_t to, const void *pixels, char *text)
{
    job->text = text;
    *text = 0;
    if (setjmp(png_jmpbuf(job->png)))
        return failed(job, PAVE_ERR_IO);
    for (int32_t y = from; y < to; y++)
        png_write_row(job->png, (const uint8_t *)pixels + (size_t)(y - from) * job->row_bytes);
    return PAVE_OK;
}

static pave_result finish(pv_codec_job *job, char *text)
{
    job->text = text;
    *text = 0;
    if (setjmp(png_jmpbuf(job->png)))
        return failed(job, PAVE_ERR_IO);
    png_write_end(job->png, NULL);
    return PAVE_OK;
}

const pv_codec pv_png = { decode, read_rows, encode, write_rows, finish, close_job };
