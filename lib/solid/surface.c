/* Meshes: storage, and whether they are closed. */
#include "solid/surface.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

pave_result pave_mesh_create(pave_context *context, const double *vertices, int64_t vertex_count,
                             const int32_t *triangles, int64_t triangle_count, pave_mesh **out)
{
    pave_result result = PAVE_OK;
    if (out)
        *out = NULL;
    if (!context || !vertices || !triangles || !out)
        return PAVE_ERR_ARGUMENT;
    if (vertex_count < 3 || vertex_count > INT32_MAX || triangle_count < 1 || triangle_count > INT32_MAX)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a mesh of %lld vertices and %lld triangles has no surface",
                       (long long)vertex_count, (long long)triangle_count);
    for (int64_t i = 0; i < 3 * vertex_count; i++)
        if (!isfinite(vertices[i]))
            return pv_fail(context, PAVE_ERR_ARGUMENT, "vertex %lld of the mesh is not finite", (long long)(i / 3));
    for (int64_t i = 0; i < 3 * triangle_count; i++)
        if (triangles[i] < 0 || triangles[i] >= vertex_count)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "triangle %lld of the mesh has vertex %d of %lld",
                           (long long)(i / 3), (int)triangles[i], (long long)vertex_count);
    pave_mesh *mesh = *out = pv_allocate_zeroed(context, 1, sizeof *mesh, &result);
    if (!mesh)
        return result;
    mesh->vertex_count = vertex_count;
    mesh->triangle_count = triangle_count;
    mesh->vertices = pv_allocate(context, (size_t)vertex_count * 3, sizeof *vertices, &result);
    mesh->triangles = result ? NULL : pv_allocate(context, (size_t)triangle_count * 3, sizeof *triangles, &result);
    if (result)
        return pave_mesh_free(out), result;
    memcpy(mesh->vertices, vertices, (size_t)vertex_count * 3 * sizeof *vertices);
    memcpy(mesh->triangles, triangles, (size_t)triangle_count * 3 * sizeof *triangles);
    return PAVE_OK;
}

void pave_mesh_free(pave_mesh **mesh)
{
    if (!mesh || !*mesh)
        return;
    pv_release((*mesh)->vertices);
    pv_release((*mesh)->triangles);
    pv_release(*mesh);
    *mesh = NULL;
}

int64_t pave_mesh_vertex_count(const pave_mesh *mesh) { return mesh->vertex_count; }
int64_t pave_mesh_triangle_count(const pave_mesh *mesh) { return mesh->triangle_count; }
const double *pave_mesh_vertices(const pave_mesh *mesh) { return mesh->vertices; }
const int32_t *pave_mesh_triangles(const pave_mesh *mesh) { return mesh->triangles; }

typedef struct corner {
    double at[3];
    int32_t vertex;
} corner;

static int by_place(const void *a, const void *b)
{
    const corner *p = a, *q = b;
    for (int k = 0; k < 3; k++)
        if (p->at[k] != q->at[k])
            return p->at[k] < q->at[k] ? -1 : 1;
    return p->vertex < q->vertex ? -1 : p->vertex > q->vertex;
}

static int same_place(const corner *a, const corner *b)
{
    return a->at[0] == b->at[0] && a->at[1] == b->at[1] && a->at[2] == b->at[2];
}

/* first[vertex]: the lowest vertex at the same place. */
static pave_result merge(pave_context *context, const pave_mesh *mesh, int32_t *first)
{
    pave_result result = PAVE_OK;
    corner *corners = pv_allocate(context, (size_t)mesh->vertex_count, sizeof *corners, &result);
    if (!corners)
        return result;
    for (int64_t i = 0; i < mesh->vertex_count; i++) {
        for (int k = 0; k < 3; k++)
            corners[i].at[k] = mesh->vertices[3 * i + k] + 0.0; /* -0 is 0 */
        corners[i].vertex = (int32_t)i;
    }
    qsort(corners, (size_t)mesh->vertex_count, sizeof *corners, by_place);
    for (int64_t i = 0, lead = 0; i < mesh->vertex_count; i++) {
        if (!same_place(&corners[i], &corners[lead]))
            lead = i;
        first[corners[i].vertex] = corners[lead].vertex;
    }
    pv_release(corners);
    return PAVE_OK;
}

typedef struct edge {
    int32_t low, high, forward;
} edge;

static int by_ends(const void *a, const void *b)
{
    const edge *p = a, *q = b;
    if (p->low != q->low)
        return p->low < q->low ? -1 : 1;
    return p->high < q->high ? -1 : p->high > q->high;
}

static pave_result judge_edges(pave_context *context, pv_surface *s)
{
    pave_result result = PAVE_OK;
    int64_t n = 3 * s->count;
    edge *edges = pv_allocate(context, (size_t)n, sizeof *edges, &result);
    if (!edges)
        return result;
    for (int64_t i = 0; i < n; i++) {
        int32_t a = s->triangles[i], b = s->triangles[i / 3 * 3 + (i + 1) % 3];
        edges[i] = a < b ? (edge){ a, b, 1 } : (edge){ b, a, 0 };
    }
    qsort(edges, (size_t)n, sizeof *edges, by_ends);
    for (int64_t i = 0, end; i < n; i = end) {
        int64_t forward = 0;
        for (end = i; end < n && !by_ends(&edges[i], &edges[end]); end++)
            forward += edges[end].forward;
        s->open_edges += (end - i) % 2;
        s->crowded_edges += end - i > 2;
        s->turned_edges += (end - i) % 2 == 0 && 2 * forward != end - i;
    }
    pv_release(edges);
    return PAVE_OK;
}

pave_result pv_surface_create(pave_context *context, const pave_mesh *mesh, pv_surface *s)
{
    pave_result result = PAVE_OK;
    memset(s, 0, sizeof *s);
    int32_t *first = pv_allocate(context, (size_t)mesh->vertex_count, sizeof *first, &result);
    if (first)
        s->triangles = pv_allocate(context, (size_t)mesh->triangle_count * 3, sizeof *s->triangles, &result);
    if (s->triangles)
        result = merge(context, mesh, first);
    for (int64_t i = 0; i < mesh->triangle_count && s->triangles && !result; i++) {
        const int32_t *t = mesh->triangles + 3 * i;
        int32_t *to = s->triangles + 3 * s->count;
        for (int k = 0; k < 3; k++)
            to[k] = first[t[k]];
        s->count += to[0] != to[1] && to[1] != to[2] && to[2] != to[0];
    }
    pv_release(first);
    if (s->triangles && !result)
        result = judge_edges(context, s);
    return result;
}

void pv_surface_free(pv_surface *surface)
{
    pv_release(surface->triangles);
    memset(surface, 0, sizeof *surface);
}
