/* Blending by a compute shader: factors lie on the device, terms go there and sums come back. */
#include "btf/view_device.h"

#include "backend/kernel.h"

#include <string.h>

enum { TERMS, COUNTS, LEFT, RIGHT, SUMS, BUFFERS };

/* Twin of the shader's. */
typedef struct push {
    int32_t base, most, channels, joint, colour;
    int32_t components[PV_BLEND_CHANNELS], left[PV_BLEND_CHANNELS], right[PV_BLEND_CHANNELS];
    float space[12];
} push;

struct pv_blender {
    pave_context *context;
    pv_kernel *kernel;
    push push;
    double cost; /* of a term */
};

static int64_t left_size(const pave_btf *btf, int32_t plane)
{
    return pv_btf_rows(btf) * btf->factors[plane].components;
}

static int64_t right_size(const pave_btf *btf, int32_t plane)
{
    return pv_btf_texels(btf) * btf->factors[plane].components;
}

/* Where each matrix lies in the buffers of them all. */
static pave_result lay_out(pv_blender *b, const pave_btf *btf, int64_t size[2])
{
    push *p = &b->push;
    size[0] = size[1] = 0;
    p->channels = btf->channels;
    p->joint = btf->joint;
    p->colour = btf->colour;
    memcpy(p->space, btf->colour_space, sizeof p->space);
    for (int32_t c = 0; c < btf->channels; c++) {
        int32_t plane = btf->joint ? 0 : c;
        p->components[c] = btf->factors[plane].components;
        p->left[c] = (int32_t)(btf->joint ? 0 : size[0]);
        p->right[c] = (int32_t)(btf->joint ? 0 : size[1]);
        b->cost += p->components[c];
        size[0] += plane == c ? left_size(btf, plane) : 0;
        size[1] += plane == c ? right_size(btf, plane) : 0;
        if (size[0] > INT32_MAX || size[1] > INT32_MAX)
            return pv_fail(b->context, PAVE_ERR_UNSUPPORTED, "the factors are too large for graphics devices");
    }
    return PAVE_OK;
}

/* A buffer is written from its start on, so all matrices go there together. */
static pave_result upload(pv_blender *b, const pave_btf *btf, int32_t buffer, int64_t size)
{
    pave_result result = PAVE_OK;
    float *all = pv_allocate(b->context, (size_t)size, sizeof *all, &result);
    for (int32_t c = 0; c < pv_btf_planes(btf) && !result; c++) {
        const pv_factors *f = &btf->factors[c];
        if (buffer == LEFT)
            memcpy(all + b->push.left[c], f->left, (size_t)left_size(btf, c) * sizeof *all);
        else
            memcpy(all + b->push.right[c], f->right, (size_t)right_size(btf, c) * sizeof *all);
    }
    if (!result)
        result = pv_kernel_write(b->kernel, buffer, all, size * (int64_t)sizeof *all);
    pv_release(all);
    return result;
}

static pave_result prepare(pv_blender *b, const pave_btf *btf, int32_t pixels, int32_t most)
{
    int64_t size[2];
    pave_result result = lay_out(b, btf, size);
    if (result)
        return result;
    pv_kernel_params params = {
        .shader = PV_KERNEL_BLEND, .buffers = BUFFERS, .what = "the factors are",
        .bytes = { [TERMS] = (int64_t)sizeof(pv_term) * pixels * most, [COUNTS] = 4 * (int64_t)pixels,
                   [LEFT] = 4 * size[0], [RIGHT] = 4 * size[1], [SUMS] = 4 * PV_BLEND_CHANNELS * (int64_t)pixels },
    };
    b->push.most = most;
    result = pv_kernel_open(b->context, &params, &b->kernel);
    if (!result)
        result = upload(b, btf, LEFT, size[0]);
    return result ? result : upload(b, btf, RIGHT, size[1]);
}

pave_result pv_blender_open(pave_context *context, const pave_btf *btf, int32_t pixels, int32_t most, pv_blender **out)
{
    pave_result result = PAVE_OK;
    *out = NULL;
    if (!btf->factors)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "graphics devices draw factored BTFs: compress this one first");
    if (btf->channels > PV_BLEND_CHANNELS)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "graphics devices draw BTFs of at most %d channels, not of %d",
                       PV_BLEND_CHANNELS, (int)btf->channels);
    pv_blender *b = pv_allocate_zeroed(context, 1, sizeof *b, &result);
    if (!b)
        return result;
    b->context = context;
    result = prepare(b, btf, pixels, most);
    if (result)
        pv_blender_close(b);
    else
        *out = b;
    return result;
}

void pv_blender_close(pv_blender *b)
{
    if (!b)
        return;
    pv_kernel_close(b->kernel);
    pv_release(b);
}

pave_result pv_blender_run(pv_blender *b, const pv_term *terms, const int32_t *counts, int32_t pixels, float *sums)
{
    int64_t all = 0;
    for (int32_t i = 0; i < pixels; i++)
        all += counts[i];
    double cost = b->cost * (1 + (double)all / pixels);
    pave_result result = pv_kernel_write(b->kernel, TERMS, terms, (int64_t)sizeof *terms * pixels * b->push.most);
    if (!result)
        result = pv_kernel_write(b->kernel, COUNTS, counts, 4 * (int64_t)pixels);
    for (int32_t some; b->push.base < pixels && !result; b->push.base += some) {
        some = pv_kernel_slice(b->kernel, pixels - b->push.base, 1, cost);
        result = pv_kernel_run(b->kernel, &b->push, sizeof b->push, some, some * cost);
    }
    b->push.base = 0;
    return result ? result : pv_kernel_read(b->kernel, SUMS, sums, 4 * PV_BLEND_CHANNELS * (int64_t)pixels);
}
