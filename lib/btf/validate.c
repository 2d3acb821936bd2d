/* Reconstruction tried on a material that the model has not seen: for some numbers of samples, what errors each noise
 * about either basis makes, and each way to mix them. */
#include "btf/evidence.h"
#include "btf/trial.h"

#include "util/random.h"

#include <math.h>
#include <string.h>

enum { TEXELS = 128, PAIRS = 512, FIRST = 8, STEP = 2, MOST_SAMPLES = 2048 };

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

/* ABTFs first, then ABRDFs of what they leave: A(b) + share (T - A(T at b)). */
typedef struct mixing {
    pv_attempt *texels, *patches;
    float *first;        /* [texel][asked]: T */
    float *at_measured;  /* [texel][sample] */
    float *known;        /* [texel][rank]: of it, along the ABRDFs' directions */
    float *own, *theirs; /* [texel][asked]: A(b), A(T at b) */
} mixing;

/* With every share: the mean square of A(b) less the truth, its product with T - A(T at b), and the square of that. */
static void compare(const pv_trial *t, const mixing *m, double out[3])
{
    const float *truth = truth_of(t, m->texels->plane);
    int64_t count = (int64_t)t->texels * t->pairs;
    memset(out, 0, 3 * sizeof *out);
    for (int64_t i = 0; i < count; i++) {
        double d = (double)m->first[i] - (double)m->theirs[i], r = (double)m->own[i] - (double)truth[i];
        out[0] += r * r;
        out[1] += d * r;
        out[2] += d * d;
    }
    for (int k = 0; k < 3; k++)
        out[k] /= (double)count;
}

static pave_result mix(const pv_trial *t, mixing *m, const pv_basis *basis, double mixed[PV_ALL_NOISES][3])
{
    pv_attempt *a = m->texels;
    int32_t rank = a->system.rank;
    pave_result result = pv_trial_product(t, 0, t->texels, rank, a->samples, m->at_measured, a->samples,
                                          a->system.from, rank, 0, m->known, rank);
    for (int32_t i = 0; i < PV_ALL_NOISES && !result; i++) {
        double noise = pv_noise_at(basis, i - PV_LOUD_NOISES);
        result = pv_attempt_predict(a, a->known, noise, m->own);
        if (!result)
            result = pv_attempt_predict(a, m->known, noise, m->theirs);
        if (!result)
            compare(t, m, mixed[i]);
    }
    return result;
}

/* What is left of the variance of a value, as the model has it. */
static double expect(const pv_trial *t, const pv_attempt *a, const pv_basis *basis, double noise)
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

static pave_result try_texels(const pv_trial *t, mixing *m, pv_errors *out)
{
    const pv_basis *basis = &t->model->basis[m->texels->plane][PV_OF_TEXELS];
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < PV_NOISES && !result; i++) {
        double noise = pv_noise_at(basis, i);
        result = pv_attempt_predict(m->texels, m->texels->known, noise, m->own);
        out->texels[i] = result ? 0 : mean_square(t, m->own, truth_of(t, m->texels->plane));
        out->expected[i] = expect(t, m->texels, basis, noise);
        out->patches[i] = INFINITY;
    }
    return result;
}

static pave_result try_patches(const pv_trial *t, mixing *m, pv_errors *out)
{
    const pv_basis *basis = t->model->basis[m->texels->plane];
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < PV_NOISES && !result; i++) {
        double noise = pv_noise_at(&basis[PV_OF_PATCHES], i);
        result = pv_attempt_predict(m->patches, m->patches->known, noise, m->first);
        if (!result)
            result = pv_attempt_predict_measured(m->patches, noise, m->at_measured);
        if (result)
            break;
        out->patches[i] = mean_square(t, m->first, truth_of(t, m->texels->plane));
        result = mix(t, m, &basis[PV_OF_TEXELS], out->mixed[i]);
    }
    return result;
}

static pave_result open_mixing(const pv_trial *t, int32_t plane, int32_t samples, mixing *m)
{
    size_t bytes = (size_t)t->pairs * sizeof(float);
    float **room[3] = { &m->first, &m->own, &m->theirs };
    pave_result result = pv_attempt_open(t, plane, PV_OF_TEXELS, samples, m->texels);
    if (!result && t->model->patch > 1)
        result = pv_attempt_open(t, plane, PV_OF_PATCHES, samples, m->patches);
    for (int i = 0; i < 3 && !result; i++)
        *room[i] = pv_allocate(t->context, (size_t)t->texels, bytes, &result);
    if (!result)
        m->at_measured = pv_allocate(t->context, (size_t)t->texels, (size_t)samples * sizeof(float), &result);
    if (!result)
        m->known = pv_allocate(t->context, (size_t)t->texels, (size_t)m->texels->system.rank * sizeof(float), &result);
    return result;
}

static void close_mixing(mixing *m)
{
    pv_attempt_close(m->texels);
    pv_attempt_close(m->patches);
    pv_release(m->first);
    pv_release(m->own);
    pv_release(m->theirs);
    pv_release(m->at_measured);
    pv_release(m->known);
}

static pave_result try_plane(const pv_trial *t, int32_t plane, int32_t samples, pv_errors *out)
{
    pv_attempt texels = { 0 }, patches = { 0 };
    mixing m = { .texels = &texels, .patches = &patches };
    memset(out, 0, sizeof *out);
    pave_result result = open_mixing(t, plane, samples, &m);
    if (!result)
        result = try_texels(t, &m, out);
    if (!result && t->model->patch > 1)
        result = try_patches(t, &m, out);
    close_mixing(&m);
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

/* By a plan as those that will be asked for: with no more noise than what the model leaves. */
static pave_result try_rungs(pv_trial *t, pv_errors *errors, pv_evidence *evidence)
{
    const pv_basis *basis = &t->model->basis[0][PV_OF_TEXELS];
    double noise = fmax(basis->outside, 1e-6 * basis->whole);
    int32_t planes = t->model->planes, rung = 0;
    pave_result result = pv_plan_greedy(t->context, t->model, noise, t->samples, t->plan, NULL);
    if (result)
        return result;
    ask(t);
    place_texels(t);
    result = read_texels(t);
    for (int32_t n = FIRST < t->samples ? FIRST : t->samples; n <= t->samples && !result; n *= STEP, rung++) {
        evidence->samples[rung] = n;
        for (int32_t c = 0; c < planes && !result; c++) {
            result = try_plane(t, c, n, errors);
            if (!result)
                pv_evidence_add(evidence, c, rung, errors);
            if (!result)
                result = pv_progress(t->context, (double)(c + 1) / planes * n / t->samples);
        }
    }
    evidence->rungs = rung;
    return result;
}

pave_result pv_model_validate(pave_context *context, const pv_algebra *algebra, const pave_btf *btf,
                              const pave_btf_model *model, pv_evidence *evidence)
{
    pv_trial t = { .context = context, .algebra = algebra, .btf = btf, .model = model, .window = 2 * model->patch - 1 };
    if (btf->width < t.window || btf->height < t.window)
        return PAVE_OK; /* no patch has all it needs: it tells nothing */
    pave_result result = open_trial(&t);
    pv_errors *errors = result ? NULL : pv_allocate(context, 1, sizeof *errors, &result);
    if (!result)
        result = try_rungs(&t, errors, evidence);
    pv_release(errors);
    close_trial(&t);
    return result;
}
