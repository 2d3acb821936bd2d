/* The generator: a BTF ray-cast from a periodic relief. */
#include "btf/scene.h"

#include "base/parallel.h"

#include <string.h>

static const pave_btf_synthesis_params default_params = PAVE_BTF_SYNTHESIS_PARAMS_INIT;

static const pv_param synthesis_rows[] = {
    { "class", PAVE_PARAM_CHOICE, "", 0, -1,
      "flat|minerals|sawn|polished|tile|grooved|brushed|concrete|cobble|asphalt|gravel", "kind of surface",
      offsetof(pave_btf_synthesis_params, class_of) },
    PV_INTEGER(pave_btf_synthesis_params, texels, "", 1, 4096, "texels a side"),
    PV_CHOICE(pave_btf_synthesis_params, directions, "ubo81|dome151", "directions of views and lights"),
    PV_SEED(pave_btf_synthesis_params, seed, "another seed, another material of the class"),
    PV_INTEGER(pave_btf_synthesis_params, samples, "", 1, 64, "rays for each texel and view"),
    PV_INTEGER(pave_btf_synthesis_params, bounces, "", 0, 16, "bounces of diffuse light between parts of the relief"),
    PV_INTEGER(pave_btf_synthesis_params, rays, "", 1, 1024, "rays for each point, to gather what bounces"),
    PV_FLAG(pave_btf_synthesis_params, shadows, "parts of the relief cast shadows"),
    PV_REAL(pave_btf_synthesis_params, relief, "", 0, 10, "heights are multiplied by this"),
    { "window", PAVE_PARAM_WINDOW, "texels", 0, 4096, NULL, "only this part of the material [the whole]",
      offsetof(pave_btf_synthesis_params, window) },
    PV_FLAG(pave_btf_synthesis_params, stored, "hold all samples in memory; otherwise they are made when read"),
};

const pv_table pv_btf_synthesis_table = PV_TABLE("BTF synthesis", default_params, synthesis_rows);

void pave_btf_synthesis_params_init(pave_btf_synthesis_params *params, size_t size)
{
    pv_params_init(&pv_btf_synthesis_table, params, size);
}

typedef struct storing {
    pave_btf *btf;
    float *values; /* a texel for each worker */
} storing;

static void store_texel(void *data, int32_t texel, int32_t worker)
{
    const storing *work = data;
    float *values = work->values + worker * pv_btf_length(work->btf);
    pv_scene_texel(work->btf->scene, texel, values);
    pv_btf_put(work->btf, texel, 0, pv_btf_length(work->btf), values);
}

static pave_result store_all(pave_context *context, pave_btf *btf, double from)
{
    storing work = { .btf = btf };
    pave_result result = pv_btf_allocate_samples(context, btf);
    if (!result)
        work.values = pv_allocate(context, (size_t)pv_workers(context), (size_t)pv_btf_length(btf) * sizeof(float),
                                  &result);
    if (!result)
        result = pv_parallel(context, (int32_t)pv_btf_texels(btf), store_texel, &work, from, 1);
    pv_release(work.values);
    pv_scene_free(&btf->scene);
    return result;
}

static pave_result make_frame(pave_context *context, const pave_btf_synthesis_params *params,
                              const pave_direction *directions, int32_t count, pave_btf **out)
{
    pave_btf_params shape = PAVE_BTF_PARAMS_INIT;
    const int32_t *window = params->window;
    shape.width = window[2] ? window[2] : params->texels;
    shape.height = window[2] ? window[3] : params->texels;
    shape.views = shape.lights = count;
    shape.view_directions = shape.light_directions = directions;
    return pv_btf_new(context, &shape, out);
}

static pave_result check_window(pave_context *context, const pave_btf_synthesis_params *params)
{
    const int32_t *w = params->window;
    if (!w[0] && !w[1] && !w[2] && !w[3])
        return PAVE_OK;
    if (w[2] && w[3] && w[0] + w[2] <= params->texels && w[1] + w[3] <= params->texels)
        return PAVE_OK;
    return pv_fail(context, PAVE_ERR_ARGUMENT, "window %d,%d,%d,%d has no texels or does not lie in the material of %d x "
                   "%d", (int)w[0], (int)w[1], (int)w[2], (int)w[3], (int)params->texels, (int)params->texels);
}

pave_result pave_btf_synthesize(pave_context *context, const pave_btf_synthesis_params *given, pave_btf **out)
{
    pave_btf_synthesis_params params;
    pave_direction directions[256];
    if (out)
        *out = NULL;
    if (!context || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_btf_synthesis_table, given, &params);
    if (!result)
        result = check_window(context, &params);
    if (result)
        return result;
    int32_t count = pave_directions(params.directions, directions, 256);
    double share = params.stored ? 0.2 : 1;
    pv_call call = pv_call_begin(context, "synthesize", 0, 1);
    result = make_frame(context, &params, directions, count, out);
    if (!result)
        result = pv_scene_create(context, &params, directions, count, share, &(*out)->scene);
    if (!result && params.stored)
        result = store_all(context, *out, share);
    pv_call_end(context, call);
    if (result)
        pave_btf_free(out);
    return result;
}
