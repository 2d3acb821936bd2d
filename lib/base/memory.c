/* Counted memory: a 64-byte header before each block says its heap and its size. */
#include "base/memory.h"

#include "base/context.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

struct pv_heap {
    pave_alloc_fn alloc;
    pave_free_fn free;
    void *user;
    int64_t max_bytes;
    atomic_llong held;
    atomic_int references;
};

typedef struct block_header {
    pv_heap *heap;
    void *raw;
    int64_t bytes;
} block_header;

enum { ALIGNMENT = 64, HUGE_PAGE = 2 << 20, WORTH_HUGE_PAGES = 4 * HUGE_PAGE };

/* Large blocks are walked with long strides, where a page for every 4 KiB costs more than what lies in them. */
static void *plain_alloc(void *user, size_t size)
{
    (void)user;
    void *block = malloc(size);
#ifdef MADV_HUGEPAGE
    uintptr_t from = ((uintptr_t)block + HUGE_PAGE - 1) & ~(uintptr_t)(HUGE_PAGE - 1);
    uintptr_t to = ((uintptr_t)block + size) & ~(uintptr_t)(HUGE_PAGE - 1);
    if (block && size >= WORTH_HUGE_PAGES && to > from)
        madvise((void *)from, to - from, MADV_HUGEPAGE); /* a hint, no more */
#endif
    return block;
}

static void plain_free(void *user, void *memory)
{
    (void)user;
    free(memory);
}

pv_heap *pv_heap_create(const pave_context_params *params, int64_t max_bytes)
{
    pave_alloc_fn alloc = params->alloc ? params->alloc : plain_alloc;
    pv_heap *heap = alloc(params->alloc_user, sizeof *heap);
    if (!heap)
        return NULL;
    heap->alloc = alloc;
    heap->free = params->free ? params->free : plain_free;
    heap->user = params->alloc_user;
    heap->max_bytes = max_bytes;
    atomic_init(&heap->held, 0);
    atomic_init(&heap->references, 1);
    return heap;
}

pv_heap *pv_heap_retain(pv_heap *heap)
{
    atomic_fetch_add(&heap->references, 1);
    return heap;
}

void pv_heap_release(pv_heap *heap)
{
    if (atomic_fetch_sub(&heap->references, 1) == 1)
        heap->free(heap->user, heap);
}

static void *take(pv_heap *heap, size_t bytes, pave_result *result)
{
    size_t whole = bytes + 2 * ALIGNMENT;
    if (atomic_fetch_add(&heap->held, (long long)whole) + (int64_t)whole > heap->max_bytes) {
        atomic_fetch_sub(&heap->held, (long long)whole);
        *result = PAVE_ERR_LIMIT;
        return NULL;
    }
    char *raw = heap->alloc(heap->user, whole);
    if (!raw) {
        atomic_fetch_sub(&heap->held, (long long)whole);
        *result = PAVE_ERR_MEMORY;
        return NULL;
    }
    char *block = raw + 2 * ALIGNMENT - ((uintptr_t)raw & (ALIGNMENT - 1));
    block_header *header = (block_header *)(void *)(block - ALIGNMENT);
    header->heap = pv_heap_retain(heap);
    header->raw = raw;
    header->bytes = (int64_t)whole;
    return block;
}

void *pv_allocate(pave_context *context, size_t count, size_t size, pave_result *result)
{
    pave_result failure = PAVE_ERR_LIMIT;
    size_t bytes;
    void *block = NULL;
    if (!__builtin_mul_overflow(count, size, &bytes) && bytes < (size_t)1 << 48)
        block = take(context->heap, bytes, &failure);
    if (block)
        return block;
    if (failure == PAVE_ERR_LIMIT)
        *result = pv_fail(context, failure, "the job needs more memory than the limit of %lld bytes (max_bytes)",
                          (long long)context->limits.max_bytes);
    else
        *result = pv_fail(context, failure, "out of memory: no %zu bytes to be had", bytes);
    return NULL;
}

void *pv_allocate_zeroed(pave_context *context, size_t count, size_t size, pave_result *result)
{
    void *block = pv_allocate(context, count, size, result);
    if (block)
        memset(block, 0, count * size);
    return block;
}

void pv_release(void *block)
{
    if (!block)
        return;
    block_header *header = (block_header *)(void *)((char *)block - ALIGNMENT);
    pv_heap *heap = header->heap;
    atomic_fetch_sub(&heap->held, (long long)header->bytes);
    heap->free(heap->user, header->raw);
    pv_heap_release(heap);
}

void *pv_resize(pave_context *context, void *block, size_t old_count, size_t count, size_t size, pave_result *result)
{
    void *grown = pv_allocate(context, count, size, result);
    if (!grown)
        return NULL;
    if (block)
        memcpy(grown, block, (old_count < count ? old_count : count) * size);
    pv_release(block);
    return grown;
}
