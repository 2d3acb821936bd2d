/* BTFs put together from pictures: the pictures of a view at a time are turned into runs of texels. */
#include "io/spool.h"

#include "io/output.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { SHARE = 8, MOST_DIRECTIONS = 4096 };

static const double degree = 3.14159265358979323846 / 180;

int pv_scratch(const char *path)
{
    const char *places[3] = { path, "/var/tmp/", "/tmp/" };
    int file = -1;
    for (int i = 0; i < 3 && file < 0; i++)
        file = pv_output_scratch(places[i]);
    return file;
}

static pave_result map_scratch(pave_context *context, const char *path, size_t bytes, pave_btf *btf)
{
    int file = pv_scratch(path), error = file < 0 ? errno : posix_fallocate(file, 0, (off_t)bytes);
    void *map = error ? MAP_FAILED : mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (!error && map == MAP_FAILED)
        error = errno;
    if (file >= 0)
        close(file);
    if (error)
        return pv_fail(context, PAVE_ERR_IO, "%s: no temporary file of %zu bytes can be made for its samples: %s", path,
                       bytes, pv_system_error(error));
    btf->samples.map = map;
    btf->samples.map_bytes = bytes;
    pv_btf_place_samples(btf, map);
    return PAVE_OK;
}

pave_result pv_spool(pave_context *context, const char *path, pave_btf *btf)
{
    double bytes = pv_btf_sample_bytes(btf);
    if (bytes > 0x1p46)
        return pv_fail(context, PAVE_ERR_LIMIT, "%s: its samples would take %.0f bytes", path, bytes);
    if (bytes > (double)context->limits.max_bytes / SHARE)
        return map_scratch(context, path, (size_t)bytes, btf);
    pave_result result = pv_btf_allocate_samples(context, btf);
    if (!result)
        memset(btf->samples.block, 0, (size_t)bytes);
    return result;
}

static int compare_angles(const double *a, const double *b)
{
    for (int i = 0; i < 2; i++)
        if (a[i] != b[i])
            return a[i] < b[i] ? -1 : 1;
    return 0;
}

static int by_angles(const void *a, const void *b)
{
    return compare_angles(a, b);
}

static int by_view_and_light(const void *a, const void *b)
{
    const pv_shot *p = a, *q = b;
    int order = compare_angles(p->view, q->view);
    return order ? order : compare_angles(p->light, q->light);
}

/* Azimuths from 0 on, to a millionth of a degree, so that equal directions are the same numbers. */
static void tidy(double angle[2])
{
    angle[0] = floor(angle[0] * 1e6 + 0.5) / 1e6;
    angle[1] = floor(fmod(fmod(angle[1], 360) + 360, 360) * 1e6 + 0.5) / 1e6;
    angle[1] = angle[1] >= 360 ? 0 : angle[1];
}

/* Distinct directions, in order. */
typedef struct set {
    double (*angle)[2];
    int64_t count;
    pave_direction *direction;
} set;

static pave_result collect(pave_context *context, const pv_album *album, int lights, set *out)
{
    pave_result result = PAVE_OK;
    out->angle = pv_allocate(context, (size_t)album->count, sizeof *out->angle, &result);
    for (int64_t i = 0; i < album->count && !result; i++)
        memcpy(out->angle[i], lights ? album->shots[i].light : album->shots[i].view, sizeof *out->angle);
    if (result)
        return result;
    qsort(out->angle, (size_t)album->count, sizeof *out->angle, by_angles);
    for (int64_t i = 0; i < album->count; i++)
        if (!out->count || compare_angles(out->angle[out->count - 1], out->angle[i]))
            memmove(out->angle[out->count++], out->angle[i], sizeof *out->angle);
    if (out->count > MOST_DIRECTIONS)
        return pv_fail(context, PAVE_ERR_LIMIT, "%s: shows %lld %s, and %d can be", album->path, (long long)out->count,
                       lights ? "lights" : "views", MOST_DIRECTIONS);
    out->direction = pv_allocate(context, (size_t)out->count, sizeof *out->direction, &result);
    for (int64_t i = 0; i < out->count && !result; i++) {
        double phi = out->angle[i][1];
        out->direction[i] = (pave_direction){ (float)(out->angle[i][0] * degree),
                                              (float)((phi >= 180 ? phi - 360 : phi) * degree) };
    }
    return result;
}

static void drop_set(set *s)
{
    pv_release(s->angle);
    pv_release(s->direction);
}

static int64_t place(const set *s, const double *angle)
{
    const double(*found)[2] = bsearch(angle, s->angle, (size_t)s->count, sizeof *s->angle, by_angles);
    return found - s->angle;
}

static pave_result refuse_twins(pave_context *context, const pv_album *album)
{
    char a[256], b[256];
    for (int64_t i = 1; i < album->count; i++)
        if (!by_view_and_light(&album->shots[i - 1], &album->shots[i])) {
            album->name(album->user, album->shots[i - 1].source, a, sizeof a);
            album->name(album->user, album->shots[i].source, b, sizeof b);
            return pv_fail(context, PAVE_ERR_FORMAT, "%s: two pictures have the same light and view: %s and %s",
                           album->path, a, b);
        }
    return PAVE_OK;
}

static pave_result mark_missing(pave_context *context, const pv_album *album, const set *lights, pave_btf *btf)
{
    int64_t pairs = (int64_t)btf->views.count * btf->lights.count, view = -1;
    pave_result result = PAVE_OK;
    if (album->count == pairs)
        return PAVE_OK;
    btf->missing = pv_allocate(context, (size_t)pairs, 1, &result);
    if (result)
        return result;
    memset(btf->missing, 1, (size_t)pairs);
    for (int64_t i = 0; i < album->count; i++) {
        const pv_shot *shot = &album->shots[i];
        view += !i || compare_angles(shot->view, shot[-1].view) != 0;
        btf->missing[view * btf->lights.count + place(lights, shot->light)] = 0;
    }
    pv_note(context, PAVE_MESSAGE_WARNING, "%s: %lld of %lld pairs of view and light have no picture", album->path,
            (long long)(pairs - album->count), (long long)pairs);
    return PAVE_OK;
}

/* Pictures of one view, all of their lights or as many as there is room for. */
typedef struct batch {
    const pv_album *album;
    pave_btf *btf;
    const set *lights;
    float *pictures; /* [picture][y][x][channel] */
    float *run;      /* what a texel has of them */
    int64_t room;
} batch;

static pave_result check_numbers(pave_context *context, const pv_album *album, int64_t source, const float *values,
                                 int64_t count)
{
    char name[256];
    for (int64_t i = 0; i < count; i++)
        if (!isfinite(values[i])) {
            album->name(album->user, source, name, sizeof name);
            return pv_fail(context, PAVE_ERR_FORMAT, "%s: %s holds a value that is not a number", album->path, name);
        }
    return PAVE_OK;
}

/* Lights that follow each other are written as one run of a texel. */
static void turn(const batch *b, int64_t first, int64_t count, int64_t view)
{
    int32_t channels = b->btf->channels;
    int64_t texels = pv_btf_texels(b->btf), lights = b->btf->lights.count;
    for (int64_t i = 0, end; i < count; i = end) {
        int64_t light = place(b->lights, b->album->shots[first + i].light);
        for (end = i + 1; end < count; end++)
            if (place(b->lights, b->album->shots[first + end].light) != light + end - i)
                break;
        for (int64_t t = 0; t < texels; t++) {
            for (int64_t k = i; k < end; k++)
                memcpy(b->run + (k - i) * channels, b->pictures + (k * texels + t) * channels,
                       (size_t)channels * sizeof *b->run);
            pv_btf_put(b->btf, t, (view * lights + light) * channels, (end - i) * channels, b->run);
        }
    }
}

static pave_result fill(pave_context *context, const batch *b)
{
    const pv_album *album = b->album;
    int64_t size = pv_btf_texels(b->btf) * b->btf->channels, view = 0;
    pave_result result = PAVE_OK;
    for (int64_t first = 0, count; first < album->count && !result; first += count) {
        const pv_shot *shots = album->shots + first;
        view += first && compare_angles(shots->view, shots[-1].view) != 0;
        for (count = 0; count < b->room && first + count < album->count && !result; count++) {
            if (compare_angles(shots->view, shots[count].view))
                break;
            float *to = b->pictures + count * size;
            pv_call call = pv_call_begin(context, "read", (double)(first + count) / (double)album->count,
                                         (double)(first + count + 1) / (double)album->count);
            result = album->read(album->user, shots[count].source, to);
            pv_call_end(context, call);
            if (!result)
                result = check_numbers(context, album, shots[count].source, to, size);
        }
        if (!result)
            turn(b, first, count, view);
    }
    return result;
}

static pave_result put_together(pave_context *context, const pv_album *album, const set *lights, pave_btf *btf)
{
    batch b = { .album = album, .btf = btf, .lights = lights };
    pave_result result = pv_spool(context, album->path, btf);
    double picture = (double)pv_btf_texels(btf) * btf->channels * sizeof(float);
    double fitting = (double)context->limits.max_bytes / SHARE / picture;
    b.room = fitting < 1 ? 1 : fitting < (double)btf->lights.count ? (int64_t)fitting : btf->lights.count;
    if (!result)
        b.pictures = pv_allocate(context, (size_t)b.room, (size_t)picture, &result);
    if (!result)
        b.run = pv_allocate(context, (size_t)b.room, (size_t)btf->channels * sizeof *b.run, &result);
    if (!result)
        result = fill(context, &b);
    pv_release(b.pictures);
    pv_release(b.run);
    return result;
}

void pv_album_sort(pv_album *album)
{
    for (int64_t i = 0; i < album->count; i++) {
        tidy(album->shots[i].view);
        tidy(album->shots[i].light);
    }
    qsort(album->shots, (size_t)album->count, sizeof *album->shots, by_view_and_light);
}

pave_result pv_album_read(pave_context *context, pv_album *album, pave_btf **out)
{
    set views = { NULL, 0, NULL }, lights = { NULL, 0, NULL };
    pv_album_sort(album);
    pave_result result = refuse_twins(context, album);
    if (!result)
        result = collect(context, album, 0, &views);
    if (!result)
        result = collect(context, album, 1, &lights);
    pave_btf_params shape = album->shape;
    shape.views = (int32_t)views.count;
    shape.lights = (int32_t)lights.count;
    shape.view_directions = views.direction;
    shape.light_directions = lights.direction;
    if (!result)
        result = pv_btf_new(context, &shape, out);
    if (!result)
        result = mark_missing(context, album, &lights, *out);
    if (!result)
        result = put_together(context, album, &lights, *out);
    drop_set(&views);
    drop_set(&lights);
    if (result)
        pave_btf_free(out);
    return result;
}
