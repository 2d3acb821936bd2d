/* Tiles with candidate lists, in portable C.
 *
 * A site can own a pixel of a tile only if its distance from the tile's centre is at most the least such distance plus
 * twice the tile's radius: no metric changes by more than the way walked. `slack` covers the rounding. Buckets beyond
 * the range of that distance need not be looked into. */
#include "backend/cpu.h"
#include "backend/metric.h"

#include <math.h>
#include <string.h>

enum { CAPACITY = 48, PIXELS = PV_TILE * PV_TILE };

typedef struct tile {
    int32_t x0, y0; /* first pixel */
    int32_t cx, cy; /* centre, 1/256 px */
    int32_t count;  /* candidates, or CAPACITY + 1: too many */
    int32_t narrow; /* 32 bits are enough */
    int32_t index[CAPACITY + 1];
    pave_site site[CAPACITY + 1];
    uint8_t owner[PIXELS]; /* local index of each pixel's site */
} tile;

typedef struct box {
    int32_t left, right, top, bottom;
} box;

/* How far a computed distance of about `d` may be from the true one. */
static double slack(const pv_cpu *cpu, double d)
{
    return PV_METRIC_SLACK + (d * cpu->stretch + cpu->reach) * 0x1p-14;
}

/* The buckets within `radius` (1/256 px) of a point. */
static box buckets_within(const pv_cpu *cpu, int32_t x, int32_t y, double radius)
{
    double b = cpu->bucket;
    double l = floor((x - radius) / b), r = floor((x + radius) / b);
    double t = floor((y - radius) / b), d = floor((y + radius) / b);
    return (box){ l > 0 ? (int32_t)l : 0, r < cpu->across - 1 ? (int32_t)r : cpu->across - 1,
                  t > 0 ? (int32_t)t : 0, d < cpu->down - 1 ? (int32_t)d : cpu->down - 1 };
}

/* Least squared distance in the buckets of a row range, lowest index first among equals. */
static void search_run(const pv_cpu *cpu, int32_t row, int32_t left, int32_t right, int32_t x, int32_t y,
                       uint64_t *least, int32_t *label)
{
    const int32_t *first = cpu->first + (int64_t)row * cpu->across;
    for (int32_t i = first[left]; i < first[right + 1]; i++) {
        uint64_t d = pv_metric(cpu->plane.metric, pv_cpu_sorted(cpu, i), x, y);
        if (d < *least || (d == *least && cpu->index[i] < *label))
            *least = d, *label = cpu->index[i];
    }
}

/* Rings of buckets around (x, y) until no box farther out can be as near. */
static int32_t nearest(const pv_cpu *cpu, int32_t x, int32_t y, uint64_t *least)
{
    int32_t bx = x / cpu->bucket, by = y / cpu->bucket, label = INT32_MAX;
    int32_t rings = cpu->across > cpu->down ? cpu->across : cpu->down;
    bx = bx < cpu->across ? bx : cpu->across - 1;
    by = by < cpu->down ? by : cpu->down - 1;
    *least = UINT64_MAX;
    for (int32_t ring = 0; ring <= rings; ring++) {
        double gap = (((double)ring - 1) * cpu->bucket - cpu->reach) / cpu->stretch;
        gap -= slack(cpu, gap);
        if (*least != UINT64_MAX && gap > 0 && gap * gap > (double)*least)
            break;
        int32_t left = bx - ring > 0 ? bx - ring : 0, right = bx + ring < cpu->across ? bx + ring : cpu->across - 1;
        for (int32_t row = by - ring; row <= by + ring; row++) {
            if (row < 0 || row >= cpu->down)
                continue;
            if (row == by - ring || row == by + ring) {
                search_run(cpu, row, left, right, x, y, least, &label);
                continue;
            }
            if (bx - ring >= 0)
                search_run(cpu, row, bx - ring, bx - ring, x, y, least, &label);
            if (bx + ring < cpu->across)
                search_run(cpu, row, bx + ring, bx + ring, x, y, least, &label);
        }
    }
    return label;
}

int32_t pv_label_pixel(const pv_cpu *cpu, int32_t px, int32_t py)
{
    uint64_t least;
    return nearest(cpu, 256 * px + 128, 256 * py + 128, &least);
}

static void add_candidate(tile *t, int32_t index, const pave_site *site)
{
    int32_t at = t->count++;
    for (; at > 0 && t->index[at - 1] > index; at--) {
        t->index[at] = t->index[at - 1];
        t->site[at] = t->site[at - 1];
    }
    t->index[at] = index;
    t->site[at] = *site;
}

static int is_narrow(const tile *t, const pave_site *site)
{
    int64_t dx = (int64_t)t->cx - site->x, dy = (int64_t)t->cy - site->y, most = PV_METRIC_NARROW - PV_TILE_RADIUS;
    return dx * dx + dy * dy < most * most;
}

/* Fills the tile's list in index order. Returns how far a pixel can be from its site. */
static int32_t find_candidates(const pv_cpu *cpu, tile *t)
{
    uint64_t least;
    nearest(cpu, t->cx, t->cy, &least);
    double bound = sqrt((double)least) + 2 * PV_TILE_RADIUS;
    bound += 4 * slack(cpu, bound);
    uint64_t within = (uint64_t)(bound * bound);
    int32_t radius = pv_cpu_range(cpu, bound - PV_TILE_RADIUS);
    box b = buckets_within(cpu, t->cx, t->cy, (bound + slack(cpu, bound)) * cpu->stretch + cpu->reach);
    t->count = 0;
    t->narrow = 1;
    for (int32_t row = b.top; row <= b.bottom; row++) {
        const int32_t *first = cpu->first + (int64_t)row * cpu->across;
        for (int32_t i = first[b.left]; i < first[b.right + 1]; i++) {
            const pave_site *site = pv_cpu_sorted(cpu, i);
            if (pv_metric(cpu->plane.metric, site, t->cx, t->cy) > within)
                continue;
            if (t->count == CAPACITY) {
                t->count = CAPACITY + 1;
                return radius;
            }
            t->narrow &= is_narrow(t, site);
            add_candidate(t, cpu->index[i], site);
        }
    }
    return radius;
}

/* One candidate against every pixel of the tile: pv_metric in 32 bits, modulo 2^32 until the shift. Inlined for each
 * metric. */
static inline void offer(int32_t metric, const tile *t, int32_t k, uint32_t *least, uint8_t *owner)
{
    const pave_site *s = &t->site[k];
    uint32_t dx = (uint32_t)(256 * t->x0 + 128 - s->x), dy = (uint32_t)(256 * t->y0 + 128 - s->y);
    uint32_t c = (uint32_t)s->cosine, n = (uint32_t)s->sine, a = (uint32_t)s->half_x, b = (uint32_t)s->half_y;
    uint32_t u0 = dx * c + dy * n + 32768, v0 = dy * c - dx * n + 32768;
    for (uint32_t i = 0; i < PIXELS; i++) {
        uint32_t x = i % PV_TILE * 256, y = i / PV_TILE * 256;
        int32_t su = (int32_t)(u0 + x * c + y * n) >> 16, sv = (int32_t)(v0 + y * c - x * n) >> 16;
        uint32_t u = (uint32_t)(su < 0 ? -su : su), v = (uint32_t)(sv < 0 ? -sv : sv), d;
        if (metric == PAVE_METRIC_BOX) {
            u = u > a ? u - a : 0;
            v = v > b ? v - b : 0;
            d = u * u + v * v;
        } else {
            u = u * a >> 16;
            v = v * b >> 16;
            u = metric == PAVE_METRIC_DIAMOND ? u + v : u > v ? u : v;
            d = u * u;
        }
        owner[i] = d < least[i] ? (uint8_t)k : owner[i];
        least[i] = d < least[i] ? d : least[i];
    }
}

static void offer_narrow(int32_t metric, const tile *t, int32_t k, uint32_t *least, uint8_t *owner)
{
    if (metric == PAVE_METRIC_BOX)
        offer(PAVE_METRIC_BOX, t, k, least, owner);
    else if (metric == PAVE_METRIC_SQUARE)
        offer(PAVE_METRIC_SQUARE, t, k, least, owner);
    else
        offer(PAVE_METRIC_DIAMOND, t, k, least, owner);
}

static void offer_wide(int32_t metric, const tile *t, int32_t k, uint64_t *least, uint8_t *owner)
{
    for (int32_t i = 0; i < PIXELS; i++) {
        int32_t x = t->x0 + i % PV_TILE, y = t->y0 + i / PV_TILE;
        uint64_t d = pv_metric(metric, &t->site[k], 256 * x + 128, 256 * y + 128);
        owner[i] = d < least[i] ? (uint8_t)k : owner[i];
        least[i] = d < least[i] ? d : least[i];
    }
}

/* Returns the greatest squared distance of a pixel from its site. */
static uint64_t decide(int32_t metric, tile *t)
{
    uint64_t most = 0;
    uint32_t narrow[PIXELS];
    uint64_t wide[PIXELS];
    memset(narrow, 0xff, sizeof narrow);
    memset(wide, 0xff, sizeof wide);
    memset(t->owner, 0, sizeof t->owner);
    for (int32_t k = 0; k < t->count; k++) {
        if (t->narrow)
            offer_narrow(metric, t, k, narrow, t->owner);
        else
            offer_wide(metric, t, k, wide, t->owner);
    }
    for (int32_t i = 0; i < PIXELS; i++) {
        uint64_t d = t->narrow ? narrow[i] : wide[i];
        most = d > most ? d : most;
    }
    return most;
}

static void collect(const pv_cpu *cpu, const tile *t, pv_sum *sums, int32_t *labels)
{
    int32_t right = t->x0 + PV_TILE < cpu->plane.width ? t->x0 + PV_TILE : cpu->plane.width;
    int32_t bottom = t->y0 + PV_TILE < cpu->plane.height ? t->y0 + PV_TILE : cpu->plane.height;
    uint64_t mask = pv_tile_mask(&cpu->plane, t->x0, t->y0);
    for (int32_t y = t->y0; y < bottom; y++)
        for (int32_t x = t->x0; x < right; x++) {
            int32_t label = t->count > CAPACITY
                                ? pv_label_pixel(cpu, x, y)
                                : t->index[t->owner[(y - t->y0) * PV_TILE + x - t->x0]];
            if (!(mask >> ((y - t->y0) * PV_TILE + x - t->x0) & 1))
                pv_sum_add(&sums[label], 1, x, y);
            if (labels)
                labels[(int64_t)y * cpu->plane.width + x] = label;
        }
}

int32_t pv_label_tile_portable(const pv_cpu *cpu, int32_t x, int32_t y, pv_sum *sums, int32_t *labels)
{
    tile t;
    t.x0 = x;
    t.y0 = y;
    t.cx = 256 * (x + PV_TILE / 2);
    t.cy = 256 * (y + PV_TILE / 2);
    int32_t radius = find_candidates(cpu, &t);
    if (t.count <= CAPACITY) {
        double most = sqrt((double)decide(cpu->plane.metric, &t));
        int32_t far = pv_cpu_range(cpu, most + 1 + slack(cpu, most));
        radius = far < radius ? far : radius;
    }
    collect(cpu, &t, sums, labels);
    return radius;
}

int32_t pv_label_row_portable(const pv_cpu *cpu, int32_t ty, pv_sum *sums, int32_t *labels)
{
    int32_t radius = 0;
    for (int32_t x = 0; x < cpu->plane.width; x += PV_TILE) {
        int32_t here = pv_label_tile_portable(cpu, x, ty * PV_TILE, sums, labels);
        radius = here > radius && pv_watched(cpu, x, ty * PV_TILE) ? here : radius;
    }
    return radius;
}
