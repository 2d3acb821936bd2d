/* The centroidal Voronoi diagram: draw the sites; label, move, again; label once more (III.B). */
#include "cvd/cvd.h"

#include "field/field.h"

#include <math.h>
#include <string.h>

static const pave_cvd_params default_params = PAVE_CVD_PARAMS_INIT;

static const pv_param cvd_rows[] = {
    PV_REAL(pave_cvd_params, half_side, "px", 1, 4096, "half the side of a mean stone"),
    PV_INTEGER(pave_cvd_params, stones, "", 0, 1 << 30, "number of stones wanted, instead of half-side; 0: none"),
    PV_INTEGER(pave_cvd_params, iterations, "", 0, 10000, "most times that sites move to the centroid of their cell"),
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
    PV_REAL(pave_cvd_params, relaxation, "", 0.1, 2, "sites go so many times the way to the centroid"),
    PV_REAL(pave_cvd_params, until_still, "px", 0, 4096, "end when sites move by no more on average; 0: never"),
};

const pv_table pv_cvd_table = PV_TABLE("cvd", default_params, cvd_rows);

void pave_cvd_params_init(pave_cvd_params *params, size_t size)
{
    pv_params_init(&pv_cvd_table, params, size);
}

static int32_t plane_width(const pave_field *field) { return field->place.width; }
static int32_t plane_height(const pave_field *field) { return field->place.height; }

double pv_half_side(const pave_cvd_params *params, int32_t width, int32_t height)
{
    return params->stones ? sqrt((double)width * height / params->stones) / 2 : params->half_side; /* Eq. 1 */
}

static pave_result read_stones(pave_context *context, const pave_field *field, pave_cvd_params *params)
{
    params->half_side = pv_half_side(params, plane_width(field), plane_height(field));
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
    int repeats = field->params.periodic; /* then a window may straddle the border */
    int64_t right = repeats ? out->width : (int64_t)out->x + out->width;
    int64_t bottom = repeats ? out->height : (int64_t)out->y + out->height;
    if (out->x < 0 || out->y < 0 || out->x >= plane_width(field) || out->y >= plane_height(field) ||
        right > plane_width(field) || bottom > plane_height(field))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "window %d,%d,%d,%d does not lie in the plane of %d x %d px",
                       (int)out->x, (int)out->y, (int)out->width, (int)out->height, (int)plane_width(field),
                       (int)plane_height(field));
    return PAVE_OK;
}

static int is_whole(const pave_field *field, pv_rect w)
{
    return w.width == plane_width(field) && w.height == plane_height(field);
}

static pave_result read_params(pave_context *context, const pave_cvd_params *given, const pave_field *field,
                               pave_cvd *cvd)
{
    pave_result result = pv_params_read(context, &pv_cvd_table, given, &cvd->params);
    if (!result && cvd->params.scale_min > cvd->params.scale_max)
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "scale_min is greater than scale_max");
    if (!result)
        result = read_stones(context, field, &cvd->params);
    if (!result)
        result = read_window(context, field, cvd->params.window, &cvd->window);
    if (!result && cvd->params.until_still > 0 && !is_whole(field, cvd->window))
        result = pv_fail(context, PAVE_ERR_ARGUMENT,
                         "until_still looks at all sites of a plane: it is not for windows");
    return result;
}

static pave_result copy_window(pave_context *context, pave_cvd *cvd)
{
    const pv_rect *w = &cvd->window;
    pave_result result = PAVE_OK;
    cvd->window_labels = cvd->labels;
    if (w->width == cvd->width && w->height == cvd->height)
        return PAVE_OK;
    cvd->window_labels = pv_allocate(context, (size_t)w->width * (size_t)w->height, sizeof *cvd->labels, &result);
    for (int32_t y = 0; y < w->height && !result; y++)
        memcpy(cvd->window_labels + (int64_t)y * w->width,
               cvd->labels + (int64_t)(w->y - cvd->place.y + y) * cvd->width + w->x - cvd->place.x,
               (size_t)w->width * sizeof *cvd->labels);
    return result;
}

/* How far there is a field: for ever, where it wraps. */
static pv_rect bounds_of(const pave_field *field)
{
    const int32_t far = 1 << 29;
    return field->wraps ? (pv_rect){ -far, -far, 2 * far, 2 * far }
                        : (pv_rect){ field->place.x, field->place.y, field->width, field->height };
}

/* Is a whole period wanted, or less work than the window with its margin? */
static int torus_pays(const pave_field *field, const pave_cvd *cvd, int32_t margin)
{
    double around = pv_torus_guess(&cvd->params);
    return is_whole(field, cvd->window) ||
           (cvd->place.width + 2 * around) * (cvd->place.height + 2 * around) <=
               (cvd->window.width + 2.0 * margin) * (cvd->window.height + 2.0 * margin);
}

/* Where the plane repeats, there has to be a stone. */
static pave_result check_period(pave_context *context, const pave_cvd *cvd)
{
    double side = 2 * cvd->params.half_side, scale = cvd->scale;
    if (!cvd->repeats || side * side <= 1.001 * cvd->place.width * cvd->place.height)
        return PAVE_OK;
    return pv_fail(context, PAVE_ERR_ARGUMENT,
                   "a stone of %g x %g px is more than a drawing that repeats every %g x %g px", side / scale,
                   side / scale, cvd->place.width / scale, cvd->place.height / scale);
}

/* A region that holds the window and all that can tell on it; a larger one if it turns out to be too small. Without
 * labels, and with *needed, if there is not enough of the field. */
static pave_result make(pave_context *context, const pave_field *field, int32_t *needed, pave_cvd *cvd)
{
    pv_rect bounds = bounds_of(field);
    int32_t wanted = (int32_t)ceil(fmin(cvd->params.window_margin * cvd->params.half_side, 1 << 20));
    int32_t margin = wanted + pv_margin_guess(&cvd->params, 0);
    cvd->place = (pv_place){ 0, 0, plane_width(field), plane_height(field) };
    cvd->repeats = field->params.periodic;
    pave_result fits = check_period(context, cvd);
    if (fits)
        return fits;
    if (field->wraps && torus_pays(field, cvd, margin)) {
        pave_result result = pv_torus_make(context, field, wanted, cvd);
        return result ? result : copy_window(context, cvd);
    }
    for (;;) {
        pv_rect region = pv_rect_grown(cvd->window, margin, bounds);
        cvd->reserve = margin;
        pave_result result = pv_region_make(context, field, region, 0, cvd);
        if (result)
            return result;
        pv_rect left = pv_region_rect(cvd);
        int32_t lacking = wanted + (cvd->exact >> 8) + 1 - pv_rect_room(cvd->window, left, cvd);
        if (cvd->site_count && lacking <= 0)
            return copy_window(context, cvd);
        pv_region_drop(cvd);
        margin += (lacking > 0 ? lacking : 0) + margin / 4 + 1;
        if (region.width == bounds.width && region.height == bounds.height &&
            pv_region_open(cvd, region) == pv_region_open(cvd, left)) {
            *needed = margin;
            return PAVE_OK;
        }
    }
}

/* All lengths in the diagram's own px. */
static void scale_up(int32_t scale, pave_cvd *cvd)
{
    cvd->window = (pv_rect){ cvd->window.x * scale, cvd->window.y * scale, cvd->window.width * scale,
                             cvd->window.height * scale };
    cvd->params.half_side *= scale;
    cvd->params.until_still *= scale;
}

/* On a finer field with everything else as much larger. */
static pave_result make_finer(pave_context *context, const pave_field *field, int32_t *needed, pave_cvd *cvd)
{
    pave_cvd_params params = cvd->params;
    pave_field *fine = NULL;
    int32_t scale = params.supersample ? params.supersample : 1;
    cvd->scale = scale;
    cvd->params.supersample = scale;
    if (scale == 1)
        return make(context, field, needed, cvd);
    pave_result result = pv_field_refine(context, field, scale, &fine);
    scale_up(scale, cvd);
    if (!result)
        result = make(context, fine, needed, cvd);
    cvd->params = params;
    cvd->params.supersample = scale;
    cvd->movement /= cvd->movement > 0 ? scale : 1;
    *needed = (*needed + scale - 1) / scale;
    pave_field_free(&fine);
    return result;
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
    int whole = !result && is_whole(field, cvd->window);
    pv_call call = pv_call_begin(context, "diagram", 0, 1);
    if (!result)
        result = make_finer(context, field, needed, cvd);
    pv_call_end(context, call);
    if (!whole && cvd->steps)
        cvd->movement = -1;
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
    pv_region_drop(*cvd);
    pv_release(*cvd);
    *cvd = NULL;
}

int32_t pave_cvd_x(const pave_cvd *cvd) { return cvd->window.x; }
int32_t pave_cvd_y(const pave_cvd *cvd) { return cvd->window.y; }
int32_t pave_cvd_width(const pave_cvd *cvd) { return cvd->window.width; }
int32_t pave_cvd_height(const pave_cvd *cvd) { return cvd->window.height; }
double pave_cvd_half_side(const pave_cvd *cvd) { return cvd->params.half_side; }
const int32_t *pave_cvd_labels(const pave_cvd *cvd) { return cvd->window_labels; }
int32_t pave_cvd_supersample(const pave_cvd *cvd) { return cvd->scale; }
int32_t pave_cvd_site_count(const pave_cvd *cvd) { return cvd->site_count; }
const pave_site *pave_cvd_sites(const pave_cvd *cvd) { return cvd->sites; }
const int32_t *pave_cvd_site_numbers(const pave_cvd *cvd) { return cvd->numbers; }
int32_t pave_cvd_steps(const pave_cvd *cvd) { return cvd->steps; }
double pave_cvd_movement(const pave_cvd *cvd) { return cvd->movement; }
int32_t pave_cvd_backend(const pave_cvd *cvd) { return cvd->backend; }
const char *pave_cvd_backend_name(const pave_cvd *cvd) { return cvd->backend_name; }

pave_result pave_cvd_image(pave_context *context, const pave_cvd *cvd, pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !cvd || !out)
        return PAVE_ERR_ARGUMENT;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = cvd->window.width;
    shape.height = cvd->window.height;
    shape.type = PAVE_U32;
    shape.encoding = PAVE_DATA;
    shape.names = "label";
    return pave_image_create(context, &shape, cvd->window_labels, out);
}
