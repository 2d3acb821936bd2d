/* Which voxels lie inside a mesh. A closed surface is crossed by rays along x, on a grid of whole numbers that no ray
 * shares a corner with, so that a ray between two triangles meets exactly one of them; counting the crossings with
 * their signs gives the winding number. Of an open surface the generalised winding number is asked. */
#include "solid/surface.h"

#include "base/parallel.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FINE = 4096 }; /* steps a voxel */

typedef struct voxelizing {
    pave_context *context;
    const pave_mesh *mesh;
    pv_surface surface;
    pave_volume_params *place;
    int64_t voxels;
    int16_t *crossings; /* at the first voxel beyond each crossing: +1 or -1 */
    int32_t signs;      /* crossings count with their sign */
    uint8_t *states;
    pv_winding *winding;
    int tangled; /* a winding number other than 0, 1 or 0, -1 */
} voxelizing;

static pave_result place_grid(voxelizing *v, int32_t resolution)
{
    double least[3] = { INFINITY, INFINITY, INFINITY }, most[3] = { -INFINITY, -INFINITY, -INFINITY }, longest = 0;
    for (int64_t i = 0; i < v->surface.count * 3; i++)
        for (int k = 0; k < 3; k++) {
            double c = v->mesh->vertices[3 * (size_t)v->surface.triangles[i] + (size_t)k];
            least[k] = fmin(least[k], c);
            most[k] = fmax(most[k], c);
        }
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, most[k] - least[k]);
    if (!(longest > 0) || !isfinite(longest) || !(longest / resolution > 0))
        return pv_fail(v->context, PAVE_ERR_FORMAT, "the mesh has no extent");
    pave_volume_params *p = v->place;
    int32_t *size[3] = { &p->width, &p->height, &p->depth };
    p->spacing = longest / resolution;
    for (int k = 0; k < 3; k++) {
        double n = ceil((most[k] - least[k]) / p->spacing - 1e-9);
        *size[k] = n < 1 ? 1 : (int32_t)n;
        p->origin[k] = (least[k] + most[k]) / 2 - (*size[k] - 1) * p->spacing / 2;
    }
    v->voxels = (int64_t)p->width * p->height * p->depth;
    if (v->voxels > UINT32_MAX || v->voxels * 16 > v->context->limits.max_bytes)
        return pv_fail(v->context, PAVE_ERR_LIMIT, "%d x %d x %d voxels need more than the limit of %lld bytes",
                       (int)p->width, (int)p->height, (int)p->depth, (long long)v->context->limits.max_bytes);
    return PAVE_OK;
}

/* A vertex in fine steps, y and z even: rays run along odd ones. */
static void fine_place(const voxelizing *v, int32_t vertex, int64_t out[3])
{
    for (int k = 0; k < 3; k++) {
        double voxel = (v->mesh->vertices[3 * (size_t)vertex + (size_t)k] - v->place->origin[k]) / v->place->spacing;
        out[k] = 2 * (int64_t)floor(voxel * (FINE / 2) + 0.5);
    }
}

/* Does the ray at (y, z) pass on the far side of an edge's line? The ends are ordered, so that both triangles agree. */
static int beyond_edge(const int64_t *a, const int64_t *b, int64_t y, int64_t z)
{
    if ((a[2] < z) == (b[2] < z))
        return 0;
    if (a[2] > b[2] || (a[2] == b[2] && a[1] > b[1])) {
        const int64_t *swap = a;
        a = b, b = swap;
    }
    return (b[1] - a[1]) * (z - a[2]) - (y - a[1]) * (b[2] - a[2]) > 0;
}

static void cross_row(voxelizing *v, int64_t corner[3][3], int32_t y, int32_t z)
{
    int64_t ry = (int64_t)y * FINE + 1, rz = (int64_t)z * FINE + 1;
    int hit = 0;
    for (int k = 0; k < 3; k++)
        hit ^= beyond_edge(corner[k], corner[(k + 1) % 3], ry, rz);
    if (!hit)
        return;
    double e[3], f[3];
    for (int k = 0; k < 3; k++) {
        e[k] = (double)(corner[1][k] - corner[0][k]);
        f[k] = (double)(corner[2][k] - corner[0][k]);
    }
    double nx = e[1] * f[2] - e[2] * f[1], ny = e[2] * f[0] - e[0] * f[2], nz = e[0] * f[1] - e[1] * f[0];
    if (nx == 0)
        return;
    double x = (double)corner[0][0] - (ny * (double)(ry - corner[0][1]) + nz * (double)(rz - corner[0][2])) / nx;
    double first = ceil(x / FINE);
    if (first >= v->place->width)
        return;
    int64_t at = ((int64_t)z * v->place->height + y) * v->place->width + (first > 0 ? (int64_t)first : 0);
    v->crossings[at] = (int16_t)(v->crossings[at] + (v->signs && nx > 0 ? -1 : 1));
}

static int32_t clamp(int64_t v, int32_t size)
{
    return v < 0 ? 0 : v >= size ? size - 1 : (int32_t)v;
}

static int64_t row_of(int64_t fine)
{
    return fine >= 0 ? fine / FINE : -1;
}

static void cross_triangle(voxelizing *v, int64_t triangle)
{
    int64_t corner[3][3], low[3], high[3];
    for (int c = 0; c < 3; c++)
        fine_place(v, v->surface.triangles[3 * triangle + c], corner[c]);
    for (int k = 1; k < 3; k++) {
        low[k] = high[k] = corner[0][k];
        for (int c = 1; c < 3; c++) {
            low[k] = corner[c][k] < low[k] ? corner[c][k] : low[k];
            high[k] = corner[c][k] > high[k] ? corner[c][k] : high[k];
        }
    }
    for (int32_t z = clamp(row_of(low[2]), v->place->depth); z <= clamp(row_of(high[2]), v->place->depth); z++)
        for (int32_t y = clamp(row_of(low[1]), v->place->height); y <= clamp(row_of(high[1]), v->place->height); y++)
            cross_row(v, corner, y, z);
}

static void fill_rows(voxelizing *v)
{
    int least = 0, most = 0;
    for (int64_t row = 0; row < v->voxels; row += v->place->width)
        for (int64_t i = row, sum = 0; i < row + v->place->width; i++) {
            sum += v->crossings[i];
            least = sum < least ? (int)sum : least;
            most = sum > most ? (int)sum : most;
            v->states[i] = (v->signs ? sum != 0 : sum & 1) ? PAVE_VOXEL_FREE : PAVE_VOXEL_OUTSIDE;
        }
    v->tangled = v->signs && (most > 1 || least < -1 || (most > 0 && least < 0));
}

static pave_result fill_closed(voxelizing *v)
{
    enum { BATCH = 4096 };
    pave_result result = PAVE_OK;
    v->signs = v->surface.turned_edges == 0;
    v->crossings = pv_allocate_zeroed(v->context, (size_t)v->voxels, sizeof *v->crossings, &result);
    for (int64_t t = 0; t < v->surface.count && v->crossings && !result; t++) {
        cross_triangle(v, t);
        if (t % BATCH == 0)
            result = pv_progress(v->context, 0);
    }
    if (v->crossings && !result)
        fill_rows(v);
    pv_release(v->crossings);
    return result;
}

static void wind_row(void *data, int32_t row, int32_t worker)
{
    (void)worker;
    voxelizing *v = data;
    const pave_volume_params *p = v->place;
    uint8_t *state = v->states + (int64_t)row * p->width;
    for (int32_t x = 0; x < p->width; x++) {
        const double point[3] = { p->origin[0] + x * p->spacing, p->origin[1] + row % p->height * p->spacing,
                                  p->origin[2] + row / p->height * p->spacing };
        state[x] = fabs(pv_winding_number(v->winding, point)) > 0.5 ? PAVE_VOXEL_FREE : PAVE_VOXEL_OUTSIDE;
    }
}

static pave_result fill_open(voxelizing *v)
{
    pave_result result = pv_winding_create(v->context, v->mesh->vertices, &v->surface, &v->winding);
    if (!result)
        result = pv_parallel(v->context, v->place->height * v->place->depth, wind_row, v, 0, 0);
    pv_winding_free(v->winding);
    return result;
}

static void describe(const voxelizing *v, char shape[96])
{
    long long open = (long long)v->surface.open_edges;
    if (open)
        snprintf(shape, 96, "generalised winding number: %lld edges with one side", open);
    else if (v->tangled)
        snprintf(shape, 96, "winding number: closed, with shells that overlap");
    else
        snprintf(shape, 96, "parity: closed%s", v->signs ? "" : ", but not all triangles turned alike");
}

static pave_result fill(voxelizing *v, int32_t resolution, char shape[96])
{
    pave_result result = place_grid(v, resolution);
    if (!result)
        v->states = pv_allocate(v->context, (size_t)v->voxels, 1, &result);
    if (!result)
        result = v->surface.open_edges ? fill_open(v) : fill_closed(v);
    if (result)
        return result;
    describe(v, shape);
    pv_note(v->context, PAVE_MESSAGE_INFO, "inside of the mesh by %s", shape);
    if (!memchr(v->states, PAVE_VOXEL_FREE, (size_t)v->voxels))
        return pv_fail(v->context, PAVE_ERR_FORMAT, "the mesh encloses no voxel (%s)", shape);
    return PAVE_OK;
}

pave_result pv_voxelize(pave_context *context, const pave_mesh *mesh, int32_t resolution, pave_volume_params *place,
                        uint8_t **states, char shape[96])
{
    voxelizing v = { .context = context, .mesh = mesh, .place = place };
    pave_result result = pv_surface_create(context, mesh, &v.surface);
    if (!result && !v.surface.count)
        result = pv_fail(context, PAVE_ERR_FORMAT, "the mesh has only triangles without area");
    if (!result)
        result = fill(&v, resolution, shape);
    pv_surface_free(&v.surface);
    if (result) {
        pv_release(v.states);
        v.states = NULL;
    }
    *states = v.states;
    return result;
}
