/* The context: set up, messages, progress and cancel. */
#include "base/context.h"

#include "base/parallel.h"
#include "base/params.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const pave_limits default_limits = PAVE_LIMITS_INIT;
static const pave_context_params default_params = PAVE_CONTEXT_PARAMS_INIT;

static const pv_param limit_rows[] = {
    PV_LONG(pave_limits, max_side, "px", 1, 1 << 20, "greatest width or height of an image"),
    PV_LONG(pave_limits, max_pixels, "px", 1, 1ll << 40, "most pixels of an image"),
    PV_LONG(pave_limits, max_bytes, "bytes", 1 << 20, 1ll << 47, "most memory held at one time"),
    PV_LONG(pave_limits, max_stones, "", 1, 1ll << 31, "most stones of a pavement"),
};

static const pv_param context_rows[] = {
    PV_INTEGER(pave_context_params, threads, "", 0, 1024, "threads to work with; 0: one for each processor"),
    PV_CHOICE(pave_context_params, backend, "auto|cpu|cpu-portable|cpu-reference|vulkan-compute|vulkan-raster|gles",
              "engine for the Voronoi diagram; all give the same bytes"),
};

const pv_table pv_limits_table = PV_TABLE("limits", default_limits, limit_rows);
const pv_table pv_context_table = PV_TABLE("context", default_params, context_rows);

void pave_limits_init(pave_limits *limits, size_t size)
{
    pv_params_init(&pv_limits_table, limits, size);
}

void pave_context_params_init(pave_context_params *params, size_t size)
{
    pv_params_init(&pv_context_table, params, size);
}

static int32_t processors(void)
{
    long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n < 1 ? 1 : n > 1024 ? 1024 : (int32_t)n;
}

/* Before there is a context its messages go straight to the caller's callback. */
static void set_up_messages(pave_context *context, const pave_context_params *params)
{
    memset(context, 0, sizeof *context);
    context->message = params->message;
    context->message_user = params->message_user;
}

pave_result pave_context_create(const pave_context_params *given, pave_context **out)
{
    if (!out)
        return PAVE_ERR_ARGUMENT;
    *out = NULL;
    pave_context early;
    set_up_messages(&early, &default_params);
    if (given && given->size >= sizeof *given)
        set_up_messages(&early, given);

    pave_context_params params;
    pave_limits limits;
    pave_result result = pv_params_read(&early, &pv_context_table, given, &params);
    if (!result)
        result = pv_params_read(&early, &pv_limits_table, params.limits, &limits);
    if (!result && !params.alloc != !params.free)
        result = pv_fail(&early, PAVE_ERR_ARGUMENT, "alloc and free must be given together");
    if (result)
        return result;

    pv_heap *heap = pv_heap_create(&params, limits.max_bytes);
    if (!heap)
        return pv_fail(&early, PAVE_ERR_MEMORY, "out of memory for a context");
    early.heap = heap;
    early.limits = limits;
    pave_context *context = pv_allocate(&early, 1, sizeof *context, &result);
    if (context) {
        *context = early;
        context->progress = params.progress;
        context->progress_user = params.progress_user;
        context->threads = params.threads ? params.threads : processors();
        context->backend = params.backend;
        context->stage = "";
        context->stage_to = 1;
        atomic_init(&context->cancelled, 0);
        *out = context;
    } else {
        pv_heap_release(heap);
    }
    return result;
}

void pv_context_alone(const pave_context *context, pave_context *out)
{
    memset(out, 0, sizeof *out);
    out->heap = context->heap;
    out->limits = context->limits;
    out->threads = 1;
    out->stage = "";
    out->stage_to = 1;
}

void pave_context_free(pave_context **context)
{
    if (!context || !*context)
        return;
    pv_heap *heap = (*context)->heap;
    pv_pool_free((*context)->pool);
    pv_release(*context);
    pv_heap_release(heap);
    *context = NULL;
}

const char *pave_context_message(const pave_context *context)
{
    return context ? context->text : "";
}

void pave_context_cancel(pave_context *context)
{
    if (context)
        atomic_store(&context->cancelled, 1);
}

pave_result pv_fail(pave_context *context, pave_result result, const char *format, ...)
{
    int before = errno;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(context->text, sizeof context->text, format, arguments);
    va_end(arguments);
    if (context->message)
        context->message(context->message_user, PAVE_MESSAGE_ERROR, context->text);
    errno = before;
    return result;
}

void pv_note(pave_context *context, int32_t level, const char *format, ...)
{
    if (!context->message)
        return;
    int before = errno;
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    context->message(context->message_user, level, text);
    errno = before;
}

pv_call pv_call_begin(pave_context *context, const char *stage, double from, double to)
{
    pv_call outer = { context->stage, context->stage_from, context->stage_to };
    double span = outer.to - outer.from;
    if (!*outer.stage)
        context->done = context->reported = context->reported_at = 0;
    context->stage = stage;
    context->stage_from = outer.from + span * from;
    context->stage_to = outer.from + span * to;
    return outer;
}

void pv_call_end(pave_context *context, pv_call outer)
{
    context->stage = outer.stage;
    context->stage_from = outer.from;
    context->stage_to = outer.to;
}

/* Every half per cent, every 30 ms, and the end. */
static int worth_reporting(pave_context *context)
{
    double now = pv_seconds();
    if (context->done < context->reported + 0.005 && now < context->reported_at + 0.03 && context->done < 1)
        return 0;
    context->reported = context->done;
    context->reported_at = now;
    return 1;
}

pave_result pv_progress(pave_context *context, double done)
{
    double now = context->stage_from + (context->stage_to - context->stage_from) * done;
    if (now > context->done)
        context->done = now < 1 ? now : 1;
    int stop = 0;
    if (context->progress && worth_reporting(context))
        stop = context->progress(context->progress_user, context->stage, context->done);
    if (atomic_exchange(&context->cancelled, 0) || stop)
        return pv_fail(context, PAVE_ERR_CANCELLED, "cancelled");
    return PAVE_OK;
}

double pv_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
