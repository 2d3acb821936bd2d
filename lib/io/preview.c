/* Stones as a picture: the exact area that each covers of each pixel, mixed in linear light over the grout. */
#include "io/convert.h"
#include "io/pavement.h"
#include "io/raster.h"
#include "stones/copies.h"
#include "stones/palette.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { MOST_SIDE = 16384, BAND = 32, BANDS_AT_ONCE = 16, CODES = 1 << 14 };

typedef struct preview {
    const pave_stones *stones;
    double scale;
    int32_t width, height, bands;
    int64_t *starts;  /* stones by band: where each band's begin in `members` */
    int32_t *members;
    int32_t first_band;
    uint8_t *pixels; /* of the bands under way */
    float *sums;     /* per worker: r, g, b and coverage of a band, and one plane for a single stone */
    float light[256];
    uint8_t code[CODES + 1]; /* display code of linear light, finer than 8 bits need */
} preview;

static size_t band_floats(const preview *job)
{
    return (size_t)BAND * (4 * (size_t)job->width + (size_t)job->width + 2);
}

/* Signed area to the right of an edge, within one row of pixels: `plane` gets differences along the row, so that
 * their running sum is the coverage. The edge goes from (x0, y0) to (x1, y1), 0 <= y <= 1 within the row. */
static void add_span(float *row, double x0, double x1, double dy)
{
    double left = x0 < x1 ? x0 : x1, right = x0 < x1 ? x1 : x0;
    int32_t first = (int32_t)left, last = (int32_t)ceil(right);
    if (last <= first + 1) {
        double inside = 1 - (0.5 * (left + right) - first);
        row[first] += (float)(dy * inside);
        row[first + 1] += (float)(dy * (1 - inside));
        return;
    }
    double slope = 1 / (right - left), before = 0; /* coverage summed up to the pixel */
    for (int32_t x = first; x < last; x++) {
        double from = left > x ? left - x : 0, to = right < x + 1 ? right - x : 1;
        double entered = (x + from - left) * slope, crossing = (to - from) * slope;
        double covered = entered + crossing * (1 - 0.5 * (from + to));
        row[x] += (float)(dy * (covered - before));
        before = covered;
    }
    row[last] += (float)(dy * (1 - before));
}

static double clamp(double v, double most)
{
    return v > 0 ? v < most ? v : most : 0;
}

static double picture_x(const preview *job, const double *vertex)
{
    return (vertex[0] - job->stones->x) * job->scale;
}

static double picture_y(const preview *job, const double *vertex)
{
    return (vertex[1] - job->stones->y) * job->scale;
}

/* An edge within a row: what of it lies beyond the picture's sides is moved to them, for it covers the same inside. */
static void add_clipped(const preview *job, float *row, double x0, double x1, double dy)
{
    double right = job->width, way = x1 - x0, from = 0;
    double a = way != 0 ? clamp(-x0 / way, 1) : 0, b = way != 0 ? clamp((right - x0) / way, 1) : 0;
    double cuts[3] = { a < b ? a : b, a < b ? b : a, 1 };
    for (int i = 0; i < 3; from = cuts[i++])
        if (cuts[i] > from)
            add_span(row, clamp(x0 + from * way, right), clamp(x0 + cuts[i] * way, right), dy * (cuts[i] - from));
}

/* An edge, cut into rows. */
static void add_edge(const preview *job, float *plane, double top, const double *a, const double *b)
{
    double x0 = picture_x(job, a), y0 = picture_y(job, a) - top, x1 = picture_x(job, b), y1 = picture_y(job, b) - top;
    double sign = y0 < y1 ? 1 : -1;
    if (sign < 0) {
        double x = x0, y = y0;
        x0 = x1, y0 = y1, x1 = x, y1 = y;
    }
    double from = clamp(y0, BAND), end = clamp(y1, BAND), slope = y1 > y0 ? (x1 - x0) / (y1 - y0) : 0;
    for (double y = from; y < end;) {
        double next = floor(y) + 1 < end ? floor(y) + 1 : end;
        double u = x0 + (y - y0) * slope, v = x0 + (next - y0) * slope;
        add_clipped(job, plane + (size_t)floor(y) * ((size_t)job->width + 2), u, v, sign * (next - y));
        y = next;
    }
}

/* The columns that a stone touches, and one more on each side for rounding. */
static void columns(const preview *job, int32_t stone, int32_t *left, int32_t *right)
{
    const pave_stones *stones = job->stones;
    double least = job->width, most = 0;
    for (int64_t i = stones->starts[stone]; i < stones->starts[stone + 1]; i++) {
        double x = clamp(picture_x(job, &stones->vertices[2 * i]), job->width);
        least = x < least ? x : least;
        most = x > most ? x : most;
    }
    *left = least >= 1 ? (int32_t)least - 1 : 0;
    *right = (int32_t)ceil(most) + 1 < job->width ? (int32_t)ceil(most) + 1 : job->width;
}

static pv_colour colour_of(const pave_stones *stones, int32_t stone)
{
    const uint8_t *rgb = stones->rgb ? stones->rgb + 3 * (int64_t)stone : NULL;
    return rgb ? (pv_colour){ rgb[0], rgb[1], rgb[2] } : pv_laid_colour(stones, stones->colours[stone]);
}

static void add_stone(const preview *job, float *sums, float *plane, int32_t band, int32_t stone)
{
    const pave_stones *stones = job->stones;
    int64_t first = stones->starts[stone], end = stones->starts[stone + 1];
    int32_t left, right;
    pv_colour colour = colour_of(stones, stone);
    float light[3] = { job->light[colour.r], job->light[colour.g], job->light[colour.b] };
    for (int64_t i = first; i < end; i++)
        add_edge(job, plane, (double)band * BAND, &stones->vertices[2 * i],
                 &stones->vertices[2 * (i + 1 < end ? i + 1 : first)]);
    columns(job, stone, &left, &right);
    for (int32_t y = 0; y < BAND; y++) {
        float *row = plane + (size_t)y * ((size_t)job->width + 2), *sum = sums + 4 * (size_t)y * (size_t)job->width;
        float covered = 0;
        for (int32_t x = left; x < right; x++) {
            covered += row[x];
            float share = fabsf(covered);
            if (stones->painted) /* over what is there */
                for (int32_t c = 0; c < 4; c++)
                    sum[4 * x + c] *= 1 - (share < 1 ? share : 1);
            for (int32_t c = 0; c < 3; c++)
                sum[4 * x + c] += share * light[c];
            sum[4 * x + 3] += share;
        }
        memset(row + left, 0, (size_t)(right + 2 - left) * sizeof *row);
    }
}

static uint8_t coded(const preview *job, float light)
{
    return job->code[(int32_t)(light < 1 ? light * CODES + 0.5f : CODES)];
}

/* Grout shows where stones leave room; where they overlap they share the pixel. */
static void mix(const preview *job, const float *sums, int64_t count, uint8_t *pixels)
{
    const float grout[3] = { job->light[pv_grout.r], job->light[pv_grout.g], job->light[pv_grout.b] };
    for (int64_t i = 0; i < count; i++, sums += 4, pixels += 3) {
        float covered = sums[3], room = covered < 1 ? 1 - covered : 0, scale = covered > 1 ? 1 / covered : 1;
        for (int32_t c = 0; c < 3; c++)
            pixels[c] = coded(job, sums[c] * scale + room * grout[c]);
    }
}

static void draw_band(void *data, int32_t index, int32_t worker)
{
    const preview *job = data;
    int32_t band = job->first_band + index, rows = job->height - band * BAND;
    if (rows < 1)
        return;
    float *sums = job->sums + (size_t)worker * band_floats(job), *plane = sums + (size_t)BAND * 4 * (size_t)job->width;
    memset(sums, 0, band_floats(job) * sizeof *sums);
    for (int64_t i = job->starts[band]; i < job->starts[band + 1]; i++)
        add_stone(job, sums, plane, band, job->members[i]);
    mix(job, sums, (int64_t)(rows < BAND ? rows : BAND) * job->width,
        job->pixels + (size_t)index * BAND * 3 * (size_t)job->width);
}

static void rows_of(const preview *job, int32_t stone, int32_t *first, int32_t *last)
{
    const pave_stones *stones = job->stones;
    double least = job->height, most = 0, edge = job->height - 1;
    for (int64_t i = stones->starts[stone]; i < stones->starts[stone + 1]; i++) {
        double y = picture_y(job, &stones->vertices[2 * i]);
        least = y < least ? y : least;
        most = y > most ? y : most;
    }
    *first = (int32_t)clamp(least, edge) / BAND;
    *last = (int32_t)clamp(most, edge) / BAND;
}

/* Stones by the bands that they touch: counted, then filled in, in the order of the stones. */
static pave_result sort_stones(pave_context *context, preview *job)
{
    pave_result result = PAVE_OK;
    int32_t first, last;
    job->starts = pv_allocate_zeroed(context, (size_t)job->bands + 2, sizeof *job->starts, &result);
    if (!job->starts)
        return result;
    for (int32_t i = 0; i < job->stones->count; i++)
        for (rows_of(job, i, &first, &last); first <= last; first++)
            job->starts[first + 2]++;
    for (int32_t i = 0; i < job->bands; i++)
        job->starts[i + 2] += job->starts[i + 1];
    job->members = pv_allocate(context, (size_t)job->starts[job->bands + 1], sizeof *job->members, &result);
    for (int32_t i = 0; i < job->stones->count && !result; i++)
        for (rows_of(job, i, &first, &last); first <= last; first++)
            job->members[job->starts[first + 1]++] = i;
    return result;
}

static pave_result draw(pave_context *context, preview *job, pv_raster *raster)
{
    pave_result result = PAVE_OK;
    for (job->first_band = 0; job->first_band < job->bands && !result; job->first_band += BANDS_AT_ONCE) {
        int32_t from = job->first_band * BAND, left = job->bands - job->first_band;
        int32_t count = left < BANDS_AT_ONCE ? left : BANDS_AT_ONCE, end = from + count * BAND;
        result = pv_parallel(context, count, draw_band, job, (double)job->first_band / job->bands,
                             (double)(job->first_band + count) / job->bands);
        if (!result)
            result = pv_raster_rows(raster, from, end < job->height ? end : job->height, job->pixels);
    }
    return result;
}

static void set_up(preview *job, const pave_stones *stones)
{
    int32_t most = stones->width > stones->height ? stones->width : stones->height;
    memset(job, 0, sizeof *job);
    job->stones = stones;
    job->scale = most > MOST_SIDE ? (double)MOST_SIDE / most : 1;
    job->width = (int32_t)ceil(stones->width * job->scale - 1e-6);
    job->height = (int32_t)ceil(stones->height * job->scale - 1e-6);
    job->bands = (job->height + BAND - 1) / BAND;
    for (int32_t i = 0; i < 256; i++)
        job->light[i] = (float)pv_linear_light(i / 255.0);
    for (int32_t i = 0; i <= CODES; i++)
        job->code[i] = (uint8_t)(pv_display_code((double)i / CODES) * 255 + 0.5);
}

static pave_result write_stones(pave_context *context, const pave_stones *stones, const char *path)
{
    preview job;
    pv_raster *raster;
    set_up(&job, stones);
    pv_picture picture = { .width = job.width, .height = job.height, .channels = 3, .type = PAVE_U8, .alpha = -1,
                           .rows = 1 };
    pave_result result = pv_raster_open(context, path, "png", &picture, &raster);
    if (result)
        return result;
    result = sort_stones(context, &job);
    if (!result)
        job.pixels = pv_allocate(context, (size_t)BAND * BANDS_AT_ONCE * 3, (size_t)job.width, &result);
    if (!result)
        job.sums = pv_allocate(context, (size_t)pv_workers(context), band_floats(&job) * sizeof *job.sums, &result);
    if (!result)
        result = draw(context, &job, raster);
    pv_release(job.starts);
    pv_release(job.members);
    pv_release(job.pixels);
    pv_release(job.sums);
    return pv_raster_close(raster, result);
}

pave_result pv_preview_write(pave_context *context, const pave_stones *stones, const char *path)
{
    pave_stones copies;
    if (!stones->field.periodic)
        return write_stones(context, stones, path);
    pave_result result = pv_copies_make(context, stones, &copies);
    if (!result)
        result = write_stones(context, &copies, path);
    pv_copies_free(&copies);
    return result;
}
