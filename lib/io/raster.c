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

static pave_result new_image(pave_context *context, const pv_picture *picture, const pv_encoded *file, pave_image **out)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    if (picture->width != file->width || picture->height != file->height)
        return pv_damaged(context, file, file->format, "its decoder sees another size than its header gives");
    params.width = picture->width;
    params.height = picture->height;
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

static pave_result read_bands(pave_context *context, const pv_codec *codec, pv_codec_job *job,
                              const pv_picture *picture, const char *path, pave_image *image)
{
    char text[PV_CODEC_TEXT];
    int64_t row = (int64_t)image->width * image->channels * (int64_t)pv_type_bytes(image->type);
    int32_t rows = band_rows(row, picture->rows);
    for (int32_t y = 0, end; y < image->height; y = end) {
        end = rows < image->height - y ? y + rows : image->height;
        pave_result result = codec->read(job, y, end, (char *)image->pixels + row * y, text);
        if (result)
            return refused(context, path, result, text);
        result = pv_progress(context, vetting + (1 - vetting) * end / image->height);
        if (result)
            return result;
    }
    return PAVE_OK;
}

static pave_result decode(pave_context *context, const pv_codec *codec, const pv_encoded *file, pave_image **out)
{
    char text[PV_CODEC_TEXT];
    pv_picture picture;
    pv_codec_job *job;
    pave_result result = codec->decode(file->format, file->bytes, file->size, &picture, &job, text);
    if (result)
        return refused(context, file->path, result, text);
    result = new_image(context, &picture, file, out);
    if (!result)
        result = read_bands(context, codec, job, &picture, file->path, *out);
    codec->close(job);
    if (!result && file->premultiplied)
        pv_unpremultiply(*out);
    if (!result)
        result = pv_orient(context, out, file->orientation);
    if (result)
        pave_image_free(out);
    return result;
}

pave_result pv_raster_read(pave_context *context, const char *path, uint8_t *bytes, size_t size, pave_image **out)
{
    pv_encoded file = { .path = path, .bytes = bytes, .size = size };
    pv_module module;
    pave_result result = pv_vet(context, &file, vetting);
    if (!result)
        result = pv_module_load(context, path, &module);
    if (result)
        return result;
    result = decode(context, module.codec, &file, out);
    pv_module_unload(&module);
    return result;
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
