/* Memory that is counted: every block of a context and of its handles comes from one heap, which outlives them all. */
#pragma once

#include <pave/context.h>

typedef struct pv_heap pv_heap;

pv_heap *pv_heap_create(const pave_context_params *params, int64_t max_bytes);
pv_heap *pv_heap_retain(pv_heap *heap);
void pv_heap_release(pv_heap *heap);

/* A block of count * size bytes, aligned to 64; from pv_allocate_zeroed it is cleared. On failure a message, and NULL
 * with *result set to PAVE_ERR_MEMORY or PAVE_ERR_LIMIT. A count of 0 gives a block that can be freed. */
void *pv_allocate(pave_context *context, size_t count, size_t size, pave_result *result);
void *pv_allocate_zeroed(pave_context *context, size_t count, size_t size, pave_result *result);

/* Frees a block of any heap. NULL is allowed. */
void pv_release(void *block);

/* A block of a new size with the same contents; the old one stays on failure. */
void *pv_resize(pave_context *context, void *block, size_t old_count, size_t count, size_t size, pave_result *result);
