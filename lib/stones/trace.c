/* From labels to polygons: where three or four labels meet there is a vertex; around each label its vertices are put
 * in order by their angle at the vertices' mean (III.C; cells are assumed to be star-shaped). */
#include "cvd/cvd.h"
#include "stones/stones.h"

#include <string.h>

/* The labels around lattice point (x, y) without repetition; up to four of them, none outside the image. */
static int labels_around(const pave_cvd *cvd, int32_t x, int32_t y, int32_t *labels)
{
    int count = 0;
    for (int k = 0; k < 4; k++) {
        int32_t px = x - 1 + (k & 1), py = y - 1 + (k >> 1);
        if (px < 0 || py < 0 || px >= pv_cvd_columns(cvd) || py >= pv_cvd_rows(cvd))
            continue;
        int32_t label = cvd->labels[(int64_t)py * pv_cvd_columns(cvd) + px];
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
    int borders = (x == 0 || x == pv_cvd_columns(cvd)) + (y == 0 || y == pv_cvd_rows(cvd));
    return count >= 3 - borders;
}

typedef void vertex_visit(pv_mesh *mesh, int32_t x, int32_t y, const int32_t *labels, int count);

static pave_result visit_vertices(pave_context *context, const pave_cvd *cvd, pv_mesh *mesh, vertex_visit *visit,
                                  double from, double to)
{
    pave_result result = PAVE_OK;
    for (int32_t y = 0; y <= pv_cvd_rows(cvd) && !result; y++) {
        for (int32_t x = 0; x <= pv_cvd_columns(cvd); x++) {
            int32_t labels[4];
            int count = labels_around(cvd, x, y, labels);
            if (is_vertex(cvd, x, y, count))
                visit(mesh, x, y, labels, count);
        }
        if (y % 64 == 0)
            result = pv_progress(context, from + (to - from) * y / pv_cvd_rows(cvd));
    }
    return result;
}

static void count_vertex(pv_mesh *mesh, int32_t x, int32_t y, const int32_t *labels, int count)
{
    (void)x, (void)y;
    mesh->vertex_count++;
    for (int i = 0; i < count; i++)
        mesh->first[labels[i] + 1]++;
}

/* While rings are filled, first[label] is where the next corner goes. */
static void add_vertex(pv_mesh *mesh, int32_t x, int32_t y, const int32_t *labels, int count)
{
    int32_t v = mesh->vertex_count++;
    mesh->vertex[v] = (pv_point){ mesh->left + x, mesh->top + y };
    mesh->owner[v] = -1;
    for (int i = 0; i < count; i++)
        mesh->corner[mesh->first[labels[i]]++] = v;
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

static pave_result sort_rings(pave_context *context, pv_mesh *mesh)
{
    pave_result result = PAVE_OK;
    int64_t longest = 0;
    for (int32_t r = 0; r < mesh->ring_count; r++) {
        int64_t count = mesh->first[r + 1] - mesh->first[r];
        longest = count > longest ? count : longest;
    }
    spoke *spokes = pv_allocate(context, (size_t)longest, sizeof *spokes, &result);
    for (int32_t r = 0; r < mesh->ring_count && spokes; r++)
        sort_ring(mesh, mesh->corner + mesh->first[r], mesh->first[r + 1] - mesh->first[r], spokes);
    pv_release(spokes);
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

/* From the diagram's pixels to those of the drawing. */
static void to_pixels(int32_t scale, pv_mesh *mesh)
{
    mesh->left /= scale;
    mesh->top /= scale;
    mesh->right /= scale;
    mesh->bottom /= scale;
    for (int32_t v = 0; v < mesh->vertex_count; v++) {
        mesh->vertex[v].x /= scale;
        mesh->vertex[v].y /= scale;
    }
}

pave_result pv_mesh_trace(pave_context *context, const pave_cvd *cvd, pv_mesh *mesh)
{
    pave_result result;
    memset(mesh, 0, sizeof *mesh);
    mesh->left = cvd->scale * cvd->place.x;
    mesh->top = cvd->scale * cvd->place.y;
    mesh->right = mesh->left + pv_cvd_columns(cvd);
    mesh->bottom = mesh->top + pv_cvd_rows(cvd);
    mesh->ring_count = cvd->site_count;
    mesh->first = pv_allocate_zeroed(context, (size_t)mesh->ring_count + 1, sizeof *mesh->first, &result);
    if (!mesh->first)
        return result;
    result = visit_vertices(context, cvd, mesh, count_vertex, 0, 0.2);
    if (!result)
        result = allocate_mesh(context, mesh);
    mesh->vertex_count = 0;
    if (!result)
        result = visit_vertices(context, cvd, mesh, add_vertex, 0.2, 0.4);
    if (result)
        return result;
    memmove(mesh->first + 1, mesh->first, (size_t)mesh->ring_count * sizeof *mesh->first);
    mesh->first[0] = 0;
    result = sort_rings(context, mesh);
    to_pixels(cvd->scale, mesh);
    return result;
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
