/* JPEG through libjpeg: vetted files of grey or colour to pixels, row after row, and back. */
#include "base/context.h"
#include "io/codec.h"

#include <setjmp.h>
#include <stdio.h>
#include <string.h>

#include <jerror.h>
#include <jpeglib.h>

enum { QUALITY = 92, BUFFER = 1 << 16 };

typedef struct receiver {
    struct jpeg_destination_mgr base; /* first: libjpeg knows this part only */
    pv_codec_sink sink;
    void *user;
    int64_t at;
    uint8_t bytes[BUFFER];
} receiver;

/* libjpeg's way out of everything is a jump to where the call began. */
typedef struct complaint {
    struct jpeg_error_mgr base; /* first, too */
    jmp_buf back;
    char *text;
} complaint;

struct pv_codec_job {
    struct jpeg_decompress_struct in;
    struct jpeg_compress_struct out;
    complaint complaint;
    receiver receiver;
    size_t row_bytes;
};

static void fail(j_common_ptr jpeg)
{
    complaint *c = (complaint *)jpeg->err;
    char message[JMSG_LENGTH_MAX];
    c->base.format_message(jpeg, message);
    snprintf(c->text, PV_CODEC_TEXT, "%s", message);
    longjmp(c->back, 1);
}

/* libjpeg goes on after damage, with a warning; a few are harmless. */
static void weigh(j_common_ptr jpeg, int level)
{
    int code = jpeg->err->msg_code;
    if (level < 0 && code != JWRN_EXTRANEOUS_DATA && code != JWRN_ADOBE_XFORM && code != JWRN_NOT_SEQUENTIAL)
        fail(jpeg);
}

static void stay_silent(j_common_ptr jpeg)
{
    (void)jpeg;
}

static pave_result begin(pave_context *context, char *text, pv_codec_job **out)
{
    pave_result result = PAVE_OK;
    pv_codec_job *job = *out = pv_allocate_zeroed(context, 1, sizeof *job, &result);
    *text = 0;
    if (!job)
        return result;
    job->in.err = job->out.err = jpeg_std_error(&job->complaint.base);
    job->complaint.base.error_exit = fail;
    job->complaint.base.emit_message = weigh;
    job->complaint.base.output_message = stay_silent;
    job->complaint.text = text;
    return PAVE_OK;
}

static void close_job(pv_codec_job *job)
{
    jpeg_destroy_decompress(&job->in);
    jpeg_destroy_compress(&job->out);
    pv_release(job);
}

static pave_result give_up(pv_codec_job **job, pave_result result)
{
    close_job(*job);
    *job = NULL;
    return result;
}

static void read_head(pv_codec_job *job, const pv_codec_file *file, pv_picture *picture)
{
    jpeg_create_decompress(&job->in);
    jpeg_mem_src(&job->in, file->bytes, file->size);
    jpeg_read_header(&job->in, TRUE);
    job->in.out_color_space = job->in.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_start_decompress(&job->in);
    job->row_bytes = (size_t)job->in.output_width * (size_t)job->in.output_components;
    memset(picture, 0, sizeof *picture);
    picture->columns = picture->width = (int32_t)job->in.output_width;
    picture->height = (int32_t)job->in.output_height;
    picture->rows = 1;
    picture->channels = job->in.output_components;
    picture->type = PAVE_U8;
    picture->alpha = -1;
    snprintf(picture->names, sizeof picture->names, "%s", picture->channels == 1 ? "Y" : "R,G,B");
}

static pave_result decode(pave_context *context, const char *format, const pv_codec_file *file, pv_picture *picture,
                          pv_codec_job **out, char *text)
{
    pave_result result = begin(context, text, out);
    (void)format;
    if (result)
        return result;
    if (setjmp((*out)->complaint.back))
        return give_up(out, PAVE_ERR_FORMAT);
    read_head(*out, file, picture);
    return PAVE_OK;
}

static pave_result read_rows(pv_codec_job *job, int32_t x, int32_t y, int32_t width, int32_t height, void *pixels,
                             char *text)
{
    (void)x, (void)y, (void)width;
    job->complaint.text = text;
    *text = 0;
    if (setjmp(job->complaint.back))
        return PAVE_ERR_FORMAT;
    for (int32_t i = 0; i < height; i++) {
        JSAMPROW row = (JSAMPROW)pixels + (size_t)i * job->row_bytes;
        jpeg_read_scanlines(&job->in, &row, 1);
    }
    return PAVE_OK;
}

static void empty(j_compress_ptr jpeg, size_t size)
{
    receiver *r = (receiver *)jpeg->dest;
    if (!r->sink(r->user, r->at, r->bytes, size))
        ERREXIT(jpeg, JERR_FILE_WRITE);
    r->at += (int64_t)size;
    r->base.next_output_byte = r->bytes;
    r->base.free_in_buffer = sizeof r->bytes;
}

static void open_buffer(j_compress_ptr jpeg)
{
    empty(jpeg, 0);
}

static boolean empty_buffer(j_compress_ptr jpeg)
{
    empty(jpeg, BUFFER);
    return TRUE;
}

static void close_buffer(j_compress_ptr jpeg)
{
    empty(jpeg, BUFFER - jpeg->dest->free_in_buffer);
}

static void write_head(pv_codec_job *job, const pv_picture *picture)
{
    jpeg_create_compress(&job->out);
    job->receiver.base = (struct jpeg_destination_mgr){ NULL, 0, open_buffer, empty_buffer, close_buffer };
    job->out.dest = &job->receiver.base;
    job->out.image_width = (JDIMENSION)picture->width;
    job->out.image_height = (JDIMENSION)picture->height;
    job->out.input_components = picture->channels;
    job->out.in_color_space = picture->channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    job->row_bytes = (size_t)picture->width * (size_t)picture->channels;
    jpeg_set_defaults(&job->out);
    jpeg_set_quality(&job->out, QUALITY, TRUE);
    jpeg_start_compress(&job->out, TRUE);
}

static pave_result encode(pave_context *context, const char *format, const pv_picture *picture, pv_codec_sink sink,
                          void *user, pv_codec_job **out, char *text)
{
    pave_result result = begin(context, text, out);
    (void)format;
    if (result)
        return result;
    (*out)->receiver.sink = sink;
    (*out)->receiver.user = user;
    if (setjmp((*out)->complaint.back))
        return give_up(out, PAVE_ERR_IO);
    write_head(*out, picture);
    return PAVE_OK;
}

static pave_result write_rows(pv_codec_job *job, int32_t from, int32_t to, const void *pixels, char *text)
{
    job->complaint.text = text;
    *text = 0;
    if (setjmp(job->complaint.back))
        return PAVE_ERR_IO;
    for (int32_t y = from; y < to; y++) {
        JSAMPROW row = (JSAMPROW)(uintptr_t)pixels + (size_t)(y - from) * job->row_bytes;
        jpeg_write_scanlines(&job->out, &row, 1);
    }
    return PAVE_OK;
}

static pave_result finish(pv_codec_job *job, char *text)
{
    job->complaint.text = text;
    *text = 0;
    if (setjmp(job->complaint.back))
        return PAVE_ERR_IO;
    jpeg_finish_compress(&job->out);
    return PAVE_OK;
}

const pv_codec pv_jpeg = { decode, read_rows, encode, write_rows, finish, close_job };
