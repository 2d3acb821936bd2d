/* The diagram of a region by itself: quantise the edges, draw the sites, let an engine move them (III.B). */
#include "cvd/cvd.h"

#include "field/field.h"
#include "util/fixed.h"
#include "util/lattice.h"
#include "util/random.h"

#include <math.h>
#include <string.h>

static int32_t fixed(double v)
{
    return (int32_t)floor(256 * v + 0.5);
}

/* Where a coordinate of the plane is in the field. */
static int32_t field_place(const pave_field *field, int32_t at, int32_t start, int32_t length)
{
    return field->wraps ? pv_modulo(at, length) : at - start;
}

static const float *field_row(const pave_field *field, const pave_cvd *cvd, int32_t y)
{
    return field->distance +
           (int64_t)field_place(field, cvd->place.y + y, field->place.y, field->height) * field->width;
}

static int has_edges(const pave_field *field, const pave_cvd *cvd)
{
    int32_t first = field_place(field, cvd->place.x, field->place.x, field->width);
    for (int32_t y = 0; y < cvd->height; y++) {
        const float *row = field_row(field, cvd, y);
        for (int32_t x = 0, at = first; x < cvd->width; x++, at++) {
            at = at < field->width ? at : 0;
            if (isfinite(row[at]))
                return 1;
        }
    }
    return 0;
}

/* What the sites feel of the field, quantised once. NULL without edges, or if nothing is to feel them. */
static uint16_t *quantise_edges(pave_context *context, const pave_field *field, const pave_cvd *cvd, pv_plane *plane,
                                pave_result *result)
{
    if (!plane->push_within || !has_edges(field, cvd))
        return NULL;
    while ((plane->push_within + 1024) >> plane->edge_shift > UINT16_MAX)
        plane->edge_shift++;
    double unit = 256.0 / (1 << plane->edge_shift);
    uint16_t *edge = pv_allocate(context, (size_t)cvd->width * (size_t)cvd->height, sizeof *edge, result);
    int32_t first = field_place(field, cvd->place.x, field->place.x, field->width);
    for (int32_t y = 0; y < cvd->height && edge; y++) {
        const float *row = field_row(field, cvd, y);
        for (int32_t x = 0, at = first; x < cvd->width; x++, at++) {
            at = at < field->width ? at : 0;
            double d = row[at] * unit + 0.5;
            edge[(int64_t)y * cvd->width + x] = d < UINT16_MAX ? (uint16_t)d : UINT16_MAX;
        }
    }
    return edge;
}

void pv_region_plane(const pave_cvd *cvd, pv_plane *plane)
{
    const pave_cvd_params *params = &cvd->params;
    double h = params->half_side;
    memset(plane, 0, sizeof *plane);
    plane->width = cvd->width;
    plane->height = cvd->height;
    plane->origin_x = 256 * cvd->place.x;
    plane->origin_y = 256 * cvd->place.y;
    plane->period_x = cvd->repeats ? 256 * cvd->place.width : 0;
    plane->period_y = cvd->repeats ? 256 * cvd->place.height : 0;
    plane->cell = fixed(2 * h);
    plane->push_within = fixed(params->push_within * h);
    plane->push_to = fixed(params->push_to * h);
    plane->excess = (int32_t)floor((params->relaxation - 1) * 65536 + 0.5);
    plane->noise_wave = fixed(params->noise_length * h);
    plane->noise_swing = (int32_t)floor(params->noise_angle * 65536 / 360 + 0.5);
    plane->noise_key = pv_draw(params->seed, PV_DRAW_NOISE, 0, 0, 0).word[0];
    plane->seed = params->seed;
}

pv_rect pv_region_rect(const pave_cvd *cvd)
{
    return (pv_rect){ cvd->place.x, cvd->place.y, cvd->width, cvd->height };
}

int32_t pv_region_open(const pave_cvd *cvd, pv_rect r)
{
    const pv_place *p = &cvd->place;
    return (r.x > 0 || cvd->repeats ? PV_LEFT : 0) | (r.y > 0 || cvd->repeats ? PV_TOP : 0) |
           (r.x + r.width < p->width || cvd->repeats ? PV_RIGHT : 0) |
           (r.y + r.height < p->height || cvd->repeats ? PV_BOTTOM : 0);
}

int32_t pv_region_radius(const pave_cvd *cvd, pv_rect part)
{
    int64_t most = 0;
    for (int32_t y = part.y; y < part.y + part.height; y++) {
        const int32_t *labels = cvd->labels + (int64_t)(y - cvd->place.y) * cvd->width - cvd->place.x;
        for (int32_t x = part.x; x < part.x + part.width; x++) {
            const pave_site *s = &cvd->sites[labels[x]];
            int64_t dx = 256 * (int64_t)x + 128 - s->x, dy = 256 * (int64_t)y + 128 - s->y;
            most = dx * dx + dy * dy > most ? dx * dx + dy * dy : most;
        }
    }
    return (int32_t)pv_isqrt((uint64_t)most) + 1;
}

/* Is the corner of a home cell, or of its copy, in the window's part of the line? */
static int is_mine(const pv_lattice *lattice, int32_t cell, int32_t shift, int32_t start, int32_t length)
{
    int64_t at = (pv_lattice_start(lattice, cell) + shift) >> 8;
    return at >= start && at < (int64_t)start + length;
}

void pv_region_share(const pv_home *homes, pave_cvd *cvd)
{
    pv_plane plane;
    const pv_rect *w = &cvd->window;
    pv_region_plane(cvd, &plane);
    pv_lattice across = pv_lattice_of(plane.cell, plane.period_x), down = pv_lattice_of(plane.cell, plane.period_y);
    for (int32_t i = 0; i < cvd->site_count; i++) {
        pv_shift shift = cvd->shifts ? cvd->shifts[i] : (pv_shift){ 0, 0 };
        cvd->mine[i] = is_mine(&across, homes[i].x, shift.x, w->x, w->width) &&
                       is_mine(&down, homes[i].y, shift.y, w->y, w->height);
    }
}

/* From the region's coordinates to the plane's. */
static void place_sites(const pv_plane *plane, pave_cvd *cvd)
{
    for (int32_t i = 0; i < cvd->site_count; i++) {
        cvd->sites[i].x += plane->origin_x;
        cvd->sites[i].y += plane->origin_y;
    }
}

/* Makes copies of all sites but those first drawn in the plane's first period, which must be there. */
static pave_result link_copies(pave_context *context, const pave_cvd *cvd, pv_seeds *seeds)
{
    int32_t *originals;
    pave_result result = pv_torus_originals(context, cvd, &originals);
    for (int32_t i = 0; i < seeds->count && !result; i++) {
        pv_shift shift = cvd->shifts[i];
        int32_t o = originals[cvd->numbers[i]];
        if (!shift.x && !shift.y)
            continue;
        seeds->homes[i] = (pv_home){ shift.x, shift.y, 0, o + 1 };
        seeds->sites[i].cosine = seeds->sites[o].cosine; /* not as turned so near the border */
        seeds->sites[i].sine = seeds->sites[o].sine;
    }
    pv_release(originals);
    return result;
}

static pave_result take_seeds(pave_context *context, pv_seeds *seeds, pave_cvd *cvd)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)seeds->count;
    cvd->site_count = seeds->count;
    cvd->numbers = seeds->numbers; /* taken over */
    cvd->shifts = seeds->shifts;
    seeds->numbers = NULL;
    seeds->shifts = NULL;
    cvd->mine = pv_allocate(context, n, sizeof *cvd->mine, &result);
    if (!result)
        cvd->sites = pv_allocate(context, n, sizeof *cvd->sites, &result);
    return result;
}

/* From which depth on labels are exact. */
static void measure(const pv_plane *plane, pave_cvd *cvd)
{
    int32_t least = plane->copies ? 0 : plane->cell, deep = plane->copies ? 0 : (cvd->exact + least) >> 8;
    int32_t left = plane->open & PV_LEFT ? deep : 0, top = plane->open & PV_TOP ? deep : 0;
    int32_t right = plane->open & PV_RIGHT ? deep : 0, bottom = plane->open & PV_BOTTOM ? deep : 0;
    cvd->radius = pv_region_radius(cvd, (pv_rect){ cvd->place.x + left, cvd->place.y + top, cvd->width - left - right,
                                                   cvd->height - top - bottom });
    cvd->radius = cvd->radius > least ? cvd->radius : least;
    int32_t far = cvd->radius + pv_most_reach(&cvd->params);
    cvd->exact += far;
    cvd->far = far > cvd->far ? far : cvd->far;
}

pave_result pv_region_make(pave_context *context, const pave_field *field, pv_rect region, int copies, pave_cvd *cvd)
{
    pv_plane plane;
    pv_seeds seeds = { .count = 0 };
    pave_result result = PAVE_OK;
    cvd->place.x = region.x;
    cvd->place.y = region.y;
    cvd->width = region.width;
    cvd->height = region.height;
    pv_region_plane(cvd, &plane);
    uint16_t *edge = quantise_edges(context, field, cvd, &plane, &result);
    plane.edge = edge;
    if (!result)
        result = pv_seeds_draw(context, &cvd->params, &plane, &cvd->place, &seeds);
    if (!result)
        result = take_seeds(context, &seeds, cvd);
    if (!result)
        pv_region_share(seeds.homes, cvd);
    if (!result && copies)
        result = link_copies(context, cvd, &seeds);
    plane.start = seeds.sites;
    plane.home = seeds.homes;
    plane.sites = seeds.count;
    plane.copies = copies;
    plane.open = pv_region_open(cvd, region);
    if (!result && seeds.count)
        result = pv_iterate(context, &plane, &seeds, edge, cvd);
    if (!result && seeds.count) {
        place_sites(&plane, cvd);
        if (pv_rect_room(cvd->window, pv_region_rect(cvd), cvd) < INT32_MAX)
            measure(&plane, cvd);
    }
    pv_release(edge);
    pv_seeds_free(&seeds);
    return result;
}

void pv_region_drop(pave_cvd *cvd)
{
    pv_release(cvd->labels);
    pv_release(cvd->sites);
    pv_release(cvd->numbers);
    pv_release(cvd->shifts);
    pv_release(cvd->mine);
    cvd->labels = NULL;
    cvd->sites = NULL;
    cvd->numbers = NULL;
    cvd->shifts = NULL;
    cvd->mine = NULL;
}
