/* Search: all differences by a compute shader. They are whole numbers, so what is found is the same. */
#include "tiling/search.h"

#include "backend/match.h"

#ifdef PAVE_HAVE_VULKAN

int pv_vulkan_is_there(pave_context *context)
{
    return pv_matcher_has_gpu(context);
}

static int32_t list_entries(const pv_query *query, pv_match_entry *out)
{
    int32_t count = 0, depth = query->bank->depth;
    for (int32_t i = 0; i < query->width * query->height; i++)
        for (int32_t c = 0; c < depth && query->counts[i]; c++) {
            int32_t x = i % query->width, y = i / query->width;
            out[count++] = (pv_match_entry){ (y * query->bank->stride + x) * depth + c, query->value[i * depth + c] };
        }
    return count;
}

static pave_result open_matcher(pave_context *context, pv_searcher *searcher, const pv_query *query)
{
    const pv_bank *bank = searcher->bank;
    return searcher->matcher ? PAVE_OK
                             : pv_matcher_open(context, bank->values, (int64_t)bank->pixels * bank->depth,
                                               query->most * bank->depth, &searcher->matcher);
}

pave_result pv_vulkan_costs(pave_context *context, pv_searcher *searcher, const pv_query *query,
                            const pv_places *places, int64_t *costs)
{
    int32_t depth = query->bank->depth;
    int32_t step = places->step * depth;
    pv_match_places where = { pv_place_at(query->bank, places, 0, 0) * depth, query->bank->stride * step, step,
                              places->across, places->down };
    pave_result result = open_matcher(context, searcher, query);
    pv_match_entry *entries = NULL;
    if (!result)
        entries = pv_allocate(context, (size_t)query->most * (size_t)depth, sizeof *entries, &result);
    if (!result)
        result = pv_matcher_run(searcher->matcher, entries, list_entries(query, entries), &where, (uint64_t *)costs);
    pv_release(entries);
    return result;
}

void pv_vulkan_close(pv_searcher *searcher)
{
    pv_matcher_close(searcher->matcher);
    searcher->matcher = NULL;
}

#else

int pv_vulkan_is_there(pave_context *context)
{
    (void)context;
    return 0;
}

pave_result pv_vulkan_costs(pave_context *context, pv_searcher *searcher, const pv_query *query,
                            const pv_places *places, int64_t *costs)
{
    (void)searcher, (void)query, (void)places, (void)costs;
    return pv_fail(context, PAVE_ERR_UNSUPPORTED, "this build has no Vulkan to search with");
}

void pv_vulkan_close(pv_searcher *searcher)
{
    (void)searcher;
}

#endif
