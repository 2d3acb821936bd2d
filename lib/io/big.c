/* UTIA's BIG files: chunks of an identifier, a length and that many bytes. All are walked before any is believed. */
#include "io/big.h"

#include "io/spool.h"
#include "image/image.h"
#include "util/half.h"
#include "util/light.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { IMAGES, TILES, HEIGHT, WIDTH, PLANES, AXES };
enum { HALF = 1, FLOAT = 2, DOUBLE = 3, BYTE = 5, WORD = 7, MIXED = 0 }; /* types, as 3.0 numbers them */

static const double degree = 3.14159265358979323846 / 180;

/* What a file says of itself. */
typedef struct big {
    pave_context *context;
    const char *path;
    const uint8_t *bytes, *data;
    size_t size, data_size;
    const pave_btf_file_params *params;
    uint64_t extent[AXES], order[AXES]; /* order: outermost first */
    uint64_t type;
    const uint8_t *types; /* of each image, if they differ */
    size_t types_step;
    const uint8_t *angles;
    int wide_angles; /* doubles and not floats */
    int old, later;
    double pixels_per_mm;
    uint64_t stride[AXES]; /* values from one to the next */
    pv_shot *shots;
} big;

static uint64_t whole(const uint8_t *p)
{
    uint64_t value = 0;
    for (int i = 8; i-- > 0;)
        value = value << 8 | p[i];
    return value;
}

static double real(const uint8_t *p, int is_wide)
{
    double wide;
    float narrow;
    return is_wide ? (memcpy(&wide, p, 8), wide) : (memcpy(&narrow, p, 4), (double)narrow);
}

static const uint8_t magic[8] = "BIG";

int pv_is_big(const uint8_t *bytes, size_t size)
{
    return size > 40 && (!memcmp(bytes, magic, 8) || (whole(bytes) == 4 && whole(bytes + 8) == 8 && whole(bytes + 16) &&
                                                      whole(bytes + 16) < 1 << 24 && whole(bytes + 24) <= 32));
}

static pave_result damaged(const big *b, const char *reason)
{
    return pv_fail(b->context, PAVE_ERR_FORMAT, "%s: is a damaged BIG file: %s", b->path, reason);
}

/* Calls `take` for each chunk; 0 if they do not end with the file. Old files may or may not fill up to 8 bytes. */
static int walk(big *b, int fill, void (*take)(big *b, uint64_t id, const uint8_t *p, uint64_t length))
{
    size_t at = b->old ? 0 : sizeof magic;
    while (at < b->size) {
        if (b->size - at < 16)
            return 0;
        uint64_t id = whole(b->bytes + at), length = whole(b->bytes + at + 8), padded = length;
        at += 16;
        if (length > b->size - at)
            return 0;
        if (fill && length % 8)
            padded += 8 - length % 8;
        if (padded > b->size - at)
            padded = b->size - at; /* the last one may go without */
        if (take)
            take(b, id, b->bytes + at, length);
        at += padded;
    }
    return 1;
}

static void take_chunk(big *b, uint64_t id, const uint8_t *p, uint64_t length)
{
    if (id >= 1 && id <= 5 && length >= 8)
        b->extent[id - 1] = whole(p);
    else if (id == 6 && length == 8 * AXES)
        for (int i = 0; i < AXES; i++)
            b->order[i] = whole(p + 8 * i) - 1;
    else if (id == 6)
        b->later = 1;
    else if (id == 7 && length >= 8) {
        b->type = whole(p);
        b->types = b->type == MIXED ? p + 8 : NULL;
        b->types_step = (length - 8) / 8; /* held against the images later */
    } else if (id == 8)
        b->data = p, b->data_size = length;
    else if (id == 11 && length >= 8)
        b->pixels_per_mm = real(p, 1);
    else if (id == 16 && length >= 8 && (whole(p) == 3 || (whole(p) == 4 && !b->angles)) &&
             b->extent[IMAGES] == (length - 8) / 32)
        b->angles = p + 8, b->wide_angles = 1;
}

static void take_old_chunk(big *b, uint64_t id, const uint8_t *p, uint64_t length)
{
    static const int axis[5] = { 0, WIDTH, HEIGHT, PLANES, IMAGES };
    if (id >= 1 && id <= 4 && length >= 8)
        b->extent[axis[id]] = whole(p);
    else if (id == 20 && length >= 8)
        b->extent[TILES] = whole(p);
    else if (id == 5 && length >= 8)
        b->type = whole(p) == 2 ? HALF : whole(p) == 4 ? FLOAT : whole(p) == UINT64_MAX ? MIXED : UINT64_MAX;
    else if (id == 6)
        b->data = p, b->data_size = length;
    else if (id == 7)
        b->types = p, b->types_step = length;
    else if (id == 9 && length >= 4)
        b->pixels_per_mm = real(p, 0);
    else if ((id == 14 || (id == 15 && !b->angles)) && length / 16 == b->extent[IMAGES])
        b->angles = p;
}

static size_t bytes_of(uint64_t type)
{
    switch (type) {
    case HALF: case WORD: return 2;
    case FLOAT: return 4;
    case DOUBLE: return 8;
    case BYTE: return 1;
    default: return 0;
    }
}

/* The type of an image where they differ. */
static uint64_t type_of(const big *b, uint64_t image)
{
    if (b->type != MIXED)
        return b->type;
    return b->old ? (b->types[image] == 2 ? HALF : b->types[image] == 4 ? FLOAT : UINT64_MAX)
                  : whole(b->types + 8 * image);
}

static pave_result check_extents(big *b)
{
    double values = 1;
    unsigned seen = 0;
    for (int i = 0; i < AXES; i++) {
        seen |= b->order[i] < AXES ? 1u << b->order[i] : 0;
        values *= (double)b->extent[i];
    }
    if (seen != (1u << AXES) - 1)
        return damaged(b, "its order of data makes no sense");
    if (values < 1 || b->extent[PLANES] > PV_BTF_CHANNELS || b->extent[IMAGES] > 1 << 24)
        return damaged(b, "it has no images, or too many, or too many planes");
    if (values > (double)b->data_size)
        return damaged(b, "it is cut short");
    pave_result result = pv_check_size(b->context, b->path, (int64_t)b->extent[WIDTH], (int64_t)b->extent[HEIGHT]);
    uint64_t stride = 1;
    for (int i = AXES; i-- > 0;) {
        b->stride[b->order[i]] = stride;
        stride *= b->extent[b->order[i]];
    }
    return result;
}

/* Do the values of all images fill the data? */
static pave_result check_types(const big *b)
{
    uint64_t each = b->extent[TILES] * b->extent[HEIGHT] * b->extent[WIDTH] * b->extent[PLANES], bytes = 0;
    if (b->type == MIXED && (b->order[0] != IMAGES || !b->types || b->types_step < b->extent[IMAGES]))
        return damaged(b, "it does not say the types of its images");
    for (uint64_t i = 0; i < b->extent[IMAGES]; i++) {
        size_t size = bytes_of(type_of(b, i));
        if (!size)
            return pv_fail(b->context, PAVE_ERR_UNSUPPORTED, "%s: its values have a type that is not read", b->path);
        bytes += each * size;
    }
    if (bytes > b->data_size || b->data_size - bytes >= 8)
        return damaged(b, "its data have not the size that its images make");
    return PAVE_OK;
}

static pave_result read_chunks(big *b)
{
    const uint64_t usual[AXES] = { IMAGES, TILES, HEIGHT, WIDTH, PLANES };
    memcpy(b->order, usual, sizeof usual);
    b->extent[TILES] = b->extent[PLANES] = 1;
    b->type = b->old ? UINT64_MAX : FLOAT;
    int fill = !b->old || walk(b, 1, NULL);
    if (!walk(b, fill, NULL))
        return damaged(b, "its chunks do not end where it ends");
    walk(b, fill, b->old ? take_old_chunk : take_chunk);
    if (!b->old && (b->later || !b->data))
        return pv_fail(b->context, PAVE_ERR_UNSUPPORTED, "%s: is no BIG file of version 3.0, and no other is read",
                       b->path);
    if (!b->data)
        return damaged(b, "it has no data");
    pave_result result = check_extents(b);
    return result ? result : check_types(b);
}

/* Without a list of directions, images by the number of a known set are taken as the sets are ordered. */
static pave_result guess_angles(big *b)
{
    pave_direction d[256];
    for (int32_t set = 0; set < 2; set++) {
        int32_t count = pave_directions(set, d, 256);
        if (b->extent[IMAGES] != (uint64_t)count * (uint64_t)count)
            continue;
        for (int32_t i = 0; i < count * count; i++) {
            const pave_direction *v = &d[i / count], *l = &d[i % count];
            b->shots[i] = (pv_shot){ { l->theta / degree, l->phi / degree },
                                     { v->theta / degree, v->phi / degree }, i };
        }
        pv_note(b->context, PAVE_MESSAGE_WARNING, "%s: lists no directions; taken as %d views of %d lights each",
                b->path, (int)count, (int)count);
        return PAVE_OK;
    }
    return pv_fail(b->context, PAVE_ERR_UNSUPPORTED, "%s: lists no directions of its images", b->path);
}

/* Degrees, unless no inclination is beyond a right angle in radians. */
static pave_result read_angles(big *b)
{
    pave_result result = PAVE_OK;
    uint64_t images = b->extent[IMAGES];
    double most = 0;
    b->shots = pv_allocate(b->context, (size_t)images, sizeof *b->shots, &result);
    if (result)
        return result;
    if (!b->angles)
        return guess_angles(b);
    size_t step = b->wide_angles ? 8 : 4;
    for (uint64_t i = 0; i < images; i++) {
        double a[4];
        for (size_t k = 0; k < 4; k++) {
            a[k] = real(b->angles + (4 * i + k) * step, b->wide_angles);
            if (!(fabs(a[k]) < 1000))
                return damaged(b, "a direction is not a number");
        }
        b->shots[i] = (pv_shot){ { a[0], a[1] }, { a[2], a[3] }, (int64_t)i };
        most = fmax(most, fmax(a[0], a[2]));
    }
    for (uint64_t i = 0; i < images && most < 1.5709; i++)
        for (int k = 0; k < 2; k++) {
            b->shots[i].light[k] /= degree;
            b->shots[i].view[k] /= degree;
        }
    return PAVE_OK;
}

static float value_at(const big *b, const uint8_t *p, uint64_t type)
{
    uint16_t half;
    double code;
    switch (type) {
    case HALF: return memcpy(&half, p, 2), pv_half_value(half);
    case FLOAT: return (float)real(p, 0);
    case DOUBLE: return (float)real(p, 1);
    case BYTE: code = p[0] / 255.0; break;
    default: code = (p[0] | p[1] << 8) / 65535.0;
    }
    return (float)(b->params->gamma == PAVE_BTF_GAMMA_22 ? pow(code, 2.2) : pv_linear_light(code));
}

/* The first tile of an image. */
static pave_result read_image(void *user, int64_t source, float *out)
{
    const big *b = user;
    uint64_t type = type_of(b, (uint64_t)source);
    const uint8_t *from = b->data;
    const uint64_t *stride = b->stride;
    size_t size = bytes_of(type);
    for (int64_t i = 0; i < source && b->type == MIXED; i++)
        from += b->stride[IMAGES] * bytes_of(type_of(b, (uint64_t)i));
    if (b->type != MIXED)
        from += b->stride[IMAGES] * (uint64_t)source * size;
    for (uint64_t y = 0; y < b->extent[HEIGHT]; y++)
        for (uint64_t x = 0; x < b->extent[WIDTH]; x++)
            for (uint64_t c = 0; c < b->extent[PLANES]; c++)
                *out++ = value_at(b, from + (y * stride[HEIGHT] + x * stride[WIDTH] + c * stride[PLANES]) * size,
                                  type);
    return PAVE_OK;
}

static void name_image(void *user, int64_t source, char *out, size_t room)
{
    (void)user;
    snprintf(out, room, "image %lld", (long long)source);
}

static int same(const double *a, const double *b)
{
    return a[0] == b[0] && a[1] == b[1];
}

/* Lights of each view, if the images are view after view under the same lights; otherwise 0. */
static int64_t grid_lights(const big *b)
{
    int64_t images = (int64_t)b->extent[IMAGES], lights = 1;
    while (lights < images && same(b->shots[lights].view, b->shots[0].view))
        lights++;
    for (int64_t i = 0; i < images; i++)
        if (!same(b->shots[i].view, b->shots[i / lights * lights].view) ||
            !same(b->shots[i].light, b->shots[i % lights].light))
            return 0;
    return images % lights ? 0 : lights;
}

/* Samples that lie as a BTF holds them: texels, then images, then planes. */
static int lies_right(const big *b)
{
    return (b->type == HALF || b->type == FLOAT) && b->stride[PLANES] == 1 && b->extent[TILES] == 1 &&
           b->stride[IMAGES] == b->extent[PLANES] && b->stride[WIDTH] == b->extent[PLANES] * b->extent[IMAGES] &&
           b->stride[HEIGHT] == b->stride[WIDTH] * b->extent[WIDTH] && grid_lights(b);
}

static pave_result map_samples(big *b, pave_btf_params *shape, pave_btf **out)
{
    pave_result result = PAVE_OK;
    shape->lights = (int32_t)grid_lights(b);
    shape->views = (int32_t)((int64_t)b->extent[IMAGES] / shape->lights);
    pave_direction *d = pv_allocate(b->context, (size_t)shape->lights + (size_t)shape->views, sizeof *d, &result);
    for (int32_t i = 0; i < shape->lights + shape->views && !result; i++) {
        int64_t view = (int64_t)(i - shape->lights) * shape->lights;
        const double *a = i < shape->lights ? b->shots[i].light : b->shots[view].view;
        d[i] = (pave_direction){ (float)(a[0] * degree), (float)(a[1] * degree) };
    }
    shape->light_directions = d;
    shape->view_directions = d + shape->lights;
    if (!result)
        result = pv_btf_new(b->context, shape, out);
    if (!result)
        pv_btf_place_samples(*out, (void *)(uintptr_t)b->data);
    pv_release(d);
    return result;
}

static pave_result read_samples(big *b, int *keeps, pave_btf **out)
{
    pave_btf_params shape = PAVE_BTF_PARAMS_INIT;
    shape.width = (int32_t)b->extent[WIDTH];
    shape.height = (int32_t)b->extent[HEIGHT];
    shape.channels = (int32_t)b->extent[PLANES];
    shape.type = PAVE_F16;
    for (uint64_t i = 0; i < b->extent[IMAGES]; i++)
        shape.type = type_of(b, i) == HALF || type_of(b, i) == BYTE ? shape.type : PAVE_F32;
    shape.pixels_per_mm = b->pixels_per_mm >= 0 && isfinite(b->pixels_per_mm) ? b->pixels_per_mm : 0;
    if (b->extent[TILES] > 1)
        pv_note(b->context, PAVE_MESSAGE_INFO, "%s: the first of its %llu tiles is read", b->path,
                (unsigned long long)b->extent[TILES]);
    *keeps = lies_right(b);
    if (*keeps)
        return map_samples(b, &shape, out);
    pv_album album = { b->path, shape, b->shots, (int64_t)b->extent[IMAGES], read_image, name_image, b };
    return pv_album_read(b->context, &album, out);
}

pave_result pv_big_read(pave_context *context, const char *path, const uint8_t *bytes, size_t size,
                        const pave_btf_file_params *params, int *keeps, pave_btf **out)
{
    big b = { .context = context, .path = path, .bytes = bytes, .size = size, .params = params,
              .old = memcmp(bytes, magic, 8) != 0 };
    *keeps = 0;
    pave_result result = read_chunks(&b);
    if (!result)
        result = read_angles(&b);
    if (!result)
        result = read_samples(&b, keeps, out);
    pv_release(b.shots);
    if (result)
        pave_btf_free(out);
    return result;
}
