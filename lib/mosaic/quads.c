/* Best mode: the cells as a mesh in which every inner vertex is a corner to all but one of its faces, so that these
 * have four corners; drawn gently to the edges and towards rectangles that the field turns; in each face a tile. The
 * mesh is on an integer grid and stays one, so that no two tiles can overlap. */
#include "mosaic/mosaic.h"

#include "stones/assign.h"
#include "stones/collapse.h"
#include "stones/contour.h"
#include "stones/realise.h"

#include <math.h>
#include <string.h>

enum { BLOCK_TILES = 8, MOST_CORNERS = 16 };

#define SIZE_PULL 0.5 /* how far a rectangle goes towards the size that is wanted, */
#define ASPECT_PULL 0.15 /* and towards the wanted ratio of its sides */
#define FIELD_WEIGHT 1.2 /* of the field in a rectangle's direction, its own sides' being 1 */

/* Labels into faces: holes are labels of their own, at the end. */
static pave_result trace(pave_context *context, const pv_work *w, pv_tess *tess)
{
    pave_result result = PAVE_OK;
    pv_pieces pieces = { 0 };
    pv_tess_place place = { 0, 0, 1, w->side / 2, { 0, 0 }, NULL };
    if (w->period)
        place.period = (pv_cell){ w->period->width, w->period->height };
    pv_label_image image = { .width = w->width, .height = w->height, .labels = w->cvd->labels,
                             .stride = w->width, .label_count = w->cvd->site_count + 1, .scale = 1 };
    double least = w->side * (w->size ? w->size_min : 1) / 3;
    result = pv_pieces_split(context, &image, (int64_t)(least * least) + 1, 1, &pieces);
    if (!result)
        result = pv_tess_trace(context, &pieces, &place, tess);
    tess->has_whole = w->period != NULL;
    tess->whole = (pv_cell){ w->margin * PV_GRID, w->margin * PV_GRID };
    pv_pieces_free(&pieces);
    return result;
}

/* What the vertices heed besides their lines. */
typedef struct shaping {
    const pv_work *w;
    double to_edge, to_square;
} shaping;

static double away_at(const pv_work *w, double x, double y)
{
    x = fmin(fmax(x - 0.5, 0), w->width - 1.001);
    y = fmin(fmax(y - 0.5, 0), w->height - 1.001);
    const float *at = w->guide->away + (int64_t)y * w->width + (int64_t)x;
    double fx = x - floor(x), fy = y - floor(y);
    int64_t right = w->width > 1, down = w->height > 1 ? w->width : 0;
    double up = (double)at[0] + fx * ((double)at[right] - (double)at[0]);
    double low = (double)at[down] + fx * ((double)at[down + right] - (double)at[down]);
    return up + fy * (low - up);
}

/* Vertices near an edge are drawn onto it. */
static void pull_to_edge(const shaping *s, pv_cell at, pv_equations *e)
{
    const pv_work *w = s->w;
    double x = (double)at.x / PV_GRID, y = (double)at.y / PV_GRID, near = 0.4 * pv_wanted_side(w, x, y);
    double away = away_at(w, x, y), gx = away_at(w, x + 1, y) - away_at(w, x - 1, y);
    double gy = away_at(w, x, y + 1) - away_at(w, x, y - 1), steep = sqrt(gx * gx + gy * gy);
    if (away >= near || steep < 0.5)
        return;
    pv_add_equation(e, s->to_edge, gx / steep, gy / steep, away * PV_GRID);
}

/* The rectangle that the corners of a face come nearest to, made more like the size that is wanted. */
typedef struct rectangle {
    double x, y, c, s, a, b; /* centre, direction, half sides; grid units */
} rectangle;

static int corners_of(const pv_tess *tess, int32_t face, pv_cell *out)
{
    int count = 0;
    for (int64_t p = tess->first[face]; p < tess->first[face + 1]; p++)
        if (pv_is_corner(tess, p)) {
            if (count == MOST_CORNERS)
                return 0;
            out[count++] = tess->at[tess->corner[p]];
        }
    return count;
}

static int32_t direction_at(const pv_work *w, const rectangle *r)
{
    int32_t x = pv_inside((int32_t)(r->x / PV_GRID), w->width, 0);
    int32_t y = pv_inside((int32_t)(r->y / PV_GRID), w->height, 0);
    return w->guide->direction[(int64_t)y * w->width + x];
}

/* Its direction is between that of the sides and the field's. */
static void turn_rectangle(const pv_work *w, const pv_cell *corner, int count, rectangle *r)
{
    double c4 = 0, s4 = 0, around = 0;
    int32_t fc, fs;
    for (int i = 0; i < count; i++) {
        pv_cell a = corner[i], b = corner[i + 1 < count ? i + 1 : 0];
        double dx = (double)b.x - a.x, dy = (double)b.y - a.y, d2 = dx * dx + dy * dy, length = sqrt(d2);
        double c = d2 > 0 ? (dx * dx - dy * dy) / d2 : 0, s = d2 > 0 ? 2 * dx * dy / d2 : 0;
        c4 += length * (c * c - s * s);
        s4 += length * 2 * c * s;
        around += length;
    }
    pv_turn(4 * direction_at(w, r), &fc, &fs);
    c4 += FIELD_WEIGHT * around * fc / 65536;
    s4 += FIELD_WEIGHT * around * fs / 65536;
    for (int halving = 0; halving < 2; halving++) { /* the root of the unit vector, twice */
        double length = sqrt(c4 * c4 + s4 * s4), c = length > 0 ? c4 / length : 1;
        c4 = sqrt(fmax(0, (1 + c) / 2));
        s4 = sqrt(fmax(0, (1 - c) / 2)) * (s4 < 0 ? -1 : 1);
    }
    r->c = c4;
    r->s = s4;
}

/* Does the field go along the rectangle's first direction rather than across? */
static int lies_along(const pv_work *w, const rectangle *r)
{
    int32_t fc, fs;
    pv_turn(direction_at(w, r), &fc, &fs);
    return fabs(fc * r->c + fs * r->s) >= fabs(fs * r->c - fc * r->s);
}

static int rectangle_of(const pv_work *w, const pv_tess *tess, int32_t face, rectangle *r)
{
    pv_cell corner[MOST_CORNERS];
    int count = corners_of(tess, face, corner);
    if (count < 3)
        return 0;
    *r = (rectangle){ 0, 0, 1, 0, 0, 0 };
    for (int i = 0; i < count; i++) {
        r->x += (double)corner[i].x / count;
        r->y += (double)corner[i].y / count;
    }
    turn_rectangle(w, corner, count, r);
    for (int i = 0; i < count; i++) {
        double dx = corner[i].x - r->x, dy = corner[i].y - r->y;
        r->a += fabs(dx * r->c + dy * r->s) / count;
        r->b += fabs(dy * r->c - dx * r->s) / count;
    }
    double wanted = pv_wanted_side(w, r->x / PV_GRID, r->y / PV_GRID) * PV_GRID / 2, is = sqrt(r->a * r->b);
    double grow = is > 0 ? 1 + SIZE_PULL * (wanted / is - 1) : 1, stretch = sqrt(w->params->aspect);
    double a = is * (lies_along(w, r) ? stretch : 1 / stretch), b = is * is / fmax(a, 1);
    r->a = grow * (r->a + ASPECT_PULL * (a - r->a));
    r->b = grow * (r->b + ASPECT_PULL * (b - r->b));
    return 1;
}

/* A corner belongs where the rectangle has one. */
static void pull_to_square(const shaping *s, const pv_tess *tess, int64_t place, pv_equations *e)
{
    rectangle r;
    pv_cell at = tess->at[tess->corner[place]];
    if (!pv_is_corner(tess, place) || !rectangle_of(s->w, tess, tess->face_of[place], &r))
        return;
    double dx = at.x - r.x, dy = at.y - r.y, u = dx * r.c + dy * r.s, v = dy * r.c - dx * r.s;
    double a = u < 0 ? -r.a : r.a, b = v < 0 ? -r.b : r.b;
    pv_add_equation(e, s->to_square, r.c, r.s, u - a);
    pv_add_equation(e, s->to_square, -r.s, r.c, v - b);
}

static void pull(const void *user, const pv_tess *tess, int32_t vertex, pv_equations *e)
{
    const shaping *s = user;
    if (s->w->guide->away)
        pull_to_edge(s, tess->at[vertex], e);
    for (int64_t k = tess->star[vertex]; k < tess->star[vertex + 1]; k++)
        pull_to_square(s, tess, tess->spoke[k], e);
}

/* First all that draws, then the lines alone, so that flat vertices end on them. */
static pave_result shape(pave_context *context, const pv_work *w, pv_tess *tess)
{
    double side = w->side * PV_GRID, least = side * (w->size ? w->size_min : 1);
    int64_t block = (int64_t)(side * BLOCK_TILES);
    pv_assign_params assign = { block, 65, 35 };
    shaping s = { w, 0.12, 0.4 };
    int32_t step = (int32_t)(side / 8), shortest = (int32_t)(least / 8);
    pv_realise_params draw = { block, 24, (int32_t)(side / 2), step, (int32_t)(least / 4), shortest, 0, 0, pull, &s };
    pv_realise_params settle = { block, 6, (int32_t)(side / 4), step, (int32_t)(least / 5), shortest, 0, 0, NULL,
                                 NULL };
    pave_result result = pv_tess_collapse(context, tess, (int64_t)(least / 5), 4, 3);
    if (!result)
        result = pv_assign_flats(context, &assign, tess, 0.2, 0.3);
    if (!result)
        result = pv_realise_flats(context, &draw, tess, 0.3, 0.6);
    return result ? result : pv_realise_flats(context, &settle, tess, 0.6, 0.8);
}

pave_result pv_quads_cut(pave_context *context, const pv_work *w, int plain, int *closed, pave_stones *out)
{
    pv_tess tess = { 0 };
    pave_result result = trace(context, w, &tess);
    if (!result && !plain)
        result = shape(context, w, &tess);
    *closed = !result && (!w->period || pv_period_closes(w, &tess));
    if (!result && *closed)
        result = pv_faces_cut(context, w, &tess, plain, out);
    pv_tess_free(&tess);
    return result;
}
