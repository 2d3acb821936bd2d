/* The context from inside: failing, noting, progress. */
#pragma once

#include "base/memory.h"

#include <stdatomic.h>

typedef struct pv_pool pv_pool;

struct pave_context {
    pv_heap *heap;
    pave_message_fn message;
    void *message_user;
    pave_progress_fn progress;
    void *progress_user;
    pave_limits limits;
    int32_t threads;
    int32_t backend;
    pv_pool *pool;
    atomic_int cancelled;
    const char *stage;
    double stage_from, stage_to; /* the share of the whole call that the stage under way covers */
    double done, reported, reported_at;
    int drafts; /* files are parts of a folder that is made durable as a whole */
    char text[1024];
};

/* Keeps the sentence, sends it to the callback and returns `result`:  return pv_fail(context, PAVE_ERR_IO, ...). */
pave_result pv_fail(pave_context *context, pave_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* A context of one thread, for a task that is made of tasks itself: of the same heap and limits, without callbacks. It
 * is the caller's, and needs no end. What fails in it has to be said again by the one that it was made of. */
void pv_context_alone(const pave_context *context, pave_context *out);

/* Sends a warning or a piece of information. */
void pv_note(pave_context *context, int32_t level, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* A public call begins: progress starts anew. Calls may nest (pave_lay calls the stages): then the stage inside takes
 * the share from..to of the call around it, and `pv_call_end` gives back what was there before. */
typedef struct pv_call {
    const char *stage;
    double from, to;
} pv_call;

pv_call pv_call_begin(pave_context *context, const char *stage, double from, double to);
void pv_call_end(pave_context *context, pv_call outer);

/* Reports how much of the stage is done, 0..1. PAVE_ERR_CANCELLED, with its message, if the job is to end. */
pave_result pv_progress(pave_context *context, double done);

/* Seconds on a clock that only goes forward. */
double pv_seconds(void);
