/* Memory that counts what it lent and runs out when it is told to: an allocator for contexts. */
#pragma once

#include "test.h"

typedef struct failing {
    int64_t calls, fail_at; /* the number of the request that fails; 0: none */
    int32_t for_good;       /* all after it fail too */
    int64_t blocks;         /* lent and not given back */
} failing;

static inline void *failing_alloc(void *user, size_t size)
{
    failing *f = user;
    f->calls++;
    if (f->calls == f->fail_at || (f->for_good && f->calls > f->fail_at))
        return NULL;
    f->blocks++;
    return malloc(size);
}

static inline void failing_free(void *user, void *memory)
{
    failing *f = user;
    f->blocks -= memory != NULL;
    free(memory);
}

/* A context's params on such memory; one thread, for requests of several come in any order. */
static inline pave_context_params failing_params(failing *f)
{
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    params.alloc = failing_alloc;
    params.free = failing_free;
    params.alloc_user = f;
    params.threads = 1;
    return params;
}
