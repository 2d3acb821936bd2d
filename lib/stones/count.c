/* What is counted while a pavement is laid: corners (Fig. 9), areas (Fig. 12), coverage. */
#include "cvd/cvd.h"
#include "stones/stones.h"

#include "util/polygon.h"

#include <math.h>
#include <string.h>

static void count_in(int64_t *bins, double at)
{
    bins[at < PAVE_REPORT_BINS - 1 ? (int)at : PAVE_REPORT_BINS - 1]++;
}

static double area_of(const pave_stones *stones, int32_t s)
{
    const double *v = stones->vertices + 2 * stones->starts[s];
    int64_t count = stones->starts[s + 1] - stones->starts[s];
    double area = 0;
    for (int64_t i = 1; i + 1 < count; i++)
        area += pv_left_turn(v[0], v[1], v[2 * i], v[2 * i + 1], v[2 * i + 2], v[2 * i + 3]);
    return area / 2;
}

void pv_count_cell(pave_report *report, int64_t corners)
{
    count_in(report->corners_before, (double)corners);
}

/* Sites of the window, and how many of them have no stone. */
static void count_sites(const pave_cvd *cvd, pave_stones *stones)
{
    int32_t with = 0;
    for (int32_t i = 0; i < cvd->site_count; i++)
        stones->report.sites += cvd->mine[i] != 0;
    for (int32_t s = 0; s < stones->count; s++)
        with += !s || stones->sites[s] != stones->sites[s - 1];
    stones->report.lost = stones->report.sites - with;
}

void pv_stones_count(const pave_cvd *cvd, pave_stones *stones)
{
    pave_report *m = &stones->report;
    double sum = 0, squares = 0, half_side = cvd->params.half_side;
    m->half_side = half_side;
    m->area_step = half_side * half_side / 2;
    count_sites(cvd, stones);
    m->stones = stones->count;
    for (int32_t s = 0; s < stones->count; s++) {
        double area = area_of(stones, s);
        count_in(m->corners_after, (double)(stones->starts[s + 1] - stones->starts[s]));
        count_in(m->areas, area / m->area_step);
        sum += area;
        squares += area * area;
    }
    double n = stones->count ? stones->count : 1, variance = squares / n - sum / n * (sum / n);
    m->area_mean = sum / n;
    m->area_deviation = variance > 0 ? sqrt(variance) : 0;
    m->coverage = sum / ((double)stones->width * stones->height);
}

pave_result pave_stones_report(pave_context *context, const pave_stones *stones, pave_report *report)
{
    if (!context || !stones || !report)
        return PAVE_ERR_ARGUMENT;
    size_t size = report->size, known = sizeof stones->report;
    if (size < sizeof(size_t) || size > 65536)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the report has no size: set it first");
    memset(report, 0, size);
    memcpy(report, &stones->report, size < known ? size : known);
    report->size = size;
    return PAVE_OK;
}
