/* Colours of cells, and the contour between them (III.C: "the color associated to the polygon's center of mass"). */
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

void pv_mesh_colour(const pave_image *drawing, pv_mesh *mesh)
{
    memset(mesh->low, 255, (size_t)mesh->vertex_count);
    memset(mesh->high, 0, (size_t)mesh->vertex_count);
    for (int32_t r = 0; r < mesh->ring_count; r++) {
        if (mesh->first[r] == mesh->first[r + 1])
            continue;
        uint8_t colour = pv_colour_at(drawing, ring_mean(mesh, r));
        for (int64_t i = mesh->first[r]; i < mesh->first[r + 1]; i++) {
            int32_t v = mesh->corner[i];
            mesh->low[v] = colour < mesh->low[v] ? colour : mesh->low[v];
            mesh->high[v] = colour > mesh->high[v] ? colour : mesh->high[v];
        }
    }
}
