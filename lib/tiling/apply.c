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

static void copy_pixels(const pave_tiling *t, const pave_image *const *images, pave_image *out)
{
    size_t pixel = (size_t)out->channels * pv_type_bytes(out->type);
    for (int64_t i = 0; i < (int64_t)t->width * t->height; i++) {
        const pave_source *s = &t->sources[i];
        const pave_image *image = images[s->exemplar];
        memcpy((char *)out->pixels + (size_t)i * pixel,
               (const char *)image->pixels + ((size_t)s->y * (size_t)image->width + (size_t)s->x) * pixel, pixel);
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

/* Mode paper: blocks as they were laid, averaged where they overlap (Eq. 2). */
static pave_result average_blocks(pave_context *context, const pave_tiling *t, const pave_image *const *images,
                                  pave_image *out)
{
    pave_result result = PAVE_OK;
    size_t pixel = (size_t)out->channels * pv_type_bytes(out->type);
    uint8_t *laid = pv_allocate_zeroed(context, (size_t)t->width * (size_t)t->height, 1, &result);
    for (int32_t i = 0; i < t->block_count && !result; i++) {
        const pv_block *b = &t->blocks[i];
        const pave_image *image = images[b->from.exemplar];
        for (int32_t k = 0; k < b->width * b->height; k++) {
            size_t to = (size_t)(b->y + k / b->width) * (size_t)t->width + (size_t)(b->x + k % b->width);
            int32_t x = b->from.x + k % b->width * b->right[0] + k / b->width * b->down[0];
            int32_t y = b->from.y + k % b->width * b->right[1] + k / b->width * b->down[1];
            const char *new = (const char *)image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) * pixel;
            if (laid[to])
                average_pixel(out, (char *)out->pixels + to * pixel, new);
            else
                memcpy((char *)out->pixels + to * pixel, new, pixel);
            laid[to] = 1;
        }
    }
    pv_release(laid);
    return result;
}

pave_result pave_tiling_apply(pave_context *context, const pave_tiling *tiling, const pave_image *const *images,
                              int32_t count, pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !tiling || !images || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = check_images(context, tiling, images, count);
    if (!result)
        result = pv_image_like(context, images[0], tiling->width, tiling->height, out);
    if (!result && tiling->blocks)
        result = average_blocks(context, tiling, images, *out);
    else if (!result)
        copy_pixels(tiling, images, *out);
    if (result)
        pave_image_free(out);
    return result;
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
