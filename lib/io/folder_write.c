/* BTFs to folders of pictures, as UTIA names them; the folder appears when it is complete. */
#include "io/folder.h"

#include "io/exr.h"
#include "io/output.h"
#include "io/raster.h"
#include "image/image.h"
#include "util/half.h"
#include "util/light.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SHARE = 8, TRIES = 100 };

static const double degree = 3.14159265358979323846 / 180;

/* "030", "007.5": thousandths are as fine as a float of an angle is. */
static void put_degrees(char out[16], double radians)
{
    long thousandths = lround(fmod(radians / degree + 360, 360) * 1000) % 360000;
    int n = snprintf(out, 16, "%03ld", thousandths / 1000);
    if (thousandths % 1000) {
        n += snprintf(out + n, (size_t)(16 - n), ".%03ld", thousandths % 1000);
        while (out[n - 1] == '0')
            out[--n] = 0;
    }
}

/* A folder being written, and what it will be called. */
typedef struct writing {
    pave_context *context;
    const pave_btf *btf;
    const char *path, *ending;
    char folder[PATH_MAX]; /* of a name of its own, until it is renamed */
    int64_t cut;           /* samples that a PNG could not hold */
    int32_t group;         /* lights at once */
    float *samples;        /* [texel][light][channel], of the lights at once */
    float *row;            /* a texel's whole view */
} writing;

static void name_view(const writing *w, int32_t view, char *out, size_t room)
{
    char theta[16], phi[16];
    put_degrees(theta, (double)w->btf->views.direction[view].theta);
    put_degrees(phi, (double)w->btf->views.direction[view].phi);
    snprintf(out, room, "tv%s_pv%s", theta, phi);
}

static void name_picture(const writing *w, int32_t view, int32_t light, char *out, size_t room)
{
    char of_view[40], theta[16], phi[16];
    name_view(w, view, of_view, sizeof of_view);
    put_degrees(theta, (double)w->btf->lights.direction[light].theta);
    put_degrees(phi, (double)w->btf->lights.direction[light].phi);
    snprintf(out, room, "%s/%s/tl%s_pl%s_%s%s", w->folder, of_view, theta, phi, of_view, w->ending);
}

static pave_result unwritable(const writing *w, int error)
{
    return pv_fail(w->context, PAVE_ERR_IO, "%s: cannot be written: %s", w->path, pv_system_error(error));
}

static pave_result new_picture(const writing *w, pave_image **out)
{
    const pave_btf *btf = w->btf;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    char names[PV_BTF_CHANNELS * PV_BTF_NAME], *to = names;
    int png = w->ending[1] == 'p';
    for (int32_t c = 0; c < btf->channels; c++)
        to += sprintf(to, "%s%s", c ? "," : "", btf->names[c]);
    shape.width = btf->width;
    shape.height = btf->height;
    shape.channels = btf->channels;
    shape.type = png ? PAVE_U8 : btf->type;
    shape.encoding = png ? PAVE_DISPLAY : PAVE_LINEAR;
    shape.alpha = -1;
    shape.names = names;
    return pv_image_new(w->context, &shape, out);
}

static void put_value(writing *w, pave_image *image, int64_t at, float value)
{
    if (image->type == PAVE_U8) {
        w->cut += !(value <= 1);
        ((uint8_t *)image->pixels)[at] = (uint8_t)(pv_display_code(fmin(fmax((double)value, 0), 1)) * 255 + 0.5);
    } else if (image->type == PAVE_F16)
        ((uint16_t *)image->pixels)[at] = pv_half(fminf(fmaxf(value, -65504), 65504));
    else
        ((float *)image->pixels)[at] = value;
}

static pave_result write_picture(writing *w, int32_t view, int32_t light, int32_t in_group)
{
    char path[PATH_MAX + 128];
    pave_image *image;
    int32_t channels = w->btf->channels;
    pave_result result = new_picture(w, &image);
    if (result)
        return result;
    for (int64_t t = 0; t < pv_btf_texels(w->btf); t++)
        for (int32_t c = 0; c < channels; c++)
            put_value(w, image, t * channels + c, w->samples[(t * w->group + in_group) * channels + c]);
    name_picture(w, view, light, path, sizeof path);
    result = w->ending[1] == 'p' ? pv_raster_write(w->context, image, path, "png")
                                 : pv_exr_write(w->context, image, path);
    pave_image_free(&image);
    return result;
}

static pave_result write_lights(writing *w, int32_t view, int32_t first)
{
    int32_t channels = w->btf->channels, lights = w->btf->lights.count;
    int32_t count = lights - first < w->group ? lights - first : w->group;
    pave_result result = PAVE_OK;
    for (int64_t t = 0; t < pv_btf_texels(w->btf); t++) {
        pv_btf_from_view(w->btf, t, view, w->row);
        memcpy(w->samples + t * w->group * channels, w->row + (int64_t)first * channels,
               (size_t)(count * channels) * sizeof(float));
    }
    for (int32_t l = 0; l < count && !result; l++) {
        double pairs = (double)w->btf->views.count * lights, done = (double)view * lights + first + l;
        if (w->btf->missing && w->btf->missing[(int64_t)view * lights + first + l])
            continue;
        pv_call call = pv_call_begin(w->context, "write", done / pairs, (done + 1) / pairs);
        result = write_picture(w, view, first + l, l);
        pv_call_end(w->context, call);
    }
    return result;
}

static pave_result write_view(writing *w, int32_t view)
{
    char path[PATH_MAX + 64], name[40];
    pave_result result = PAVE_OK;
    name_view(w, view, name, sizeof name);
    snprintf(path, sizeof path, "%s/%s", w->folder, name);
    if (mkdir(path, 0777))
        return unwritable(w, errno);
    for (int32_t l = 0; l < w->btf->lights.count && !result; l += w->group)
        result = write_lights(w, view, l);
    return result;
}

/* Only what was written is removed. */
static void remove_all(const writing *w)
{
    char path[PATH_MAX + 128], name[40];
    for (int32_t v = 0; v < w->btf->views.count; v++) {
        for (int32_t l = 0; l < w->btf->lights.count; l++) {
            name_picture(w, v, l, path, sizeof path);
            unlink(path);
        }
        name_view(w, v, name, sizeof name);
        snprintf(path, sizeof path, "%s/%s", w->folder, name);
        rmdir(path);
    }
    rmdir(w->folder);
}

static int holds_something(const char *path)
{
    DIR *folder = opendir(path);
    struct dirent *entry;
    int found = !folder && errno != ENOENT;
    while (folder && !found && (entry = readdir(folder)))
        if (strcmp(entry->d_name, ".") && strcmp(entry->d_name, ".."))
            found = 1, errno = ENOTEMPTY;
    int error = errno;
    if (folder)
        closedir(folder);
    errno = error;
    return found;
}

/* The target without slashes at its end, and a folder beside it. */
static pave_result make_folder(writing *w, char *target)
{
    static atomic_uint count;
    size_t length = strlen(w->path);
    while (length > 1 && w->path[length - 1] == '/')
        length--;
    if (length >= PATH_MAX - 64)
        return unwritable(w, ENAMETOOLONG);
    memcpy(target, w->path, length);
    target[length] = 0;
    if (holds_something(target)) /* an empty one gives way */
        return unwritable(w, errno);
    const char *slash = strrchr(target, '/');
    int before = slash ? (int)(slash - target) + 1 : 0;
    for (int i = 0; i < TRIES; i++) {
        snprintf(w->folder, sizeof w->folder, "%.*s.pave-%ld-%u.tmp", before, target, (long)getpid(),
                 atomic_fetch_add(&count, 1));
        if (!mkdir(w->folder, 0777))
            return PAVE_OK;
        if (errno != EEXIST)
            break;
    }
    return unwritable(w, errno);
}

static pave_result open_writing(writing *w)
{
    const pave_btf *btf = w->btf;
    pave_result result = PAVE_OK;
    size_t texel = (size_t)btf->channels * sizeof(float);
    double light = (double)pv_btf_texels(btf) * (double)texel;
    double fitting = (double)w->context->limits.max_bytes / SHARE / light;
    w->group = fitting < 1 ? 1 : fitting < btf->lights.count ? (int32_t)fitting : btf->lights.count;
    w->row = pv_allocate(w->context, (size_t)btf->lights.count, texel, &result);
    if (!result)
        w->samples = pv_allocate(w->context, (size_t)w->group, (size_t)light, &result);
    return result;
}

/* All pictures at once: to wait for the disk after each takes far longer. */
static pave_result settle(const writing *w, const char *target)
{
    int folder = open(w->folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC), error = folder < 0 || syncfs(folder) ? errno : 0;
    if (!error && rename(w->folder, target))
        error = errno;
    if (!error)
        syncfs(folder);
    if (folder >= 0)
        close(folder);
    return error ? unwritable(w, error) : PAVE_OK;
}

static pave_result write_all(writing *w, const char *target)
{
    pave_result result = open_writing(w);
    for (int32_t v = 0; v < w->btf->views.count && !result; v++)
        result = write_view(w, v);
    if (!result)
        result = settle(w, target);
    if (result)
        remove_all(w);
    else if (w->cut)
        pv_note(w->context, PAVE_MESSAGE_WARNING, "%s: PNG ends at 1, and %lld samples beyond it were cut", w->path,
                (long long)w->cut);
    pv_release(w->row);
    pv_release(w->samples);
    return result;
}

pave_result pv_folder_write(pave_context *context, const pave_btf *btf, const pave_btf_file_params *params,
                            const char *path)
{
    writing w = { .context = context, .btf = btf, .path = path };
    char target[PATH_MAX];
    w.ending = params->pictures == PAVE_BTF_PNG ? ".png" : ".exr";
    if (params->pictures == PAVE_BTF_PNG && btf->channels != 1 && btf->channels != 3)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: PNG holds 1 or 3 channels, and this BTF has %d; write EXR",
                       path, (int)btf->channels);
    pave_result result = make_folder(&w, target);
    if (result)
        return result;
    context->drafts++;
    result = write_all(&w, target);
    context->drafts--;
    return result;
}
