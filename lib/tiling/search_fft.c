/* Search: all differences at once by Fourier transforms. A difference is the sum of the block's squares, less twice its
 * correlation with the exemplar, plus the correlation of what counts with the exemplar's squares. Floating point only
 * tells which places cannot be the least; whole numbers decide among the others. */
#include "tiling/search.h"

#include "image/fft.h"

#include <math.h>
#include <string.h>

struct pv_spectra {
    pave_context *context;
    const pv_bank *bank;
    const pv_sheet *sheet;
    pv_fft fft;
    pv_complex *exemplar; /* depth + 1 spectra: values less half of white, and their squares' sum */
    double *norm;         /* of those planes */
    float *plane;
    pv_complex *one, *sum;
};

void pv_spectra_free(pv_spectra *s)
{
    if (!s)
        return;
    pv_fft_free(&s->fft);
    pv_release(s->exemplar);
    pv_release(s->norm);
    pv_release(s->plane);
    pv_release(s->one);
    pv_release(s->sum);
    pv_release(s);
}

static double centred(const pv_spectra *s, int16_t value)
{
    return value - s->bank->white / 2;
}

/* Channel k of a pixel's values, or for k = depth the sum of their squares. */
static float plane_value(const pv_spectra *s, const int16_t *value, int32_t k)
{
    double sum = 0;
    if (k < s->bank->depth)
        return (float)centred(s, value[k]);
    for (int32_t c = 0; c < s->bank->depth; c++)
        sum += centred(s, value[c]) * centred(s, value[c]);
    return (float)sum;
}

static double norm_of(const pv_spectra *s)
{
    double sum = 0;
    for (size_t i = 0; i < pv_fft_reals(&s->fft); i++)
        sum += (double)s->plane[i] * s->plane[i];
    return sqrt(sum);
}

static void transform_sheet(pv_spectra *s)
{
    for (int32_t k = 0; k <= s->bank->depth; k++) {
        memset(s->plane, 0, pv_fft_reals(&s->fft) * sizeof *s->plane);
        for (int32_t y = 0; y < s->sheet->height; y++)
            for (int32_t x = 0; x < s->sheet->width; x++) {
                int64_t place = s->sheet->first + (int64_t)y * s->bank->stride + x;
                s->plane[(size_t)y * (size_t)s->fft.width + (size_t)x] =
                    plane_value(s, s->bank->values + place * s->bank->depth, k);
            }
        s->norm[k] = norm_of(s);
        pv_fft_forth(&s->fft, s->plane, s->exemplar + (size_t)k * pv_fft_halves(&s->fft));
    }
}

pave_result pv_spectra_create(pave_context *context, const pv_bank *bank, const pv_sheet *sheet, pv_spectra **out)
{
    pave_result result = PAVE_OK;
    pv_spectra *s = *out = pv_allocate_zeroed(context, 1, sizeof *s, &result);
    if (!s)
        return result;
    *s = (pv_spectra){ .context = context, .bank = bank, .sheet = sheet };
    size_t planes = (size_t)bank->depth + 1;
    result = pv_fft_create(context, sheet->width, sheet->height, &s->fft);
    if (!result)
        s->exemplar = pv_allocate(context, planes * pv_fft_halves(&s->fft), sizeof *s->exemplar, &result);
    if (!result)
        s->norm = pv_allocate(context, planes, sizeof *s->norm, &result);
    if (!result)
        s->plane = pv_allocate(context, pv_fft_reals(&s->fft), sizeof *s->plane, &result);
    if (!result)
        s->one = pv_allocate(context, pv_fft_halves(&s->fft), sizeof *s->one, &result);
    if (!result)
        s->sum = pv_allocate(context, pv_fft_halves(&s->fft), sizeof *s->sum, &result);
    if (!result) {
        transform_sheet(s);
        return PAVE_OK;
    }
    pv_spectra_free(s);
    *out = NULL;
    return result;
}

/* Adds the correlation of the query's plane k: its values where they count, or for k = depth ones. */
static double add_correlation(pv_spectra *s, const pv_query *query, int32_t k)
{
    int32_t depth = s->bank->depth;
    const pv_complex *exemplar = s->exemplar + (size_t)k * pv_fft_halves(&s->fft);
    memset(s->plane, 0, pv_fft_reals(&s->fft) * sizeof *s->plane);
    for (int32_t i = 0; i < query->width * query->height; i++)
        if (query->counts[i])
            s->plane[(size_t)(i / query->width) * (size_t)s->fft.width + (size_t)(i % query->width)] =
                k < depth ? -2 * plane_value(s, query->value + (int64_t)i * depth, k) : 1;
    pv_fft_forth(&s->fft, s->plane, s->one);
    for (size_t i = 0; i < pv_fft_halves(&s->fft); i++) {
        s->sum[i].r += s->one[i].r * exemplar[i].r + s->one[i].i * exemplar[i].i;
        s->sum[i].i += s->one[i].r * exemplar[i].i - s->one[i].i * exemplar[i].r;
    }
    return norm_of(s) * s->norm[k];
}

/* The correlations at all places go to the plane, scaled. Returns how far they may be off: every transform of n numbers
 * is within 8 log2(n) roundings of its norm, and a correlation is no greater than the product of the norms. */
static double correlate(pv_spectra *s, const pv_query *query)
{
    double n = (double)pv_fft_reals(&s->fft), norms = 0;
    memset(s->sum, 0, pv_fft_halves(&s->fft) * sizeof *s->sum);
    for (int32_t k = 0; k <= s->bank->depth; k++)
        norms += add_correlation(s, query, k);
    pv_fft_back(&s->fft, s->sum, s->plane);
    for (size_t i = 0; i < pv_fft_reals(&s->fft); i++)
        s->plane[i] = (float)(s->plane[i] / n);
    return ldexp(8.0 * (log2(n) + 4), -24) * (2 * norms + norm_of(s)) + 1;
}

static double query_squares(const pv_spectra *s, const pv_query *query)
{
    double sum = 0;
    for (int32_t i = 0; i < query->width * query->height; i++)
        sum += query->counts[i] ? plane_value(s, query->value + (int64_t)i * s->bank->depth, s->bank->depth) : 0;
    return sum;
}

typedef struct spectral { pv_spectra *s; const pv_query *query; pv_places places; double squares; } spectral;

static double told(const spectral *w, int32_t k, int32_t *place)
{
    int32_t x = k % w->places.across, y = k / w->places.across;
    *place = w->places.sheet->first + y * w->s->bank->stride + x;
    return w->squares + w->s->plane[(size_t)y * (size_t)w->s->fft.width + (size_t)x];
}

/* The place that seems the least bounds it; whatever may be as little is then compared exactly. */
pave_result pv_spectra_least(pv_spectra *s, const pv_query *query, int32_t *place, int64_t *difference)
{
    spectral w = { s, query, pv_places_all(s->sheet, query->width, query->height), query_squares(s, query) };
    double off = correlate(s, query), seems = INFINITY;
    pv_compare *compare = pv_compare_choose(PAVE_SEARCH_AUTO);
    int32_t n = w.places.across * w.places.down, at, first = -1;
    for (int32_t k = 0; k < n; k++) {
        double about = told(&w, k, &at);
        if (about < seems && pv_bank_clear(s->bank, at, query->width, query->height))
            seems = about, first = at;
    }
    if (first < 0)
        return PAVE_OK;
    double bound = (double)compare(query, first, PV_NO_PLACE);
    for (int32_t k = 0; k < n; k++) {
        double about = told(&w, k, &at);
        if (about - off > bound || !pv_bank_clear(s->bank, at, query->width, query->height))
            continue;
        int64_t cost = compare(query, at, *difference);
        if (cost < *difference)
            *difference = cost, *place = at;
        bound = (double)cost < bound ? (double)cost : bound;
    }
    return pv_progress(s->context, 0);
}
