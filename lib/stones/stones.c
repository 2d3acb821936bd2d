/* Stones: trace the cells, colour them, flatten wide angles, snap to the edges, isolate each stone (III.C). */
#include "stones/stones.h"

#include "cvd/cvd.h"
#include "field/field.h"
#include "image/image.h"
#include "util/fixed.h"

#include <math.h>
#include <string.h>

static const pave_stones_params default_params = PAVE_STONES_PARAMS_INIT;

static const pv_param stones_rows[] = {
    PV_CHOICE(pave_stones_params, mode, "paper|best",
              "how stones are made: the text to the letter, or so that a paver would lay them"),
    PV_REAL(pave_stones_params, grout, "px", 0, 1024, "joint width; corners move half of it to the centroid"),
    PV_REAL(pave_stones_params, wide_angle, "degrees", 90, 180, "inner angles beyond this are flattened"),
    PV_INTEGER(pave_stones_params, passes, "", 0, 100, "times that wide angles are flattened"),
    PV_REAL(pave_stones_params, drop_angle, "degrees", 90, 180, "corners of a stone wider than this are dropped"),
    PV_REAL(pave_stones_params, small_edge, "half sides", 0, 2, "shorter edges of a stone lose an end"),
    PV_CHOICE(pave_stones_params, joint_style, "paper|even",
              "joints of best mode: as uneven as the text's, or as wide everywhere as the grout"),
    PV_CHOICE(pave_stones_params, thin, "keep|drop|widen", "lines and spots too thin for a stone"),
    PV_CHOICE(pave_stones_params, border, "wrapped|cut", "stones across the border of a periodic plane: whole, or cut"),
    PV_REAL(pave_stones_params, thin_width, "half sides", 0, 4, "thin features are widened to this, if they are"),
    PV_REAL(pave_stones_params, aspect, "", 0, 1000, "stones longer than so many widths are cut across; 0: none"),
};

const pv_table pv_stones_table = PV_TABLE("stones", default_params, stones_rows);

void pave_stones_params_init(pave_stones_params *params, size_t size)
{
    pv_params_init(&pv_stones_table, params, size);
}

/* The text's way: one shared tessellation, bent; then each stone by itself. */
static pave_result make_paper(pave_context *context, const pave_image *drawing, const pave_field *field,
                        const pave_cvd *cvd, pave_stones *stones)
{
    pv_mesh mesh;
    pave_result result = pv_mesh_trace(context, cvd, &mesh);
    if (!result)
        result = pv_mesh_colour(context, drawing, 0.4, &mesh);
    if (!result)
        result = pv_mesh_flatten(context, &stones->params, &mesh);
    if (!result)
        result = pv_mesh_colour(context, drawing, 0.6, &mesh);
    if (!result)
        result = pv_mesh_snap(context, drawing, field, &mesh);
    if (!result)
        result = pv_stones_isolate(context, drawing, cvd, &mesh, stones);
    for (int32_t r = 0; r < mesh.ring_count && !result; r++)
        if (cvd->mine[r])
            pv_count_cell(&stones->report, mesh.first[r + 1] - mesh.first[r]);
    pv_mesh_free(&mesh);
    return result;
}

static pave_result make(pave_context *context, const pave_image *drawing, const pave_field *field,
                        const pave_cvd *cvd, pave_stones *stones)
{
    pave_result result = stones->params.mode == PAVE_MODE_PAPER ? make_paper(context, drawing, field, cvd, stones)
                                                                : pv_stones_best(context, drawing, cvd, stones);
    if (!result && cvd->shifts)
        result = pv_stones_sort(context, stones);
    if (!result)
        pv_stones_count(cvd, stones);
    if (!result && cvd->repeats && stones->params.border == PAVE_BORDER_CUT)
        result = pv_stones_cut(context, stones);
    return result ? result : pv_progress(context, 1);
}

/* How far beyond its window a home's site lies, px of the diagram. */
static double farthest_site(const pave_cvd *cvd)
{
    const pv_rect *w = &cvd->window;
    int64_t beyond = 0, left = 256 * (int64_t)w->x, top = 256 * (int64_t)w->y;
    int64_t right = left + 256 * (int64_t)w->width, bottom = top + 256 * (int64_t)w->height;
    for (int32_t i = 0; i < cvd->site_count; i++) {
        if (!cvd->mine[i])
            continue;
        int64_t x = cvd->sites[i].x, y = cvd->sites[i].y;
        beyond = left - x > beyond ? left - x : beyond;
        beyond = x - right > beyond ? x - right : beyond;
        beyond = top - y > beyond ? top - y : beyond;
        beyond = y - bottom > beyond ? y - bottom : beyond;
    }
    return (double)beyond / 256;
}

/* Flattening carries something from cell to cell in each pass, colouring once more, and a stone may lie beyond the
 * window that its home is in. */
double pv_stones_margin(const pave_cvd *cvd, const pave_stones_params *params)
{
    double radius = (double)cvd->radius / 256, margin = farthest_site(cvd) + 4;
    if (params->mode == PAVE_MODE_PAPER)
        return margin + (2 * (params->passes + 2) + 1) * radius;
    return (margin + radius) / cvd->scale + pv_best_reach(cvd, radius / cvd->scale);
}

double pv_stones_margin_guess(int32_t width, int32_t height, int repeats, const pave_cvd_params *params,
                              const pave_stones_params *stones)
{
    pave_cvd cvd = { .scale = 1, .place = { 0, 0, width, height }, .repeats = repeats, .params = *params };
    const int32_t *w = params->window;
    cvd.window = w[2] ? (pv_rect){ w[0], w[1], w[2], w[3] } : (pv_rect){ 0, 0, width, height };
    double h = cvd.params.half_side = pv_half_side(params, width, height);
    return stones->mode == PAVE_MODE_PAPER || h < 1 ? 0 : pv_best_reach(&cvd, 4 * h) / h + 8;
}

double pv_stones_thin_width(int32_t width, int32_t height, const pave_cvd_params *cvd,
                            const pave_stones_params *params)
{
    double least = params->thin_width * pv_half_side(cvd, width, height);
    return params->thin == PAVE_THIN_WIDEN ? fmin(least, 200) : 0;
}

pave_result pv_stones_widen(pave_context *context, const pave_cvd_params *cvd, const pave_stones_params *params,
                            int repeats, pave_image **drawing)
{
    pave_image *wide = NULL;
    pv_place plane = (*drawing)->place;
    double least = pv_stones_thin_width(plane.width, plane.height, cvd, params);
    if (!(least > 1))
        return PAVE_OK;
    int whole = pv_is_whole(&plane, (*drawing)->width, (*drawing)->height);
    pave_result result = pave_image_widen(context, *drawing, least, repeats && whole, &wide);
    if (result)
        return result;
    pave_image_free(drawing);
    *drawing = wide;
    return PAVE_OK;
}

double pv_stones_room(const pave_cvd *cvd)
{
    pv_rect region = { cvd->place.x, cvd->place.y, cvd->width, cvd->height };
    int32_t room = pv_rect_room(cvd->window, region, cvd);
    return room == INT32_MAX ? INFINITY : (room - cvd->exact / 256.0) / cvd->scale;
}

int32_t pv_stones_supersample(const pave_stones_params *params)
{
    return params->mode == PAVE_MODE_PAPER ? 1 : 2;
}

/* Does an image, or a field, lie under all of the diagram? */
static int covers(const pv_place *place, int32_t width, int32_t height, const pave_cvd *cvd)
{
    int64_t s = cvd->scale;
    return s * place->width == cvd->place.width && s * place->height == cvd->place.height &&
           s * place->x <= cvd->place.x && s * place->y <= cvd->place.y &&
           s * (place->x + width) >= cvd->place.x + cvd->width && s * (place->y + height) >= cvd->place.y + cvd->height;
}

/* The part of the plane that the diagram's region is on, px of the drawing. */
static pv_rect region_of(const pave_cvd *cvd)
{
    int32_t s = cvd->scale, x = (int32_t)pv_floor_div(cvd->place.x, s), y = (int32_t)pv_floor_div(cvd->place.y, s);
    return (pv_rect){ x, y, (int32_t)pv_ceil_div(cvd->place.x + cvd->width, s) - x,
                      (int32_t)pv_ceil_div(cvd->place.y + cvd->height, s) - y };
}

/* Of a plane that repeats: what the diagram has around it too. */
static pave_result repeat_inputs(pave_context *context, const pave_cvd *cvd, const pave_image **drawing,
                                 const pave_field **field, pave_image **own_drawing, pave_field **own_field)
{
    pv_rect at = region_of(cvd);
    int32_t width = cvd->place.width / cvd->scale, height = cvd->place.height / cvd->scale;
    if (!cvd->repeats || !(*field)->wraps || !pv_is_whole(&(*drawing)->place, width, height) ||
        (*field)->width != width || (*field)->height != height || (*drawing)->type != PAVE_U8 ||
        (*drawing)->channels != 1)
        return PAVE_OK;
    pave_result result = pv_image_repeat(context, *drawing, at.x, at.y, at.width, at.height, own_drawing);
    if (!result)
        result = pv_field_repeat(context, *field, at.x, at.y, at.width, at.height, own_field);
    if (result)
        return result;
    *drawing = *own_drawing;
    *field = *own_field;
    return PAVE_OK;
}

static pave_result check_inputs(pave_context *context, const pave_image *drawing, const pave_field *field,
                                const pave_cvd *cvd, const pave_stones_params *params)
{
    if (drawing->channels != 1 || drawing->type != PAVE_U8)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a drawing has one 8-bit channel: call pave_image_threshold first");
    if (!covers(&drawing->place, drawing->width, drawing->height, cvd) ||
        !covers(&field->place, field->width, field->height, cvd))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "drawing, field and diagram are not of one size");
    if (params->mode == PAVE_MODE_PAPER && cvd->scale > 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the paper's mode takes a diagram on the drawing's own pixels: its "
                       "supersample is %d", (int)cvd->scale);
    double margin = pv_stones_margin(cvd, params), more = margin - pv_stones_room(cvd);
    double needed = ceil(cvd->params.window_margin + more / cvd->params.half_side);
    if (more > 0)
        return pv_fail(context, PAVE_ERR_ARGUMENT,
                       "the diagram's window_margin is too small for its stones: %.0f is needed", needed);
    return PAVE_OK;
}

static pave_result make_stones(pave_context *context, const pave_image *drawing, const pave_field *field,
                               const pave_cvd *cvd, const pave_stones_params *params, pave_stones **out)
{
    pave_result result = PAVE_OK;
    pave_stones *stones = pv_allocate_zeroed(context, 1, sizeof *stones, &result);
    if (!stones)
        return result;
    stones->x = cvd->window.x / cvd->scale;
    stones->y = cvd->window.y / cvd->scale;
    stones->plane_width = cvd->place.width / cvd->scale;
    stones->plane_height = cvd->place.height / cvd->scale;
    stones->width = cvd->window.width / cvd->scale;
    stones->height = cvd->window.height / cvd->scale;
    stones->report.size = sizeof stones->report;
    stones->report.steps = cvd->steps;
    stones->report.movement = cvd->movement;
    stones->cvd = cvd->params;
    stones->params = *params;
    stones->field = field->params;
    pave_threshold_params_init(&stones->threshold, sizeof stones->threshold);
    pave_palette_params_init(&stones->palette, sizeof stones->palette);
    stones->palette.colours = drawing->palette.count;
    stones->palette.palette = drawing->palette;
    stones->backend = cvd->backend;
    memcpy(stones->backend_name, cvd->backend_name, sizeof stones->backend_name);
    pv_call call = pv_call_begin(context, "stones", 0, 1);
    result = make(context, drawing, field, cvd, stones);
    pv_call_end(context, call);
    if (result)
        pave_stones_free(&stones);
    *out = stones;
    return result;
}

pave_result pave_stones_create(pave_context *context, const pave_image *drawing, const pave_field *field,
                               const pave_cvd *cvd, const pave_stones_params *given, pave_stones **out)
{
    if (out)
        *out = NULL;
    if (!context || !drawing || !field || !cvd || !out)
        return PAVE_ERR_ARGUMENT;
    pave_stones_params params;
    pave_result result = pv_params_read(context, &pv_stones_table, given, &params);
    if (result)
        return result;
    pave_image *own_drawing = NULL;
    pave_field *own_field = NULL;
    result = repeat_inputs(context, cvd, &drawing, &field, &own_drawing, &own_field);
    if (!result)
        result = check_inputs(context, drawing, field, cvd, &params);
    if (!result)
        result = make_stones(context, drawing, field, cvd, &params, out);
    pave_image_free(&own_drawing);
    pave_field_free(&own_field);
    return result;
}
void pave_stones_free(pave_stones **stones)
{
    if (!stones || !*stones)
        return;
    pv_stones_drop(*stones);
    pv_release((*stones)->rgb);
    pv_release((*stones)->mosaic);
    pv_release(*stones);
    *stones = NULL;
}

double pv_stones_half_side(const pave_stones *stones)
{
    if (stones->report.half_side > 0)
        return stones->report.half_side;
    double ground = (double)stones->width * stones->height;
    return sqrt(ground / (stones->count ? stones->count : 1)) / 2;
}

int32_t pave_stones_x(const pave_stones *stones) { return stones->x; }
int32_t pave_stones_y(const pave_stones *stones) { return stones->y; }
int32_t pave_stones_width(const pave_stones *stones) { return stones->width; }
int32_t pave_stones_height(const pave_stones *stones) { return stones->height; }
int32_t pave_stones_count(const pave_stones *stones) { return stones->count; }
const int64_t *pave_stones_starts(const pave_stones *stones) { return stones->starts; }
const double *pave_stones_vertices(const pave_stones *stones) { return stones->vertices; }
const uint8_t *pave_stones_colours(const pave_stones *stones) { return stones->colours; }
const pave_palette *pave_stones_palette(const pave_stones *stones) { return &stones->palette.palette; }
const uint8_t *pave_stones_rgb(const pave_stones *stones) { return stones->rgb; }
const int32_t *pave_stones_sites(const pave_stones *stones) { return stones->sites; }
