/* Images through the module: vetted, decoded in bands, put upright; and encoded in bands. */
#include "io/raster.h"

#include "io/convert.h"
#include "io/module.h"
#include "io/output.h"
#include "io/vet.h"

#include <stdio.h>
#include <string.h>

enum { BAND_BYTES = 1 << 22 };
static const double vetting = 0.3; /* share of the time */

/* Rows of a band of some megabytes, a multiple of `step`. */
static int32_t band_rows(int64_t row_bytes, int32_t step)
{
    int64_t rows = BAND_BYTES / row_bytes / step * step;
    return rows > step ? rows < INT32_MAX ? (int32_t)rows : INT32_MAX / step * step : step;
}

static pave_result refused(pave_context *context, const char *path, pave_result result, const char *text)
{
    return result == PAVE_ERR_FORMAT ? pv_fail(context, result, "%s: cannot be decoded: %s", path, text)
                                     : pv_fail(context, result, "%s: the image codec failed: %s", path, text);
}

/* An image of the picture's kind with `height` rows. */
static pave_result new_image(pave_context *context, const pv_picture *picture, const pv_encoded *file, int32_t height,
                             pave_image **out)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    if (picture->width != file->width || picture->height != file->height)
        return pv_damaged(context, file, file->format, "its decoder sees another size than its header gives");
    params.width = picture->width;
    params.height = height;
    params.channels = picture->channels;
    params.type = picture->type;
    params.encoding = picture->type == PAVE_U32 ? PAVE_DATA : picture->linear ? PAVE_LINEAR : PAVE_DISPLAY;
    params.alpha = picture->alpha < picture->channels ? picture->alpha : -1;
    params.names = picture->names;
    if (picture->channels > PV_MOST_CHANNELS)
        return pv_fail(context, PAVE_ERR_LIMIT, "%s: has %d channels, and 1 to %d can be read", file->path,
                       picture->channels, PV_MOST_CHANNELS);
    return pv_image_new(context, &params, out);
}

/* A file being decoded. */
typedef struct decoding {
    pave_context *context;
    const pv_codec *codec;
    const pv_encoded *file;
    pv_codec_job *job;
    pv_picture picture;
} decoding;

static int64_t row_bytes(const pv_picture *picture)
{
    return (int64_t)picture->width * picture->channels * (int64_t)pv_type_bytes(picture->type);
}

static pave_result read_rows(const decoding *d, int32_t from, int32_t to, void *pixels)
{
    char text[PV_CODEC_TEXT];
    pave_result result = d->codec->read(d->job, from, to, pixels, text);
    if (result)
        return refused(d->context, d->file->path, result, text);
    return pv_progress(d->context, vetting + (1 - vetting) * to / d->picture.height);
}

static pave_result read_image(const decoding *d, pave_image **out)
{
    int64_t row = row_bytes(&d->picture);
    int32_t rows = band_rows(row, d->picture.rows), height = d->picture.height;
    pave_result result = new_image(d->context, &d->picture, d->file, height, out);
    for (int32_t y = 0, end; y < height && !result; y = end) {
        end = rows < height - y ? y + rows : height;
        result = read_rows(d, y, end, (char *)(*out)->pixels + row * y);
    }
    if (!result && d->file->premultiplied)
        pv_unpremultiply(*out);
    if (!result)
        result = pv_orient(d->context, out, d->file->orientation);
    if (result)
        pave_image_free(out);
    return result;
}

static pave_result store_band(const decoding *d, int32_t y, pave_image *band, const pave_threshold_params *threshold,
                              pv_bitmap *out)
{
    pave_image *drawing = NULL;
    if (d->file->premultiplied)
        pv_unpremultiply(band);
    pave_result result = pave_image_threshold(d->context, band, threshold, &drawing);
    if (!result)
        pv_bitmap_store(out, y, drawing);
    pave_image_free(&drawing);
    return result;
}

/* Only a band at a time is more than a bit a pixel. */
static pave_result read_bitmap(const decoding *d, const pave_threshold_params *threshold, pv_bitmap *out)
{
    int32_t rows = band_rows(row_bytes(&d->picture), d->picture.rows), height = d->picture.height;
    pave_result result = pv_bitmap_create(d->context, d->picture.width, height, out);
    for (int32_t y = 0, end; y < height && !result; y = end) {
        pave_image *band = NULL;
        end = rows < height - y ? y + rows : height;
        result = new_image(d->context, &d->picture, d->file, end - y, &band);
        if (!result)
            result = read_rows(d, y, end, band->pixels);
        if (!result)
            result = store_band(d, y, band, threshold, out);
        pave_image_free(&band);
    }
    if (result)
        pv_bitmap_free(out);
    return result;
}

/* Decodes to an image, or else to a bitmap. */
static pave_result decode(decoding *d, pave_image **image, const pave_threshold_params *threshold, pv_bitmap *bitmap)
{
    char text[PV_CODEC_TEXT];
    pave_result result = d->codec->decode(d->file->format, d->file->bytes, d->file->size, &d->picture, &d->job, text);
    if (result)
        return refused(d->context, d->file->path, result, text);
    result = image ? read_image(d, image) : read_bitmap(d, threshold, bitmap);
    d->codec->close(d->job);
    return result;
}

static pave_result open_and_decode(pave_context *context, const char *path, uint8_t *bytes, size_t size,
                                   pave_image **image, const pave_threshold_params *threshold, pv_bitmap *bitmap)
{
    pv_encoded file = { .path = path, .bytes = bytes, .size = size };
    pv_module module;
    pave_result result = pv_vet(context, &file, vetting);
    if (!result && !image && file.orientation >= 2 && file.orientation <= 8)
        result = pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: lies on its side; turn it upright before it is laid in "
                         "windows", path);
    if (!result)
        result = pv_module_load(context, path, &module);
    if (result)
        return result;
    decoding d = { .context = context, .codec = module.codec, .file = &file };
    result = decode(&d, image, threshold, bitmap);
    pv_module_unload(&module);
    return result;
}

pave_result pv_raster_read(pave_context *context, const char *path, uint8_t *bytes, size_t size, pave_image **out)
{
    return open_and_decode(context, path, bytes, size, out, NULL, NULL);
}

pave_result pv_raster_read_drawing(pave_context *context, const char *path, uint8_t *bytes, size_t size,
                                   const pave_threshold_params *threshold, pv_bitmap *out)
{
    return open_and_decode(context, path, bytes, size, NULL, threshold, out);
}

struct pv_raster {
    pave_context *context;
    const char *path;
    pv_module module;
    pv_output *output;
    pv_codec_job *job;
    char text[PV_CODEC_TEXT];
};

static int32_t sink(void *user, int64_t offset, const void *bytes, size_t size)
{
    return pv_output_at(user, offset, bytes, size);
}

pave_result pv_raster_open(pave_context *context, const char *path, const char *format, const pv_picture *picture,
                           pv_raster **out)
{
    pave_result result = PAVE_OK;
    pv_raster *raster = *out = pv_allocate_zeroed(context, 1, sizeof *raster, &result);
    if (!raster)
        return result;
    raster->context = context;
    raster->path = path;
    result = pv_module_load(context, path, &raster->module);
    if (!result)
        result = pv_output_open(context, path, 1, &raster->output);
    if (!result) {
        result = raster->module.codec->encode(format, picture, sink, raster->output, &raster->job, raster->text);
        if (result)
            refused(context, path, result, raster->text);
    }
    if (result) {
        pv_raster_close(raster, result);
        *out = NULL;
    }
    return result;
}

/* When the disk is full it is the output that knows; its sentence comes from closing it. */
static pave_result judged(pv_raster *raster, pave_result result)
{
    if (!result || pv_output_failed(raster->output))
        return PAVE_OK;
    return refused(raster->context, raster->path, result, raster->text);
}

pave_result pv_raster_rows(pv_raster *raster, int32_t from, int32_t to, const void *pixels)
{
    return judged(raster, raster->module.codec->write(raster->job, from, to, pixels, raster->text));
}

pave_result pv_raster_close(pv_raster *raster, pave_result result)
{
    if (!result)
        result = judged(raster, raster->module.codec->finish(raster->job, raster->text));
    if (raster->job)
        raster->module.codec->close(raster->job);
    if (raster->output)
        result = pv_output_close(raster->output, result);
    pv_module_unload(&raster->module);
    pv_release(raster);
    return result;
}

/* What the file holds: PNG whole numbers, JPEG bytes, TIFF whole numbers for display or floats of linear light. */
static pave_result choose_pixels(pave_context *context, const pave_image *image, const char *path, const char *format,
                                 pv_pixels *out)
{
    int tiff = !strcmp(format, "tiff"), jpeg = !strcmp(format, "jpeg");
    int whole = image->type == PAVE_U8 || image->type == PAVE_U16, even = image->channels % 2 == 0;
    int fits = image->channels <= 4 && image->alpha == (even ? image->channels - 1 : -1);
    if (!tiff && (!fits || image->type == PAVE_U32))
        return pv_fail(context, PAVE_ERR_UNSUPPORTED,
                       "%s: this format holds grey or RGB, with alpha or without, for display; write .exr", path);
    if (jpeg && even)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: JPEG holds no alpha; write .png", path);
    out->type = jpeg ? PAVE_U8 : image->type == PAVE_U32 ? PAVE_U32 : whole ? image->type : tiff ? PAVE_F32 : PAVE_U16;
    out->encoding = out->type == PAVE_F32 ? PAVE_LINEAR : PAVE_DISPLAY;
    out->premultiplied = 0;
    return PAVE_OK;
}

static void describe(const pave_image *image, pv_pixels pixels, pv_picture *picture)
{
    memset(picture, 0, sizeof *picture);
    picture->width = image->width;
    picture->height = image->height;
    picture->channels = image->channels;
    picture->type = pixels.type;
    picture->linear = pixels.encoding == PAVE_LINEAR;
    picture->alpha = image->alpha;
    picture->rows = 1;
}

static pave_result write_bands(pave_context *context, const pave_image *image, pv_pixels pixels, pv_raster *raster)
{
    pave_result result = PAVE_OK;
    size_t row = (size_t)image->width * (size_t)image->channels * pv_type_bytes(pixels.type);
    int32_t rows = band_rows((int64_t)row, 1);
    rows = rows < image->height ? rows : image->height;
    void *band = pv_allocate(context, (size_t)rows, row, &result);
    for (int32_t y = 0, end; y < image->height && !result; y = end) {
        end = rows < image->height - y ? y + rows : image->height;
        pv_convert_rows(image, y, end, pixels, band);
        result = pv_raster_rows(raster, y, end, band);
        if (!result)
            result = pv_progress(context, (double)end / image->height);
    }
    pv_release(band);
    return result;
}

pave_result pv_raster_write(pave_context *context, const pave_image *image, const char *path, const char *format)
{
    pv_pixels pixels;
    pv_picture picture;
    pv_raster *raster;
    pave_result result = choose_pixels(context, image, path, format, &pixels);
    if (result)
        return result;
    describe(image, pixels, &picture);
    result = pv_raster_open(context, path, format, &picture, &raster);
    return result ? result : pv_raster_close(raster, write_bands(context, image, pixels, raster));
}
