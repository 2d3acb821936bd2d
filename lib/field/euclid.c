/* Exact Euclidean distance from a pixel's centre to the frontier between two colours.
 *
 * The frontier is made of unit cracks between pixels. Seen from a pixel's centre its nearest point is either straight
 * ahead in the pixel's own row or column, or the end of a crack: a lattice corner. The first kind is a run length, the
 * second an ordinary distance transform of lattice corners (columns first, then the lower envelope of parabolas:
 * Felzenszwalb and Huttenlocher 2012). All in half pixels, so all integers. */
#include "field/field.h"

#include "util/fixed.h"

#include <math.h>

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

/* For every row of pixels: half pixels (odd) up or down to the nearest corner, for each of the width + 1 columns of
 * corners; also the straight distances along columns. `up` and `straight` carry over from row to row. */
static void down_columns(const pv_drawing *d, int32_t y, int32_t step, int32_t *corners, int32_t *straight,
                         int32_t *row)
{
    int32_t edge = step > 0 ? y : y + 1, before = y - step;
    if (d->wraps)
        before = before < 0 ? d->height - 1 : before < d->height ? before : 0;
    for (int32_t x = 0; x <= d->width; x++)
        corners[x] = corner(d, x, edge) ? 1 : corners[x] < INT32_MAX / 2 ? corners[x] + 2 : corners[x];
    for (int32_t x = 0; x < d->width; x++) {
        if (before >= 0 && before < d->height && differ(d, x, before, x, y))
            straight[x] = 1;
        else if (straight[x] < INT32_MAX / 2)
            straight[x] += 2;
        row[x] = nearer(row[x], straight[x]);
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

/* Scratch for rows: corner heights from above, from below (kept for every row), straight runs, envelope. */
typedef struct scratch {
    int32_t *above, *straight;
    int32_t *wide, pad; /* where the borders meet: `above` and half a turn more on both sides */
    envelope envelope;
} scratch;

static void look_across(const pv_drawing *d, scratch *s, int32_t *row)
{
    int32_t columns = d->width + 1 + 2 * s->pad;
    const int32_t *h = s->wide ? s->wide : s->above;
    for (int32_t i = 0, at = d->width - s->pad; i < columns && s->wide; i++, at++)
        s->wide[i] = s->above[at % d->width];
    build_envelope(&s->envelope, h, columns);
    to_corners(&s->envelope, h, s->pad, d->width, row);
}

static void far_away(int32_t *values, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        values[i] = INT32_MAX;
}

static pave_result sweep(pave_context *context, const pv_drawing *d, int32_t step, scratch *s, int32_t *distance)
{
    pave_result result = PAVE_OK;
    far_away(s->above, d->width + 1);
    far_away(s->straight, d->width);
    int32_t rows = d->height << d->wraps;
    for (int32_t i = 0; i < rows && !result; i++) {
        int32_t y = step > 0 ? i % d->height : d->height - 1 - i % d->height;
        int32_t *row = distance + (int64_t)y * d->width;
        if (step > 0 && i < d->height)
            along_row(d, y, row);
        down_columns(d, y, step, s->above, s->straight, row);
        look_across(d, s, row);
        if (i % 64 == 0)
            result = pv_progress(context, (step > 0 ? 0.0 : 0.45) + 0.45 * i / rows);
    }
    return result;
}

/* The nearest corner lies above or below: both sweeps look only their way, the smaller distance stays. */
pave_result pv_euclid(pave_context *context, const pv_drawing *d, int32_t *distance)
{
    pave_result result = PAVE_OK;
    int32_t pad = d->wraps ? d->width / 2 + 1 : 0;
    size_t columns = (size_t)d->width + 1 + 2 * (size_t)pad;
    scratch s = { .above = pv_allocate(context, columns, sizeof *s.above, &result), .pad = pad };
    if (!result && pad)
        s.wide = pv_allocate(context, columns, sizeof *s.wide, &result);
    if (!result)
        s.straight = pv_allocate(context, columns, sizeof *s.straight, &result);
    if (!result)
        s.envelope.apex = pv_allocate(context, columns, sizeof *s.envelope.apex, &result);
    if (!result)
        s.envelope.from = pv_allocate(context, columns, sizeof *s.envelope.from, &result);
    if (!result)
        result = sweep(context, d, 1, &s, distance);
    if (!result)
        result = sweep(context, d, -1, &s, distance);
    pv_release(s.above);
    pv_release(s.wide);
    pv_release(s.straight);
    pv_release(s.envelope.apex);
    pv_release(s.envelope.from);
    return result;
}
