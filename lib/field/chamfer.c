/* Quasi-Euclidean 3x3 chamfer distance transform (III.A). Sums are integers, so a distance depends on nothing
 * but the edges around it: not on the order of passes, nor on what lies beyond.
 *
 * A shortest path from an edge to a pixel has steps of at most two kinds, whose order is free: straight ones along the
 * row and diagonal ones, all up or all down; or vertical ones and such diagonals. So all rows are filled in along
 * themselves first, each alone; then each row takes what comes down to it, and what comes up.
 *
 * The passes down and up commute, too: one thread goes down through the upper half while another goes up through the
 * lower half, and from the middle each goes on through the other half. More threads would have nothing to do, but
 * memory is what limits these passes.
 *
 * Where the borders meet, no path is longer than half a turn: a second round finds all that the first did not. */
#include "base/parallel.h"
#include "field/field.h"

/* The next row to fill in, where to go from there, how many rows are left. */
typedef struct march {
    int32_t row, step, left;
} march;

typedef struct chamfer_job {
    const pv_drawing *drawing;
    pv_steps steps;
    int32_t *distance;
    march march[2];
    int32_t stride; /* rows of a march at a time */
} chamfer_job;

static inline int32_t least(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* The lesser of `here` and `there + way`; PV_FIELD_FAR is not exceeded. */
static inline int32_t nearer(int32_t here, int32_t there, int32_t way)
{
    return least(here - way, there) + way;
}

static int32_t *row_of(const chamfer_job *job, int32_t y)
{
    return job->distance + (int64_t)y * job->drawing->width;
}

/* From the left and from the right at once. Each pixel waits for the one before; the two ways, whose order does not
 * matter either, do not wait for each other. */
static void along_row(int32_t *row, int32_t width, int32_t straight, int32_t rounds)
{
    int32_t before = PV_FIELD_FAR, after = PV_FIELD_FAR;
    for (; rounds > 0; rounds--)
        for (int32_t x = 0, back = width - 1; x < width; x++, back--) {
            row[x] = before = nearer(row[x], before, straight);
            row[back] = after = nearer(row[back], after, straight);
        }
}

/* First distances, and what spreads along each row while it is in the cache. */
static void start_rows(void *data, int32_t band, int32_t worker)
{
    (void)worker;
    const chamfer_job *job = data;
    int32_t rows = pv_band_rows(job->drawing->width), y = band * rows;
    for (int32_t to = least(y + rows, job->drawing->height); y < to; y++) {
        pv_edge_row(job->drawing, y, row_of(job, y));
        along_row(row_of(job, y), job->drawing->width, job->steps.straight, 1 + job->drawing->wraps);
    }
}

/* What a row inherits from the row beside it, straight and diagonally. */
static void from_row(const chamfer_job *job, int32_t to, int32_t from)
{
    int32_t *restrict row = row_of(job, to), last = job->drawing->width - 1;
    const int32_t *restrict beside = row_of(job, from);
    pv_steps steps = job->steps;
    for (int32_t x = 1; x < last; x++) {
        int32_t aside = least(beside[x - 1], beside[x + 1]);
        row[x] = nearer(nearer(row[x], beside[x], steps.straight), aside, steps.diagonal);
    }
    row[0] = nearer(row[0], beside[0], steps.straight);
    row[last] = nearer(row[last], beside[last], steps.straight);
    if (last) {
        row[0] = nearer(row[0], beside[1], steps.diagonal);
        row[last] = nearer(row[last], beside[last - 1], steps.diagonal);
    }
    if (job->drawing->wraps) {
        row[0] = nearer(row[0], beside[last], steps.diagonal);
        row[last] = nearer(row[last], beside[0], steps.diagonal);
    }
}

static void advance(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    chamfer_job *job = data;
    march *m = &job->march[index];
    for (int32_t n = least(m->left, job->stride); n > 0; n--, m->left--, m->row += m->step)
        from_row(job, m->row, m->row - m->step);
}

static pave_result march_both(pave_context *context, chamfer_job *job, march down, march up, double from, double to)
{
    pave_result result = PAVE_OK;
    int32_t most = down.left > up.left ? down.left : up.left;
    job->march[0] = down;
    job->march[1] = up;
    for (int32_t done = 0; done < most && !result; done += job->stride)
        result = pv_parallel(context, 2, advance, job, from + (to - from) * done / most,
                             from + (to - from) * done / most);
    return result;
}

/* All the way down, and all the way up. */
static pave_result march_through(pave_context *context, chamfer_job *job, double from, double to)
{
    int32_t height = job->drawing->height, upper = height / 2, lower = height - upper;
    double middle = (from + to) / 2;
    march down = { 1, 1, upper - 1 }, up = { height - 2, -1, lower - 1 };
    pave_result result = march_both(context, job, down, up, from, middle);
    if (result || !upper)
        return result;
    from_row(job, upper, upper - 1);
    from_row(job, upper - 1, upper);
    down = (march){ upper + 1, 1, lower - 1 };
    up = (march){ upper - 2, -1, upper - 1 };
    return march_both(context, job, down, up, middle, to);
}

pave_result pv_chamfer(pave_context *context, const pv_drawing *drawing, pv_steps steps, int32_t *distance)
{
    int32_t width = drawing->width, height = drawing->height;
    chamfer_job job = { drawing, steps, distance, .stride = 4 * pv_band_rows(width) };
    pave_result result = pv_parallel(context, pv_bands(width, height), start_rows, &job, 0, 0.5);
    if (!result)
        result = march_through(context, &job, 0.5, drawing->wraps ? 0.7 : 0.9);
    if (result || !drawing->wraps)
        return result;
    if (height > 1) {
        from_row(&job, 0, height - 1);
        from_row(&job, height - 1, 0);
    }
    return march_through(context, &job, 0.7, 0.9);
}
