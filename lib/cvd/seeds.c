/* First sites (III.B): uniform at random with the density of Eq. 1, in an order that belongs to the plane.
 *
 * The plane's lattice has cells of 2h x 2h, one to a stone. Each block of 8 x 8 cells draws 64 sites uniformly (one
 * jittered site a cell would stay visible for ever), sorts them by cell, and keeps those inside the drawing. */
#include "backend/relax.h"
#include "cvd/cvd.h"
#include "util/fixed.h"
#include "util/random.h"

enum { SIDE = 8, DRAWS = SIDE * SIDE };

typedef struct draw {
    int32_t x, y, cell; /* place in the block, 1/256 px; cell in the block */
    uint32_t scale;
} draw;

/* The 64 draws of a block, in cell order. */
static void draw_block(uint64_t seed, int32_t bx, int32_t by, int32_t cell, draw *sorted, int32_t *slots)
{
    draw drawn[DRAWS];
    int32_t place[DRAWS + 1] = { 0 };
    for (int32_t k = 0; k < DRAWS; k++) {
        pv_random r = pv_draw(seed, PV_DRAW_SITES, (uint32_t)bx, (uint32_t)by, (uint32_t)k);
        drawn[k].x = (int32_t)pv_below(r.word[0], (uint32_t)(SIDE * cell));
        drawn[k].y = (int32_t)pv_below(r.word[1], (uint32_t)(SIDE * cell));
        drawn[k].scale = r.word[2];
        drawn[k].cell = drawn[k].y / cell * SIDE + drawn[k].x / cell;
        place[drawn[k].cell + 1]++;
    }
    for (int32_t c = 0; c < DRAWS; c++)
        place[c + 1] += place[c];
    for (int32_t k = 0; k < DRAWS; k++) {
        int32_t at = place[drawn[k].cell]++;
        sorted[at] = drawn[k];
        slots[at] = k;
    }
}

static pave_site make_site(const pave_cvd_params *params, int32_t x, int32_t y, uint32_t word)
{
    double s = params->scale_min + (params->scale_max - params->scale_min) * word * 0x1p-32;
    double extent = 256 * params->cap * params->half_side;
    return (pave_site){ x, y, 65536, 0, (int32_t)(extent * s + 0.5), (int32_t)(extent + 0.5) };
}

/* The number of the first site of a row of blocks, and where its blocks lie. */
typedef struct block_row {
    const pave_cvd_params *params;
    const pv_plane *plane;
    const pv_place *place;
    int32_t across, y;
} block_row;

static int is_inside(const block_row *row, int64_t x, int64_t y)
{
    return x < 256 * (int64_t)row->place->width && y < 256 * (int64_t)row->place->height;
}

/* How many of a block's sites lie inside the plane: all, but at its right and lower border. */
static int32_t count_block(const block_row *row, int32_t bx)
{
    int64_t side = SIDE * (int64_t)row->plane->cell, x = bx * side, y = row->y * side;
    draw sorted[DRAWS];
    int32_t slots[DRAWS], count = 0;
    if (is_inside(row, x + side - 1, y + side - 1))
        return DRAWS;
    draw_block(row->params->seed, bx, row->y, row->plane->cell, sorted, slots);
    for (int32_t k = 0; k < DRAWS; k++)
        count += is_inside(row, x + sorted[k].x, y + sorted[k].y);
    return count;
}

/* Adds the block's sites that lie in the region; `number` counts those in the plane. */
static int32_t add_block(const block_row *row, int32_t bx, int32_t number, pv_seeds *out)
{
    int32_t cell = row->plane->cell, slots[DRAWS];
    int64_t left = (int64_t)bx * SIDE * cell, top = (int64_t)row->y * SIDE * cell;
    draw sorted[DRAWS];
    draw_block(row->params->seed, bx, row->y, cell, sorted, slots);
    for (int32_t k = 0; k < DRAWS; k++) {
        int64_t x = left + sorted[k].x, y = top + sorted[k].y;
        if (!is_inside(row, x, y))
            continue;
        int32_t here = number++;
        x -= row->plane->origin_x;
        y -= row->plane->origin_y;
        if (x < 0 || y < 0 || x >= 256 * (int64_t)row->plane->width || y >= 256 * (int64_t)row->plane->height)
            continue;
        out->sites[out->count] = make_site(row->params, (int32_t)x, (int32_t)y, sorted[k].scale);
        out->homes[out->count] = (pv_home){ bx * SIDE + sorted[k].cell % SIDE, row->y * SIDE + sorted[k].cell / SIDE,
                                            slots[k] };
        out->numbers[out->count++] = here;
    }
    return number;
}

/* Adds the blocks left .. right-1 of a row; returns the number of the next row's first site. */
static int32_t add_row(const block_row *row, int32_t left, int32_t right, int32_t number, pv_seeds *out)
{
    for (int32_t bx = 0; bx < row->across; bx++) {
        if (bx >= left && bx < right)
            number = add_block(row, bx, number, out);
        else
            number += count_block(row, bx);
    }
    return number;
}

/* A plane smaller than a stone is one stone. */
static void add_middle(const pave_cvd_params *params, const pv_plane *plane, pv_seeds *out)
{
    out->sites[0] = make_site(params, 128 * plane->width, 128 * plane->height, 0x80000000u);
    out->homes[0] = (pv_home){ 0, 0, 0 };
    out->numbers[0] = 0;
    out->count = 1;
}

static pave_result allocate(pave_context *context, int64_t count, pv_seeds *out)
{
    pave_result result = PAVE_OK;
    out->sites = pv_allocate(context, (size_t)count, sizeof *out->sites, &result);
    if (!result)
        out->homes = pv_allocate(context, (size_t)count, sizeof *out->homes, &result);
    if (!result)
        out->numbers = pv_allocate(context, (size_t)count, sizeof *out->numbers, &result);
    return result;
}

pave_result pv_seeds_draw(pave_context *context, const pave_cvd_params *params, const pv_plane *plane,
                          const pv_place *place, pv_seeds *out)
{
    int64_t block = SIDE * (int64_t)plane->cell;
    int64_t across = pv_ceil_div(256 * (int64_t)place->width, block);
    int64_t left = plane->origin_x / block, right = pv_ceil_div(plane->origin_x + 256 * (int64_t)plane->width, block);
    int64_t top = plane->origin_y / block, bottom = pv_ceil_div(plane->origin_y + 256 * (int64_t)plane->height, block);
    double each = (double)plane->cell * plane->cell / 65536;
    double expected = (double)plane->width * plane->height / each;
    int whole = plane->width == place->width && plane->height == place->height;
    int64_t room = (right - left) * (bottom - top) * DRAWS;
    *out = (pv_seeds){ NULL, NULL, NULL, 0 };
    if (expected > (double)context->limits.max_stones || room > INT32_MAX ||
        (double)place->width * place->height / each > INT32_MAX / 2)
        return pv_fail(context, PAVE_ERR_LIMIT, "about %.0f stones are beyond the limit of %lld (max_stones)", expected,
                       (long long)context->limits.max_stones);
    pave_result result = allocate(context, room, out);
    int32_t number = 0;
    for (int64_t by = 0; by < bottom && !result; by++) {
        block_row row = { params, plane, place, (int32_t)across, (int32_t)by };
        number = add_row(&row, (int32_t)left, by < top ? (int32_t)left : (int32_t)right, number, out);
    }
    if (!result && !number && whole)
        add_middle(params, plane, out);
    for (int32_t i = 0; i < out->count; i++)
        pv_site_turn(plane, &out->sites[i]);
    return result;
}

void pv_seeds_free(pv_seeds *seeds)
{
    pv_release(seeds->sites);
    pv_release(seeds->homes);
    pv_release(seeds->numbers);
}
