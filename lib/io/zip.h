/* Zip archives, as far as sets of pictures need them: stored and deflated members, also of more than 4 GiB. */
#pragma once

#include "io/input.h"

typedef struct pv_zip_member {
    char *name; /* as it stands in the archive */
    int64_t at; /* of its local header */
    int64_t packed, size;
    uint32_t check;
    int method;
} pv_zip_member;

typedef struct pv_zip {
    pv_input input;
    uint8_t *directory; /* the central directory, in which the names are */
    pv_zip_member *member;
    int64_t count;
} pv_zip;

/* Reads the directory. Closed in any case by pv_zip_close. */
pave_result pv_zip_open(pave_context *context, const char *path, pv_zip *out);
void pv_zip_close(pv_zip *zip);

/* Unpacks a member into a file, from its beginning on; what it unpacks to is held against its size and check sum. */
pave_result pv_zip_unpack(const pv_zip *zip, int64_t index, int file);
