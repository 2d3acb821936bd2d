/* Maps as a folder of images, and a file that says what they are of. */
#include <pave/io.h>

#include "io/output.h"
#include "io/parameters.h"
#include "image/image.h"
#include "maps/maps.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { TRIES = 100 };

static const pave_maps_file_params default_params = PAVE_MAPS_FILE_PARAMS_INIT;

static const pv_param rows[] = {
    PV_CHOICE(pave_maps_file_params, format, "png|exr", "what maps are written as"),
};

extern const pv_table pv_maps_file_table;
const pv_table pv_maps_file_table = PV_TABLE("maps file", default_params, rows);

void pave_maps_file_params_init(pave_maps_file_params *params, size_t size)
{
    pv_params_init(&pv_maps_file_table, params, size);
}

static const char *const names[PAVE_MAP_COUNT] = {
    [PAVE_MAP_COLOUR] = "colour",       [PAVE_MAP_HEIGHT] = "height",       [PAVE_MAP_NORMAL] = "normal",
    [PAVE_MAP_ROUGHNESS] = "roughness", [PAVE_MAP_OCCLUSION] = "occlusion", [PAVE_MAP_MASK] = "mask",
    [PAVE_MAP_ID] = "id",
};

/* The folder's files while they are made: in a folder of another name beside it. */
typedef struct writing {
    pave_context *context;
    const pave_maps *maps;
    const char *path;
    int32_t exr;
    char target[PATH_MAX];
    char folder[PATH_MAX + 64];
} writing;

enum { REPORT = PAVE_MAP_COUNT, FILES };

static void name_file(const writing *w, const char *folder, int32_t which, char *out, size_t room)
{
    const char *ending = which == REPORT ? ".json" : w->exr || which == PAVE_MAP_ID ? ".exr" : ".png";
    snprintf(out, room, "%s/%s%s", folder, which == REPORT ? "maps" : names[which], ending);
}

static pave_result unwritable(const writing *w, int error)
{
    return pv_fail(w->context, PAVE_ERR_IO, "%s: cannot be written: %s", w->path, pv_system_error(error));
}

/* Heights from the lowest to the highest as 16 bits. */
static pave_result scaled_heights(const writing *w, pave_image **out)
{
    const pave_image *from = w->maps->image[PAVE_MAP_HEIGHT];
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    double low = w->maps->lowest, range = w->maps->highest - low;
    shape.width = from->width;
    shape.height = from->height;
    shape.type = PAVE_U16;
    shape.encoding = PAVE_DATA;
    pave_result result = pv_image_new(w->context, &shape, out);
    for (int64_t i = 0; i < (int64_t)from->width * from->height && !result; i++) {
        double part = range > 0 ? ((double)((const float *)from->pixels)[i] - low) / range : 0;
        ((uint16_t *)(*out)->pixels)[i] = (uint16_t)(pv_clamped(part, 0, 1) * 65535 + 0.5);
    }
    return result;
}

static pave_result write_map(const writing *w, int32_t which)
{
    char path[PATH_MAX + 128];
    pave_image *scaled = NULL;
    pave_result result = PAVE_OK;
    name_file(w, w->folder, which, path, sizeof path);
    if (which == PAVE_MAP_HEIGHT && !w->exr)
        result = scaled_heights(w, &scaled);
    if (!result)
        result = pave_image_write(w->context, scaled ? scaled : w->maps->image[which], path);
    pave_image_free(&scaled);
    return result;
}

static void put_report(const writing *w, pv_json *json)
{
    const pave_maps *maps = w->maps;
    pv_json_object(json, NULL);
    pv_json_string(json, "pave", pave_version());
    pv_json_whole(json, "x", maps->frame.x);
    pv_json_whole(json, "y", maps->frame.y);
    pv_json_whole(json, "width", maps->frame.width);
    pv_json_whole(json, "height", maps->frame.height);
    pv_json_number(json, "height_lowest", maps->lowest);
    pv_json_number(json, "height_highest", maps->highest);
    pv_json_object(json, "files");
    for (int32_t i = 0; i < PAVE_MAP_COUNT; i++) {
        char name[PATH_MAX];
        name_file(w, "", i, name, sizeof name);
        pv_json_string(json, names[i], name + 1);
    }
    pv_json_close(json);
    pv_json_params(json, &pv_maps_table, &maps->params);
    pv_json_close(json);
}

static pave_result write_report(const writing *w)
{
    char path[PATH_MAX + 128];
    pv_json json;
    pv_output *output;
    name_file(w, w->folder, REPORT, path, sizeof path);
    pave_result result = pv_output_open(w->context, path, 0, &output);
    if (result)
        return result;
    pv_json_begin(&json, pv_output_put, output);
    put_report(w, &json);
    return pv_output_close(output, PAVE_OK);
}

/* The target without slashes at its end, and a folder beside it. */
static pave_result make_folder(writing *w)
{
    static atomic_uint count;
    struct stat info;
    size_t length = strlen(w->path);
    while (length > 1 && w->path[length - 1] == '/')
        length--;
    if (!length || length >= sizeof w->target)
        return unwritable(w, length ? ENAMETOOLONG : ENOENT);
    memcpy(w->target, w->path, length);
    w->target[length] = 0;
    if (!stat(w->target, &info) && !S_ISDIR(info.st_mode))
        return unwritable(w, ENOTDIR);
    const char *slash = strrchr(w->target, '/');
    int before = slash ? (int)(slash - w->target) + 1 : 0;
    for (int i = 0; i < TRIES; i++) {
        snprintf(w->folder, sizeof w->folder, "%.*s.pave-%ld-%u.tmp", before, w->target, (long)getpid(),
                 atomic_fetch_add(&count, 1));
        if (!mkdir(w->folder, 0777))
            return PAVE_OK;
        if (errno != EEXIST)
            break;
    }
    return unwritable(w, errno);
}

/* Durable before they are moved; one after the other, for the folder may hold other things. */
static pave_result move_all(const writing *w)
{
    char from[PATH_MAX + 128], to[PATH_MAX + 128];
    int folder = open(w->folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC), error = folder < 0 || syncfs(folder) ? errno : 0;
    if (!error && mkdir(w->target, 0777) && errno != EEXIST)
        error = errno;
    for (int32_t i = 0; i < FILES && !error; i++) {
        name_file(w, w->folder, i, from, sizeof from);
        name_file(w, w->target, i, to, sizeof to);
        error = rename(from, to) ? errno : 0;
    }
    if (!error)
        syncfs(folder);
    if (folder >= 0)
        close(folder);
    return error ? unwritable(w, error) : PAVE_OK;
}

static void remove_folder(const writing *w)
{
    char path[PATH_MAX + 128];
    for (int32_t i = 0; i < FILES; i++) {
        name_file(w, w->folder, i, path, sizeof path);
        unlink(path);
    }
    rmdir(w->folder);
}

static pave_result write_all(const writing *w)
{
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < PAVE_MAP_COUNT && !result; i++) {
        pv_call call = pv_call_begin(w->context, "write", (double)i / FILES, (i + 1.0) / FILES);
        result = write_map(w, i);
        pv_call_end(w->context, call);
    }
    if (!result)
        result = write_report(w);
    return result ? result : move_all(w);
}

pave_result pave_maps_write(pave_context *context, const pave_maps *maps, const pave_maps_file_params *given,
                            const char *folder)
{
    pave_maps_file_params params;
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!maps || !folder)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_maps_write: maps or folder is NULL");
    pave_result result = pv_params_read(context, &pv_maps_file_table, given, &params);
    if (result)
        return result;
    int before = errno;
    writing w = { .context = context, .maps = maps, .path = folder, .exr = params.format == PAVE_MAPS_EXR };
    pv_call outer = pv_call_begin(context, "write", 0, 1);
    result = make_folder(&w);
    if (!result) {
        context->drafts++;
        result = write_all(&w);
        context->drafts--;
        remove_folder(&w);
    }
    pv_call_end(context, outer);
    errno = before;
    return result;
}
