/* The tessellation's own bookkeeping: indexes, compaction, and the check of all that must hold. */
#include "stones/tess.h"

#include <string.h>

int32_t pv_tess_ring(const pv_tess *tess, int32_t face, pv_cell *ring, int32_t most)
{
    int32_t count = pv_tess_size(tess, face);
    for (int32_t i = 0; i < count && i < most; i++)
        ring[i] = tess->at[tess->corner[tess->first[face] + i]];
    return count;
}

pave_result pv_tess_index(pave_context *context, pv_tess *tess)
{
    pave_result result = PAVE_OK;
    int64_t places = tess->first[tess->face_count];
    pv_release(tess->star);
    pv_release(tess->spoke);
    pv_release(tess->face_of);
    tess->spoke = NULL;
    tess->face_of = NULL;
    tess->star = pv_allocate_zeroed(context, (size_t)tess->vertex_count + 2, sizeof *tess->star, &result);
    if (!result)
        tess->spoke = pv_allocate(context, (size_t)places, sizeof *tess->spoke, &result);
    if (!result)
        tess->face_of = pv_allocate(context, (size_t)places, sizeof *tess->face_of, &result);
    if (result)
        return result;
    for (int32_t f = 0; f < tess->face_count; f++)
        for (int64_t p = tess->first[f]; p < tess->first[f + 1]; p++) {
            tess->face_of[p] = f;
            tess->star[tess->corner[p] + 2]++;
        }
    for (int32_t v = 0; v < tess->vertex_count; v++)
        tess->star[v + 2] += tess->star[v + 1];
    for (int64_t p = 0; p < places; p++)
        tess->spoke[tess->star[tess->corner[p] + 1]++] = p;
    return PAVE_OK;
}

/* Rings without repeated neighbours. */
static void drop_repeats(pv_tess *tess)
{
    int64_t at = 0, begin = tess->first[0];
    for (int32_t f = 0; f < tess->face_count; f++) {
        int64_t end = tess->first[f + 1], first = at;
        for (int64_t p = begin; p < end; p++)
            if (at == first || tess->corner[at - 1] != tess->corner[p])
                tess->corner[at++] = tess->corner[p];
        while (at > first + 1 && tess->corner[at - 1] == tess->corner[first])
            at--;
        begin = end;
        tess->first[f + 1] = at;
    }
}

pave_result pv_tess_compact(pave_context *context, pv_tess *tess)
{
    pave_result result = PAVE_OK;
    drop_repeats(tess);
    int32_t *number = pv_allocate_zeroed(context, (size_t)tess->vertex_count, sizeof *number, &result);
    if (result)
        return result;
    for (int64_t p = 0; p < tess->first[tess->face_count]; p++)
        number[tess->corner[p]] = 1;
    int32_t count = 0;
    for (int32_t v = 0; v < tess->vertex_count; v++)
        if (number[v]) {
            tess->at[count] = tess->at[v];
            tess->kind[count] = tess->kind[v];
            tess->flat[count] = tess->flat[v];
            number[v] = count++;
        }
    for (int64_t p = 0; p < tess->first[tess->face_count]; p++)
        tess->corner[p] = number[tess->corner[p]];
    tess->vertex_count = count;
    pv_release(number);
    return pv_tess_index(context, tess);
}

/* How often the side from a to b occurs in rings. */
static int32_t count_side(const pv_tess *tess, int32_t a, int32_t b)
{
    int32_t count = 0;
    for (int64_t s = tess->star[a]; s < tess->star[a + 1]; s++)
        count += tess->corner[pv_tess_next(tess, tess->spoke[s])] == b;
    return count;
}

static const char *side_fault(const pv_tess *tess, int64_t place)
{
    int32_t a = tess->corner[place], b = tess->corner[pv_tess_next(tess, place)];
    int32_t border = tess->kind[a] & tess->kind[b] & PV_BORDER, back = count_side(tess, b, a);
    if (count_side(tess, a, b) != 1)
        return "belongs to two faces on one side";
    return back == 1 || (border && back == 0) ? NULL : "has no face on its other side";
}

pave_result pv_tess_check(pave_context *context, const pv_tess *tess)
{
    pave_result result = PAVE_OK;
    int32_t longest = 0;
    for (int32_t f = 0; f < tess->face_count; f++)
        longest = pv_tess_size(tess, f) > longest ? pv_tess_size(tess, f) : longest;
    pv_cell *ring = pv_allocate(context, (size_t)longest, sizeof *ring, &result);
    for (int32_t f = 0; f < tess->face_count && !result; f++)
        if (!pv_ring_valid(ring, pv_tess_ring(tess, f, ring, longest)))
            result = pv_fail(context, PAVE_ERR_INTERNAL, "face %d of %d sides is not a simple polygon", (int)f,
                             (int)pv_tess_size(tess, f));
    for (int64_t p = 0; p < tess->first[tess->face_count] && !result; p++) {
        const char *fault = side_fault(tess, p);
        if (fault)
            result = pv_fail(context, PAVE_ERR_INTERNAL, "side %lld of face %d %s", (long long)p,
                             (int)tess->face_of[p], fault);
    }
    for (int32_t v = 0; v < tess->vertex_count && !result; v++)
        if (tess->star[v] == tess->star[v + 1])
            result = pv_fail(context, PAVE_ERR_INTERNAL, "vertex %d is in no face", (int)v);
    pv_release(ring);
    return result;
}

void pv_tess_free(pv_tess *tess)
{
    pv_release(tess->at);
    pv_release(tess->kind);
    pv_release(tess->flat);
    pv_release(tess->first);
    pv_release(tess->corner);
    pv_release(tess->star);
    pv_release(tess->spoke);
    pv_release(tess->face_of);
    pv_release(tess->label);
    pv_release(tess->part);
    pv_release(tess->colour);
    memset(tess, 0, sizeof *tess);
}
