/* Packing: Lloyd's method on square pyramids that the field turns (section 3). For a while thick edges are nobody's,
 * which drives the sites off them; then the gaps are filled again (section 6). Between the phases each site takes the
 * size that tiles are to have where it has come to. Where the photo repeats, sites have copies that follow them; in the
 * list they come right after each other, so that ties are decided alike everywhere. */
#include "mosaic/mosaic.h"

#include "util/fixed.h"
#include "util/lattice.h"

#include <math.h>
#include <string.h>

typedef struct packing {
    pv_work *w;
    pv_plane plane;
    pave_site *own;    /* `w->n`, without copies */
    int32_t *place;    /* of those in the list, which is */
    pave_site *sites;  /* these, */
    pv_home *homes;    /* these, and what the diagram has */
    uint64_t *mask;
} packing;

/* Marks the pixels that count for nobody: holes, and edges. */
static void mark(packing *p, int with_edges)
{
    const pv_work *w = p->w;
    int32_t across = (w->width + 7) / 8;
    int any = 0;
    memset(p->mask, 0, (size_t)across * (size_t)((w->height + 7) / 8) * sizeof *p->mask);
    for (int32_t y = 0; y < w->height; y++)
        for (int32_t x = 0; x < w->width; x++) {
            int64_t i = (int64_t)y * w->width + x;
            double side = w->size ? w->scale * (double)w->size[i] : w->scale;
            int hole = w->photo.hole && w->photo.hole[i];
            if (!hole && !(with_edges && w->guide->away && (double)w->guide->away[i] <= w->params->edge_width * side))
                continue;
            p->mask[(int64_t)(y / 8) * across + x / 8] |= (uint64_t)1 << (y % 8 * 8 + x % 8);
            any = 1;
        }
    p->plane.mask = any ? p->mask : NULL;
}

/* Slopes by the size of tiles where the sites are: alpha by the size, beta by the aspect. */
static void slope(packing *p)
{
    const pv_work *w = p->w;
    double least = w->size ? w->size_min * w->scale : w->scale;
    for (int32_t i = 0; i < w->n; i++) {
        pave_site *s = &p->own[i];
        double steep = pv_steepest(p->plane.metric) * least / pv_wanted_side(w, s->x / 256.0, s->y / 256.0);
        s->half_y = (int32_t)(steep < 1 ? 1 : steep);
        s->half_x = (int32_t)(steep / w->params->aspect < 1 ? 1 : steep / w->params->aspect);
    }
}

static void turn(packing *p)
{
    for (int32_t i = 0; i < p->w->n; i++) {
        pave_site *s = &p->own[i];
        pv_turn(p->plane.direction[(int64_t)(s->y >> 8) * p->plane.width + (s->x >> 8)], &s->cosine, &s->sine);
    }
}

static pave_site into_period(const pv_work *w, pave_site s)
{
    if (!w->period)
        return s;
    s.x = 256 * w->margin + pv_modulo(s.x - 256 * w->margin, 256 * w->period->width);
    s.y = 256 * w->margin + pv_modulo(s.y - 256 * w->margin, 256 * w->period->height);
    return s;
}

static int is_there(const pv_work *w, const pave_site *s)
{
    return s->x >= 0 && s->y >= 0 && s->x < 256 * w->width && s->y < 256 * w->height;
}

/* A site, or its copy some periods away, to the end of the list; counted only if there is no list. */
static void add_site(packing *p, int32_t i, int32_t right, int32_t down)
{
    const pv_work *w = p->w;
    pave_site s = p->own[i];
    int32_t at = w->cvd->site_count, x = 256 * right * (w->period ? w->period->width : 0);
    int32_t y = 256 * down * (w->period ? w->period->height : 0), original = !right && !down;
    s.x += x;
    s.y += y;
    if (!is_there(w, &s))
        return;
    w->cvd->site_count++;
    if (original)
        p->place[i] = at;
    if (!p->sites)
        return;
    pv_lattice across = pv_lattice_of(p->plane.cell, p->plane.period_x);
    pv_lattice along = pv_lattice_of(p->plane.cell, p->plane.period_y);
    p->sites[at] = s;
    w->cvd->numbers[at] = i;
    w->cvd->mine[at] = (uint8_t)original;
    if (!original)
        p->homes[at] = (pv_home){ x, y, 0, p->place[i] + 1 };
    else if (!w->period)
        p->homes[at] = (pv_home){ .x = i };
    else
        p->homes[at] = (pv_home){ pv_lattice_cell(&across, s.x + p->plane.origin_x),
                                  pv_lattice_cell(&along, s.y + p->plane.origin_y), i, 0 };
}

static void add_sites(packing *p)
{
    const pv_work *w = p->w;
    int32_t right = w->period ? w->margin / w->period->width + 1 : 0;
    int32_t down = w->period ? w->margin / w->period->height + 1 : 0;
    w->cvd->site_count = 0;
    for (int32_t i = 0; i < w->n; i++)
        for (int32_t y = -down; y <= down; y++)
            for (int32_t x = -right; x <= right; x++)
                add_site(p, i, x, y);
}

static void drop_list(packing *p)
{
    pv_release(p->sites);
    pv_release(p->homes);
    pv_release(p->w->cvd->sites);
    pv_release(p->w->cvd->numbers);
    pv_release(p->w->cvd->mine);
    p->w->cvd->sites = p->sites = NULL;
    p->w->cvd->numbers = NULL;
    p->w->cvd->mine = NULL;
    p->homes = NULL;
}

static pave_result list_sites(pave_context *context, packing *p)
{
    pave_result result = PAVE_OK;
    pave_cvd *cvd = p->w->cvd;
    drop_list(p);
    add_sites(p); /* so that places are known, and their number */
    size_t n = (size_t)cvd->site_count;
    p->plane.sites = cvd->site_count;
    p->sites = pv_allocate(context, n, sizeof *p->sites, &result);
    if (!result)
        p->homes = pv_allocate_zeroed(context, n, sizeof *p->homes, &result);
    if (!result)
        cvd->sites = pv_allocate_zeroed(context, n, sizeof *cvd->sites, &result);
    if (!result)
        cvd->numbers = pv_allocate(context, n, sizeof *cvd->numbers, &result);
    if (!result)
        cvd->mine = pv_allocate(context, n, sizeof *cvd->mine, &result);
    if (!result)
        add_sites(p);
    return result;
}

/* How much around the period the last steps were felt in: see cvd/torus.c. */
static void note_needed(packing *p)
{
    const pave_cvd *cvd = p->w->cvd;
    int64_t needed = (2 * ((int64_t)cvd->stray + cvd->far) + 2 * p->plane.cell + 1024) >> 8;
    needed = needed < 1 << 20 ? needed : 1 << 20;
    p->w->needed = needed > p->w->needed ? (int32_t)needed : p->w->needed;
}

static pave_result phase(pave_context *context, packing *p, int32_t iterations, int with_edges, double from, double to)
{
    pave_cvd *cvd = p->w->cvd;
    mark(p, with_edges);
    slope(p);
    turn(p);
    pave_result result = list_sites(context, p);
    if (result || p->w->needed > p->w->margin)
        return result;
    p->plane.start = p->sites;
    p->plane.home = p->homes;
    p->plane.seed++;
    p->plane.excess = (int32_t)floor((p->w->params->relaxation - 1) * 65536 + 0.5);
    cvd->params.iterations = iterations;
    pv_call call = pv_call_begin(context, "mosaic", from, to);
    result = pv_iterate(context, &p->plane, NULL, NULL, cvd);
    pv_call_end(context, call);
    for (int32_t i = 0; i < p->w->n && !result; i++)
        p->own[i] = into_period(p->w, cvd->sites[p->place[i]]);
    if (p->w->period)
        note_needed(p);
    return result;
}

static pave_result phases(pave_context *context, packing *p)
{
    const pave_mosaic_params *params = p->w->params;
    int32_t first = params->iterations / 2, all = params->iterations + params->avoiding + params->closing;
    double share = all ? 1.0 / all : 0, at = first * share;
    int avoid = params->avoiding && p->w->guide->away && params->edge_width > 0;
    pave_result result = phase(context, p, first, 0, 0, at);
    if (!result)
        result = phase(context, p, params->iterations - first, 0, at, params->iterations * share);
    if (!result && avoid)
        result = phase(context, p, params->avoiding, 1, params->iterations * share, 1 - params->closing * share);
    if (!result)
        result = phase(context, p, params->closing, 0, 1 - params->closing * share, 1);
    return result;
}

static pave_result new_diagram(pave_context *context, pv_work *w)
{
    pave_result result = PAVE_OK;
    pave_cvd *cvd = w->cvd = pv_allocate_zeroed(context, 1, sizeof *cvd, &result);
    if (!cvd)
        return result;
    const pv_work *period = w->period ? w->period : w;
    cvd->place = (pv_place){ -w->margin, -w->margin, period->width, period->height };
    cvd->window = (pv_rect){ 0, 0, period->width, period->height };
    cvd->repeats = w->period != NULL;
    cvd->width = w->width;
    cvd->height = w->height;
    pave_cvd_params_init(&cvd->params, sizeof cvd->params);
    cvd->params.half_side = w->side / 2;
    cvd->params.seed = w->params->seed;
    cvd->labels = pv_allocate(context, (size_t)w->width * (size_t)w->height, sizeof *cvd->labels, &result);
    cvd->window_labels = cvd->labels;
    return result;
}

/* Where tiles are not to be, pixels have the label after the last. */
static void punch_holes(pv_work *w)
{
    for (int64_t i = 0; w->photo.hole && i < (int64_t)w->width * w->height; i++)
        if (w->photo.hole[i])
            w->cvd->labels[i] = w->cvd->site_count;
}

static pave_result allocate(pave_context *context, packing *p)
{
    const pv_work *w = p->w;
    pave_result result = PAVE_OK;
    p->own = pv_allocate_zeroed(context, (size_t)w->n, sizeof *p->own, &result);
    if (!result)
        p->place = pv_allocate(context, (size_t)w->n, sizeof *p->place, &result);
    if (!result)
        p->mask = pv_allocate(context, (size_t)((w->width + 7) / 8) * (size_t)((w->height + 7) / 8), sizeof *p->mask,
                              &result);
    return result;
}

/* The first sites, of a period if there is one. */
static pave_result sow(pave_context *context, packing *p)
{
    const pv_work *w = p->w;
    int32_t count = 0;
    pave_result result = pv_sites_sow(context, w->period ? w->period : w, p->own, &count);
    for (int32_t i = 0; i < count; i++) {
        p->own[i].x += 256 * w->margin;
        p->own[i].y += 256 * w->margin;
    }
    return result;
}

static void repeat(packing *p)
{
    const pv_work *w = p->w;
    p->plane.origin_x = p->plane.origin_y = -256 * w->margin;
    p->plane.period_x = 256 * w->period->width;
    p->plane.period_y = 256 * w->period->height;
    p->plane.copies = 1;
    p->plane.open = PV_LEFT | PV_TOP | PV_RIGHT | PV_BOTTOM;
}

pave_result pv_tiles_pack(pave_context *context, pv_work *w)
{
    packing p = { .w = w };
    p.plane = (pv_plane){ .width = w->width, .height = w->height, .cell = (int32_t)(256 * w->side + 0.5),
                          .noise_wave = 256, .seed = w->params->seed, .direction = w->guide->direction,
                          .metric = w->params->pyramid == PAVE_PYRAMID_DIAMOND ? PAVE_METRIC_DIAMOND
                                                                               : PAVE_METRIC_SQUARE };
    pave_result result = new_diagram(context, w);
    if (!result)
        result = allocate(context, &p);
    if (!result)
        result = sow(context, &p);
    if (w->period)
        repeat(&p);
    if (!result)
        result = phases(context, &p);
    if (!result)
        punch_holes(w);
    pv_release(p.own);
    pv_release(p.place);
    pv_release(p.sites);
    pv_release(p.homes);
    pv_release(p.mask);
    return result;
}
