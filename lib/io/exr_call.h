/* What reading and writing OpenEXR files share: a call under way. */
#pragma once

#include "io/input.h"
#include "io/output.h"

#include <OpenEXR/openexr.h>

/* OpenEXR's allocator has no user pointer, so the call at work in a thread is kept apart. */
typedef struct pv_exr_call {
    pave_context *context;
    const char *path;
    exr_context_t exr;
    const pv_input *input; /* when it is read */
    pv_output *output;     /* when it is written */
    pave_result memory;    /* what became of the last allocation */
    char text[256];        /* OpenEXR's last sentence */
} pv_exr_call;

/* Makes a call the one at work, and returns the one before: a callback may have called in here. */
pv_exr_call *pv_exr_enter(pv_exr_call *call);

/* Opens what the call is about, which is the one at work: its output if there is one, else its input. */
exr_result_t pv_exr_start(pv_exr_call *call);

/* The bytes of a chunk, uncompressed: rows, and in each channel after channel as the file orders them. The pipeline
 * is the caller's, one for each part. */
pave_result pv_exr_decode(pv_exr_call *call, int part, const exr_chunk_info_t *chunk, exr_decode_pipeline_t *pipeline,
                          const uint8_t **out);

/* Packs and writes a chunk; `first` for the first of a part. */
exr_result_t pv_exr_encode(const pv_exr_call *call, int part, int first, exr_encode_pipeline_t *pipeline);

/* The sentence for a failure of OpenEXR's. */
pave_result pv_exr_failure(pv_exr_call *call, exr_result_t code);
