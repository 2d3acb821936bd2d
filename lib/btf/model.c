/* The model of a class of materials: made of some, and looked at. */
#include "btf/model.h"

#include <string.h>
#include <sys/mman.h>

static const pave_btf_model_params default_params = PAVE_BTF_MODEL_PARAMS_INIT;

static const pv_param model_rows[] = {
    PV_INTEGER(pave_btf_model_params, patch, "", 1, PV_MOST_PATCH, "side of a patch of texels, odd; 1: no patches"),
    PV_INTEGER(pave_btf_model_params, components, "", 1, PV_MOST_COMPONENTS, "eigen-ABTFs of a channel, at most"),
    PV_INTEGER(pave_btf_model_params, abrdfs, "", 1, PV_MOST_COMPONENTS, "eigen-ABRDFs of a channel, at most"),
    PV_INTEGER(pave_btf_model_params, material, "", 1, 4096, "components kept of each material; half for colour"),
    PV_INTEGER(pave_btf_model_params, stride, "", 0, 64, "texels from patch to patch; 0: none overlap"),
    PV_CHOICE(pave_btf_model_params, colour, "auto|log-yuv|log|plain", "what the model is about"),
    PV_REAL(pave_btf_model_params, epsilon, "", 1e-9, 1, "added before a logarithm; white is 0.318"),
    PV_FLAG(pave_btf_model_params, symmetric, "mirrored and turned materials belong to the class too"),
    PV_FLAG(pave_btf_model_params, validate, "hold three materials out in turn, to see how best to reconstruct"),
    PV_INTEGER(pave_btf_model_params, passes, "", 1, 16, "passes over each material"),
};

const pv_table pv_btf_model_table = PV_TABLE("BTF model", default_params, model_rows);

void pave_btf_model_params_init(pave_btf_model_params *params, size_t size)
{
    pv_params_init(&pv_btf_model_table, params, size);
}

void pv_model_drop_bases(pave_btf_model *model)
{
    for (int32_t c = 0; c < model->planes; c++)
        for (int32_t of = 0; of < 2; of++) {
            pv_release(model->basis[c][of].left);
            pv_release(model->basis[c][of].deviation);
            memset(&model->basis[c][of], 0, sizeof model->basis[c][of]);
        }
}

pave_result pv_model_new(pave_context *context, int32_t planes, const pave_direction *views, int32_t view_count,
                         const pave_direction *lights, int32_t light_count, pave_btf_model **out)
{
    pave_result result = PAVE_OK;
    pave_btf_model *model = *out = pv_allocate_zeroed(context, 1, sizeof **out, &result);
    size_t each = (size_t)planes;
    if (result)
        return result;
    model->planes = planes;
    result = pv_directions_create(context, "view", views, view_count, &model->views);
    if (!result)
        result = pv_directions_create(context, "light", lights, light_count, &model->lights);
    if (!result)
        model->range = pv_allocate_zeroed(context, each, sizeof *model->range, &result);
    if (!result)
        model->basis = pv_allocate_zeroed(context, each, sizeof *model->basis, &result);
    if (!result)
        model->rung = pv_allocate_zeroed(context, each, sizeof *model->rung, &result);
    if (!result)
        model->mean = pv_allocate(context, (size_t)pv_model_pairs(model), each * sizeof *model->mean, &result);
    if (result)
        pave_btf_model_free(out);
    return result;
}

void pave_btf_model_free(pave_btf_model **model)
{
    if (!model || !*model)
        return;
    pave_btf_model *m = *model;
    if (m->map)
        munmap(m->map, m->map_bytes);
    else if (m->basis)
        pv_model_drop_bases(m);
    pv_release(m->basis);
    pv_release(m->range);
    pv_release(m->rung);
    pv_release(m->mean);
    pv_directions_free(&m->views);
    pv_directions_free(&m->lights);
    pv_release(m);
    *model = NULL;
}

static int same_directions(const pv_directions *a, const pv_directions *b)
{
    for (int32_t i = 0; i < a->count && a->count == b->count; i++)
        if (pv_direction_distance(a->direction[i], b->direction[i]) > 1e-3)
            return 0;
    return a->count == b->count;
}

static pave_result check(pave_context *context, const pave_btf *const *btfs, int32_t count,
                         const pave_btf_model_params *params)
{
    const pave_btf *first = btfs[0];
    if (params->patch % 2 == 0)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a patch has an odd side, not %d", (int)params->patch);
    for (int32_t i = 0; i < count; i++) {
        const pave_btf *b = btfs[i];
        if (!b)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "material %d is missing", (int)i);
        if (b->channels != first->channels || b->cosine != first->cosine ||
            !same_directions(&b->views, &first->views) || !same_directions(&b->lights, &first->lights))
            return pv_fail(context, PAVE_ERR_ARGUMENT,
                           "materials 0 and %d differ in channels (%d and %d), directions (%d x %d and %d x %d, or "
                           "where they are) or the cosine", (int)i, (int)first->channels, (int)b->channels,
                           (int)first->views.count, (int)first->lights.count, (int)b->views.count,
                           (int)b->lights.count);
        for (int64_t p = 0; p < (int64_t)b->views.count * b->lights.count && b->missing; p++)
            if (b->missing[p])
                return pv_fail(context, PAVE_ERR_ARGUMENT, "material %d lacks pairs of view and light: a model is made "
                               "of complete ones", (int)i);
        if (b->width < params->patch || b->height < params->patch)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "material %d has %d x %d texels, fewer than a patch of %d",
                           (int)i, (int)b->width, (int)b->height, (int)params->patch);
    }
    return PAVE_OK;
}

static pave_result make_frame(pave_context *context, const pave_btf *btf, const pave_btf_model_params *params,
                              pave_btf_model **out)
{
    int32_t colour;
    pave_result result = pv_colour_choose(context, params->colour, btf->channels, 0, &colour);
    if (!result)
        result = pv_model_new(context, btf->channels, btf->views.direction, btf->views.count, btf->lights.direction,
                              btf->lights.count, out);
    if (result)
        return result;
    pave_btf_model *model = *out;
    model->channels = btf->channels;
    model->colour = colour;
    model->cosine = btf->cosine;
    model->patch = params->patch;
    model->least = (float)params->epsilon;
    memcpy(model->names, btf->names, sizeof model->names);
    pv_model_set_mean(model);
    return PAVE_OK;
}

pave_result pv_model_frame(pave_context *context, const pave_btf *const *btfs, int32_t count,
                           const pave_btf_model_params *given, pave_btf_model **out)
{
    pave_btf_model_params params;
    pave_result result = pv_params_read(context, &pv_btf_model_table, given, &params);
    if (!result)
        result = check(context, btfs, count, &params);
    return result ? result : make_frame(context, btfs[0], &params, out);
}

pave_result pave_btf_model_create(pave_context *context, const pave_btf *const *btfs, int32_t count,
                                  const pave_btf_model_params *given, pave_btf_model **out)
{
    pave_btf_model_params params;
    if (out)
        *out = NULL;
    if (!context || !btfs || count < 1 || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_btf_model_table, given, &params);
    if (!result)
        result = pv_model_frame(context, btfs, count, &params, out);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "model", 0, 1);
    result = pv_model_fit(context, btfs, count, &params, *out);
    pv_call_end(context, call);
    if (result)
        pave_btf_model_free(out);
    return result;
}

int32_t pave_btf_model_materials(const pave_btf_model *model) { return model->materials; }
int32_t pave_btf_model_patch(const pave_btf_model *model) { return model->patch; }
int32_t pave_btf_model_channels(const pave_btf_model *model) { return model->channels; }
int32_t pave_btf_model_views(const pave_btf_model *model) { return model->views.count; }
int32_t pave_btf_model_lights(const pave_btf_model *model) { return model->lights.count; }
int32_t pave_btf_model_copies(const pave_btf_model *model) { return model->symmetry; }

static const pv_basis *find_basis(const pave_btf_model *model, int32_t channel, int32_t of_patches)
{
    return channel < 0 || channel >= model->planes ? NULL : &model->basis[channel][of_patches != 0];
}

int32_t pave_btf_model_components(const pave_btf_model *model, int32_t channel, int32_t of_patches)
{
    const pv_basis *basis = find_basis(model, channel, of_patches);
    return basis ? basis->components : 0;
}

const float *pave_btf_model_deviations(const pave_btf_model *model, int32_t channel, int32_t of_patches)
{
    const pv_basis *basis = find_basis(model, channel, of_patches);
    return basis ? basis->deviation : NULL;
}

void pave_btf_model_vector(const pave_btf_model *model, int32_t channel, int32_t of_patches, int32_t index, float *out)
{
    const pv_basis *basis = find_basis(model, channel, of_patches);
    for (int64_t r = 0; basis && r < pv_basis_rows(model, of_patches != 0); r++)
        out[r] = index >= 0 && index < basis->components ? basis->left[r * basis->components + index] : 0;
}
