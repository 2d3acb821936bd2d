/* Tasks over the context's threads. Which thread runs a task must never matter to what it computes. */
#pragma once

#include "base/context.h"

/* `worker` is 0 .. pv_workers-1 and no two tasks run at once with the same one. A task should take under 20 ms, for
 * that is how often the caller looks whether to stop. */
typedef void pv_task(void *data, int32_t index, int32_t worker);

/* How many workers a run over `tasks` tasks can have: what per-worker storage must allow for. */
int32_t pv_workers(const pave_context *context);

/* Runs task(data, 0 .. tasks-1), reporting progress of from..to of the stage. PAVE_OK, or PAVE_ERR_CANCELLED once no
 * task is running any more. Without threads to be had the calling one does it all. */
pave_result pv_parallel(pave_context *context, int32_t tasks, pv_task *task, void *data, double from, double to);

/* The same over 0 .. count-1 in runs of about so many: items begin .. end-1. */
typedef void pv_run_task(void *data, int32_t begin, int32_t end, int32_t worker);
pave_result pv_parallel_runs(pave_context *context, int32_t count, int32_t run, pv_run_task *task, void *data,
                             double from, double to);

void pv_pool_free(pv_pool *pool);
