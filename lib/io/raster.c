/* Images through codecs: vetted, decoded part by part, put upright; and encoded in bands. */
#include "io/raster.h"

#include "io/convert.h"
#include "io/module.h"
#include "io/output.h"
#include "io/vet.h"

#include <stdio.h>
#include <string.h>

enum { BAND_BYTES = 1 << 22 };
static const double vetting = 0.3; /* share of the time */

/* CMYK is left to the module, which makes RGB of it. */
static pave_result find_codec(pave_context *context, const char *path, const char *format, int32_t channels,
                              pv_module *out)
{
    *out = (pv_module){ NULL, !strcmp(format, "png") ? &pv_png : NULL };
    if (!strcmp(format, "jpeg") && channels != 4)
        out->codec = &pv_jpeg;
    return out->codec ? PAVE_OK : pv_module_load(context, path, out);
}

static pave_result refused(pave_context *context, const char *path, pave_result result, const char *text)
{
    if (!*text)
        return result;
    return result == PAVE_ERR_FORMAT ? pv_fail(context, result, "%s: cannot be decoded: %s", path, text)
                                     : pv_fail(context, result, "%s: the image codec failed: %s", path, text);
}

/* A file being decoded. */
typedef struct decoding {
    pave_context *context;
    const pv_codec *codec;
    pv_encoded *file;
    pv_codec_job *job;
    pv_picture picture;
} decoding;

static int32_t give(void *user, int64_t offset, void *bytes, size_t size)
{
    return pv_encoded_read(user, offset, bytes, (int64_t)size);
}

/* If the file has changed, that is the reason. */
static pave_result undecodable(const decoding *d, pave_result result, const char *text)
{
    pave_result changed = pv_input_unchanged(d->file->input);
    return changed ? changed : refused(d->context, d->file->path, result, text);
}

static pave_result read_part(void *user, pv_rect part, void *pixels)
{
    const decoding *d = user;
    char text[PV_CODEC_TEXT];
    pave_result result = d->codec->read(d->job, part.x, part.y, part.width, part.height, pixels, text);
    return result ? undecodable(d, result, text) : PAVE_OK;
}

static pave_result describe_blocks(decoding *d, pv_blocks *out)
{
    const pv_picture *picture = &d->picture;
    const pv_encoded *file = d->file;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    if (picture->width != file->width || picture->height != file->height)
        return pv_damaged(d->context, file, file->format, "its decoder sees another size than its header gives");
    if (picture->channels > PV_MOST_CHANNELS)
        return pv_fail(d->context, PAVE_ERR_LIMIT, "%s: has %d channels, and 1 to %d can be read", file->path,
                       picture->channels, PV_MOST_CHANNELS);
    shape.width = picture->width;
    shape.height = picture->height;
    shape.channels = picture->channels;
    shape.type = picture->type;
    shape.encoding = picture->type == PAVE_U32 ? PAVE_DATA : picture->linear ? PAVE_LINEAR : PAVE_DISPLAY;
    shape.alpha = picture->alpha < picture->channels ? picture->alpha : -1;
    shape.names = picture->names;
    *out = (pv_blocks){ file->path, shape, picture->columns, picture->rows, file->premultiplied, file->at_once, vetting,
                        read_part, d };
    return PAVE_OK;
}

static pave_result decode(decoding *d, const pv_target *target)
{
    char text[PV_CODEC_TEXT];
    pv_blocks blocks;
    pv_codec_file file = { d->file->piece_count ? NULL : d->file->bytes, d->file->size, give, d->file };
    pave_result result = d->codec->decode(d->context, d->file->format, &file, &d->picture, &d->job, text);
    if (result)
        return undecodable(d, result, text);
    result = describe_blocks(d, &blocks);
    if (!result)
        result = pv_blocks_read(d->context, &blocks, target);
    d->codec->close(d->job);
    return result;
}

static pave_result load_and_decode(pave_context *context, pv_encoded *file, const pv_target *target)
{
    pv_module module;
    if (!target->image && file->orientation >= 2 && file->orientation <= 8)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: lies on its side; turn it upright before it is laid in "
                       "windows", file->path);
    pave_result result = find_codec(context, file->path, file->format, file->channels, &module);
    if (result)
        return result;
    decoding d = { .context = context, .codec = module.codec, .file = file };
    result = decode(&d, target);
    pv_module_unload(&module);
    return result || !target->image ? result : pv_orient(context, target->image, file->orientation);
}

pave_result pv_raster_read(pave_context *context, pv_input *input, const pv_target *target)
{
    pv_encoded file = { .input = input, .path = input->path };
    pave_result result = pv_vet(context, &file, vetting);
    if (!result)
        result = load_and_decode(context, &file, target);
    pv_release(file.bytes);
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
    result = find_codec(context, path, format, picture->channels, &raster->module);
    if (!result)
        result = pv_output_open(context, path, 1, &raster->output);
    if (!result) {
        const pv_codec *codec = raster->module.codec;
        result = codec->encode(context, format, picture, sink, raster->output, &raster->job, raster->text);
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
    picture->linear = pixels.encoding == PAVE_LINEAR || image->encoding == PAVE_DATA;
    picture->alpha = image->alpha;
    picture->columns = image->width;
    picture->rows = 1;
}

static pave_result write_bands(pave_context *context, const pave_image *image, pv_pixels pixels, pv_raster *raster)
{
    pave_result result = PAVE_OK;
    size_t row = (size_t)image->width * (size_t)image->channels * pv_type_bytes(pixels.type);
    size_t fitting = row < BAND_BYTES ? BAND_BYTES / row : 1;
    int32_t rows = fitting < (size_t)image->height ? (int32_t)fitting : image->height;
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
