/* Where a BTF's samples are: in memory, in a file that is mapped, in its factors or in a scene. */
#include "btf/btf.h"

#include "btf/scene.h"
#include "image/image.h"
#include "util/half.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

double pv_btf_sample_bytes(const pave_btf *btf)
{
    return (double)pv_btf_texels(btf) * (double)pv_btf_length(btf) * (btf->type == PAVE_F16 ? 2 : 4);
}

void pv_btf_place_samples(pave_btf *btf, void *at)
{
    btf->samples.first = at;
    btf->samples.texel_bytes = (size_t)pv_btf_length(btf) * (btf->type == PAVE_F16 ? 2 : 4);
    btf->samples.chunk = INT32_MAX;
}

pave_result pv_btf_allocate_samples(pave_context *context, pave_btf *btf)
{
    pave_result result = PAVE_OK;
    size_t value = btf->type == PAVE_F16 ? 2 : 4;
    double bytes = pv_btf_sample_bytes(btf);
    if (bytes > (double)context->limits.max_bytes)
        return pv_fail(context, PAVE_ERR_LIMIT, "the samples take %.0f bytes, beyond the limit of %lld (max_bytes)",
                       bytes, (long long)context->limits.max_bytes);
    void *block = pv_allocate(context, (size_t)pv_btf_texels(btf), (size_t)pv_btf_length(btf) * value, &result);
    if (block)
        pv_btf_place_samples(btf, block);
    btf->samples.block = block;
    return result;
}

/* Where a texel's samples lie; NULL if they were left out of the file. */
static const uint8_t *texel_bytes(const pave_btf *btf, int64_t texel)
{
    const pv_samples *s = &btf->samples;
    int64_t slot = s->slots ? s->slots[texel] : texel;
    return slot < 0 ? NULL : s->first + (size_t)slot * s->texel_bytes + (size_t)(slot / s->chunk) * s->gap;
}

void pv_btf_samples(const pave_btf *btf, int64_t texel, int64_t first, int64_t count, float *out)
{
    const uint8_t *from = texel_bytes(btf, texel);
    if (!from)
        memset(out, 0, (size_t)count * sizeof *out);
    else if (btf->type == PAVE_F32)
        memcpy(out, from + 4 * first, (size_t)count * sizeof *out);
    else
        for (int64_t i = 0; i < count; i++) {
            uint16_t half;
            memcpy(&half, from + 2 * (first + i), sizeof half);
            out[i] = pv_half_value(half);
        }
}

void pv_btf_leave(const pave_btf *btf, int64_t texel)
{
    const uint8_t *first = btf->samples.map ? texel_bytes(btf, texel) : NULL;
    uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE);
    uintptr_t from = ((uintptr_t)first + page - 1) & ~(page - 1);
    uintptr_t to = ((uintptr_t)first + btf->samples.texel_bytes) & ~(page - 1);
    if (first && to > from)
        madvise((void *)from, to - from, MADV_DONTNEED);
}

int pv_all_finite(const float *values, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return 0;
    return 1;
}

void pv_btf_put(pave_btf *btf, int64_t texel, int64_t first, int64_t count, const float *values)
{
    uint8_t *to = (uint8_t *)(uintptr_t)btf->samples.first + (size_t)texel * btf->samples.texel_bytes;
    if (btf->type == PAVE_F32)
        memcpy(to + 4 * first, values, (size_t)count * sizeof *values);
    else
        for (int64_t i = 0; i < count; i++)
            ((uint16_t *)(void *)to)[first + i] = pv_half(values[i]);
}

static float product(const float *a, const float *b, int32_t count)
{
    float sum[8] = { 0 };
    int32_t i = 0;
    for (; i + 8 <= count; i += 8)
        for (int32_t k = 0; k < 8; k++)
            sum[k] += a[i + k] * b[i + k];
    for (; i < count; i++)
        sum[0] += a[i] * b[i];
    return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

static void sample_scene(const pave_btf *btf, int64_t texel, int64_t pair, float *out)
{
    float values[PV_MOST_LIGHTS * 3];
    pv_scene_view(btf->scene, texel, (int32_t)(pair / btf->lights.count), values);
    memcpy(out, values + pair % btf->lights.count * 3, 3 * sizeof *out);
}

void pv_btf_sample(const pave_btf *btf, int64_t texel, int64_t pair, float *out)
{
    if (btf->scene) {
        sample_scene(btf, texel, pair, out);
        return;
    }
    if (!btf->factors) {
        pv_btf_samples(btf, texel, pair * btf->channels, btf->channels, out);
        return;
    }
    float values[PV_BTF_CHANNELS];
    for (int32_t c = 0; c < btf->channels; c++) {
        const pv_factors *f = &btf->factors[btf->joint ? 0 : c];
        int64_t row = btf->joint ? pair * btf->channels + c : pair;
        values[c] = product(f->left + row * f->components, f->right + texel * f->components, f->components);
    }
    pv_colour_decode(btf->colour, PV_LEAST_LIGHT, btf->colour_space, btf->channels, values, 1, out);
}

void pv_btf_from_view(const pave_btf *btf, int64_t texel, int32_t view, float *out)
{
    int32_t lights = btf->lights.count;
    int64_t first = (int64_t)view * lights;
    if (btf->scene)
        pv_scene_view(btf->scene, texel, view, out);
    else if (!btf->factors)
        pv_btf_samples(btf, texel, first * btf->channels, (int64_t)lights * btf->channels, out);
    else
        for (int32_t l = 0; l < lights; l++)
            pv_btf_sample(btf, texel, first + l, out + (int64_t)l * btf->channels);
}

pave_result pv_btf_picture(pave_context *context, const pave_btf *btf, int32_t width, int32_t height, int alpha,
                           pave_image **out)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    char names[PV_BTF_CHANNELS * PV_BTF_NAME + 2] = "", *to = names;
    shape.width = width;
    shape.height = height;
    shape.channels = btf->channels + alpha;
    shape.type = PAVE_F32;
    shape.encoding = PAVE_LINEAR;
    shape.alpha = alpha ? btf->channels : -1;
    for (int32_t c = 0; c < btf->channels; c++)
        to += sprintf(to, "%s%s", c ? "," : "", btf->names[c]);
    strcpy(to, alpha ? ",A" : "");
    shape.names = names;
    if (shape.channels > PV_MOST_CHANNELS)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "a picture has at most %d channels, and this BTF has %d",
                       PV_MOST_CHANNELS - alpha, (int)btf->channels);
    return pv_image_new(context, &shape, out);
}
