/* Models as binary glTF 2.0: a head, what there is in JSON, and the numbers and pictures themselves. */
#include <pave/io.h>

#include "io/codec.h"
#include "io/output.h"
#include "image/image.h"
#include "maps/model.h"
#include "util/json.h"

#include <errno.h>
#include <math.h>
#include <string.h>

enum { ROWS_AT_ONCE = 64, PIECES = 8 };
enum { FLOAT = 5126, UNSIGNED_INT = 5125, VERTICES = 34962, INDICES = 34963, LINEAR = 9729, CLAMP = 33071 };

/* Bytes that grow. */
typedef struct store {
    pave_context *context;
    char *bytes;
    size_t size, room;
    pave_result result;
} store;

static int32_t store_at(void *user, int64_t offset, const void *bytes, size_t size)
{
    store *s = user;
    size_t end = (size_t)offset + size, room = s->room ? s->room : 1 << 16;
    while (room < end)
        room *= 2;
    if (!s->result && room > s->room) {
        char *grown = s->bytes ? pv_resize(s->context, s->bytes, s->size, room, 1, &s->result)
                               : pv_allocate(s->context, room, 1, &s->result);
        if (!s->result)
            s->bytes = grown, s->room = room;
    }
    if (s->result)
        return 0;
    memcpy(s->bytes + offset, bytes, size);
    s->size = end > s->size ? end : s->size;
    return 1;
}

static void store_text(void *user, const char *text, size_t length)
{
    store_at(user, (int64_t)((store *)user)->size, text, length);
}

/* A piece of the file's binary part. */
typedef struct piece {
    const void *bytes;
    size_t size, offset;
    int32_t target; /* 0: none */
} piece;

typedef struct writing {
    pave_context *context;
    const pave_model *model;
    piece pieces[PIECES];
    int32_t count, positions, normals, coordinates, colours, triangles, pictures[PAVE_SKIN_COUNT];
    store png[PAVE_SKIN_COUNT];
    size_t size; /* of all pieces */
} writing;

static pave_result encode_rows(pave_context *context, const pave_image *image, pv_codec_job *job, char *text)
{
    pave_result result = PAVE_OK;
    size_t row = (size_t)image->width * (size_t)image->channels * pv_type_bytes(image->type);
    for (int32_t y = 0, end; y < image->height && !result; y = end) {
        end = image->height - y < ROWS_AT_ONCE ? image->height : y + ROWS_AT_ONCE;
        result = pv_png.write(job, y, end, (const char *)image->pixels + (size_t)y * row, text);
        if (!result)
            result = pv_progress(context, (double)end / image->height);
    }
    return result ? result : pv_png.finish(job, text);
}

static pave_result encode(pave_context *context, const char *path, const pave_image *image, store *out)
{
    char text[PV_CODEC_TEXT] = "";
    pv_codec_job *job = NULL;
    pv_picture picture = { .width = image->width, .height = image->height, .channels = image->channels,
                           .type = image->type, .linear = image->encoding == PAVE_DATA, .alpha = -1,
                           .columns = image->width, .rows = 1 };
    pave_result result = pv_png.encode(context, "png", &picture, store_at, out, &job, text);
    if (!result) {
        result = encode_rows(context, image, job, text);
        pv_png.close(job);
    }
    if (out->result)
        return out->result;
    return result && *text ? pv_fail(context, result, "%s: the image codec failed: %s", path, text) : result;
}

/* The next piece; each begins at a multiple of four bytes. */
static int32_t add_piece(writing *w, const void *bytes, size_t size, int32_t target)
{
    if (!bytes)
        return -1;
    w->pieces[w->count] = (piece){ bytes, size, w->size, target };
    w->size += (size + 3) / 4 * 4;
    return w->count++;
}

static pave_result gather(writing *w, const char *path)
{
    const pave_model *m = w->model;
    size_t n = (size_t)m->vertices;
    w->positions = add_piece(w, m->position, n * 12, VERTICES);
    w->normals = add_piece(w, m->normal, n * 12, VERTICES);
    w->coordinates = add_piece(w, m->coordinate, n * 8, VERTICES);
    w->colours = add_piece(w, m->colour, n * 12, VERTICES);
    w->triangles = add_piece(w, m->triangle, (size_t)m->triangles * 12, INDICES);
    for (int i = 0; i < PAVE_SKIN_COUNT; i++) {
        w->png[i].context = w->context;
        pv_call call = pv_call_begin(w->context, "write", i / 4.0, (i + 1) / 4.0);
        pave_result result = m->picture[i] ? encode(w->context, path, m->picture[i], &w->png[i]) : PAVE_OK;
        pv_call_end(w->context, call);
        if (result)
            return result;
        w->pictures[i] = add_piece(w, w->png[i].bytes, w->png[i].size, 0);
    }
    return PAVE_OK;
}

static void put_numbers(pv_json *json, const char *key, const float *numbers, int32_t count)
{
    pv_json_array(json, key);
    for (int32_t i = 0; i < count; i++)
        pv_json_number(json, NULL, (double)numbers[i]);
    pv_json_close(json);
}

static void put_accessor(pv_json *json, int32_t view, int32_t type, int64_t count, const char *shape,
                         const float *range)
{
    if (view < 0)
        return;
    pv_json_object(json, NULL);
    pv_json_whole(json, "bufferView", view);
    pv_json_whole(json, "componentType", type);
    pv_json_whole(json, "count", count);
    pv_json_string(json, "type", shape);
    if (range) {
        put_numbers(json, "min", range, 3);
        put_numbers(json, "max", range + 3, 3);
    }
    pv_json_close(json);
}

/* Accessors have the numbers of their pieces, for the pictures come last. */
static void put_accessors(const writing *w, pv_json *json)
{
    const pave_model *m = w->model;
    float range[6] = { INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY };
    for (int64_t i = 0; i < 3 * m->vertices; i++) {
        range[i % 3] = m->position[i] < range[i % 3] ? m->position[i] : range[i % 3];
        range[3 + i % 3] = m->position[i] > range[3 + i % 3] ? m->position[i] : range[3 + i % 3];
    }
    pv_json_array(json, "accessors");
    put_accessor(json, w->positions, FLOAT, m->vertices, "VEC3", range);
    put_accessor(json, w->normals, FLOAT, m->vertices, "VEC3", NULL);
    put_accessor(json, w->coordinates, FLOAT, m->vertices, "VEC2", NULL);
    put_accessor(json, w->colours, FLOAT, m->vertices, "VEC3", NULL);
    put_accessor(json, w->triangles, UNSIGNED_INT, 3 * m->triangles, "SCALAR", NULL);
    pv_json_close(json);
}

static void put_views(const writing *w, pv_json *json)
{
    pv_json_array(json, "bufferViews");
    for (int32_t i = 0; i < w->count; i++) {
        pv_json_object(json, NULL);
        pv_json_whole(json, "buffer", 0);
        pv_json_whole(json, "byteOffset", (int64_t)w->pieces[i].offset);
        pv_json_whole(json, "byteLength", (int64_t)w->pieces[i].size);
        if (w->pieces[i].target)
            pv_json_whole(json, "target", w->pieces[i].target);
        pv_json_close(json);
    }
    pv_json_close(json);
    pv_json_array(json, "buffers");
    pv_json_object(json, NULL);
    pv_json_whole(json, "byteLength", (int64_t)w->size);
    pv_json_close(json);
    pv_json_close(json);
}

static void put_texture(pv_json *json, const char *key, int32_t index)
{
    pv_json_object(json, key);
    pv_json_whole(json, "index", index);
    pv_json_close(json);
}

static void put_material(const writing *w, pv_json *json)
{
    int painted = w->pictures[PAVE_SKIN_COLOUR] >= 0;
    pv_json_array(json, "materials");
    pv_json_object(json, NULL);
    pv_json_string(json, "name", "stones and joints");
    pv_json_object(json, "pbrMetallicRoughness");
    if (painted) {
        put_texture(json, "baseColorTexture", PAVE_SKIN_COLOUR);
        put_texture(json, "metallicRoughnessTexture", PAVE_SKIN_SURFACE);
    }
    pv_json_number(json, "metallicFactor", 0);
    pv_json_number(json, "roughnessFactor", painted ? 1 : w->model->roughness);
    pv_json_close(json);
    if (painted)
        put_texture(json, "occlusionTexture", PAVE_SKIN_SURFACE);
    if (w->pictures[PAVE_SKIN_NORMAL] >= 0)
        put_texture(json, "normalTexture", PAVE_SKIN_NORMAL);
    pv_json_close(json);
    pv_json_close(json);
}

static void put_pictures(const writing *w, pv_json *json)
{
    int32_t count = 0;
    while (count < PAVE_SKIN_COUNT && w->pictures[count] >= 0)
        count++;
    if (!count)
        return;
    pv_json_array(json, "samplers");
    pv_json_object(json, NULL);
    pv_json_whole(json, "magFilter", LINEAR);
    pv_json_whole(json, "minFilter", LINEAR);
    pv_json_whole(json, "wrapS", CLAMP);
    pv_json_whole(json, "wrapT", CLAMP);
    pv_json_close(json);
    pv_json_close(json);
    pv_json_array(json, "textures");
    for (int32_t i = 0; i < count; i++) {
        pv_json_object(json, NULL);
        pv_json_whole(json, "sampler", 0);
        pv_json_whole(json, "source", i);
        pv_json_close(json);
    }
    pv_json_close(json);
    pv_json_array(json, "images");
    for (int32_t i = 0; i < count; i++) {
        pv_json_object(json, NULL);
        pv_json_whole(json, "bufferView", w->pictures[i]);
        pv_json_string(json, "mimeType", "image/png");
        pv_json_close(json);
    }
    pv_json_close(json);
}

/* An array of one object, which is left open. */
static void open_only(pv_json *json, const char *key)
{
    pv_json_array(json, key);
    pv_json_object(json, NULL);
}

static void close_both(pv_json *json)
{
    pv_json_close(json);
    pv_json_close(json);
}

static void put_mesh(const writing *w, pv_json *json)
{
    open_only(json, "meshes");
    pv_json_string(json, "name", "pavement");
    open_only(json, "primitives");
    pv_json_object(json, "attributes");
    pv_json_whole(json, "POSITION", w->positions);
    pv_json_whole(json, "NORMAL", w->normals);
    if (w->coordinates >= 0)
        pv_json_whole(json, "TEXCOORD_0", w->coordinates);
    if (w->colours >= 0)
        pv_json_whole(json, "COLOR_0", w->colours);
    pv_json_close(json);
    pv_json_whole(json, "indices", w->triangles);
    pv_json_whole(json, "material", 0);
    close_both(json);
    close_both(json);
}

static void put_scene(const writing *w, pv_json *json)
{
    pv_json_object(json, "asset");
    pv_json_string(json, "version", "2.0");
    pv_json_string(json, "generator", "libpave " PAVE_VERSION_STRING);
    pv_json_close(json);
    pv_json_whole(json, "scene", 0);
    open_only(json, "scenes");
    pv_json_array(json, "nodes");
    pv_json_whole(json, NULL, 0);
    pv_json_close(json);
    close_both(json);
    open_only(json, "nodes");
    pv_json_string(json, "name", "pavement");
    pv_json_whole(json, "mesh", 0);
    close_both(json);
    put_mesh(w, json);
}

static pave_result describe(const writing *w, store *out)
{
    pv_json json;
    out->context = w->context;
    pv_json_begin(&json, store_text, out);
    pv_json_object(&json, NULL);
    put_scene(w, &json);
    put_material(w, &json);
    put_pictures(w, &json);
    put_accessors(w, &json);
    put_views(w, &json);
    pv_json_close(&json);
    while (out->size % 4 && !out->result)
        store_text(out, " ", 1);
    return out->result;
}

static void put_word(pv_output *output, size_t value)
{
    const uint8_t bytes[4] = { (uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16), (uint8_t)(value >> 24) };
    pv_output_bytes(output, bytes, sizeof bytes);
}

static void put_chunk(pv_output *output, size_t size, const char *kind)
{
    put_word(output, size);
    pv_output_bytes(output, kind, 4);
}

static pave_result write_file(const writing *w, const store *text, const char *path)
{
    static const char zeros[4];
    const uint32_t one = 1;
    double size = 28 + (double)text->size + (double)w->size;
    pv_output *output;
    if (size > UINT32_MAX)
        return pv_fail(w->context, PAVE_ERR_LIMIT, "%s: a model of %.0f bytes is beyond the 4 GiB of a GLB file", path,
                       size);
    if (!*(const uint8_t *)&one) /* numbers are written as they lie in memory */
        return pv_fail(w->context, PAVE_ERR_UNSUPPORTED, "models are written on little-endian machines");
    pave_result result = pv_output_open(w->context, path, 0, &output);
    if (result)
        return result;
    pv_output_bytes(output, "glTF", 4);
    put_word(output, 2);
    put_word(output, (size_t)size);
    put_chunk(output, text->size, "JSON");
    pv_output_bytes(output, text->bytes, text->size);
    put_chunk(output, w->size, "BIN\0");
    for (int32_t i = 0; i < w->count; i++) {
        pv_output_bytes(output, w->pieces[i].bytes, w->pieces[i].size);
        pv_output_bytes(output, zeros, (4 - w->pieces[i].size % 4) % 4);
    }
    return pv_output_close(output, pv_progress(w->context, 1));
}

pave_result pave_model_write(pave_context *context, const pave_model *model, const char *path)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!model || !path)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_model_write: model or path is NULL");
    int before = errno;
    writing w = { .context = context, .model = model };
    store text = { .context = context };
    pv_call outer = pv_call_begin(context, "write", 0, 1);
    pave_result result = gather(&w, path);
    if (!result)
        result = describe(&w, &text);
    if (!result)
        result = write_file(&w, &text, path);
    for (int i = 0; i < PAVE_SKIN_COUNT; i++)
        pv_release(w.png[i].bytes);
    pv_release(text.bytes);
    pv_call_end(context, outer);
    errno = before;
    return result;
}
