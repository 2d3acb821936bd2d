/* A whole BTF from some of its samples: what was measured, what the bases make of it, every texel from its patches. */
#include "btf/rebuild.h"

#include "image/image.h"

#include <string.h>

static const pave_btf_reconstruct_params default_params = PAVE_BTF_RECONSTRUCT_PARAMS_INIT;

static const pv_param reconstruct_rows[] = {
    PV_CHOICE(pave_btf_reconstruct_params, mode, "best|paper|project",
              "with the prior, by the pseudo-inverse, or a complete BTF onto the basis"),
    PV_CHOICE(pave_btf_reconstruct_params, basis, "both|abrdf|abtf", "what is reconstructed with"),
    PV_INTEGER(pave_btf_reconstruct_params, components, "", 0, PV_MOST_COMPONENTS, "eigen-ABTFs of a channel; 0: all"),
    PV_INTEGER(pave_btf_reconstruct_params, abrdfs, "", 0, PV_MOST_COMPONENTS, "eigen-ABRDFs of a channel; 0: all"),
    PV_INTEGER(pave_btf_reconstruct_params, samples, "", 0, INT32_MAX, "of the plan, the first; 0: all"),
    PV_REAL(pave_btf_reconstruct_params, cut, "", 0, 1, "paper: singular values below this share do not count"),
    PV_REAL(pave_btf_reconstruct_params, noise, "", 0, 100, "best: standard deviation of measured logarithms"),
    { "type", PAVE_PARAM_INTEGER, "", PAVE_F16, PAVE_F32, NULL, "4: halves, 5: floats, in the file",
      offsetof(pave_btf_reconstruct_params, type) },
};

const pv_table pv_btf_reconstruct_table = PV_TABLE("BTF reconstruction", default_params, reconstruct_rows);

void pave_btf_reconstruct_params_init(pave_btf_reconstruct_params *params, size_t size)
{
    pv_params_init(&pv_btf_reconstruct_table, params, size);
}

static pave_result check(const pv_rebuild *r)
{
    const pave_btf *s = r->sparse;
    const pave_btf_model *m = r->model;
    if (s->channels != m->channels)
        return pv_fail(r->context, PAVE_ERR_ARGUMENT, "the model is of another colour model: it has %d channels, the "
                       "BTF %d", (int)m->channels, (int)s->channels);
    if (s->cosine != m->cosine)
        return pv_fail(r->context, PAVE_ERR_ARGUMENT, "the samples of %s hold the cosine of the light, those of the "
                       "other do not", m->cosine ? "the model" : "the BTF");
    if (s->width < m->patch || s->height < m->patch)
        return pv_fail(r->context, PAVE_ERR_ARGUMENT, "%d x %d texels are fewer than a patch of %d", (int)s->width,
                       (int)s->height, (int)m->patch);
    return PAVE_OK;
}

static pave_result make_frame(pv_rebuild *r, pave_btf **out)
{
    pave_btf_params shape = PAVE_BTF_PARAMS_INIT;
    const pave_btf_model *m = r->model;
    shape.width = r->sparse->width;
    shape.height = r->sparse->height;
    shape.channels = m->channels;
    shape.type = r->params->type;
    shape.views = m->views.count;
    shape.lights = m->lights.count;
    shape.view_directions = m->views.direction;
    shape.light_directions = m->lights.direction;
    shape.cosine = m->cosine;
    shape.pixels_per_mm = r->sparse->pixels_per_mm;
    pave_result result = pv_btf_new(r->context, &shape, out);
    if (!result)
        memcpy((*out)->names, r->sparse->names, sizeof (*out)->names);
    if (!result)
        result = pv_btf_allocate_samples(r->context, *out);
    r->out = *out;
    return result;
}

static pave_result make_errors(const pv_rebuild *r, pave_image **errors)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    if (r->params->mode != PAVE_BTF_BEST)
        return pv_fail(r->context, PAVE_ERR_ARGUMENT, "errors can be expected in mode best only, by the model's prior");
    shape.width = r->sparse->width;
    shape.height = r->sparse->height;
    shape.channels = 1;
    shape.type = PAVE_F32;
    shape.encoding = PAVE_LINEAR;
    return pv_image_new(r->context, &shape, errors);
}

static void close_rebuild(pv_rebuild *r)
{
    for (int32_t c = 0; c < PV_BTF_CHANNELS; c++) {
        pv_release(r->measured[c]);
        for (int32_t of = 0; of < 2; of++) {
            pv_system_close(&r->part[c][of].system);
            pv_release(r->part[c][of].coefficients);
        }
    }
    pv_release(r->pair);
    pv_release(r->given);
    pv_release(r->bad);
    pv_release(r->tile);
}

static pave_result run(pv_rebuild *r, const pave_btf_plan *plan, pave_btf **out, pave_image **errors)
{
    pave_result result = check(r);
    if (!result && r->params->samples && !plan)
        result = pv_fail(r->context, PAVE_ERR_ARGUMENT, "the first %d samples of a plan are asked for, and there is "
                         "none", (int)r->params->samples);
    if (!result && errors)
        result = make_errors(r, errors);
    if (!result)
        result = make_frame(r, out);
    if (!result)
        result = pv_rebuild_measure(r, plan);
    if (!result)
        result = pv_rebuild_solve(r, errors ? (*errors)->pixels : NULL);
    return result ? result : pv_rebuild_blend_all(r);
}

pave_result pave_btf_reconstruct(pave_context *context, const pave_btf_model *model, const pave_btf *sparse,
                                 const pave_btf_plan *plan, const pave_btf_reconstruct_params *given, pave_btf **out,
                                 pave_image **errors)
{
    pave_btf_reconstruct_params params;
    pv_rebuild r = { .context = context, .model = model, .sparse = sparse, .params = &params };
    if (out)
        *out = NULL;
    if (errors)
        *errors = NULL;
    if (!context || !model || !sparse || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_btf_reconstruct_table, given, &params);
    if (!result)
        result = pv_algebra_open(context, &r.algebra);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "reconstruct", 0, 1);
    result = run(&r, plan, out, errors);
    close_rebuild(&r);
    pv_algebra_close(&r.algebra);
    pv_call_end(context, call);
    if (result) {
        pave_btf_free(out);
        if (errors)
            pave_image_free(errors);
    }
    return result;
}
