/* The text's own tiles (5.2, 5.3): at each site a square, a rectangle or an ellipse, as the field turns it. */
#include "mosaic/mosaic.h"

#include "util/random.h"

#include <math.h>
#include <string.h>

enum { OVAL = 24, GRID = 1000 };

/* cos and sin of a quarter of OVAL's angles, exactly enough: found by halving. */
static void oval_corner(int k, double *x, double *y)
{
    static const double cosine[] = { 1, 0.96592582628906829, 0.86602540378443865, 0.70710678118654752, 0.5,
                                     0.25881904510252076, 0 };
    int quarter = k / 6, i = k % 6;
    double c = cosine[i], s = cosine[6 - i];
    *x = quarter == 0 ? c : quarter == 1 ? -s : quarter == 2 ? -c : s;
    *y = quarter == 0 ? s : quarter == 1 ? c : quarter == 2 ? -s : -c;
}

static double on_grid(double v)
{
    return floor(v * GRID + 0.5) / GRID;
}

static void put(pave_stones *out, const pave_site *site, double u, double v)
{
    double c = site->cosine / 65536.0, s = site->sine / 65536.0;
    double *to = out->vertices + 2 * out->starts[out->count + 1]++;
    to[0] = on_grid(site->x / 256.0 + u * c - v * s);
    to[1] = on_grid(site->y / 256.0 + u * s + v * c);
}

/* u lies along the edge, and the long side with it. */
static void cut(const pv_work *w, const pave_site *site, pave_stones *out)
{
    double side = w->params->delta * pv_wanted_side(w, site->x / 256.0, site->y / 256.0);
    double a = side / 2 * sqrt(w->params->aspect), b = side / 2 / sqrt(w->params->aspect);
    out->starts[out->count + 1] = out->starts[out->count];
    if (w->params->shape == PAVE_TILE_SQUARE) {
        put(out, site, a, b);
        put(out, site, a, -b);
        put(out, site, -a, -b);
        put(out, site, -a, b);
    } else {
        const double as_large = 1.1283791670955126; /* as the rectangle: 2 / sqrt(pi) */
        for (int k = 0; k < OVAL; k++) {
            double x, y;
            oval_corner(k, &x, &y);
            put(out, site, a * as_large * x, -b * as_large * y);
        }
    }
    out->count++;
}

/* Tiles that overlap are laid in random order, all others in the order of their sites. */
static void shuffle(const pv_work *w, int32_t *order)
{
    for (int32_t i = 0, n = 0; i < w->cvd->site_count; i++)
        if (w->cvd->mine[i])
            order[n++] = i;
    for (int32_t i = w->n - 1; i > 0 && w->params->shape == PAVE_TILE_ELLIPSE; i--) {
        pv_random r = pv_draw(w->params->seed, PV_DRAW_SCALE, (uint32_t)i, 0, 3);
        int32_t j = (int32_t)pv_below(r.word[0], (uint32_t)i + 1);
        int32_t k = order[i];
        order[i] = order[j], order[j] = k;
    }
}

static void find_living(const pv_work *w, uint8_t *alive)
{
    memset(alive, 0, (size_t)w->cvd->site_count);
    for (int64_t i = 0; i < (int64_t)w->width * w->height; i++)
        if (w->cvd->labels[i] < w->cvd->site_count)
            alive[w->cvd->labels[i]] = 1;
}

pave_result pv_tiles_cut(pave_context *context, const pv_work *w, pave_stones *out)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)w->n, corners = w->params->shape == PAVE_TILE_SQUARE ? 4 : OVAL;
    int32_t *order = pv_allocate(context, n, sizeof *order, &result);
    uint8_t *alive = result ? NULL : pv_allocate(context, (size_t)w->cvd->site_count, 1, &result);
    out->starts = result ? NULL : pv_allocate_zeroed(context, n + 1, sizeof *out->starts, &result);
    out->vertices = result ? NULL : pv_allocate(context, n * corners, 2 * sizeof *out->vertices, &result);
    out->sites = result ? NULL : pv_allocate(context, n, sizeof *out->sites, &result);
    if (!result) {
        find_living(w, alive);
        shuffle(w, order);
        for (int32_t i = 0; i < w->n; i++) {
            if (!alive[order[i]])
                continue;
            out->sites[out->count] = i;
            cut(w, &w->cvd->sites[order[i]], out);
        }
    }
    out->painted = 1;
    out->mosaic->served = out->count;
    pv_release(order);
    pv_release(alive);
    return result;
}
