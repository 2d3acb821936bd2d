/* Any image to a drawing in the colours of a palette: each pixel to a code, then what lies between two entries to one
 * of them. The codes are what is kept of a plane that is laid window by window. */
#include "image/palette.h"

#include "base/parallel.h"
#include "util/fixed.h"

#include <string.h>

enum { ROWS = 16 };

typedef struct resolving {
    const pv_codebook *book;
    const pave_image *codes;
    pave_image *drawing; /* a part of it */
} resolving;

/* From where to where a period reaches that holds a coordinate, seen from an origin and cut to a length. */
static void find_period(int32_t at, int32_t period, int32_t origin, int32_t length, int32_t *from, int32_t *to)
{
    int64_t begin = pv_floor_div(at, period) * period - origin, end = begin + period;
    *from = begin > 0 ? (int32_t)begin : 0;
    *to = end < length ? (int32_t)end : length;
}

static void resolve_row(const resolving *r, int32_t y, uint8_t *row)
{
    const pv_place *place = &r->codes->place, *part = &r->drawing->place;
    pv_codes codes = { .width = r->codes->width, .code = r->codes->pixels };
    find_period(part->y + y, place->height, place->y, r->codes->height, &codes.top, &codes.bottom);
    for (int32_t x = 0; x < r->drawing->width; x++) {
        int32_t at = part->x + x - place->x;
        if (!x || at >= codes.right)
            find_period(part->x + x, place->width, place->x, r->codes->width, &codes.left, &codes.right);
        row[x] = pv_resolve(r->book, &codes, at, part->y + y - place->y);
    }
}

static void resolve_rows(void *data, int32_t band, int32_t worker)
{
    (void)worker;
    const resolving *r = data;
    int32_t width = r->drawing->width, height = r->drawing->height, end = (band + 1) * ROWS;
    for (int32_t y = band * ROWS; y < (end < height ? end : height); y++)
        resolve_row(r, y, (uint8_t *)r->drawing->pixels + (int64_t)y * width);
}

static pave_result new_drawing(pave_context *context, int32_t width, int32_t height, pave_image **out)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = width;
    shape.height = height;
    shape.encoding = PAVE_DATA;
    return pv_image_new(context, &shape, out);
}

/* A part of codes as a drawing. */
static pave_result resolve(pave_context *context, const pave_palette *palette, const pave_image *codes, pv_place part,
                           pave_image **out)
{
    pv_codebook *book = NULL;
    pave_result result = pv_codebook_create(context, palette, &book);
    if (!result)
        result = new_drawing(context, part.width, part.height, out);
    if (!result) {
        resolving r = { book, codes, *out };
        (*out)->place = (pv_place){ part.x, part.y, codes->place.width, codes->place.height };
        (*out)->palette = *palette;
        result = pv_parallel(context, (part.height + ROWS - 1) / ROWS, resolve_rows, &r, 0.5, 1);
    }
    pv_release(book);
    if (result)
        pave_image_free(out);
    return result;
}

pave_result pv_encode_image(pave_context *context, const pv_codebook *book, const pave_image *image, pave_image **out)
{
    pave_result result = new_drawing(context, image->width, image->height, out);
    if (result)
        return result;
    (*out)->place = image->place;
    result = pv_encode(context, book, image, (*out)->pixels);
    if (result)
        pave_image_free(out);
    return result;
}

/* Codes are named, and not what they become, as they are what is kept. */
static pave_result name_codes(pave_context *context, const pave_image *codes, uint64_t *hash)
{
    pv_bitmap bitmap = { codes->width, codes->height, 8, 0, codes->width, codes->pixels, -1 };
    return pv_bitmap_hash(context, &bitmap, hash);
}

static pave_result quantise(pave_context *context, const pave_image *image, const pave_palette *palette,
                            pave_image **out)
{
    pave_image *codes = NULL;
    pv_codebook *book = NULL;
    pv_place whole = { image->place.x, image->place.y, image->width, image->height };
    pave_result result = pv_codebook_create(context, palette, &book);
    if (!result)
        result = pv_encode_image(context, book, image, &codes);
    if (!result)
        result = resolve(context, palette, codes, whole, out);
    if (!result)
        result = name_codes(context, codes, &(*out)->hash);
    pave_image_free(&codes);
    pv_release(book);
    if (result)
        pave_image_free(out);
    return result;
}

/* Numbers beyond the count are cleared, so that equal palettes are the same bytes. */
static pave_result take_palette(pave_context *context, const pave_palette *given, pave_palette *out)
{
    memset(out, 0, sizeof *out);
    if (given->count < 1 || given->count > 256)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the palette has %d colours, but must have 1 .. 256",
                       (int)given->count);
    out->count = given->count;
    memcpy(out->rgb, given->rgb, 3 * (size_t)given->count);
    return PAVE_OK;
}

pave_result pave_image_quantise(pave_context *context, const pave_image *image, const pave_palette *given,
                                pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !image || !given || !out)
        return PAVE_ERR_ARGUMENT;
    pave_palette palette;
    pave_result result = take_palette(context, given, &palette);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "colours", 0, 1);
    result = quantise(context, image, &palette, out);
    pv_call_end(context, call);
    return result;
}

pave_result pv_drawing_cut(pave_context *context, const pv_bitmap *bitmap, const pave_palette *palette, int32_t x,
                           int32_t y, int32_t width, int32_t height, pave_image **out)
{
    if (!palette->count)
        return pv_bitmap_cut(context, bitmap, x, y, width, height, out);
    enum { REACH = PV_RESOLVE_REACH };
    pave_image *codes = NULL;
    *out = NULL;
    pave_result result = pv_bitmap_cut(context, bitmap, x - REACH, y - REACH, width + 2 * REACH,
                                       height + 2 * REACH, &codes);
    if (!result)
        result = resolve(context, palette, codes, (pv_place){ x, y, width, height }, out);
    pave_image_free(&codes);
    return result;
}
