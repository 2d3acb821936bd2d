/* OpenEXR files to images, chunk by chunk. */
#include "io/exr.h"

#include "io/exr_call.h"
#include "util/half.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { EXPANSION = 1100, FLAG_DEEP = 0x800, FLAG_PARTS = 0x1000 };

static pave_result unsupported(const pv_exr_call *call, const char *what)
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

static pave_result check_flags(const pv_exr_call *call)
{
    uint8_t head[8];
    if (pv_read_at(call->input->file, 0, head, 8) != 8)
        return pv_fail(call->context, PAVE_ERR_FORMAT, "%s: is a damaged OpenEXR file: it is cut short", call->path);
    uint32_t version = (uint32_t)head[4] | (uint32_t)head[5] << 8 | (uint32_t)head[6] << 16 | (uint32_t)head[7] << 24;
    if ((version & 0xFF) != 2)
        return unsupported(call, "is an OpenEXR file of a version other than 2");
    if (version & FLAG_DEEP)
        return unsupported(call, "is a deep OpenEXR image, and flat ones are read");
    return version & FLAG_PARTS ? unsupported(call, "is an OpenEXR file of many parts, and those of one part are read")
                                : PAVE_OK;
}

static pave_result read_window(pv_exr_call *call, exr_layout *layout)
{
    exr_attr_box2i_t window;
    exr_storage_t storage;
    exr_result_t code = exr_get_data_window(call->exr, 0, &window);
    if (!code)
        code = exr_get_storage(call->exr, 0, &storage);
    if (!code)
        code = exr_get_compression(call->exr, 0, &layout->compression);
    if (code)
        return pv_exr_failure(call, code);
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
static pave_result choose_type(pv_exr_call *call, const exr_attr_chlist_t *list, exr_layout *layout)
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

static pave_result read_channels(pv_exr_call *call, exr_layout *layout)
{
    const exr_attr_chlist_t *list;
    exr_result_t code = exr_get_channels(call->exr, 0, &list);
    if (code)
        return pv_exr_failure(call, code);
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
    if (claimed > (double)call->input->size * EXPANSION + 65536)
        return pv_fail(call->context, PAVE_ERR_LIMIT,
                       "%s: claims %lld x %lld px, more than a file of %lld bytes can hold", call->path,
                       (long long)layout->width, (long long)layout->height, (long long)call->input->size);
    return PAVE_OK;
}

static pave_image_params image_shape(const exr_layout *layout)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    params.width = (int32_t)layout->width;
    params.height = (int32_t)layout->height;
    params.channels = layout->channels;
    params.type = layout->type;
    params.encoding = layout->colour && layout->type != PAVE_U32 ? PAVE_LINEAR : PAVE_DATA;
    params.alpha = layout->type == PAVE_U32 ? -1 : layout->alpha;
    params.names = layout->names;
    return params;
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

/* A chunk holds row after row, and in each row channel after channel. `to` is its first pixel in rows of `width`. */
static void unpack(const exr_layout *layout, const exr_chunk_info_t *chunk, const uint8_t *from, int32_t width,
                   char *to)
{
    size_t bytes = pv_type_bytes(layout->type), pixel = (size_t)layout->channels * bytes;
    for (int32_t row = 0; row < chunk->height; row++, to += (size_t)width * pixel)
        for (int32_t i = 0; i < layout->channels; i++) {
            unpack_row(layout, i, from, chunk->width, to + (size_t)layout->place[i] * bytes);
            from += (size_t)chunk->width * pv_type_bytes(layout->type_in_file[i]);
        }
}

/* A file while its pixels are read. */
typedef struct exr_reading {
    pv_exr_call *call;
    exr_layout layout;
    int32_t columns, rows; /* of a chunk */
    exr_decode_pipeline_t pipeline;
} exr_reading;

static int32_t least(int32_t a, int64_t b)
{
    return a < b ? a : (int32_t)b;
}

/* What a chunk must be: the whole of its place, of the size that its pixels take, not longer than the file. */
static int good_chunk(const exr_reading *r, const exr_chunk_info_t *chunk, int32_t x, int32_t y)
{
    const exr_layout *layout = &r->layout;
    uint64_t bytes = 0;
    for (int32_t i = 0; i < layout->channels; i++)
        bytes += pv_type_bytes(layout->type_in_file[i]);
    int fits = chunk->width == least(r->columns, layout->width - x) &&
               chunk->height == least(r->rows, layout->height - y);
    bytes *= fits ? (uint64_t)chunk->width * (uint64_t)chunk->height : 0;
    return fits && chunk->unpacked_size == bytes && chunk->packed_size <= bytes &&
           chunk->packed_size <= (uint64_t)r->call->input->size &&
           (layout->compression != EXR_COMPRESSION_NONE || chunk->packed_size == bytes);
}

/* The chunk whose first pixel this is. */
static pave_result read_chunk(exr_reading *r, int32_t x, int32_t y, int32_t width, char *to)
{
    exr_chunk_info_t chunk;
    const exr_layout *layout = &r->layout;
    const uint8_t *pixels = NULL;
    exr_context_t exr = r->call->exr;
    exr_result_t code =
        layout->tiled ? exr_read_tile_chunk_info(exr, 0, x / r->columns, y / r->rows, 0, 0, &chunk)
                      : exr_read_scanline_chunk_info(exr, 0, (int)((int64_t)layout->y0 + y), &chunk);
    if (!code && !good_chunk(r, &chunk, x, y))
        code = EXR_ERR_CORRUPT_CHUNK;
    pave_result result = code ? pv_exr_failure(r->call, code)
                              : pv_exr_decode(r->call, 0, &chunk, &r->pipeline, &pixels);
    if (!result)
        unpack(layout, &chunk, pixels, width, to);
    return result ? result : pv_progress(r->call->context, 0);
}

static pave_result read_part(void *user, pv_rect part, void *pixels)
{
    exr_reading *r = user;
    int64_t pixel = r->layout.channels * (int64_t)pv_type_bytes(r->layout.type);
    pave_result result = PAVE_OK;
    for (int32_t y = 0; y < part.height && !result; y += r->rows)
        for (int32_t x = 0; x < part.width && !result; x += r->columns)
            result = read_chunk(r, part.x + x, part.y + y, part.width,
                                (char *)pixels + ((int64_t)y * part.width + x) * pixel);
    return result;
}

static pave_result read_chunk_size(exr_reading *r)
{
    exr_result_t code;
    r->columns = (int32_t)r->layout.width;
    if (r->layout.tiled)
        code = exr_get_tile_sizes(r->call->exr, 0, 0, 0, &r->columns, &r->rows);
    else
        code = exr_get_scanlines_per_chunk(r->call->exr, 0, &r->rows);
    if (!code && (r->columns < 1 || r->rows < 1))
        code = EXR_ERR_INVALID_ATTR;
    return code ? pv_exr_failure(r->call, code) : PAVE_OK;
}

/* A chunk is there packed and unpacked, and OpenEXR holds the table of all chunks. */
static int64_t bytes_at_once(const exr_reading *r)
{
    double pixel = r->layout.channels * (double)pv_type_bytes(r->layout.type);
    double width = (double)r->layout.width, height = (double)r->layout.height;
    double chunk = fmin(r->columns, width) * fmin(r->rows, height);
    return (int64_t)(3 * chunk * pixel + 8 * (width / r->columns + 1) * (height / r->rows + 1));
}

static pave_result read_pixels(pv_exr_call *call, const pv_target *target)
{
    exr_reading r = { .call = call, .pipeline = EXR_DECODE_PIPELINE_INITIALIZER };
    pave_result result = read_window(call, &r.layout);
    if (!result)
        result = read_channels(call, &r.layout);
    if (!result)
        result = read_chunk_size(&r);
    if (result)
        return result;
    pv_blocks blocks = { call->path, image_shape(&r.layout), r.columns, r.rows, 1, bytes_at_once(&r), 0, read_part,
                         &r };
    result = pv_blocks_read(call->context, &blocks, target);
    exr_decoding_destroy(call->exr, &r.pipeline);
    return result;
}

pave_result pv_exr_read(pave_context *context, pv_input *input, const pv_target *target)
{
    pv_exr_call call = { .context = context, .path = input->path, .input = input };
    pave_result result = check_flags(&call);
    if (result)
        return result;
    pv_exr_call *outer = pv_exr_enter(&call);
    exr_result_t code = pv_exr_start(&call);
    result = code ? pv_exr_failure(&call, code) : read_pixels(&call, target);
    if (call.exr)
        exr_finish(&call.exr);
    pv_exr_enter(outer);
    return result;
}
