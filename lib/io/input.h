/* Input files: read where bytes of them are needed, so that none is ever held as a whole for its size. */
#pragma once

#include "base/context.h"

typedef struct pv_input {
    pave_context *context;
    const char *path; /* for sentences */
    int file;
    int64_t size, changed; /* when it was opened */
    uint8_t *window;       /* what pv_input_look showed last */
    int64_t from, held;
} pv_input;

/* Opens a regular file that is not empty. Closed in any case by pv_input_close. */
pave_result pv_input_open(pave_context *context, const char *path, pv_input *out);
void pv_input_close(pv_input *input);

/* Reads so many bytes at a place, or fails with a sentence. */
pave_result pv_input_read(const pv_input *input, int64_t offset, void *bytes, int64_t size);

/* Shows up to PV_INPUT_LOOK bytes at a place, until the next look; they must lie inside the file. */
enum { PV_INPUT_LOOK = 1 << 16 };
pave_result pv_input_look(pv_input *input, int64_t offset, int64_t size, const uint8_t **out);

/* All of it, to be released by the caller. */
pave_result pv_input_load(const pv_input *input, uint8_t **out);

/* Fails if somebody has written to the file since it was opened. */
pave_result pv_input_unchanged(const pv_input *input);

/* "PATH: cannot be read: REASON" */
pave_result pv_unreadable(pave_context *context, const char *path, int error);

/* pread, going on until all is there: the bytes read, fewer at the end of the file; -1 and errno on failure. */
int64_t pv_read_at(int file, int64_t offset, void *bytes, int64_t size);
