/* The colours of tiles (5.1): the mean light under each, or its centre's pixel; of a palette where there is one. */
#include "mosaic/cover.h"
#include "mosaic/mosaic.h"

#include "base/parallel.h"

#include <math.h>
#include <stdlib.h>

enum { CHUNK = 64 };

typedef struct colouring {
    const pv_work *w;
    pave_stones *stones;
    double *light; /* 3 a tile */
} colouring;

static void add_pixel(const pv_work *w, int32_t x, int32_t y, double light[3], int64_t *count)
{
    x = x < 0 ? 0 : x < w->width ? x : w->width - 1;
    y = y < 0 ? 0 : y < w->height ? y : w->height - 1;
    const float *from = w->photo.light + 3 * ((int64_t)y * w->width + x);
    for (int c = 0; c < 3; c++)
        light[c] += (double)from[c];
    ++*count;
}

static void add_area(const pv_work *w, const pave_stones *s, int32_t tile, double light[3], int64_t *count)
{
    int32_t from[PV_COVER_RUNS], to[PV_COVER_RUNS];
    pv_cover cover = pv_cover_of(s->vertices + 2 * s->starts[tile], s->starts[tile + 1] - s->starts[tile], w->width,
                                 w->height);
    for (int32_t y = cover.top; y < cover.bottom; y++)
        for (int32_t k = pv_cover_row(&cover, y, from, to) - 1; k >= 0; k--)
            for (int32_t x = from[k]; x < to[k]; x++)
                add_pixel(w, x, y, light, count);
}

static void colour_tile(const colouring *c, int32_t tile)
{
    const pave_stones *s = c->stones;
    double *light = c->light + 3 * (int64_t)tile, x = 0, y = 0;
    int64_t count = 0, corners = s->starts[tile + 1] - s->starts[tile];
    light[0] = light[1] = light[2] = 0;
    if (c->w->params->colour == PAVE_COLOUR_AREA)
        add_area(c->w, s, tile, light, &count);
    for (int64_t i = s->starts[tile]; i < s->starts[tile + 1]; i++) {
        x += s->vertices[2 * i] / (double)corners;
        y += s->vertices[2 * i + 1] / (double)corners;
    }
    if (!count)
        add_pixel(c->w, (int32_t)floor(x), (int32_t)floor(y), light, &count);
    for (int k = 0; k < 3; k++) {
        light[k] /= (double)count;
        s->rgb[3 * tile + k] = pv_tile_code(light[k]);
    }
}

static void colour_chunk(void *data, int32_t chunk, int32_t worker)
{
    (void)worker;
    const colouring *c = data;
    for (int32_t i = chunk * CHUNK; i < (chunk + 1) * CHUNK && i < c->stones->count; i++)
        colour_tile(c, i);
}

/* A tile and a colour that it could have. */
typedef struct match {
    float difference;
    int32_t tile, colour;
} match;

static int compare(const void *a, const void *b)
{
    const match *p = a, *q = b;
    if (p->difference < q->difference || p->difference > q->difference)
        return p->difference < q->difference ? -1 : 1;
    return p->tile != q->tile ? (p->tile < q->tile ? -1 : 1) : (p->colour > q->colour) - (p->colour < q->colour);
}

static pave_result check_palette(pave_context *context, const colouring *c)
{
    const pave_mosaic_sources *sources = c->w->sources;
    int64_t all = 0;
    for (int32_t i = 0; sources->stock && i < sources->palette_count; i++)
        all += sources->stock[i] > 0 ? sources->stock[i] : 0;
    if (sources->palette_count < 1 || sources->palette_count > 65536)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a palette has 1 to 65536 colours, not %d",
                       (int)sources->palette_count);
    if (sources->stock && all < c->stones->count)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%d tiles are more than the %lld in stock", (int)c->stones->count,
                       (long long)all);
    return PAVE_OK;
}

static void compare_colours(const colouring *c, match *matches)
{
    const pave_mosaic_sources *sources = c->w->sources;
    for (int32_t k = 0; k < sources->palette_count; k++) {
        double light[3], colour[3], tile[3];
        for (int i = 0; i < 3; i++)
            light[i] = pv_tile_light(sources->palette[3 * k + i] / 255.0);
        pv_tile_lab(light, colour);
        for (int32_t t = 0; t < c->stones->count; t++) {
            pv_tile_lab(c->light + 3 * (int64_t)t, tile);
            matches[(int64_t)k * c->stones->count + t] = (match){ (float)pv_ciede2000(tile, colour), t, k };
        }
    }
}

/* The best match of all first, as long as there is one in stock. */
static void deal(const colouring *c, const match *matches, int64_t count, int32_t *used, uint8_t *done)
{
    const pave_mosaic_sources *sources = c->w->sources;
    for (int64_t i = 0; i < count; i++) {
        const match *m = &matches[i];
        if (done[m->tile] || (sources->stock && used[m->colour] >= sources->stock[m->colour]))
            continue;
        done[m->tile] = 1;
        used[m->colour]++;
        for (int k = 0; k < 3; k++)
            c->stones->rgb[3 * m->tile + k] = sources->palette[3 * m->colour + k];
    }
}

static pave_result use_palette(pave_context *context, const colouring *c)
{
    int64_t tiles = c->stones->count, colours = c->w->sources->palette_count;
    pave_result result = check_palette(context, c);
    if (result)
        return result;
    match *matches = pv_allocate(context, (size_t)(tiles * colours), sizeof *matches, &result);
    int32_t *used = result ? NULL : pv_allocate_zeroed(context, (size_t)colours, sizeof *used, &result);
    uint8_t *done = result ? NULL : pv_allocate_zeroed(context, (size_t)tiles, 1, &result);
    if (!result) {
        compare_colours(c, matches);
        qsort(matches, (size_t)(tiles * colours), sizeof *matches, compare);
        deal(c, matches, tiles * colours, used, done);
    }
    pv_release(matches);
    pv_release(used);
    pv_release(done);
    return result;
}

/* The grey of each colour, for formats that know no other. */
static void grey(pave_stones *s)
{
    for (int32_t i = 0; i < s->count; i++)
        s->colours[i] = (uint8_t)((299 * s->rgb[3 * i] + 587 * s->rgb[3 * i + 1] + 114 * s->rgb[3 * i + 2]) / 1000);
}

pave_result pv_tiles_colour(pave_context *context, const pv_work *w, pave_stones *stones)
{
    pave_result result = PAVE_OK;
    colouring c = { w, stones, NULL };
    size_t n = (size_t)stones->count;
    stones->rgb = pv_allocate(context, n, 3, &result);
    if (!result)
        stones->colours = pv_allocate(context, n, 1, &result);
    if (!result)
        c.light = pv_allocate(context, n, 3 * sizeof *c.light, &result);
    if (!result)
        result = pv_parallel(context, (stones->count + CHUNK - 1) / CHUNK, colour_chunk, &c, 0, 0.5);
    if (!result && w->sources->palette)
        result = use_palette(context, &c);
    if (!result)
        grey(stones);
    pv_release(c.light);
    return result;
}
