/* A pavement by many processes: a plan of its windows, each laid by itself, and their merge. */
#include "stream.h"

#include "base/params.h"

#include <pave/pave.h>

#include <errno.h>
#include <stdlib.h>
#include <unistd.h>

extern const pv_table pv_stream_table; /* stream.c */

pave_result pave_plan(pave_context *context, const char *drawing, const pave_lay_params *given,
                      const pave_stream_params *stream_given, const char *manifest, int32_t *windows)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!drawing || !manifest || !windows)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_plan: no drawing or no place for the plan");
    int before = errno;
    pave_stream_params params;
    pave_result result = pv_params_read(context, &pv_stream_table, stream_given, &params);
    pv_stream *s = result ? NULL : pv_stream_begin(context, &result);
    if (!s)
        return result;
    pv_call call = pv_call_begin(context, "plan", 0, 1);
    result = pv_stream_plan(s, drawing, given, params.memory, manifest, 1);
    pv_call_end(context, call);
    *windows = pv_stream_windows(s);
    char *path = result ? NULL : realpath(drawing, NULL);
    s->plan.drawing = path;
    if (!result)
        result = pv_manifest_write(context, &s->plan, manifest);
    free(path);
    s->plan.drawing = NULL;
    pv_stream_end(s);
    errno = before;
    return result;
}

static pave_result lay_shard(pv_stream *s, const char *manifest, int32_t shard, const char *output)
{
    char path[PV_PATH + PV_PART];
    uint64_t hash = 0;
    pave_result result = pv_manifest_read(s->context, manifest, &s->plan);
    if (result)
        return result;
    if (shard < 0 || shard >= pv_stream_windows(s))
        return pv_fail(s->context, PAVE_ERR_ARGUMENT, "shard is %d, but the plan has shards 0 .. %d", (int)shard,
                       (int)(pv_stream_windows(s) - 1));
    if (!output) {
        result = pv_stream_set_folder(s, NULL, manifest);
        if (!result)
            result = pv_stream_make_folder(s);
        pv_stream_part(s, shard, path);
    }
    if (!result)
        result = pv_stream_read(s, s->plan.drawing, pv_stream_room(s, output ? output : path), 0.1, &hash);
    if (!result && (hash != s->plan.hash || s->drawing.width != s->plan.width ||
                    s->drawing.height != s->plan.height))
        result = pv_fail(s->context, PAVE_ERR_FORMAT, "%s: is not the drawing that %s was planned for",
                         s->plan.drawing, manifest);
    pv_call call = pv_call_begin(s->context, "lay", 0.1, 1);
    if (!result)
        result = pv_stream_lay(s, shard, output ? output : path);
    pv_call_end(s->context, call);
    return result;
}

pave_result pave_lay_shard(pave_context *context, const char *manifest, int32_t shard, const char *output)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!manifest)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_lay_shard: no plan");
    int before = errno;
    pave_result result = PAVE_OK;
    pv_stream *s = pv_stream_begin(context, &result);
    if (!s)
        return result;
    pv_call call = pv_call_begin(context, "lay", 0, 1);
    result = lay_shard(s, manifest, shard, output);
    pv_call_end(context, call);
    pv_stream_end(s);
    errno = before;
    return result;
}

/* All parts are there; else the sentence says which is not. */
static pave_result find_parts(pv_stream *s)
{
    char path[PV_PATH + PV_PART];
    for (int32_t k = 0; k < pv_stream_windows(s); k++) {
        pv_stream_part(s, k, path);
        if (access(path, F_OK))
            return pv_fail(s->context, PAVE_ERR_FORMAT, "%s: is not there: lay shard %d first", path, (int)k);
    }
    return PAVE_OK;
}

pave_result pave_plan_merge(pave_context *context, const char *manifest, const char *const *outputs, int32_t count)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!manifest || !outputs || count < 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_plan_merge: no plan or no outputs");
    int before = errno;
    pave_result result = PAVE_OK;
    pv_stream *s = pv_stream_begin(context, &result);
    if (!s)
        return result;
    pv_call call = pv_call_begin(context, "merge", 0, 1);
    result = pv_manifest_read(context, manifest, &s->plan);
    if (!result)
        result = pv_stream_set_folder(s, NULL, manifest);
    if (!result)
        result = find_parts(s);
    if (!result)
        result = pv_stream_merge(s, outputs, count);
    pv_call_end(context, call);
    pv_stream_end(s);
    errno = before;
    return result;
}
