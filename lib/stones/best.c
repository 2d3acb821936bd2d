/* The best mode: pieces of cells, traced into a tessellation; vertices made flat so that faces have four corners; in
 * each face a stone. */
#include "stones/assign.h"
#include "stones/collapse.h"
#include "stones/contour.h"
#include "stones/inscribe.h"
#include "stones/realise.h"
#include "stones/stones.h"

#include "cvd/cvd.h"
#include "image/image.h"

#include <math.h>
#include <string.h>

enum { MATCH_CELLS = 8, REALISE_CELLS = 6, ROUNDS = 6, COLLAPSES = 3 };

enum { MOST_AREA = 960 }; /* of a face that grows, hundredths of a half side squared: 2.4 mean stones */

/* Lengths of the tessellation that follow from the size of stones. */
static int64_t half_side(const pave_cvd *cvd)
{
    return (int64_t)(cvd->params.half_side * PV_GRID + 0.5);
}

/* Pieces merge with neighbours' neighbours, and are cut; chains are drawn by what is around them, and again crack by
 * crack; sides collapse if they are the shortest among faces' neighbours. */
static double reach_before_blocks(double radius)
{
    double cell = 2 * radius, pieces = (2 * PV_PIECES_ROUNDS + 1) * cell;
    double chains = PV_CONTOUR_REACH + PV_SMOOTH_REACH + 2 + 4 * cell;
    return pieces + chains + 2 * COLLAPSES * cell;
}

/* A block's length in px, the longer way. */
static double block_length(const pave_cvd *cvd, int32_t cells)
{
    int64_t side = 2 * half_side(cvd) * cells, unit = cvd->repeats ? PV_GRID : 0;
    int64_t x = pv_block_length(side, unit * cvd->place.width / cvd->scale);
    int64_t y = pv_block_length(side, unit * cvd->place.height / cvd->scale);
    return (double)(x > y ? x : y) / PV_GRID;
}

/* Blocks follow on blocks. */
static double reach_of_blocks(const pave_cvd *cvd, double radius)
{
    return 2 * (4 * block_length(cvd, MATCH_CELLS) + 2 * radius) +
           2 * (4 * block_length(cvd, REALISE_CELLS) + 2 * radius);
}

/* From the window's borders to those of a period of blocks that begins in it, and the cells there. */
static double reach_of_period(const pave_cvd *cvd, double radius)
{
    int32_t x = cvd->place.width - cvd->window.width, y = cvd->place.height - cvd->window.height;
    return (double)(x > y ? x : y) / cvd->scale + block_length(cvd, MATCH_CELLS) + 2 * radius;
}

/* Is it less to see a whole period, where blocks need nothing around them? */
static int sees_period(const pave_cvd *cvd, double radius)
{
    return cvd->repeats && reach_of_period(cvd, radius) < reach_of_blocks(cvd, radius);
}

double pv_best_reach(const pave_cvd *cvd, double radius)
{
    return reach_before_blocks(radius) +
           (sees_period(cvd, radius) ? reach_of_period(cvd, radius) : reach_of_blocks(cvd, radius));
}

/* As much of the diagram as its stones are felt in. */
static pv_rect region_of(const pave_cvd *cvd, const pave_stones_params *params)
{
    pv_rect all = { cvd->place.x, cvd->place.y, cvd->width, cvd->height };
    int32_t margin = (int32_t)ceil(pv_stones_margin(cvd, params)) + 1;
    return pv_rect_grown(cvd->window, cvd->scale * margin, all);
}

static pave_result split(pave_context *context, const pave_image *drawing, const pave_cvd *cvd, pv_rect region,
                         int fill, pv_pieces *pieces)
{
    int64_t first = (int64_t)(region.y - cvd->place.y) * cvd->width + region.x - cvd->place.x;
    pv_label_image image = { .width = region.width, .height = region.height, .labels = cvd->labels + first,
                             .stride = cvd->width, .label_count = cvd->site_count, .colours = drawing->pixels,
                             .scale = cvd->scale, .colour_x = region.x - cvd->scale * drawing->place.x,
                             .colour_y = region.y - cvd->scale * drawing->place.y,
                             .colour_width = drawing->width };
    double side = cvd->scale * cvd->params.half_side;
    return pv_pieces_split(context, &image, (int64_t)(side * side), fill, pieces);
}

/* From labels to faces. */
static pave_result trace(pave_context *context, const pave_image *drawing, const pave_cvd *cvd,
                         const pave_stones_params *params, pv_tess *tess)
{
    pv_pieces pieces;
    pv_rect region = region_of(cvd, params);
    pv_tess_place place = { region.x, region.y, cvd->scale, cvd->params.half_side, { 0, 0 },
                            drawing->levels ? drawing : NULL };
    if (cvd->repeats)
        place.period = (pv_cell){ cvd->place.width / cvd->scale, cvd->place.height / cvd->scale };
    pave_result result = split(context, drawing, cvd, region, params->thin == PAVE_THIN_DROP, &pieces);
    if (!result)
        result = pv_tess_trace(context, &pieces, &place, tess);
    tess->has_whole = sees_period(cvd, (double)cvd->radius / 256 / cvd->scale);
    tess->whole = (pv_cell){ cvd->window.x / cvd->scale * PV_GRID, cvd->window.y / cvd->scale * PV_GRID };
    pv_pieces_free(&pieces);
    return result;
}

enum { SPARE_CORNERS = 16, MOST_STONES = 2 * PV_STONE_PARTS };

/* Stones of all faces, before they are put one after the other. */
typedef struct quarry {
    const pave_stones_params *params;
    const pave_cvd *cvd;
    const pv_tess *tess;
    pv_cell *corner;     /* of face f from first_corner(f) on */
    uint8_t (*count)[MOST_STONES]; /* of face f, one after the other; 0: no more */
    uint8_t *cut;        /* stones that the joint took corners of, or all */
} quarry;

enum { TASK = 256 };

/* Losses of a cell's area for which one stone of four corners is kept. A wedge beside a bent contour eats the edge of
 * the drawing; among stones of one colour it is hardly seen. */
#define LOSS_INSIDE 0.125
#define LOSS_AT_CONTOUR 0.087
#define LOSS_AT_BEND 0.02
#define LOSS_PARTED 0.06
#define LOSS_MORE_CORNERS 0.01

static double area_of(const pv_cell *ring, int32_t count)
{
    return (double)pv_ring_area(ring, count);
}

/* Two stones in a cell. Returns 0 if it cannot be parted well. */
static int part_cell(const pv_stone_cell *cell, double most_loss, pv_cell *out, int32_t counts[2])
{
    pv_cell first[PV_STONE_MOST], second[PV_STONE_MOST];
    uint8_t corner[PV_STONE_MOST];
    if (!pv_stone_part(cell, most_loss, first, second, counts))
        return 0;
    pv_stone_mark(first, counts[0], corner);
    pv_stone_cell a = { counts[0], first, corner, 0 };
    counts[0] = pv_stone_fit(&a, most_loss, out);
    pv_stone_mark(second, counts[1], corner);
    pv_stone_cell b = { counts[1], second, corner, 0 };
    counts[1] = pv_stone_fit(&b, most_loss, out + counts[0]);
    return 1;
}

/* Are two stones better than the one there is, if there is one? */
static int try_two(const pv_stone_cell *cell, double most_loss, int32_t found, pv_cell *out, int32_t counts[2])
{
    pv_cell parts[2 * PV_STONE_MOST];
    int32_t n[2];
    if (!part_cell(cell, most_loss, parts, n))
        return 0;
    double left = area_of(parts, n[0]) + area_of(parts + n[0], n[1]);
    if (found && (n[0] != 4 || n[1] != 4 || left < (1 - LOSS_PARTED) * area_of(cell->ring, cell->count)))
        return 0;
    memcpy(counts, n, sizeof n);
    memcpy(out, parts, (size_t)(n[0] + n[1]) * sizeof *out);
    return 1;
}

/* A larger stone of more corners than the one there is; only if that leaves too much may it have dents. */
static int32_t try_more_corners(const pv_stone_cell *cell, double most_loss, int32_t found, pv_cell *out)
{
    pv_stone_cell with_dents = { cell->count, cell->ring, cell->corner, 1 };
    pv_cell larger[PV_STONE_SIDES];
    double area = area_of(cell->ring, cell->count), most = found ? area_of(out, found) : 0;
    for (int dents = 0; dents < 2 && most < (1 - (dents ? 1.1 * most_loss : LOSS_MORE_CORNERS)) * area; dents++) {
        int32_t count = pv_stone_grow(dents ? &with_dents : cell, LOSS_MORE_CORNERS, larger);
        if (!count || area_of(larger, count) <= most)
            continue;
        most = area_of(larger, count);
        found = count;
        memcpy(out, larger, (size_t)count * sizeof *out);
    }
    return found;
}

/* The stones of a cell, one after the other: one of four corners if it leaves little of the cell, else two of four,
 * else one of more corners. */
static void cut_cell(const pv_stone_cell *cell, double most_loss, pv_cell *out, int32_t counts[2])
{
    counts[0] = pv_stone_fit(cell, most_loss, out);
    counts[1] = 0;
    if (counts[0] == 4 && area_of(out, 4) >= (1 - most_loss) * area_of(cell->ring, cell->count))
        return;
    if (try_two(cell, most_loss, counts[0], out, counts))
        return;
    counts[0] = try_more_corners(cell, most_loss, counts[0], out);
    if (!counts[0])
        counts[0] = pv_stone_inscribe(cell, most_loss, out);
}

static int32_t open_joints(const quarry *q, pv_cell *stone, int32_t count)
{
    double way = q->params->grout / 2 * PV_GRID;
    return q->params->joint_style == PAVE_JOINT_PAPER ? pv_stone_draw_in(stone, count, way)
                                                      : pv_stone_offset(stone, count, way);
}

/* Where a stone with dents has no room for joints, they go around the convex one in it. */
static int32_t open_joints_anyhow(const quarry *q, pv_cell *stone, int32_t count)
{
    pv_cell whole[PV_STONE_MOST], convex[PV_STONE_MOST];
    uint8_t corner[PV_STONE_MOST];
    memcpy(whole, stone, (size_t)count * sizeof *stone);
    int32_t after = open_joints(q, stone, count);
    if (after)
        return after;
    pv_stone_mark(whole, count, corner);
    pv_stone_cell cell = { count, whole, corner, 0 };
    int32_t fitted = pv_stone_fit(&cell, 0.25, convex);
    after = fitted ? open_joints(q, convex, fitted) : 0;
    if (after > count)
        return 0;
    memcpy(stone, convex, (size_t)after * sizeof *stone);
    return after;
}

static void move(pv_cell *ring, int32_t count, pv_cell way)
{
    for (int32_t i = 0; i < count; i++)
        ring[i] = (pv_cell){ ring[i].x + way.x, ring[i].y + way.y };
}

/* Two for each corner of the face would do for its stones, if none were divided. */
static int64_t first_corner(const pv_tess *tess, int32_t f)
{
    return 3 * tess->first[f] + SPARE_CORNERS * (int64_t)f;
}

/* A stone of a cell, in parts if it is too long, with joints around: from `out` on, of which there are `room`. */
static int32_t add_parts(const quarry *q, int32_t f, const pv_cell *stone, int32_t count, pv_cell origin,
                         int32_t *stones, pv_cell *out, int32_t room)
{
    pv_cell parts[2 * PV_STONE_MOST];
    int32_t counts[PV_STONE_PARTS], used = 0;
    memcpy(parts, stone, (size_t)count * sizeof *stone);
    int32_t n = pv_stone_divide(parts, count, q->params->aspect, room, counts);
    for (int32_t k = 0, at = 0; k < n; at += counts[k++]) {
        int32_t after = open_joints_anyhow(q, parts + at, counts[k]);
        q->cut[f] += after < counts[k];
        if (!after || after > UINT8_MAX)
            continue;
        move(parts + at, after, origin);
        memcpy(out + used, parts + at, (size_t)after * sizeof *out);
        q->count[f][(*stones)++] = (uint8_t)after;
        used += after;
    }
    return used;
}

/* How much of a face one stone of four corners may leave. */
static double most_loss_of(const pv_tess *tess, int32_t f)
{
    uint8_t kinds = 0;
    for (int64_t p = tess->first[f]; p < tess->first[f + 1]; p++)
        kinds |= tess->kind[tess->corner[p]];
    if (!(kinds & PV_CONTOUR))
        return LOSS_INSIDE;
    return kinds & PV_BEND ? LOSS_AT_BEND : LOSS_AT_CONTOUR;
}

static void cut_face(const quarry *q, int32_t f)
{
    pv_cell ring[PV_STONE_MOST], stones[2 * PV_STONE_MOST], *out = q->corner + first_corner(q->tess, f);
    uint8_t corner[PV_STONE_MOST];
    int32_t before[2] = { 0, 0 }, count = pv_tess_ring(q->tess, f, ring, PV_STONE_MOST), made = 0, used = 0;
    if (count > PV_STONE_MOST)
        return;
    pv_cell origin = ring[0]; /* so that the stone is the same wherever it lies */
    move(ring, count, (pv_cell){ -origin.x, -origin.y });
    for (int32_t i = 0; i < count; i++)
        corner[i] = (uint8_t)pv_is_corner(q->tess, q->tess->first[f] + i);
    pv_stone_cell cell = { count, ring, corner, 0 };
    cut_cell(&cell, most_loss_of(q->tess, f), stones, before);
    int32_t room = (int32_t)(first_corner(q->tess, f + 1) - first_corner(q->tess, f)) - before[1];
    if (before[0])
        used = add_parts(q, f, stones, before[0], origin, &made, out, room);
    if (before[1])
        add_parts(q, f, stones + before[0], before[1], origin, &made, out + used, room + before[1] - used);
}

static void cut_faces(void *data, int32_t task, int32_t worker)
{
    const quarry *q = data;
    (void)worker;
    for (int32_t f = task * TASK; f < (task + 1) * TASK && f < q->tess->face_count; f++)
        if (q->cvd->mine[q->tess->label[f]])
            cut_face(q, f);
}

/* How many periods a copy of a site is away, grid units. */
static pv_cell shift_of(const pave_cvd *cvd, int32_t site)
{
    pv_shift s = cvd->shifts ? cvd->shifts[site] : (pv_shift){ 0, 0 };
    return (pv_cell){ (int32_t)((int64_t)s.x * PV_GRID / (256 * cvd->scale)),
                      (int32_t)((int64_t)s.y * PV_GRID / (256 * cvd->scale)) };
}

static void add_stones(const quarry *q, int32_t face, pave_stones *out)
{
    int64_t from = first_corner(q->tess, face);
    pv_cell shift = shift_of(q->cvd, q->tess->label[face]);
    for (int k = 0; k < MOST_STONES && q->count[face][k]; k++) {
        int64_t at = out->starts[out->count];
        int32_t count = q->count[face][k];
        for (int32_t i = 0; i < count; i++, from++) {
            out->vertices[2 * (at + i)] = (double)(q->corner[from].x - shift.x) / PV_GRID;
            out->vertices[2 * (at + i) + 1] = (double)(q->corner[from].y - shift.y) / PV_GRID;
        }
        out->colours[out->count] = q->tess->colour[face];
        out->sites[out->count] = q->cvd->numbers[q->tess->label[face]];
        out->starts[++out->count] = at + count;
    }
}

static void count_cells(const quarry *q, pave_stones *out)
{
    const pv_tess *tess = q->tess;
    for (int32_t f = 0; f < tess->face_count; f++) {
        int64_t junctions = 0;
        if (!q->cvd->mine[tess->label[f]])
            continue;
        for (int64_t p = tess->first[f]; p < tess->first[f + 1]; p++)
            junctions += !(tess->kind[tess->corner[p]] & PV_BEND);
        pv_count_cell(&out->report, junctions);
        out->report.vanished += !q->count[f][0];
        out->report.reduced += q->cut[f];
    }
}

static pave_result isolate(pave_context *context, const pave_cvd *cvd, const pv_tess *tess, pave_stones *out)
{
    quarry q = { &out->params, cvd, tess, NULL, NULL, NULL };
    int64_t count = 0, corners = 0;
    pave_result result = PAVE_OK;
    q.corner = pv_allocate(context, (size_t)first_corner(tess, tess->face_count), sizeof *q.corner, &result);
    if (!result)
        q.count = pv_allocate_zeroed(context, (size_t)tess->face_count, sizeof *q.count, &result);
    if (!result)
        q.cut = pv_allocate_zeroed(context, (size_t)tess->face_count, sizeof *q.cut, &result);
    if (!result)
        result = pv_parallel(context, (tess->face_count + TASK - 1) / TASK, cut_faces, &q, 0.8, 0.98);
    for (int32_t f = 0; f < tess->face_count && !result; f++)
        for (int k = 0; k < MOST_STONES && q.count[f][k]; k++)
            count++, corners += q.count[f][k];
    if (!result)
        result = pv_stones_allocate(context, (size_t)count, (size_t)corners, out);
    for (int32_t f = 0; f < tess->face_count && !result; f++)
        add_stones(&q, f, out);
    if (!result)
        count_cells(&q, out);
    pv_release(q.corner);
    pv_release(q.count);
    pv_release(q.cut);
    return result;
}

pave_result pv_best_tess(pave_context *context, const pave_image *drawing, const pave_cvd *cvd,
                         const pave_stones_params *params, pv_tess *out)
{
    int64_t h = half_side(cvd);
    pv_assign_params assign = { 2 * h * MATCH_CELLS, 75, 24 };
    pv_realise_params realise = { 2 * h * REALISE_CELLS, ROUNDS, (int32_t)h, (int32_t)(h / 5), (int32_t)(h / 4),
                                  (int32_t)(h / 8), (int32_t)(h / 17), MOST_AREA * h * h / 100, NULL, NULL };
    pave_result result = trace(context, drawing, cvd, params, out);
    if (!result)
        result = pv_tess_collapse(context, out, h / 2, 4, COLLAPSES);
    if (!result)
        result = pv_assign_flats(context, &assign, out, 0.3, 0.5);
    if (!result)
        result = pv_realise_flats(context, &realise, out, 0.5, 0.8);
#ifndef NDEBUG
    if (!result)
        result = pv_tess_check(context, out);
#endif
    return result;
}

pave_result pv_stones_best(pave_context *context, const pave_image *drawing, const pave_cvd *cvd, pave_stones *out)
{
    pv_tess tess = { 0 };
    pave_result result = pv_best_tess(context, drawing, cvd, &out->params, &tess);
    if (!result)
        result = isolate(context, cvd, &tess, out);
    pv_tess_free(&tess);
    return result;
}
