/* Stones as arrays, and in the order of their sites. */
#include "stones/stones.h"

#include <stdlib.h>
#include <string.h>

pave_result pv_stones_allocate(pave_context *context, size_t n, size_t corners, pave_stones *out)
{
    pave_result result = PAVE_OK;
    out->starts = pv_allocate_zeroed(context, n + 1, sizeof *out->starts, &result);
    if (!result)
        out->vertices = pv_allocate(context, corners, 2 * sizeof *out->vertices, &result);
    if (!result)
        out->colours = pv_allocate(context, n, sizeof *out->colours, &result);
    if (!result)
        out->sites = pv_allocate(context, n, sizeof *out->sites, &result);
    return result;
}

void pv_stones_drop(pave_stones *s)
{
    pv_release(s->starts);
    pv_release(s->vertices);
    pv_release(s->colours);
    pv_release(s->sites);
    s->starts = NULL;
    s->vertices = NULL;
    s->colours = NULL;
    s->sites = NULL;
}

typedef struct numbered {
    int32_t number, place;
} numbered;

static int by_number(const void *a, const void *b)
{
    const numbered *p = a, *q = b;
    return p->number != q->number ? (p->number > q->number) - (p->number < q->number)
                                  : (p->place > q->place) - (p->place < q->place);
}

static void put_in_order(const numbered *order, const pave_stones *from, pave_stones *to)
{
    for (int32_t i = 0; i < from->count; i++) {
        int32_t k = order[i].place;
        int64_t first = from->starts[k], corners = from->starts[k + 1] - first;
        memcpy(to->vertices + 2 * to->starts[i], from->vertices + 2 * first,
               2 * (size_t)corners * sizeof *to->vertices);
        to->starts[i + 1] = to->starts[i] + corners;
        to->colours[i] = from->colours[k];
        to->sites[i] = order[i].number;
    }
}

pave_result pv_stones_sort(pave_context *context, pave_stones *out)
{
    pave_result result = PAVE_OK;
    pave_stones sorted = *out;
    sorted.starts = NULL, sorted.vertices = NULL, sorted.colours = NULL, sorted.sites = NULL;
    numbered *order = pv_allocate(context, (size_t)out->count, sizeof *order, &result);
    if (!result)
        result = pv_stones_allocate(context, (size_t)out->count, (size_t)out->starts[out->count], &sorted);
    for (int32_t i = 0; i < out->count && !result; i++)
        order[i] = (numbered){ out->sites[i], i };
    if (!result) {
        qsort(order, (size_t)out->count, sizeof *order, by_number);
        put_in_order(order, out, &sorted);
    }
    pv_stones_drop(result ? &sorted : out);
    if (!result)
        *out = sorted;
    pv_release(order);
    return result;
}
