/* Piles of stones in memory. */
#include "io/pile.h"

#include <math.h>

typedef struct memory_pile {
    int32_t at, part;
    int32_t xy[];
} memory_pile;

static pave_result memory_next(pave_context *context, pv_pile *pile, pv_stone *out)
{
    (void)context;
    memory_pile *memory = pile->source;
    const pave_stones *stones = &pile->head;
    int32_t at = memory->at;
    *out = (pv_stone){ .xy = memory->xy };
    if (at == stones->count)
        return PAVE_OK;
    int64_t first = stones->starts[at];
    memory->part = at && stones->sites[at - 1] == stones->sites[at] ? memory->part + 1 : 0;
    out->number = stones->sites[at];
    out->part = memory->part;
    out->colour = stones->colours[at];
    out->rgb = stones->rgb ? stones->rgb + 3 * (int64_t)at : NULL;
    out->corners = (int32_t)(stones->starts[at + 1] - first);
    for (int32_t i = 0; i < 2 * out->corners; i++)
        memory->xy[i] = (int32_t)lround(stones->vertices[2 * first + i] * 1000);
    memory->at++;
    return PAVE_OK;
}

static void memory_rewind(pv_pile *pile)
{
    ((memory_pile *)pile->source)->at = 0;
}

static void memory_close(pv_pile *pile)
{
    pv_release(pile->source);
}

pave_result pv_pile_of(pave_context *context, const pave_stones *stones, pv_pile *out)
{
    int64_t most = 0;
    pave_result result = PAVE_OK;
    *out = (pv_pile){ .head = *stones, .next = memory_next, .rewind = memory_rewind, .close = memory_close };
    for (int32_t i = 0; i < stones->count; i++) {
        int64_t corners = stones->starts[i + 1] - stones->starts[i];
        most = corners > most ? corners : most;
        out->counts[stones->colours[i]]++;
    }
    memory_pile *memory = pv_allocate(context, 1, sizeof *memory + 2 * (size_t)most * sizeof *memory->xy, &result);
    out->source = memory;
    if (memory)
        memory->at = 0;
    return result;
}

void pv_pile_close(pv_pile *pile)
{
    pile->close(pile);
}
