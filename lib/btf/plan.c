/* Plans of measurements: which pairs of view and light, and in which order. */
#include "btf/model.h"

#include <math.h>
#include <string.h>

static const pave_btf_plan_params default_params = PAVE_BTF_PLAN_PARAMS_INIT;

static const pv_param plan_rows[] = {
    PV_CHOICE(pave_btf_plan_params, method, "greedy|swap|parabolic", "how pairs are chosen"),
    PV_INTEGER(pave_btf_plan_params, samples, "", 1, 1 << 24, "pairs of view and light"),
    PV_INTEGER(pave_btf_plan_params, abrdfs, "", 0, PV_MOST_COMPONENTS, "swap: eigen-ABRDFs to be found; 0: all"),
    PV_FLAG(pave_btf_plan_params, patches, "swap: the condition is that of the ABTFs"),
    PV_INTEGER(pave_btf_plan_params, components, "", 0, PV_MOST_COMPONENTS, "swap: eigen-ABTFs to be found; 0: all"),
    PV_INTEGER(pave_btf_plan_params, steps, "", 0, 1 << 24, "swap: tries"),
    PV_SEED(pave_btf_plan_params, seed, "swap: of chance"),
    PV_FLAG(pave_btf_plan_params, dome, "greedy: whole views times lights, as a dome takes them"),
    PV_REAL(pave_btf_plan_params, shot_cost, "", 0, 1e6, "dome: what a lamp costs besides its pictures, in pictures"),
    PV_REAL(pave_btf_plan_params, noise, "", 0, 100, "greedy: standard deviation of a value; 0: as the model found"),
};

const pv_table pv_btf_plan_table = PV_TABLE("BTF plan", default_params, plan_rows);

void pave_btf_plan_params_init(pave_btf_plan_params *params, size_t size)
{
    pv_params_init(&pv_btf_plan_table, params, size);
}

pave_result pv_plan_new(pave_context *context, const pv_directions *views, const pv_directions *lights,
                        const int32_t *pairs, int32_t count, pave_btf_plan **out)
{
    pave_result result = PAVE_OK;
    size_t places = (size_t)count;
    pave_btf_plan *plan = *out = pv_allocate_zeroed(context, 1, sizeof **out, &result);
    if (!result)
        plan->view = pv_allocate(context, places, sizeof *plan->view, &result);
    if (!result)
        plan->light = pv_allocate(context, places, sizeof *plan->light, &result);
    if (!result)
        plan->expected = pv_allocate_zeroed(context, places, sizeof *plan->expected, &result);
    if (!result)
        plan->from = pv_allocate(context, places, sizeof *plan->from, &result);
    if (!result)
        plan->to = pv_allocate(context, places, sizeof *plan->to, &result);
    if (result) {
        pave_btf_plan_free(out);
        return result;
    }
    plan->count = count;
    for (int32_t i = 0; i < count; i++) {
        plan->view[i] = pairs[i] / lights->count;
        plan->light[i] = pairs[i] % lights->count;
        plan->from[i] = views->direction[plan->view[i]];
        plan->to[i] = lights->direction[plan->light[i]];
    }
    return PAVE_OK;
}

pave_result pv_plan_mark(pave_context *context, const pave_btf_plan *plan, int32_t samples, const char *holder,
                         int32_t views, int32_t lights, uint8_t *wanted)
{
    int32_t count = samples ? samples : plan->count;
    if (count > plan->count)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%d samples of a plan that has %d", (int)count, (int)plan->count);
    for (int32_t i = 0; i < count; i++) {
        if (plan->view[i] >= views || plan->light[i] >= lights)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "the plan is of more directions than %s", holder);
        wanted[(int64_t)plan->view[i] * lights + plan->light[i]] = 1;
    }
    return PAVE_OK;
}

/* The first that is no pair of the BTF's, or was there before; `count` if all are fine. */
static int32_t first_wrong(const pave_btf *btf, const int32_t *views, const int32_t *lights, int32_t count,
                           uint8_t *taken, int32_t *pairs)
{
    for (int32_t i = 0; i < count; i++) {
        if (views[i] < 0 || views[i] >= btf->views.count || lights[i] < 0 || lights[i] >= btf->lights.count)
            return i;
        pairs[i] = views[i] * btf->lights.count + lights[i];
        if (taken[pairs[i]]++)
            return i;
    }
    return count;
}

pave_result pave_btf_plan_of_pairs(pave_context *context, const pave_btf *btf, const int32_t *views,
                                   const int32_t *lights, int32_t count, pave_btf_plan **out)
{
    if (out)
        *out = NULL;
    if (!context || !btf || !views || !lights || count < 1 || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = PAVE_OK;
    int32_t *pairs = pv_allocate(context, (size_t)count, sizeof *pairs, &result), wrong = count;
    uint8_t *taken = result ? NULL : pv_allocate_zeroed(context, (size_t)btf->views.count, (size_t)btf->lights.count,
                                                        &result);
    if (!result)
        wrong = first_wrong(btf, views, lights, count, taken, pairs);
    if (!result && wrong < count)
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "pair %d, of view %d and light %d, is none of the BTF's or comes "
                         "for the second time", (int)wrong, (int)views[wrong], (int)lights[wrong]);
    if (!result)
        result = pv_plan_new(context, &btf->views, &btf->lights, pairs, count, out);
    pv_release(pairs);
    pv_release(taken);
    return result;
}

void pave_btf_plan_free(pave_btf_plan **plan)
{
    if (!plan || !*plan)
        return;
    pv_release((*plan)->view);
    pv_release((*plan)->light);
    pv_release((*plan)->expected);
    pv_release((*plan)->from);
    pv_release((*plan)->to);
    pv_release(*plan);
    *plan = NULL;
}

int32_t pave_btf_plan_samples(const pave_btf_plan *plan) { return plan->count; }
const int32_t *pave_btf_plan_views(const pave_btf_plan *plan) { return plan->view; }
const int32_t *pave_btf_plan_lights(const pave_btf_plan *plan) { return plan->light; }
const double *pave_btf_plan_expected(const pave_btf_plan *plan) { return plan->expected; }

void pave_btf_plan_condition(const pave_btf_plan *plan, double *before, double *after)
{
    *before = plan->before;
    *after = plan->after;
}

/* ---- The parabolic map ---- */

/* Cells of a map of so many across whose centres lie in the disc. */
static int32_t cells_in_disc(int32_t across, pave_direction *out)
{
    int32_t count = 0;
    for (int32_t i = 0; i < across * across; i++) {
        double x = (2.0 * (i % across) + 1) / across - 1, y = (2.0 * (i / across) + 1) / across - 1;
        double square = x * x + y * y, vector[3] = { 2 * x, 2 * y, 1 - square };
        if (square > 1)
            continue;
        if (out) {
            double length = 1 + square;
            vector[0] /= length, vector[1] /= length, vector[2] /= length;
            out[count] = pv_vector_direction(vector);
        }
        count++;
    }
    return count;
}

/* The directions that are nearest to the cells', each once. */
static int32_t map_to(const pv_directions *directions, const pave_direction *cells, int32_t count, int32_t *out)
{
    int32_t found = 0;
    double away;
    for (int32_t i = 0; i < count; i++) {
        int32_t nearest = pv_directions_nearest(directions, cells[i], &away), twice = 0;
        for (int32_t k = 0; k < found; k++)
            twice |= out[k] == nearest;
        if (!twice)
            out[found++] = nearest;
    }
    return found;
}

enum { MOST_ACROSS = 64 };

static pave_result plan_map(pave_context *context, const pave_btf_model *model, const pave_btf_plan_params *params,
                            int32_t *pairs, int32_t *count)
{
    int32_t across = 1;
    while (across < MOST_ACROSS) {
        int64_t next = cells_in_disc(across + 1, NULL);
        if (next * next > params->samples)
            break;
        across++;
    }
    pave_result result = PAVE_OK;
    size_t cells = (size_t)cells_in_disc(across, NULL);
    pave_direction *map = pv_allocate(context, cells, sizeof *map, &result);
    int32_t *view = result ? NULL : pv_allocate(context, cells, 2 * sizeof *view, &result);
    if (!result) {
        int32_t *light = view + cells, all = cells_in_disc(across, map);
        int32_t views = map_to(&model->views, map, all, view), lights = map_to(&model->lights, map, all, light);
        *count = views * lights;
        for (int32_t i = 0; i < *count; i++)
            pairs[i] = view[i / lights] * model->lights.count + light[i % lights];
        pv_note(context, PAVE_MESSAGE_INFO, "a map of %d x %d cells has %d directions in its disc, which are %d "
                "views and %d lights: %d pairs", (int)across, (int)across, (int)all, (int)views, (int)lights,
                (int)*count);
    }
    pv_release(map);
    pv_release(view);
    return result;
}

/* ---- The story ---- */

/* The same for every number of samples, so that a plan begins as a shorter one does. */
static double noise_of(const pave_btf_model *model, const pave_btf_plan_params *params)
{
    double most = model->rungs ? model->rung[0][model->rungs - 1].samples : 1;
    return params->noise > 0 ? params->noise * params->noise : pv_model_settings(model, 0, most).noise[0];
}

/* The root mean square of what is left, for each number of samples. */
static void expect(const pave_btf_model *model, const double *left, pave_btf_plan *plan)
{
    for (int32_t i = 0; i < plan->count; i++)
        plan->expected[i] = sqrt(left[i] / (double)pv_model_pairs(model) + model->basis[0][PV_OF_TEXELS].outside);
}

static pave_result choose(pave_context *context, const pave_btf_model *model, const pave_btf_plan_params *params,
                          int32_t *pairs, double *left, int32_t *count, double condition[2])
{
    double noise = noise_of(model, params);
    switch (params->method) {
    case PAVE_BTF_PLAN_SWAP: return pv_plan_swap(context, model, params, pairs, &condition[0], &condition[1]);
    case PAVE_BTF_PLAN_PARABOLIC: return plan_map(context, model, params, pairs, count);
    default:
        return params->dome ? pv_plan_dome(context, model, noise, params->shot_cost, pairs, left, count)
                            : pv_plan_greedy(context, model, noise, *count, pairs, left);
    }
}

pave_result pave_btf_plan_create(pave_context *context, const pave_btf_model *model, const pave_btf_plan_params *given,
                                 pave_btf_plan **out)
{
    pave_btf_plan_params params;
    double *left = NULL, condition[2] = { 0, 0 };
    if (out)
        *out = NULL;
    if (!context || !model || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_btf_plan_table, given, &params);
    if (!result && params.samples > pv_model_pairs(model))
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "%d samples of a model that has %lld pairs of view and light",
                         (int)params.samples, (long long)pv_model_pairs(model));
    if (result)
        return result;
    int32_t count = params.samples;
    int32_t *pairs = pv_allocate(context, (size_t)count, sizeof *pairs, &result);
    if (!result)
        left = pv_allocate(context, (size_t)count, sizeof *left, &result);
    pv_call call = pv_call_begin(context, "plan", 0, 1);
    if (!result)
        result = choose(context, model, &params, pairs, left, &count, condition);
    if (!result)
        result = pv_plan_new(context, &model->views, &model->lights, pairs, count, out);
    if (!result && params.method == PAVE_BTF_PLAN_GREEDY)
        expect(model, left, *out);
    if (!result) {
        (*out)->before = condition[0];
        (*out)->after = condition[1];
    }
    pv_call_end(context, call);
    pv_release(pairs);
    pv_release(left);
    return result;
}
