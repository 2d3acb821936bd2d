/* BTFs to OpenEXR files of many parts, ZIP-compressed, made as they are written. */
#include "io/exr_btf.h"

#include "io/exr_call.h"
#include "util/half.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A part while it is written. */
typedef struct part {
    pv_exr_call *call;
    const pave_btf *btf;
    int32_t view, lines;
    size_t bytes; /* of a value */
    float *run;   /* a texel: [light][channel] */
    uint8_t *band; /* [y][x][light][channel] */
} part;

static int is_missing(const pave_btf *btf, int32_t view, int32_t light)
{
    return btf->missing && btf->missing[(int64_t)view * btf->lights.count + light];
}

static exr_result_t put_attributes(exr_context_t exr, const pave_btf *btf, int32_t view)
{
    char names[PV_BTF_CHANNELS * PV_BTF_NAME], *to = names;
    const pave_direction *at = &btf->views.direction[view];
    exr_attr_v2f_t direction = { .x = at->theta, .y = at->phi };
    for (int32_t c = 0; c < btf->channels; c++)
        to += sprintf(to, "%s%s", c ? "," : "", btf->names[c]);
    exr_result_t code = exr_attr_set_v2f(exr, view, "viewDirection", &direction);
    if (!code)
        code = exr_attr_set_float_vector(exr, view, "lightDirections", 2 * btf->lights.count,
                                         &btf->lights.direction[0].theta);
    if (!code)
        code = exr_attr_set_string(exr, view, "channelNames", names);
    if (!code)
        code = exr_attr_set_int(exr, view, "lightCosine", btf->cosine);
    return code ? code : exr_attr_set_float(exr, view, "pixelsPerMm", (float)btf->pixels_per_mm);
}

/* "L017.R". Pairs that are missing have no channels. */
static exr_result_t add_part(exr_context_t exr, const pave_btf *btf, int32_t view)
{
    char name[PV_BTF_NAME + 16];
    int index;
    exr_pixel_type_t kind = btf->type == PAVE_F16 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
    snprintf(name, sizeof name, "view %03d", (int)view);
    exr_result_t code = exr_add_part(exr, name, EXR_STORAGE_SCANLINE, &index);
    if (!code)
        code = exr_initialize_required_attr_simple(exr, view, btf->width, btf->height, EXR_COMPRESSION_ZIP);
    for (int32_t l = 0; l < btf->lights.count; l++)
        for (int32_t c = 0; c < btf->channels && !code && !is_missing(btf, view, l); c++) {
            snprintf(name, sizeof name, "L%03d.%s", (int)l, btf->names[c]);
            code = exr_add_channel(exr, view, name, kind, EXR_PERCEPTUALLY_LINEAR, 1, 1);
        }
    return code ? code : put_attributes(exr, btf, view);
}

static exr_result_t put_header(exr_context_t exr, const pave_btf *btf)
{
    exr_result_t code = EXR_ERR_SUCCESS;
    int long_names = 0;
    for (int32_t c = 0; c < btf->channels; c++)
        long_names |= strlen(btf->names[c]) > 24;
    if (long_names)
        code = exr_set_longname_support(exr, 1);
    for (int32_t v = 0; v < btf->views.count && !code; v++)
        code = add_part(exr, btf, v);
    return code ? code : exr_write_header(exr);
}

static int64_t run_length(const pave_btf *btf)
{
    return (int64_t)btf->lights.count * btf->channels;
}

static void make_band(const part *p, int32_t y)
{
    const pave_btf *btf = p->btf;
    int64_t count = run_length(btf), first = (int64_t)y * btf->width;
    int64_t end = (int64_t)(p->lines < btf->height - y ? y + p->lines : btf->height) * btf->width;
    for (int64_t t = first; t < end; t++) {
        uint8_t *to = p->band + (size_t)((t - first) * count) * p->bytes;
        pv_btf_from_view(btf, t, p->view, p->run);
        if (p->bytes == 4)
            memcpy(to, p->run, (size_t)count * 4);
        for (int64_t i = 0; i < count && p->bytes == 2; i++)
            ((uint16_t *)(void *)to)[i] = pv_half(fminf(fmaxf(p->run[i], -65504), 65504));
    }
}

static void bind(const part *p, exr_encode_pipeline_t *pipeline)
{
    const pave_btf *btf = p->btf;
    size_t pixel = (size_t)run_length(btf) * p->bytes;
    for (int16_t i = 0; i < pipeline->channel_count; i++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[i];
        int32_t light = 0, digits = 0, c = 0;
        for (const char *s = channel->channel_name + 1; *s != '.'; s++, digits++)
            light = 10 * light + (*s - '0');
        while (strcmp(btf->names[c], channel->channel_name + digits + 2))
            c++;
        channel->user_bytes_per_element = (int16_t)p->bytes;
        channel->user_data_type = channel->data_type;
        channel->user_pixel_stride = (int32_t)pixel;
        channel->user_line_stride = (int32_t)((size_t)btf->width * pixel);
        channel->encode_from_ptr = p->band + ((size_t)light * (size_t)btf->channels + (size_t)c) * p->bytes;
    }
}

static exr_result_t put_chunk(const part *p, int32_t y, exr_encode_pipeline_t *pipeline)
{
    exr_chunk_info_t chunk;
    exr_context_t exr = p->call->exr;
    exr_result_t code = exr_write_scanline_chunk_info(exr, p->view, y, &chunk);
    int first = !pipeline->channels;
    if (!code)
        code = first ? exr_encoding_initialize(exr, p->view, &chunk, pipeline)
                     : exr_encoding_update(exr, p->view, &chunk, pipeline);
    if (code)
        return code;
    make_band(p, y);
    bind(p, pipeline);
    return pv_exr_encode(p->call, p->view, first, pipeline);
}

static pave_result put_part(part *p)
{
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t code = EXR_ERR_SUCCESS;
    pave_result result = PAVE_OK;
    const pave_btf *btf = p->btf;
    for (int32_t y = 0; y < btf->height && !code && !result; y += p->lines) {
        code = put_chunk(p, y, &pipeline);
        result = pv_progress(p->call->context, (p->view + (double)y / btf->height) / btf->views.count);
    }
    exr_encoding_destroy(p->call->exr, &pipeline);
    return result || pv_output_failed(p->call->output) || !code ? result : pv_exr_failure(p->call, code);
}

static pave_result put_parts(pv_exr_call *call, const pave_btf *btf)
{
    part p = { .call = call, .btf = btf, .bytes = btf->type == PAVE_F16 ? 2 : 4 };
    pave_result result = PAVE_OK;
    exr_result_t code = exr_get_scanlines_per_chunk(call->exr, 0, &p.lines);
    if (code)
        return pv_exr_failure(call, code);
    size_t run = (size_t)run_length(btf);
    if ((double)run * (double)p.bytes * btf->width > INT32_MAX)
        return pv_fail(call->context, PAVE_ERR_UNSUPPORTED, "%s: a row of all lights is too long for an EXR file",
                       call->path);
    p.run = pv_allocate(call->context, run, sizeof *p.run, &result);
    if (!result)
        p.band = pv_allocate(call->context, (size_t)p.lines * (size_t)btf->width, run * p.bytes, &result);
    for (; p.view < btf->views.count && !result; p.view++)
        result = put_part(&p);
    pv_release(p.run);
    pv_release(p.band);
    return result;
}

static pave_result write_file(pv_exr_call *call, const pave_btf *btf)
{
    exr_result_t code = pv_exr_start(call);
    if (!code)
        code = put_header(call->exr, btf);
    pave_result result = code && !pv_output_failed(call->output) ? pv_exr_failure(call, code) : PAVE_OK;
    if (!code)
        result = put_parts(call, btf);
    if (call->exr)
        code = exr_finish(&call->exr);
    return result || !code || pv_output_failed(call->output) ? result : pv_exr_failure(call, code);
}

static pave_result check_names(pave_context *context, const pave_btf *btf, const char *path)
{
    for (int32_t v = 0; v < btf->views.count && btf->missing; v++)
        if (!memchr(btf->missing + (int64_t)v * btf->lights.count, 0, (size_t)btf->lights.count))
            return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: view %d has no lights, and a part needs channels", path,
                           (int)v);
    for (int32_t a = 0; a < btf->channels; a++)
        for (int32_t b = 0; b < a; b++)
            if (!strcmp(btf->names[a], btf->names[b]))
                return pv_fail(context, PAVE_ERR_ARGUMENT, "%s: two channels are called %s", path, btf->names[a]);
    return PAVE_OK;
}

pave_result pv_exr_btf_write(pave_context *context, const pave_btf *btf, const char *path)
{
    pv_exr_call call = { .context = context, .path = path };
    pave_result result = check_names(context, btf, path);
    if (!result)
        result = pv_output_open(context, path, 1, &call.output);
    if (result)
        return result;
    pv_exr_call *outer = pv_exr_enter(&call);
    result = write_file(&call, btf);
    pv_exr_enter(outer);
    return pv_output_close(call.output, result);
}
