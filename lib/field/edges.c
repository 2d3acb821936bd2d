/* First distances: pixels that touch a pixel of another colour (III.A). */
#include "base/parallel.h"
#include "field/field.h"

typedef struct edges_job {
    const pv_drawing *drawing;
    uint32_t *distance;
} edges_job;

enum { ROWS = 64 };

/* Does (x, y) differ from its neighbour? Outside the drawing nothing does. */
static int differs(const pv_drawing *drawing, int32_t x, int32_t y, int32_t dx, int32_t dy)
{
    int32_t nx = x + dx, ny = y + dy;
    if (nx < 0 || ny < 0 || nx >= drawing->width || ny >= drawing->height)
        return 0;
    return drawing->pixels[(int64_t)ny * drawing->width + nx] != drawing->pixels[(int64_t)y * drawing->width + x];
}

static uint32_t first_distance(const pv_drawing *d, int32_t x, int32_t y)
{
    if (differs(d, x, y, 1, 0) || differs(d, x, y, -1, 0) || differs(d, x, y, 0, 1) || differs(d, x, y, 0, -1))
        return PV_FIELD_ONE / 2;
    if (differs(d, x, y, 1, 1) || differs(d, x, y, -1, 1) || differs(d, x, y, 1, -1) || differs(d, x, y, -1, -1))
        return 46341; /* sqrt(2)/2 */
    return PV_FIELD_FAR;
}

static void edge_rows(void *data, int32_t band, int32_t worker)
{
    (void)worker;
    const edges_job *job = data;
    int32_t to = (band + 1) * ROWS < job->drawing->height ? (band + 1) * ROWS : job->drawing->height;
    for (int32_t y = band * ROWS; y < to; y++)
        for (int32_t x = 0; x < job->drawing->width; x++)
            job->distance[(int64_t)y * job->drawing->width + x] = first_distance(job->drawing, x, y);
}

pave_result pv_edges(pave_context *context, const pv_drawing *drawing, uint32_t *distance)
{
    edges_job job = { drawing, distance };
    return pv_parallel(context, (drawing->height + ROWS - 1) / ROWS, edge_rows, &job, 0, 0.3);
}
