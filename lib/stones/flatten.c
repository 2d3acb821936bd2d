/* Wide angles made straight in the shared tessellation (III.C).
 *
 * A vertex can be straight in one of its polygons only. In each pass every polygon asks for its widest corners as long
 * as four others remain; a vertex goes to the polygon where it is widest, and stays with it; then all move at once.
 * So no order is involved, and a pass reaches no farther than to the neighbours. Vertices of the contour between two
 * colours stay: they are nearly straight where the edge is, and at its corners they are what shows it. */
#include "base/parallel.h"
#include "stones/stones.h"

#include "util/polygon.h"

#include <sched.h>
#include <string.h>

typedef struct request {
    double width; /* of the corner, pv_corner_width */
    int32_t ring; /* -1: nobody asks */
    int32_t busy; /* a thread is looking */
    pv_point way;
} request;

enum { MOST_CORNERS = 256 }; /* longer rings come from broken cells and are left as they are */

/* A vertex aims at a line whose ends move too: a whole step would overshoot (overlaps of 4 % instead of 0.4). */
#define STEP 0.6

typedef struct ring {
    int32_t index, count;
    const int32_t *corner;
    uint8_t active[MOST_CORNERS];
} ring;

static int32_t step(const ring *r, int32_t i, int32_t by)
{
    do
        i = (i + by + r->count) % r->count;
    while (!r->active[i]);
    return i;
}

static double corner_width(const pv_mesh *mesh, const ring *r, int32_t i)
{
    pv_point a = mesh->vertex[r->corner[step(r, i, -1)]], b = mesh->vertex[r->corner[i]],
             c = mesh->vertex[r->corner[step(r, i, 1)]];
    return pv_corner_width(a.x, a.y, b.x, b.y, c.x, c.y);
}

static int on_border(const pv_mesh *mesh, pv_point p)
{
    return p.x <= mesh->left || p.y <= mesh->top || p.x >= mesh->right || p.y >= mesh->bottom;
}

/* The widest corner that this ring may still ask for, -1 if there is none. */
static int32_t widest(const pv_mesh *mesh, const ring *r, double limit, double *width)
{
    int32_t best = -1;
    *width = limit;
    for (int32_t i = 0; i < r->count; i++) {
        int32_t v = r->corner[i], owner = mesh->owner[v];
        if (!r->active[i] || mesh->low[v] != mesh->high[v] || on_border(mesh, mesh->vertex[v]) ||
            (owner >= 0 && owner != r->index))
            continue;
        double w = corner_width(mesh, r, i);
        if (w > *width)
            *width = w, best = i;
    }
    return best;
}

/* The way to the foot of the perpendicular on the line between the neighbours, away from their ends. */
static pv_point way_to_foot(const pv_mesh *mesh, const ring *r, int32_t i)
{
    pv_point a = mesh->vertex[r->corner[step(r, i, -1)]], p = mesh->vertex[r->corner[i]],
             b = mesh->vertex[r->corner[step(r, i, 1)]];
    double dx = b.x - a.x, dy = b.y - a.y, square = dx * dx + dy * dy;
    if (!(square > 0))
        return (pv_point){ 0, 0 };
    double t = ((p.x - a.x) * dx + (p.y - a.y) * dy) / square;
    t = t < 0.1 ? 0.1 : t < 0.9 ? t : 0.9;
    return (pv_point){ a.x - p.x + t * dx, a.y - p.y + t * dy };
}

/* The widest corner gets the vertex, and the lower ring among equals, whoever comes first. */
static void ask(const pv_mesh *mesh, const ring *r, int32_t i, double width, request *requests)
{
    request *q = &requests[r->corner[i]];
    pv_point way = way_to_foot(mesh, r, i);
    while (__atomic_exchange_n(&q->busy, 1, __ATOMIC_ACQUIRE))
        sched_yield();
    if (q->ring < 0 || q->width < width || (q->width == width && q->ring > r->index)) {
        q->width = width;
        q->ring = r->index;
        q->way = way;
    }
    __atomic_store_n(&q->busy, 0, __ATOMIC_RELEASE);
}

/* Corners that a ring already owns come first, so that they are straightened again after their neighbours moved. */
static void ask_for_own(const pv_mesh *mesh, ring *r, int32_t *active, request *requests)
{
    for (int32_t i = 0; i < r->count; i++)
        if (mesh->owner[r->corner[i]] == r->index && *active > 4) {
            r->active[i] = 0;
            --*active;
        }
    for (int32_t i = 0; i < r->count; i++)
        if (!r->active[i])
            ask(mesh, r, i, 4, requests);
}

static void ring_asks(const pv_mesh *mesh, ring *r, double limit, request *requests)
{
    int32_t active = r->count;
    memset(r->active, 1, (size_t)r->count);
    ask_for_own(mesh, r, &active, requests);
    while (active > 4) {
        double width;
        int32_t i = widest(mesh, r, limit, &width);
        if (i < 0)
            break;
        ask(mesh, r, i, width, requests);
        r->active[i] = 0;
        active--;
    }
}

typedef struct flatten_job {
    pv_mesh *mesh;
    request *requests;
    double limit;
} flatten_job;

static void ask_some(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    const flatten_job *job = data;
    const pv_mesh *mesh = job->mesh;
    for (int32_t k = begin; k < end; k++) {
        int64_t count = mesh->first[k + 1] - mesh->first[k];
        ring r = { .index = k, .count = (int32_t)count, .corner = mesh->corner + mesh->first[k] };
        if (count > 4 && count <= MOST_CORNERS)
            ring_asks(mesh, &r, job->limit, job->requests);
    }
}

static void grant_some(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    const flatten_job *job = data;
    pv_mesh *mesh = job->mesh;
    for (int32_t v = begin; v < end; v++) {
        request *q = &job->requests[v];
        if (q->ring >= 0) {
            mesh->owner[v] = q->ring;
            mesh->vertex[v].x += pv_way(STEP * q->way.x);
            mesh->vertex[v].y += pv_way(STEP * q->way.y);
        }
        q->ring = -1;
    }
}

pave_result pv_mesh_flatten(pave_context *context, const pave_stones_params *params, pv_mesh *mesh)
{
    pave_result result = PAVE_OK;
    flatten_job job = { mesh, NULL, pv_width_of_degrees(params->wide_angle) };
    job.requests = pv_allocate(context, (size_t)mesh->vertex_count, sizeof *job.requests, &result);
    for (int32_t v = 0; v < mesh->vertex_count && !result; v++)
        job.requests[v] = (request){ .ring = -1 };
    for (int32_t pass = 0; pass < params->passes && !result; pass++) {
        double from = 0.4 + 0.2 * pass / params->passes, to = 0.4 + 0.2 * (pass + 1) / params->passes;
        result = pv_parallel_runs(context, mesh->ring_count, PV_RINGS, ask_some, &job, from, to);
        if (!result)
            result = pv_parallel_runs(context, mesh->vertex_count, 8 * PV_RINGS, grant_some, &job, to, to);
    }
    pv_release(job.requests);
    return result;
}
