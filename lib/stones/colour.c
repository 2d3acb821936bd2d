/* Colours of cells, and the contour between them (III.C: "the color associated to the polygon's center of mass"). */
#include "base/parallel.h"
#include "image/image.h"
#include "stones/stones.h"

#include <math.h>
#include <string.h>

static int32_t clamp(int32_t v, int32_t high)
{
    return v < 0 ? 0 : v < high ? v : high - 1;
}

uint8_t pv_colour_at(const pave_image *drawing, pv_point p)
{
    int32_t x = clamp((int32_t)floor(p.x) - drawing->place.x, drawing->width);
    int32_t y = clamp((int32_t)floor(p.y) - drawing->place.y, drawing->height);
    return ((const uint8_t *)drawing->pixels)[(int64_t)y * drawing->width + x];
}

static pv_point ring_mean(const pv_mesh *mesh, int32_t r)
{
    pv_point sum = { 0, 0 };
    double count = (double)(mesh->first[r + 1] - mesh->first[r]);
    for (int64_t i = mesh->first[r]; i < mesh->first[r + 1]; i++) {
        sum.x += mesh->vertex[mesh->corner[i]].x;
        sum.y += mesh->vertex[mesh->corner[i]].y;
    }
    return (pv_point){ sum.x / count, sum.y / count };
}

typedef struct colour_job {
    const pave_image *drawing;
    pv_mesh *mesh;
} colour_job;

/* Rings share vertices, and so may threads. */
static void lower(uint8_t *least, uint8_t colour)
{
    uint8_t known = __atomic_load_n(least, __ATOMIC_RELAXED);
    while (colour < known &&
           !__atomic_compare_exchange_n(least, &known, colour, 1, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
        continue;
}

static void raise(uint8_t *greatest, uint8_t colour)
{
    uint8_t known = __atomic_load_n(greatest, __ATOMIC_RELAXED);
    while (colour > known &&
           !__atomic_compare_exchange_n(greatest, &known, colour, 1, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
        continue;
}

static void colour_some(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    const colour_job *job = data;
    pv_mesh *mesh = job->mesh;
    for (int32_t r = begin; r < end; r++) {
        if (mesh->first[r] == mesh->first[r + 1])
            continue;
        uint8_t colour = pv_colour_at(job->drawing, ring_mean(mesh, r));
        for (int64_t i = mesh->first[r]; i < mesh->first[r + 1]; i++) {
            lower(&mesh->low[mesh->corner[i]], colour);
            raise(&mesh->high[mesh->corner[i]], colour);
        }
    }
}

pave_result pv_mesh_colour(pave_context *context, const pave_image *drawing, double at, pv_mesh *mesh)
{
    colour_job job = { drawing, mesh };
    memset(mesh->low, 255, (size_t)mesh->vertex_count);
    memset(mesh->high, 0, (size_t)mesh->vertex_count);
    return pv_parallel_runs(context, mesh->ring_count, PV_RINGS, colour_some, &job, at, at);
}
