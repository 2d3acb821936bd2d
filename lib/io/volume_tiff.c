/* A stack of TIFF pages by number. */
#include "io/volume.h"

#include "image/image.h"

#include <pave/io.h>

#include <stdio.h>
#include <string.h>

/* "stone.tif" becomes "stone-0000.tif" and so on: one page a slice along z. */
static int page_path(const char *path, int32_t page, char out[PV_VOLUME_PATH])
{
    const char *dot = strrchr(path, '.');
    int n = snprintf(out, PV_VOLUME_PATH, "%.*s-%04d%s", (int)(dot - path), path, (int)page, dot);
    return n > 0 && n < PV_VOLUME_PATH;
}

pave_result pv_tiff_write(pave_context *context, const pave_volume *v, const char *path)
{
    char page[PV_VOLUME_PATH];
    pave_result result = PAVE_OK;
    for (int32_t z = 0; z < v->size[2] && !result; z++) {
        pave_image *image = NULL;
        if (!page_path(path, z, page))
            return pv_fail(context, PAVE_ERR_IO, "%s: cannot be written: the name is too long", path);
        result = pave_volume_slice(context, v, 2, z, &image);
        if (!result)
            result = pave_image_write(context, image, page);
        pave_image_free(&image);
    }
    return result;
}

static pave_result add_page(pave_context *context, const pave_image *image, int32_t page, pave_volume *v)
{
    if (image->width != v->size[0] || image->height != v->size[1] || image->channels != v->channels ||
        image->type != v->type)
        return pv_fail(context, PAVE_ERR_FORMAT, "page %d of the stack differs from the first", (int)page);
    size_t bytes = pv_volume_bytes(v) / (size_t)v->size[2];
    memcpy(v->values + (size_t)page * bytes, image->pixels, bytes);
    return PAVE_OK;
}

static pave_result read_page(pave_context *context, const char *path, int32_t page, pave_image **out)
{
    char name[PV_VOLUME_PATH];
    if (!page_path(path, page, name))
        return pv_fail(context, PAVE_ERR_IO, "%s: cannot be read: the name is too long", path);
    return pave_image_read(context, name, out);
}

/* How many pages there are, without a gap. */
static int32_t count_pages(const char *path)
{
    char name[PV_VOLUME_PATH];
    int32_t pages = 0;
    for (; pages < 1 << 20 && page_path(path, pages, name); pages++) {
        FILE *file = fopen(name, "rb");
        if (!file)
            break;
        fclose(file);
    }
    return pages;
}

pave_result pv_tiff_read(pave_context *context, const char *path, pave_volume **out)
{
    pave_volume_params place = PAVE_VOLUME_PARAMS_INIT;
    pave_result result = PAVE_OK;
    int32_t pages = count_pages(path);
    for (int32_t z = 0; (z < pages || z == 0) && !result; z++) {
        pave_image *image = NULL;
        result = read_page(context, path, z, &image);
        if (!result && z == 0) {
            place.width = image->width;
            place.height = image->height;
            place.depth = pages;
            place.channels = image->channels;
            place.type = image->type;
            result = pv_volume_new(context, &place, out);
        }
        if (!result)
            result = add_page(context, image, z, *out);
        pave_image_free(&image);
    }
    if (!result)
        pv_volume_set_states(*out);
    return result;
}
