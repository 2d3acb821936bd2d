/* A drawing with a bit or a byte a pixel, in memory or in a file. */
#include "image/bitmap.h"

#include "util/fixed.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum { CHUNK = 1 << 16 };

static pv_bitmap shape(int32_t width, int32_t height, int32_t depth)
{
    return (pv_bitmap){ width, height, depth, 0, ((int64_t)width * depth + 7) / 8, NULL, -1 };
}

pave_result pv_bitmap_create(pave_context *context, int32_t width, int32_t height, int32_t depth, pv_bitmap *out)
{
    pave_result result = PAVE_OK;
    *out = shape(width, height, depth);
    out->bits = pv_allocate_zeroed(context, (size_t)out->stride, (size_t)height, &result);
    return result;
}

static pave_result failed(pave_context *context, const char *what)
{
    const char *reason = strerrordesc_np(errno);
    return pv_fail(context, PAVE_ERR_IO, "the temporary file for the drawing cannot be %s: %s", what,
                   reason ? reason : "unknown error");
}

/* Its size is set at once, so that what was not put is black and nothing is ever read beyond the end. */
pave_result pv_bitmap_create_in(pave_context *context, int32_t width, int32_t height, int32_t depth, int file,
                                pv_bitmap *out)
{
    *out = shape(width, height, depth);
    out->file = file;
    return ftruncate(file, out->stride * height) ? failed(context, "made so large") : PAVE_OK;
}

void pv_bitmap_free(pv_bitmap *bitmap)
{
    if (!bitmap->bits && bitmap->file >= 0 && bitmap->stride)
        close(bitmap->file);
    pv_release(bitmap->bits);
    *bitmap = shape(0, 0, 1);
}

/* Reads, or writes, so many bytes from a place on. */
static pave_result transfer(pave_context *context, const pv_bitmap *bitmap, int64_t offset, uint8_t *bytes,
                            int64_t size, int writes)
{
    while (size) {
        ssize_t n = writes ? pwrite(bitmap->file, bytes, (size_t)size, offset)
                           : pread(bitmap->file, bytes, (size_t)size, offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n == 0)
            errno = EIO;
        if (n <= 0)
            return failed(context, writes ? "written" : "read");
        bytes += n, offset += n, size -= n;
    }
    return PAVE_OK;
}

void pv_bitmap_store(pv_bitmap *bitmap, int32_t x, int32_t y, const pave_image *drawing)
{
    const uint8_t *pixels = bitmap->cut && drawing->levels ? drawing->levels : drawing->pixels;
    for (int32_t row = 0; row < drawing->height; row++, pixels += drawing->width) {
        uint8_t *bits = bitmap->bits + (y + row) * bitmap->stride;
        if (bitmap->depth == 8)
            memcpy(bits + x, pixels, (size_t)drawing->width);
        for (int32_t i = 0, at = x; i < drawing->width && bitmap->depth == 1; i++, at++)
            bits[at >> 3] |= (uint8_t)((pixels[i] >> 7) << (7 - (at & 7)));
    }
}

pave_result pv_bitmap_put(pave_context *context, pv_bitmap *bitmap, int32_t y, const pv_bitmap *band)
{
    int64_t offset = y * bitmap->stride, size = band->height * band->stride;
    if (!bitmap->bits)
        return transfer(context, bitmap, offset, band->bits, size, 1);
    memcpy(bitmap->bits + offset, band->bits, (size_t)size);
    return PAVE_OK;
}

/* The bytes x..x+size of a row; `scratch` has room for them. */
static pave_result row_bytes(pave_context *context, const pv_bitmap *bitmap, int32_t y, int64_t x, int64_t size,
                             uint8_t *scratch, const uint8_t **out)
{
    *out = bitmap->bits ? bitmap->bits + y * bitmap->stride + x : scratch;
    return bitmap->bits ? PAVE_OK : transfer(context, bitmap, y * bitmap->stride + x, scratch, size, 0);
}

/* Pixels of a row that lie inside the plane. */
static pave_result cut_run(pave_context *context, const pv_bitmap *bitmap, int32_t x, int32_t y, int32_t count,
                           uint8_t *scratch, uint8_t *pixel)
{
    int32_t bytes = bitmap->depth == 8, first = bytes ? x : x >> 3;
    int32_t size = bytes ? count : ((x + count + 7) >> 3) - first;
    const uint8_t *bits = NULL;
    pave_result result = row_bytes(context, bitmap, y, first, size, scratch, &bits);
    if (bytes && !result)
        memcpy(pixel, bits, (size_t)count);
    if (bytes)
        return result;
    for (int32_t column = x - 8 * first; column < x - 8 * first + count && !result; column++)
        *pixel++ = bits[column >> 3] >> (7 - (column & 7)) & 1 ? 255 : 0;
    return result;
}

pave_result pv_bitmap_deepen(pave_context *context, const pv_bitmap *bitmap, int32_t rows, pv_bitmap *out)
{
    pave_result result = PAVE_OK;
    int32_t width = bitmap->width;
    uint8_t *scratch = pv_allocate(context, (size_t)bitmap->stride, 1, &result);
    pv_bitmap row = { 0 };
    if (!result)
        result = pv_bitmap_create(context, width, 1, 8, &row);
    for (int32_t y = 0; y < rows && !result; y++) {
        result = cut_run(context, bitmap, 0, y, width, scratch, row.bits);
        if (!result)
            result = pv_bitmap_put(context, out, y, &row);
    }
    pv_release(row.bits);
    pv_release(scratch);
    return result;
}

pave_result pv_bitmap_cut(pave_context *context, const pv_bitmap *bitmap, int32_t x, int32_t y, int32_t width,
                          int32_t height, pave_image **out)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    params.width = width;
    params.height = height;
    pave_result result = pv_image_new(context, &params, out);
    uint8_t *scratch = result ? NULL : pv_allocate(context, (size_t)width + 2, 1, &result);
    uint8_t *pixel = result ? NULL : (*out)->pixels;
    for (int32_t row = 0; row < height && !result; row++)
        for (int32_t i = 0, run; i < width && !result; i += run, pixel += run) {
            int32_t at = pv_modulo(x + i, bitmap->width), left = bitmap->width - at;
            run = left < width - i ? left : width - i;
            result = cut_run(context, bitmap, at, pv_modulo(y + row, bitmap->height), run, scratch, pixel);
        }
    pv_release(scratch);
    if (!result && bitmap->cut)
        result = pv_levels_split(context, *out, bitmap->cut);
    if (result)
        pave_image_free(out);
    else
        (*out)->place = (pv_place){ x, y, bitmap->width, bitmap->height };
    return result;
}

/* FNV-1a by words; `size` is a multiple of 8 but at the end. */
static uint64_t hash_bytes(uint64_t hash, const uint8_t *bytes, int64_t size)
{
    const uint64_t prime = 1099511628211u;
    int64_t i = 0;
    for (; i + 8 <= size; i += 8) {
        uint64_t word;
        memcpy(&word, bytes + i, sizeof word);
        hash = (hash ^ word) * prime;
        hash ^= hash >> 29;
    }
    for (; i < size; i++)
        hash = (hash ^ bytes[i]) * prime;
    return hash;
}

pave_result pv_bitmap_hash(pave_context *context, const pv_bitmap *bitmap, uint64_t *out)
{
    uint64_t hash = 14695981039346656037u ^ (uint64_t)(uint32_t)bitmap->width << 32 ^ (uint32_t)bitmap->height ^
                    (uint64_t)(uint32_t)bitmap->cut << 24;
    int64_t size = bitmap->stride * bitmap->height;
    pave_result result = PAVE_OK;
    uint8_t *scratch = bitmap->bits ? NULL : pv_allocate(context, CHUNK, 1, &result);
    for (int64_t done = 0, n; done < size && !result; done += n) {
        n = size - done < CHUNK ? size - done : CHUNK;
        if (scratch)
            result = transfer(context, bitmap, done, scratch, n, 0);
        if (!result)
            hash = hash_bytes(hash, scratch ? scratch : bitmap->bits + done, n);
    }
    pv_release(scratch);
    *out = hash ? hash : 1;
    return result;
}
