/* libpave: versions, results and the rules that hold for every header.
 *
 * Names     pave_noun_verb, types pave_noun, constants PAVE_.
 * Shape     pave_result pave_X_create(context, inputs..., params, pave_X **out). On failure *out is NULL.
 * Handles   opaque, immutable once made, own their data, may outlive their inputs and the context, and may be read
 *           from any thread. pave_X_free(&x) frees and writes NULL; freeing NULL does nothing.
 * Params    begin with `size_t size`. NULL means defaults. Start from PAVE_X_PARAMS_INIT, or from
 *           pave_X_params_init(&p, sizeof p) where an initialiser is no use (C++, other languages). Fields are only
 *           ever added at the end: a smaller struct gets defaults for the rest, a larger one must be zero there.
 * Data out  flat arrays that stay valid until their handle is freed.
 * Threads   one context is used by one thread at a time. Handles belong to no thread.
 */
#ifndef PAVE_BASE_H
#define PAVE_BASE_H

#include <stddef.h>
#include <stdint.h>

#ifdef PAVE_BUILDING
#define PAVE_API __attribute__((visibility("default")))
#else
#define PAVE_API
#endif

#define PAVE_VERSION_MAJOR 0
#define PAVE_VERSION_MINOR 1
#define PAVE_VERSION_PATCH 0
#define PAVE_VERSION_STRING "0.1.0"

#ifdef __cplusplus
extern "C" {
#endif

/* What a call returns: PAVE_OK or one of the negative codes below. The values never change. The sentence with the
 * details goes to the context's message callback and stays readable through pave_context_message. */
typedef int32_t pave_result;

enum {
    PAVE_OK = 0,
    PAVE_ERR_ARGUMENT = -1,    /* an argument or parameter is missing, not a number or out of its range */
    PAVE_ERR_MEMORY = -2,      /* the allocator returned NULL */
    PAVE_ERR_LIMIT = -3,       /* the job would exceed the context's pave_limits */
    PAVE_ERR_TOO_NEW = -4,     /* a params struct sets fields that this library does not know */
    PAVE_ERR_IO = -5,          /* a file cannot be opened, read or written; the disk is full */
    PAVE_ERR_FORMAT = -6,      /* a file is damaged or is not what it says it is */
    PAVE_ERR_UNSUPPORTED = -7, /* a legal request that this build or this machine cannot serve */
    PAVE_ERR_DEVICE = -8,      /* the graphics device is missing, lost or out of memory */
    PAVE_ERR_CANCELLED = -9,   /* the progress callback or pave_context_cancel ended the call */
    PAVE_ERR_INTERNAL = -10    /* a fault of the library itself; please report it */
};

/* The name of a result, "PAVE_ERR_LIMIT"; "unknown result" for any other number. Never NULL. Any thread. */
PAVE_API const char *pave_result_name(pave_result result);

/* The version of the library that is running, "0.1.0". Compare with PAVE_VERSION_STRING. Any thread. */
PAVE_API const char *pave_version(void);

#ifdef __cplusplus
}
#endif

#endif
