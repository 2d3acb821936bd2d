/* Applying: images laid as a tiling says. */
#include "tiling/tiling.h"

#include <string.h>

static pave_result check_images(pave_context *context, const pave_tiling *t, const pave_image *const *images,
                                int32_t count)
{
    if (count != t->exemplars)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%d images for %d exemplars", (int)count, (int)t->exemplars);
    for (int32_t i = 0; i < count; i++) {
        const pave_image *image = images[i];
        if (!image)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "image %d is NULL", (int)i);
        if (image->width != t->sizes[i][0] || image->height != t->sizes[i][1])
            return pv_fail(context, PAVE_ERR_ARGUMENT, "a map of %d x %d px does not fit an exemplar of %d x %d px",
                           (int)image->width, (int)image->height, (int)t->sizes[i][0], (int)t->sizes[i][1]);
        if (image->channels != images[0]->channels || image->type != images[0]->type)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "map %d has other channels, or another type, than the first",
                           (int)i);
    }
    return PAVE_OK;
}

pave_result pv_image_like(pave_context *context, const pave_image *model, int32_t width, int32_t height,
                          pave_image **out)
{
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    params.width = width;
    params.height = height;
    params.channels = model->channels;
    params.type = model->type;
    params.encoding = model->encoding;
    params.alpha = model->alpha;
    pave_result result = pv_image_new(context, &params, out);
    if (!result)
        memcpy((*out)->names, model->names, sizeof model->names);
    return result;
}

static void copy_pixels(const pave_tiling *t, const pave_image *const *images, pave_image *out)
{
    size_t pixel = (size_t)out->channels * pv_type_bytes(out->type);
    for (int64_t i = 0; i < (int64_t)t->width * t->height; i++) {
        const pave_source *s = &t->sources[i];
        const pave_image *image = images[s->exemplar];
        memcpy((char *)out->pixels + (size_t)i * pixel,
               (const char *)image->pixels + ((size_t)s->y * (size_t)image->width + (size_t)s->x) * pixel, pixel);
    }
}

pave_result pave_tiling_apply(pave_context *context, const pave_tiling *tiling, const pave_image *const *images,
                              int32_t count, pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !tiling || !images || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = check_images(context, tiling, images, count);
    if (!result)
        result = pv_image_like(context, images[0], tiling->width, tiling->height, out);
    if (!result)
        copy_pixels(tiling, images, *out);
    return result;
}

pave_result pave_tiling_source_image(pave_context *context, const pave_tiling *tiling, pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !tiling || !out)
        return PAVE_ERR_ARGUMENT;
    pave_image_params params = PAVE_IMAGE_PARAMS_INIT;
    params.width = tiling->width;
    params.height = tiling->height;
    params.channels = 4;
    params.type = PAVE_U32;
    params.encoding = PAVE_DATA;
    params.names = "exemplar,x,y,turn";
    pave_result result = pv_image_new(context, &params, out);
    if (!result)
        memcpy((*out)->pixels, tiling->sources, (size_t)tiling->width * (size_t)tiling->height * sizeof(pave_source));
    return result;
}
