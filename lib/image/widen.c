/* Thin features of a drawing made wide enough for stones.
 *
 * On half pixels, so that odd and even widths are alike. As wide as a feature is the largest disc in it that a place is
 * covered by (the granulometry of morphology); what no disc of the width wanted covers, nor the rounding of a right
 * angle's corner by such a disc can be blamed for, is thin, and grows by what it lacks on either side. */
#include "image/image.h"

#include "util/fixed.h"

#include <math.h>
#include <string.h>

/* All lengths are half pixels, all distances squared: from a half pixel's centre to the nearest one of another colour,
 * which is the radius of the largest disc around it. */
typedef struct widening {
    int32_t width, height; /* with what is around */
    int32_t least;         /* radius of a disc as wide as wanted */
    uint8_t *colour, *painted;
    uint16_t *gap;         /* along the row to another colour, not squared; then from what is painted */
    uint16_t *far, *wide;  /* to another colour; of the largest disc that covers a thin place */
} widening;

enum { MOST = 200, FAR = UINT16_MAX };

int32_t pv_widen_reach(int32_t least)
{
    return 2 * least + 6;
}

static void set_gaps(const widening *w, int32_t y)
{
    const uint8_t *colour = w->colour + (int64_t)y * w->width;
    uint16_t *gap = w->gap + (int64_t)y * w->width;
    for (int32_t x = 0; x < w->width; x++) {
        int32_t before = x ? gap[x - 1] + 1 : MOST;
        gap[x] = (uint16_t)(x && colour[x] != colour[x - 1] ? 1 : before < MOST ? before : MOST);
    }
    for (int32_t x = w->width - 1, after = MOST; x >= 0; x--) {
        after = x + 1 == w->width ? MOST : colour[x] != colour[x + 1] ? 1 : after + 1;
        if (after < gap[x])
            gap[x] = (uint16_t)after;
    }
}

/* The nearest on row y, `k` away, squared. */
static int32_t on_row(const widening *w, int32_t x, int64_t at, int32_t k, int32_t y)
{
    if (y < 0 || y >= w->height)
        return FAR;
    int64_t there = (int64_t)y * w->width + x;
    int32_t gap = w->colour[there] == w->colour[at] ? w->gap[there] : 0;
    return k * k + gap * gap;
}

static void set_far(const widening *w, int32_t y)
{
    for (int32_t x = 0; x < w->width; x++) {
        int64_t at = (int64_t)y * w->width + x;
        int32_t best = w->gap[at] * w->gap[at];
        for (int32_t k = 1; k * k < best && k < w->least; k++) {
            int32_t up = on_row(w, x, at, k, y - k), down = on_row(w, x, at, k, y + k);
            best = up < best ? up : best;
            best = down < best ? down : best;
        }
        w->far[at] = (uint16_t)(best < FAR ? best : FAR);
    }
}

static int is_wide_near(const widening *w, int32_t x, int32_t y)
{
    int32_t reach = (17 * w->least + 11) / 12 + 2; /* a little more than from a corner to the disc in it */
    uint8_t colour = w->colour[(int64_t)y * w->width + x];
    for (int32_t dy = -reach; dy <= reach; dy++)
        for (int32_t dx = -reach; dx <= reach; dx++) {
            int32_t tx = x + dx, ty = y + dy;
            if (tx < 0 || ty < 0 || tx >= w->width || ty >= w->height || dx * dx + dy * dy > reach * reach)
                continue;
            int64_t at = (int64_t)ty * w->width + tx;
            if (w->colour[at] == colour && w->far[at] >= w->least * w->least)
                return 1;
        }
    return 0;
}

typedef void visit(const widening *w, int64_t at, int32_t square, int64_t middle);

/* Half pixels nearer than the root of `square` to one. */
static void visit_disc(const widening *w, int32_t x, int32_t y, int32_t square, visit *call)
{
    int32_t reach = (int32_t)pv_isqrt((uint64_t)square);
    for (int32_t dy = -reach; dy <= reach; dy++)
        for (int32_t dx = -reach; dx <= reach; dx++) {
            int32_t tx = x + dx, ty = y + dy, far = dx * dx + dy * dy;
            if (far < square && tx >= 0 && ty >= 0 && tx < w->width && ty < w->height)
                call(w, (int64_t)ty * w->width + tx, far, (int64_t)y * w->width + x);
        }
}

static void cover(const widening *w, int64_t at, int32_t square, int64_t middle)
{
    (void)square;
    if (w->far[middle] > w->wide[at])
        w->wide[at] = w->far[middle];
}

/* Where two colours would grow what is nearer decides. */
static void paint(const widening *w, int64_t at, int32_t square, int64_t middle)
{
    if (square > w->gap[at] || (square == w->gap[at] && w->colour[middle] >= w->painted[at]))
        return;
    w->gap[at] = (uint16_t)square;
    w->painted[at] = w->colour[middle];
}

static pave_result widen(pave_context *context, const widening *w)
{
    pave_result result = PAVE_OK;
    size_t pixels = (size_t)w->width * (size_t)w->height;
    memset(w->wide, 0, pixels * sizeof *w->wide);
    memset(w->gap, 255, pixels * sizeof *w->gap);
    memcpy(w->painted, w->colour, pixels);
    for (int32_t y = 0; y < w->height && !result; y++) {
        for (int32_t x = 0; x < w->width; x++) {
            int64_t at = (int64_t)y * w->width + x;
            if (w->far[at] < w->least * w->least && !is_wide_near(w, x, y))
                visit_disc(w, x, y, w->far[at], cover);
        }
        if (y % 256 == 0)
            result = pv_progress(context, 0.3 + 0.5 * y / w->height);
    }
    for (int32_t y = 0; y < w->height && !result; y++)
        for (int32_t x = 0; x < w->width; x++) {
            int64_t at = (int64_t)y * w->width + x;
            double lack = w->least - sqrt(w->wide[at]);
            if (w->wide[at] && lack > 0)
                visit_disc(w, x, y, (int32_t)(lack * lack) + 1, paint);
        }
    return result;
}

static int32_t place_in(int32_t at, int32_t length, int repeats)
{
    return repeats ? pv_modulo(at, length) : at < 0 ? 0 : at < length ? at : length - 1;
}

/* The drawing with some of what repeats, or of its rim, around it. */
static void read_colours(const widening *w, const pave_image *drawing, int32_t around, int repeats)
{
    const uint8_t *pixels = drawing->pixels;
    for (int32_t y = 0; y < w->height; y++) {
        const uint8_t *row = pixels + (int64_t)place_in(y / 2 - around, drawing->height, repeats) * drawing->width;
        for (int32_t x = 0; x < w->width; x++)
            w->colour[(int64_t)y * w->width + x] = row[place_in(x / 2 - around, drawing->width, repeats)];
    }
}

static pave_result allocate(pave_context *context, widening *w)
{
    size_t pixels = (size_t)w->width * (size_t)w->height;
    pave_result result = PAVE_OK;
    w->colour = pv_allocate(context, pixels, 1, &result);
    if (!result)
        w->painted = pv_allocate(context, pixels, 1, &result);
    if (!result)
        w->gap = pv_allocate(context, pixels, sizeof *w->gap, &result);
    if (!result)
        w->far = pv_allocate(context, pixels, sizeof *w->far, &result);
    if (!result)
        w->wide = pv_allocate(context, pixels, sizeof *w->wide, &result);
    return result;
}

static pave_result make(pave_context *context, const pave_image *drawing, int32_t around, int repeats, widening *w)
{
    pave_result result = allocate(context, w);
    if (result)
        return result;
    read_colours(w, drawing, around, repeats);
    for (int32_t y = 0; y < w->height; y++)
        set_gaps(w, y);
    for (int32_t y = 0; y < w->height && !result; y++) {
        set_far(w, y);
        if (y % 256 == 0)
            result = pv_progress(context, 0.3 * y / w->height);
    }
    return result ? result : widen(context, w);
}

/* Pixels half of which have been painted. */
static void take_inner(const widening *w, int32_t around, const pave_image *drawing, pave_image *out)
{
    for (int32_t y = 0; y < out->height; y++)
        for (int32_t x = 0; x < out->width; x++) {
            const uint8_t *half = w->painted + (int64_t)2 * (y + around) * w->width + 2 * (x + around);
            uint8_t all[4] = { half[0], half[1], half[w->width], half[w->width + 1] };
            int64_t at = (int64_t)y * out->width + x;
            uint8_t was = ((const uint8_t *)drawing->pixels)[at], is = was;
            for (int i = 0; i < 4; i++)
                for (int k = 0; k < i; k++)
                    is = all[i] == all[k] && all[i] != was ? all[i] : is;
            ((uint8_t *)out->pixels)[at] = is;
            if (out->levels)
                out->levels[at] = is == was ? drawing->levels[at] : is;
        }
}

pave_result pave_image_widen(pave_context *context, const pave_image *drawing, double least, int32_t periodic,
                             pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !drawing || !out)
        return PAVE_ERR_ARGUMENT;
    if (drawing->channels != 1 || drawing->type != PAVE_U8)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a drawing has one 8-bit channel: call pave_image_threshold first");
    if (!(least >= 0 && least <= MOST))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "features can be widened to 0 .. %d px, not to %g", MOST, least);
    widening w = { .least = (int32_t)floor(least + 0.5) };
    int32_t around = pv_widen_reach(w.least);
    w.width = 2 * (drawing->width + 2 * around);
    w.height = 2 * (drawing->height + 2 * around);
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = drawing->width;
    shape.height = drawing->height;
    pv_call call = pv_call_begin(context, "widen", 0, 1);
    pave_result result = pv_image_new(context, &shape, out);
    if (!result && drawing->levels)
        result = pv_levels_new(context, *out, drawing->cut);
    if (!result)
        result = make(context, drawing, around, periodic, &w);
    if (!result) {
        (*out)->place = drawing->place;
        (*out)->palette = drawing->palette;
        (*out)->hash = drawing->hash;
        take_inner(&w, around, drawing, *out);
    } else {
        pave_image_free(out);
    }
    pv_call_end(context, call);
    pv_release(w.colour);
    pv_release(w.painted);
    pv_release(w.gap);
    pv_release(w.far);
    pv_release(w.wide);
    return result;
}

pave_result pv_image_crop(pave_context *context, const pave_image *drawing, pv_place part, pave_image **out)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = part.width;
    shape.height = part.height;
    pave_result result = pv_image_new(context, &shape, out);
    if (result)
        return result;
    (*out)->place = drawing->place;
    (*out)->place.x += part.x;
    (*out)->place.y += part.y;
    (*out)->palette = drawing->palette;
    (*out)->hash = drawing->hash;
    if (drawing->levels)
        result = pv_levels_new(context, *out, drawing->cut);
    for (int32_t y = 0; y < part.height && !result; y++) {
        int64_t to = (int64_t)y * part.width, from = (int64_t)(y + part.y) * drawing->width + part.x;
        memcpy((uint8_t *)(*out)->pixels + to, (const uint8_t *)drawing->pixels + from, (size_t)part.width);
        if (drawing->levels)
            memcpy((*out)->levels + to, drawing->levels + from, (size_t)part.width);
    }
    if (result)
        pave_image_free(out);
    return result;
}
