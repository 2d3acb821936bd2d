/* A regression, and windows of the sample put together anew beside it: as much of the latter as would have served where
 * parts of the sample were made from the rest. */
#include "btf/enlarge.h"

#include <math.h>
#include <string.h>

/* What the photographs weigh for windows. */
static const double balance = 10;

static pave_result put_together(pv_enlarge *e, double from, double to)
{
    return pv_enlarge_optimize(e, 1, balance * e->params->balance, from, to);
}

/* ---- Parts of the sample from the rest ---- */

static pave_result columns(pave_context *context, const pv_texels *t, int32_t left, int32_t count, pv_texels *out)
{
    pave_result result = pv_texels_new(context, count, t->height, t->channels, out);
    for (int64_t y = 0; y < t->height && !result; y++)
        memcpy(out->values + y * count * t->channels, t->values + (y * t->width + left) * t->channels,
               (size_t)count * (size_t)t->channels * sizeof(float));
    return result;
}

/* So many columns at the left or the right end of the sample, from windows of what is left of it. */
static pave_result make_end(const pv_enlarge *e, int32_t wide, int right, float *made, double from, double to)
{
    pv_enlarge part = *e;
    int32_t rest = e->known.width - wide, n = e->coefficients, left = right ? rest : 0;
    part.known = part.seen = part.given = part.made = (pv_texels){ 0 };
    pave_result result = columns(e->context, &e->known, right ? 0 : wide, rest, &part.known);
    if (!result)
        result = columns(e->context, &e->seen, right ? 0 : wide, rest, &part.seen);
    if (!result)
        result = columns(e->context, &e->seen, left, wide, &part.given);
    if (!result)
        result = pv_texels_new(e->context, wide, e->known.height, n, &part.made);
    if (!result)
        result = put_together(&part, from, to);
    for (int64_t y = 0; y < e->known.height && !result; y++)
        memcpy(made + (y * e->known.width + left) * n, part.made.values + y * wide * n,
               (size_t)wide * (size_t)n * sizeof *made);
    pv_release(part.known.values);
    pv_release(part.seen.values);
    pv_release(part.given.values);
    pv_release(part.made.values);
    return result;
}

/* Of what was held out, just the columns at both ends. */
static void keep_ends(const pv_enlarge *e, int32_t wide, pv_held_out *held)
{
    int64_t kept = 0, n = e->coefficients;
    for (int64_t i = 0; i < held->count; i++) {
        int64_t x = held->texel[i] % e->known.width;
        if (x >= wide && x < e->known.width - wide)
            continue;
        held->texel[kept] = held->texel[i];
        memmove(held->missed + kept++ * n, held->missed + i * n, (size_t)n * sizeof *held->missed);
    }
    held->count = kept;
}

double pv_enlarge_share(const pv_enlarge *e, const float *made)
{
    double agree = 0, apart = 0;
    int64_t n = e->coefficients;
    for (int64_t i = 0; i < e->held.count * n; i++) {
        int64_t at = e->held.texel[i / n] * n + i % n;
        double missed = (double)e->held.missed[i], other = (double)made[at] - (double)e->known.values[at] - missed;
        agree -= missed * other;
        apart += other * other;
    }
    return apart > 0 ? fmin(fmax(agree / apart, 0), 1) : 0;
}

static pave_result learn_share(pv_enlarge *e, double *share, double from, double to)
{
    pave_result result = PAVE_OK;
    int32_t quarter = e->known.width / 4, side = e->params->neighbourhood, wide = quarter > side ? quarter : side;
    float *made = pv_allocate(e->context, (size_t)pv_texels_count(&e->known), (size_t)e->coefficients * sizeof *made,
                              &result);
    if (!result)
        result = make_end(e, wide, 0, made, from, (from + to) / 2);
    if (!result)
        result = make_end(e, wide, 1, made, (from + to) / 2, to);
    if (!result) {
        keep_ends(e, wide, &e->held);
        *share = pv_enlarge_share(e, made);
    }
    pv_release(made);
    return result;
}

/* ---- The whole ---- */

/* Of the sample's variance, what is missed where texels are held out. */
static double left_over(const pv_enlarge *e)
{
    double missed = 0, own = 0;
    int64_t n = e->coefficients;
    for (int64_t i = 0; i < e->held.count * n; i++)
        missed += (double)e->held.missed[i] * (double)e->held.missed[i] / (double)e->held.count;
    for (int64_t k = 0; k < n; k++)
        own += e->spread[k * n + k];
    return own > 0 ? missed / own : 0;
}

pave_result pv_enlarge_mix(pv_enlarge *e)
{
    int64_t count = pv_texels_count(&e->made) * e->coefficients;
    double share = 0;
    pave_result result = pv_enlarge_predict(e, 0.2, 0.6);
    float *predicted = result ? NULL : pv_allocate(e->context, (size_t)count, sizeof *predicted, &result);
    if (!result) {
        e->left = left_over(e);
        memcpy(predicted, e->made.values, (size_t)count * sizeof *predicted);
        result = learn_share(e, &share, 0.6, 0.65);
    }
    if (!result && share > 0)
        result = put_together(e, 0.65, 0.95);
    for (int64_t i = 0; i < count && !result && share > 0; i++)
        e->made.values[i] = (float)(share * (double)e->made.values[i] + (1 - share) * (double)predicted[i]);
    pv_release(predicted);
    return result;
}
