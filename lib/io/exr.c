/* OpenEXR files: what reading and writing share. Only these sources include OpenEXR's headers. */
#include "io/exr.h"

#include "io/exr_call.h"

#include <stdio.h>
#include <string.h>

static _Thread_local pv_exr_call *call_at_work;

pv_exr_call *pv_exr_enter(pv_exr_call *call)
{
    pv_exr_call *outer = call_at_work;
    call_at_work = call;
    return outer;
}

/* Zeroed, so that a chunk which inflates to less than it should shows no old memory. */
static void *allocate(size_t size)
{
    return pv_allocate_zeroed(call_at_work->context, size, 1, &call_at_work->memory);
}

static void keep_text(exr_const_context_t exr, exr_result_t code, const char *text)
{
    (void)exr;
    (void)code;
    pv_exr_call *call = call_at_work;
    if (call)
        snprintf(call->text, sizeof call->text, "%.*s", (int)strcspn(text, "\n"), text);
}

static int64_t read_at(exr_const_context_t exr, void *user, void *buffer, uint64_t size, uint64_t offset,
                       exr_stream_error_func_ptr_t error)
{
    (void)exr;
    (void)error;
    const pv_exr_call *call = user;
    return pv_read_at(call->input->file, (int64_t)offset, buffer, (int64_t)size);
}

static int64_t file_size(exr_const_context_t exr, void *user)
{
    (void)exr;
    return ((const pv_exr_call *)user)->input->size;
}

static int64_t write_at(exr_const_context_t exr, void *user, const void *buffer, uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t error)
{
    (void)exr;
    (void)error;
    return pv_output_at(((pv_exr_call *)user)->output, (int64_t)offset, buffer, size) ? (int64_t)size : -1;
}

exr_result_t pv_exr_start(pv_exr_call *call)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.read_fn = read_at;
    init.size_fn = file_size;
    init.write_fn = write_at;
    init.error_handler_fn = keep_text;
    init.alloc_fn = allocate;
    init.free_fn = pv_release;
    init.user_data = call;
    init.max_tile_width = init.max_tile_height = (int)call->context->limits.max_side;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    return call->output ? exr_start_write(&call->exr, call->path, EXR_WRITE_FILE_DIRECTLY, &init)
                        : exr_start_read(&call->exr, call->path, &init);
}

pave_result pv_exr_failure(pv_exr_call *call, exr_result_t code)
{
    if (call->memory)
        return call->memory;
    const char *reason = call->text[0] ? call->text : exr_get_default_error_message(code);
    return pv_fail(call->context, call->output ? PAVE_ERR_ARGUMENT : PAVE_ERR_FORMAT,
                   call->output ? "%s: OpenEXR does not take this image: %s" : "%s: is a damaged OpenEXR file: %s",
                   call->path, reason);
}

static exr_result_t leave_packed(exr_decode_pipeline_t *pipeline)
{
    (void)pipeline;
    return EXR_ERR_SUCCESS;
}

pave_result pv_exr_decode(pv_exr_call *call, int part, const exr_chunk_info_t *chunk, exr_decode_pipeline_t *pipeline,
                          const uint8_t **out)
{
    int first = !pipeline->channels;
    exr_result_t code = first ? exr_decoding_initialize(call->exr, part, chunk, pipeline)
                              : exr_decoding_update(call->exr, part, chunk, pipeline);
    if (!code && first)
        code = exr_decoding_choose_default_routines(call->exr, part, pipeline);
    pipeline->unpack_and_convert_fn = leave_packed;
    if (!code)
        code = exr_decoding_run(call->exr, part, pipeline);
    *out = pipeline->unpacked_buffer ? pipeline->unpacked_buffer : pipeline->packed_buffer;
    return code || !*out ? pv_exr_failure(call, code ? code : EXR_ERR_CORRUPT_CHUNK) : PAVE_OK;
}

/* A chunk that came out no shorter is kept bare: readers take one of that length for bare, and OpenEXR 3.1 writes one
 * of just that length packed. */
static exr_result_t keep_if_no_shorter(exr_encode_pipeline_t *pipeline)
{
    if (pipeline->compressed_buffer != pipeline->packed_buffer && pipeline->compressed_bytes == pipeline->packed_bytes)
        memcpy(pipeline->compressed_buffer, pipeline->packed_buffer, pipeline->packed_bytes);
    return EXR_ERR_SUCCESS;
}

exr_result_t pv_exr_encode(const pv_exr_call *call, int part, int first, exr_encode_pipeline_t *pipeline)
{
    exr_result_t code = first ? exr_encoding_choose_default_routines(call->exr, part, pipeline) : EXR_ERR_SUCCESS;
    pipeline->yield_until_ready_fn = keep_if_no_shorter;
    return code ? code : exr_encoding_run(call->exr, part, pipeline);
}

void pv_exr_version(char *text, size_t capacity)
{
    int major, minor, patch;
    const char *extra;
    exr_get_library_version(&major, &minor, &patch, &extra);
    snprintf(text, capacity, "%d.%d.%d", major, minor, patch);
}
