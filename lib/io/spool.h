/* Room for the samples of a BTF that is put together from pictures. */
#pragma once

#include "btf/btf.h"

/* Zeroed room: in memory if it takes no more than an eighth of max_bytes, else in a mapped file without a name, beside
 * `path` or where temporary files go. Its blocks are taken at once, so that a full disk is met here and not later. */
pave_result pv_spool(pave_context *context, const char *path, pave_btf *btf);

/* A file without a name beside `path`, or where temporary files go; -1 and errno on failure. */
int pv_scratch(const char *path);

/* One picture of a BTF: inclination and azimuth of the light and of the view, degrees. */
typedef struct pv_shot {
    double light[2], view[2];
    int64_t source; /* the caller's: which picture */
} pv_shot;

/* Pictures from which a BTF is put together. `shape` is what all have, without directions. */
typedef struct pv_album {
    const char *path;
    pave_btf_params shape;
    pv_shot *shots;
    int64_t count;
    /* A picture as [y][x][channel]. */
    pave_result (*read)(void *user, int64_t source, float *out);
    /* How to call a picture in a sentence. */
    void (*name)(void *user, int64_t source, char *out, size_t room);
    void *user;
} pv_album;

/* By view and light, by inclination and azimuth. */
void pv_album_sort(pv_album *album);

/* Directions are put in order; pairs without a picture are noted and become missing; two
 * pictures of one pair are refused. The shots
 * are sorted. */
pave_result pv_album_read(pave_context *context, pv_album *album, pave_btf **out);
