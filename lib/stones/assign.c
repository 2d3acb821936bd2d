/* Quads by assignment: a min-cost matching of vertices to faces, one augmenting path a vertex. */
#include "stones/assign.h"

#include <string.h>

enum { COST = 4096, UNASSIGNED = 16 * COST, FORBIDDEN = INT32_MAX, MOST_STEPS = 4096 };

typedef struct matching {
    pv_tess *tess;
    int64_t most, contour_most; /* cost */
    int32_t *most_flats; /* of faces */
    int32_t *room;   /* of faces of the block under way: how many more flats they can take */
    int32_t *cost;   /* of every place of `corner` */
    int32_t *best;   /* of faces, while a path is sought: cost to get there, */
    int64_t *by;     /* the place that was taken to get there */
    uint8_t *state;  /* of faces, while a path is sought */
} matching;

enum { UNSEEN, QUEUED, DONE };

static double width_at(const pv_tess *tess, int64_t place)
{
    pv_cell a = tess->at[tess->corner[pv_tess_previous(tess, place)]], b = tess->at[tess->corner[place]];
    pv_cell c = tess->at[tess->corner[pv_tess_next(tess, place)]];
    return pv_corner_width(a.x, a.y, b.x, b.y, c.x, c.y);
}

static int32_t degree(const pv_tess *tess, int32_t v)
{
    return (int32_t)(tess->star[v + 1] - tess->star[v]);
}

static int is_sharp_bend(const pv_tess *tess, int64_t place)
{
    return width_at(tess, place) < 0.8660254; /* 150 degrees */
}

int pv_is_corner(const pv_tess *tess, int64_t place)
{
    int32_t v = tess->corner[place];
    if (tess->kind[v] & PV_BEND)
        return is_sharp_bend(tess, place);
    return tess->flat[v] != tess->face_of[place];
}

/* Has the face of this place a colour there that no other face has? */
static int is_alone(const pv_tess *tess, int64_t place)
{
    int32_t v = tess->corner[place];
    uint8_t colour = tess->colour[tess->face_of[place]];
    int same = 0;
    for (int64_t s = tess->star[v]; s < tess->star[v + 1]; s++)
        same += tess->colour[tess->face_of[tess->spoke[s]]] == colour;
    return same == 1;
}

static int32_t cost_of(const matching *m, int64_t place)
{
    const pv_tess *tess = m->tess;
    int32_t v = tess->corner[place];
    if ((tess->kind[v] & (PV_BORDER | PV_BEND)) || degree(tess, v) != 3)
        return FORBIDDEN;
    double lack = 1 - width_at(tess, place);
    int64_t cost = (int64_t)((lack < 0 ? -lack : lack) * COST);
    if (tess->kind[v] & PV_CONTOUR)
        return is_alone(tess, place) && cost <= m->contour_most ? (int32_t)(cost / 4) : FORBIDDEN;
    return cost <= m->most ? (int32_t)cost : FORBIDDEN;
}

static void set_most_flats(matching *m)
{
    const pv_tess *tess = m->tess;
    for (int32_t f = 0; f < tess->face_count; f++) {
        int32_t corners = 0;
        for (int64_t p = tess->first[f]; p < tess->first[f + 1]; p++) {
            m->cost[p] = cost_of(m, p);
            corners += pv_is_corner(tess, p);
        }
        m->most_flats[f] = corners > 4 ? corners - 4 : 0;
    }
}

/* Queue of faces to go on from. */
typedef struct queue {
    int32_t face[MOST_STEPS];
    int32_t count;
} queue;

static void reach(matching *m, queue *q, int64_t place, int32_t cost, int32_t limit)
{
    int32_t f = m->tess->face_of[place];
    if (m->state[f] == DONE || cost >= m->best[f] || cost >= limit || q->count == MOST_STEPS)
        return;
    m->best[f] = cost;
    m->by[f] = place;
    if (m->state[f] == QUEUED)
        return;
    m->state[f] = QUEUED;
    q->face[q->count++] = f;
}

static void reach_from(matching *m, queue *q, int32_t v, int32_t without, int32_t cost, int32_t limit)
{
    const pv_tess *tess = m->tess;
    for (int64_t s = tess->star[v]; s < tess->star[v + 1]; s++) {
        int64_t place = tess->spoke[s];
        if (m->cost[place] != FORBIDDEN && tess->face_of[place] != without)
            reach(m, q, place, cost + m->cost[place], limit);
    }
}

/* The vertex belongs to the block: no other may be moved. */
static int is_own(const int32_t *vertices, int64_t count, int32_t v)
{
    int64_t low = 0, high = count;
    while (low < high) {
        int64_t middle = (low + high) / 2;
        if (vertices[middle] < v)
            low = middle + 1;
        else
            high = middle;
    }
    return low < count && vertices[low] == v;
}

/* From a face that is full one of its flats goes elsewhere. */
static void push_on(matching *m, queue *q, int32_t face, const int32_t *vertices, int64_t count, int32_t limit)
{
    const pv_tess *tess = m->tess;
    for (int64_t p = tess->first[face]; p < tess->first[face + 1]; p++) {
        int32_t u = tess->corner[p];
        if (tess->flat[u] == face && is_own(vertices, count, u))
            reach_from(m, q, u, face, m->best[face] - m->cost[p], limit);
    }
}

/* Takes the path to `face` back to `start`, each vertex on it into the face it led to. */
static void take_path(matching *m, int32_t face, int32_t start)
{
    pv_tess *tess = m->tess;
    m->room[face]--;
    for (;;) {
        int32_t v = tess->corner[m->by[face]], before = tess->flat[v];
        tess->flat[v] = face;
        if (v == start)
            return;
        face = before;
    }
}

static void insert(matching *m, int32_t v, const int32_t *vertices, int64_t count)
{
    queue q;
    int32_t target = -1, least = UNASSIGNED;
    q.count = 0;
    reach_from(m, &q, v, -1, 0, least);
    for (int32_t i = 0; i < q.count; i++) {
        int32_t f = q.face[i];
        m->state[f] = DONE;
        if (m->room[f] > 0) {
            if (m->best[f] < least)
                least = m->best[f], target = f;
        } else if (m->best[f] < least) {
            push_on(m, &q, f, vertices, count, least);
        }
    }
    if (target >= 0)
        take_path(m, target, v);
    for (int32_t i = 0; i < q.count; i++) {
        m->best[q.face[i]] = INT32_MAX;
        m->state[q.face[i]] = UNSEEN;
    }
}

static int32_t count_flats(const pv_tess *tess, int32_t face)
{
    int32_t count = 0;
    for (int64_t p = tess->first[face]; p < tess->first[face + 1]; p++)
        count += tess->flat[tess->corner[p]] == face;
    return count;
}

static void match_block(void *data, const int32_t *vertices, int64_t count)
{
    matching *m = data;
    const pv_tess *tess = m->tess;
    for (int64_t i = 0; i < count; i++)
        tess->flat[vertices[i]] = -1;
    for (int64_t i = 0; i < count; i++)
        for (int64_t s = tess->star[vertices[i]]; s < tess->star[vertices[i] + 1]; s++) {
            int32_t f = tess->face_of[tess->spoke[s]];
            m->room[f] = m->most_flats[f] - count_flats(tess, f);
        }
    for (int64_t i = 0; i < count; i++)
        insert(m, vertices[i], vertices, count);
}

static pave_result allocate(pave_context *context, matching *m)
{
    pave_result result = PAVE_OK;
    size_t faces = (size_t)m->tess->face_count;
    m->most_flats = pv_allocate(context, faces, sizeof *m->most_flats, &result);
    if (!result)
        m->room = pv_allocate(context, faces, sizeof *m->room, &result);
    if (!result)
        m->cost = pv_allocate(context, (size_t)m->tess->first[faces], sizeof *m->cost, &result);
    if (!result)
        m->best = pv_allocate(context, faces, sizeof *m->best, &result);
    if (!result)
        m->by = pv_allocate(context, faces, sizeof *m->by, &result);
    if (!result)
        m->state = pv_allocate_zeroed(context, faces, 1, &result);
    for (size_t f = 0; f < faces && !result; f++)
        m->best[f] = INT32_MAX;
    return result;
}

pave_result pv_assign_flats(pave_context *context, const pv_assign_params *params, pv_tess *tess, double from,
                            double to)
{
    matching m = { .tess = tess };
    m.most = (int64_t)((1 - pv_width_of_degrees(180 - params->most_lack)) * COST);
    m.contour_most = (int64_t)((1 - pv_width_of_degrees(180 - params->contour_lack)) * COST);
    memset(tess->flat, -1, (size_t)tess->vertex_count * sizeof *tess->flat);
    pave_result result = allocate(context, &m);
    if (!result)
        set_most_flats(&m);
    for (int sweep = 0; sweep < 2 && !result; sweep++) {
        pv_blocks blocks;
        result = pv_blocks_build(context, tess, params->block, sweep, &blocks);
        if (!result)
            result = pv_blocks_run(context, &blocks, match_block, &m, from + (to - from) * sweep / 2,
                                   from + (to - from) * (sweep + 1) / 2);
        pv_blocks_free(&blocks);
    }
    pv_release(m.most_flats);
    pv_release(m.room);
    pv_release(m.cost);
    pv_release(m.best);
    pv_release(m.by);
    pv_release(m.state);
    return result;
}
