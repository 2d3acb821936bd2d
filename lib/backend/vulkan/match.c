/* Matching by a compute shader. */
#include "backend/match.h"
#include "backend/kernel.h"

enum { VALUES, BLOCK, COSTS, BUFFERS, GROUP = 64, SLICE = 1 << 16 };

typedef struct parameters { int32_t first, stride, depth, across, base, count, entries; } parameters;

struct pv_matcher {
    pave_context *context;
    pv_kernel *kernel;
};

void pv_matcher_close(pv_matcher *m)
{
    if (!m)
        return;
    pv_kernel_close(m->kernel);
    pv_release(m);
}

pave_result pv_matcher_open(pave_context *context, const int16_t *values, int64_t count, int32_t most_entries,
                            pv_matcher **out)
{
    pave_result result = PAVE_OK;
    pv_matcher *m = pv_allocate_zeroed(context, 1, sizeof *m, &result);
    *out = NULL;
    if (!m)
        return result;
    pv_kernel_params params = {
        .shader = PV_KERNEL_MATCH, .buffers = BUFFERS, .what = "the exemplars are",
        .bytes = { [VALUES] = 2 * count, [BLOCK] = (int64_t)sizeof(pv_match_entry) * most_entries,
                   [COSTS] = 8 * SLICE },
    };
    m->context = context;
    result = pv_kernel_open(context, &params, &m->kernel);
    if (!result)
        result = pv_kernel_write(m->kernel, VALUES, values, 2 * count);
    if (result)
        pv_matcher_close(m);
    else
        *out = m;
    return result;
}

pave_result pv_matcher_run(pv_matcher *m, const pv_match_entry *entries, int32_t count, const pv_match_places *places,
                           uint64_t *costs)
{
    int32_t all = places->across * places->down;
    parameters p = { places->first, places->stride, places->depth, places->across, 0, 0, count };
    pave_result result = pv_kernel_write(m->kernel, BLOCK, entries, (int64_t)sizeof *entries * count);
    for (; p.base < all && !result; p.base += p.count) {
        p.count = pv_kernel_slice(m->kernel, all - p.base, GROUP, count);
        result = pv_kernel_run(m->kernel, &p, sizeof p, (p.count + GROUP - 1) / GROUP, (double)p.count * count);
        if (!result)
            result = pv_kernel_read(m->kernel, COSTS, costs + p.base, 8 * (int64_t)p.count);
        if (!result)
            result = pv_progress(m->context, 0);
    }
    return result;
}
