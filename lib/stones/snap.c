/* Vertices moved to the edges of the drawing (III.C): all whose pixel has another colour than the centre of one of
 * their polygons go along the gradient of the distance until they are on the edge. */
#include "base/parallel.h"
#include "field/field.h"
#include "image/image.h"
#include "stones/stones.h"

#include <math.h>

enum { STEPS = 4 };

static int32_t clamp(int32_t v, int32_t high)
{
    return v < 0 ? 0 : v < high ? v : high - 1;
}

typedef struct terrain {
    const pave_image *drawing;
    const pave_field *field;
    uint8_t inside; /* the colour that counts as positive */
} terrain;

static double signed_distance(const terrain *t, int32_t x, int32_t y)
{
    x = clamp(x - t->field->place.x, t->field->width);
    y = clamp(y - t->field->place.y, t->field->height);
    int64_t at = (int64_t)y * t->field->width + x;
    double d = t->field->distance[at];
    return ((const uint8_t *)t->drawing->pixels)[at] == t->inside ? d : -d;
}

/* Signed distance between pixel centres, bilinear, with its gradient. 0 where it is not finite. */
static int sample(const terrain *t, pv_point p, double *d, double *gx, double *gy)
{
    double cx = p.x - 0.5, cy = p.y - 0.5, fx = cx - floor(cx), fy = cy - floor(cy);
    int32_t x = (int32_t)floor(cx), y = (int32_t)floor(cy);
    double nw = signed_distance(t, x, y), ne = signed_distance(t, x + 1, y);
    double sw = signed_distance(t, x, y + 1), se = signed_distance(t, x + 1, y + 1);
    *gx = (ne - nw) * (1 - fy) + (se - sw) * fy;
    *gy = (sw - nw) * (1 - fx) + (se - ne) * fx;
    *d = (nw * (1 - fx) + ne * fx) * (1 - fy) + (sw * (1 - fx) + se * fx) * fy;
    return isfinite(*d) && isfinite(*gx) && isfinite(*gy);
}

static double limit(double v, double low, double high)
{
    return v < low ? low : v < high ? v : high;
}

/* Newton's steps down the distance; vertices on the border of the plane stay on it, if it has one. */
static pv_point to_edge(const terrain *t, pv_point p)
{
    int repeats = t->field->params.periodic;
    double width = repeats ? INFINITY : t->drawing->place.width, height = repeats ? INFINITY : t->drawing->place.height;
    double least = repeats ? -INFINITY : 0;
    int fixed_x = p.x <= least || p.x >= width, fixed_y = p.y <= least || p.y >= height;
    for (int i = 0; i < STEPS; i++) {
        double d, gx, gy;
        if (!sample(t, p, &d, &gx, &gy))
            return p;
        gx = fixed_x ? 0 : gx;
        gy = fixed_y ? 0 : gy;
        double square = gx * gx + gy * gy;
        if (square < 0.05)
            return p;
        double way = -d / (square > 1 ? square : sqrt(square));
        p.x = limit(p.x + pv_way(way * gx), least, width);
        p.y = limit(p.y + pv_way(way * gy), least, height);
    }
    return p;
}

typedef struct snap_job {
    const pave_image *drawing;
    const pave_field *field;
    pv_mesh *mesh;
} snap_job;

static void snap_some(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    const snap_job *job = data;
    pv_mesh *mesh = job->mesh;
    for (int32_t v = begin; v < end; v++) {
        uint8_t here = pv_colour_at(job->drawing, mesh->vertex[v]);
        terrain t = { job->drawing, job->field, here };
        if (here != mesh->low[v] || here != mesh->high[v])
            mesh->vertex[v] = to_edge(&t, mesh->vertex[v]);
    }
}

pave_result pv_mesh_snap(pave_context *context, const pave_image *drawing, const pave_field *field, pv_mesh *mesh)
{
    snap_job job = { drawing, field, mesh };
    return pv_parallel_runs(context, mesh->vertex_count, PV_RINGS, snap_some, &job, 0.6, 0.7);
}
