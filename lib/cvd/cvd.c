/* The centroidal Voronoi diagram: draw the sites; label, move, again; label once more (III.B). */
#include "cvd/cvd.h"

#include "field/field.h"
#include "image/image.h"
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
};

const pv_table pv_cvd_table = PV_TABLE("cvd", default_params, cvd_rows);

void pave_cvd_params_init(pave_cvd_params *params, size_t size)
{
    pv_params_init(&pv_cvd_table, params, size);
}

static int32_t fixed(double v)
{
    return (int32_t)floor(256 * v + 0.5);
}

static pave_result read_params(pave_context *context, const pave_cvd_params *given, const pave_field *field,
                               pave_cvd_params *params)
{
    pave_result result = pv_params_read(context, &pv_cvd_table, given, params);
    if (result)
        return result;
    if (params->scale_min > params->scale_max)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "scale_min is greater than scale_max");
    if (params->stones) /* Eq. 1 */
        params->half_side = sqrt((double)field->width * field->height / params->stones) / 2;
    if (params->half_side < 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT,
                       "%d stones are too many for %d x %d px: half a side would be under 1 px", (int)params->stones,
                       (int)field->width, (int)field->height);
    if (params->half_side > 4096)
        return pv_fail(context, PAVE_ERR_ARGUMENT,
                       "%d stones are too few for %d x %d px: half a side would be over 4096 px", (int)params->stones,
                       (int)field->width, (int)field->height);
    return PAVE_OK;
}

/* What the sites feel of the field, quantised once. NULL without edges, or if nothing is to feel them. */
static uint16_t *quantise_edges(pave_context *context, const pave_field *field, pv_plane *plane, pave_result *result)
{
    int64_t count = (int64_t)field->width * field->height;
    int edges = 0;
    for (int64_t i = 0; i < count && !edges; i++)
        edges = isfinite(field->distance[i]);
    if (!edges || !plane->push_within)
        return NULL;
    while ((plane->push_within + 1024) >> plane->edge_shift > UINT16_MAX)
        plane->edge_shift++;
    uint16_t *edge = pv_allocate(context, (size_t)count, sizeof *edge, result);
    for (int64_t i = 0; i < count && edge; i++) {
        double d = floor(field->distance[i] * 256.0 / (1 << plane->edge_shift) + 0.5);
        edge[i] = d < UINT16_MAX ? (uint16_t)d : UINT16_MAX;
    }
    return edge;
}

static void set_lengths(const pave_cvd_params *params, const pave_field *field, pv_plane *plane)
{
    double h = params->half_side;
    memset(plane, 0, sizeof *plane);
    plane->width = field->width;
    plane->height = field->height;
    plane->cell = fixed(2 * h);
    plane->push_within = fixed(params->push_within * h);
    plane->push_to = fixed(params->push_to * h);
    plane->noise_wave = fixed(params->noise_length * h);
    plane->noise_swing = (int32_t)floor(params->noise_angle * 65536 / 360 + 0.5);
    plane->noise_key = pv_draw(params->seed, PV_DRAW_NOISE, 0, 0, 0).word[0];
    plane->seed = params->seed;
}

static pave_result relax(pave_context *context, const pv_backend *backend, void *engine, pave_cvd *cvd)
{
    int32_t steps = cvd->params.iterations;
    double share = 1.0 / (steps + 1);
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < steps && !result; i++) {
        pv_step step;
        result = backend->step(context, engine, i, i * share, (i + 1) * share, &step);
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
    pave_result result = backend->open(context, plane, &engine, cvd->backend_name);
    if (!result)
        result = relax(context, backend, engine, cvd);
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

static pave_result make(pave_context *context, const pave_field *field, pave_cvd *cvd)
{
    pv_plane plane;
    pave_site *start = NULL;
    pv_home *homes = NULL;
    pave_result result = PAVE_OK;
    set_lengths(&cvd->params, field, &plane);
    uint16_t *edge = quantise_edges(context, field, &plane, &result);
    plane.edge = edge;
    if (!result)
        result = pv_seeds(context, &cvd->params, &plane, &start, &homes, &cvd->site_count);
    plane.start = start;
    plane.home = homes;
    plane.sites = cvd->site_count;
    if (!result)
        cvd->sites = pv_allocate(context, (size_t)plane.sites, sizeof *cvd->sites, &result);
    if (!result)
        cvd->labels = pv_allocate(context, (size_t)plane.width * (size_t)plane.height, sizeof *cvd->labels, &result);
    if (!result)
        result = run(context, &plane, cvd);
    pv_release(edge);
    pv_release(start);
    pv_release(homes);
    return result;
}

pave_result pave_cvd_create(pave_context *context, const pave_field *field, const pave_cvd_params *given,
                            pave_cvd **out)
{
    if (out)
        *out = NULL;
    if (!context || !field || !out)
        return PAVE_ERR_ARGUMENT;
    pave_cvd_params params;
    pave_result result = read_params(context, given, field, &params);
    if (result)
        return result;
    pave_cvd *cvd = pv_allocate_zeroed(context, 1, sizeof *cvd, &result);
    if (!cvd)
        return result;
    cvd->width = field->width;
    cvd->height = field->height;
    cvd->params = params;
    pv_call call = pv_call_begin(context, "diagram", 0, 1);
    result = make(context, field, cvd);
    pv_call_end(context, call);
    if (result)
        pave_cvd_free(&cvd);
    *out = cvd;
    return result;
}

void pave_cvd_free(pave_cvd **cvd)
{
    if (!cvd || !*cvd)
        return;
    pv_release((*cvd)->labels);
    pv_release((*cvd)->sites);
    pv_release(*cvd);
    *cvd = NULL;
}

int32_t pave_cvd_width(const pave_cvd *cvd) { return cvd->width; }
int32_t pave_cvd_height(const pave_cvd *cvd) { return cvd->height; }
double pave_cvd_half_side(const pave_cvd *cvd) { return cvd->params.half_side; }
const int32_t *pave_cvd_labels(const pave_cvd *cvd) { return cvd->labels; }
int32_t pave_cvd_site_count(const pave_cvd *cvd) { return cvd->site_count; }
const pave_site *pave_cvd_sites(const pave_cvd *cvd) { return cvd->sites; }
int32_t pave_cvd_backend(const pave_cvd *cvd) { return cvd->backend; }
const char *pave_cvd_backend_name(const pave_cvd *cvd) { return cvd->backend_name; }

pave_result pave_cvd_image(pave_context *context, const pave_cvd *cvd, pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !cvd || !out)
        return PAVE_ERR_ARGUMENT;
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    shape.width = cvd->width;
    shape.height = cvd->height;
    shape.type = PAVE_U32;
    shape.encoding = PAVE_DATA;
    shape.names = "label";
    return pave_image_create(context, &shape, cvd->labels, out);
}
