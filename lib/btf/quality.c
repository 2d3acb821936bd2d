/* How an enlargement came out, as far as that can be told without the truth. */
#include "btf/enlarge.h"

#include <math.h>
#include <string.h>

enum { JUDGED = 4 };

static const double least_roughness = 1e-6;

/* Mean square difference of neighbours, all coefficients together: that of all textures, for eigen-ABRDFs are
 * orthonormal. */
static double roughness(const pv_texels *t)
{
    double sum = 0;
    int64_t n = t->channels, wide = (int64_t)t->width * n, count = 0;
    for (int64_t y = 0; y + 1 < t->height; y++)
        for (int64_t x = 0; x + 1 < t->width; x++, count++) {
            const float *a = t->values + y * wide + x * n;
            for (int64_t k = 0; k < n; k++) {
                double right = (double)a[k + n] - (double)a[k], down = (double)a[k + wide] - (double)a[k];
                sum += right * right + down * down;
            }
        }
    return count ? sum / (double)count : 0;
}

static double mean_square(const pv_texels *t)
{
    double sum = 0;
    int64_t count = pv_texels_count(t) * t->channels;
    for (int64_t i = 0; i < count; i++)
        sum += (double)t->values[i] * (double)t->values[i];
    return sum * t->channels / (double)count;
}

/* All coefficients together, octave by octave. */
static pave_result spectrum_distance(const pv_enlarge *e, double *out)
{
    int32_t count = PV_OCTAVES * e->coefficients;
    double sum = 0;
    pave_result result = PAVE_OK;
    double *own = pv_allocate(e->context, 2 * (size_t)count, sizeof *own, &result), *made = own;
    if (!result)
        result = pv_enlarge_octaves(e, own, made += count);
    for (int32_t o = 0; o < PV_OCTAVES && !result; o++) {
        double a = 0, b = 0;
        for (int32_t k = o * e->coefficients; k < (o + 1) * e->coefficients; k++) {
            a += own[k];
            b += made[k];
        }
        sum += a > 0 && b > 0 ? log(b / a) * log(b / a) : 0;
    }
    *out = sqrt(sum / PV_OCTAVES);
    pv_release(own);
    return result;
}

/* As many scales as the sample allows, for it and for the whole. */
pave_result pv_enlarge_statistics(const pv_enlarge *e, const pv_texels *t, int32_t channels, pv_statistics **out)
{
    pv_statistics_settings settings = { 4, 4, 7, 0 };
    int32_t side = e->known.width < e->known.height ? e->known.width : e->known.height;
    int64_t count = pv_texels_count(t);
    pave_result result = PAVE_OK;
    while (settings.scales > 1 && side < 4 << settings.scales)
        settings.scales--;
    float *planes = pv_allocate(e->context, (size_t)count, (size_t)channels * sizeof *planes, &result);
    for (int64_t i = 0; i < count * channels && !result; i++)
        planes[i] = t->values[i % count * t->channels + i / count];
    if (!result)
        result = pv_statistics_measure(e->context, t->width, t->height, channels, planes, &settings, out);
    pv_release(planes);
    return result;
}

static pave_result statistics_distance(const pv_enlarge *e, double *out)
{
    pv_statistics *own = NULL, *made = NULL;
    int32_t channels = e->first[1] < JUDGED ? e->first[1] : JUDGED;
    pave_result result = pv_enlarge_statistics(e, &e->known, channels, &own);
    if (!result)
        result = pv_enlarge_statistics(e, &e->made, channels, &made);
    if (!result)
        *out = pv_statistics_distance(made, own);
    pv_statistics_free(own);
    pv_statistics_free(made);
    return result;
}

/* Root mean square of what the photographs show and the result does not. */
static double photographs_missed(const pv_enlarge *e)
{
    double sum = 0;
    for (int64_t t = 0; t < pv_texels_count(&e->made); t++)
        for (int32_t g = 0; g < e->guides; g++) {
            const pv_guide *guide = &e->guide[g];
            const float *x = e->made.values + t * e->coefficients + e->first[guide->plane];
            double missed = (double)e->given.values[t * e->guides + g] - guide->offset;
            for (int32_t k = 0; k < e->first[guide->plane + 1] - e->first[guide->plane]; k++)
                missed -= (double)guide->row[k] * (double)x[k];
            sum += missed * missed;
        }
    return sqrt(sum / ((double)pv_texels_count(&e->made) * e->guides));
}

/* What the components leave of the sample, mean square over all its values. */
static double left_by_components(const pv_enlarge *e)
{
    double sum = 0, rows = (double)pv_btf_rows(e->out) * (double)pv_texels_count(&e->known);
    for (int32_t c = 0; c < e->planes; c++) {
        const pv_factors *f = &e->out->factors[c];
        double kept = 0, share = f->error * f->error;
        for (int32_t k = 0; k < f->components; k++)
            kept += (double)f->singular[k] * (double)f->singular[k];
        sum += share < 1 ? kept * share / (1 - share) / rows / e->planes : 0;
    }
    return sum;
}

pave_result pv_enlarge_judge(const pv_enlarge *e, pave_btf_enlargement *report)
{
    pave_btf_enlargement found = { 0 };
    double own = roughness(&e->known), missed = 0;
    double rows = (double)pv_btf_rows(e->out) * e->planes;
    for (int32_t k = 0; k < e->coefficients; k++)
        missed += e->spread[(int64_t)k * e->coefficients + k] / rows;
    found.photographs = e->guides / e->planes;
    found.rounds = e->rounds;
    found.least = sqrt(left_by_components(e));
    found.explained = e->left > 0 ? 1 - e->left : 0;
    found.expected = e->left > 0 ? sqrt(missed + found.least * found.least) : 0;
    found.missed = photographs_missed(e);
    pave_result result = PAVE_OK;
    if (own > least_roughness * mean_square(&e->known)) { /* of a plain sample nothing can be told */
        found.sharpness = roughness(&e->made) / own;
        result = spectrum_distance(e, &found.spectrum);
        if (!result)
            result = statistics_distance(e, &found.statistics);
    }
    size_t size = report->size;
    memcpy(report, &found, size < sizeof found ? size : sizeof found);
    report->size = size;
    return result;
}
