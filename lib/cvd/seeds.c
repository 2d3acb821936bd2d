/* First sites (III.B): uniform at random with the density of Eq. 1, in an order that belongs to the plane.
 *
 * The plane's lattice has cells of 2h x 2h, one to a stone. Each block of 8 x 8 cells draws 64 sites uniformly (one
 * jittered site a cell would stay visible for ever), sorts them by cell, and keeps those inside the drawing. */
#include "backend/relax.h"
#include "cvd/cvd.h"
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

typedef struct seeds {
    pave_site *sites;
    pv_home *homes;
    int32_t count;
} seeds;

static void add_block(const pave_cvd_params *params, const pv_plane *plane, int32_t bx, int32_t by, seeds *out)
{
    draw sorted[DRAWS];
    int32_t slots[DRAWS];
    draw_block(params->seed, bx, by, plane->cell, sorted, slots);
    for (int32_t k = 0; k < DRAWS; k++) {
        int64_t x = (int64_t)bx * SIDE * plane->cell + sorted[k].x, y = (int64_t)by * SIDE * plane->cell + sorted[k].y;
        if (x >= 256 * (int64_t)plane->width || y >= 256 * (int64_t)plane->height)
            continue;
        int32_t cx = bx * SIDE + sorted[k].cell % SIDE, cy = by * SIDE + sorted[k].cell / SIDE;
        out->sites[out->count] = make_site(params, (int32_t)x, (int32_t)y, sorted[k].scale);
        out->homes[out->count++] = (pv_home){ cx, cy, slots[k] };
    }
}

pave_result pv_seeds(pave_context *context, const pave_cvd_params *params, const pv_plane *plane, pave_site **sites,
                     pv_home **homes, int32_t *count)
{
    int64_t block = SIDE * (int64_t)plane->cell;
    int64_t across = (256 * (int64_t)plane->width + block - 1) / block;
    int64_t down = (256 * (int64_t)plane->height + block - 1) / block;
    double expected = 65536.0 * plane->width * plane->height / ((double)plane->cell * plane->cell);
    if (expected > (double)context->limits.max_stones || across * down * DRAWS > INT32_MAX)
        return pv_fail(context, PAVE_ERR_LIMIT, "about %.0f stones are beyond the limit of %lld (max_stones)", expected,
                       (long long)context->limits.max_stones);

    pave_result result = PAVE_OK;
    seeds made = { NULL, NULL, 0 };
    made.sites = pv_allocate(context, (size_t)(across * down * DRAWS), sizeof *made.sites, &result);
    if (!result)
        made.homes = pv_allocate(context, (size_t)(across * down * DRAWS), sizeof *made.homes, &result);
    for (int32_t by = 0; by < down && !result; by++)
        for (int32_t bx = 0; bx < across; bx++)
            add_block(params, plane, bx, by, &made);
    if (!result && !made.count) { /* a drawing smaller than a stone is one stone */
        made.sites[0] = make_site(params, 128 * plane->width, 128 * plane->height, 0x80000000u);
        made.homes[0] = (pv_home){ 0, 0, 0 };
        made.count = 1;
    }
    for (int32_t i = 0; i < made.count; i++)
        pv_site_turn(plane, &made.sites[i]);
    *sites = made.sites;
    *homes = made.homes;
    *count = made.count;
    return result;
}
