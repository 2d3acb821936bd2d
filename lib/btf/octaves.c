/* Octaves of coefficients: differences of ever smoother copies (a trous, Holschneider et al. 1989), which add up to the
 * whole again. */
#include "btf/enlarge.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

static const double most_gain = 4;
static const double ridge = 1e-3; /* of the photographs' mean square */

/* Octaves overlap: scaling one changes what its neighbours measure. Gains go beyond the root of what is missed, which
 * would do for each alone. */
enum { TURNS = 10 };
static const double exponent = 0.7;

/* What a field is taken apart for; NULL: not for that. */
typedef struct purpose {
    const double *gains; /* [octave][channel], by which the field's own are scaled */
    double *power;       /* [octave][channel], gets the mean square of slopes */
    float *slopes;       /* [texel][right, down][channel], gets those of one octave */
    int32_t octave;
} purpose;

/* A field while it is taken apart: what is left, and what is next. */
typedef struct apart {
    const pv_texels *shape;
    int32_t gap; /* between the texels that are averaged */
    float *now, *rows, *next;
    float *sum;          /* octaves times their gains; NULL: none */
    const double *gain;  /* [channel] */
    double *power;       /* [row][channel], of the octave */
    float *slopes;       /* NULL: not of this one */
} apart;

/* The mean of five texels that lie `step` values apart along an axis; `at` is the middle one's place on it. */
static void smooth(const float *from, int64_t at, int64_t count, int64_t gap, int64_t step, int32_t channels, float *to)
{
    static const float weight[5] = { 0.0625f, 0.25f, 0.375f, 0.25f, 0.0625f };
    const float *tap[5];
    for (int64_t i = 0; i < 5; i++)
        tap[i] = from + (pv_mirrored(at + (i - 2) * gap, count) - at) * step;
    for (int32_t c = 0; c < channels; c++)
        to[c] = weight[0] * tap[0][c] + weight[1] * tap[1][c] + weight[2] * tap[2][c] + weight[3] * tap[3][c] +
                weight[4] * tap[4][c];
}

static void smooth_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const apart *a = data;
    int64_t n = a->shape->channels, wide = a->shape->width;
    for (int64_t x = 0; x < wide; x++)
        smooth(a->now + (y * wide + x) * n, x, wide, a->gap, n, (int32_t)n, a->rows + (y * wide + x) * n);
}

/* And down the columns; what that took away is the octave. */
static void take_octave(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const apart *a = data;
    int64_t n = a->shape->channels, wide = a->shape->width;
    for (int64_t x = 0; x < wide; x++) {
        int64_t at = (y * wide + x) * n;
        smooth(a->rows + at, y, a->shape->height, a->gap, wide * n, (int32_t)n, a->next + at);
        for (int64_t c = 0; c < n && a->sum; c++)
            a->sum[at + c] += (float)(a->gain[c] * ((double)a->now[at + c] - (double)a->next[at + c]));
    }
}

/* Slopes to the right and downwards, in the octave. */
static void measure_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const apart *a = data;
    int64_t n = a->shape->channels, wide = a->shape->width;
    double *power = a->power + y * n;
    memset(power, 0, (size_t)n * sizeof *power);
    for (int64_t x = 0; x < wide; x++) {
        int64_t at = (y * wide + x) * n, right = x + 1 < wide ? at + n : at;
        int64_t below = y + 1 < a->shape->height ? at + wide * n : at;
        for (int64_t c = 0; c < n; c++) {
            double here = (double)a->now[at + c] - (double)a->next[at + c];
            double along = (double)a->now[right + c] - (double)a->next[right + c] - here;
            double down = (double)a->now[below + c] - (double)a->next[below + c] - here;
            power[c] += along * along + down * down;
            if (a->slopes) {
                a->slopes[2 * at + c] = (float)along;
                a->slopes[2 * at + n + c] = (float)down;
            }
        }
    }
}

static pave_result take_apart(pave_context *context, const pv_texels *t, const purpose *use)
{
    pave_result result = PAVE_OK;
    const double *gains = use->gains;
    int32_t octaves = use->slopes ? use->octave + 1 : PV_OCTAVES;
    size_t texels = (size_t)pv_texels_count(t), bytes = (size_t)t->channels * sizeof(float);
    apart a = { .shape = t };
    a.now = pv_allocate(context, texels, bytes, &result);
    if (!result)
        a.rows = pv_allocate(context, texels, bytes, &result);
    if (!result)
        a.next = pv_allocate(context, texels, bytes, &result);
    if (!result)
        a.power = pv_allocate(context, (size_t)t->height, 2 * bytes, &result);
    if (!result)
        memcpy(a.now, t->values, texels * bytes);
    if (!result && gains)
        memset(t->values, 0, texels * bytes);
    a.sum = gains ? t->values : NULL;
    for (int32_t o = 0; o < octaves && !result; o++) {
        float *swap = a.now;
        a.gap = 1 << o;
        a.slopes = o == use->octave ? use->slopes : NULL;
        a.gain = gains ? gains + (int64_t)o * t->channels : NULL;
        result = pv_parallel(context, t->height, smooth_row, &a, 0, 0);
        if (!result)
            result = pv_parallel(context, t->height, take_octave, &a, 0, 0);
        if (!result && (use->power || a.slopes))
            result = pv_parallel(context, t->height, measure_row, &a, 0, 0);
        for (int32_t c = 0; c < t->channels && use->power && !result; c++) {
            use->power[o * t->channels + c] = 0;
            for (int32_t y = 0; y < t->height; y++)
                use->power[o * t->channels + c] += a.power[(int64_t)y * t->channels + c] / (double)texels;
        }
        a.now = a.next;
        a.next = swap;
    }
    for (size_t i = 0; i < texels * (size_t)t->channels && gains && !result; i++)
        t->values[i] += a.now[i];
    pv_release(a.now);
    pv_release(a.rows);
    pv_release(a.next);
    pv_release(a.power);
    return result;
}

pave_result pv_enlarge_octaves(const pv_enlarge *e, double *own, double *made)
{
    pave_result result = take_apart(e->context, &e->known, &(purpose){ .power = own });
    return result ? result : take_apart(e->context, &e->made, &(purpose){ .power = made });
}

/* ---- What the photographs tell of the rest ---- */

/* A fit of coefficients' slopes to those of photographs, in one octave. */
typedef struct regression {
    float *seen, *given, *known; /* slopes: of what photographs show of the sample and of the whole, of coefficients */
    double *sample, *whole;      /* [guide][guide], products of photographs' slopes */
    double *matrix;              /* room to solve in */
    double *weight;              /* [coefficient][guide] */
} regression;

static double quadratic(const double *matrix, const double *x, int32_t n)
{
    double sum = 0;
    for (int32_t i = 0; i < n; i++)
        for (int32_t k = 0; k < n; k++)
            sum += x[i] * matrix[i * n + k] * x[k];
    return sum;
}

static pave_result fit_octave(const pv_enlarge *e, int32_t octave, regression *r)
{
    int32_t n = e->guides;
    int64_t inside = 2 * pv_texels_count(&e->seen), all = 2 * pv_texels_count(&e->given);
    double trace = 0;
    pave_result result = take_apart(e->context, &e->seen, &(purpose){ .slopes = r->seen, .octave = octave });
    if (!result)
        result = take_apart(e->context, &e->given, &(purpose){ .slopes = r->given, .octave = octave });
    if (!result)
        result = take_apart(e->context, &e->known, &(purpose){ .slopes = r->known, .octave = octave });
    if (!result)
        result = pv_gram(e->context, &e->algebra, inside, n, r->seen, r->sample);
    if (!result)
        result = pv_gram(e->context, &e->algebra, all, n, r->given, r->whole);
    if (!result)
        result = pv_cross(e->context, &e->algebra, inside, n, r->seen, e->coefficients, r->known, r->weight);
    if (result)
        return result;
    memcpy(r->matrix, r->sample, (size_t)n * (size_t)n * sizeof *r->matrix);
    for (int32_t i = 0; i < n; i++)
        trace += r->sample[i * n + i];
    for (int32_t i = 0; i < n; i++)
        r->matrix[i * n + i] += ridge * trace / n;
    if (trace <= 0 || !pv_solve_positive(&e->algebra, n, r->matrix, e->coefficients, r->weight))
        memset(r->weight, 0, (size_t)n * (size_t)e->coefficients * sizeof *r->weight);
    return PAVE_OK;
}

static pave_result make_regression(const pv_enlarge *e, regression *r)
{
    pave_result result = PAVE_OK;
    size_t inside = 2 * (size_t)pv_texels_count(&e->seen), all = 2 * (size_t)pv_texels_count(&e->given);
    size_t n = (size_t)e->guides;
    r->seen = pv_allocate(e->context, inside, n * sizeof *r->seen, &result);
    if (!result)
        r->given = pv_allocate(e->context, all, n * sizeof *r->given, &result);
    if (!result)
        r->known = pv_allocate(e->context, inside, (size_t)e->coefficients * sizeof *r->known, &result);
    if (!result)
        r->sample = pv_allocate(e->context, n, 3 * n * sizeof *r->sample, &result);
    if (!result)
        r->weight = pv_allocate(e->context, n, (size_t)e->coefficients * sizeof *r->weight, &result);
    if (!result) {
        r->whole = r->sample + n * n;
        r->matrix = r->whole + n * n;
    }
    return result;
}

static void free_regression(regression *r)
{
    pv_release(r->seen);
    pv_release(r->given);
    pv_release(r->known);
    pv_release(r->sample);
    pv_release(r->weight);
}

/* The sample may be rougher or smoother than the rest. The photographs tell by how much, where a coefficient's slopes
 * go with theirs: in each plane, the power of what they say of it in the whole over that in the sample. One photograph
 * alone tells half of it at best. */
static pave_result adapt(const pv_enlarge *e, double *own)
{
    double trust = e->guides / (double)(e->guides + e->planes);
    double area = (double)pv_texels_count(&e->given) / (double)pv_texels_count(&e->seen);
    regression r = { 0 };
    pave_result result = make_regression(e, &r);
    for (int32_t octave = 0; octave < PV_OCTAVES && !result; octave++) {
        result = fit_octave(e, octave, &r);
        for (int32_t plane = 0; plane < e->planes && !result; plane++) {
            double sample = 0, whole = 0;
            for (int32_t c = e->first[plane]; c < e->first[plane + 1]; c++) {
                sample += quadratic(r.sample, r.weight + c * e->guides, e->guides);
                whole += quadratic(r.whole, r.weight + c * e->guides, e->guides) / area;
            }
            for (int32_t c = e->first[plane]; c < e->first[plane + 1] && sample > 0; c++)
                own[octave * e->coefficients + c] *= pow(whole / sample, trust);
        }
    }
    free_regression(&r);
    return result;
}

/* What is left to scale by, when it has been scaled by `sofar`, until there is the power that is wanted. */
static double next_gain(double wanted, double made, double *sofar)
{
    double before = *sofar;
    *sofar = made > 0 ? fmin(fmax(before * pow(wanted / made, exponent), 1 / most_gain), most_gain) : before;
    return *sofar / before;
}

pave_result pv_enlarge_sharpen(pv_enlarge *e)
{
    int32_t count = PV_OCTAVES * e->coefficients;
    pave_result result = PAVE_OK;
    double *wanted = pv_allocate(e->context, 4 * (size_t)count, sizeof *wanted, &result);
    if (result)
        return result;
    double *made = wanted + count, *gain = made + count, *sofar = gain + count;
    for (int32_t i = 0; i < count; i++)
        sofar[i] = 1;
    result = take_apart(e->context, &e->known, &(purpose){ .power = wanted });
    if (!result)
        result = adapt(e, wanted);
    for (int32_t turn = 0; turn < TURNS && !result; turn++) {
        result = take_apart(e->context, &e->made, &(purpose){ .power = made });
        for (int32_t i = 0; i < count && !result; i++)
            gain[i] = next_gain(wanted[i], made[i], sofar + i);
        if (!result)
            result = take_apart(e->context, &e->made, &(purpose){ .gains = gain });
    }
    pv_release(wanted);
    return result;
}
