/* Octaves of coefficients: differences of ever smoother copies (a trous, Holschneider et al. 1989), which add up to the
 * whole again. */
#include "btf/enlarge.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

static const double most_gain = 4;

/* Octaves overlap: scaling one changes what its neighbours measure. */
enum { TURNS = 6 };

/* A field while it is taken apart: what is left, and what is next. */
typedef struct apart {
    const pv_texels *shape;
    int32_t gap; /* between the texels that are averaged */
    float *now, *rows, *next;
    float *sum;          /* octaves times their gains; NULL: none */
    const double *gain;  /* [channel] */
    double *power;       /* [row][channel], of the octave */
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
        }
    }
}

/* `power`, [octave][channel], gets mean squares; with `gains`, alike, octaves are scaled by them. */
static pave_result take_apart(pave_context *context, pv_texels *t, const double *gains, double *power)
{
    pave_result result = PAVE_OK;
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
    for (int32_t o = 0; o < PV_OCTAVES && !result; o++) {
        float *swap = a.now;
        a.gap = 1 << o;
        a.gain = gains ? gains + (int64_t)o * t->channels : NULL;
        result = pv_parallel(context, t->height, smooth_row, &a, 0, 0);
        if (!result)
            result = pv_parallel(context, t->height, take_octave, &a, 0, 0);
        if (!result && power)
            result = pv_parallel(context, t->height, measure_row, &a, 0, 0);
        for (int32_t c = 0; c < t->channels && power && !result; c++) {
            power[o * t->channels + c] = 0;
            for (int32_t y = 0; y < t->height; y++)
                power[o * t->channels + c] += a.power[(int64_t)y * t->channels + c] / (double)texels;
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
    pv_texels known = e->known, whole = e->made;
    pave_result result = take_apart(e->context, &known, NULL, own);
    return result ? result : take_apart(e->context, &whole, NULL, made);
}

/* The sample may be rougher or smoother than the rest: by how much, the photographs tell for each plane, though one
 * alone tells half of it at best. */
static pave_result adapt(const pv_enlarge *e, double *own)
{
    double trust = e->guides / (double)(e->guides + e->planes);
    pv_texels seen = e->seen, given = e->given;
    int32_t count = PV_OCTAVES * e->guides;
    pave_result result = PAVE_OK;
    double *power = pv_allocate(e->context, 2 * (size_t)count, sizeof *power, &result);
    if (!result)
        result = take_apart(e->context, &seen, NULL, power);
    if (!result)
        result = take_apart(e->context, &given, NULL, power + count);
    for (int32_t i = 0; i < PV_OCTAVES * e->planes && !result; i++) {
        int32_t octave = i / e->planes, plane = i % e->planes;
        double sample = 0, whole = 0;
        for (int32_t g = plane; g < e->guides; g += e->planes) {
            sample += power[octave * e->guides + g];
            whole += power[count + octave * e->guides + g];
        }
        for (int32_t c = e->first[plane]; c < e->first[plane + 1] && sample > 0; c++)
            own[octave * e->coefficients + c] *= pow(whole / sample, trust);
    }
    pv_release(power);
    return result;
}

/* What is left to scale by, when it has been scaled by `sofar`, until there is the power that is wanted. */
static double next_gain(double wanted, double made, double *sofar)
{
    double before = *sofar;
    *sofar = made > 0 ? fmin(fmax(before * sqrt(wanted / made), 1 / most_gain), most_gain) : before;
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
    result = pv_enlarge_octaves(e, wanted, made);
    if (!result)
        result = adapt(e, wanted);
    for (int32_t turn = 0; turn < TURNS && !result; turn++) {
        for (int32_t i = 0; i < count; i++)
            gain[i] = next_gain(wanted[i], made[i], sofar + i);
        result = take_apart(e->context, &e->made, gain, NULL);
        if (!result)
            result = take_apart(e->context, &e->made, NULL, made);
    }
    pv_release(wanted);
    return result;
}
