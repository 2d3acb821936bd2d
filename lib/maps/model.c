/* Models: stones as closed solids that stand on their footprints, with pictures around them. */
#include "maps/model.h"

#include "image/image.h"
#include "util/fixed.h"

#include <math.h>
#include <string.h>

static const pave_model_params default_params = PAVE_MODEL_PARAMS_INIT;
static const pave_maps_input default_input = PAVE_MAPS_INPUT_INIT;

static const pv_param rows[] = {
    PV_REAL(pave_model_params, pixels_per_metre, "px", 0.001, 1000000, "px of the drawing to a metre"),
    PV_REAL(pave_model_params, thickness, "half sides", 0.01, 64, "of the stones, from their faces down"),
    PV_INTEGER(pave_model_params, segments, "", 0, PV_MOST_SEGMENTS, "of the rounding of an edge; 0: sharp edges"),
    PV_CHOICE(pave_model_params, skin, "maps|vertices", "colours from pictures, or one at each vertex"),
    PV_CHOICE(pave_model_params, ground, "no|yes", "a floor at the height of the joints"),
};

const pv_table pv_model_table = PV_TABLE("model", default_params, rows);

void pave_model_params_init(pave_model_params *params, size_t size)
{
    pv_params_init(&pv_model_table, params, size);
}

static void set_up(pv_modelling *m)
{
    const pv_bed *bed = m->bed;
    const pave_stones *s = bed->stones;
    int32_t n = m->params.segments, cosine, sine;
    m->middle[0] = s->x + s->width / 2.0;
    m->middle[1] = s->y + s->height / 2.0;
    m->bottom = -fmax(m->params.thickness * bed->half_side, bed->depth);
    m->cosine[0] = 1;
    for (int32_t k = 1; k < n; k++) {
        pv_turn(16384 * k / n, &cosine, &sine);
        m->cosine[k] = cosine / 65536.0;
        m->sine[k] = sine / 65536.0;
    }
    m->cosine[n] = n == 0;
    m->sine[n] = n > 0;
}

/* Around the window and all that hangs over it. */
static pave_result find_frame(pave_context *context, pv_modelling *m)
{
    const pave_stones *s = m->bed->stones;
    double box[4] = { s->x, s->y, (double)s->x + s->width, (double)s->y + s->height };
    for (int64_t i = 0; i < s->starts[s->count]; i++) {
        double x = s->vertices[2 * i], y = s->vertices[2 * i + 1];
        box[0] = x < box[0] ? x : box[0];
        box[1] = y < box[1] ? y : box[1];
        box[2] = x > box[2] ? x : box[2];
        box[3] = y > box[3] ? y : box[3];
    }
    if (m->params.skin == PAVE_SKIN_MAPS)
        return pv_frame_of(context, m->bed, box, &m->frame);
    for (int i = 0; i < 4; i++) /* no px are made */
        box[i] = pv_clamped(box[i] * m->bed->scale, -1e9, 1e9);
    m->frame = (pv_frame){ (int64_t)floor(box[0]), (int64_t)floor(box[1]),
                           (int32_t)(ceil(box[2]) - floor(box[0])), (int32_t)(ceil(box[3]) - floor(box[1])) };
    return PAVE_OK;
}

/* Where each stone's vertices and triangles go. */
static pave_result count(pave_context *context, pv_modelling *m)
{
    pave_model *model = m->model;
    pave_result result = PAVE_OK;
    model->stones = m->bed->count;
    model->starts = pv_allocate(context, (size_t)model->stones + 1, sizeof *model->starts, &result);
    for (int32_t s = 0; s < model->stones && !result; s++) {
        pv_footprint *o = &m->footprint[s];
        o->first_vertex = model->vertices;
        o->first_triangle = model->starts[s] = model->triangles;
        model->vertices += o->corners ? pv_prism_vertices(o->corners, o->segments) : 0;
        model->triangles += o->corners ? pv_prism_triangles(o->corners, o->segments) : 0;
    }
    if (result)
        return result;
    model->starts[model->stones] = model->triangles;
    model->vertices += m->params.ground ? 4 : 0;
    model->triangles += m->params.ground ? 2 : 0;
    if (model->vertices >= UINT32_MAX || model->triangles > UINT32_MAX / 3)
        return pv_fail(context, PAVE_ERR_LIMIT, "a model of %lld vertices is beyond the limit of 2^32 numbers",
                       (long long)model->vertices);
    return PAVE_OK;
}

static pave_result allocate(pave_context *context, const pv_modelling *m)
{
    pave_model *model = m->model;
    pave_result result = PAVE_OK;
    size_t n = (size_t)model->vertices, point = 3 * sizeof(float);
    model->position = pv_allocate(context, n, point, &result);
    if (!result)
        model->normal = pv_allocate(context, n, point, &result);
    if (!result && m->params.skin == PAVE_SKIN_MAPS)
        model->coordinate = pv_allocate(context, n, 2 * sizeof(float), &result);
    if (!result && m->params.skin == PAVE_SKIN_VERTICES)
        model->colour = pv_allocate(context, n, point, &result);
    if (!result)
        model->triangle = pv_allocate(context, (size_t)model->triangles, 3 * sizeof *model->triangle, &result);
    return result;
}

static pave_result build(pave_context *context, pv_modelling *m)
{
    int painted = m->params.skin == PAVE_SKIN_MAPS;
    pave_result result = find_frame(context, m);
    if (!result)
        result = pv_footprints_make(context, m);
    if (!result && painted)
        result = pv_skin_plan(context, m);
    if (!result)
        result = count(context, m);
    if (!result)
        result = allocate(context, m);
    if (!result)
        result = pv_prisms_build(context, m, 0.1, painted ? 0.3 : 1);
    if (!result && m->params.ground)
        pv_floor_build(m);
    return result || !painted ? result : pv_skin_paint(context, m, 0.3, 1);
}

static pave_result make(pave_context *context, const pave_maps_input *input, const pave_maps_params *maps,
                        const pave_model_params *params, pave_model *model)
{
    pv_bed bed;
    pv_modelling m = { .bed = &bed, .params = *params, .model = model };
    pave_result result = pv_bed_open(context, input, maps, &bed);
    if (!result) {
        bed.colour_type = PAVE_U8;
        model->roughness = maps->roughness;
        model->joint_roughness = maps->joint_roughness;
        set_up(&m);
        result = build(context, &m);
    }
    pv_release(m.footprint);
    pv_release(m.corner);
    pv_release(m.strip);
    pv_bed_close(&bed);
    return result;
}

pave_result pave_model_create(pave_context *context, const pave_maps_input *given_input,
                              const pave_maps_params *given_maps, const pave_model_params *given, pave_model **out)
{
    pave_maps_input input;
    pave_maps_params maps;
    pave_model_params params;
    if (out)
        *out = NULL;
    if (!context || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_maps_table, given_maps, &maps);
    if (!result)
        result = pv_params_read(context, &pv_model_table, given, &params);
    if (!result)
        result = pv_struct_read(context, "maps input", &default_input, sizeof input, given_input, &input);
    if (result)
        return result;
    pv_call outer = pv_call_begin(context, "model", 0, 1);
    *out = pv_allocate_zeroed(context, 1, sizeof **out, &result);
    if (!result)
        result = make(context, &input, &maps, &params, *out);
    if (result)
        pave_model_free(out);
    pv_call_end(context, outer);
    return result;
}

void pave_model_free(pave_model **model)
{
    if (!model || !*model)
        return;
    for (int i = 0; i < PAVE_SKIN_COUNT; i++)
        pave_image_free(&(*model)->picture[i]);
    pv_release((*model)->position);
    pv_release((*model)->normal);
    pv_release((*model)->coordinate);
    pv_release((*model)->colour);
    pv_release((*model)->triangle);
    pv_release((*model)->starts);
    pv_release(*model);
    *model = NULL;
}

int64_t pave_model_vertex_count(const pave_model *model) { return model->vertices; }
const float *pave_model_positions(const pave_model *model) { return model->position; }
const float *pave_model_normals(const pave_model *model) { return model->normal; }
const float *pave_model_coordinates(const pave_model *model) { return model->coordinate; }
const float *pave_model_colours(const pave_model *model) { return model->colour; }
int64_t pave_model_triangle_count(const pave_model *model) { return model->triangles; }
const uint32_t *pave_model_triangles(const pave_model *model) { return model->triangle; }
int32_t pave_model_stone_count(const pave_model *model) { return model->stones; }
const int64_t *pave_model_starts(const pave_model *model) { return model->starts; }

const pave_image *pave_model_picture(const pave_model *model, int32_t picture)
{
    return picture >= 0 && picture < PAVE_SKIN_COUNT ? model->picture[picture] : NULL;
}
