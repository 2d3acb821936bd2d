/* How much ground lies under two stones: stones cut into convex pieces, pieces that may meet tested exactly. */
#include "stones/measure.h"

#include "util/clip.h"

#include <string.h>

/* Convex pieces of the valid stones, as rings and as boxes. */
typedef struct pieces {
    int32_t count, longest;
    int64_t *first;
    pv_cell *corner;
    int32_t *stone;
    pv_box *box;
} pieces;

static const pv_cell *ring_of(const pieces *p, int32_t i, int32_t *count)
{
    *count = (int32_t)(p->first[i + 1] - p->first[i]);
    return p->corner + p->first[i];
}

static void add(pieces *p, const pv_cell *ring, int32_t count, int32_t stone)
{
    int64_t at = p->first[p->count];
    memmove(p->corner + at, ring, (size_t)count * sizeof *ring);
    p->stone[p->count] = stone;
    p->box[p->count] = pv_box_of(ring, count);
    p->first[++p->count] = at + count;
    p->longest = count > p->longest ? count : p->longest;
}

static pave_result add_triangles(pave_context *context, pieces *p, const pv_cell *ring, int32_t count, int32_t stone)
{
    pave_result result = PAVE_OK;
    pv_cell *work = pv_allocate(context, (size_t)count * 4, sizeof *work, &result), *triangle = work + count;
    if (!work)
        return result;
    memcpy(work, ring, (size_t)count * sizeof *ring);
    int32_t found = pv_ring_triangles(work, count, triangle);
    for (int32_t t = 0; t < found; t++)
        add(p, triangle + 3 * t, 3, stone);
    pv_release(work);
    return PAVE_OK;
}

/* A stone of n corners makes at most n pieces with 3 n corners. */
static pave_result allocate(pave_context *context, const pv_survey *survey, pieces *p)
{
    pave_result result = PAVE_OK;
    size_t corners = (size_t)survey->first[survey->count];
    p->first = pv_allocate_zeroed(context, corners + 1, sizeof *p->first, &result);
    if (!result)
        p->corner = pv_allocate(context, corners * 3, sizeof *p->corner, &result);
    if (!result)
        p->stone = pv_allocate(context, corners, sizeof *p->stone, &result);
    if (!result)
        p->box = pv_allocate(context, corners, sizeof *p->box, &result);
    return result;
}

static pave_result cut(pave_context *context, const pv_survey *survey, pieces *p)
{
    pave_result result = allocate(context, survey, p);
    for (int32_t s = 0; s < survey->count && !result; s++) {
        int32_t count;
        const pv_cell *ring = pv_survey_ring(survey, s, &count);
        if (survey->valid[s] && pv_ring_convex(ring, count))
            add(p, ring, count, s);
        else if (survey->valid[s])
            result = add_triangles(context, p, ring, count, s);
        if (!result && s % 1024 == 0)
            result = pv_progress(context, 0.1 + 0.1 * s / survey->count);
    }
    return result;
}

/* What is found while pairs are gone through. */
typedef struct search {
    const pieces *p;
    const pv_buckets *buckets;
    double *work;
    uint8_t *overlaps; /* a stone */
    double area;       /* squares of the grid */
} search;

/* The bucket where a pair is looked at: the one that holds the corner that their boxes share. */
static int64_t home(const pv_buckets *buckets, const pv_box *a, const pv_box *b)
{
    int32_t x = a->left > b->left ? a->left : b->left, y = a->top > b->top ? a->top : b->top;
    return (int64_t)pv_bucket_row(buckets, y) * buckets->columns + pv_bucket_column(buckets, x);
}

static int boxes_meet(const pv_box *a, const pv_box *b)
{
    return a->left < b->right && b->left < a->right && a->top < b->bottom && b->top < a->bottom;
}

static void meet(search *s, int32_t i, int32_t j, int64_t bucket)
{
    const pieces *p = s->p;
    if (!boxes_meet(&p->box[i], &p->box[j]) || p->stone[i] == p->stone[j] ||
        home(s->buckets, &p->box[i], &p->box[j]) != bucket)
        return;
    int32_t a_count, b_count;
    const pv_cell *a = ring_of(p, i, &a_count), *b = ring_of(p, j, &b_count);
    if (!pv_convex_meet(a, a_count, b, b_count))
        return;
    s->overlaps[p->stone[i]] = s->overlaps[p->stone[j]] = 1;
    s->area += pv_convex_common(a, a_count, b, b_count, s->work);
}

static pave_result go_through(pave_context *context, search *s)
{
    const pv_buckets *b = s->buckets;
    int64_t buckets = (int64_t)b->columns * b->rows, done = 0;
    for (int64_t k = 0; k < buckets; k++)
        for (int64_t i = b->first[k]; i < b->first[k + 1]; i++) {
            for (int64_t j = i + 1; j < b->first[k + 1]; j++)
                meet(s, b->member[i], b->member[j], k);
            if (++done % 256)
                continue;
            pave_result result = pv_progress(context, 0.2 + 0.1 * (double)k / (double)buckets);
            if (result)
                return result;
        }
    return PAVE_OK;
}

static pave_result sum_up(pave_context *context, const pv_survey *survey, search *s, pave_stones_measures *out)
{
    pave_result result = PAVE_OK;
    s->work = pv_allocate(context, (size_t)s->p->longest * 8, sizeof *s->work, &result);
    if (!result)
        s->overlaps = pv_allocate_zeroed(context, (size_t)survey->count, 1, &result);
    if (!result)
        result = go_through(context, s);
    for (int32_t i = 0; i < survey->count && !result; i++)
        out->overlapping += s->overlaps[i];
    out->overlap = s->area / ((double)PV_GRID * PV_GRID) / ((double)out->width * out->height);
    pv_release(s->work);
    pv_release(s->overlaps);
    return result;
}

pave_result pv_measure_overlap(pave_context *context, const pv_survey *survey, pave_stones_measures *out)
{
    pieces p;
    pv_buckets buckets;
    memset(&p, 0, sizeof p);
    memset(&buckets, 0, sizeof buckets);
    pave_result result = cut(context, survey, &p);
    if (!result)
        result = pv_buckets_fill(context, survey->stones, p.box, p.count, &buckets);
    search s = { .p = &p, .buckets = &buckets };
    if (!result)
        result = sum_up(context, survey, &s, out);
    pv_buckets_free(&buckets);
    pv_release(p.first);
    pv_release(p.corner);
    pv_release(p.stone);
    pv_release(p.box);
    return result;
}
