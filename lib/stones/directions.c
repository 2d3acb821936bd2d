/* How stones lie: all along the axes far from edges, where nothing should tell them how (R4), and along edges near
 * them. A direction is a complex number to the fourth power, to which quarter turns are all the same. */
#include "stones/measure.h"

#include <math.h>

typedef struct quarter {
    double x, y; /* of length 1 or 0 */
} quarter;

/* (x + i y)^4 / |x + i y|^4 * weight */
static quarter fourth(double x, double y, double weight)
{
    double xx = x * x - y * y, xy = 2 * x * y, square = x * x + y * y;
    if (!(square > 0))
        return (quarter){ 0, 0 };
    weight /= square * square;
    return (quarter){ weight * (xx * xx - xy * xy), weight * 2 * xx * xy };
}

static quarter of_length_one(quarter q)
{
    double length = sqrt(q.x * q.x + q.y * q.y);
    return length > 0 ? (quarter){ q.x / length, q.y / length } : (quarter){ 0, 0 };
}

/* The sides' directions, weighted by their length. */
static quarter direction_of(const pv_cell *ring, int32_t count)
{
    quarter sum = { 0, 0 };
    for (int32_t i = 0; i < count; i++) {
        double x = (double)ring[(i + 1) % count].x - ring[i].x, y = (double)ring[(i + 1) % count].y - ring[i].y;
        quarter q = fourth(x, y, sqrt(x * x + y * y));
        sum.x += q.x;
        sum.y += q.y;
    }
    return of_length_one(sum);
}

/* The pixel under the mean of the corners, within the plane. */
static void pixel_of(const pv_survey *survey, const pv_cell *ring, int32_t count, int32_t *x, int32_t *y)
{
    double sx = 0, sy = 0;
    for (int32_t i = 0; i < count; i++) {
        sx += ring[i].x;
        sy += ring[i].y;
    }
    double width = survey->drawing->width - 1, height = survey->drawing->height - 1;
    *x = (int32_t)fmin(fmax(floor(sx / count / PV_GRID), 0), width);
    *y = (int32_t)fmin(fmax(floor(sy / count / PV_GRID), 0), height);
}

enum { BINS = 4501 }; /* of 1/100 degree */

typedef struct tally {
    double far_x, far_y, near_sum;
    int32_t far_count, near_count;
    int32_t bins[BINS];
} tally;

/* Degrees between two directions, 0..45. */
static double between(quarter a, quarter b)
{
    double cosine = a.x * b.x + a.y * b.y, sine = a.y * b.x - a.x * b.y;
    return fabs(atan2(sine, cosine)) * 45 / 3.14159265358979323846;
}

static void add_stone(const pv_survey *survey, const pave_field *field, int32_t s, tally *t)
{
    int32_t count, x, y;
    float gx, gy;
    const pv_cell *ring = pv_survey_ring(survey, s, &count);
    pixel_of(survey, ring, count, &x, &y);
    double distance = field->distance[(int64_t)y * field->width + x];
    quarter lies = direction_of(ring, count);
    if (distance > 3 * survey->half_side) {
        t->far_x += lies.x;
        t->far_y += lies.y;
        t->far_count++;
    }
    if (!(distance < 1.5 * survey->half_side))
        return;
    pv_gradient(field, x, y, &gx, &gy);
    if (gx == 0 && gy == 0)
        return;
    double angle = between(lies, fourth(gx, gy, 1));
    t->near_sum += angle;
    t->near_count++;
    t->bins[(int)(angle * 100)]++;
}

static double percentile(const tally *t, double share)
{
    int64_t sum = 0;
    for (int32_t i = 0; i < BINS; i++) {
        sum += t->bins[i];
        if ((double)sum >= share * t->near_count)
            return i / 100.0;
    }
    return 45;
}

pave_result pv_measure_directions(pave_context *context, const pv_survey *survey, const pave_field *field,
                                  pave_stones_measures *out)
{
    pave_result result = PAVE_OK;
    tally *t = pv_allocate_zeroed(context, 1, sizeof *t, &result);
    for (int32_t s = 0; s < survey->count && !result; s++) {
        if (survey->valid[s])
            add_stone(survey, field, s, t);
        if (s % 1024 == 0)
            result = pv_progress(context, 0.65 + 0.02 * s / survey->count);
    }
    if (!result) {
        double far = t->far_count ? t->far_count : 1;
        out->axis_bias = sqrt(t->far_x * t->far_x + t->far_y * t->far_y) / far;
        out->far_stones = t->far_count;
        out->near_stones = t->near_count;
        out->near_mean = t->near_sum / (t->near_count ? t->near_count : 1);
        out->near_p90 = t->near_count ? percentile(t, 0.9) : 0;
    }
    pv_release(t);
    return result;
}
