/* Any image to a drawing in the colours of a palette: each pixel to a code, then what lies between two entries to one
 * of them. */
#include "image/palette.h"

#include "base/parallel.h"

typedef struct resolving {
    const pv_codebook *book;
    pv_codes codes;
    uint8_t *out;
} resolving;

enum { ROWS = 16 };

static void resolve_rows(void *data, int32_t band, int32_t worker)
{
    (void)worker;
    const resolving *r = data;
    int32_t from = band * ROWS, to = from + ROWS < r->codes.height ? from + ROWS : r->codes.height;
    for (int32_t y = from; y < to; y++)
        for (int32_t x = 0; x < r->codes.width; x++)
            r->out[(int64_t)y * r->codes.width + x] = pv_resolve(r->book, &r->codes, x, y);
}

static pave_result quantise(pave_context *context, const pv_codebook *book, const pave_image *image,
                            pave_image *drawing)
{
    pave_result result = PAVE_OK;
    uint8_t *codes = pv_allocate(context, (size_t)image->width * (size_t)image->height, 1, &result);
    if (!result)
        result = pv_encode(context, book, image, codes);
    resolving r = { book, { drawing->width, drawing->height, codes }, drawing->pixels };
    if (!result)
        result = pv_parallel(context, (image->height + ROWS - 1) / ROWS, resolve_rows, &r, 0.5, 1);
    pv_release(codes);
    return result;
}

pave_result pave_image_quantise(pave_context *context, const pave_image *image, const pave_palette *palette,
                                pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !image || !palette || !out)
        return PAVE_ERR_ARGUMENT;
    if (palette->count < 1 || palette->count > 256)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the palette has %d colours, but must have 1 .. 256",
                       (int)palette->count);
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    pave_image *drawing = NULL;
    pv_codebook *book = NULL;
    shape.width = image->width;
    shape.height = image->height;
    shape.encoding = PAVE_DATA;
    pave_result result = pv_image_new(context, &shape, &drawing);
    if (!result)
        result = pv_codebook_create(context, palette, &book);
    pv_call call = pv_call_begin(context, "colours", 0, 1);
    if (!result) {
        drawing->place = image->place;
        drawing->palette = *palette;
        result = quantise(context, book, image, drawing);
    }
    pv_call_end(context, call);
    pv_release(book);
    if (result)
        pave_image_free(&drawing);
    *out = drawing;
    return result;
}
