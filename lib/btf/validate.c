/* How best to reconstruct, found on a material that the model has not seen: for some numbers of samples, how much noise
 * to expect about either basis, and how to mix them. */
#include "btf/trial.h"

#include "util/random.h"

#include <math.h>
#include <string.h>

enum { TEXELS = 128, PAIRS = 512, FIRST = 8, STEP = 2, NOISES = 13, MOST_SAMPLES = 2048 };

/* One by chance in each share of the pairs. */
static void ask(pv_trial *t)
{
    int64_t all = pv_model_pairs(t->model);
    for (int32_t i = 0; i < t->pairs; i++) {
        pv_random r = pv_draw(2, PV_DRAW_SKETCH, (uint32_t)i, 0, 0);
        double place = (i + r.word[0] * 0x1p-32) * (double)all / t->pairs;
        t->asked[i] = (int32_t)place;
    }
}

static void place_texels(pv_trial *t)
{
    int64_t wide = t->btf->width - t->window + 1, high = t->btf->height - t->window + 1, all = wide * high;
    for (int32_t i = 0; i < t->texels; i++) {
        int64_t k = t->texels < 2 ? 0 : i * (all - 1) / (t->texels - 1);
        t->place[i] = k / wide * t->btf->width + k % wide;
    }
}

static pave_result read_texels(pv_trial *t)
{
    const pave_btf_model *model = t->model;
    int64_t pairs = pv_model_pairs(model);
    int32_t centre = t->window * t->window / 2;
    pv_values values = { 0 };
    float *to[PV_BTF_CHANNELS];
    pave_result result = pv_values_open(t->context, t->btf, model, &values);
    float *texel = NULL;
    if (!result)
        texel = pv_allocate(t->context, (size_t)model->planes, (size_t)pairs * sizeof *texel, &result);
    for (int32_t c = 0; c < model->planes && !result; c++)
        to[c] = texel + c * pairs;
    for (int32_t i = 0; i < t->texels && !result; i++)
        for (int32_t s = 0; s < t->window * t->window; s++) {
            pv_values_read(&values, t->place[i] + s / t->window * t->btf->width + s % t->window, 0, to);
            for (int32_t c = 0; c < model->planes; c++) {
                float *row = pv_trial_measured(t, c, s) + (int64_t)i * t->samples;
                for (int32_t k = 0; k < t->samples; k++)
                    row[k] = to[c][t->plan[k]];
                for (int32_t k = 0; k < t->pairs && s == centre; k++)
                    t->truth[((int64_t)c * t->texels + i) * t->pairs + k] = to[c][t->asked[k]];
            }
        }
    pv_release(texel);
    pv_values_close(&values);
    return result;
}

static const float *truth_of(const pv_trial *t, int32_t plane)
{
    return t->truth + (int64_t)plane * t->texels * t->pairs;
}

static double mean_square(const pv_trial *t, const float *a, const float *b)
{
    double sum = 0;
    int64_t count = (int64_t)t->texels * t->pairs;
    for (int64_t i = 0; i < count; i++)
        sum += (double)(a[i] - b[i]) * (double)(a[i] - b[i]);
    return sum / (double)count;
}

static double noise_at(const pv_basis *basis, int32_t step)
{
    return basis->whole * pow(10, -0.5 * step);
}

/* The noise with which a basis by itself predicts best; its prediction comes last. */
static pave_result find_noise(pv_attempt *a, const pv_basis *basis, float *predicted, double *noise, double *error)
{
    pave_result result = PAVE_OK;
    *error = INFINITY;
    for (int32_t i = 0; i < NOISES && !result; i++) {
        result = pv_attempt_predict(a, a->known, noise_at(basis, i), predicted);
        double here = result ? 0 : mean_square(a->t, predicted, truth_of(a->t, a->plane));
        if (here < *error) {
            *error = here;
            *noise = noise_at(basis, i);
        }
    }
    return result ? result : pv_attempt_predict(a, a->known, *noise, predicted);
}

/* ABTFs first, then ABRDFs of what they leave: A(b) + share (T - A(T at b)), whose best share has a closed form. */
typedef struct mixing {
    pv_attempt *texels;
    float *patches;      /* [texel][asked]: T */
    float *at_measured;  /* [texel][sample] */
    float *known;        /* [texel][rank]: of it, along the ABRDFs' directions */
    float *own, *theirs; /* [texel][asked]: A(b), A(T at b) */
} mixing;

static double best_share(const pv_trial *t, const mixing *m, int32_t plane, double *error)
{
    const float *truth = truth_of(t, plane);
    double square = 0, along = 0, rest = 0;
    int64_t count = (int64_t)t->texels * t->pairs;
    for (int64_t i = 0; i < count; i++) {
        double d = (double)m->patches[i] - (double)m->theirs[i], r = (double)m->own[i] - (double)truth[i];
        square += d * d;
        along += d * r;
        rest += r * r;
    }
    double share = square > 0 ? fmin(fmax(-along / square, 0), 1) : 0;
    *error = (rest + 2 * share * along + share * share * square) / (double)count;
    return share;
}

static pave_result mix(const pv_trial *t, mixing *m, const pv_basis *basis, pv_rung *rung, double *error)
{
    pv_attempt *a = m->texels;
    int32_t rank = a->system.rank;
    pave_result result = pv_trial_product(t, 0, t->texels, rank, a->samples, m->at_measured, a->samples,
                                          a->system.from, rank, 0, m->known, rank);
    *error = INFINITY;
    for (int32_t i = -4; i < NOISES && !result; i++) {
        double noise = noise_at(basis, i), here;
        result = pv_attempt_predict(a, a->known, noise, m->own);
        if (!result)
            result = pv_attempt_predict(a, m->known, noise, m->theirs);
        double share = result ? 0 : best_share(t, m, a->plane, &here);
        if (!result && here < *error) {
            *error = here;
            rung->rest = noise;
            rung->share = share;
        }
    }
    return result;
}

/* What is left of the variance of a value, as the model has it. */
static double expected(const pv_trial *t, const pv_attempt *a, const pv_basis *basis, double noise)
{
    double whole = 0, surprise = 0;
    int32_t centre = t->window * t->window / 2;
    for (int32_t k = 0; k < basis->components; k++)
        whole += (double)basis->deviation[k] * basis->deviation[k];
    for (int32_t i = 0; i < t->texels; i++)
        surprise += pv_system_surprise(&a->system, noise,
                                       pv_trial_measured(t, a->plane, centre) + (int64_t)i * t->samples,
                                       a->known + (int64_t)i * a->system.rank) / t->texels;
    return (pv_system_left(&a->system, whole, noise) / (double)pv_model_pairs(t->model) + basis->outside) * surprise;
}

static pave_result try_patches(const pv_trial *t, int32_t plane, mixing *m, pv_rung *rung, double *error)
{
    const pave_btf_model *model = t->model;
    pv_attempt patches;
    double alone;
    pave_result result = pv_attempt_open(t, plane, PV_OF_PATCHES, (int32_t)rung->samples, &patches);
    if (!result)
        result = find_noise(&patches, &model->basis[plane][PV_OF_PATCHES], m->patches, &rung->noise[1], &alone);
    if (!result)
        result = pv_attempt_predict_measured(&patches, rung->noise[1], m->at_measured);
    pv_attempt_close(&patches);
    return result ? result : mix(t, m, &model->basis[plane][PV_OF_TEXELS], rung, error);
}

static pave_result find_rung(const pv_trial *t, int32_t plane, pv_rung *rung)
{
    const pv_basis *basis = &t->model->basis[plane][PV_OF_TEXELS];
    int32_t samples = (int32_t)rung->samples;
    size_t bytes = (size_t)t->pairs * sizeof(float);
    pv_attempt texels;
    mixing m = { .texels = &texels };
    double error;
    pave_result result = pv_attempt_open(t, plane, PV_OF_TEXELS, samples, &texels);
    float **room[3] = { &m.patches, &m.own, &m.theirs };
    for (int i = 0; i < 3 && !result; i++)
        *room[i] = pv_allocate(t->context, (size_t)t->texels, bytes, &result);
    if (!result)
        m.at_measured = pv_allocate(t->context, (size_t)t->texels, (size_t)samples * sizeof(float), &result);
    if (!result)
        m.known = pv_allocate(t->context, (size_t)t->texels, (size_t)texels.system.rank * sizeof(float), &result);
    if (!result)
        result = find_noise(&texels, basis, m.own, &rung->noise[0], &error);
    rung->rest = rung->noise[0];
    rung->noise[1] = rung->noise[0];
    if (!result && t->model->patch > 1)
        result = try_patches(t, plane, &m, rung, &error);
    if (!result)
        rung->trust = sqrt(error / fmax(expected(t, &texels, basis, rung->noise[0]), 1e-30));
    pv_attempt_close(&texels);
    for (int i = 0; i < 3; i++)
        pv_release(*room[i]);
    pv_release(m.at_measured);
    pv_release(m.known);
    return result;
}

static pave_result open_trial(pv_trial *t)
{
    pave_context *context = t->context;
    int64_t pairs = pv_model_pairs(t->model), spots = (int64_t)t->window * t->window;
    int64_t places = (int64_t)(t->btf->width - t->window + 1) * (t->btf->height - t->window + 1);
    size_t planes = (size_t)t->model->planes;
    pave_result result = PAVE_OK;
    t->texels = (int32_t)(places < TEXELS ? places : TEXELS);
    t->pairs = (int32_t)(pairs < PAIRS ? pairs : PAIRS);
    t->samples = FIRST;
    while ((int64_t)t->samples * STEP <= pairs / 8 && t->samples * STEP <= MOST_SAMPLES)
        t->samples *= STEP;
    t->samples = (int32_t)(t->samples < pairs ? t->samples : pairs);
    t->plan = pv_allocate(context, (size_t)t->samples, sizeof *t->plan, &result);
    if (!result)
        t->asked = pv_allocate(context, (size_t)t->pairs, sizeof *t->asked, &result);
    if (!result)
        t->place = pv_allocate(context, (size_t)t->texels, sizeof *t->place, &result);
    if (!result)
        t->truth = pv_allocate(context, planes * (size_t)t->texels, (size_t)t->pairs * sizeof(float), &result);
    if (!result)
        t->measured = pv_allocate(context, planes * (size_t)spots * (size_t)t->texels,
                                  (size_t)t->samples * sizeof(float), &result);
    return result;
}

static void close_trial(pv_trial *t)
{
    pv_release(t->plan);
    pv_release(t->asked);
    pv_release(t->place);
    pv_release(t->truth);
    pv_release(t->measured);
}

static pave_result find_rungs(pv_trial *t, pave_btf_model *model)
{
    double noise = 0.03 * model->basis[0][PV_OF_TEXELS].whole;
    pave_result result = pv_plan_greedy(t->context, model, noise, t->samples, t->plan, NULL);
    if (result)
        return result;
    ask(t);
    place_texels(t);
    result = read_texels(t);
    for (int32_t n = FIRST < t->samples ? FIRST : t->samples; n <= t->samples && !result; n *= STEP, model->rungs++)
        for (int32_t c = 0; c < model->planes && !result; c++) {
            model->rung[c][model->rungs].samples = n;
            result = find_rung(t, c, &model->rung[c][model->rungs]);
            if (!result)
                result = pv_progress(t->context, (double)(c + 1) / model->planes * n / t->samples);
        }
    return result;
}

pave_result pv_model_validate(pave_context *context, const pv_algebra *algebra, const pave_btf *btf,
                              pave_btf_model *model)
{
    pv_trial t = { .context = context, .algebra = algebra, .btf = btf, .model = model, .window = 2 * model->patch - 1 };
    if (btf->width < t.window || btf->height < t.window)
        return PAVE_OK; /* no patch has all it needs: settings stay those of nobody's */
    pave_result result = open_trial(&t);
    if (!result)
        result = find_rungs(&t, model);
    close_trial(&t);
    return result;
}
