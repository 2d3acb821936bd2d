/* Single stones (III.C): wide corners and small edges dropped, coloured, shrunk by the grout, and made valid. */
#include "base/parallel.h"
#include "cvd/cvd.h"
#include "image/image.h"
#include "stones/stones.h"

#include "util/polygon.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CORNERS = 256, LEAST_CORNERS = 4, GRID = 1000 };

typedef struct stone {
    int32_t count;
    pv_point p[MOST_CORNERS];
} stone;

static void drop(stone *s, int32_t i)
{
    s->count--;
    memmove(&s->p[i], &s->p[i + 1], (size_t)(s->count - i) * sizeof *s->p);
}

static pv_point corner(const stone *s, int32_t i)
{
    return s->p[(i + s->count) % s->count];
}

static double width_at(const stone *s, int32_t i)
{
    pv_point a = corner(s, i - 1), b = corner(s, i), c = corner(s, i + 1);
    return pv_corner_width(a.x, a.y, b.x, b.y, c.x, c.y);
}

/* The widest corner goes first. */
static void drop_wide_corners(stone *s, double limit)
{
    while (s->count > LEAST_CORNERS) {
        int32_t widest = -1;
        double width = limit;
        for (int32_t i = 0; i < s->count; i++)
            if (width_at(s, i) > width)
                width = width_at(s, i), widest = i;
        if (widest < 0)
            return;
        drop(s, widest);
    }
}

/* The smallest edge goes first, and of its ends the one with the wider angle. */
static void drop_small_edges(stone *s, double limit)
{
    while (s->count > LEAST_CORNERS) {
        int32_t smallest = -1;
        double square = limit * limit;
        for (int32_t i = 0; i < s->count; i++) {
            pv_point a = s->p[i], b = corner(s, i + 1);
            double d = (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y);
            if (d < square)
                square = d, smallest = i;
        }
        if (smallest < 0)
            return;
        int32_t other = (smallest + 1) % s->count;
        drop(s, width_at(s, smallest) >= width_at(s, other) ? smallest : other);
    }
}

static double area_of(const stone *s)
{
    double area = 0;
    for (int32_t i = 1; i + 1 < s->count; i++)
        area += pv_left_turn(s->p[0].x, s->p[0].y, s->p[i].x, s->p[i].y, s->p[i + 1].x, s->p[i + 1].y);
    return area / 2;
}

/* Centre of area; of the corners where there is no area to speak of. */
static pv_point centroid(const stone *s)
{
    double area = 0, x = 0, y = 0;
    pv_point o = s->p[0], mean = { 0, 0 };
    for (int32_t i = 0; i < s->count; i++) {
        pv_point a = s->p[i], b = corner(s, i + 1);
        double turn = pv_left_turn(o.x, o.y, a.x, a.y, b.x, b.y);
        area += turn;
        x += turn * (a.x + b.x + o.x);
        y += turn * (a.y + b.y + o.y);
        mean.x += a.x / s->count;
        mean.y += a.y / s->count;
    }
    return fabs(area) > 1e-9 ? (pv_point){ x / (3 * area), y / (3 * area) } : mean;
}

static int is_convex(const stone *s)
{
    for (int32_t i = 0; i < s->count; i++)
        if (width_at(s, i) > 1)
            return 0;
    return 1;
}

static stone moved_inwards(const stone *s, pv_point centre, double way)
{
    stone out = { .count = s->count };
    for (int32_t i = 0; i < s->count; i++) {
        double dx = centre.x - s->p[i].x, dy = centre.y - s->p[i].y, d = sqrt(dx * dx + dy * dy);
        double t = d > 0 ? way / d : 0;
        t = t < 0.5 ? t : 0.5;
        out.p[i] = (pv_point){ s->p[i].x + t * dx, s->p[i].y + t * dy };
    }
    return out;
}

static stone scaled(const stone *s, pv_point centre, double way)
{
    stone out = { .count = s->count };
    double mean = 0;
    for (int32_t i = 0; i < s->count; i++)
        mean += sqrt((centre.x - s->p[i].x) * (centre.x - s->p[i].x) +
                     (centre.y - s->p[i].y) * (centre.y - s->p[i].y)) / s->count;
    double t = mean > 0 ? way / mean : 0;
    t = t < 0.5 ? t : 0.5;
    for (int32_t i = 0; i < s->count; i++)
        out.p[i] = (pv_point){ s->p[i].x + t * (centre.x - s->p[i].x), s->p[i].y + t * (centre.y - s->p[i].y) };
    return out;
}

/* The text's shrink bends long stones inwards; those are scaled about their centre instead. */
static void shrink(stone *s, pv_point centre, double way)
{
    stone moved = moved_inwards(s, centre, way);
    *s = is_convex(s) && !is_convex(&moved) ? scaled(s, centre, way) : moved;
}

/* Onto the grid that all formats carry exactly, without repeated corners. 0 if it is not a number. */
static int to_grid(const stone *s, pv_cell *ring, int32_t *count)
{
    *count = 0;
    for (int32_t i = 0; i < s->count; i++) {
        if (!isfinite(s->p[i].x) || !isfinite(s->p[i].y))
            return 0;
        pv_cell c = { (int32_t)floor(s->p[i].x * GRID + 0.5), (int32_t)floor(s->p[i].y * GRID + 0.5) };
        if (*count && ring[*count - 1].x == c.x && ring[*count - 1].y == c.y)
            continue;
        ring[(*count)++] = c;
    }
    while (*count > 1 && ring[0].x == ring[*count - 1].x && ring[0].y == ring[*count - 1].y)
        --*count;
    return 1;
}

/* What the text can break (inverted, self-crossing) becomes its convex hull. Returns the corners that remain. */
static int32_t repair(pv_cell *ring, int32_t count, int32_t *repaired)
{
    pv_cell hull[MOST_CORNERS + 1];
    if (pv_ring_valid(ring, count))
        return count;
    ++*repaired;
    int32_t n = count < 3 ? 0 : pv_convex_hull(ring, count, hull);
    if (!pv_ring_valid(hull, n))
        return 0;
    memcpy(ring, hull, (size_t)n * sizeof *ring);
    return n;
}

typedef struct cut_limits {
    double drop_width, small_edge, half_grout;
} cut_limits;

/* The stone is where it was first drawn; as seen in the drawing it is a shift away. */
static int32_t cut_stone(const pave_image *drawing, const cut_limits *limits, pv_shift shift, stone *s, uint8_t *colour,
                         pv_cell *ring, int32_t *repaired)
{
    int32_t count;
    drop_wide_corners(s, limits->drop_width);
    drop_small_edges(s, limits->small_edge);
    pv_point centre = centroid(s);
    *colour = pv_colour_at(drawing, (pv_point){ floor(centre.x) + shift.x / 256, floor(centre.y) + shift.y / 256 });
    if (area_of(s) > 0)
        shrink(s, centre, limits->half_grout);
    if (!to_grid(s, ring, &count))
        return 0;
    return repair(ring, count, repaired);
}

/* Rings of broken cells can be longer than any stone: evenly thinned out. */
static void take_ring(const pv_mesh *mesh, int32_t r, pv_shift shift, stone *s)
{
    int64_t count = mesh->first[r + 1] - mesh->first[r];
    s->count = count < MOST_CORNERS ? (int32_t)count : MOST_CORNERS;
    for (int32_t i = 0; i < s->count; i++) {
        pv_point p = mesh->vertex[mesh->corner[mesh->first[r] + i * count / s->count]];
        s->p[i] = (pv_point){ p.x - shift.x / 256, p.y - shift.y / 256 };
    }
}

/* While stones are made, each has its corners where its ring has them; 0 corners: it is lost. */
typedef struct isolate_job {
    const pave_image *drawing;
    const pave_cvd *cvd;
    const pv_mesh *mesh;
    cut_limits limits;
    pave_stones *out;
    int32_t *corners;
    int32_t repaired;
} isolate_job;

static void isolate_ring(const isolate_job *job, int32_t r, int32_t *repaired)
{
    stone s;
    pv_cell ring[MOST_CORNERS];
    int64_t first = job->mesh->first[r];
    job->corners[r] = 0;
    if (!job->cvd->mine[r] || job->mesh->first[r + 1] - first < 3)
        return;
    pv_shift shift = job->cvd->shifts ? job->cvd->shifts[r] : (pv_shift){ 0, 0 };
    take_ring(job->mesh, r, shift, &s);
    int32_t count = cut_stone(job->drawing, &job->limits, shift, &s, &job->out->colours[r], ring, repaired);
    job->corners[r] = count;
    for (int32_t i = 0; i < count; i++) {
        job->out->vertices[2 * (first + i)] = (double)ring[i].x / GRID;
        job->out->vertices[2 * (first + i) + 1] = (double)ring[i].y / GRID;
    }
}

static void isolate_some(void *data, int32_t begin, int32_t end, int32_t worker)
{
    (void)worker;
    isolate_job *job = data;
    int32_t repaired = 0;
    for (int32_t r = begin; r < end; r++)
        isolate_ring(job, r, &repaired);
    __atomic_fetch_add(&job->repaired, repaired, __ATOMIC_RELAXED);
}

/* Moves the stones together, in the order of their sites. */
static void close_ranks(const isolate_job *job)
{
    pave_stones *out = job->out;
    for (int32_t r = 0; r < job->mesh->ring_count; r++) {
        int64_t at = out->starts[out->count], first = job->mesh->first[r], corners = job->corners[r];
        if (!corners)
            continue;
        memmove(out->vertices + 2 * at, out->vertices + 2 * first, 2 * (size_t)corners * sizeof *out->vertices);
        out->colours[out->count] = out->colours[r];
        out->sites[out->count] = job->cvd->numbers[r];
        out->starts[++out->count] = at + corners;
    }
}

pave_result pv_stones_isolate(pave_context *context, const pave_image *drawing, const pave_cvd *cvd,
                              const pv_mesh *mesh, pave_stones *out)
{
    cut_limits limits = { pv_width_of_degrees(out->params.drop_angle), out->params.small_edge * cvd->params.half_side,
                          out->params.grout / 2 };
    isolate_job job = { drawing, cvd, mesh, limits, out, NULL, 0 };
    size_t rings = (size_t)mesh->ring_count;
    pave_result result = pv_stones_allocate(context, rings, (size_t)mesh->first[mesh->ring_count], out);
    if (!result)
        job.corners = pv_allocate(context, (size_t)mesh->ring_count, sizeof *job.corners, &result);
    if (!result)
        result = pv_parallel_runs(context, mesh->ring_count, PV_RINGS, isolate_some, &job, 0.7, 0.95);
    if (!result)
        close_ranks(&job);
    out->report.repaired = job.repaired;
    pv_release(job.corners);
    return result;
}
