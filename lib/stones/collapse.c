/* Short sides: found, compared with those around them, and merged where nothing forbids it. */
#include "stones/collapse.h"

#include <string.h>

enum { MOST_RING = 64 };

typedef struct short_side {
    int64_t square;
    int32_t a, b;
    int64_t place; /* of a, where b follows */
} short_side;

static int comes_before(const short_side *s, const short_side *t)
{
    if (s->square != t->square)
        return s->square < t->square;
    return s->a != t->a ? s->a < t->a : s->b < t->b;
}

static int is_plain_junction(const pv_tess *tess, int32_t v)
{
    return !(tess->kind[v] & PV_BEND) && tess->star[v + 1] - tess->star[v] == 3;
}

static int64_t square_between(const pv_tess *tess, int32_t a, int32_t b)
{
    int64_t dx = (int64_t)tess->at[a].x - tess->at[b].x, dy = (int64_t)tess->at[a].y - tess->at[b].y;
    return dx * dx + dy * dy;
}

/* The face at v besides the two given; -1: none. */
static int32_t third_face(const pv_tess *tess, int32_t v, int32_t f, int32_t g)
{
    for (int64_t s = tess->star[v]; s < tess->star[v + 1]; s++) {
        int32_t h = tess->face_of[tess->spoke[s]];
        if (h != f && h != g)
            return h;
    }
    return -1;
}

/* The face on the other side of the side that begins at `place`; -1: none. */
static int32_t face_across(const pv_tess *tess, int64_t place)
{
    int32_t a = tess->corner[place], b = tess->corner[pv_tess_next(tess, place)];
    for (int64_t s = tess->star[b]; s < tess->star[b + 1]; s++)
        if (tess->corner[pv_tess_next(tess, tess->spoke[s])] == a)
            return tess->face_of[tess->spoke[s]];
    return -1;
}

/* Where both ends would go. 0: they cannot. */
static int meeting_place(const pv_tess *tess, const short_side *s, pv_cell *out)
{
    int fixed = PV_BORDER | PV_CONTOUR;
    pv_cell a = tess->at[s->a], b = tess->at[s->b];
    if ((tess->kind[s->a] & fixed) && (tess->kind[s->b] & fixed))
        return 0;
    pv_cell middle = { a.x + (b.x - a.x) / 2, a.y + (b.y - a.y) / 2 };
    *out = tess->kind[s->a] & fixed ? a : tess->kind[s->b] & fixed ? b : middle;
    return 1;
}

static int stays_simple(const pv_tess *tess, int32_t face, const short_side *s, pv_cell there)
{
    pv_cell ring[MOST_RING];
    int32_t size = pv_tess_size(tess, face), n = 0, put = 0;
    if (size > MOST_RING)
        return 0;
    for (int32_t i = 0; i < size; i++) {
        int32_t v = tess->corner[tess->first[face] + i];
        if (v != s->a && v != s->b)
            ring[n++] = tess->at[v];
        else if (!put++)
            ring[n++] = there;
    }
    return pv_ring_valid(ring, n);
}

/* The four faces around a side. 0 if it cannot go. */
static int may_collapse(const pv_tess *tess, const short_side *s, int32_t corners, int32_t faces[4], pv_cell *there)
{
    int32_t left = faces[0] = tess->face_of[s->place], right = faces[1] = face_across(tess, s->place);
    if (right < 0 || !meeting_place(tess, s, there))
        return 0;
    faces[2] = third_face(tess, s->a, left, right);
    faces[3] = third_face(tess, s->b, left, right);
    if (faces[2] < 0 || faces[3] < 0 || faces[2] == faces[3])
        return 0;
    if (pv_tess_size(tess, left) <= corners || pv_tess_size(tess, right) <= corners)
        return 0;
    for (int k = 0; k < 4; k++)
        if (!stays_simple(tess, faces[k], s, *there))
            return 0;
    return 1;
}

static int64_t find_short(const pv_tess *tess, int64_t least, short_side *out)
{
    int64_t count = 0;
    for (int64_t p = 0; p < tess->first[tess->face_count]; p++) {
        int32_t a = tess->corner[p], b = tess->corner[pv_tess_next(tess, p)];
        if (a > b || !is_plain_junction(tess, a) || !is_plain_junction(tess, b))
            continue;
        int64_t square = square_between(tess, a, b);
        if (square >= least * least)
            continue;
        if (out)
            out[count] = (short_side){ square, a, b, p };
        count++;
    }
    return count;
}

/* Every face knows the shortest of the sides that may go around it; those go that are so for all their faces. */
static int64_t collapse_some(pv_tess *tess, const short_side *sides, int64_t count, int32_t corners, int64_t *best)
{
    int64_t gone = 0;
    int32_t faces[4];
    pv_cell there;
    for (int32_t f = 0; f < tess->face_count; f++)
        best[f] = -1;
    for (int64_t i = 0; i < count; i++)
        for (int k = 0, may = may_collapse(tess, &sides[i], corners, faces, &there); k < 4 && may; k++)
            if (best[faces[k]] < 0 || comes_before(&sides[i], &sides[best[faces[k]]]))
                best[faces[k]] = i;
    for (int64_t i = 0; i < count; i++) {
        const short_side *s = &sides[i];
        if (best[tess->face_of[s->place]] != i || !may_collapse(tess, s, corners, faces, &there) ||
            best[faces[1]] != i || best[faces[2]] != i || best[faces[3]] != i)
            continue;
        tess->at[s->a] = there;
        tess->kind[s->a] |= tess->kind[s->b];
        for (int64_t k = tess->star[s->b]; k < tess->star[s->b + 1]; k++)
            tess->corner[tess->spoke[k]] = s->a;
        gone++;
    }
    return gone;
}

pave_result pv_tess_collapse(pave_context *context, pv_tess *tess, int64_t least, int32_t corners, int32_t rounds)
{
    pave_result result = PAVE_OK;
    int64_t gone = 1;
    for (int32_t round = 0; round < rounds && gone && !result; round++) {
        int64_t count = find_short(tess, least, NULL);
        short_side *sides = pv_allocate(context, (size_t)count, sizeof *sides, &result);
        int64_t *best = result ? NULL : pv_allocate(context, (size_t)tess->face_count, sizeof *best, &result);
        if (!result) {
            find_short(tess, least, sides);
            gone = collapse_some(tess, sides, count, corners, best);
        }
        if (!result && gone)
            result = pv_tess_compact(context, tess);
        pv_release(best);
        pv_release(sides);
    }
    return result;
}
