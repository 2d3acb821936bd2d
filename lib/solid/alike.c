/* For every neighbourhood of the sample a few that are most alike but not the same. Source: Tong et al. 2002
 * (k-coherence) for what they are used for, Barnes et al. 2010 (generalised PatchMatch) for how they are found: what is
 * alike here is alike one texel further, so that the cost of a texel does not grow with the sample. */
#include "solid/bank.h"

#include "base/parallel.h"
#include "util/random.h"

#include <string.h>

enum { ROUNDS = 5, TRIES = 6, PART = 2048, ROWS = 4 };

typedef struct search {
    pv_windows *bank;
    uint64_t *name;    /* [position]: the same for the same neighbourhood and centre */
    int32_t *distance; /* [position][PV_NEAREST] */
    int16_t *all;      /* every tap present */
    uint64_t seed;
    pv_distances *distances;
    int32_t round, part, shift; /* positions that are gone over one after the other, and where the first part ends */
} search;

static void name_patches(search *s)
{
    const pv_windows *bank = s->bank;
    for (int32_t p = 0; p < bank->positions; p++) {
        const int16_t *patch = bank->patch + (size_t)p * (size_t)bank->window.stride;
        uint64_t hash = 14695981039346656037u ^ bank->class[p];
        for (int32_t i = 0; i < bank->window.taps; i++)
            hash = (hash ^ (uint16_t)patch[i]) * 1099511628211u;
        s->name[p] = hash;
    }
}

/* Takes `candidate` into the list of `p` if it is nearer than its last and unlike all in it. */
static void offer(search *s, int32_t p, int32_t candidate)
{
    const pv_windows *bank = s->bank;
    int32_t *list = bank->nearest + (size_t)p * PV_NEAREST, *distance = s->distance + (size_t)p * PV_NEAREST;
    if (!bank->inside[candidate] || s->name[candidate] == s->name[p])
        return;
    for (int i = 0; i < PV_NEAREST; i++)
        if (list[i] >= 0 && s->name[list[i]] == s->name[candidate])
            return;
    int32_t d;
    s->distances(bank, bank->patch + (size_t)p * (size_t)bank->window.stride, s->all, &candidate, 1, &d);
    int i = PV_NEAREST;
    if (list[i - 1] >= 0 && d >= distance[i - 1])
        return;
    for (i--; i > 0 && (list[i - 1] < 0 || d < distance[i - 1]); i--)
        list[i] = list[i - 1], distance[i] = distance[i - 1];
    list[i] = candidate;
    distance[i] = d;
}

static int32_t part_of(const search *s, int32_t position)
{
    return (position + s->shift) / s->part;
}

/* Only neighbours of the same part: the others' lists are being written. */
static void offer_shifted(search *s, int32_t p, int32_t neighbour, int32_t dx, int32_t dy)
{
    const pv_windows *bank = s->bank;
    if (neighbour < 0 || neighbour >= bank->positions || !bank->inside[neighbour] ||
        part_of(s, neighbour) != part_of(s, p))
        return;
    for (int i = 0; i < PV_NEAREST; i++) {
        int32_t q = bank->nearest[(size_t)neighbour * PV_NEAREST + (size_t)i];
        if (q >= 0)
            offer(s, p, q + dy * pv_windows_row(bank, q) + dx);
    }
}

static void improve(search *s, int32_t p)
{
    const pv_windows *bank = s->bank;
    int32_t row = pv_windows_row(bank, p), way = s->round & 1 ? -1 : 1;
    offer_shifted(s, p, p - way, way, 0);
    offer_shifted(s, p, p - way * row, 0, way);
    for (uint32_t t = 0; t < TRIES; t++) {
        pv_random r = pv_draw(s->seed, PV_DRAW_ALIKE, (uint32_t)p, (uint32_t)s->round, t);
        offer(s, p, bank->inner[pv_below(r.word[0], (uint32_t)bank->inner_count)]);
        /* among those with the centre alike */
        int32_t from = bank->class_start[bank->class[p]], to = bank->class_start[bank->class[p] + 1];
        if (to > from)
            offer(s, p, bank->inner[from + (int32_t)pv_below(r.word[1], (uint32_t)(to - from))]);
    }
}

static void improve_part(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    search *s = data;
    const pv_windows *bank = s->bank;
    int32_t from = index * s->part - s->shift, to = from + s->part;
    from = from < 0 ? 0 : from;
    to = to < bank->positions ? to : bank->positions;
    for (int32_t i = from; i < to; i++) {
        int32_t p = s->round & 1 ? from + to - 1 - i : i;
        if (bank->inside[p])
            improve(s, p);
    }
}

/* Parts depend on the sample alone, and every other round they lie half a part further, so that what is found gets
 * everywhere. */
static pave_result run(pave_context *context, search *s)
{
    pave_result result = PAVE_OK;
    int32_t rows = ROWS * (s->bank->width > s->bank->height ? s->bank->width : s->bank->height);
    s->part = rows > PART ? rows : PART;
    for (s->round = 0; s->round < ROUNDS && !result; s->round++) {
        s->shift = s->round & 1 ? s->part / 2 : 0;
        result = pv_parallel(context, part_of(s, s->bank->positions - 1) + 1, improve_part, s, 0, 0);
    }
    return result;
}

pave_result pv_windows_alike(pave_context *context, pv_windows *bank, uint64_t seed)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)bank->positions;
    search s = { .bank = bank, .seed = seed, .distances = pv_distances_choose(0) };
    s.name = pv_allocate(context, n, sizeof *s.name, &result);
    s.distance = result ? NULL : pv_allocate(context, n * PV_NEAREST, sizeof *s.distance, &result);
    s.all = result ? NULL : pv_allocate(context, (size_t)bank->window.stride, sizeof *s.all, &result);
    if (!result) {
        for (int32_t i = 0; i < bank->window.stride; i++)
            s.all[i] = 1;
        name_patches(&s);
        result = run(context, &s);
    }
    pv_release(s.name);
    pv_release(s.distance);
    pv_release(s.all);
    return result;
}
