/* Exact Euclidean distance from a pixel's centre to the frontier between two colours.
 *
 * The frontier is made of unit cracks between pixels. Seen from a pixel's centre its nearest point is either straight
 * ahead in the pixel's own row or column, or the end of a crack: a lattice corner. The first kind is a run length, the
 * second an ordinary distance transform of lattice corners (columns first, then the lower envelope of parabolas:
 * Felzenszwalb and Huttenlocher 2012). All in half pixels, so all integers.
 *
 * Some rows at a time the columns go down or up, strips of columns side by side; then each row looks across alone. */
#include "base/parallel.h"
#include "field/field.h"

#include "util/fixed.h"

#include <math.h>
#include <string.h>

#define NONE ((int64_t)1 << 40)

static int differ(const pv_drawing *d, int32_t x0, int32_t y0, int32_t x1, int32_t y1)
{
    return d->pixels[(int64_t)y0 * d->width + x0] != d->pixels[(int64_t)y1 * d->width + x1];
}

/* The same where the borders meet. */
static int corner_on_torus(const pv_drawing *d, int32_t x, int32_t y)
{
    int32_t left = (x ? x : d->width) - 1, up = (y ? y : d->height) - 1;
    int32_t right = x < d->width ? x : 0, down = y < d->height ? y : 0;
    return differ(d, left, up, right, up) || differ(d, left, down, right, down) || differ(d, left, up, left, down) ||
           differ(d, right, up, right, down);
}

/* Does a crack end at the lattice corner above and left of pixel (x, y)? 0 <= x <= width, 0 <= y <= height. */
static int corner(const pv_drawing *d, int32_t x, int32_t y)
{
    if (d->wraps)
        return corner_on_torus(d, x, y);
    int32_t left = x - 1, up = y - 1;
    int inside_x = x > 0 && x < d->width, inside_y = y > 0 && y < d->height;
    return (inside_x && up >= 0 && differ(d, left, up, x, up)) ||
           (inside_x && y < d->height && differ(d, left, y, x, y)) ||
           (inside_y && left >= 0 && differ(d, left, up, left, y)) ||
           (inside_y && x < d->width && differ(d, x, up, x, y));
}

static int32_t nearer(int32_t a, int64_t half_pixels)
{
    int64_t b = half_pixels * (PV_FIELD_ONE / 2);
    return b < a ? (int32_t)b : a;
}

/* Is there a crack left of pixel (x, y)? */
static int crack(const pv_drawing *d, int32_t x, int32_t y)
{
    return x ? differ(d, x - 1, y, x, y) : d->wraps && differ(d, d->width - 1, y, 0, y);
}

/* Straight ahead: half pixels to the next crack in this row, both ways. Where the borders meet, what is still unknown
 * is found in a second round. */
static void along_row(const pv_drawing *d, int32_t y, int32_t *row)
{
    int64_t run = NONE;
    for (int32_t i = 0; i < d->width << d->wraps; i++, run += 2) {
        int32_t x = i % d->width;
        if (crack(d, x, y))
            run = 1;
        row[x] = nearer(i < d->width ? PV_FIELD_FAR : row[x], run);
    }
    run = NONE;
    for (int32_t i = 0; i < d->width << d->wraps; i++, run += 2) {
        int32_t x = d->width - 1 - i % d->width;
        if ((x + 1 < d->width || d->wraps) && crack(d, x + 1 < d->width ? x + 1 : 0, y))
            run = 1;
        row[x] = nearer(row[x], run);
    }
}

typedef struct envelope {
    int32_t *apex;
    int64_t *from; /* the half-pixel column where a parabola begins to be the lowest */
    int32_t count;
} envelope;

/* Lower envelope of (u - 2i)^2 + h[i]^2 over the corner columns i. */
static void build_envelope(envelope *e, const int32_t *h, int32_t columns)
{
    e->count = 0;
    for (int32_t i = 0; i < columns; i++) {
        if (h[i] >= INT32_MAX / 2)
            continue;
        int64_t start = INT64_MIN, hi = (int64_t)h[i] * h[i] + 4 * (int64_t)i * i;
        while (e->count) {
            int64_t j = e->apex[e->count - 1], hj = (int64_t)h[j] * h[j] + 4 * j * j;
            start = pv_floor_div(hi - hj, 4 * (i - j)) + 1; /* first u where i is strictly lower */
            if (start > e->from[e->count - 1])
                break;
            e->count--;
            start = INT64_MIN;
        }
        e->apex[e->count] = i;
        e->from[e->count++] = start;
    }
}

static int32_t corner_distance(int64_t square)
{
    double d = sqrt((double)square) * (PV_FIELD_ONE / 2);
    return d < (double)PV_FIELD_FAR ? (int32_t)(d + 0.5) : PV_FIELD_FAR;
}

/* `pad` columns of corners lie left of the row's first. */
static void to_corners(const envelope *e, const int32_t *h, int32_t pad, int32_t width, int32_t *row)
{
    for (int32_t x = 0, k = 0; x < width && e->count; x++) {
        int64_t u = 2 * ((int64_t)x + pad) + 1;
        while (k + 1 < e->count && e->from[k + 1] <= u)
            k++;
        int64_t i = e->apex[k], square = (u - 2 * i) * (u - 2 * i) + (int64_t)h[i] * h[i];
        int32_t d = corner_distance(square);
        row[x] = d < row[x] ? d : row[x];
    }
}

enum { ROWS = 32 /* at a time */, STRIP = 256 /* columns together */ };

/* Heights of corners and lengths of runs carry over from row to row; the other scratch is each worker's own. */
typedef struct sweep {
    const pv_drawing *drawing;
    int32_t *distance;
    int32_t step, done, rows; /* rows this time */
    int32_t columns, pad;     /* an envelope's: where the borders meet, half a turn more on both sides */
    int32_t *corners, *straight;
    int32_t *heights;         /* of corners: ROWS times width + 1 */
    int32_t *wide, *apex;
    int64_t *from;
} sweep;

static int32_t row_at(const sweep *s, int32_t i)
{
    int32_t y = (s->done + i) % s->drawing->height;
    return s->step > 0 ? y : s->drawing->height - 1 - y;
}

/* For a row of pixels: half pixels (odd) up or down to the nearest corner, for the columns of corners `begin` to `end`;
 * also the straight distances along columns. */
static void down_columns(const sweep *s, int32_t y, int32_t begin, int32_t end, int32_t *row)
{
    const pv_drawing *d = s->drawing;
    int32_t edge = s->step > 0 ? y : y + 1, before = y - s->step;
    int32_t *corners = s->corners, *straight = s->straight;
    if (d->wraps)
        before = before < 0 ? d->height - 1 : before < d->height ? before : 0;
    for (int32_t x = begin; x < end; x++)
        corners[x] = corner(d, x, edge) ? 1 : corners[x] < INT32_MAX / 2 ? corners[x] + 2 : corners[x];
    for (int32_t x = begin; x < end && x < d->width; x++) {
        if (before >= 0 && before < d->height && differ(d, x, before, x, y))
            straight[x] = 1;
        else if (straight[x] < INT32_MAX / 2)
            straight[x] += 2;
        row[x] = nearer(row[x], straight[x]);
    }
}

static void go_along_columns(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const sweep *s = data;
    (void)worker;
    for (int32_t i = 0; i < s->rows; i++) {
        int32_t y = row_at(s, i);
        down_columns(s, y, begin, end, s->distance + (int64_t)y * s->drawing->width);
        memcpy(s->heights + (int64_t)i * (s->drawing->width + 1) + begin, s->corners + begin,
               (size_t)(end - begin) * sizeof *s->heights);
    }
}

static void look_across(void *data, int32_t i, int32_t worker)
{
    const sweep *s = data;
    int32_t width = s->drawing->width;
    int64_t own = (int64_t)worker * s->columns;
    const int32_t *h = s->heights + (int64_t)i * (width + 1);
    if (s->pad) {
        int32_t *wide = s->wide + own;
        for (int32_t k = 0, at = width - s->pad; k < s->columns; k++, at++)
            wide[k] = h[at % width];
        h = wide;
    }
    envelope e = { s->apex + own, s->from + own, 0 };
    build_envelope(&e, h, s->columns);
    to_corners(&e, h, s->pad, width, s->distance + (int64_t)row_at(s, i) * width);
}

static void look_along(void *data, int32_t y, int32_t worker)
{
    const sweep *s = data;
    (void)worker;
    along_row(s->drawing, y, s->distance + (int64_t)y * s->drawing->width);
}

static void far_away(int32_t *values, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        values[i] = INT32_MAX;
}

/* All the way down or up, twice where the borders meet. */
static pave_result go(pave_context *context, sweep *s, int32_t step, double from, double to)
{
    pave_result result = PAVE_OK;
    int32_t width = s->drawing->width, rows = s->drawing->height << s->drawing->wraps;
    far_away(s->corners, width + 1);
    far_away(s->straight, width);
    s->step = step;
    for (s->done = 0; s->done < rows && !result; s->done += s->rows) {
        double at = from + (to - from) * s->done / rows;
        int32_t left = s->drawing->height - s->done % s->drawing->height; /* no row twice at a time */
        s->rows = left < ROWS ? left : ROWS;
        result = pv_parallel_runs(context, width + 1, STRIP, go_along_columns, s, at, at);
        if (!result)
            result = pv_parallel(context, s->rows, look_across, s, at, at);
    }
    return result;
}

static pave_result allocate(pave_context *context, sweep *s)
{
    pave_result result = PAVE_OK;
    size_t across = (size_t)s->drawing->width + 1, all = (size_t)s->columns * (size_t)pv_workers(context);
    s->corners = pv_allocate(context, across, sizeof *s->corners, &result);
    if (!result)
        s->straight = pv_allocate(context, across, sizeof *s->straight, &result);
    if (!result)
        s->heights = pv_allocate(context, ROWS * across, sizeof *s->heights, &result);
    if (!result && s->pad)
        s->wide = pv_allocate(context, all, sizeof *s->wide, &result);
    if (!result)
        s->apex = pv_allocate(context, all, sizeof *s->apex, &result);
    if (!result)
        s->from = pv_allocate(context, all, sizeof *s->from, &result);
    return result;
}

/* The nearest corner lies above or below: both sweeps look only their way, the smaller distance stays. */
pave_result pv_euclid(pave_context *context, const pv_drawing *d, int32_t *distance)
{
    int32_t pad = d->wraps ? d->width / 2 + 1 : 0;
    sweep s = { .drawing = d, .distance = distance, .columns = d->width + 1 + 2 * pad, .pad = pad };
    pave_result result = allocate(context, &s);
    if (!result)
        result = pv_parallel(context, d->height, look_along, &s, 0, 0.1);
    if (!result)
        result = go(context, &s, 1, 0.1, 0.5);
    if (!result)
        result = go(context, &s, -1, 0.5, 0.9);
    pv_release(s.corners);
    pv_release(s.straight);
    pv_release(s.heights);
    pv_release(s.wide);
    pv_release(s.apex);
    pv_release(s.from);
    return result;
}
