/* How wide the joints are: from three points of each side straight out to the next stone. */
#include "stones/measure.h"

#include <math.h>
#include <string.h>

enum { SAMPLES = 3 };

/* Stones to be met, as boxes in buckets. */
typedef struct meeting {
    const pv_survey *survey;
    pv_box *box;
    int32_t *stone; /* of each box */
    int32_t count;
    pv_buckets buckets;
    double limit; /* 1/1000 px */
} meeting;

typedef struct ray {
    double x, y, dx, dy; /* 1/1000 px; direction of length 1 */
    int32_t from;        /* the stone that it leaves */
} ray;

/* How far along a ray the side a b is, INFINITY if it is missed; behind the start is negative. */
static double along(const ray *r, pv_cell a, pv_cell b)
{
    double ax = a.x - r->x, ay = a.y - r->y, bx = b.x - r->x, by = b.y - r->y;
    double sa = ax * r->dy - ay * r->dx, sb = bx * r->dy - by * r->dx;
    if ((sa <= 0) == (sb <= 0))
        return INFINITY;
    double t = sa / (sa - sb);
    return (ax + t * (bx - ax)) * r->dx + (ay + t * (by - ay)) * r->dy;
}

/* 0 where the ray begins inside the stone. */
static double distance_to(const meeting *m, const ray *r, int32_t s)
{
    int32_t count, ahead = 0;
    double nearest = INFINITY;
    const pv_cell *ring = pv_survey_ring(m->survey, s, &count);
    for (int32_t i = 0; i < count; i++) {
        double t = along(r, ring[i], ring[(i + 1) % count]);
        if (t >= 0 && t < INFINITY) {
            nearest = t < nearest ? t : nearest;
            ahead++;
        }
    }
    return ahead % 2 ? 0 : nearest;
}

static pv_box reach(const meeting *m, const ray *r)
{
    double x = r->x + r->dx * m->limit, y = r->y + r->dy * m->limit;
    return (pv_box){ (int32_t)floor(fmin(x, r->x)), (int32_t)floor(fmin(y, r->y)), (int32_t)ceil(fmax(x, r->x)),
                     (int32_t)ceil(fmax(y, r->y)) };
}

static int boxes_touch(const pv_box *a, const pv_box *b)
{
    return a->left <= b->right && b->left <= a->right && a->top <= b->bottom && b->top <= a->bottom;
}

/* To the next stone; more than the limit if there is none so near. */
static double width_at(const meeting *m, const ray *r)
{
    const pv_buckets *b = &m->buckets;
    double nearest = INFINITY;
    pv_box box = reach(m, r);
    int32_t right = pv_bucket_column(b, box.right), bottom = pv_bucket_row(b, box.bottom);
    for (int32_t row = pv_bucket_row(b, box.top); row <= bottom; row++)
        for (int32_t column = pv_bucket_column(b, box.left); column <= right; column++) {
            int64_t k = (int64_t)row * b->columns + column;
            for (int64_t i = b->first[k]; i < b->first[k + 1]; i++) {
                int32_t at = b->member[i];
                if (m->stone[at] != r->from && boxes_touch(&box, &m->box[at]))
                    nearest = fmin(nearest, distance_to(m, r, m->stone[at]));
            }
        }
    return nearest;
}

/* Lengths of joints by their width, in bins of 1/1000 of the limit. */
enum { BINS = 1001 };

typedef struct tally {
    double all, jointed, sum, squares;
    double bins[BINS];
} tally;

static void add_side(const meeting *m, int32_t s, pv_cell a, pv_cell b, tally *t)
{
    double x = (double)b.x - a.x, y = (double)b.y - a.y, length = sqrt(x * x + y * y), part = length / SAMPLES;
    for (int32_t k = 0; k < SAMPLES; k++) {
        double share = (k + 0.5) / SAMPLES;
        ray r = { a.x + share * x, a.y + share * y, -y / length, x / length, s }; /* to the right is outside */
        double width = width_at(m, &r);
        t->all += part;
        if (!(width <= m->limit))
            continue;
        t->jointed += part;
        t->sum += part * width;
        t->squares += part * width * width;
        t->bins[(int)(width / m->limit * (BINS - 1))] += part;
    }
}

static double percentile(const tally *t, double share, double limit)
{
    double sum = 0;
    for (int32_t i = 0; i < BINS; i++) {
        sum += t->bins[i];
        if (sum >= share * t->jointed)
            return limit * i / (BINS - 1) / PV_GRID;
    }
    return limit / PV_GRID;
}

static void finish(const meeting *m, const tally *t, pave_stones_measures *out)
{
    if (!(t->jointed > 0))
        return;
    double mean = t->sum / t->jointed, variance = t->squares / t->jointed - mean * mean;
    out->joint_mean = mean / PV_GRID;
    out->joint_deviation = variance > 0 ? sqrt(variance) / PV_GRID : 0;
    out->joint_p5 = percentile(t, 0.05, m->limit);
    out->joint_p95 = percentile(t, 0.95, m->limit);
    out->jointed = t->jointed / t->all;
}

static pave_result measure(pave_context *context, const meeting *m, pave_stones_measures *out)
{
    pave_result result = PAVE_OK;
    tally *t = pv_allocate_zeroed(context, 1, sizeof *t, &result);
    for (int32_t i = 0; i < m->count && !result; i++) {
        int32_t count;
        const pv_cell *ring = pv_survey_ring(m->survey, m->stone[i], &count);
        for (int32_t k = 0; k < count; k++)
            add_side(m, m->stone[i], ring[k], ring[(k + 1) % count], t);
        if (i % 256 == 0)
            result = pv_progress(context, 0.67 + 0.13 * i / m->count);
    }
    if (!result)
        finish(m, t, out);
    pv_release(t);
    return result;
}

static pave_result gather(pave_context *context, meeting *m)
{
    pave_result result = PAVE_OK;
    const pv_survey *survey = m->survey;
    m->box = pv_allocate(context, (size_t)survey->count, sizeof *m->box, &result);
    if (!result)
        m->stone = pv_allocate(context, (size_t)survey->count, sizeof *m->stone, &result);
    for (int32_t s = 0; s < survey->count && !result; s++) {
        int32_t count;
        const pv_cell *ring = pv_survey_ring(survey, s, &count);
        if (!survey->valid[s])
            continue;
        m->box[m->count] = pv_box_of(ring, count);
        m->stone[m->count++] = s;
    }
    return result ? result : pv_buckets_fill(context, survey->stones, m->box, m->count, &m->buckets);
}

pave_result pv_measure_joints(pave_context *context, const pv_survey *survey, pave_stones_measures *out)
{
    meeting m = { .survey = survey, .limit = survey->joint_limit * PV_GRID };
    pave_result result = gather(context, &m);
    if (!result)
        result = measure(context, &m, out);
    pv_buckets_free(&m.buckets);
    pv_release(m.box);
    pv_release(m.stone);
    return result;
}
