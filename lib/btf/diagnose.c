/* How sound a BTF is, and how far two are apart: texels in rounds, so that no sum depends on the number of threads. */
#include "btf/btf.h"

#include "base/parallel.h"
#include "image/image.h"

#include <math.h>
#include <string.h>

enum { ROUND = 64 };

static const double pi = 3.14159265358979323846;

static const pave_btf_texels_params default_params = PAVE_BTF_TEXELS_PARAMS_INIT;

static const pv_param texels_rows[] = {
    PV_INTEGER(pave_btf_texels_params, texels, "", 0, INT32_MAX, "texels that are looked at, spread evenly; 0: all"),
};

const pv_table pv_btf_texels_table = PV_TABLE("BTF texels", default_params, texels_rows);

void pave_btf_texels_params_init(pave_btf_texels_params *params, size_t size)
{
    pv_params_init(&pv_btf_texels_table, params, size);
}

/* The k-th of `count` texels, spread evenly from the first to the last. */
static int64_t spread(int64_t k, int64_t count, int64_t texels)
{
    return count < 2 ? 0 : k * (texels - 1) / (count - 1);
}

static int64_t texels_looked_at(const pave_btf *btf, const pave_btf_texels_params *params)
{
    int64_t all = pv_btf_texels(btf);
    return params->texels && params->texels < all ? params->texels : all;
}

/* What one texel, or one place of a round, has to say. */
typedef struct tally {
    int64_t not_finite, negative, saturated[PV_BTF_CHANNELS], over, albedos;
    float least, greatest[PV_BTF_CHANNELS];
    double sum, albedo;
} tally;

typedef struct work {
    const pave_btf *btf;
    int64_t count, first; /* texels; the first of the round */
    double *share;        /* of the hemisphere, for each light, times the cosine that its samples lack */
    double *whole;        /* sum of all shares times cosines, for each view: of the lights it has */
    double *mean;         /* [place of the round][pair]: luminance */
    float *values;        /* a texel for each worker */
    tally *tally;         /* for each place of the round */
} work;

static int is_missing(const pave_btf *btf, int64_t pair)
{
    return btf->missing && btf->missing[pair];
}

static void count_value(tally *t, int32_t channel, float value)
{
    if (!isfinite(value)) {
        t->not_finite++;
        return;
    }
    t->negative += value < 0;
    t->least = fminf(t->least, value);
    t->sum += value;
    if (value > t->greatest[channel])
        t->greatest[channel] = value, t->saturated[channel] = 0;
    t->saturated[channel] += value == t->greatest[channel];
}

static void add_albedos(const work *w, const float *values, int32_t view, tally *t)
{
    const pave_btf *btf = w->btf;
    int32_t lights = btf->lights.count;
    for (int32_t c = 0; c < btf->channels && w->whole[view] > 0; c++) {
        double sum = 0;
        for (int32_t l = 0; l < lights; l++)
            sum += w->share[l] * values[((int64_t)view * lights + l) * btf->channels + c];
        double albedo = pi * sum / w->whole[view];
        t->albedo += albedo;
        t->over += albedo > 1;
        t->albedos++;
    }
}

static void look_at(void *data, int32_t place, int32_t worker)
{
    const work *w = data;
    const pave_btf *btf = w->btf;
    int64_t texel = spread(w->first + place, w->count, pv_btf_texels(btf)), pairs = pv_btf_length(btf) / btf->channels;
    float *values = w->values + worker * pv_btf_length(btf);
    pave_btf_abrdf(btf, (int32_t)(texel % btf->width), (int32_t)(texel / btf->width), values);
    for (int64_t p = 0; p < pairs; p++)
        for (int32_t c = 0; c < btf->channels && !is_missing(btf, p); c++) {
            count_value(&w->tally[place], c, values[p * btf->channels + c]);
            w->mean[place * pairs + p] += values[p * btf->channels + c];
        }
    for (int32_t v = 0; v < btf->views.count; v++)
        add_albedos(w, values, v, &w->tally[place]);
}

static double light_cosine(const pave_btf *btf, int32_t light)
{
    return cos((double)btf->lights.direction[light].theta);
}

static pave_result open_work(pave_context *context, work *w)
{
    const pave_btf *btf = w->btf;
    pave_result result = PAVE_OK;
    size_t lights = (size_t)btf->lights.count, views = (size_t)btf->views.count;
    w->share = pv_allocate(context, lights, sizeof *w->share, &result);
    if (!result)
        w->whole = pv_allocate_zeroed(context, views, sizeof *w->whole, &result);
    if (!result)
        w->mean = pv_allocate_zeroed(context, ROUND, views * lights * sizeof *w->mean, &result);
    if (!result)
        w->values = pv_allocate(context, (size_t)pv_workers(context), (size_t)pv_btf_length(btf) * sizeof(float),
                                &result);
    if (!result)
        w->tally = pv_allocate_zeroed(context, ROUND, sizeof *w->tally, &result);
    if (result)
        return result;
    pv_directions_share(&btf->lights, w->share);
    for (int64_t p = 0; p < (int64_t)(views * lights); p++)
        if (!is_missing(btf, p))
            w->whole[p / btf->lights.count] += w->share[p % btf->lights.count] *
                                               light_cosine(btf, (int32_t)(p % btf->lights.count));
    for (int32_t l = 0; l < btf->lights.count && !btf->cosine; l++)
        w->share[l] *= light_cosine(btf, l);
    for (int i = 0; i < ROUND; i++)
        w->tally[i].least = INFINITY;
    return PAVE_OK;
}

static void close_work(work *w)
{
    pv_release(w->share);
    pv_release(w->whole);
    pv_release(w->mean);
    pv_release(w->values);
    pv_release(w->tally);
}

/* The set that directions are of, to a tenth of a degree and in its order; -1: none. */
static int32_t recognise(const pv_directions *d)
{
    pave_direction known[256];
    for (int32_t set = 0; set < 2; set++) {
        int32_t i = 0, count = pave_directions(set, known, 256);
        for (; i < count && count == d->count; i++) {
            double a[3], b[3];
            pv_direction_vector(known[i], a);
            pv_direction_vector(d->direction[i], b);
            if (hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]) > 0.1 * pi / 180)
                break;
        }
        if (i == d->count && count == d->count)
            return set;
    }
    return -1;
}

/* The light that shines from where a view looks; -1: none, to a tenth of a degree. */
static int32_t light_at(const pave_btf *btf, int32_t view)
{
    double a[3], b[3];
    pv_direction_vector(btf->views.direction[view], a);
    for (int32_t l = 0; l < btf->lights.count; l++) {
        pv_direction_vector(btf->lights.direction[l], b);
        if (hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]) < 0.1 * pi / 180)
            return l;
    }
    return -1;
}

/* Of the mean over texels: the rms difference of pairs with view and light exchanged, over the rms. NAN without one. */
static pave_result judge_reciprocity(pave_context *context, const work *w, double *out)
{
    const pave_btf *btf = w->btf;
    double wrong = 0, whole = 0;
    pave_result result = PAVE_OK;
    int32_t views = btf->views.count, lights = btf->lights.count;
    int32_t *twin = pv_allocate(context, (size_t)views, sizeof *twin, &result);
    for (int32_t v = 0; v < views && !result; v++)
        twin[v] = light_at(btf, v);
    for (int32_t v = 0; v < views && !result; v++)
        for (int32_t u = 0; u < v && twin[v] >= 0; u++) {
            int64_t p = (int64_t)v * lights + twin[u], q = (int64_t)u * lights + twin[v];
            if (twin[u] < 0 || is_missing(btf, p) || is_missing(btf, q))
                continue;
            double a = w->mean[p] / (btf->cosine ? light_cosine(btf, twin[u]) : 1);
            double b = w->mean[q] / (btf->cosine ? light_cosine(btf, twin[v]) : 1);
            wrong += 2 * (a - b) * (a - b);
            whole += a * a + b * b;
        }
    pv_release(twin);
    *out = whole > 0 ? sqrt(wrong / whole) : NAN;
    return result;
}

static void sum_up(const work *w, pave_btf_diagnosis *out)
{
    const pave_btf *btf = w->btf;
    float greatest[PV_BTF_CHANNELS] = { 0 };
    int64_t pairs = pv_btf_length(btf) / btf->channels, over = 0, albedos = 0;
    double sum = 0, albedo = 0;
    out->least = INFINITY;
    for (int i = 0; i < ROUND; i++)
        for (int32_t c = 0; c < btf->channels; c++)
            greatest[c] = fmaxf(greatest[c], w->tally[i].greatest[c]);
    for (int i = 0; i < ROUND; i++) {
        const tally *t = &w->tally[i];
        out->not_finite += t->not_finite;
        out->negative += t->negative;
        out->least = fmin(out->least, (double)t->least);
        for (int32_t c = 0; c < btf->channels; c++)
            out->saturated += t->greatest[c] == greatest[c] ? t->saturated[c] : 0;
        sum += t->sum, albedo += t->albedo, over += t->over, albedos += t->albedos;
    }
    for (int32_t c = 0; c < btf->channels; c++)
        out->greatest = fmax(out->greatest, (double)greatest[c]);
    for (int64_t p = 0; p < pairs; p++)
        out->missing += is_missing(btf, p);
    out->samples = w->count * (pairs - out->missing) * btf->channels;
    out->mean = out->samples > out->not_finite ? sum / (double)(out->samples - out->not_finite) : NAN;
    out->albedo = albedos ? albedo / (double)albedos : NAN;
    out->albedo_over = albedos ? (double)over / (double)albedos : NAN;
    for (int64_t i = pairs; i < ROUND * pairs; i++)
        w->mean[i % pairs] += w->mean[i];
}

static pave_result diagnose(pave_context *context, work *w, pave_btf_diagnosis *out)
{
    pave_result result = open_work(context, w);
    for (w->first = 0; w->first < w->count && !result; w->first += ROUND) {
        int64_t left = w->count - w->first;
        result = pv_parallel(context, left < ROUND ? (int32_t)left : ROUND, look_at, w,
                             (double)w->first / (double)w->count, (double)(w->first + ROUND) / (double)w->count);
    }
    if (!result) {
        sum_up(w, out);
        out->texels = w->count;
        out->view_set = recognise(&w->btf->views);
        out->light_set = recognise(&w->btf->lights);
        result = judge_reciprocity(context, w, &out->reciprocity);
    }
    close_work(w);
    return result;
}

/* Gives a caller's struct of any version what it has room for. */
static void hand_out(void *to, size_t room, void *from, size_t known)
{
    memcpy(from, &room, sizeof room);
    memcpy(to, from, room < known ? room : known);
}

pave_result pave_btf_diagnose(pave_context *context, const pave_btf *btf, const pave_btf_texels_params *given,
                              pave_btf_diagnosis *out)
{
    pave_btf_texels_params params;
    pave_btf_diagnosis found;
    if (!context || !btf || !out || out->size < sizeof out->size)
        return PAVE_ERR_ARGUMENT;
    memset(&found, 0, sizeof found);
    pave_result result = pv_params_read(context, &pv_btf_texels_table, given, &params);
    if (result)
        return result;
    work w = { .btf = btf, .count = texels_looked_at(btf, &params) };
    pv_call call = pv_call_begin(context, "diagnose", 0, 1);
    result = diagnose(context, &w, &found);
    pv_call_end(context, call);
    if (!result)
        hand_out(out, out->size, &found, sizeof found);
    return result;
}

/* ---- The albedo as a picture ---- */

typedef struct map {
    work w;
    float *pixels;
} map;

static void draw_texel(void *data, int32_t texel, int32_t worker)
{
    const map *m = data;
    const pave_btf *btf = m->w.btf;
    int32_t lights = btf->lights.count, views = 0;
    double sum[PV_BTF_CHANNELS] = { 0 };
    float *values = m->w.values + worker * pv_btf_length(btf);
    pave_btf_abrdf(btf, texel % btf->width, texel / btf->width, values);
    for (int32_t v = 0; v < btf->views.count; v++) {
        views += m->w.whole[v] > 0;
        for (int64_t i = 0; i < (int64_t)lights * btf->channels && m->w.whole[v] > 0; i++)
            sum[i % btf->channels] += m->w.share[i / btf->channels] / m->w.whole[v] *
                                      values[(int64_t)v * lights * btf->channels + i];
    }
    for (int32_t c = 0; c < btf->channels; c++)
        m->pixels[(int64_t)texel * btf->channels + c] = views ? (float)(pi * sum[c] / views) : 0;
}

pave_result pave_btf_albedo(pave_context *context, const pave_btf *btf, pave_image **out)
{
    map m = { .w = { .btf = btf } };
    if (out)
        *out = NULL;
    if (!context || !btf || !out)
        return PAVE_ERR_ARGUMENT;
    pv_call call = pv_call_begin(context, "albedo", 0, 1);
    pave_result result = open_work(context, &m.w);
    if (!result)
        result = pv_btf_picture(context, btf, btf->width, btf->height, 0, out);
    if (!result) {
        m.pixels = (*out)->pixels;
        result = pv_parallel(context, (int32_t)pv_btf_texels(btf), draw_texel, &m, 0, 1);
    }
    close_work(&m.w);
    pv_call_end(context, call);
    if (result)
        pave_image_free(out);
    return result;
}
