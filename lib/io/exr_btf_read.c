/* BTFs from OpenEXR files of many parts. */
#include "io/exr_btf.h"

#include "io/exr_call.h"
#include "io/spool.h"
#include "image/image.h"
#include "util/half.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { EXPANSION = 1100, MOST_PARTS = 4096 };

/* A file while it is read. */
typedef struct book {
    pv_exr_call *call;
    pave_btf_params shape;
    pave_direction *views;
    pave_btf *btf;
    int32_t *place;  /* of a part's channels: light * channels + channel */
    float *run;
    exr_pixel_type_t kind;
    double claimed;  /* bytes of all parts */
} book;

static pave_result damaged(const book *b, const char *reason)
{
    return pv_fail(b->call->context, PAVE_ERR_FORMAT, "%s: is a damaged BTF in OpenEXR: %s", b->call->path, reason);
}

/* The place that a channel's name says; -1 if it says none. */
static int32_t parse_channel(const book *b, const char *name)
{
    const char *p = name + 1, *names = b->shape.names;
    int32_t light = 0;
    if (name[0] != 'L' || *p < '0' || *p > '9')
        return -1;
    for (; *p >= '0' && *p <= '9' && light < 100000; p++)
        light = 10 * light + (*p - '0');
    if (*p++ != '.' || light >= b->shape.lights)
        return -1;
    for (int32_t c = 0; c < b->shape.channels; c++, names++) {
        size_t length = strcspn(names, ",");
        if (strlen(p) == length && !memcmp(p, names, length))
            return light * b->shape.channels + c;
        names += length;
    }
    return -1;
}

static pave_result check_window(book *b, int part)
{
    exr_attr_box2i_t window;
    exr_storage_t storage;
    exr_compression_t compression;
    exr_context_t exr = b->call->exr;
    exr_result_t code = exr_get_data_window(exr, part, &window);
    if (!code)
        code = exr_get_storage(exr, part, &storage);
    if (!code)
        code = exr_get_compression(exr, part, &compression);
    if (code)
        return pv_exr_failure(b->call, code);
    int64_t width = (int64_t)window.max.x - window.min.x + 1, height = (int64_t)window.max.y - window.min.y + 1;
    if (storage != EXR_STORAGE_SCANLINE || compression > EXR_COMPRESSION_ZIP || window.min.x || window.min.y)
        return pv_fail(b->call->context, PAVE_ERR_UNSUPPORTED, "%s: its part %d is not of rows from 0 with ZIP",
                       b->call->path, part);
    if (!part) {
        pave_result result = pv_check_size(b->call->context, b->call->path, width, height);
        b->shape.width = (int32_t)width;
        b->shape.height = (int32_t)height;
        return result;
    }
    return width == b->shape.width && height == b->shape.height ? PAVE_OK : damaged(b, "its parts differ in size");
}

/* What the first part says of all. */
static pave_result read_shape(book *b, int parts)
{
    int32_t numbers = 0, cosine = 1;
    const float *lights;
    const char *names;
    float pixels_per_mm = 0;
    exr_context_t exr = b->call->exr;
    if (exr_attr_get_float_vector(exr, 0, "lightDirections", &numbers, &lights) ||
        exr_attr_get_string(exr, 0, "channelNames", NULL, &names))
        return pv_fail(b->call->context, PAVE_ERR_FORMAT,
                       "%s: is an OpenEXR picture and no BTF (its parts would say lightDirections)", b->call->path);
    exr_attr_get_int(exr, 0, "lightCosine", &cosine);
    exr_attr_get_float(exr, 0, "pixelsPerMm", &pixels_per_mm);
    if (numbers < 2 || numbers % 2 || parts > MOST_PARTS || numbers / 2 > MOST_PARTS)
        return damaged(b, "it has no lights, or too many");
    b->shape.channels = 1;
    for (const char *p = names; *p; p++)
        b->shape.channels += *p == ',' && b->shape.channels <= PV_BTF_CHANNELS;
    b->shape.views = parts;
    b->shape.lights = numbers / 2;
    b->shape.light_directions = (const pave_direction *)(const void *)lights;
    b->shape.names = names;
    b->shape.cosine = cosine;
    b->shape.pixels_per_mm = pixels_per_mm >= 0 && isfinite(pixels_per_mm) ? (double)pixels_per_mm : 0;
    return PAVE_OK;
}

static pave_result check_channels(book *b, int part)
{
    const exr_attr_chlist_t *list;
    exr_result_t code = exr_get_channels(b->call->exr, part, &list);
    if (code)
        return pv_exr_failure(b->call, code);
    if (list->num_channels > b->shape.lights * b->shape.channels)
        return damaged(b, "a part has more channels than lights and colours make");
    if (!part && list->num_channels)
        b->kind = list->entries[0].pixel_type;
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        if (entry->x_sampling != 1 || entry->y_sampling != 1 || entry->pixel_type != b->kind ||
            (b->kind != EXR_PIXEL_HALF && b->kind != EXR_PIXEL_FLOAT))
            return damaged(b, "its channels are not all halves or all floats");
        if (parse_channel(b, entry->name.str) < 0)
            return damaged(b, "a channel is called neither by a light nor by a colour");
    }
    b->claimed += (double)b->shape.width * b->shape.height * list->num_channels * (b->kind == EXR_PIXEL_HALF ? 2 : 4);
    return list->num_channels ? PAVE_OK : damaged(b, "a view has no lights");
}

static pave_result check_parts(book *b)
{
    int parts = 0;
    pave_result result = PAVE_OK;
    exr_attr_v2f_t direction;
    exr_result_t code = exr_get_count(b->call->exr, &parts);
    if (code)
        return pv_exr_failure(b->call, code);
    result = read_shape(b, parts);
    if (!result)
        b->views = pv_allocate(b->call->context, (size_t)parts, sizeof *b->views, &result);
    for (int v = 0; v < parts && !result; v++) {
        if (exr_attr_get_v2f(b->call->exr, v, "viewDirection", &direction))
            return damaged(b, "a part does not say its viewDirection");
        b->views[v] = (pave_direction){ direction.x, direction.y };
        result = check_window(b, v);
        if (!result)
            result = check_channels(b, v);
    }
    if (!result && b->claimed > (double)b->call->input->size * EXPANSION + 65536)
        return pv_fail(b->call->context, PAVE_ERR_LIMIT, "%s: claims more samples than a file of %lld bytes can hold",
                       b->call->path, (long long)b->call->input->size);
    b->shape.type = b->kind == EXR_PIXEL_HALF ? PAVE_F16 : PAVE_F32;
    b->shape.view_directions = b->views;
    return result;
}

/* Which lights a part has; the others are missing. Returns how many channels. */
static int32_t place_channels(book *b, int part)
{
    const exr_attr_chlist_t *list;
    uint8_t *missing = b->btf->missing + (int64_t)part * b->shape.lights;
    exr_get_channels(b->call->exr, part, &list);
    for (int i = 0; i < list->num_channels; i++) {
        b->place[i] = parse_channel(b, list->entries[i].name.str);
        missing[b->place[i] / b->shape.channels] = 0;
    }
    return list->num_channels;
}

static float value_at(const book *b, const uint8_t *p)
{
    float value;
    uint16_t half;
    if (b->kind == EXR_PIXEL_FLOAT)
        return memcpy(&value, p, 4), value;
    return memcpy(&half, p, 2), pv_half_value(half);
}

static pave_result put_row(book *b, int part, int32_t y, const uint8_t *row, int32_t channels)
{
    size_t bytes = b->kind == EXR_PIXEL_HALF ? 2 : 4, width = (size_t)b->shape.width;
    int64_t run = (int64_t)b->shape.lights * b->shape.channels;
    memset(b->run, 0, (size_t)run * sizeof *b->run);
    for (int32_t x = 0; x < b->shape.width; x++) {
        for (int32_t i = 0; i < channels; i++) {
            float value = value_at(b, row + ((size_t)i * width + (size_t)x) * bytes);
            if (!isfinite(value))
                return damaged(b, "a sample is not a number");
            b->run[b->place[i]] = value;
        }
        pv_btf_put(b->btf, (int64_t)y * b->shape.width + x, part * run, run, b->run);
    }
    return PAVE_OK;
}

static pave_result read_chunk(book *b, int part, int32_t y, int32_t lines, int32_t channels,
                              exr_decode_pipeline_t *pipeline)
{
    exr_chunk_info_t chunk;
    const uint8_t *rows = NULL;
    size_t row = (size_t)b->shape.width * (size_t)channels * (b->kind == EXR_PIXEL_HALF ? 2 : 4);
    exr_result_t code = exr_read_scanline_chunk_info(b->call->exr, part, y, &chunk);
    int32_t wanted = lines < b->shape.height - y ? lines : b->shape.height - y;
    exr_compression_t compression = EXR_COMPRESSION_NONE;
    exr_get_compression(b->call->exr, part, &compression);
    if (!code && (chunk.height != wanted || chunk.width != b->shape.width ||
                  chunk.unpacked_size != row * (size_t)wanted || chunk.packed_size > chunk.unpacked_size ||
                  chunk.packed_size > (uint64_t)b->call->input->size ||
                  (compression == EXR_COMPRESSION_NONE && chunk.packed_size != chunk.unpacked_size)))
        code = EXR_ERR_CORRUPT_CHUNK;
    pave_result result = code ? pv_exr_failure(b->call, code) : pv_exr_decode(b->call, part, &chunk, pipeline, &rows);
    for (int32_t i = 0; i < wanted && !result; i++)
        result = put_row(b, part, y + i, rows + (size_t)i * row, channels);
    return result;
}

static pave_result read_part(book *b, int part)
{
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    int32_t lines = 0, channels = place_channels(b, part);
    exr_result_t code = exr_get_scanlines_per_chunk(b->call->exr, part, &lines);
    pave_result result = code || lines < 1 ? pv_exr_failure(b->call, code ? code : EXR_ERR_INVALID_ATTR) : PAVE_OK;
    for (int32_t y = 0; y < b->shape.height && !result; y += lines) {
        result = read_chunk(b, part, y, lines, channels, &pipeline);
        if (!result)
            result = pv_progress(b->call->context, (part + (double)y / b->shape.height) / b->shape.views);
    }
    exr_decoding_destroy(b->call->exr, &pipeline);
    return result;
}

/* The mask only stays if something is missing. */
static void judge_mask(book *b)
{
    size_t pairs = (size_t)b->shape.views * (size_t)b->shape.lights;
    if (memchr(b->btf->missing, 1, pairs))
        return;
    pv_release(b->btf->missing);
    b->btf->missing = NULL;
}

static pave_result read_parts(book *b, pave_btf **out)
{
    pave_context *context = b->call->context;
    pave_result result = check_parts(b);
    if (!result)
        result = pv_btf_new(context, &b->shape, out);
    if (result)
        return result;
    b->btf = *out;
    size_t run = (size_t)b->shape.lights * (size_t)b->shape.channels;
    size_t pairs = (size_t)b->shape.views * (size_t)b->shape.lights;
    b->btf->missing = pv_allocate(context, pairs, 1, &result);
    if (!result)
        b->place = pv_allocate(context, run, sizeof *b->place, &result);
    if (!result)
        b->run = pv_allocate(context, run, sizeof *b->run, &result);
    if (!result)
        result = pv_spool(context, b->call->path, b->btf);
    if (!result)
        memset(b->btf->missing, 1, pairs);
    for (int v = 0; v < b->shape.views && !result; v++)
        result = read_part(b, v);
    if (!result)
        judge_mask(b);
    return result;
}

pave_result pv_exr_btf_read(pave_context *context, pv_input *input, pave_btf **out)
{
    pv_exr_call call = { .context = context, .path = input->path, .input = input };
    book b = { .call = &call, .shape = PAVE_BTF_PARAMS_INIT };
    pv_exr_call *outer = pv_exr_enter(&call);
    exr_result_t code = pv_exr_start(&call);
    pave_result result = code ? pv_exr_failure(&call, code) : read_parts(&b, out);
    if (call.exr)
        exr_finish(&call.exr);
    pv_exr_enter(outer);
    pv_release(b.views);
    pv_release(b.place);
    pv_release(b.run);
    if (result)
        pave_btf_free(out);
    return result;
}
