/* Planes that repeat: one period is computed, with copies of its sites around it, and spread out from there.
 *
 * Let all originals be right before a step, and their copies with them. Missing are sites first drawn outside the
 * region, and a copy that would leave it stays on its border. No site is farther than `stray` from its home cell, so
 * that neither is felt deeper inside than stray + cell, and labels are right `far` deeper, where no pixel is farther
 * than that from its site. An original lies deeper than the plane's first period does, less stray, and its cell within
 * `far` of it: were a pixel of it farther off, the way there would cross right pixels as far off. So where the region
 * reaches 2 (stray + far) + cell beyond the period, originals move as they do in the plane that repeats for ever. */
#include "cvd/cvd.h"

#include "field/field.h"
#include "util/lattice.h"

enum { ROUNDING = 1024 };

/* As measured: no pixel is farther from a box than 5 half sides in the first step, and no site strays farther than 3
 * from its home cell. */
int32_t pv_torus_guess(const pave_cvd_params *params)
{
    double reach = params->cap * params->scale_max;
    return (int32_t)(params->half_side * (2 * (5 + reach + 3) + 2) + 8);
}

static int32_t needed_around(const pave_cvd *cvd)
{
    pv_plane plane;
    pv_region_plane(cvd, &plane);
    int64_t around = 2 * ((int64_t)cvd->stray + cvd->far) + plane.cell + plane.cell / 2 + plane.push_within + ROUNDING;
    return (int32_t)((around < INT32_MAX / 2 ? around : INT32_MAX / 2) >> 8);
}

int32_t pv_torus_sites(const pave_cvd *cvd)
{
    pv_plane plane;
    pv_region_plane(cvd, &plane);
    return pv_lattice_of(plane.cell, plane.period_x).cells * pv_lattice_of(plane.cell, plane.period_y).cells;
}

pave_result pv_torus_originals(pave_context *context, const pave_cvd *cvd, int32_t **originals)
{
    pave_result result = PAVE_OK;
    *originals = pv_allocate(context, (size_t)pv_torus_sites(cvd), sizeof **originals, &result);
    for (int32_t i = 0; i < cvd->site_count && *originals; i++)
        if (!cvd->shifts[i].x && !cvd->shifts[i].y)
            (*originals)[cvd->numbers[i]] = i;
    return result;
}

/* The period, in a region that turned out to be large enough. */
static pave_result make_period(pave_context *context, const pave_field *field, pave_cvd *cvd)
{
    int32_t around = pv_torus_guess(&cvd->params);
    for (;;) {
        pv_rect region = { -around, -around, cvd->place.width + 2 * around, cvd->place.height + 2 * around };
        pave_result result = pv_region_make(context, field, region, 1, cvd);
        int32_t needed = result ? 0 : needed_around(cvd);
        if (result || needed <= around)
            return result;
        pv_region_drop(cvd);
        around = needed + needed / 8 + 1;
    }
}

/* Where the copies of each site are in the list: for each number a table of periods, row by row. */
typedef struct copies {
    int32_t width, height;   /* of a period, px */
    int32_t first_x, first_y, across, down; /* periods */
    int32_t *index;
} copies;

static int32_t *copy_at(const copies *c, int32_t number, int32_t x, int32_t y)
{
    return &c->index[((int64_t)number * c->down + y - c->first_y) * c->across + x - c->first_x];
}

/* A table for the sites first drawn in a part of the plane. */
static pave_result tabulate(pave_context *context, const pave_cvd *cvd, pv_rect part, copies *c)
{
    pave_result result = PAVE_OK;
    int32_t width = cvd->place.width, height = cvd->place.height;
    *c = (copies){ .width = width, .height = height };
    c->first_x = (int32_t)pv_floor_div(part.x, width);
    c->first_y = (int32_t)pv_floor_div(part.y, height);
    c->across = (int32_t)pv_floor_div(part.x + part.width - 1, width) - c->first_x + 1;
    c->down = (int32_t)pv_floor_div(part.y + part.height - 1, height) - c->first_y + 1;
    size_t size = (size_t)pv_torus_sites(cvd) * (size_t)c->across * (size_t)c->down;
    c->index = pv_allocate_zeroed(context, size, sizeof *c->index, &result);
    for (int32_t i = 0; i < cvd->site_count && c->index; i++)
        *copy_at(c, cvd->numbers[i], cvd->shifts[i].x / (256 * width), cvd->shifts[i].y / (256 * height)) = i;
    return result;
}

static void spread_labels(const pave_cvd *core, const copies *c, pave_cvd *cvd)
{
    int32_t *label = cvd->labels;
    for (int32_t y = cvd->place.y; y < cvd->place.y + cvd->height; y++) {
        int32_t row = (int32_t)pv_floor_div(y, c->height);
        const int32_t *from = core->labels + (int64_t)(y - row * c->height - core->place.y) * core->width;
        for (int32_t x = cvd->place.x; x < cvd->place.x + cvd->width; x++) {
            int32_t column = (int32_t)pv_floor_div(x, c->width), i = from[x - column * c->width - core->place.x];
            *label++ = *copy_at(c, core->numbers[i], core->shifts[i].x / (256 * c->width) + column,
                                core->shifts[i].y / (256 * c->height) + row);
        }
    }
}

static pave_result spread_sites(pave_context *context, const pave_cvd *core, pave_cvd *cvd)
{
    int32_t *originals;
    pave_result result = pv_torus_originals(context, core, &originals);
    for (int32_t i = 0; i < cvd->site_count && !result; i++) {
        cvd->sites[i] = core->sites[originals[cvd->numbers[i]]];
        cvd->sites[i].x += cvd->shifts[i].x;
        cvd->sites[i].y += cvd->shifts[i].y;
    }
    pv_release(originals);
    return result;
}

/* Draws the sites of a part of the plane, for their order. */
static pave_result draw_sites(pave_context *context, pv_rect part, pave_cvd *cvd)
{
    pv_plane plane;
    pv_seeds seeds;
    pave_cvd there = *cvd;
    there.place.x = part.x;
    there.place.y = part.y;
    there.width = part.width;
    there.height = part.height;
    pv_region_plane(&there, &plane);
    pave_result result = pv_seeds_draw(context, &cvd->params, &plane, &there.place, &seeds);
    if (!result)
        cvd->mine = pv_allocate(context, (size_t)seeds.count, sizeof *cvd->mine, &result);
    cvd->site_count = seeds.count;
    cvd->sites = seeds.sites;
    cvd->numbers = seeds.numbers;
    cvd->shifts = seeds.shifts;
    if (!result)
        pv_region_share(seeds.homes, cvd);
    pv_release(seeds.homes);
    return result;
}

/* From the period to the window and what is wanted around it. Labels lead to sites that were first drawn no farther
 * than radius + stray + cell from there. */
static pave_result spread(pave_context *context, const pave_cvd *core, int32_t wanted, pave_cvd *cvd)
{
    const pv_rect everywhere = { -(1 << 29), -(1 << 29), 1 << 30, 1 << 30 };
    pv_rect part = pv_rect_grown(cvd->window, wanted, everywhere);
    int32_t cell = (int32_t)(2 * cvd->params.half_side + 2) * 2; /* they are stretched to no more than twice theirs */
    pv_rect outer = pv_rect_grown(part, (core->radius + core->stray) / 256 + cell, everywhere);
    copies c = { .index = NULL };
    cvd->place.x = part.x;
    cvd->place.y = part.y;
    cvd->width = part.width;
    cvd->height = part.height;
    pave_result result = draw_sites(context, outer, cvd);
    if (!result)
        result = tabulate(context, cvd, outer, &c);
    if (!result)
        result = spread_sites(context, core, cvd);
    if (!result)
        cvd->labels = pv_allocate(context, (size_t)part.width * (size_t)part.height, sizeof *cvd->labels, &result);
    if (!result)
        spread_labels(core, &c, cvd);
    pv_release(c.index);
    return result;
}

pave_result pv_torus_make(pave_context *context, const pave_field *field, int32_t wanted, pave_cvd *cvd)
{
    pave_result result = make_period(context, field, cvd);
    if (result)
        return result;
    cvd->radius = pv_region_radius(cvd, (pv_rect){ 0, 0, cvd->place.width, cvd->place.height });
    pave_cvd core = *cvd;
    cvd->labels = NULL;
    cvd->sites = NULL;
    cvd->numbers = NULL;
    cvd->shifts = NULL;
    cvd->mine = NULL;
    result = spread(context, &core, wanted, cvd);
    pv_region_drop(&core);
    if (result)
        return result;
    cvd->exact = 0;
    return PAVE_OK;
}
