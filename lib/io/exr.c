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

exr_context_initializer_t pv_exr_initializer(pv_exr_call *call)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_text;
    init.alloc_fn = allocate;
    init.free_fn = pv_release;
    init.user_data = call;
    init.max_tile_width = init.max_tile_height = (int)call->context->limits.max_side;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    return init;
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

void pv_exr_version(char *text, size_t capacity)
{
    int major, minor, patch;
    const char *extra;
    exr_get_library_version(&major, &minor, &patch, &extra);
    snprintf(text, capacity, "%d.%d.%d", major, minor, patch);
}
