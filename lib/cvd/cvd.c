/* The centroidal Voronoi diagram: draw the sites; label, move, again; label once more (III.B). */
#include "cvd/cvd.h"

#include "field/field.h"
#include "util/fixed.h"
#include "util/random.h"

#include <math.h>
#include <string.h>

static const pave_cvd_params default_params = PAVE_CVD_PARAMS_INIT;

static const pv_param cvd_rows[] = {
    PV_REAL(pave_cvd_params, half_side, "px", 1, 4096, "half the side of a mean stone"),
    PV_INTEGER(pave_cvd_params, stones, "", 0, 1 << 30, "number of stones wanted, instead of half-side; 0: none"),
    PV_INTEGER(pave_cvd_params, iterations, "", 0, 10000, "times that sites move to the centroid of their cell"),
    PV_SEED(pave_cvd_params, seed, "another seed, another pavement"),
    PV_REAL(pave_cvd_params, cap, "half sides", 0, 1, "half extent of the metric's flat box"),
    PV_REAL(pave_cvd_params, scale_min, "", 0.1, 10, "least stretch of a box"),
    PV_REAL(pave_cvd_params, scale_max, "", 0.1, 10, "greatest stretch of a box"),
    PV_REAL(pave_cvd_params, noise_angle, "degrees", 0, 360, "greatest rotation away from edges"),
    PV_REAL(pave_cvd_params, noise_length, "half sides", 1, 4096, "wave length of the rotation's noise"),
    PV_REAL(pave_cvd_params, push_within, "half sides", 0, 4, "sites nearer to an edge are moved and aligned"),
    PV_REAL(pave_cvd_params, push_to, "half sides", 0, 4, "to this distance from the edge"),
    PV_INTEGER(pave_cvd_params, supersample, "", 0, 4, "the diagram's pixels to one of the drawing; 0: by mode"),
    PV_WINDOW(pave_cvd_params, window, "only this part of the plane, px [the whole]"),
    PV_REAL(pave_cvd_params, window_margin, "half sides", 0, 4096, "exact labels wanted around the window"),
};

const pv_table pv_cvd_table = PV_TABLE("cvd", default_params, cvd_rows);

void pave_cvd_params_init(pave_cvd_params *params, size_t size)
{
    pv_params_init(&pv_cvd_table, params, size);
}

enum { FIELD_ROUNDING = 512 };

static int32_t fixed(double v)
{
    return (int32_t)floor(256 * v + 0.5);
}

static int32_t plane_width(const pave_field *field) { return field->place.width; }
static int32_t plane_height(const pave_field *field) { return field->place.height; }

static pave_result read_stones(pave_context *context, const pave_field *field, pave_cvd_params *params)
{
    if (params->stones) /* Eq. 1 */
        params->half_side = sqrt((double)plane_width(field) * plane_height(field) / params->stones) / 2;
    if (params->half_side < 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT,
                       "%d stones are too many for %d x %d px: half a side would be under 1 px", (int)params->stones,
                       (int)plane_width(field), (int)plane_height(field));
    if (params->half_side > 4096)
        return pv_fail(context, PAVE_ERR_ARGUMENT,
                       "%d stones are too few for %d x %d px: half a side would be over 4096 px", (int)params->stones,
                       (int)plane_width(field), (int)plane_height(field));
    return PAVE_OK;
}

static pave_result read_window(pave_context *context, const pave_field *field, const int32_t *window, pv_rect *out)
{
    *out = (pv_rect){ window[0], window[1], window[2], window[3] };
    if (!window[0] && !window[1] && !window[2] && !window[3])
        *out = (pv_rect){ 0, 0, plane_width(field), plane_height(field) };
    if (out->width < 1 || out->height < 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "window has no pixels: %d x %d", (int)out->width, (int)out->height);
    if (out->x < 0 || out->y < 0 || (int64_t)out->x + out->width > plane_width(field) ||
        (int64_t)out->y + out->height > plane_height(field))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "window %d,%d,%d,%d does not lie in the plane of %d x %d px",
                       (int)out->x, (int)out->y, (int)out->width, (int)out->height, (int)plane_width(field),
                       (int)plane_height(field));
    return PAVE_OK;
}

static pave_result read_params(pave_context *context, const pave_cvd_params *given, const pave_field *field,
                               pave_cvd *cvd)
{
    pave_result result = pv_params_read(context, &pv_cvd_table, given, &cvd->params);
    if (!result && cvd->params.scale_min > cvd->params.scale_max)
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "scale_min is greater than scale_max");
    if (!result)
        result = read_stones(context, field, &cvd->params);
    cvd->scale = cvd->params.supersample ? cvd->params.supersample : 1;
    cvd->params.supersample = cvd->scale;
    return result ? result : read_window(context, field, cvd->params.window, &cvd->window);
}

static const float *field_row(const pave_field *field, const pave_cvd *cvd, int32_t y)
{
    int32_t dx = cvd->place.x - field->place.x, dy = cvd->place.y - field->place.y;
    return field->distance + (int64_t)(y + dy) * field->width + dx;
}

static int has_edges(const pave_field *field, const pave_cvd *cvd)
{
    for (int32_t y = 0; y < cvd->height; y++) {
        const float *row = field_row(field, cvd, y);
        for (int32_t x = 0; x < cvd->width; x++)
            if (isfinite(row[x]))
                return 1;
    }
    return 0;
}

static uint16_t quantised(double distance, double unit)
{
    double d = distance * unit + 0.5;
    return d < UINT16_MAX ? (uint16_t)d : UINT16_MAX;
}

/* Between which of `count` pixels the diagram's pixel `i` lies, and how far from the first. */
static double between(int32_t i, int32_t scale, int32_t count, int32_t *a, int32_t *b)
{
    int32_t at = 2 * i + 1 - scale, first = (int32_t)pv_floor_div(at, 2 * scale);
    *a = first < 0 ? 0 : first;
    *b = first + 1 < count ? first + 1 : first;
    return (double)(at - 2 * scale * first) / (2 * scale);
}

/* The distance at a row of the diagram's pixels: what those of the drawing around them say together. */
static void quantise_between(const pave_field *field, const pave_cvd *cvd, int32_t y, double unit, uint16_t *out)
{
    int32_t top, bottom, left, right;
    double v = between(y, cvd->scale, cvd->height, &top, &bottom);
    const float *up = field_row(field, cvd, top), *down = field_row(field, cvd, bottom);
    for (int32_t x = 0; x < pv_cvd_columns(cvd); x++) {
        double u = between(x, cvd->scale, cvd->width, &left, &right);
        double a = up[left] + ((double)up[right] - up[left]) * u;
        double b = down[left] + ((double)down[right] - down[left]) * u, d = a + (b - a) * v;
        out[x] = isfinite(d) ? quantised(cvd->scale * d, unit) : UINT16_MAX;
    }
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
    uint16_t *edge = pv_allocate(context, (size_t)plane->width * (size_t)plane->height, sizeof *edge, result);
    for (int32_t y = 0; y < plane->height && edge; y++) {
        uint16_t *out = edge + (int64_t)y * plane->width;
        if (cvd->scale > 1) {
            quantise_between(field, cvd, y, unit, out);
            continue;
        }
        const float *row = field_row(field, cvd, y);
        for (int32_t x = 0; x < cvd->width; x++)
            out[x] = quantised(row[x], unit);
    }
    return edge;
}

static void set_lengths(const pave_cvd *cvd, pv_plane *plane)
{
    const pave_cvd_params *params = &cvd->params;
    double h = cvd->scale * params->half_side;
    memset(plane, 0, sizeof *plane);
    plane->width = cvd->scale * cvd->width;
    plane->height = cvd->scale * cvd->height;
    plane->origin_x = 256 * cvd->scale * cvd->place.x;
    plane->origin_y = 256 * cvd->scale * cvd->place.y;
    plane->cell = fixed(2 * h);
    plane->push_within = fixed(params->push_within * h);
    plane->push_to = fixed(params->push_to * h);
    plane->noise_wave = fixed(params->noise_length * h);
    plane->noise_swing = (int32_t)floor(params->noise_angle * 65536 / 360 + 0.5);
    plane->noise_key = pv_draw(params->seed, PV_DRAW_NOISE, 0, 0, 0).word[0];
    plane->seed = params->seed;
}

static pave_result relax(pave_context *context, const pv_backend *backend, void *engine, const pv_plane *plane,
                         pave_cvd *cvd)
{
    int32_t steps = cvd->params.iterations;
    double share = 1.0 / (steps + 1);
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < steps && !result; i++) {
        pv_step step = { 0, 0, 0 };
        result = backend->step(context, engine, i, i * share, (i + 1) * share, &step);
        cvd->exact = pv_margin_after(plane, cvd->exact, step.radius);
    }
    if (!result)
        result = backend->labels(context, engine, steps * share, 1, cvd->labels);
    if (!result)
        result = backend->sites(context, engine, cvd->sites);
    return result;
}

static pave_result run_on(pave_context *context, const pv_backend *backend, const pv_plane *plane, pave_cvd *cvd)
{
    void *engine = NULL;
    cvd->exact = plane->push_within + FIELD_ROUNDING; /* what lies beyond the field cannot be nearer than that */
    pave_result result = backend->open(context, plane, &engine, cvd->backend_name);
    if (!result)
        result = relax(context, backend, engine, plane, cvd);
    if (engine)
        backend->close(engine);
    cvd->backend = backend->id;
    return result;
}

/* A device that fails is no reason to fail, unless the caller named it: the CPU gives the same bytes. */
static pave_result run(pave_context *context, const pv_plane *plane, pave_cvd *cvd)
{
    const pv_backend *backend = pv_backend_choose(context, plane, cvd->params.iterations);
    if (!backend)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "this build of libpave has no such backend");
    pave_result result = run_on(context, backend, plane, cvd);
    if ((result == PAVE_ERR_DEVICE || result == PAVE_ERR_UNSUPPORTED) && context->backend == PAVE_BACKEND_AUTO) {
        pv_note(context, PAVE_MESSAGE_WARNING, "going on with the CPU: %s", context->text);
        result = run_on(context, &pv_cpu_backend, plane, cvd);
    }
    return result;
}

/* The greatest distance from a pixel to its site, and from which depth on labels are exact. */
static void measure_radius(const pv_plane *plane, pave_cvd *cvd)
{
    int64_t most = 0;
    for (int32_t y = 0; y < plane->height; y++)
        for (int32_t x = 0; x < plane->width; x++) {
            const pave_site *s = &cvd->sites[cvd->labels[(int64_t)y * plane->width + x]];
            int64_t dx = 256 * (int64_t)x + 128 - s->x, dy = 256 * (int64_t)y + 128 - s->y;
            most = dx * dx + dy * dy > most ? dx * dx + dy * dy : most;
        }
    cvd->radius = (int32_t)pv_isqrt((uint64_t)most) + 1;
    cvd->exact += cvd->radius + pv_plane_reach(plane);
    cvd->exact = (int32_t)pv_ceil_div(cvd->exact, cvd->scale);
    cvd->radius = (int32_t)pv_ceil_div(cvd->radius, cvd->scale);
}

/* Sites in the plane's coordinates, with the homes that belong to the window. */
static void place_sites(const pv_plane *plane, const pv_seeds *seeds, pave_cvd *cvd)
{
    const pv_rect *w = &cvd->window;
    for (int32_t i = 0; i < cvd->site_count; i++) {
        int32_t x = (seeds->homes[i].x * plane->cell >> 8) / cvd->scale;
        int32_t y = (seeds->homes[i].y * plane->cell >> 8) / cvd->scale;
        cvd->mine[i] = x >= w->x && y >= w->y && x < w->x + w->width && y < w->y + w->height;
        cvd->sites[i].x += plane->origin_x;
        cvd->sites[i].y += plane->origin_y;
    }
}

static pave_result allocate(pave_context *context, pv_seeds *seeds, pave_cvd *cvd)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)seeds->count;
    cvd->site_count = seeds->count;
    cvd->numbers = seeds->numbers; /* taken over */
    seeds->numbers = NULL;
    cvd->mine = pv_allocate(context, n, sizeof *cvd->mine, &result);
    if (!result)
        cvd->sites = pv_allocate(context, n, sizeof *cvd->sites, &result);
    if (!result)
        cvd->labels = pv_allocate(context, (size_t)pv_cvd_columns(cvd) * (size_t)pv_cvd_rows(cvd), sizeof *cvd->labels,
                                  &result);
    return result;
}

/* The first sites, in the diagram's own pixels. */
static pave_result draw_seeds(pave_context *context, const pave_cvd *cvd, const pv_plane *plane, pv_seeds *seeds)
{
    pave_cvd_params params = cvd->params;
    int32_t s = cvd->scale;
    pv_place place = { s * cvd->place.x, s * cvd->place.y, s * cvd->place.width, s * cvd->place.height };
    params.half_side *= s;
    return pv_seeds_draw(context, &params, plane, &place, seeds);
}

/* The diagram of a region. */
static pave_result make_region(pave_context *context, const pave_field *field, pv_rect region, pave_cvd *cvd)
{
    pv_plane plane;
    pv_seeds seeds;
    pave_result result = PAVE_OK;
    cvd->place = (pv_place){ region.x, region.y, plane_width(field), plane_height(field) };
    cvd->width = region.width;
    cvd->height = region.height;
    set_lengths(cvd, &plane);
    uint16_t *edge = quantise_edges(context, field, cvd, &plane, &result);
    plane.edge = edge;
    seeds = (pv_seeds){ NULL, NULL, NULL, 0 };
    if (!result)
        result = draw_seeds(context, cvd, &plane, &seeds);
    plane.start = seeds.sites;
    plane.home = seeds.homes;
    plane.sites = seeds.count;
    if (!result)
        result = allocate(context, &seeds, cvd);
    if (!result && seeds.count)
        result = run(context, &plane, cvd);
    if (!result && seeds.count) {
        if (pv_rect_room(cvd->window, region, &cvd->place) < INT32_MAX)
            measure_radius(&plane, cvd);
        place_sites(&plane, &seeds, cvd);
    }
    pv_release(edge);
    pv_seeds_free(&seeds);
    return result;
}

static void drop_region(pave_cvd *cvd)
{
    pv_release(cvd->labels);
    pv_release(cvd->sites);
    pv_release(cvd->numbers);
    pv_release(cvd->mine);
    cvd->labels = NULL;
    cvd->sites = NULL;
    cvd->numbers = NULL;
    cvd->mine = NULL;
}

static pave_result copy_window(pave_context *context, pave_cvd *cvd)
{
    int32_t s = cvd->scale, row = s * cvd->width;
    pv_rect w = { s * (cvd->window.x - cvd->place.x), s * (cvd->window.y - cvd->place.y), s * cvd->window.width,
                  s * cvd->window.height };
    pave_result result = PAVE_OK;
    cvd->window_labels = cvd->labels;
    if (cvd->window.width == cvd->width && cvd->window.height == cvd->height)
        return PAVE_OK;
    cvd->window_labels = pv_allocate(context, (size_t)w.width * (size_t)w.height, sizeof *cvd->labels, &result);
    for (int32_t y = 0; y < w.height && !result; y++)
        memcpy(cvd->window_labels + (int64_t)y * w.width, cvd->labels + (int64_t)(w.y + y) * row + w.x,
               (size_t)w.width * sizeof *cvd->labels);
    return result;
}

/* A region that holds the window and all that can tell on it; a larger one if it turns out to be too small. Without
 * labels, and with *needed, if there is not enough of the field. */
static pave_result make(pave_context *context, const pave_field *field, int32_t *needed, pave_cvd *cvd)
{
    pv_rect bounds = { field->place.x, field->place.y, field->width, field->height };
    int32_t wanted = (int32_t)ceil(fmin(cvd->params.window_margin * cvd->params.half_side, 1 << 20));
    int32_t margin = wanted + pv_margin_guess(&cvd->params);
    for (;;) {
        pv_rect region = pv_rect_grown(cvd->window, margin, bounds);
        pave_result result = make_region(context, field, region, cvd);
        if (result)
            return result;
        int32_t room = pv_rect_room(cvd->window, region, &cvd->place), least = wanted + (cvd->exact >> 8) + 1;
        if (cvd->site_count && room >= least)
            return copy_window(context, cvd);
        drop_region(cvd);
        margin = (least > margin ? least : margin) + margin / 4 + 1;
        if (region.width == bounds.width && region.height == bounds.height) {
            *needed = margin;
            return PAVE_OK;
        }
    }
}

pave_result pv_cvd_create(pave_context *context, const pave_field *field, const pave_cvd_params *given,
                          int32_t *needed, pave_cvd **out)
{
    pave_result result;
    *needed = 0;
    pave_cvd *cvd = pv_allocate_zeroed(context, 1, sizeof *cvd, &result);
    if (!cvd)
        return result;
    result = read_params(context, given, field, cvd);
    pv_call call = pv_call_begin(context, "diagram", 0, 1);
    if (!result)
        result = make(context, field, needed, cvd);
    pv_call_end(context, call);
    if (result || *needed)
        pave_cvd_free(&cvd);
    *out = cvd;
    return result;
}

pave_result pave_cvd_create(pave_context *context, const pave_field *field, const pave_cvd_params *given,
                            pave_cvd **out)
{
    int32_t needed;
    if (out)
        *out = NULL;
    if (!context || !field || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_cvd_create(context, field, given, &needed, out);
    if (!result && !*out)
        return pv_fail(context, PAVE_ERR_LIMIT, "the window needs %d px of the drawing around it", (int)needed);
    return result;
}

void pave_cvd_free(pave_cvd **cvd)
{
    if (!cvd || !*cvd)
        return;
    if ((*cvd)->window_labels != (*cvd)->labels)
        pv_release((*cvd)->window_labels);
    drop_region(*cvd);
    pv_release(*cvd);
    *cvd = NULL;
}

int32_t pave_cvd_x(const pave_cvd *cvd) { return cvd->scale * cvd->window.x; }
int32_t pave_cvd_y(const pave_cvd *cvd) { return cvd->scale * cvd->window.y; }
int32_t pave_cvd_width(const pave_cvd *cvd) { return cvd->scale * cvd->window.width; }
int32_t pave_cvd_height(const pave_cvd *cvd) { return cvd->scale * cvd->window.height; }
int32_t pave_cvd_supersample(const pave_cvd *cvd) { return cvd->scale; }
double pave_cvd_half_side(const pave_cvd *cvd) { return cvd->params.half_side; }
const int32_t *pave_cvd_labels(const pave_cvd *cvd) { return cvd->window_labels; }
int32_t pave_cvd_site_count(const pave_cvd *cvd) { return cvd->site_count; }
const pave_site *pave_cvd_sites(const pave_cvd *cvd) { return cvd->sites; }
const int32_t *pave_cvd_site_numbers(const pave_cvd *cvd) { return cvd->numbers; }
int32_t pave_cvd_backend(const pave_cvd *cvd) { return cvd->backend; }
const char *pave_cvd_backend_name(const pave_cvd *cvd) { return cvd->backend_name; }

pave_result pave_cvd_image(pave_context *context, const pave_cvd *cvd, pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !cvd || !out)
        return PAVE_ERR_ARGUMENT;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = pave_cvd_width(cvd);
    shape.height = pave_cvd_height(cvd);
    shape.type = PAVE_U32;
    shape.encoding = PAVE_DATA;
    shape.names = "label";
    return pave_image_create(context, &shape, cvd->window_labels, out);
}
