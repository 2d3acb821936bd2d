/* Stones made ready to be judged: on the grid, one way round, and told whether they are valid. */
#include "stones/measure.h"

#include <math.h>
#include <string.h>

enum { LEAST = -(1 << 18), MOST = (1 << 20) + (1 << 18) }; /* px; beyond, products would not fit into 64 bits */

static int same(pv_cell a, pv_cell b)
{
    return a.x == b.x && a.y == b.y;
}

/* Copies a stone without repeated corners; 0 if it lies beyond what can be computed with. */
static int take(const pave_stones *stones, int32_t s, pv_cell *ring, int32_t *count)
{
    *count = 0;
    for (int64_t i = stones->starts[s]; i < stones->starts[s + 1]; i++) {
        double x = stones->vertices[2 * i], y = stones->vertices[2 * i + 1];
        if (!(x >= LEAST && x <= MOST && y >= LEAST && y <= MOST))
            return 0;
        pv_cell c = { (int32_t)lround(x * PV_GRID), (int32_t)lround(y * PV_GRID) };
        if (!*count || !same(c, ring[*count - 1]))
            ring[(*count)++] = c;
    }
    while (*count > 1 && same(ring[0], ring[*count - 1]))
        --*count;
    return 1;
}

static void turn_round(pv_cell *ring, int32_t count)
{
    for (int32_t i = 0, j = count - 1; i < j; i++, j--) {
        pv_cell c = ring[i];
        ring[i] = ring[j];
        ring[j] = c;
    }
}

static pave_result take_all(pave_context *context, pv_survey *survey, int32_t *clockwise)
{
    pave_result result = PAVE_OK;
    for (int32_t s = 0; s < survey->count && !result; s++) {
        pv_cell *ring = survey->corner + survey->first[s];
        int32_t count;
        if (!take(survey->stones, s, ring, &count))
            return pv_fail(context, PAVE_ERR_ARGUMENT, "stone %d lies beyond %d .. %d px", s, LEAST, MOST);
        int64_t area = count < 3 ? 0 : pv_ring_area(ring, count);
        if (area < 0)
            turn_round(ring, count);
        survey->valid[s] = count >= 3 && pv_ring_valid(ring, count);
        survey->area[s] = fabs((double)area) / (2.0 * PV_GRID * PV_GRID);
        survey->first[s + 1] = survey->first[s] + count;
        clockwise[area < 0] += survey->valid[s];
        if (s % 1024 == 0)
            result = pv_progress(context, 0.1 * s / survey->count);
    }
    return result;
}

static pave_result allocate(pave_context *context, pv_survey *survey)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)survey->count, corners = (size_t)survey->stones->starts[survey->count];
    survey->first = pv_allocate_zeroed(context, n + 1, sizeof *survey->first, &result);
    if (!result)
        survey->corner = pv_allocate(context, corners, sizeof *survey->corner, &result);
    if (!result)
        survey->valid = pv_allocate(context, n, sizeof *survey->valid, &result);
    if (!result)
        survey->colour = pv_allocate(context, n, sizeof *survey->colour, &result);
    if (!result)
        survey->area = pv_allocate(context, n, sizeof *survey->area, &result);
    return result;
}

/* What a stone is painted with. Those without a palette are 0 or 255. */
static pv_rgb paint_of(const pave_stones *stones, int32_t s)
{
    uint8_t value = stones->colours[s];
    const uint8_t *rgb = stones->rgb ? stones->rgb + 3 * (int64_t)s : stones->palette.palette.rgb + 3 * value;
    int known = stones->rgb || value < stones->palette.palette.count;
    return known ? (pv_rgb){ rgb[0], rgb[1], rgb[2] } : (pv_rgb){ value, value, value };
}

static uint8_t black_or_white(pv_rgb c)
{
    return 299 * c.r + 587 * c.g + 114 * c.b >= 128000 ? 255 : 0;
}

/* Stones in the drawing's colours: its nearest entry, black or white by luma. */
static pave_result translate(pave_context *context, pv_survey *survey)
{
    const pave_palette *palette = &survey->drawing->palette;
    pv_codebook *book = NULL;
    pave_result result = palette->count ? pv_codebook_create(context, palette, &book) : PAVE_OK;
    for (int32_t s = 0; s < survey->count && !result; s++) {
        pv_rgb paint = paint_of(survey->stones, s);
        survey->colour[s] = book ? pv_nearest_entry(book, paint) : black_or_white(paint);
    }
    pv_release(book);
    return result;
}

pave_result pv_survey_make(pave_context *context, const pave_image *drawing, const pave_stones *stones,
                           const pave_stones_measure_params *params, pv_survey *out, int32_t *clockwise)
{
    memset(out, 0, sizeof *out);
    out->drawing = drawing;
    out->stones = stones;
    out->count = stones->count;
    out->half_side = params->half_side > 0 ? params->half_side : pv_stones_half_side(stones);
    out->joint_limit = params->joint_limit * out->half_side;
    pave_result result = allocate(context, out);
    int32_t ways[2] = { 0, 0 };
    if (!result)
        result = take_all(context, out, ways);
    if (!result)
        result = translate(context, out);
    *clockwise = ways[0] < ways[1] ? ways[0] : ways[1];
    return result;
}

void pv_survey_free(pv_survey *survey)
{
    pv_release(survey->first);
    pv_release(survey->corner);
    pv_release(survey->valid);
    pv_release(survey->colour);
    pv_release(survey->area);
    memset(survey, 0, sizeof *survey);
}
