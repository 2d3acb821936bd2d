/* The context: what all stages share. Allocator, messages, progress and cancel, threads, backend, limits. */
#ifndef PAVE_CONTEXT_H
#define PAVE_CONTEXT_H

#include <pave/base.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pave_context pave_context;

/* Memory. `alloc` returns at least `size` bytes aligned for any type, or NULL. Both may be called from the context's
 * worker threads, and `free` also from whichever thread frees a handle, even after the context is gone. */
typedef void *(*pave_alloc_fn)(void *user, size_t size);
typedef void (*pave_free_fn)(void *user, void *memory);

/* One sentence without a line end, in English, UTF-8. Called on the thread that made the call into the library. */
typedef void (*pave_message_fn)(void *user, int32_t level, const char *text);

enum {
    PAVE_MESSAGE_ERROR = 1,   /* the call is about to return a failure */
    PAVE_MESSAGE_WARNING = 2, /* the call goes on, but not quite as asked (a fall-back, a repair) */
    PAVE_MESSAGE_INFO = 3     /* what was chosen (device, backend) */
};

/* Progress of the call under way: `stage` names what is being done, `done` runs from 0 to 1 over the whole call and
 * never goes back. Called on the calling thread only, a few times to some hundred times a call. A return other than
 * 0 ends the call with PAVE_ERR_CANCELLED. */
typedef int32_t (*pave_progress_fn)(void *user, const char *stage, double done);

/* The engines that compute Voronoi diagrams. They all give the same bytes; see docs/determinism.md. */
enum {
    PAVE_BACKEND_AUTO = 0,           /* the fastest for the job; falls back to the CPU with a message */
    PAVE_BACKEND_CPU = 1,            /* tiles with candidate lists; AVX2 where the processor has it */
    PAVE_BACKEND_CPU_PORTABLE = 2,   /* the same without AVX2 */
    PAVE_BACKEND_CPU_REFERENCE = 3,  /* every site for every pixel: the definition, for tests */
    PAVE_BACKEND_VULKAN_COMPUTE = 4, /* Vulkan compute shaders on any device with 64-bit integers */
    PAVE_BACKEND_VULKAN_RASTER = 5,  /* Vulkan's rasteriser and depth buffer, the paper's own way */
    PAVE_BACKEND_GLES = 6            /* the same with OpenGL ES */
};

/* Upper bounds, checked before anything of the size is allocated. A job beyond them ends in PAVE_ERR_LIMIT. */
typedef struct pave_limits {
    size_t size;
    int64_t max_side;   /* width or height of an image, px; default and greatest 2^20 */
    int64_t max_pixels; /* pixels of an image; default 2^28 */
    int64_t max_bytes;  /* memory held at one time through this context and its handles; default 2^34 */
    int64_t max_stones; /* stones, or sites, of a pavement; default 2^26 */
} pave_limits;

#define PAVE_LIMITS_INIT \
    { sizeof(pave_limits), (int64_t)1 << 20, (int64_t)1 << 28, (int64_t)1 << 34, (int64_t)1 << 26 }

typedef struct pave_context_params {
    size_t size;
    pave_alloc_fn alloc; /* NULL, with free NULL: malloc and free */
    pave_free_fn free;
    void *alloc_user;
    pave_message_fn message; /* NULL: no messages; the last one stays readable all the same */
    void *message_user;
    pave_progress_fn progress; /* NULL: none */
    void *progress_user;
    const pave_limits *limits; /* NULL: defaults; copied */
    int32_t threads;           /* worker threads, the calling one included; 0: one for each processor */
    int32_t backend;           /* PAVE_BACKEND_ */
} pave_context_params;

#define PAVE_CONTEXT_PARAMS_INIT \
    { sizeof(pave_context_params), NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, 0, PAVE_BACKEND_AUTO }

PAVE_API void pave_limits_init(pave_limits *limits, size_t size);
PAVE_API void pave_context_params_init(pave_context_params *params, size_t size);

/* Makes a context. Starts no thread and touches no driver; both happen when a job first needs them. */
PAVE_API pave_result pave_context_create(const pave_context_params *params, pave_context **out);

/* Ends the worker threads, closes the device and frees the context. Handles made through it stay valid. */
PAVE_API void pave_context_free(pave_context **context);

/* The last error's sentence, "" if there was none. Valid until the next call that uses the context. */
PAVE_API const char *pave_context_message(const pave_context *context);

/* Ends the call under way in this context, or else the next one, with PAVE_ERR_CANCELLED, within 100 ms. May be
 * called from any thread and from a signal handler. */
PAVE_API void pave_context_cancel(pave_context *context);

#ifdef __cplusplus
}
#endif

#endif
