/* First sites (III.B): uniform at random with the density of Eq. 1, in an order that belongs to the plane.
 *
 * The plane's lattice has cells of 2h x 2h, one to a stone. Each block of 8 x 8 cells draws 64 sites uniformly (one
 * jittered site a cell would stay visible for ever), sorts them by cell, and keeps those inside the drawing. In a plane
 * that repeats, cells are so wide that a whole number fits, and so are blocks: each has up to 8 x 8 cells and draws as
 * many sites as it has cells. There blocks are counted on and on, but what is drawn in them repeats. */
#include "backend/relax.h"
#include "cvd/cvd.h"
#include "util/lattice.h"
#include "util/random.h"

enum { SIDE = 8, DRAWS = SIDE * SIDE };

/* The plane's blocks in one direction, and the region's part of them. */
typedef struct axis {
    pv_lattice lattice;
    int32_t blocks;      /* in a period; 0: it does not repeat */
    int64_t from, to;    /* the region, 1/256 px */
    int32_t first, last; /* the blocks that it touches: first .. last - 1 */
    int64_t cells;       /* of these blocks */
} axis;

/* A row of cells that a block has in one direction. */
typedef struct strip {
    int32_t key;          /* what the block's draws are counted by */
    int32_t first, cells;
    int64_t start;        /* in the first period, 1/256 px */
    int32_t length;
    int64_t shift;        /* from there to where the block lies */
} strip;

static strip strip_of(const axis *a, int32_t block)
{
    int64_t period = a->blocks ? pv_floor_div(block, a->blocks) : 0;
    int32_t key = (int32_t)(block - period * a->blocks), n = a->lattice.cells, end = SIDE * (key + 1);
    strip e = { .key = key, .first = SIDE * key, .shift = period * a->lattice.span };
    if (a->blocks) {
        e.first = (int32_t)((int64_t)key * n / a->blocks);
        end = (int32_t)((key + (int64_t)1) * n / a->blocks);
    }
    e.cells = end - e.first;
    e.start = pv_lattice_start(&a->lattice, e.first);
    e.length = (int32_t)(pv_lattice_start(&a->lattice, end) - e.start);
    return e;
}

/* The blocks that a region may touch: whole periods, less those that do not. */
static axis make_axis(int32_t cell, int32_t period, int32_t origin, int32_t length)
{
    axis a = { .lattice = pv_lattice_of(cell, period), .from = origin, .to = origin + 256 * (int64_t)length };
    a.blocks = period ? (int32_t)pv_ceil_div(a.lattice.cells, SIDE) : 0;
    int64_t span = period ? period : SIDE * (int64_t)cell, per_span = period ? a.blocks : 1;
    a.first = (int32_t)(pv_floor_div(a.from, span) * per_span);
    a.last = (int32_t)(-pv_floor_div(-a.to, span) * per_span);
    for (strip e; e = strip_of(&a, a.first), e.start + e.length + e.shift <= a.from; a.first++)
        continue;
    for (strip e; e = strip_of(&a, a.last - 1), e.start + e.shift >= a.to; a.last--)
        continue;
    for (int32_t b = a.first; b < a.last; b++)
        a.cells += strip_of(&a, b).cells;
    return a;
}

typedef struct draw {
    int64_t x, y;        /* in the first period, 1/256 px */
    int32_t cell_x, cell_y, slot;
    uint32_t scale;
} draw;

/* The draws of a block, in the order of its cells. Returns their number. */
static int32_t draw_block(uint64_t seed, const axis axes[2], const strip *x, const strip *y, draw *sorted)
{
    draw drawn[DRAWS];
    int32_t place[DRAWS + 1] = { 0 }, cell[DRAWS], draws = x->cells * y->cells;
    for (int32_t k = 0; k < draws; k++) {
        pv_random r = pv_draw(seed, PV_DRAW_SITES, (uint32_t)x->key, (uint32_t)y->key, (uint32_t)k);
        draw *d = &drawn[k];
        d->x = x->start + pv_below(r.word[0], (uint32_t)x->length);
        d->y = y->start + pv_below(r.word[1], (uint32_t)y->length);
        d->cell_x = pv_lattice_cell(&axes[0].lattice, d->x);
        d->cell_y = pv_lattice_cell(&axes[1].lattice, d->y);
        d->slot = k;
        d->scale = r.word[2];
        cell[k] = (d->cell_y - y->first) * x->cells + d->cell_x - x->first;
        place[cell[k] + 1]++;
    }
    for (int32_t c = 0; c < draws; c++)
        place[c + 1] += place[c];
    for (int32_t k = 0; k < draws; k++)
        sorted[place[cell[k]]++] = drawn[k];
    return draws;
}

static pave_site make_site(const pave_cvd_params *params, int64_t x, int64_t y, uint32_t word)
{
    double s = params->scale_min + (params->scale_max - params->scale_min) * word * 0x1p-32;
    double extent = 256 * params->cap * params->half_side;
    return (pave_site){ (int32_t)x, (int32_t)y, 65536, 0, (int32_t)(extent * s + 0.5), (int32_t)(extent + 0.5) };
}

/* A region being sown. */
typedef struct sower {
    const pave_cvd_params *params;
    const pv_place *place;
    axis axes[2];
    pv_seeds *out;
    int whole; /* the region is the plane */
} sower;

static int is_inside(const sower *s, int64_t x, int64_t y)
{
    return s->axes[0].blocks || (x < 256 * (int64_t)s->place->width && y < 256 * (int64_t)s->place->height);
}

static int is_wanted(const axis *a, int64_t at)
{
    return at >= a->from && at < a->to;
}

/* How many of a block's sites lie inside the plane: all, but at its right and lower border. */
static int32_t count_block(const sower *s, const strip *x, const strip *y)
{
    draw sorted[DRAWS];
    int32_t count = 0;
    if (is_inside(s, x->start + x->length - 1, y->start + y->length - 1))
        return x->cells * y->cells;
    draw_block(s->params->seed, s->axes, x, y, sorted);
    for (int32_t k = 0; k < DRAWS; k++)
        count += is_inside(s, sorted[k].x, sorted[k].y);
    return count;
}

static void add_site(const sower *s, const strip *x, const strip *y, const draw *d, int32_t number)
{
    pv_seeds *out = s->out;
    int32_t i = out->count++;
    int64_t left = s->axes[0].from - x->shift, top = s->axes[1].from - y->shift;
    out->sites[i] = make_site(s->params, d->x - left, d->y - top, d->scale);
    out->homes[i] = (pv_home){ d->cell_x, d->cell_y, d->slot, 0 };
    out->numbers[i] = number;
    if (out->shifts)
        out->shifts[i] = (pv_shift){ (int32_t)x->shift, (int32_t)y->shift };
}

/* Adds the block's sites that lie in the region; `number` counts those in the plane. */
static int32_t add_block(const sower *s, const strip *x, const strip *y, int32_t number)
{
    draw sorted[DRAWS];
    int32_t draws = draw_block(s->params->seed, s->axes, x, y, sorted);
    for (int32_t k = 0; k < draws; k++) {
        const draw *d = &sorted[k];
        if (!is_inside(s, d->x, d->y))
            continue;
        if (is_wanted(&s->axes[0], d->x + x->shift) && is_wanted(&s->axes[1], d->y + y->shift))
            add_site(s, x, y, d, number);
        number++;
    }
    return number;
}

/* Adds a row of blocks; returns the number of the next row's first site. */
static int32_t add_row(const sower *s, int32_t by, int32_t number)
{
    const axis *across = &s->axes[0], *down = &s->axes[1];
    int32_t end = (int32_t)pv_ceil_div(256 * (int64_t)s->place->width, SIDE * (int64_t)across->lattice.span);
    strip y = strip_of(down, by);
    for (int32_t bx = 0; bx < end; bx++) {
        strip x = strip_of(across, bx);
        int wanted = by >= down->first && bx >= across->first && bx < across->last;
        number = wanted ? add_block(s, &x, &y, number) : number + count_block(s, &x, &y);
    }
    return number;
}

static void add_open(const sower *s)
{
    int32_t number = 0;
    for (int32_t by = 0; by < s->axes[1].last; by++)
        number = add_row(s, by, number);
    if (!number && s->whole) { /* a plane smaller than a stone is one stone */
        draw middle = { 128 * (int64_t)s->place->width, 128 * (int64_t)s->place->height, 0, 0, 0, 0x80000000u };
        strip none = { .shift = 0 };
        add_site(s, &none, &none, &middle, 0);
    }
}

/* Where the plane repeats, no site is left out, so that all of them can be counted. */
static void add_repeating(const sower *s)
{
    const axis *across = &s->axes[0], *down = &s->axes[1];
    for (int32_t by = down->first; by < down->last; by++) {
        strip y = strip_of(down, by);
        for (int32_t bx = across->first; bx < across->last; bx++) {
            strip x = strip_of(across, bx);
            add_block(s, &x, &y, y.first * across->lattice.cells + y.cells * x.first);
        }
    }
}

static pave_result allocate(pave_context *context, int64_t count, int shifted, pv_seeds *out)
{
    pave_result result = PAVE_OK;
    out->sites = pv_allocate(context, (size_t)count, sizeof *out->sites, &result);
    if (!result)
        out->homes = pv_allocate(context, (size_t)count, sizeof *out->homes, &result);
    if (!result)
        out->numbers = pv_allocate(context, (size_t)count, sizeof *out->numbers, &result);
    if (!result && shifted)
        out->shifts = pv_allocate(context, (size_t)count, sizeof *out->shifts, &result);
    return result;
}

pave_result pv_seeds_draw(pave_context *context, const pave_cvd_params *params, const pv_plane *plane,
                          const pv_place *place, pv_seeds *out)
{
    sower s = { params, place, { make_axis(plane->cell, plane->period_x, plane->origin_x, plane->width),
                                 make_axis(plane->cell, plane->period_y, plane->origin_y, plane->height) }, out, 0 };
    double each = (double)plane->cell * plane->cell / 65536;
    double expected = (double)plane->width * plane->height / each;
    double room = (double)s.axes[0].cells * (double)s.axes[1].cells;
    s.whole = plane->width == place->width && plane->height == place->height;
    *out = (pv_seeds){ .count = 0 };
    if (expected > (double)context->limits.max_stones || room > INT32_MAX ||
        (double)place->width * place->height / each > INT32_MAX / 2)
        return pv_fail(context, PAVE_ERR_LIMIT, "about %.0f stones are beyond the limit of %lld (max_stones)", expected,
                       (long long)context->limits.max_stones);
    pave_result result = allocate(context, (int64_t)room, plane->period_x, out);
    if (!result && plane->period_x)
        add_repeating(&s);
    else if (!result)
        add_open(&s);
    for (int32_t i = 0; i < out->count; i++)
        pv_site_turn(plane, &out->sites[i]);
    return result;
}

void pv_seeds_free(pv_seeds *seeds)
{
    pv_release(seeds->sites);
    pv_release(seeds->homes);
    pv_release(seeds->numbers);
    pv_release(seeds->shifts);
}
