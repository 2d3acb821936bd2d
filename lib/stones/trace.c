/* From labels to polygons: where three or four labels meet there is a vertex; around each label its vertices are put
 * in order by their angle at the vertices' mean (III.C; cells are assumed to be star-shaped). */
#include "base/parallel.h"
#include "cvd/cvd.h"
#include "stones/stones.h"

#include <string.h>

/* The labels around lattice point (x, y) without repetition; up to four of them, none outside the image. */
static int labels_around(const pave_cvd *cvd, int32_t x, int32_t y, int32_t *labels)
{
    int count = 0;
    for (int k = 0; k < 4; k++) {
        int32_t px = x - 1 + (k & 1), py = y - 1 + (k >> 1);
        if (px < 0 || py < 0 || px >= cvd->width || py >= cvd->height)
            continue;
        int32_t label = cvd->labels[(int64_t)py * cvd->width + px];
        int known = 0;
        for (int i = 0; i < count; i++)
            known |= labels[i] == label;
        if (!known)
            labels[count++] = label;
    }
    return count;
}

/* Three labels inside, two along the border, one in the four corners. */
static int is_vertex(const pave_cvd *cvd, int32_t x, int32_t y, int count)
{
    int borders = (x == 0 || x == cvd->width) + (y == 0 || y == cvd->height);
    return count >= 3 - borders;
}

/* Lattice rows are done in bands, each with its own vertices, so that these are numbered row by row. */
typedef struct trace_job {
    const pave_cvd *cvd;
    pv_mesh *mesh;
    int32_t rows;   /* of a band */
    int32_t *first; /* vertex of each band; before, one further on, how many it has */
} trace_job;

typedef void vertex_visit(const trace_job *job, int32_t band, int32_t x, int32_t y, const int32_t *labels, int count);

/* Inside a cell nothing is to be done. */
static int within_a_cell(const pave_cvd *cvd, int32_t x, int32_t y)
{
    if (x == 0 || y == 0 || x == cvd->width || y == cvd->height)
        return 0;
    const int32_t *below = cvd->labels + (int64_t)y * cvd->width + x, *above = below - cvd->width;
    return below[0] == below[-1] && below[0] == above[0] && below[0] == above[-1];
}

static void visit_band(const trace_job *job, int32_t band, vertex_visit *visit)
{
    const pave_cvd *cvd = job->cvd;
    int32_t end = (band + 1) * job->rows < cvd->height + 1 ? (band + 1) * job->rows : cvd->height + 1;
    for (int32_t y = band * job->rows; y < end; y++)
        for (int32_t x = 0; x <= cvd->width; x++) {
            int32_t labels[4];
            if (within_a_cell(cvd, x, y))
                continue;
            int count = labels_around(cvd, x, y, labels);
            if (is_vertex(cvd, x, y, count))
                visit(job, band, x, y, labels, count);
        }
}

static int64_t count_up(int64_t *counter)
{
    return __atomic_fetch_add(counter, 1, __ATOMIC_RELAXED);
}

static void count_vertex(const trace_job *job, int32_t band, int32_t x, int32_t y, const int32_t *labels, int count)
{
    (void)x, (void)y;
    job->first[band + 1]++;
    for (int i = 0; i < count; i++)
        count_up(&job->mesh->first[labels[i] + 1]);
}

/* While rings are filled, first[label] is where the next corner goes; they are put in order later. */
static void add_vertex(const trace_job *job, int32_t band, int32_t x, int32_t y, const int32_t *labels, int count)
{
    pv_mesh *mesh = job->mesh;
    int32_t v = job->first[band]++;
    mesh->vertex[v] = (pv_point){ mesh->left + x, mesh->top + y };
    mesh->owner[v] = -1;
    for (int i = 0; i < count; i++)
        mesh->corner[count_up(&mesh->first[labels[i]])] = v;
}

static void count_band(void *data, int32_t band, int32_t worker)
{
    (void)worker;
    visit_band(data, band, count_vertex);
}

static void add_band(void *data, int32_t band, int32_t worker)
{
    (void)worker;
    visit_band(data, band, add_vertex);
}

/* A corner as seen from the mean of its ring, times the number of corners: exact in integers; y goes up. */
typedef struct spoke {
    int64_t x, y;
    int32_t vertex;
} spoke;

static int lower_half(const spoke *s)
{
    return !(s->y > 0 || (s->y == 0 && s->x > 0));
}

/* Does a come before b, counter-clockwise from the positive x axis? Nearer first, then by number, among equals. */
static int before(const spoke *a, const spoke *b)
{
    if (lower_half(a) != lower_half(b))
        return lower_half(a) < lower_half(b);
    int64_t turn = a->x * b->y - a->y * b->x;
    if (turn)
        return turn > 0;
    int64_t ra = a->x * a->x + a->y * a->y, rb = b->x * b->x + b->y * b->y;
    return ra != rb ? ra < rb : a->vertex < b->vertex;
}

static void sort_ring(const pv_mesh *mesh, int32_t *corner, int64_t count, spoke *spokes)
{
    int64_t sx = 0, sy = 0;
    for (int64_t i = 0; i < count; i++) {
        sx += (int64_t)mesh->vertex[corner[i]].x;
        sy += (int64_t)mesh->vertex[corner[i]].y;
    }
    for (int64_t i = 0; i < count; i++) {
        const pv_point *p = &mesh->vertex[corner[i]];
        spoke s = { (int64_t)p->x * count - sx, sy - (int64_t)p->y * count, corner[i] };
        int64_t at = i;
        for (; at > 0 && before(&s, &spokes[at - 1]); at--)
            spokes[at] = spokes[at - 1];
        spokes[at] = s;
    }
    for (int64_t i = 0; i < count; i++)
        corner[i] = spokes[i].vertex;
}

typedef struct sort_job {
    pv_mesh *mesh;
    spoke *spokes; /* room for the longest ring, for each worker */
    int64_t longest;
} sort_job;

static void sort_some(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const sort_job *job = data;
    pv_mesh *mesh = job->mesh;
    for (int32_t r = begin; r < end; r++)
        sort_ring(mesh, mesh->corner + mesh->first[r], mesh->first[r + 1] - mesh->first[r],
                  job->spokes + worker * job->longest);
}

static pave_result sort_rings(pave_context *context, pv_mesh *mesh)
{
    pave_result result = PAVE_OK;
    sort_job job = { mesh, NULL, 0 };
    for (int32_t r = 0; r < mesh->ring_count; r++) {
        int64_t count = mesh->first[r + 1] - mesh->first[r];
        job.longest = count > job.longest ? count : job.longest;
    }
    job.spokes = pv_allocate(context, (size_t)job.longest * (size_t)pv_workers(context), sizeof *job.spokes, &result);
    if (!result)
        result = pv_parallel_runs(context, mesh->ring_count, PV_RINGS, sort_some, &job, 0.35, 0.4);
    pv_release(job.spokes);
    return result;
}

static pave_result allocate_mesh(pave_context *context, pv_mesh *mesh)
{
    pave_result result = PAVE_OK;
    for (int32_t r = 0; r < mesh->ring_count; r++)
        mesh->first[r + 1] += mesh->first[r];
    mesh->vertex = pv_allocate(context, (size_t)mesh->vertex_count, sizeof *mesh->vertex, &result);
    if (!result)
        mesh->owner = pv_allocate(context, (size_t)mesh->vertex_count, sizeof *mesh->owner, &result);
    if (!result)
        mesh->low = pv_allocate(context, (size_t)mesh->vertex_count, sizeof *mesh->low, &result);
    if (!result)
        mesh->high = pv_allocate(context, (size_t)mesh->vertex_count, sizeof *mesh->high, &result);
    if (!result)
        mesh->corner = pv_allocate(context, (size_t)mesh->first[mesh->ring_count], sizeof *mesh->corner, &result);
    return result;
}

/* Finds all vertices: counts them, makes room, writes them. */
static pave_result find_vertices(pave_context *context, trace_job *job)
{
    pv_mesh *mesh = job->mesh;
    pave_result result = PAVE_OK;
    int32_t bands = job->cvd->height / job->rows + 1;
    job->first = pv_allocate_zeroed(context, (size_t)bands + 1, sizeof *job->first, &result);
    if (!result)
        result = pv_parallel(context, bands, count_band, job, 0, 0.2);
    for (int32_t band = 0; band < bands && !result; band++)
        job->first[band + 1] += job->first[band];
    if (!result) {
        mesh->vertex_count = job->first[bands];
        result = allocate_mesh(context, mesh);
    }
    if (!result)
        result = pv_parallel(context, bands, add_band, job, 0.2, 0.35);
    pv_release(job->first);
    return result;
}

pave_result pv_mesh_trace(pave_context *context, const pave_cvd *cvd, pv_mesh *mesh)
{
    pave_result result = PAVE_OK;
    memset(mesh, 0, sizeof *mesh);
    mesh->left = cvd->place.x;
    mesh->top = cvd->place.y;
    mesh->right = mesh->left + cvd->width;
    mesh->bottom = mesh->top + cvd->height;
    mesh->ring_count = cvd->site_count;
    mesh->first = pv_allocate_zeroed(context, (size_t)mesh->ring_count + 1, sizeof *mesh->first, &result);
    trace_job job = { cvd, mesh, (1 << 17) / cvd->width + 1, NULL };
    if (!result)
        result = find_vertices(context, &job);
    if (result)
        return result;
    memmove(mesh->first + 1, mesh->first, (size_t)mesh->ring_count * sizeof *mesh->first);
    mesh->first[0] = 0;
    return sort_rings(context, mesh);
}

void pv_mesh_free(pv_mesh *mesh)
{
    pv_release(mesh->vertex);
    pv_release(mesh->owner);
    pv_release(mesh->low);
    pv_release(mesh->high);
    pv_release(mesh->first);
    pv_release(mesh->corner);
    memset(mesh, 0, sizeof *mesh);
}
