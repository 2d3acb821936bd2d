/* PNG files: chunks and checksums, the deflate stream, the row filters. What is left gives libpng nothing to say.
 * Source: the PNG specification, third edition (W3C 2025), 5, 7, 9 and 11. */
#include "io/vet.h"

#include <string.h>
#include <zlib.h>

enum { SIDE_OF_LIBPNG = 1000000, EXPANSION = 1100 };
enum { GREY = 0, RGB = 2, PALETTE = 3, GREY_ALPHA = 4, RGB_ALPHA = 6 };

typedef struct png_file {
    pave_context *context;
    pv_encoded *file;
    int64_t read; /* where the next chunk is */
    uint32_t colour, interlaced, entries;
    int palette, transparency;
    int64_t first_data, end_of_data;
    pave_result memory; /* what became of zlib's last allocation */
} png_file;

/* A chunk; its data follow the first 8 bytes. */
typedef struct png_chunk {
    int64_t from;
    uint32_t length;
    char type[5];
} png_chunk;

static pave_result damaged(const png_file *png, const char *reason)
{
    return pv_damaged(png->context, png->file, "PNG", reason);
}

static int is_type(const png_chunk *chunk, const char *type)
{
    return !memcmp(chunk->type, type, 4);
}

static pave_result read_header(png_file *png, const uint8_t *data, uint32_t length)
{
    static const uint8_t channels[7] = { 1, 0, 3, 1, 2, 0, 4 };
    static const uint32_t depths[7] = { 0x10116, 0, 0x10100, 0x116, 0x10100, 0, 0x10100 }; /* bit d: d bits */
    pv_encoded *file = png->file;
    if (length != 13)
        return damaged(png, "its header has a wrong length");
    file->width = pv_be32(data);
    file->height = pv_be32(data + 4);
    file->bits = data[8];
    png->colour = data[9];
    png->interlaced = data[12];
    if (png->colour > 6 || file->bits > 16 || !(depths[png->colour] >> file->bits & 1))
        return damaged(png, "its header gives a colour type and bit depth that do not exist");
    if (data[10] || data[11] || png->interlaced > 1)
        return damaged(png, "its header gives a method that does not exist");
    file->channels = channels[png->colour];
    if (file->width > INT32_MAX || file->height > INT32_MAX)
        return damaged(png, "its header gives an impossible size");
    if (file->width > SIDE_OF_LIBPNG || file->height > SIDE_OF_LIBPNG)
        return pv_fail(png->context, PAVE_ERR_LIMIT, "%s: is a PNG file of more than %d px a side", file->path,
                       SIDE_OF_LIBPNG);
    return PAVE_OK;
}

/* A transparency chunk that fits the colour type; others are left out. */
static int good_transparency(const png_file *png, const uint8_t *data, uint32_t length)
{
    uint32_t most = (1u << png->file->bits) - 1;
    if (png->first_data || png->transparency)
        return 0;
    if (png->colour == GREY)
        return length == 2 && pv_be16(data) <= most;
    if (png->colour == RGB)
        return length == 6 && pv_be16(data) <= most && pv_be16(data + 2) <= most && pv_be16(data + 4) <= most;
    return png->colour == PALETTE && png->palette && length >= 1 && length <= png->entries;
}

static pave_result take_palette(png_file *png, uint32_t length)
{
    png->entries = length / 3;
    if (png->palette++ || png->first_data || length % 3 || !length || png->entries > 1u << png->file->bits)
        return damaged(png, "its palette is out of place or of a wrong length");
    return PAVE_OK;
}

/* The picture's data, in one chunk or in some that follow each other. */
static pave_result take_data(png_file *png, const png_chunk *chunk)
{
    if (png->colour == PALETTE && !png->palette)
        return damaged(png, "its palette is missing");
    if (png->first_data && chunk->from != png->end_of_data)
        return damaged(png, "its picture is in two places");
    if (!png->first_data)
        png->first_data = chunk->from;
    png->end_of_data = png->read;
    return PAVE_OK;
}

/* Decides on one chunk: keep it? */
static pave_result look_at(png_file *png, const png_chunk *chunk, int *keep)
{
    const uint8_t *data;
    uint32_t length = chunk->length;
    if (is_type(chunk, "IHDR"))
        return damaged(png, "it has two headers");
    if (is_type(chunk, "PLTE")) {
        *keep = png->colour == PALETTE;
        return *keep ? take_palette(png, length) : PAVE_OK;
    }
    if (is_type(chunk, "IDAT")) {
        *keep = 1;
        return take_data(png, chunk);
    }
    if (is_type(chunk, "tRNS") || is_type(chunk, "eXIf")) {
        if (length > PV_INPUT_LOOK)
            return PAVE_OK;
        pave_result result = pv_input_look(png->file->input, chunk->from + 8, length, &data);
        if (result)
            return result;
        if (is_type(chunk, "eXIf"))
            png->file->orientation = pv_exif_orientation(data, length);
        else
            png->transparency |= *keep = good_transparency(png, data, length);
        return PAVE_OK;
    }
    return chunk->type[0] & 0x20 ? PAVE_OK
                                 : damaged(png, "it holds a chunk of an unknown kind that it cannot do without");
}

static pave_result check_sum(png_file *png, const png_chunk *chunk)
{
    const uint8_t *data;
    int64_t at = chunk->from + 4, end = at + 4 + chunk->length;
    uLong sum = 0;
    for (int64_t n; at < end; at += n) {
        n = end - at < PV_INPUT_LOOK ? end - at : PV_INPUT_LOOK;
        pave_result result = pv_input_look(png->file->input, at, n, &data);
        if (!result)
            result = pv_progress(png->context, 0);
        if (result)
            return result;
        sum = crc32(sum, data, (uInt)n);
    }
    pave_result result = pv_input_look(png->file->input, end, 4, &data);
    return result || pv_be32(data) == sum ? result : damaged(png, "a checksum is wrong");
}

static pave_result chunk_at(png_file *png, int64_t at, png_chunk *out)
{
    const uint8_t *head;
    int64_t left = png->file->input->size - at;
    if (left < 12)
        return damaged(png, "it is cut short");
    pave_result result = pv_input_look(png->file->input, at, 8, &head);
    if (result)
        return result;
    *out = (png_chunk){ .from = at, .length = pv_be32(head) };
    memcpy(out->type, head + 4, 4);
    return out->length > left - 12 ? damaged(png, "it is cut short") : PAVE_OK;
}

static pave_result next_chunk(png_file *png, png_chunk *out)
{
    pave_result result = chunk_at(png, png->read, out);
    if (!result && (!(out->type[0] & 0x20) || is_type(out, "tRNS")))
        result = check_sum(png, out);
    png->read += (int64_t)out->length + 12;
    return result;
}

static pave_result begin(png_file *png)
{
    png_chunk chunk = { 0 };
    const uint8_t *data;
    pave_result result = next_chunk(png, &chunk);
    if (!result && !is_type(&chunk, "IHDR"))
        return damaged(png, "its header is missing");
    if (!result)
        result = pv_input_look(png->file->input, chunk.from + 8, chunk.length < 13 ? chunk.length : 13, &data);
    if (!result)
        result = read_header(png, data, chunk.length);
    pv_keep(png->file, 0, png->read, NULL);
    return result;
}

static pave_result walk_chunks(png_file *png)
{
    png_chunk chunk = { 0 };
    pave_result result = begin(png);
    while (!result && !is_type(&chunk, "IEND") && !(result = next_chunk(png, &chunk))) {
        int last = is_type(&chunk, "IEND"), keep = last;
        if (last && chunk.length)
            return damaged(png, "its end is of a wrong length");
        if (last && !png->first_data)
            return damaged(png, "it holds no picture");
        if (!last)
            result = look_at(png, &chunk, &keep);
        if (!result && keep)
            pv_keep(png->file, chunk.from, (int64_t)chunk.length + 12, NULL);
    }
    return result;
}

/* Where the inflated stream is: the rows left in this pass of the interlace, the bytes left in this row. */
typedef struct png_rows {
    int32_t pass, passes;
    int64_t rows, row_bytes, left;
} png_rows;

/* Size of a pass, Adam7. */
static void begin_pass(const png_file *png, png_rows *at)
{
    static const int32_t x0[7] = { 0, 4, 0, 2, 0, 1, 0 }, dx[7] = { 8, 8, 4, 4, 2, 2, 1 };
    static const int32_t y0[7] = { 0, 0, 4, 0, 2, 0, 1 }, dy[7] = { 8, 8, 8, 4, 4, 2, 2 };
    const pv_encoded *file = png->file;
    for (at->rows = 0; !at->rows && at->pass < at->passes; at->pass++) {
        int32_t p = at->pass;
        int64_t w = at->passes == 1 ? file->width : (file->width - x0[p] + dx[p] - 1) / dx[p];
        int64_t h = at->passes == 1 ? file->height : (file->height - y0[p] + dy[p] - 1) / dy[p];
        at->rows = w ? h : 0;
        at->row_bytes = (w * file->channels * file->bits + 7) / 8;
    }
    at->left = 0;
}

/* Takes inflated bytes; a sentence if they are not a picture. */
static const char *take_rows(const png_file *png, png_rows *at, const uint8_t *bytes, size_t count)
{
    while (count) {
        if (!at->rows)
            return "it holds more than its picture";
        if (!at->left) {
            if (*bytes > 4)
                return "a row has a filter that does not exist";
            at->left = at->row_bytes + 1;
        }
        size_t n = count < (size_t)at->left ? count : (size_t)at->left;
        bytes += n;
        count -= n;
        at->left -= (int64_t)n;
        if (!at->left && !--at->rows)
            begin_pass(png, at);
    }
    return NULL;
}

static voidpf zlib_alloc(voidpf user, uInt count, uInt size)
{
    png_file *png = user;
    return pv_allocate_zeroed(png->context, count, size, &png->memory);
}

static void zlib_free(voidpf user, voidpf block)
{
    (void)user;
    pv_release(block);
}

static const char *inflate_chunk(const png_file *png, z_stream *stream, png_rows *at, int *ended)
{
    uint8_t rows[16384];
    int state = Z_OK;
    while (state == Z_OK && (stream->avail_in || !stream->avail_out)) {
        stream->next_out = rows;
        stream->avail_out = sizeof rows;
        state = inflate(stream, Z_NO_FLUSH);
        if (state == Z_BUF_ERROR)
            break;
        if (state != Z_OK && state != Z_STREAM_END)
            return "its compressed data are broken";
        const char *reason = take_rows(png, at, rows, sizeof rows - stream->avail_out);
        if (reason)
            return reason;
    }
    *ended = state == Z_STREAM_END;
    return *ended && stream->avail_in ? "data follow its picture" : NULL;
}

/* One IDAT chunk; *reason says what is wrong with it. */
static pave_result inflate_data(png_file *png, const png_chunk *chunk, z_stream *stream, png_rows *at, int *ended,
                                const char **reason)
{
    const uint8_t *data;
    int64_t from = chunk->from + 8, end = from + chunk->length;
    pave_result result = PAVE_OK;
    for (int64_t n; from < end && !*reason && !result; from += n) {
        n = end - from < PV_INPUT_LOOK ? end - from : PV_INPUT_LOOK;
        result = pv_input_look(png->file->input, from, n, &data);
        if (result)
            break;
        stream->next_in = (Bytef *)(uintptr_t)data;
        stream->avail_in = (uInt)n;
        stream->avail_out = 1;
        *reason = *ended ? "data follow its picture" : inflate_chunk(png, stream, at, ended);
    }
    return result;
}

static pave_result inflate_all(png_file *png, z_stream *stream, double share)
{
    png_rows at = { 0, png->interlaced ? 7 : 1, 0, 0, 0 };
    png_chunk chunk = { .from = png->first_data };
    const char *reason = NULL;
    pave_result result = PAVE_OK;
    int ended = 0;
    begin_pass(png, &at);
    for (int64_t from = chunk.from; from < png->end_of_data && !reason && !result; from += (int64_t)chunk.length + 12) {
        result = chunk_at(png, from, &chunk);
        if (!result)
            result = inflate_data(png, &chunk, stream, &at, &ended, &reason);
        if (!result)
            result = pv_progress(png->context, share * (double)from / (double)png->end_of_data);
    }
    if (!reason && (!ended || at.rows))
        reason = "its picture is cut short";
    if (!result)
        result = png->memory;
    return result ? result : reason ? damaged(png, reason) : PAVE_OK;
}

static pave_result check_picture(png_file *png, double share)
{
    z_stream stream;
    memset(&stream, 0, sizeof stream);
    stream.zalloc = zlib_alloc;
    stream.zfree = zlib_free;
    stream.opaque = png;
    if (inflateInit2(&stream, 0) != Z_OK)
        return png->memory ? png->memory : damaged(png, "its compressed data are broken");
    pave_result result = inflate_all(png, &stream, share);
    inflateEnd(&stream);
    return result;
}

pave_result pv_vet_png(pave_context *context, pv_encoded *file, double share)
{
    png_file png = { .context = context, .file = file, .read = 8 };
    file->format = "png";
    file->expansion = EXPANSION;
    file->size = 0;
    pave_result result = walk_chunks(&png);
    if (!result)
        result = pv_check_claims(context, file);
    if (result)
        return result;
    file->at_once = png.interlaced ? (int64_t)pv_picture_bytes(file) : 0;
    return check_picture(&png, share);
}
