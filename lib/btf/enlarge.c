/* A whole BTF from one of a small region and a few photographs: the sample's eigen-ABRDFs, what the photographs show,
 * and from both the coefficients of every texel (Steinhausen et al. 2014, Algorithm 1, and what does better). */
#include "btf/enlarge.h"

#include "image/image.h"

#include <math.h>
#include <string.h>

static const pave_btf_enlarge_params default_params = PAVE_BTF_ENLARGE_PARAMS_INIT;

static const pv_param enlarge_rows[] = {
    PV_CHOICE(pave_btf_enlarge_params, mode, "best|paper", "regression, or Algorithm 1"),
    PV_CHOICE(pave_btf_enlarge_params, aim, "error|look", "best: the least error, or the sharpness of the material"),
    PV_INTEGER(pave_btf_enlarge_params, stage, "", 1, 3,
               "paper: Texture Optimization alone, then statistics once, or all to the end"),
    PV_INTEGER(pave_btf_enlarge_params, components, "", 1, 1024, "of the sample's luminance, or of each channel"),
    PV_INTEGER(pave_btf_enlarge_params, chroma, "", 0, 1024, "of U/Y and V/Y each; 0: half as many"),
    PV_CHOICE(pave_btf_enlarge_params, colour, "auto|log-yuv|log|plain", "what is factored"),
    PV_REAL(pave_btf_enlarge_params, epsilon, "", 1e-9, 1, "darker samples count as this; white is 0.318"),
    PV_INTEGER(pave_btf_enlarge_params, neighbourhood, "texels", 2, 32, "side of a window of Texture Optimization"),
    PV_INTEGER(pave_btf_enlarge_params, levels, "", 1, 4, "paper: levels, each half as fine as the one before"),
    PV_REAL(pave_btf_enlarge_params, balance, "", 1e-3, 1e3, "paper: weight of the photographs over the texture's"),
    PV_REAL(pave_btf_enlarge_params, share, "", 0, 1, "paper: alpha / (alpha + beta) of Eq. 4"),
    PV_INTEGER(pave_btf_enlarge_params, samples, "", 0, INT32_MAX, "of a plan, the first; 0: all"),
    PV_INTEGER(pave_btf_enlarge_params, x, "texels", -1, 1 << 20, "where the sample lies in the whole; -1: not in it"),
    PV_INTEGER(pave_btf_enlarge_params, y, "texels", -1, 1 << 20, "alike, from the top"),
    PV_INTEGER(pave_btf_enlarge_params, passes, "", 1, 16, "over the sample, to factor it"),
    PV_FLAG(pave_btf_enlarge_params, symmetric, "best: learn from turned and mirrored copies of the sample, too"),
    { "type", PAVE_PARAM_INTEGER, "", PAVE_F16, PAVE_F32, NULL, "4: halves, 5: floats, in the file",
      offsetof(pave_btf_enlarge_params, type) },
};

const pv_table pv_btf_enlarge_table = PV_TABLE("BTF enlargement", default_params, enlarge_rows);

void pave_btf_enlarge_params_init(pave_btf_enlarge_params *params, size_t size)
{
    pv_params_init(&pv_btf_enlarge_table, params, size);
}

/* ---- What is given ---- */

enum { LEAST_SIDE = 16 };

static pave_result check_sample(const pv_enlarge *e)
{
    const pave_btf *s = e->sample;
    int32_t windows = 2 * e->params->neighbourhood, least = windows > LEAST_SIDE ? windows : LEAST_SIDE;
    if (s->width < least || s->height < least)
        return pv_fail(e->context, PAVE_ERR_ARGUMENT, "the sample has %d x %d texels: too few, for %d x %d are needed",
                       (int)s->width, (int)s->height, (int)least, (int)least);
    for (int64_t p = 0; p < (int64_t)s->views.count * s->lights.count && s->missing; p++)
        if (s->missing[p])
            return pv_fail(e->context, PAVE_ERR_ARGUMENT, "the sample lacks pairs of view and light: it must be "
                           "complete");
    return PAVE_OK;
}

static pave_result check(const pv_enlarge *e)
{
    const pave_btf *s = e->sample, *p = e->photos;
    if (!p && !e->mean)
        return pv_fail(e->context, PAVE_ERR_ARGUMENT, "there is not one photograph");
    if (p && (p->channels != s->channels || p->cosine != s->cosine))
        return pv_fail(e->context, PAVE_ERR_ARGUMENT, "sample and photographs differ in channels (%d and %d) or in the "
                       "cosine", (int)s->channels, (int)p->channels);
    if (e->mean && e->mean->channels != s->channels)
        return pv_fail(e->context, PAVE_ERR_ARGUMENT, "the picture under even light has %d channels, and the sample %d",
                       (int)e->mean->channels, (int)s->channels);
    int32_t width = p ? p->width : e->mean->width, height = p ? p->height : e->mean->height;
    if ((e->params->x < 0) != (e->params->y < 0) ||
        (e->params->x >= 0 && (e->params->x + s->width > width || e->params->y + s->height > height)))
        return pv_fail(e->context, PAVE_ERR_ARGUMENT, "a sample of %d x %d texels at %d,%d does not lie in a whole of "
                       "%d x %d", (int)s->width, (int)s->height, (int)e->params->x, (int)e->params->y, (int)width,
                       (int)height);
    return check_sample(e);
}

static pave_result make_frame(pv_enlarge *e, pave_btf **out)
{
    pave_result result = pv_btf_copy_frame(e->context, e->sample, out);
    if (result)
        return result;
    e->out = *out;
    pv_release(e->out->missing);
    e->out->missing = NULL;
    e->out->width = e->photos ? e->photos->width : e->mean->width;
    e->out->height = e->photos ? e->photos->height : e->mean->height;
    e->out->factor_type = e->params->type;
    e->planes = e->sample->channels;
    result = pv_check_size(e->context, "the whole", e->out->width, e->out->height);
    return result ? result : pv_colour_choose(e->context, e->params->colour, e->sample->channels, 0, &e->out->colour);
}

/* ---- Paper ---- */

enum { MOST_TURNS = 5, STATISTICS_ROUNDS = 10 };

static const double still = 1e-3; /* relative change that ends Algorithm 1 */

static void to_planes(const pv_texels *t, float *planes)
{
    int64_t count = pv_texels_count(t);
    for (int64_t i = 0; i < count * t->channels; i++)
        planes[i % t->channels * count + i / t->channels] = t->values[i];
}

static void from_planes(const float *planes, const pv_texels *t, float *values)
{
    int64_t count = pv_texels_count(t);
    for (int64_t i = 0; i < count * t->channels; i++)
        values[i] = planes[i % t->channels * count + i / t->channels];
}

static double change(const float *a, const float *b, int64_t count)
{
    double apart = 0, whole = 0;
    for (int64_t i = 0; i < count; i++) {
        apart += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
        whole += (double)b[i] * (double)b[i];
    }
    return whole > 0 ? sqrt(apart / whole) : 0;
}

/* Statistics are imposed, and photographs forced on what lies between before and after, until little changes. */
static pave_result alternate(pv_enlarge *e, const pv_statistics *wanted, float *room, double from)
{
    int64_t count = pv_texels_count(&e->made) * e->coefficients;
    float *after = room, *planes = room + count;
    pave_result result = PAVE_OK;
    for (int32_t turn = 0; turn < MOST_TURNS && !result; turn++) {
        double begin = from + (1 - from) * turn / MOST_TURNS, end = from + (1 - from) * (turn + 1) / MOST_TURNS;
        to_planes(&e->made, planes);
        result = pv_statistics_impose(e->context, wanted, e->made.width, e->made.height, planes, STATISTICS_ROUNDS,
                                      begin, end);
        if (result)
            break;
        from_planes(planes, &e->made, after);
        e->rounds++;
        if (e->params->stage < 3) {
            memcpy(e->made.values, after, (size_t)count * sizeof *after);
            break;
        }
        result = pv_enlarge_force(e, e->made.values, after, e->params->share, planes);
        double changed = change(planes, e->made.values, count);
        memcpy(e->made.values, planes, (size_t)count * sizeof *planes);
        if (changed < still)
            break;
    }
    return result;
}

static pave_result as_in_the_paper(pv_enlarge *e)
{
    pv_statistics *wanted = NULL;
    float *room = NULL;
    double share = e->params->stage == 1 ? 0.95 : 0.5;
    pave_result result = pv_enlarge_optimize(e, e->params->levels, e->params->balance, 0.2, share);
    if (e->params->stage == 1 || result)
        return result;
    room = pv_allocate(e->context, 2 * (size_t)pv_texels_count(&e->made), (size_t)e->coefficients * sizeof *room,
                       &result);
    if (!result)
        result = pv_enlarge_statistics(e, &e->known, e->coefficients, &wanted);
    if (!result)
        result = alternate(e, wanted, room, share);
    pv_statistics_free(wanted);
    pv_release(room);
    return result;
}

/* ---- Best ---- */

/* What was measured is known. */
static void paste_sample(pv_enlarge *e)
{
    size_t bytes = (size_t)e->known.width * (size_t)e->coefficients * sizeof(float);
    for (int64_t y = 0; y < e->known.height && e->params->x >= 0; y++)
        memcpy(e->made.values + ((y + e->params->y) * e->made.width + e->params->x) * e->coefficients,
               e->known.values + y * e->known.width * e->coefficients, bytes);
}

static pave_result as_well_as_possible(pv_enlarge *e)
{
    pave_result result = pv_enlarge_mix(e);
    if (!result && e->params->aim == PAVE_BTF_AIM_LOOK)
        result = pv_enlarge_sharpen(e);
    if (!result && e->left > 0.8)
        pv_note(e->context, PAVE_MESSAGE_WARNING, "the photographs explain %.0f %% of what the sample varies by; a "
                "plan made from the sample says which would tell more", 100 * (1 - e->left));
    if (!result)
        paste_sample(e);
    return result;
}

/* ---- The whole ---- */

static pave_result fill_factors(pv_enlarge *e)
{
    pave_result result = PAVE_OK;
    for (int32_t c = 0; c < e->planes && !result; c++) {
        pv_factors *f = &e->out->factors[c];
        f->right = pv_allocate(e->context, (size_t)pv_texels_count(&e->made), (size_t)f->components * sizeof *f->right,
                               &result);
        for (int64_t t = 0; t < pv_texels_count(&e->made) && !result; t++)
            memcpy(f->right + t * f->components, e->made.values + t * e->coefficients + e->first[c],
                   (size_t)f->components * sizeof(float));
    }
    return result;
}

static pave_result run(pv_enlarge *e, pave_btf **out, pave_btf_enlargement *report)
{
    pave_result result = check(e);
    if (!result)
        result = make_frame(e, out);
    pv_call call = pv_call_begin(e->context, "factor", 0, 0.2);
    if (!result)
        result = pv_enlarge_factor(e);
    pv_call_end(e->context, call);
    if (!result)
        result = pv_enlarge_guide(e);
    if (!result)
        result = pv_texels_new(e->context, e->out->width, e->out->height, e->coefficients, &e->made);
    if (!result)
        result = e->params->mode == PAVE_BTF_PAPER ? as_in_the_paper(e) : as_well_as_possible(e);
    if (!result && report)
        result = pv_enlarge_judge(e, report);
    return result ? result : fill_factors(e);
}

static void close(pv_enlarge *e)
{
    pv_release(e->known.values);
    pv_release(e->made.values);
    pv_release(e->given.values);
    pv_enlarge_free_copies(e);
    for (int32_t g = 0; g < e->guides && e->guide; g++)
        pv_release(e->guide[g].own);
    pv_release(e->guide);
    pv_release(e->given_pair);
    pv_release(e->sample_pair);
    pv_release(e->middle);
    pv_release(e->spread);
    pv_held_out_free(&e->held);
}

pave_result pave_btf_enlarge(pave_context *context, const pave_btf *sample, const pave_btf *photographs,
                             const pave_btf_plan *plan, const pave_image *mean, const pave_btf_enlarge_params *given,
                             pave_btf **out, pave_btf_enlargement *report)
{
    pave_btf_enlarge_params params;
    pv_enlarge e = { .context = context, .sample = sample, .photos = photographs, .plan = plan, .mean = mean,
                     .params = &params };
    if (out)
        *out = NULL;
    if (!context || !sample || !out || (report && report->size < sizeof report->size))
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_btf_enlarge_table, given, &params);
    if (!result)
        result = pv_algebra_open(context, &e.algebra);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "enlarge", 0, 1);
    result = run(&e, out, report);
    close(&e);
    pv_algebra_close(&e.algebra);
    pv_call_end(context, call);
    if (result)
        pave_btf_free(out);
    return result;
}
