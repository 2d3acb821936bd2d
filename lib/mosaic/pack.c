/* Packing: Lloyd's method on square pyramids that the field turns (section 3). For a while thick edges are nobody's,
 * which drives the sites off them; then the gaps are filled again (section 6). Between the phases each site takes the
 * size that tiles are to have where it has come to. */
#include "mosaic/mosaic.h"

#include "util/fixed.h"

#include <math.h>
#include <string.h>

typedef struct packing {
    pv_work *w;
    pv_plane plane;
    pave_site *sites;
    pv_home *homes;
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
    for (int32_t i = 0; i < p->plane.sites; i++) {
        pave_site *s = &p->sites[i];
        double steep = pv_steepest(p->plane.metric) * least / pv_wanted_side(w, s->x / 256.0, s->y / 256.0);
        s->half_y = (int32_t)(steep < 1 ? 1 : steep);
        s->half_x = (int32_t)(steep / w->params->aspect < 1 ? 1 : steep / w->params->aspect);
    }
}

static void turn(packing *p)
{
    for (int32_t i = 0; i < p->plane.sites; i++) {
        pave_site *s = &p->sites[i];
        pv_turn(p->plane.direction[(int64_t)(s->y >> 8) * p->plane.width + (s->x >> 8)], &s->cosine, &s->sine);
    }
}

static pave_result phase(pave_context *context, packing *p, int32_t iterations, int with_edges, double from, double to)
{
    pave_cvd *cvd = p->w->cvd;
    mark(p, with_edges);
    slope(p);
    turn(p);
    p->plane.start = p->sites;
    p->plane.seed++;
    p->plane.excess = (int32_t)floor((p->w->params->relaxation - 1) * 65536 + 0.5);
    cvd->params.iterations = iterations;
    pv_call call = pv_call_begin(context, "mosaic", from, to);
    pave_result result = pv_iterate(context, &p->plane, NULL, NULL, cvd);
    pv_call_end(context, call);
    if (!result)
        memcpy(p->sites, cvd->sites, (size_t)p->plane.sites * sizeof *p->sites);
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
    size_t n = (size_t)w->n;
    pave_cvd *cvd = w->cvd = pv_allocate_zeroed(context, 1, sizeof *cvd, &result);
    if (!cvd)
        return result;
    cvd->place = (pv_place){ 0, 0, w->width, w->height };
    cvd->window = (pv_rect){ 0, 0, w->width, w->height };
    cvd->width = w->width;
    cvd->height = w->height;
    cvd->site_count = w->n;
    pave_cvd_params_init(&cvd->params, sizeof cvd->params);
    cvd->params.half_side = w->side / 2;
    cvd->params.seed = w->params->seed;
    cvd->labels = pv_allocate(context, (size_t)w->width * (size_t)w->height, sizeof *cvd->labels, &result);
    cvd->window_labels = cvd->labels;
    if (!result)
        cvd->sites = pv_allocate_zeroed(context, n, sizeof *cvd->sites, &result);
    if (!result)
        cvd->numbers = pv_allocate(context, n, sizeof *cvd->numbers, &result);
    if (!result)
        cvd->mine = pv_allocate(context, n, sizeof *cvd->mine, &result);
    for (int32_t i = 0; i < w->n && !result; i++) {
        cvd->numbers[i] = i;
        cvd->mine[i] = 1;
    }
    return result;
}

/* Where tiles are not to be, pixels have the label after the last. */
static void punch_holes(pv_work *w)
{
    for (int64_t i = 0; w->photo.hole && i < (int64_t)w->width * w->height; i++)
        if (w->photo.hole[i])
            w->cvd->labels[i] = w->n;
}

static pave_result allocate(pave_context *context, packing *p)
{
    const pv_work *w = p->w;
    pave_result result = PAVE_OK;
    p->sites = pv_allocate_zeroed(context, (size_t)w->n, sizeof *p->sites, &result);
    if (!result)
        p->homes = pv_allocate_zeroed(context, (size_t)w->n, sizeof *p->homes, &result);
    if (!result)
        p->mask = pv_allocate(context, (size_t)((w->width + 7) / 8) * (size_t)((w->height + 7) / 8), sizeof *p->mask,
                              &result);
    for (int32_t i = 0; i < w->n && !result; i++)
        p->homes[i] = (pv_home){ .x = i };
    return result;
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
        result = pv_sites_sow(context, w, p.sites, &p.plane.sites);
    p.plane.home = p.homes;
    if (!result)
        result = phases(context, &p);
    if (!result)
        punch_holes(w);
    pv_release(p.sites);
    pv_release(p.homes);
    pv_release(p.mask);
    return result;
}
