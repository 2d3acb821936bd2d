/* How far two BTFs are apart: texels by themselves, so that no sum depends on the number of threads. */
#include "btf/btf.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static const pave_btf_measure_params default_params = PAVE_BTF_MEASURE_PARAMS_INIT;

static const pv_param measure_rows[] = {
    PV_INTEGER(pave_btf_measure_params, texels, "", 0, INT32_MAX, "texels that are looked at, spread evenly; 0: all"),
    PV_REAL(pave_btf_measure_params, epsilon, "", 1e-9, 1, "added before a logarithm; white is 0.318"),
};

const pv_table pv_btf_measure_table = PV_TABLE("BTF comparison", default_params, measure_rows);

void pave_btf_measure_params_init(pave_btf_measure_params *params, size_t size)
{
    pv_params_init(&pv_btf_measure_table, params, size);
}

typedef struct pairing {
    const pave_btf *a, *b;
    int64_t count;
    float *values;      /* two texels for each worker */
    double epsilon;
    double (*error)[6]; /* of each texel: squares of the difference, of its logarithm, of log luminance, of b's; of
                           luminance, of b's */
    double *sums;       /* two of each light, for each worker */
    double *varied;     /* of each view: squares of what texels of b differ from their mean */
} pairing;

/* The k-th of so many texels, spread evenly from the first to the last. */
static int64_t texel_of(const pairing *p, int64_t k)
{
    return p->count < 2 ? 0 : k * (pv_btf_texels(p->b) - 1) / (p->count - 1);
}

static double log_of(const pairing *p, double value)
{
    return log(fmax(value, 0) + p->epsilon);
}

static double luminance(const float *values, int32_t channels)
{
    double sum = 0;
    for (int32_t c = 0; c < channels && channels != 3; c++)
        sum += (double)values[c] / channels;
    if (channels == 3)
        sum = 0.299 * (double)values[0] + 0.587 * (double)values[1] + 0.114 * (double)values[2];
    return sum;
}

static void compare_texel(void *data, int32_t index, int32_t worker)
{
    const pairing *p = data;
    int64_t length = pv_btf_length(p->a), texel = texel_of(p, index);
    int32_t channels = p->a->channels, x = (int32_t)(texel % p->a->width), y = (int32_t)(texel / p->a->width);
    float *a = p->values + 2 * worker * length, *b = a + length;
    double *error = p->error[index];
    pave_btf_abrdf(p->a, x, y, a);
    pave_btf_abrdf(p->b, x, y, b);
    memset(error, 0, sizeof p->error[0]);
    for (int64_t i = 0; i < length; i++) {
        double linear = (double)a[i] - (double)b[i], logs = log_of(p, (double)a[i]) - log_of(p, (double)b[i]);
        error[0] += linear * linear;
        error[1] += logs * logs;
    }
    for (int64_t i = 0; i < length; i += channels) {
        double of_a = luminance(a + i, channels), of_b = luminance(b + i, channels);
        double log_b = log_of(p, of_b), apart = log_of(p, of_a) - log_b;
        error[2] += apart * apart;
        error[3] += log_b * log_b;
        error[4] += (of_a - of_b) * (of_a - of_b);
        error[5] += of_b * of_b;
    }
}

/* What texels of b differ from their mean, seen from one view. */
static void vary_view(void *data, int32_t view, int32_t worker)
{
    const pairing *p = data;
    int32_t lights = p->b->lights.count, channels = p->b->channels;
    float *values = p->values + 2 * worker * pv_btf_length(p->b);
    double *sum = p->sums + (int64_t)worker * 2 * lights, *square = sum + lights;
    memset(sum, 0, 2 * (size_t)lights * sizeof *sum);
    for (int64_t k = 0; k < p->count; k++) {
        pv_btf_from_view(p->b, texel_of(p, k), view, values);
        for (int32_t l = 0; l < lights; l++) {
            double here = log_of(p, luminance(values + (int64_t)l * channels, channels));
            sum[l] += here;
            square[l] += here * here;
        }
    }
    p->varied[view] = 0;
    for (int32_t l = 0; l < lights; l++)
        p->varied[view] += fmax(square[l] - sum[l] * sum[l] / (double)p->count, 0);
}

static double greatest_angle(const pv_directions *a, const pv_directions *b)
{
    double most = 0;
    for (int32_t i = 0; i < a->count; i++)
        most = fmax(most, pv_direction_distance(a->direction[i], b->direction[i]) * 180 / pi);
    return most;
}

static void sum_errors(const pairing *p, pave_btf_difference *out)
{
    double length = (double)pv_btf_length(p->a), apart = 0, whole = 0, varied = 0, linear = 0, light = 0;
    double pairs = length / p->a->channels * (double)p->count;
    for (int64_t i = 0; i < p->count; i++) {
        out->rmse += sqrt(p->error[i][0] / length) / (double)p->count;
        out->rmse_log += sqrt(p->error[i][1] / length) / (double)p->count;
        apart += p->error[i][2];
        whole += p->error[i][3];
        linear += p->error[i][4];
        light += p->error[i][5];
    }
    for (int32_t v = 0; v < p->b->views.count; v++)
        varied += p->varied[v];
    out->relative = whole > 0 ? sqrt(apart / whole) : 0;
    out->whole = sqrt(whole / pairs);
    out->variation = sqrt(varied / pairs);
    out->centred = varied > 0 ? sqrt(apart / varied) : 0;
    out->linear = light > 0 ? sqrt(linear / light) : 0;
    out->texels = p->count;
    out->direction_error = fmax(greatest_angle(&p->a->views, &p->b->views),
                                greatest_angle(&p->a->lights, &p->b->lights));
}

pave_result pave_btf_measure(pave_context *context, const pave_btf *a, const pave_btf *b,
                             const pave_btf_measure_params *given, pave_btf_difference *out)
{
    pave_btf_measure_params params;
    pave_btf_difference found;
    if (!context || !a || !b || !out || out->size < sizeof out->size)
        return PAVE_ERR_ARGUMENT;
    memset(&found, 0, sizeof found);
    pave_result result = pv_params_read(context, &pv_btf_measure_table, given, &params);
    if (!result && (a->width != b->width || a->height != b->height || a->channels != b->channels ||
                    a->views.count != b->views.count || a->lights.count != b->lights.count))
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "the two BTFs differ in texels, channels or directions");
    if (result)
        return result;
    int64_t texels = pv_btf_texels(a);
    pairing p = { .a = a, .b = b, .epsilon = params.epsilon };
    p.count = params.texels && params.texels < texels ? params.texels : texels;
    pv_call call = pv_call_begin(context, "measure", 0, 1);
    p.values = pv_allocate(context, (size_t)pv_workers(context), 2 * (size_t)pv_btf_length(a) * sizeof *p.values,
                           &result);
    if (!result)
        p.error = pv_allocate(context, (size_t)p.count, sizeof *p.error, &result);
    if (!result)
        p.varied = pv_allocate(context, (size_t)b->views.count, sizeof *p.varied, &result);
    if (!result)
        p.sums = pv_allocate(context, (size_t)pv_workers(context), 2 * (size_t)b->lights.count * sizeof *p.sums,
                             &result);
    if (!result)
        result = pv_parallel(context, (int32_t)p.count, compare_texel, &p, 0, 0.7);
    if (!result)
        result = pv_parallel(context, b->views.count, vary_view, &p, 0.7, 1);
    if (!result) {
        size_t size = out->size;
        sum_errors(&p, &found);
        memcpy(out, &found, size < sizeof found ? size : sizeof found);
        out->size = size;
    }
    pv_release(p.values);
    pv_release(p.error);
    pv_release(p.varied);
    pv_release(p.sums);
    pv_call_end(context, call);
    return result;
}
