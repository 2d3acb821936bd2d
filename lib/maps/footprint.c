/* Footprints: rings of corners that solids can stand on, and rings inside of them. */
#include "maps/model.h"

#include "base/parallel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RUN = 64, TRIES = 10 };
static const double flat = 0.01;        /* px: a corner nearer to its neighbours' line is none */
static const double least_bevel = 0.02; /* px */

static double way(pv_cell a, pv_cell b)
{
    double x = pv_fine(b.x - a.x), y = pv_fine(b.y - a.y);
    return sqrt(x * x + y * y);
}

static int is_flat(pv_cell a, pv_cell b, pv_cell c)
{
    double across = way(a, c), off = fabs((double)pv_cell_turn(a, b, c)) / (1000.0 * PV_FINE) / (1000.0 * PV_FINE);
    return way(a, b) < flat || way(b, c) < flat || across < flat || off < flat * across;
}

/* Drops corners until each is one. */
static int32_t tidy(pv_cell *ring, int32_t count)
{
    for (int32_t i = 0, kept = 0; kept < count && count >= 3;) {
        i %= count;
        if (is_flat(ring[(i + count - 1) % count], ring[i], ring[(i + 1) % count])) {
            memmove(&ring[i], &ring[i + 1], (size_t)(count - 1 - i) * sizeof *ring);
            count--;
            kept = 0;
        } else {
            kept++;
            i++;
        }
    }
    return count;
}

void pv_footprint_normal(const pv_cell *ring, int32_t corners, int32_t i, double out[2])
{
    pv_cell a = ring[i], b = ring[i + 1 < corners ? i + 1 : 0];
    double x = pv_fine(b.x - a.x), y = pv_fine(b.y - a.y), length = sqrt(x * x + y * y);
    out[0] = -y / length;
    out[1] = x / length;
}

void pv_footprint_corner(const pv_cell *ring, int32_t corners, int32_t i, double inset, double out[2])
{
    double a[2], b[2];
    pv_footprint_normal(ring, corners, i ? i - 1 : corners - 1, a);
    pv_footprint_normal(ring, corners, i, b);
    double share = inset / fmax(1 + a[0] * b[0] + a[1] * b[1], 0.01);
    out[0] = pv_fine(ring[i].x) - (a[0] + b[0]) * share;
    out[1] = pv_fine(ring[i].y) - (a[1] + b[1]) * share;
}

/* Sides keep their direction, and something of their length. */
static int sides_keep(const pv_cell *ring, const pv_cell *inner, int32_t corners)
{
    for (int32_t i = 0; i < corners; i++) {
        int32_t j = i + 1 < corners ? i + 1 : 0;
        double x = pv_fine(ring[j].x - ring[i].x), y = pv_fine(ring[j].y - ring[i].y);
        double u = pv_fine(inner[j].x - inner[i].x), v = pv_fine(inner[j].y - inner[i].y);
        if (x * u + y * v < 0.05 * (x * x + y * y) || way(inner[i], inner[j]) < 2 * flat)
            return 0;
    }
    return 1;
}

int pv_footprint_inset(const pv_cell *ring, int32_t corners, double inset, pv_cell *out)
{
    for (int32_t i = 0; i < corners; i++) {
        double at[2];
        pv_footprint_corner(ring, corners, i, inset, at);
        if (!(fabs(at[0]) < 16000) || !(fabs(at[1]) < 16000))
            return 0;
        out[i] = (pv_cell){ (int32_t)floor(at[0] * 1000 * PV_FINE + 0.5),
                            (int32_t)floor(at[1] * 1000 * PV_FINE + 0.5) };
    }
    return sides_keep(ring, out, corners) && pv_ring_valid(out, corners) &&
           pv_ring_inside(ring, corners, out, corners);
}

/* The largest rounding, up to the one asked for, whose rings all lie in one another. */
static double fit_bevel(const pv_modelling *m, const pv_cell *ring, int32_t corners, pv_cell *work)
{
    double bevel = m->bed->bevel;
    for (int i = 0; i < TRIES && bevel > least_bevel; i++, bevel *= 0.7) {
        const pv_cell *outer = ring;
        int fits = 1;
        for (int32_t k = 1; k <= m->params.segments && fits; k++) {
            pv_cell *inner = work + (k % 2 ? 0 : corners);
            fits = pv_footprint_inset(ring, corners, bevel * (1 - m->cosine[k]), inner) &&
                   (k == 1 || pv_ring_inside(outer, corners, inner, corners));
            outer = inner;
        }
        if (fits)
            return bevel;
    }
    return 0;
}

static void reverse(pv_cell *ring, int32_t count)
{
    for (int32_t i = 0; 2 * i < count - 1; i++) {
        pv_cell swap = ring[i];
        ring[i] = ring[count - 1 - i];
        ring[count - 1 - i] = swap;
    }
}

/* The lowest that the upper end of a stone's sides gets. */
static double lowest_rim(const pv_modelling *m, int32_t s, const pv_cell *ring, const pv_footprint *o)
{
    double least = INFINITY;
    for (int32_t i = 0; i < o->corners; i++) {
        double at[2];
        pv_model_place(m, s, pv_fine(ring[i].x), pv_fine(ring[i].y), at);
        double z = pv_stone_plane(m->bed, &m->bed->laid[s], at[0], at[1]) - o->bevel;
        least = z < least ? z : least;
    }
    return least;
}

typedef struct tracing {
    pv_modelling *m;
    pv_cell *work; /* two rings for each worker */
} tracing;

static void make_footprints(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const tracing *job = data;
    const pv_modelling *m = job->m;
    const double *v = m->bed->stones->vertices;
    for (int32_t s = begin; s < end; s++) {
        const pv_laid *laid = &m->bed->laid[s];
        pv_cell *ring = m->corner + laid->first;
        pv_footprint *o = &m->footprint[s];
        *o = (pv_footprint){ .first = laid->first };
        for (int64_t i = 0; i < laid->corners; i++) {
            const double *at = v + 2 * (laid->first + i), *from = v + 2 * laid->first;
            ring[i].x = PV_FINE * (int32_t)floor((at[0] - from[0]) * 1000 + 0.5);
            ring[i].y = PV_FINE * (int32_t)floor((at[1] - from[1]) * 1000 + 0.5);
        }
        if (laid->corners >= 3 && pv_ring_area(ring, laid->corners) < 0)
            reverse(ring, laid->corners);
        o->corners = laid->corners >= 3 && pv_ring_valid(ring, laid->corners) ? tidy(ring, laid->corners) : 0;
        if (o->corners < 3 || !pv_ring_valid(ring, o->corners)) {
            o->corners = 0;
            continue;
        }
        if (m->params.segments)
            o->bevel = fit_bevel(m, ring, o->corners, job->work + 2 * (int64_t)worker * m->most_corners);
        o->segments = o->bevel > 0 ? m->params.segments : 0;
        double rim = lowest_rim(m, s, ring, o) - 0.01 * m->bed->half_side;
        o->bottom = rim < m->bottom ? rim : m->bottom;
    }
}

/* Stones whose coordinates fit, and the most corners. */
static pave_result check_extents(pave_context *context, pv_modelling *m)
{
    for (int32_t s = 0; s < m->bed->count; s++) {
        const pv_laid *laid = &m->bed->laid[s];
        if (laid->width > 16000 * m->bed->scale || laid->height > 16000 * m->bed->scale)
            return pv_fail(context, PAVE_ERR_LIMIT, "stone %d is larger than the 16000 px that a model's may have", s);
        m->most_corners = laid->corners > m->most_corners ? laid->corners : m->most_corners;
    }
    return PAVE_OK;
}

static pave_result refuse_crossed(pave_context *context, const pv_modelling *m)
{
    int32_t none = 0;
    for (int32_t s = 0; s < m->bed->count; s++)
        none += !m->footprint[s].corners;
    if (none == m->bed->count)
        return pv_fail(context, PAVE_ERR_FORMAT, "every stone crosses itself or has no area: no model can be made");
    if (none)
        pv_note(context, PAVE_MESSAGE_WARNING, "%d stones that cross themselves or are thinner than %g px are left out",
                none, flat);
    return PAVE_OK;
}

pave_result pv_footprints_make(pave_context *context, pv_modelling *m)
{
    tracing job = { .m = m };
    pave_result result = check_extents(context, m);
    if (!result)
        m->footprint = pv_allocate(context, (size_t)m->bed->count, sizeof *m->footprint, &result);
    if (!result)
        m->corner = pv_allocate(context, (size_t)m->bed->stones->starts[m->bed->count], sizeof *m->corner, &result);
    if (!result)
        job.work = pv_allocate(context, (size_t)pv_workers(context) * 2 * (size_t)m->most_corners, sizeof *job.work,
                               &result);
    if (!result)
        result = pv_parallel_runs(context, m->bed->count, RUN, make_footprints, &job, 0.05, 0.1);
    pv_release(job.work);
    return result ? result : refuse_crossed(context, m);
}

/* How round the triangle of an ear is: twice its area by the square of its longest side; no more than 0: it is none. */
static double ear(const pv_cell *ring, const int32_t *left, int32_t count, int32_t i)
{
    int32_t before = left[(i + count - 1) % count], at = left[i], after = left[(i + 1) % count];
    pv_cell a = ring[before], b = ring[at], c = ring[after];
    int64_t turn = pv_cell_turn(a, b, c);
    if (turn <= 0)
        return 0;
    for (int32_t k = 0; k < count; k++) {
        pv_cell p = ring[left[k]];
        if (left[k] == before || left[k] == at || left[k] == after)
            continue;
        if (pv_cell_turn(a, b, p) >= 0 && pv_cell_turn(b, c, p) >= 0 && pv_cell_turn(c, a, p) >= 0)
            return 0;
    }
    double longest = fmax(fmax(way(a, b), way(b, c)), way(c, a));
    return (double)turn / (longest * longest);
}

void pv_footprint_fill(const pv_cell *ring, int32_t corners, int32_t *left, int32_t *triangles)
{
    for (int32_t i = 0; i < corners; i++)
        left[i] = i;
    for (int32_t count = corners; count >= 3; count--, triangles += 3) {
        int32_t best = 0;
        double roundest = -1;
        for (int32_t i = 0; i < count; i++) {
            double round = ear(ring, left, count, i);
            if (round > roundest)
                roundest = round, best = i;
        }
        triangles[0] = left[(best + count - 1) % count];
        triangles[1] = left[best];
        triangles[2] = left[(best + 1) % count];
        memmove(&left[best], &left[best + 1], (size_t)(count - 1 - best) * sizeof *left);
    }
}
