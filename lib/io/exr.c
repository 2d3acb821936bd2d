/* OpenEXR files: the only source that includes OpenEXR's headers. */
#include "io/exr.h"

#include "io/convert.h"
#include "io/output.h"
#include "util/half.h"

#include <OpenEXR/openexr.h>

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { EXPANSION = 1100, FLAG_DEEP = 0x800, FLAG_PARTS = 0x1000 };

/* A call under way. OpenEXR's allocator has no user pointer, so the call at work in a thread is kept here. */
typedef struct exr_call {
    pave_context *context;
    const char *path;
    exr_context_t exr;
    int file;
    int64_t size;
    pv_output *output;
    pave_result memory; /* what became of the last allocation */
    char text[256];     /* OpenEXR's last sentence */
} exr_call;

static _Thread_local exr_call *call_at_work;

/* Zeroed, so that a chunk which inflates to less than it should shows no old memory. */
static void *allocate(size_t size)
{
    return pv_allocate_zeroed(call_at_work->context, size, 1, &call_at_work->memory);
}

static void keep_text(exr_const_context_t exr, exr_result_t code, const char *text)
{
    (void)exr;
    (void)code;
    exr_call *call = call_at_work;
    if (call)
        snprintf(call->text, sizeof call->text, "%.*s", (int)strcspn(text, "\n"), text);
}

static int64_t read_at(exr_const_context_t exr, void *user, void *buffer, uint64_t size, uint64_t offset,
                       exr_stream_error_func_ptr_t error)
{
    (void)exr;
    (void)error;
    const exr_call *call = user;
    uint64_t done = 0;
    while (done < size) {
        ssize_t n = pread(call->file, (char *)buffer + done, size - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            break;
        done += (uint64_t)n;
    }
    return (int64_t)done;
}

static int64_t file_size(exr_const_context_t exr, void *user)
{
    (void)exr;
    return ((const exr_call *)user)->size;
}

static int64_t write_at(exr_const_context_t exr, void *user, const void *buffer, uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t error)
{
    (void)exr;
    (void)error;
    return pv_output_at(((exr_call *)user)->output, (int64_t)offset, buffer, size) ? (int64_t)size : -1;
}

static exr_context_initializer_t initializer(exr_call *call)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_text;
    init.alloc_fn = allocate;
    init.free_fn = pv_release;
    init.user_data = call;
    init.max_tile_width = init.max_tile_height = (int)call->context->limits.max_side;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    return init;
}

/* The sentence for a failure of OpenEXR's. */
static pave_result failure(exr_call *call, exr_result_t code)
{
    if (call->memory)
        return call->memory;
    const char *reason = call->text[0] ? call->text : exr_get_default_error_message(code);
    return pv_fail(call->context, call->output ? PAVE_ERR_ARGUMENT : PAVE_ERR_FORMAT,
                   call->output ? "%s: OpenEXR does not take this image: %s" : "%s: is a damaged OpenEXR file: %s",
                   call->path, reason);
}

static pave_result unsupported(const exr_call *call, const char *what)
{
    return pv_fail(call->context, PAVE_ERR_UNSUPPORTED, "%s: %s", call->path, what);
}

/* Where things are in the file, and what becomes of its channels. */
typedef struct exr_layout {
    int64_t width, height;
    int32_t x0, y0;
    int32_t channels, type;
    int tiled;
    exr_compression_t compression;
    int32_t place[PV_MOST_CHANNELS]; /* of the file's channels, in the image */
    int32_t type_in_file[PV_MOST_CHANNELS];
    char names[PV_MOST_CHANNELS * PV_CHANNEL_NAME];
    int32_t colour, alpha;
} exr_layout;

static pave_result check_flags(const exr_call *call)
{
    uint8_t head[8];
    if (call->size < 8 || read_at(NULL, (void *)(uintptr_t)call, head, 8, 0, NULL) != 8)
        return pv_fail(call->context, PAVE_ERR_FORMAT, "%s: is a damaged OpenEXR file: it is cut short", call->path);
    uint32_t version = (uint32_t)head[4] | (uint32_t)head[5] << 8 | (uint32_t)head[6] << 16 | (uint32_t)head[7] << 24;
    if ((version & 0xFF) != 2)
        return unsupported(call, "is an OpenEXR file of a version other than 2");
    if (version & FLAG_DEEP)
        return unsupported(call, "is a deep OpenEXR image, and flat ones are read");
    return version & FLAG_PARTS ? unsupported(call, "is an OpenEXR file of many parts, and those of one part are read")
                                : PAVE_OK;
}

static pave_result read_window(exr_call *call, exr_layout *layout)
{
    exr_attr_box2i_t window;
    exr_storage_t storage;
    exr_result_t code = exr_get_data_window(call->exr, 0, &window);
    if (!code)
        code = exr_get_storage(call->exr, 0, &storage);
    if (!code)
        code = exr_get_compression(call->exr, 0, &layout->compression);
    if (code)
        return failure(call, code);
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return unsupported(call, "is a deep OpenEXR image, and flat ones are read");
    if (layout->compression > EXR_COMPRESSION_ZIP)
        return unsupported(call, "its OpenEXR compression is not read; save it with ZIP compression");
    layout->tiled = storage == EXR_STORAGE_TILED;
    layout->x0 = window.min.x;
    layout->y0 = window.min.y;
    layout->width = (int64_t)window.max.x - window.min.x + 1;
    layout->height = (int64_t)window.max.y - window.min.y + 1;
    return pv_check_size(call->context, call->path, layout->width, layout->height);
}

/* All of one type keep it; half and float become float; counts and other numbers do not go together. */
static pave_result choose_type(exr_call *call, const exr_attr_chlist_t *list, exr_layout *layout)
{
    static const int32_t types[3] = { PAVE_U32, PAVE_F16, PAVE_F32 };
    for (int32_t i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        if (entry->x_sampling != 1 || entry->y_sampling != 1)
            return unsupported(call, "has subsampled channels (luminance and chroma); save it as RGB");
        if ((uint32_t)entry->pixel_type > 2)
            return unsupported(call, "has channels of an unknown type");
        int32_t type = layout->type_in_file[i] = types[entry->pixel_type];
        if (i && (layout->type == PAVE_U32) != (type == PAVE_U32))
            return unsupported(call, "has both whole-number and floating-point channels");
        layout->type = i && layout->type != type ? PAVE_F32 : type;
    }
    return PAVE_OK;
}

/* R, G, B, A first, the others in the order of the file. */
static void order_channels(const exr_attr_chlist_t *list, exr_layout *layout)
{
    static const char first[] = "RGBA";
    int32_t next = 0;
    char *names = layout->names;
    for (int32_t pass = 0; pass < 5; pass++)
        for (int32_t i = 0; i < list->num_channels; i++) {
            const char *name = list->entries[i].name.str;
            const char *known = name[0] && !name[1] ? strchr(first, name[0]) : NULL;
            if ((known ? known - first : 4) != pass)
                continue;
            layout->place[i] = next++;
            layout->colour |= known ? pass < 3 : !strcmp(name, "Y");
            if (known && pass == 3)
                layout->alpha = layout->place[i];
            names += snprintf(names, PV_CHANNEL_NAME, "%s%.60s", next > 1 ? "," : "", name);
        }
}

static pave_result read_channels(exr_call *call, exr_layout *layout)
{
    const exr_attr_chlist_t *list;
    exr_result_t code = exr_get_channels(call->exr, 0, &list);
    if (code)
        return failure(call, code);
    layout->channels = list->num_channels;
    layout->alpha = -1;
    if (layout->channels < 1 || layout->channels > PV_MOST_CHANNELS)
        return pv_fail(call->context, PAVE_ERR_LIMIT, "%s: has %d channels, and 1 to %d can be read", call->path,
                       layout->channels, PV_MOST_CHANNELS);
    pave_result result = choose_type(call, list, layout);
    if (result)
        return result;
    order_channels(list, layout);
    double claimed = 0;
    for (int32_t i = 0; i < layout->channels; i++)
        claimed += (double)layout->width * (double)layout->height * (double)pv_type_bytes(layout->type_in_file[i]);
    if (claimed > (double)call->size * EXPANSION + 65536)
        return pv_fail(call->context, PAVE_ERR_LIMIT,
                       "%s: claims %lld x %lld px, more than a file of %lld bytes can hold", call->path,
                       (long long)layout->width, (long long)layout->height, (long long)call->size);
    return PAVE_OK;
}

static pave_result new_image(exr_call *call, const exr_layout *layout, pave_image **out)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    params.width = (int32_t)layout->width;
    params.height = (int32_t)layout->height;
    params.channels = layout->channels;
    params.type = layout->type;
    params.encoding = layout->colour && layout->type != PAVE_U32 ? PAVE_LINEAR : PAVE_DATA;
    params.alpha = layout->type == PAVE_U32 ? -1 : layout->alpha;
    params.names = layout->names;
    return pv_image_new(call->context, &params, out);
}

static void unpack_row(const exr_layout *layout, int32_t channel, const uint8_t *from, int32_t count, char *to)
{
    size_t step = (size_t)layout->channels * pv_type_bytes(layout->type);
    if (layout->type_in_file[channel] == PAVE_F16) {
        for (int32_t i = 0; i < count; i++, to += step) {
            uint16_t half = (uint16_t)(from[2 * i] | from[2 * i + 1] << 8);
            float value = pv_half_value(half);
            memcpy(to, layout->type == PAVE_F16 ? (void *)&half : (void *)&value, layout->type == PAVE_F16 ? 2 : 4);
        }
        return;
    }
    for (int32_t i = 0; i < count; i++, to += step) {
        const uint8_t *p = from + 4 * (size_t)i;
        uint32_t word = (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
        memcpy(to, &word, 4);
    }
}

/* A chunk holds row after row, and in each row channel after channel. */
static void unpack(const exr_layout *layout, const exr_chunk_info_t *chunk, int32_t x, int32_t y, const uint8_t *from,
                   pave_image *image)
{
    size_t bytes = pv_type_bytes(layout->type);
    for (int32_t row = 0; row < chunk->height; row++)
        for (int32_t i = 0; i < layout->channels; i++) {
            size_t pixel = (size_t)(y + row) * (size_t)image->width + (size_t)x;
            char *to = (char *)image->pixels + (pixel * (size_t)image->channels + (size_t)layout->place[i]) * bytes;
            unpack_row(layout, i, from, chunk->width, to);
            from += (size_t)chunk->width * pv_type_bytes(layout->type_in_file[i]);
        }
}

/* What a chunk must be: inside the image, of the size that its pixels take, not longer than the file. */
static int good_chunk(const exr_call *call, const exr_layout *layout, const exr_chunk_info_t *chunk, int32_t x,
                      int32_t y)
{
    uint64_t bytes = 0;
    for (int32_t i = 0; i < layout->channels; i++)
        bytes += pv_type_bytes(layout->type_in_file[i]);
    int inside = chunk->width > 0 && chunk->height > 0 && x + (int64_t)chunk->width <= layout->width &&
                 y + (int64_t)chunk->height <= layout->height;
    bytes *= inside ? (uint64_t)chunk->width * (uint64_t)chunk->height : 0;
    return inside && chunk->unpacked_size == bytes && chunk->packed_size <= bytes &&
           chunk->packed_size <= (uint64_t)call->size &&
           (layout->compression != EXR_COMPRESSION_NONE || chunk->packed_size == bytes);
}

static exr_result_t leave_packed(exr_decode_pipeline_t *pipeline)
{
    (void)pipeline;
    return EXR_ERR_SUCCESS;
}

static pave_result read_chunk(exr_call *call, const exr_layout *layout, exr_decode_pipeline_t *pipeline,
                              const exr_chunk_info_t *chunk, int32_t x, int32_t y, pave_image *image)
{
    if (!good_chunk(call, layout, chunk, x, y))
        return failure(call, EXR_ERR_CORRUPT_CHUNK);
    int first = !pipeline->channels;
    exr_result_t code = first ? exr_decoding_initialize(call->exr, 0, chunk, pipeline)
                              : exr_decoding_update(call->exr, 0, chunk, pipeline);
    if (!code && first)
        code = exr_decoding_choose_default_routines(call->exr, 0, pipeline);
    pipeline->unpack_and_convert_fn = leave_packed;
    if (!code)
        code = exr_decoding_run(call->exr, 0, pipeline);
    const uint8_t *pixels = pipeline->unpacked_buffer ? pipeline->unpacked_buffer : pipeline->packed_buffer;
    if (code || !pixels)
        return failure(call, code ? code : EXR_ERR_CORRUPT_CHUNK);
    unpack(layout, chunk, x, y, pixels, image);
    return pv_progress(call->context, (y + 0.5) / (double)layout->height);
}

static pave_result read_scanlines(exr_call *call, const exr_layout *layout, exr_decode_pipeline_t *pipeline,
                                  pave_image *image)
{
    exr_chunk_info_t chunk;
    for (int32_t y = 0; y < image->height; y += chunk.height) {
        exr_result_t code = exr_read_scanline_chunk_info(call->exr, 0, (int)((int64_t)layout->y0 + y), &chunk);
        pave_result result = code ? failure(call, code) : read_chunk(call, layout, pipeline, &chunk, 0, y, image);
        if (result)
            return result;
    }
    return PAVE_OK;
}

static pave_result read_tiles(exr_call *call, const exr_layout *layout, exr_decode_pipeline_t *pipeline,
                              pave_image *image)
{
    int32_t width, height;
    exr_chunk_info_t chunk;
    exr_result_t code = exr_get_tile_sizes(call->exr, 0, 0, 0, &width, &height);
    if (!code && (width < 1 || height < 1))
        code = EXR_ERR_INVALID_ATTR;
    for (int64_t y = 0; y < image->height && !code; y += height)
        for (int64_t x = 0; x < image->width && !code; x += width) {
            code = exr_read_tile_chunk_info(call->exr, 0, (int)(x / width), (int)(y / height), 0, 0, &chunk);
            if (code)
                break;
            pave_result result = read_chunk(call, layout, pipeline, &chunk, (int32_t)x, (int32_t)y, image);
            if (result)
                return result;
        }
    return code ? failure(call, code) : PAVE_OK;
}

static pave_result read_pixels(exr_call *call, const exr_layout *layout, pave_image *image)
{
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    pave_result result = layout->tiled ? read_tiles(call, layout, &pipeline, image)
                                       : read_scanlines(call, layout, &pipeline, image);
    exr_decoding_destroy(call->exr, &pipeline);
    if (!result)
        pv_unpremultiply(image);
    return result;
}

static pave_result read_image(exr_call *call, pave_image **out)
{
    exr_layout layout;
    memset(&layout, 0, sizeof layout);
    pave_result result = read_window(call, &layout);
    if (!result)
        result = read_channels(call, &layout);
    if (!result)
        result = new_image(call, &layout, out);
    if (!result)
        result = read_pixels(call, &layout, *out);
    if (result)
        pave_image_free(out);
    return result;
}

pave_result pv_exr_read(pave_context *context, const char *path, int file, int64_t size, pave_image **out)
{
    exr_call call = { .context = context, .path = path, .file = file, .size = size };
    pave_result result = check_flags(&call);
    if (result)
        return result;
    exr_context_initializer_t init = initializer(&call);
    init.read_fn = read_at;
    init.size_fn = file_size;
    exr_call *outer = call_at_work; /* a callback may have called in here */
    call_at_work = &call;
    exr_result_t code = exr_start_read(&call.exr, path, &init);
    result = code ? failure(&call, code) : read_image(&call, out);
    if (call.exr)
        exr_finish(&call.exr);
    call_at_work = outer;
    return result;
}

/* The image as it goes into the file. */
static pv_pixels file_pixels(const pave_image *image)
{
    pv_pixels pixels = { image->type, PAVE_LINEAR, 1 };
    if (image->type == PAVE_U8)
        pixels.type = PAVE_F16;
    if (image->type == PAVE_U16)
        pixels.type = PAVE_F32;
    pixels.premultiplied = image->type != PAVE_U32;
    return pixels;
}

static exr_result_t write_header(exr_call *call, const pave_image *image, int32_t type)
{
    exr_pixel_type_t kind = type == PAVE_U32 ? EXR_PIXEL_UINT : type == PAVE_F16 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
    int part, long_names = 0;
    for (int32_t c = 0; c < image->channels; c++)
        long_names |= strlen(image->names[c]) > 31;
    exr_result_t code = exr_add_part(call->exr, NULL, EXR_STORAGE_SCANLINE, &part);
    if (!code && long_names)
        code = exr_set_longname_support(call->exr, 1);
    if (!code)
        code = exr_initialize_required_attr_simple(call->exr, 0, image->width, image->height, EXR_COMPRESSION_ZIP);
    for (int32_t c = 0; c < image->channels && !code; c++)
        code = exr_add_channel(call->exr, 0, image->names[c], kind, EXR_PERCEPTUALLY_LINEAR, 1, 1);
    return code ? code : exr_write_header(call->exr);
}

static void bind_channels(const pave_image *image, size_t bytes, const void *band, exr_encode_pipeline_t *pipeline)
{
    for (int16_t i = 0; i < pipeline->channel_count; i++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[i];
        size_t place = (size_t)pv_image_channel(image, channel->channel_name);
        channel->user_bytes_per_element = (int16_t)bytes;
        channel->user_data_type = channel->data_type;
        channel->user_pixel_stride = (int32_t)((size_t)image->channels * bytes);
        channel->user_line_stride = (int32_t)((size_t)image->width * (size_t)image->channels * bytes);
        channel->encode_from_ptr = (const uint8_t *)band + place * bytes;
    }
}

static exr_result_t write_chunk(exr_call *call, const pave_image *image, size_t bytes, int32_t y, const void *band,
                                exr_encode_pipeline_t *pipeline)
{
    exr_chunk_info_t chunk;
    exr_result_t code = exr_write_scanline_chunk_info(call->exr, 0, y, &chunk);
    int first = !pipeline->channels;
    if (!code)
        code = first ? exr_encoding_initialize(call->exr, 0, &chunk, pipeline)
                     : exr_encoding_update(call->exr, 0, &chunk, pipeline);
    if (code)
        return code;
    bind_channels(image, bytes, band, pipeline);
    if (first)
        code = exr_encoding_choose_default_routines(call->exr, 0, pipeline);
    return code ? code : exr_encoding_run(call->exr, 0, pipeline);
}

static pave_result write_pixels(exr_call *call, const pave_image *image, pv_pixels pixels)
{
    int32_t lines = 0;
    pave_result result = PAVE_OK;
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t code = exr_get_scanlines_per_chunk(call->exr, 0, &lines);
    size_t bytes = pv_type_bytes(pixels.type), row = (size_t)image->width * (size_t)image->channels * bytes;
    void *band = code ? NULL : pv_allocate(call->context, (size_t)lines, row, &result);
    for (int32_t y = 0; y < image->height && !code && !result; y += lines) {
        pv_convert_rows(image, y, lines < image->height - y ? y + lines : image->height, pixels, band);
        code = write_chunk(call, image, bytes, y, band, &pipeline);
        result = pv_progress(call->context, (double)y / image->height);
    }
    exr_encoding_destroy(call->exr, &pipeline);
    pv_release(band);
    return result || pv_output_failed(call->output) || !code ? result : failure(call, code);
}

static pave_result write_file(exr_call *call, const pave_image *image)
{
    exr_context_initializer_t init = initializer(call);
    pv_pixels pixels = file_pixels(image);
    init.write_fn = write_at;
    exr_result_t code = exr_start_write(&call->exr, call->path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (!code)
        code = write_header(call, image, pixels.type);
    pave_result result = code && !pv_output_failed(call->output) ? failure(call, code) : PAVE_OK;
    if (!code)
        result = write_pixels(call, image, pixels);
    if (call->exr)
        code = exr_finish(&call->exr);
    return result || !code || pv_output_failed(call->output) ? result : failure(call, code);
}

pave_result pv_exr_write(pave_context *context, const pave_image *image, const char *path)
{
    exr_call call = { .context = context, .path = path };
    pave_result result = pv_output_open(context, path, 1, &call.output);
    if (result)
        return result;
    exr_call *outer = call_at_work;
    call_at_work = &call;
    result = write_file(&call, image);
    call_at_work = outer;
    return pv_output_close(call.output, result);
}

void pv_exr_version(char *text, size_t capacity)
{
    int major, minor, patch;
    const char *extra;
    exr_get_library_version(&major, &minor, &patch, &extra);
    snprintf(text, capacity, "%d.%d.%d", major, minor, patch);
}
