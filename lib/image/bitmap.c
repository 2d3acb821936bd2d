/* A drawing with one bit a pixel. */
#include "image/bitmap.h"

#include "util/fixed.h"

#include <string.h>

pave_result pv_bitmap_create(pave_context *context, int32_t width, int32_t height, pv_bitmap *out)
{
    pave_result result = PAVE_OK;
    *out = (pv_bitmap){ width, height, ((int64_t)width + 7) / 8, NULL };
    out->bits = pv_allocate_zeroed(context, (size_t)out->stride, (size_t)height, &result);
    return result;
}

void pv_bitmap_free(pv_bitmap *bitmap)
{
    pv_release(bitmap->bits);
    bitmap->bits = NULL;
}

void pv_bitmap_store(pv_bitmap *bitmap, int32_t y, const pave_image *drawing)
{
    const uint8_t *pixels = drawing->pixels;
    for (int32_t row = 0; row < drawing->height; row++, pixels += drawing->width) {
        uint8_t *bits = bitmap->bits + (y + row) * bitmap->stride;
        for (int32_t x = 0; x < drawing->width; x++)
            bits[x >> 3] |= (uint8_t)((pixels[x] >> 7) << (7 - (x & 7)));
    }
}

pave_result pv_bitmap_cut(pave_context *context, const pv_bitmap *bitmap, int32_t x, int32_t y, int32_t width,
                          int32_t height, pave_image **out)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = width;
    shape.height = height;
    pave_result result = pv_image_new(context, &shape, out);
    if (result)
        return result;
    (*out)->place = (pv_place){ x, y, bitmap->width, bitmap->height };
    uint8_t *pixel = (*out)->pixels;
    for (int32_t row = y; row < y + height; row++) {
        const uint8_t *bits = bitmap->bits + pv_modulo(row, bitmap->height) * bitmap->stride;
        for (int32_t i = 0, column = pv_modulo(x, bitmap->width); i < width; i++, column++) {
            column = column < bitmap->width ? column : 0;
            *pixel++ = bits[column >> 3] >> (7 - (column & 7)) & 1 ? 255 : 0;
        }
    }
    return PAVE_OK;
}

/* FNV-1a by words. */
uint64_t pv_bitmap_hash(const pv_bitmap *bitmap)
{
    const uint64_t prime = 1099511628211u;
    uint64_t hash = 14695981039346656037u ^ (uint64_t)(uint32_t)bitmap->width << 32 ^ (uint32_t)bitmap->height;
    int64_t size = bitmap->stride * bitmap->height, i = 0;
    for (; i + 8 <= size; i += 8) {
        uint64_t word;
        memcpy(&word, bitmap->bits + i, sizeof word);
        hash = (hash ^ word) * prime;
        hash ^= hash >> 29;
    }
    for (; i < size; i++)
        hash = (hash ^ bitmap->bits[i]) * prime;
    return hash ? hash : 1;
}
