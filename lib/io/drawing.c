/* Images read part by part. */
#include "io/drawing.h"

#include "io/convert.h"
#include "io/output.h"

#include <errno.h>

enum { PART_BYTES = 1 << 22, SHARE = 8 };

static int64_t pixel_bytes(const pv_blocks *blocks)
{
    return blocks->shape.channels * (int64_t)pv_type_bytes(blocks->shape.type);
}

/* So many times `step` that it comes to PART_BYTES, where one takes `bytes`. */
static int32_t steps(int32_t step, int64_t bytes, int32_t most)
{
    int64_t count = PART_BYTES / (bytes * step), all = count < 1 ? step : count * step;
    return all < most ? (int32_t)all : most;
}

static pave_result read_part(pave_context *context, const pv_blocks *blocks, pv_rect part, void *pixels)
{
    const pave_image_params *shape = &blocks->shape;
    pave_result result = blocks->read(blocks->user, part, pixels);
    double done = ((double)part.y * shape->width + ((double)part.x + part.width) * part.height) /
                  ((double)shape->width * shape->height);
    return result ? result : pv_progress(context, blocks->begun + (1 - blocks->begun) * done);
}

static pave_result read_image(pave_context *context, const pv_blocks *blocks, pave_image **out)
{
    const pave_image_params *shape = &blocks->shape;
    int64_t row = pixel_bytes(blocks) * shape->width;
    int32_t rows = steps(blocks->rows, row, shape->height);
    pave_result result = pv_image_new(context, shape, out);
    for (int32_t y = 0; y < shape->height && !result; y += rows) {
        rows = rows < shape->height - y ? rows : shape->height - y;
        pv_rect part = { 0, y, shape->width, rows };
        result = read_part(context, blocks, part, (char *)(*out)->pixels + row * y);
    }
    if (!result && blocks->premultiplied)
        pv_unpremultiply(*out);
    if (result)
        pave_image_free(out);
    return result;
}

/* In memory if it is small beside the room there is, else in a file. */
static pave_result create_bitmap(pave_context *context, const pv_blocks *blocks, const pv_target *target,
                                 int32_t depth, pv_bitmap *out)
{
    const pave_image_params *shape = &blocks->shape;
    const pv_room *room = target->room;
    if (blocks->at_once > room->bytes)
        return pv_fail(context, PAVE_ERR_LIMIT,
                       "%s: is decoded with %lld bytes at once, and memory leaves %lld; save it as TIFF in tiles",
                       blocks->path, (long long)blocks->at_once, (long long)room->bytes);
    if (((int64_t)shape->width * depth + 7) / 8 * shape->height <= room->bytes / SHARE)
        return pv_bitmap_create(context, shape->width, shape->height, depth, out);
    int file = pv_output_scratch(room->beside);
    if (file < 0)
        return pv_fail(context, PAVE_ERR_IO, "%s: no temporary file can be made beside it: %s", room->beside,
                       pv_system_error(errno));
    return pv_bitmap_create_in(context, shape->width, shape->height, depth, file, out);
}

/* Levels instead of bits, in a bitmap whose first rows are there. */
static pave_result deepen(pave_context *context, int32_t rows, int32_t cut, pv_bitmap *deep, pv_bitmap *bitmap)
{
    pave_result result = pv_bitmap_deepen(context, bitmap, rows, deep);
    if (result)
        return result;
    deep->cut = cut;
    pv_bitmap_free(bitmap);
    *bitmap = *deep;
    *deep = (pv_bitmap){ .file = -1 };
    return PAVE_OK;
}

static pave_result deepen_band(pave_context *context, int32_t cut, pv_bitmap *band)
{
    pv_bitmap deep;
    pave_result result = pv_bitmap_create(context, band->width, band->height, 8, &deep);
    if (!result)
        result = deepen(context, band->height, cut, &deep, band);
    pv_bitmap_free(&deep);
    return result;
}

/* A drawing is kept as bits until the first grey is met. */
static pave_result put_band(pave_context *context, const pv_blocks *blocks, const pv_target *target, int32_t y,
                            pv_bitmap *band)
{
    pave_result result = PAVE_OK;
    pv_bitmap *drawing = target->drawing, deep = { .file = -1 };
    if (band->cut && !drawing->cut) {
        result = create_bitmap(context, blocks, target, 8, &deep);
        if (!result)
            result = deepen(context, y, band->cut, &deep, drawing);
        pv_bitmap_free(&deep);
    } else if (drawing->cut && !band->cut) {
        result = deepen_band(context, drawing->cut, band);
    }
    return result ? result : pv_bitmap_put(context, drawing, y, band);
}

/* A part into a band of the bitmap, or into the histogram. */
static pave_result take_part(pave_context *context, const pv_blocks *blocks, pv_rect part, const pv_target *target,
                             pv_bitmap *band)
{
    pave_image_params shape = blocks->shape;
    pave_image *image = NULL, *drawing = NULL;
    shape.width = part.width;
    shape.height = part.height;
    pave_result result = pv_image_new(context, &shape, &image);
    if (!result)
        result = read_part(context, blocks, part, image->pixels);
    if (!result && blocks->premultiplied)
        pv_unpremultiply(image);
    pv_call call = pv_call_begin(context, "read", 0, 0); /* no progress of its own */
    if (!result && target->histogram)
        result = pv_histogram_add(context, target->histogram, image);
    else if (!result)
        result = target->book ? pv_encode_image(context, target->book, image, &drawing)
                              : pave_image_threshold(context, image, target->threshold, &drawing);
    pv_call_end(context, call);
    if (drawing && drawing->levels && !band->cut)
        result = deepen_band(context, drawing->cut, band);
    if (drawing && !result)
        pv_bitmap_store(band, part.x, 0, drawing);
    pave_image_free(&drawing);
    pave_image_free(&image);
    return result;
}

static pave_result read_band(pave_context *context, const pv_blocks *blocks, int32_t y, int32_t rows,
                             const pv_target *target)
{
    const pave_image_params *shape = &blocks->shape;
    int32_t columns = steps(blocks->columns, pixel_bytes(blocks) * rows, shape->width);
    pv_bitmap band;
    pave_result result = pv_bitmap_create(context, shape->width, rows, target->book ? 8 : 1, &band);
    for (int32_t x = 0; x < shape->width && !result; x += columns) {
        columns = columns < shape->width - x ? columns : shape->width - x;
        result = take_part(context, blocks, (pv_rect){ x, y, columns, rows }, target, &band);
    }
    if (!result && target->drawing)
        result = put_band(context, blocks, target, y, &band);
    pv_bitmap_free(&band);
    return result;
}

static pave_result read_drawing(pave_context *context, const pv_blocks *blocks, const pv_target *target)
{
    const pave_image_params *shape = &blocks->shape;
    int32_t columns = blocks->columns < shape->width ? blocks->columns : shape->width;
    int32_t rows = steps(blocks->rows, pixel_bytes(blocks) * columns, shape->height);
    pave_result result = pv_check_size(context, blocks->path, shape->width, shape->height);
    if (!result)
        result = target->drawing ? create_bitmap(context, blocks, target, target->book ? 8 : 1, target->drawing)
                                 : PAVE_OK;
    for (int32_t y = 0; y < shape->height && !result; y += rows) {
        rows = rows < shape->height - y ? rows : shape->height - y;
        result = read_band(context, blocks, y, rows, target);
    }
    if (result && target->drawing)
        pv_bitmap_free(target->drawing);
    return result;
}

pave_result pv_blocks_read(pave_context *context, const pv_blocks *blocks, const pv_target *target)
{
    return target->image ? read_image(context, blocks, target->image) : read_drawing(context, blocks, target);
}
