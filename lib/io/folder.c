/* BTFs from sets of pictures: UBO2003, ATRIUM and UTIA name each by the angles of its light and view. */
#include "io/folder.h"

#include "io/drawing.h"
#include "io/input.h"
#include "io/output.h"
#include "io/spool.h"
#include "io/zip.h"
#include "image/image.h"
#include "util/light.h"
#include "util/text.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { DEPTH = 8, FIRST_ROOM = 256, MOST_PICTURES = 1 << 24 };

static int is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

static int is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* A number of degrees ("030", "7.5", "-15") that does not take the point of an ending with it. */
static size_t parse_degrees(const char *text, double *out)
{
    char word[32];
    size_t n = text[0] == '-', first = n;
    while (is_digit(text[n]))
        n++;
    if (n == first)
        return 0;
    if (text[n] == '.' && is_digit(text[n + 1]))
        for (n++; is_digit(text[n]);)
            n++;
    if (n >= sizeof word)
        return 0;
    memcpy(word, text, n);
    word[n] = 0;
    return pv_parse_number(word, out) ? n : 0;
}

int pv_parse_angles(const char *name, double light[2], double view[2])
{
    unsigned seen = 0;
    for (const char *p = name; *p; p++) {
        int polar = (*p | 32) == 't', azimuth = (*p | 32) == 'p', of_view = (p[1] | 32) == 'v';
        double value;
        if ((!polar && !azimuth) || (!of_view && (p[1] | 32) != 'l') || (p > name && is_letter(p[-1])) ||
            !parse_degrees(p + 2, &value))
            continue;
        (of_view ? view : light)[azimuth] = value;
        seen |= 1u << (2 * of_view + azimuth);
    }
    return seen == 15;
}

/* A set of pictures while it is read. */
typedef struct collection {
    pave_context *context;
    const char *path;
    const pave_btf_file_params *params;
    pv_shot *shots;
    int64_t count, room;
    char *text; /* names of a folder's pictures, below it */
    size_t text_size, text_room;
    size_t *name_at;
    pv_zip *zip;
    int file; /* what is unpacked of an archive */
    pave_btf_params shape;
    char names[PV_BTF_CHANNELS * PV_BTF_NAME];
    int64_t others; /* files that are no pictures of the set */
} collection;

static const char *name_of(const collection *c, int64_t source)
{
    return c->zip ? c->zip->member[source].name : c->text + c->name_at[source];
}

static int is_picture(const char *name)
{
    static const char *const endings[] = { ".jpg", ".jpeg", ".png", ".exr", ".hdr", ".tif", ".tiff" };
    const char *point = strrchr(name, '.');
    char ending[8] = "";
    for (size_t i = 0; point && i < sizeof ending - 1 && point[i]; i++)
        ending[i] = point[i] >= 'A' && point[i] <= 'Z' ? (char)(point[i] + 32) : point[i];
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
        if (!strcmp(ending, endings[i]))
            return 1;
    return 0;
}

static pave_result add_shot(collection *c, const char *name, int64_t source)
{
    pave_result result = PAVE_OK;
    pv_shot shot = { .source = source };
    if (!is_picture(name) || !pv_parse_angles(name, shot.light, shot.view)) {
        c->others++;
        return PAVE_OK;
    }
    if (c->count == c->room) {
        int64_t grown = c->room ? 2 * c->room : FIRST_ROOM;
        void *shots = grown > MOST_PICTURES ? NULL
                                            : pv_resize(c->context, c->shots, (size_t)c->room, (size_t)grown,
                                                        sizeof *c->shots, &result);
        if (!shots)
            return result ? result : pv_fail(c->context, PAVE_ERR_LIMIT, "%s: holds too many pictures", c->path);
        c->shots = shots;
        c->room = grown;
    }
    c->shots[c->count++] = shot;
    return PAVE_OK;
}

/* ---- Folders ---- */

static pave_result keep_name(collection *c, const char *name)
{
    pave_result result = PAVE_OK;
    size_t length = strlen(name) + 1;
    int64_t before = c->count, room = c->room;
    if (c->text_room - c->text_size < length) {
        size_t grown = 2 * c->text_room + length + 4096;
        char *text = pv_resize(c->context, c->text, c->text_room, grown, 1, &result);
        if (!text)
            return result;
        c->text = text;
        c->text_room = grown;
    }
    result = add_shot(c, name, before);
    if (!result && c->room > room) {
        size_t *at = pv_resize(c->context, c->name_at, (size_t)room, (size_t)c->room, sizeof *at, &result);
        c->name_at = at ? at : c->name_at;
    }
    if (result || c->count == before)
        return result;
    c->name_at[before] = c->text_size;
    memcpy(c->text + c->text_size, name, length);
    c->text_size += length;
    return PAVE_OK;
}

static pave_result list_folder(collection *c, const char *below, int depth);

static pave_result list_entry(collection *c, const char *below, const char *name, int depth)
{
    char inner[PATH_MAX], whole[PATH_MAX];
    struct stat info;
    int length = snprintf(inner, sizeof inner, "%s%s%s", below, *below ? "/" : "", name);
    int all = snprintf(whole, sizeof whole, "%s/%s", c->path, inner);
    if (length >= PATH_MAX || all >= PATH_MAX)
        return pv_unreadable(c->context, c->path, ENAMETOOLONG);
    if (stat(whole, &info))
        return pv_unreadable(c->context, whole, errno);
    if (S_ISDIR(info.st_mode))
        return depth < DEPTH ? list_folder(c, inner, depth + 1) : PAVE_OK;
    return S_ISREG(info.st_mode) ? keep_name(c, inner) : PAVE_OK;
}

static pave_result list_folder(collection *c, const char *below, int depth)
{
    char whole[PATH_MAX];
    pave_result result = pv_progress(c->context, 0);
    if (snprintf(whole, sizeof whole, "%s/%s", c->path, below) >= PATH_MAX)
        return pv_unreadable(c->context, c->path, ENAMETOOLONG);
    DIR *folder = result ? NULL : opendir(whole);
    if (!folder)
        return result ? result : pv_unreadable(c->context, whole, errno);
    for (struct dirent *entry; !result && (entry = readdir(folder));)
        if (entry->d_name[0] != '.')
            result = list_entry(c, below, entry->d_name, depth);
    closedir(folder);
    return result;
}

/* ---- Pictures ---- */

static pave_result open_picture(const collection *c, int64_t source, char *path, size_t room, pv_input *input)
{
    snprintf(path, room, "%s/%s", c->path, name_of(c, source));
    if (!c->zip)
        return pv_input_open(c->context, path, input);
    pave_result result = pv_zip_unpack(c->zip, source, c->file);
    *input = (pv_input){ .context = c->context, .path = path, .file = dup(c->file),
                         .size = c->zip->member[source].size };
    if (!result && input->file < 0)
        result = pv_unreadable(c->context, path, errno);
    return result || input->size ? result : pv_fail(c->context, PAVE_ERR_FORMAT, "%s: is empty", path);
}

static pave_result read_picture(const collection *c, int64_t source, pave_image **out)
{
    char path[2 * PATH_MAX];
    pv_input input = { .file = -1 };
    pv_target target = { .image = out };
    *out = NULL;
    pave_result result = open_picture(c, source, path, sizeof path, &input);
    if (!result)
        result = pv_image_read_input(c->context, &input, &target);
    pv_input_close(&input);
    if (result)
        pave_image_free(out);
    return result;
}

/* Alpha is no channel of a BTF. */
static int32_t colours(const pave_image *image)
{
    return image->channels - (image->alpha >= 0);
}

static double linear(const collection *c, double display)
{
    return c->params->gamma == PAVE_BTF_GAMMA_22 ? pow(display, 2.2) : pv_linear_light(display);
}

static void copy_pixels(const collection *c, const pave_image *image, float *out)
{
    int64_t pixels = (int64_t)image->width * image->height;
    double table[256];
    int bytes = image->type == PAVE_U8, display = image->encoding == PAVE_DISPLAY;
    for (int i = 0; i < 256 && display; i++)
        table[i] = linear(c, i / 255.0);
    for (int64_t i = 0; i < pixels; i++)
        for (int32_t k = 0; k < image->channels; k++) {
            int64_t at = i * image->channels + k;
            if (k == image->alpha)
                continue;
            double value = bytes && display ? table[((const uint8_t *)image->pixels)[at]] : pv_image_value(image, at);
            *out++ = (float)(display && !bytes ? linear(c, value) : value);
        }
}

static pave_result read_shot(void *user, int64_t source, float *out)
{
    const collection *c = user;
    pave_image *image;
    pave_result result = read_picture(c, source, &image);
    if (result)
        return result;
    if (image->width != c->shape.width || image->height != c->shape.height || colours(image) != c->shape.channels)
        result = pv_fail(c->context, PAVE_ERR_FORMAT,
                         "%s: %s has %d x %d px and %d channels, and others %d x %d and %d", c->path,
                         name_of(c, source), (int)image->width, (int)image->height, (int)colours(image),
                         (int)c->shape.width, (int)c->shape.height, (int)c->shape.channels);
    else
        copy_pixels(c, image, out);
    pave_image_free(&image);
    return result;
}

static void name_shot(void *user, int64_t source, char *out, size_t room)
{
    snprintf(out, room, "%s", name_of(user, source));
}

/* All pictures must be like the first. */
static pave_result take_shape(collection *c)
{
    pave_image *first;
    char *to = c->names;
    pave_result result = read_picture(c, c->shots[0].source, &first);
    if (result)
        return result;
    c->shape = (pave_btf_params)PAVE_BTF_PARAMS_INIT;
    c->shape.width = first->width;
    c->shape.height = first->height;
    c->shape.channels = colours(first);
    c->shape.type = first->type == PAVE_U8 || first->type == PAVE_F16 ? PAVE_F16 : PAVE_F32;
    c->shape.names = c->names;
    for (int32_t k = 0; k < first->channels; k++)
        if (k != first->alpha)
            to += sprintf(to, "%s%s", to > c->names ? "," : "", first->names[k]);
    pave_image_free(&first);
    return c->shape.channels ? PAVE_OK : pv_fail(c->context, PAVE_ERR_FORMAT, "%s: its pictures hold nothing but alpha",
                                                 c->path);
}

static pave_result read_collection(collection *c, pave_btf **out)
{
    if (!c->count)
        return pv_fail(c->context, PAVE_ERR_FORMAT,
                       "%s: holds no pictures of a BTF, named by angles like tl030_pl000_tv015_pv060.png", c->path);
    if (c->others)
        pv_note(c->context, PAVE_MESSAGE_INFO, "%s: %lld other files are passed over", c->path, (long long)c->others);
    pv_album album = { .path = c->path, .shots = c->shots, .count = c->count, .read = read_shot, .name = name_shot,
                       .user = c };
    pv_album_sort(&album);
    pave_result result = take_shape(c);
    album.shape = c->shape;
    return result ? result : pv_album_read(c->context, &album, out);
}

static void drop(collection *c)
{
    pv_release(c->shots);
    pv_release(c->text);
    pv_release(c->name_at);
}

pave_result pv_folder_read(pave_context *context, const char *path, const pave_btf_file_params *params,
                           pave_btf **out)
{
    collection c = { .context = context, .path = path, .params = params, .file = -1 };
    pave_result result = list_folder(&c, "", 0);
    if (!result)
        result = read_collection(&c, out);
    drop(&c);
    return result;
}

pave_result pv_zip_read(pave_context *context, const char *path, const pave_btf_file_params *params, pave_btf **out)
{
    pv_zip zip;
    collection c = { .context = context, .path = path, .params = params, .zip = &zip };
    pave_result result = pv_zip_open(context, path, &zip);
    c.file = result ? -1 : pv_scratch(path);
    if (!result && c.file < 0)
        result = pv_fail(context, PAVE_ERR_IO, "%s: no temporary file can be made: %s", path, pv_system_error(errno));
    for (int64_t i = 0; i < zip.count && !result; i++)
        result = add_shot(&c, zip.member[i].name, i);
    if (!result)
        result = read_collection(&c, out);
    if (c.file >= 0)
        close(c.file);
    drop(&c);
    pv_zip_close(&zip);
    return result;
}
