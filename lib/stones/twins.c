/* Originals and copies by their places in the period: a hash table, and what follows from it. */
#include "stones/twins.h"

#include "util/fixed.h"

#include <string.h>

typedef struct table {
    const pv_tess *tess;
    uint32_t mask;
    int32_t *slot; /* an original; -1: free */
} table;

static pv_cell place_of(const pv_tess *tess, int32_t v)
{
    return (pv_cell){ pv_modulo(tess->at[v].x, tess->period.x), pv_modulo(tess->at[v].y, tess->period.y) };
}

/* The slot of the original at a place, or where it would be. */
static uint32_t find(const table *t, pv_cell place)
{
    uint32_t at = (uint32_t)place.x * 2654435761u ^ (uint32_t)place.y * 2246822519u;
    for (at ^= at >> 15;; at++) {
        int32_t v = t->slot[at & t->mask];
        if (v < 0)
            return at & t->mask;
        pv_cell there = place_of(t->tess, v);
        if (there.x == place.x && there.y == place.y)
            return at & t->mask;
    }
}

static int32_t degree(const pv_tess *tess, int32_t v)
{
    return (int32_t)(tess->star[v + 1] - tess->star[v]);
}

static void add(const pv_tess *tess, int32_t copy, int32_t original, pv_twins *out)
{
    pv_cell c = tess->at[copy], o = tess->at[original];
    if (degree(tess, copy) != degree(tess, original))
        return; /* at the region's border */
    out->copy[out->count] = copy;
    out->original[out->count] = original;
    out->away[out->count++] = (pv_cell){ c.x - o.x, c.y - o.y };
}

pave_result pv_twins_find(pave_context *context, const pv_tess *tess, const uint8_t *originals, pv_twins *out)
{
    table t = { tess, 1, NULL };
    pave_result result = PAVE_OK;
    size_t n = (size_t)tess->vertex_count;
    memset(out, 0, sizeof *out);
    while (t.mask < 2 * n)
        t.mask = 2 * t.mask + 1;
    t.slot = pv_allocate(context, (size_t)t.mask + 1, sizeof *t.slot, &result);
    if (!result)
        out->copy = pv_allocate(context, n, sizeof *out->copy, &result);
    if (!result)
        out->original = pv_allocate(context, n, sizeof *out->original, &result);
    if (!result)
        out->away = pv_allocate(context, n, sizeof *out->away, &result);
    if (!result)
        memset(t.slot, -1, ((size_t)t.mask + 1) * sizeof *t.slot);
    for (int32_t v = 0; v < tess->vertex_count && !result; v++)
        if (originals[v])
            t.slot[find(&t, place_of(tess, v))] = v;
    for (int32_t v = 0; v < tess->vertex_count && !result; v++) {
        int32_t original = originals[v] ? -1 : t.slot[find(&t, place_of(tess, v))];
        if (original >= 0)
            add(tess, v, original, out);
    }
    pv_release(t.slot);
    return result;
}

/* The faces around a vertex and around its copy are in the same order. */
static int32_t flat_face(const pv_tess *tess, int32_t copy, int32_t original)
{
    for (int32_t k = 0; k < degree(tess, original); k++)
        if (tess->face_of[tess->spoke[tess->star[original] + k]] == tess->flat[original])
            return tess->face_of[tess->spoke[tess->star[copy] + k]];
    return -1;
}

void pv_twins_follow(const pv_twins *twins, pv_tess *tess)
{
    for (int32_t i = 0; i < twins->count; i++) {
        int32_t copy = twins->copy[i], original = twins->original[i];
        tess->at[copy].x = tess->at[original].x + twins->away[i].x;
        tess->at[copy].y = tess->at[original].y + twins->away[i].y;
        tess->flat[copy] = flat_face(tess, copy, original);
    }
}

void pv_twins_free(pv_twins *twins)
{
    pv_release(twins->copy);
    pv_release(twins->original);
    pv_release(twins->away);
    memset(twins, 0, sizeof *twins);
}
