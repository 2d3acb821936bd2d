/* Shapes of stones, one by one: corners, areas, slivers, the slit that they fit through. */
#include "stones/measure.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* The k-th smallest of numbers that are not negative, whose bits are then ordered as they are: 16 bits at a time. */
static pave_result find_kth(pave_context *context, const double *values, int64_t count, int64_t k, double *out)
{
    pave_result result = PAVE_OK;
    uint64_t found = 0, bits;
    for (int32_t shift = 48; shift >= 0 && !result; shift -= 16) {
        int64_t *bins = pv_allocate_zeroed(context, 65536, sizeof *bins, &result);
        int32_t bin = 0;
        for (int64_t i = 0; i < count && bins; i++) {
            memcpy(&bits, &values[i], sizeof bits);
            if (shift == 48 || bits >> (shift + 16) == found)
                bins[bits >> shift & 65535]++;
        }
        for (; bins && bin < 65535 && k >= bins[bin]; bin++)
            k -= bins[bin];
        found = found << 16 | (uint64_t)bin;
        pv_release(bins);
        result = result ? result : pv_progress(context, 0.1);
    }
    memcpy(out, &found, sizeof found);
    return result;
}

static pave_result median(pave_context *context, const pv_survey *survey, double *out)
{
    int64_t n = survey->count;
    double low = 0, high = 0;
    pave_result result = n ? find_kth(context, survey->area, n, (n - 1) / 2, &low) : PAVE_OK;
    if (n && !result)
        result = find_kth(context, survey->area, n, n / 2, &high);
    *out = (low + high) / 2;
    return result;
}

static double length(pv_cell a, pv_cell b)
{
    double x = ((double)b.x - a.x) / PV_GRID, y = ((double)b.y - a.y) / PV_GRID;
    return sqrt(x * x + y * y);
}

static double perimeter(const pv_cell *ring, int32_t count)
{
    double sum = 0;
    for (int32_t i = 0; i < count; i++)
        sum += length(ring[i], ring[(i + 1) % count]);
    return sum;
}

/* Twice the area of a triangle, px^2. */
static double turn(pv_cell a, pv_cell b, pv_cell c)
{
    return pv_left_turn(a.x, a.y, b.x, b.y, c.x, c.y) / ((double)PV_GRID * PV_GRID);
}

static int turns_both_ways(const pv_cell *ring, int32_t count, double area)
{
    int left = 0, right = 0;
    for (int32_t i = 0; i < count; i++) {
        double t = turn(ring[i], ring[(i + 1) % count], ring[(i + 2) % count]);
        left |= t > 1e-6 * area;
        right |= t < -1e-6 * area;
    }
    return left && right;
}

/* The narrowest slit has a side of the hull on one of its edges. */
static double least_width(const pv_cell *hull, int32_t count)
{
    double least = INFINITY;
    for (int32_t i = 0; i < count; i++) {
        pv_cell a = hull[i], b = hull[(i + 1) % count];
        double farthest = 0, base = length(a, b);
        for (int32_t j = 0; j < count; j++)
            farthest = fmax(farthest, fabs(turn(a, b, hull[j])) / base);
        least = fmin(least, farthest);
    }
    return least;
}

static pave_result is_thin(pave_context *context, const pv_survey *survey, const pv_cell *ring, int32_t count,
                           int32_t *thin)
{
    pave_result result = PAVE_OK;
    pv_cell *work = pv_allocate(context, 2 * (size_t)count + 1, sizeof *work, &result);
    if (!work)
        return result;
    memcpy(work, ring, (size_t)count * sizeof *work);
    int32_t n = pv_convex_hull(work, count, work + count);
    *thin += least_width(work + count, n) < survey->half_side;
    pv_release(work);
    return PAVE_OK;
}

/* Sums over all stones; they become shares at the end. */
typedef struct tally {
    double area, squares;
    int32_t valid, nonconvex, sliver, tiny, small, thin;
} tally;

static pave_result count_stone(pave_context *context, const pv_survey *survey, int32_t s, double tiny, tally *t)
{
    int32_t count;
    const pv_cell *ring = pv_survey_ring(survey, s, &count);
    double area = survey->area[s], h = survey->half_side;
    t->area += area;
    t->squares += area * area;
    t->tiny += area < tiny;
    t->small += area < h * h;
    t->valid += survey->valid[s];
    if (!survey->valid[s])
        return t->sliver++, t->thin++, PAVE_OK;
    double around = perimeter(ring, count);
    t->sliver += 4 * pi * area / (around * around) < 0.3;
    t->nonconvex += turns_both_ways(ring, count, area);
    return is_thin(context, survey, ring, count, &t->thin);
}

static void count_corners(const pv_survey *survey, pave_stones_measures *out)
{
    const int64_t *starts = survey->stones->starts;
    for (int32_t s = 0; s < survey->count; s++) {
        int64_t corners = starts[s + 1] - starts[s];
        out->vertices[corners < PAVE_REPORT_BINS - 1 ? corners : PAVE_REPORT_BINS - 1]++;
    }
}

static void shares(const pv_survey *survey, const tally *t, pave_stones_measures *out)
{
    double n = survey->count ? survey->count : 1, variance;
    out->stones = survey->count;
    out->invalid = survey->count - t->valid;
    out->quads = (double)out->vertices[4] / n;
    out->triangles = (double)out->vertices[3] / n;
    out->nonconvex = t->nonconvex / n;
    out->sliver = t->sliver / n;
    out->tiny = t->tiny / n;
    out->small = t->small / n;
    out->thin = t->thin / n;
    out->area_mean = t->area / n;
    variance = t->squares / n - out->area_mean * out->area_mean;
    out->area_cv = variance > 0 && t->area > 0 ? sqrt(variance) / out->area_mean : 0;
    out->coverage = t->area / ((double)out->width * out->height);
}

pave_result pv_measure_shapes(pave_context *context, const pv_survey *survey, pave_stones_measures *out)
{
    tally t = { 0, 0, 0, 0, 0, 0, 0, 0 };
    count_corners(survey, out);
    pave_result result = median(context, survey, &out->area_median);
    for (int32_t s = 0; s < survey->count && !result; s++) {
        result = count_stone(context, survey, s, out->area_median / 8, &t);
        if (!result && s % 1024 == 0)
            result = pv_progress(context, 0.1);
    }
    shares(survey, &t, out);
    return result;
}
