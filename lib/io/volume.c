/* Volumes in and out: what their formats share, and the choice of one. */
#include "io/volume.h"

#include "util/text.h"

#include <pave/io.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

void pv_head_text(pv_volume_head *h, const char *text)
{
    size_t n = strlen(text);
    if (h->length + n < PV_VOLUME_HEAD)
        memcpy(h->text + h->length, text, n + 1), h->length += n;
}

void pv_head_number(pv_volume_head *h, double value)
{
    char text[PV_VOLUME_NUMBER];
    pv_text_number(text, sizeof text, value);
    pv_head_text(h, text);
}

void pv_head_whole(pv_volume_head *h, int64_t value)
{
    char text[PV_VOLUME_NUMBER];
    snprintf(text, sizeof text, "%lld", (long long)value);
    pv_head_text(h, text);
}

size_t pv_volume_bytes(const pave_volume *v)
{
    return (size_t)v->size[0] * (size_t)v->size[1] * (size_t)v->size[2] * (size_t)v->channels * pv_type_bytes(v->type);
}

pave_result pv_volume_put(pave_context *context, pv_output *output, const pave_volume *v)
{
    pave_result result = PAVE_OK;
    size_t all = pv_volume_bytes(v);
    for (size_t at = 0; at < all && !result; at += PV_VOLUME_CHUNK) {
        pv_output_bytes(output, v->values + at, all - at < PV_VOLUME_CHUNK ? all - at : PV_VOLUME_CHUNK);
        result = pv_progress(context, (double)at / (double)all);
    }
    return result;
}

static const struct { const char *format, *ending; pv_volume_writer *write; } formats[] = {
    { "nrrd", ".nrrd", pv_nrrd_write }, { "nrrd-gzip", ".nrrd.gz", pv_nrrd_write_gzip },
    { "vti", ".vti", pv_vti_write },    { "raw", ".raw", pv_raw_write },
    { "tiff", ".tif", pv_tiff_write },  { "tiff", ".tiff", pv_tiff_write },
};

const char *pave_volume_format(const char *path)
{
    for (size_t i = 0; path && i < sizeof formats / sizeof *formats; i++)
        if (pv_text_ends_with(path, formats[i].ending))
            return formats[i].format;
    return NULL;
}

pave_result pave_volume_write(pave_context *context, const pave_volume *volume, const char *path, const char *format)
{
    if (!context || !volume || !path)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    pave_result result = PAVE_ERR_UNSUPPORTED;
    pv_call outer = pv_call_begin(context, "write", 0, 1);
    const char *chosen = format ? format : pave_volume_format(path);
    pv_volume_writer *write = NULL;
    for (size_t i = 0; chosen && i < sizeof formats / sizeof *formats; i++)
        if (!strcmp(formats[i].format, chosen))
            write = formats[i].write;
    if (write)
        result = write(context, volume, path);
    else
        result = pv_fail(context, result, "%s: a volume is written as .nrrd, .nrrd.gz, .vti, .raw or .tif", path);
    pv_call_end(context, outer);
    errno = before;
    return result;
}

int pv_volume_reals(const char *text, double *out, int most)
{
    int count = 0;
    while (*text && count < most) {
        char word[PV_VOLUME_NUMBER];
        size_t n = strspn(text, "0123456789+-.eE");
        if (n && n < sizeof word) {
            memcpy(word, text, n);
            word[n] = 0;
            count += pv_parse_number(word, &out[count]);
        }
        text += n ? n : 1;
    }
    return count;
}

static void swap_ends(pave_volume *v)
{
    size_t each = pv_type_bytes(v->type), all = pv_volume_bytes(v);
    for (size_t at = 0; at < all && each > 1; at += each)
        for (size_t i = 0; i < each / 2; i++) {
            uint8_t b = v->values[at + i];
            v->values[at + i] = v->values[at + each - 1 - i];
            v->values[at + each - 1 - i] = b;
        }
}

void pv_volume_set_states(pave_volume *v)
{
    int64_t n = (int64_t)v->size[0] * v->size[1] * v->size[2];
    for (int64_t i = 0; i < n; i++) {
        v->states[i] = PAVE_VOXEL_MEASURED;
        for (int32_t c = 0; c < v->channels; c++)
            if (v->type == PAVE_F32 && !isfinite(((const float *)(const void *)v->values)[i * v->channels + c]))
                v->states[i] = PAVE_VOXEL_FREE;
    }
}

static pave_result read_values(pave_context *context, pv_input *input, const pv_volume_layout *l, pave_volume **out)
{
    uint8_t *bytes = NULL;
    pave_result result = pv_volume_new(context, &l->place, out);
    if (result)
        return result;
    pave_volume *v = *out;
    int64_t left = input->size - l->data;
    if (l->packed) {
        result = pv_input_load(input, &bytes);
        if (!result)
            result = pv_nrrd_inflate(context, input->path, bytes + l->data, left, v);
    } else if (left < (int64_t)pv_volume_bytes(v))
        result = pv_fail(context, PAVE_ERR_FORMAT, "%s: holds %lld bytes of values, but its header speaks of %zu",
                         input->path, (long long)left, pv_volume_bytes(v));
    else
        result = pv_input_read(input, l->data, v->values, (int64_t)pv_volume_bytes(v));
    pv_release(bytes);
    if (!result && l->big)
        swap_ends(v);
    if (!result)
        pv_volume_set_states(v);
    return result;
}

static pave_result read_file(pave_context *context, const char *path, pave_volume **out)
{
    pv_input input, values;
    char text[PV_VOLUME_HEAD + 1], other[2 * PV_VOLUME_PATH];
    pv_volume_layout l = { .place = PAVE_VOLUME_PARAMS_INIT };
    pave_result result = pv_input_open(context, path, &input);
    int64_t length = input.size < PV_VOLUME_HEAD ? input.size : PV_VOLUME_HEAD;
    if (!result)
        result = pv_input_read(&input, 0, text, length);
    if (!result) {
        text[length] = 0;
        result = !memcmp(text, "NRRD", 4)       ? pv_nrrd_read_head(context, path, text, &l)
                 : strstr(text, "<VTKFile")     ? pv_vti_read_head(context, path, text, length, &l)
                                                : pv_fail(context, PAVE_ERR_UNSUPPORTED,
                                                          "%s: volumes are read from NRRD and VTK image data", path);
    }
    if (!result && l.file[0]) {
        const char *slash = strrchr(path, '/');
        snprintf(other, sizeof other, "%.*s%s", slash ? (int)(slash - path) + 1 : 0, path, l.file);
        result = pv_input_open(context, other, &values);
        if (!result)
            result = read_values(context, &values, &l, out);
        pv_input_close(&values);
    } else if (!result)
        result = read_values(context, &input, &l, out);
    pv_input_close(&input);
    return result;
}

pave_result pave_volume_read(pave_context *context, const char *path, pave_volume **out)
{
    if (out)
        *out = NULL;
    if (!context || !path || !out)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    char sidecar[PV_VOLUME_PATH];
    pv_call outer = pv_call_begin(context, "read", 0, 1);
    pave_result result = PAVE_OK;
    if (pv_text_ends_with(path, ".tif") || pv_text_ends_with(path, ".tiff"))
        result = pv_tiff_read(context, path, out);
    else if (pv_text_ends_with(path, ".raw") && strlen(path) + 6 < sizeof sidecar) {
        snprintf(sidecar, sizeof sidecar, "%s.nhdr", path);
        result = read_file(context, sidecar, out);
    } else
        result = read_file(context, path, out);
    if (result)
        pave_volume_free(out);
    pv_call_end(context, outer);
    errno = before;
    return result;
}
