/* Applying: images laid as a tiling says. */
#include "tiling/tiling.h"

#include "util/half.h"

#include <string.h>

static pave_result check_images(pave_context *context, const pave_tiling *t, const pave_image *const *images,
                                int32_t count)
{
    if (count != t->exemplars)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%d images for %d exemplars", (int)count, (int)t->exemplars);
    for (int32_t i = 0; i < count; i++) {
        const pave_image *image = images[i];
        if (!image)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "image %d is NULL", (int)i);
        if (image->width != t->sizes[i][0] || image->height != t->sizes[i][1])
            return pv_fail(context, PAVE_ERR_ARGUMENT, "a map of %d x %d px does not fit an exemplar of %d x %d px",
                           (int)image->width, (int)image->height, (int)t->sizes[i][0], (int)t->sizes[i][1]);
        if (image->channels != images[0]->channels || image->type != images[0]->type)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "map %d has other channels, or another type, than the first",
                           (int)i);
    }
    return PAVE_OK;
}

pave_result pv_image_like(pave_context *context, const pave_image *model, int32_t width, int32_t height,
                          pave_image **out)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    params.width = width;
    params.height = height;
    params.channels = model->channels;
    params.type = model->type;
    params.encoding = model->encoding;
    params.alpha = model->alpha;
    pave_result result = pv_image_new(context, &params, out);
    if (!result)
        memcpy((*out)->names, model->names, sizeof model->names);
    return result;
}

/* What becomes of a copy's values where it was turned. */
typedef enum map_kind { PLAIN, NORMALS_DOWN, NORMALS_UP } map_kind;

/* Whole numbers have 0 in the middle of their range. */
static void negate(int32_t type, void *value)
{
    switch (type) {
    case PAVE_U8: *(uint8_t *)value = (uint8_t)(UINT8_MAX - *(uint8_t *)value); break;
    case PAVE_U16: *(uint16_t *)value = (uint16_t)(UINT16_MAX - *(uint16_t *)value); break;
    case PAVE_U32: *(uint32_t *)value = UINT32_MAX - *(uint32_t *)value; break;
    case PAVE_F16: *(uint16_t *)value ^= 0x8000; break;
    default: *(float *)value = -*(float *)value;
    }
}

/* Mirrors and turns the first two values of a pixel with the copy it belongs to. */
static void turn_normal(int32_t type, char *pixel, int32_t turn, map_kind kind)
{
    size_t bytes = pv_type_bytes(type);
    char *x = pixel, *y = pixel + bytes, other[4];
    if (turn & 4)
        negate(type, x);
    for (int32_t quarter = turn & 3; quarter > 0; quarter--) {
        memcpy(other, x, bytes);
        memcpy(x, y, bytes);
        memcpy(y, other, bytes);
        negate(type, kind == NORMALS_UP ? y : x);
    }
}

static void copy_pixels(const pave_tiling *t, const pave_image *const *images, map_kind kind, pave_image *out)
{
    size_t pixel = (size_t)out->channels * pv_type_bytes(out->type);
    for (int64_t i = 0; i < (int64_t)t->width * t->height; i++) {
        const pave_source *s = &t->sources[i];
        const pave_image *image = images[s->exemplar];
        char *to = (char *)out->pixels + (size_t)i * pixel;
        memcpy(to, (const char *)image->pixels + ((size_t)s->y * (size_t)image->width + (size_t)s->x) * pixel, pixel);
        if (kind)
            turn_normal(out->type, to, s->turn, kind);
    }
}

/* The mean of two values, rounded to the nearest, halves up. */
static void average(int32_t type, void *there, const void *new)
{
    switch (type) {
    case PAVE_U8: *(uint8_t *)there = (uint8_t)((*(uint8_t *)there + *(const uint8_t *)new + 1) / 2); break;
    case PAVE_U16: *(uint16_t *)there = (uint16_t)((*(uint16_t *)there + *(const uint16_t *)new + 1) / 2); break;
    case PAVE_U32:
        *(uint32_t *)there = (uint32_t)(((uint64_t)*(uint32_t *)there + *(const uint32_t *)new + 1) / 2);
        break;
    case PAVE_F16:
        *(uint16_t *)there =
            pv_half((pv_half_value(*(uint16_t *)there) + pv_half_value(*(const uint16_t *)new)) / 2);
        break;
    default: *(float *)there = (*(float *)there + *(const float *)new) / 2;
    }
}

static void average_pixel(const pave_image *out, char *there, const char *new)
{
    size_t bytes = pv_type_bytes(out->type);
    for (int32_t c = 0; c < out->channels; c++)
        average(out->type, there + (size_t)c * bytes, new + (size_t)c * bytes);
}

/* The pixels of one block of mode paper, averaged with what lies there (Eq. 2). */
static void average_block(const pave_tiling *t, const pv_block *b, const pave_image *image, map_kind kind,
                          uint8_t *laid, pave_image *out)
{
    size_t pixel = (size_t)out->channels * pv_type_bytes(out->type);
    char new[PV_MOST_CHANNELS * sizeof(uint32_t)];
    for (int32_t k = 0; k < b->width * b->height; k++) {
        size_t to = (size_t)(b->y + k / b->width) * (size_t)t->width + (size_t)(b->x + k % b->width);
        int32_t x = b->from.x + k % b->width * b->right[0] + k / b->width * b->down[0];
        int32_t y = b->from.y + k % b->width * b->right[1] + k / b->width * b->down[1];
        memcpy(new, (const char *)image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) * pixel, pixel);
        if (kind)
            turn_normal(out->type, new, b->from.turn, kind);
        if (laid[to])
            average_pixel(out, (char *)out->pixels + to * pixel, new);
        else
            memcpy((char *)out->pixels + to * pixel, new, pixel);
        laid[to] = 1;
    }
}

/* Mode paper: blocks as they were laid. */
static pave_result average_blocks(pave_context *context, const pave_tiling *t, const pave_image *const *images,
                                  map_kind kind, pave_image *out)
{
    pave_result result = PAVE_OK;
    uint8_t *laid = pv_allocate_zeroed(context, (size_t)t->width * (size_t)t->height, 1, &result);
    for (int32_t i = 0; i < t->block_count && !result; i++)
        average_block(t, &t->blocks[i], images[t->blocks[i].from.exemplar], kind, laid, out);
    pv_release(laid);
    return result;
}

static pave_result apply(pave_context *context, const pave_tiling *tiling, const pave_image *const *images,
                         int32_t count, map_kind kind, pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !tiling || !images || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = check_images(context, tiling, images, count);
    if (!result && kind && images[0]->channels < 2)
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "a normal map has two channels or more, this one %d",
                         (int)images[0]->channels);
    if (!result)
        result = pv_image_like(context, images[0], tiling->width, tiling->height, out);
    if (!result && tiling->blocks)
        result = average_blocks(context, tiling, images, kind, *out);
    else if (!result)
        copy_pixels(tiling, images, kind, *out);
    if (result)
        pave_image_free(out);
    return result;
}

pave_result pave_tiling_apply(pave_context *context, const pave_tiling *tiling, const pave_image *const *images,
                              int32_t count, pave_image **out)
{
    return apply(context, tiling, images, count, PLAIN, out);
}

pave_result pave_tiling_apply_normals(pave_context *context, const pave_tiling *tiling,
                                      const pave_image *const *images, int32_t count, int32_t up, pave_image **out)
{
    return apply(context, tiling, images, count, up ? NORMALS_UP : NORMALS_DOWN, out);
}

pave_result pave_tiling_source_image(pave_context *context, const pave_tiling *tiling, pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !tiling || !out)
        return PAVE_ERR_ARGUMENT;
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    params.width = tiling->width;
    params.height = tiling->height;
    params.channels = 4;
    params.type = PAVE_U32;
    params.encoding = PAVE_DATA;
    params.names = "exemplar,x,y,turn";
    pave_result result = pv_image_new(context, &params, out);
    if (!result)
        memcpy((*out)->pixels, tiling->sources, (size_t)tiling->width * (size_t)tiling->height * sizeof(pave_source));
    return result;
}
