/* Images to OpenEXR files. */
#include "io/exr.h"

#include "io/convert.h"
#include "io/exr_call.h"

#include <string.h>

/* The image as it goes into the file. */
static pv_pixels file_pixels(const pave_image *image)
{
    pv_pixels pixels = { image->type, PAVE_LINEAR, 1 };
    if (image->type == PAVE_U8)
        pixels.type = PAVE_F16;
    if (image->type == PAVE_U16)
        pixels.type = PAVE_F32;
    pixels.premultiplied = image->type != PAVE_U32;
    return pixels;
}

static exr_result_t write_header(pv_exr_call *call, const pave_image *image, int32_t type)
{
    exr_pixel_type_t kind = type == PAVE_U32 ? EXR_PIXEL_UINT : type == PAVE_F16 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
    int part, long_names = 0;
    for (int32_t c = 0; c < image->channels; c++)
        long_names |= strlen(image->names[c]) > 31;
    exr_result_t code = exr_add_part(call->exr, NULL, EXR_STORAGE_SCANLINE, &part);
    if (!code && long_names)
        code = exr_set_longname_support(call->exr, 1);
    if (!code)
        code = exr_initialize_required_attr_simple(call->exr, 0, image->width, image->height, EXR_COMPRESSION_ZIP);
    for (int32_t c = 0; c < image->channels && !code; c++)
        code = exr_add_channel(call->exr, 0, image->names[c], kind, EXR_PERCEPTUALLY_LINEAR, 1, 1);
    return code ? code : exr_write_header(call->exr);
}

static void bind_channels(const pave_image *image, size_t bytes, const void *band, exr_encode_pipeline_t *pipeline)
{
    for (int16_t i = 0; i < pipeline->channel_count; i++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[i];
        size_t place = (size_t)pv_image_channel(image, channel->channel_name);
        channel->user_bytes_per_element = (int16_t)bytes;
        channel->user_data_type = channel->data_type;
        channel->user_pixel_stride = (int32_t)((size_t)image->channels * bytes);
        channel->user_line_stride = (int32_t)((size_t)image->width * (size_t)image->channels * bytes);
        channel->encode_from_ptr = (const uint8_t *)band + place * bytes;
    }
}

static exr_result_t write_chunk(pv_exr_call *call, const pave_image *image, size_t bytes, int32_t y, const void *band,
                                exr_encode_pipeline_t *pipeline)
{
    exr_chunk_info_t chunk;
    exr_result_t code = exr_write_scanline_chunk_info(call->exr, 0, y, &chunk);
    int first = !pipeline->channels;
    if (!code)
        code = first ? exr_encoding_initialize(call->exr, 0, &chunk, pipeline)
                     : exr_encoding_update(call->exr, 0, &chunk, pipeline);
    if (code)
        return code;
    bind_channels(image, bytes, band, pipeline);
    return pv_exr_encode(call, 0, first, pipeline);
}

static pave_result write_pixels(pv_exr_call *call, const pave_image *image, pv_pixels pixels)
{
    int32_t lines = 0;
    pave_result result = PAVE_OK;
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t code = exr_get_scanlines_per_chunk(call->exr, 0, &lines);
    size_t bytes = pv_type_bytes(pixels.type), row = (size_t)image->width * (size_t)image->channels * bytes;
    void *band = code ? NULL : pv_allocate(call->context, (size_t)lines, row, &result);
    for (int32_t y = 0; y < image->height && !code && !result; y += lines) {
        pv_convert_rows(image, y, lines < image->height - y ? y + lines : image->height, pixels, band);
        code = write_chunk(call, image, bytes, y, band, &pipeline);
        result = pv_progress(call->context, (double)y / image->height);
    }
    exr_encoding_destroy(call->exr, &pipeline);
    pv_release(band);
    return result || pv_output_failed(call->output) || !code ? result : pv_exr_failure(call, code);
}

static pave_result write_file(pv_exr_call *call, const pave_image *image)
{
    pv_pixels pixels = file_pixels(image);
    exr_result_t code = pv_exr_start(call);
    if (!code)
        code = write_header(call, image, pixels.type);
    pave_result result = code && !pv_output_failed(call->output) ? pv_exr_failure(call, code) : PAVE_OK;
    if (!code)
        result = write_pixels(call, image, pixels);
    if (call->exr)
        code = exr_finish(&call->exr);
    return result || !code || pv_output_failed(call->output) ? result : pv_exr_failure(call, code);
}

pave_result pv_exr_write(pave_context *context, const pave_image *image, const char *path)
{
    pv_exr_call call = { .context = context, .path = path };
    pave_result result = pv_output_open(context, path, 1, &call.output);
    if (result)
        return result;
    pv_exr_call *outer = pv_exr_enter(&call);
    result = write_file(&call, image);
    pv_exr_enter(outer);
    return pv_output_close(call.output, result);
}
