/* Found edges as chains, the longest first: one that comes near to another ends there, for no tile fits between. */
#include "mosaic/mosaic.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BORDER = 2 };

typedef struct chains {
    int32_t width, height, wraps, count;
    uint8_t *edge;
    int32_t *pixel;  /* of all chains, one after another */
    int32_t *first;  /* count + 1 */
    int32_t *order;  /* the longest first */
    uint8_t *near;   /* 1: within `apart` of a chain that stays */
} chains;

static int64_t at(const chains *c, int32_t x, int32_t y)
{
    return (int64_t)y * c->width + x;
}

/* Where the borders meet all places are, on the other side if need be. */
static int is_there(const chains *c, int32_t *x, int32_t *y)
{
    if (*x >= 0 && *y >= 0 && *x < c->width && *y < c->height)
        return 1;
    *x = pv_inside(*x, c->width, c->wraps);
    *y = pv_inside(*y, c->height, c->wraps);
    return c->wraps;
}

static int neighbours(const chains *c, int32_t pixel, int32_t found[8])
{
    int32_t x = pixel % c->width, y = pixel / c->width, count = 0;
    static const int8_t way[8][2] = { { 1, 0 }, { 0, 1 }, { -1, 0 }, { 0, -1 }, { 1, 1 }, { -1, 1 }, { -1, -1 },
                                      { 1, -1 } };
    for (int k = 0; k < 8; k++) {
        int32_t nx = x + way[k][0], ny = y + way[k][1];
        if (is_there(c, &nx, &ny) && c->edge[at(c, nx, ny)])
            found[count++] = (int32_t)at(c, nx, ny);
    }
    return count;
}

/* Follows a chain from a pixel to where it ends or forks, and takes its pixels away. */
static void walk(chains *c, int32_t start)
{
    int32_t here = start, found[8];
    for (int count = 1; count; here = found[0]) {
        c->edge[here] = 0;
        c->pixel[c->first[c->count + 1]++] = here;
        count = neighbours(c, here, found);
    }
}

/* Ends first, so that open chains are walked whole; what is left then are rings. */
static void take_apart(chains *c)
{
    int64_t pixels = (int64_t)c->width * c->height;
    int32_t found[8];
    for (int rings = 0; rings < 2; rings++)
        for (int64_t i = 0; i < pixels; i++) {
            if (!c->edge[i] || (!rings && neighbours(c, (int32_t)i, found) != 1))
                continue;
            c->first[c->count + 1] = c->first[c->count];
            walk(c, (int32_t)i);
            c->count++;
        }
}

static void stamp(chains *c, int32_t pixel, int32_t radius)
{
    int32_t px = pixel % c->width, py = pixel / c->width;
    for (int32_t y = py - radius; y <= py + radius; y++)
        for (int32_t x = px - radius; x <= px + radius; x++) {
            int32_t nx = x, ny = y;
            if ((x - px) * (x - px) + (y - py) * (y - py) <= radius * radius && is_there(c, &nx, &ny))
                c->near[at(c, nx, ny)] = 1;
        }
}

static int along_border(const chains *c, int32_t pixel)
{
    int32_t x = pixel % c->width, y = pixel / c->width;
    return !c->wraps && (x < BORDER || y < BORDER || x >= c->width - BORDER || y >= c->height - BORDER);
}

/* Keeps the runs of a chain that are long enough and by themselves. */
static void keep_runs(chains *c, int32_t chain, double least, int32_t radius)
{
    for (int32_t from = c->first[chain], to; from < c->first[chain + 1]; from = to + 1) {
        for (to = from; to < c->first[chain + 1]; to++)
            if (c->near[c->pixel[to]] || along_border(c, c->pixel[to]))
                break;
        if (to - from < least)
            continue;
        for (int32_t i = from; i < to; i++)
            c->edge[c->pixel[i]] = 1;
    }
    for (int32_t i = c->first[chain]; i < c->first[chain + 1]; i++)
        if (c->edge[c->pixel[i]])
            stamp(c, c->pixel[i], radius);
}

static int32_t length(const chains *c, int32_t chain)
{
    return c->first[chain + 1] - c->first[chain];
}

/* A counting sort by length; among equals the order stays. */
static pave_result sort_chains(pave_context *context, chains *c)
{
    pave_result result = PAVE_OK;
    int32_t longest = 0;
    for (int32_t i = 0; i < c->count; i++)
        longest = length(c, i) > longest ? length(c, i) : longest;
    int32_t *place = pv_allocate_zeroed(context, (size_t)longest + 2, sizeof *place, &result);
    for (int32_t i = 0; i < c->count && place; i++)
        place[longest - length(c, i) + 1]++;
    for (int32_t i = 0; i < longest && place; i++)
        place[i + 1] += place[i];
    for (int32_t i = 0; i < c->count && place; i++)
        c->order[place[longest - length(c, i)]++] = i;
    pv_release(place);
    return result;
}

pave_result pv_edges_clean(pave_context *context, double least, double apart, pave_guide *guide)
{
    chains c = { .width = guide->width, .height = guide->height, .wraps = guide->wraps, .edge = guide->edge };
    size_t pixels = (size_t)c.width * (size_t)c.height, marked = 0;
    pave_result result = PAVE_OK;
    for (size_t i = 0; i < pixels; i++)
        marked += guide->edge[i];
    c.pixel = pv_allocate(context, marked, sizeof *c.pixel, &result);
    if (!result)
        c.first = pv_allocate_zeroed(context, marked + 2, sizeof *c.first, &result);
    if (!result)
        c.order = pv_allocate(context, marked, sizeof *c.order, &result);
    if (!result)
        c.near = pv_allocate_zeroed(context, pixels, 1, &result);
    if (!result) {
        take_apart(&c);
        result = sort_chains(context, &c);
    }
    for (int32_t i = 0; i < c.count && !result; i++)
        keep_runs(&c, c.order[i], least, (int32_t)apart);
    pv_release(c.pixel);
    pv_release(c.first);
    pv_release(c.order);
    pv_release(c.near);
    return result;
}
