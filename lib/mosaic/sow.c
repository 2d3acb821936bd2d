/* The first sites (5.2): as dense as tiles are to be small. Stratified: the plane is halved again and again, each part
 * with its share of the sites, until there is one site in a part; or by the text's rejection sampling. */
#include "mosaic/mosaic.h"

#include "util/random.h"

#include <math.h>

typedef struct sower {
    const pv_work *w;
    uint64_t *sum; /* of densities above and left of a pixel's corner, (width + 1) a row */
    pave_site *sites;
    int32_t count;
} sower;

typedef struct part {
    int32_t left, top, right, bottom; /* px */
} part;

/* In 1/65536 of the greatest: (s_min / s)^2, and 0 in holes. */
static uint32_t density(const pv_work *w, int64_t i)
{
    double s = w->size ? w->size_min / (double)w->size[i] : 1;
    return w->photo.hole && w->photo.hole[i] ? 0 : (uint32_t)(s * s * 65536 + 0.5);
}

static uint64_t mass(const sower *s, part p)
{
    size_t row = (size_t)s->w->width + 1, top = (size_t)p.top * row, bottom = (size_t)p.bottom * row;
    return s->sum[bottom + (size_t)p.right] - s->sum[bottom + (size_t)p.left] - s->sum[top + (size_t)p.right] +
           s->sum[top + (size_t)p.left];
}

static void add_up(sower *s)
{
    const pv_work *w = s->w;
    size_t row = (size_t)w->width + 1;
    for (int32_t y = 0; y < w->height; y++) {
        uint64_t run = 0;
        for (int32_t x = 0; x < w->width; x++) {
            run += density(w, (int64_t)y * w->width + x);
            s->sum[((size_t)y + 1) * row + (size_t)x + 1] = s->sum[(size_t)y * row + (size_t)x + 1] + run;
        }
    }
}

/* The part's share up to `at`, in x or in y. */
static part cut(part p, int across, int32_t at)
{
    if (across)
        p.right = at;
    else
        p.bottom = at;
    return p;
}

/* Where the first `few` of `count` sites' share of the density ends. */
static int32_t find_cut(const sower *s, part p, int across, int32_t few, int32_t count)
{
    int32_t low = across ? p.left : p.top, high = across ? p.right : p.bottom;
    double wanted = (double)mass(s, p) * few / count;
    while (high - low > 1) {
        int32_t middle = low + (high - low) / 2;
        if ((double)mass(s, cut(p, across, middle)) <= wanted)
            low = middle;
        else
            high = middle;
    }
    double below = (double)mass(s, cut(p, across, low)), above = (double)mass(s, cut(p, across, high));
    return wanted - below <= above - wanted ? low : high;
}

/* A site at random in a part, as likely at each pixel as its density. */
static void place(sower *s, part p)
{
    const pv_work *w = s->w;
    pv_random r = pv_draw(w->params->seed, PV_DRAW_SITES, (uint32_t)s->count, 0, 1);
    uint64_t all = mass(s, p), target = all ? ((uint64_t)r.word[2] << 32 | r.word[3]) % all : 0;
    int32_t row = p.top, x = p.left;
    for (int step = 0; step < 2 && all; step++) { /* the row, then the pixel in it */
        part line = step ? (part){ p.left, row, p.right, row + 1 } : p;
        int32_t low = step ? p.left : p.top, high = step ? p.right : p.bottom;
        while (high - low > 1) {
            int32_t middle = low + (high - low) / 2;
            if (mass(s, cut(line, step, middle)) <= target)
                low = middle;
            else
                high = middle;
        }
        target -= mass(s, cut(line, step, low));
        *(step ? &x : &row) = low;
    }
    int32_t dx = (int32_t)(r.word[0] >> 24), dy = (int32_t)(r.word[1] >> 24);
    s->sites[s->count++] = (pave_site){ .x = 256 * x + dx, .y = 256 * row + dy };
}

/* Near the middle, if all of the part is as dense. */
static void place_near_middle(sower *s, part p)
{
    pv_random r = pv_draw(s->w->params->seed, PV_DRAW_SITES, (uint32_t)s->count, 0, 1);
    int32_t width = 256 * (p.right - p.left), height = 256 * (p.bottom - p.top);
    int32_t x = 256 * p.left + width * 3 / 8 + (int32_t)pv_below(r.word[0], (uint32_t)width / 4 + 1);
    int32_t y = 256 * p.top + height * 3 / 8 + (int32_t)pv_below(r.word[1], (uint32_t)height / 4 + 1);
    s->sites[s->count++] = (pave_site){ .x = x, .y = y };
}

static void divide(sower *s, part p, int32_t count)
{
    if (count == 1) {
        if (s->w->photo.hole || p.right == p.left || p.bottom == p.top)
            place(s, p);
        else
            place_near_middle(s, p);
        return;
    }
    int across = p.right - p.left >= p.bottom - p.top;
    int32_t few = count / 2, at = find_cut(s, p, across, few, count);
    divide(s, cut(p, across, at), few);
    part rest = p;
    *(across ? &rest.left : &rest.top) = at;
    divide(s, rest, count - few);
}

/* Draws until all are placed; each draw is accepted as the density says. */
static pave_result sample(pave_context *context, sower *s)
{
    const pv_work *w = s->w;
    pave_result result = PAVE_OK;
    for (uint32_t k = 0; s->count < w->n && !result; k++) {
        pv_random r = pv_draw(w->params->seed, PV_DRAW_SITES, k, 0, 2);
        int32_t x = (int32_t)pv_below(r.word[0], (uint32_t)(256 * w->width));
        int32_t y = (int32_t)pv_below(r.word[1], (uint32_t)(256 * w->height));
        if (pv_below(r.word[2], 65536) < density(w, (int64_t)(y >> 8) * w->width + (x >> 8)))
            s->sites[s->count++] = (pave_site){ .x = x, .y = y };
        if (k % 65536 == 65535)
            result = k == UINT32_MAX ? PAVE_ERR_INTERNAL : pv_progress(context, 0);
    }
    return result;
}

pave_result pv_sites_sow(pave_context *context, const pv_work *w, pave_site *sites, int32_t *count)
{
    sower s = { .w = w, .sites = sites };
    pave_result result = PAVE_OK;
    if (w->params->start == PAVE_START_RANDOM) {
        result = sample(context, &s);
    } else {
        s.sum = pv_allocate_zeroed(context, ((size_t)w->width + 1) * ((size_t)w->height + 1), sizeof *s.sum, &result);
        if (!result) {
            add_up(&s);
            divide(&s, (part){ 0, 0, w->width, w->height }, w->n);
        }
        pv_release(s.sum);
    }
    *count = s.count;
    return result;
}
