/* All statistics at once: a Gauss-Newton step, the smallest relative change of a picture that takes it, to the first
 * order, to all that is wanted. The projections in turn of impose.c undo part of each other; near the end this does
 * not. The linear least squares are solved by conjugate gradients, with nothing but gradients and changes. */
#include "statistics/texture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { LEAST_STEPS = 8, MOST_STEPS = 32, HALVINGS = 4 };

typedef struct joint {
    pv_texture *at, *change;
    const pv_statistics *wanted;
    pv_statistics *is, *product; /* those there are; weights, or what they change by */
    int32_t channel;
    size_t size;
    float *plane, *before;
    float *filter, *direction, *slope, *step; /* of the size of the plane */
    uint8_t *stopped;                         /* pixels at an end of the range that would go beyond it */
    double *norm, *left;                      /* of each statistic: what it is multiplied by, and what is missing */
} joint;

/* How strong each part of the pyramid is: a change of the strong ones is seen less. */
static pave_result find_filter(joint *j)
{
    const pv_statistics *w = j->wanted;
    int32_t scales = w->settings.scales, n = w->settings.orientations;
    double weights[PV_MOST_SCALES + 2], least = 0;
    weights[0] = *pv_statistics_at(w, PV_HIGH, j->channel, 0);
    weights[scales + 1] = pv_statistics_at(w, PV_LOW_CORRELATION, j->channel, scales)[0];
    for (int32_t s = 0; s < scales; s++) {
        const double *mean = pv_statistics_at(w, PV_MAGNITUDE, j->channel, s);
        const double *variance = pv_statistics_at(w, PV_MAGNITUDE_CORRELATION, j->channel, s);
        weights[1 + s] = 0;
        for (int32_t k = 0; k < n; k++)
            weights[1 + s] += (mean[k] * mean[k] + variance[k * pv_lags(w->reach[s])]) / 2;
        least = fmax(least, 1e-6 * weights[1 + s]);
    }
    for (int32_t i = 0; i < scales + 2; i++)
        weights[i] = fmax(weights[i], least);
    return pv_steerable_spread(j->at->context, &j->at->steerable, weights, j->filter);
}

static pave_result apply_filter(joint *j, const float *in, float *out)
{
    pv_complex *room = j->change->room[0];
    const pv_fourier *fourier = &j->at->steerable.level[0].fourier;
    for (size_t i = 0; i < j->size; i++)
        room[i] = (pv_complex){ j->stopped[i] ? 0 : in[i], 0 };
    pave_result result = pv_fourier_forth(j->at->context, fourier, 1, &room);
    for (size_t i = 0; i < j->size && !result; i++)
        room[i].r *= j->filter[i], room[i].i *= j->filter[i];
    if (!result)
        result = pv_fourier_back(j->at->context, fourier, 1, &room);
    for (size_t i = 0; i < j->size && !result; i++)
        out[i] = j->stopped[i] ? 0 : room[i].r;
    return result;
}

/* Does the channel have a part in a statistic? The mean and the ends of the range are imposed by themselves. */
static int takes_part(const joint *j, const pv_stretch *s, int32_t k)
{
    int32_t channels = j->wanted->channels, pair = k % (channels > 1 ? channels * (channels - 1) / 2 : 1);
    if (s->group < PV_CHANNELS)
        return s->channel == j->channel && (s->group != PV_PIXELS || k == 1);
    for (int32_t other = 0; other < channels; other++)
        if (other != j->channel && pair == pv_pair(other, j->channel))
            return 1;
    return 0;
}

static void find_norms(joint *j)
{
    for (int32_t i = 0; i < j->wanted->stretch_count; i++) {
        const pv_stretch *s = &j->wanted->stretches[i];
        double norm = pv_statistics_norm(j->wanted, s);
        for (int32_t k = 0; k < s->count; k++)
            j->norm[s->first + k] = takes_part(j, s, k) ? 1 / norm : 0;
    }
}

static double square_sum(const double *values, int32_t count)
{
    double sum = 0;
    for (int32_t i = 0; i < count; i++)
        sum += values[i] * values[i];
    return sum;
}

/* What is missing, of the plane as it is, and the sum of its squares. */
static pave_result look(joint *j, double *sum)
{
    pave_result result = pv_texture_analyse(j->at, j->plane);
    if (!result)
        result = pv_texture_gather(j->at, j->plane, j->channel, j->is);
    for (int32_t i = 0; i < j->wanted->count && !result; i++)
        j->left[i] = (j->wanted->values[i] - j->is->values[i]) * j->norm[i];
    *sum = result ? 0 : square_sum(j->left, j->wanted->count);
    return result;
}

/* The slope of what is left, and the smallest relative change in its direction; their product. */
static pave_result find_slope(joint *j, double *power)
{
    for (int32_t i = 0; i < j->wanted->count; i++)
        j->product->values[i] = j->left[i] * j->norm[i];
    pave_result result = pv_texture_gradient(j->at, j->plane, j->channel, j->product->values, j->change, j->slope);
    float *raw = j->change->low[0];
    if (!result) {
        memcpy(raw, j->slope, j->size * sizeof *raw);
        result = apply_filter(j, raw, j->slope);
    }
    *power = result ? 0 : pv_mean_product(raw, j->slope, (int32_t)j->size, 1, 0, 0);
    return result;
}

/* One step along the direction: as far as it is good for what is left. */
static pave_result follow(joint *j, double power)
{
    pave_result result = pv_texture_differentiate(j->at, j->direction, j->change);
    if (!result)
        result = pv_texture_gather_change(j->at, j->change, j->plane, j->direction, j->channel, j->product);
    double sum = 0;
    for (int32_t i = 0; i < j->wanted->count && !result; i++)
        sum += j->product->values[i] * j->norm[i] * j->product->values[i] * j->norm[i];
    double length = sum > 0 ? power / sum : 0;
    for (int32_t i = 0; i < j->wanted->count && !result; i++)
        j->left[i] -= length * j->product->values[i] * j->norm[i];
    for (size_t k = 0; k < j->size && !result; k++)
        j->step[k] += (float)length * j->direction[k];
    return result;
}

/* Those that the slope would carry beyond the range stand still. Are there any? */
static int stop_pixels(joint *j)
{
    const double *pixels = pv_statistics_at(j->wanted, PV_PIXELS, j->channel, 0);
    float least = (float)pixels[2], greatest = (float)pixels[3];
    int any = 0;
    for (size_t i = 0; i < j->size; i++) {
        j->stopped[i] = (j->plane[i] <= least && j->slope[i] < 0) || (j->plane[i] >= greatest && j->slope[i] > 0);
        any |= j->stopped[i];
    }
    return any;
}

static pave_result conjugate_gradients(joint *j, int32_t steps)
{
    double power = 0, before;
    memset(j->stopped, 0, j->size);
    pave_result result = find_slope(j, &power);
    if (!result && stop_pixels(j))
        result = find_slope(j, &power);
    memcpy(j->direction, j->slope, j->size * sizeof *j->direction);
    memset(j->step, 0, j->size * sizeof *j->step);
    for (int32_t i = 0; i < steps && power > 0 && !result; i++) {
        result = follow(j, power);
        before = power;
        if (!result && i + 1 < steps)
            result = find_slope(j, &power);
        for (size_t k = 0; k < j->size && !result; k++)
            j->direction[k] = j->slope[k] + (float)(power / before) * j->direction[k];
    }
    return result;
}

/* The whole step, or, where the statistics bend too much for it, a half or a quarter. */
static pave_result take_step(joint *j, double was, double *now)
{
    const double *pixels = pv_statistics_at(j->wanted, PV_PIXELS, j->channel, 0);
    double share = 1, is = was;
    pave_result result = PAVE_OK;
    memcpy(j->before, j->plane, j->size * sizeof *j->plane);
    for (int32_t i = 0; i < HALVINGS && is >= was && !result; i++, share /= 2) {
        for (size_t k = 0; k < j->size; k++)
            j->plane[k] = j->before[k] + (float)share * j->step[k];
        pv_impose_range(j->plane, j->size, pixels[0], pixels[2], pixels[3]);
        result = look(j, &is);
    }
    if (!result && is >= was) {
        memcpy(j->plane, j->before, j->size * sizeof *j->plane);
        result = look(j, &is);
    }
    *now = is;
    return result;
}

/* More conjugate gradients go farther: as long as that much farther is still where they think it is. */
static int32_t choose_steps(int32_t steps, double was, double told, double is)
{
    double kept = was > told ? (was - is) / (was - told) : 1;
    steps = kept < 0.25 ? steps * 2 / 3 : kept > 0.5 ? steps * 3 / 2 : steps;
    return steps < LEAST_STEPS ? LEAST_STEPS : steps > MOST_STEPS ? MOST_STEPS : steps;
}

static pave_result make_room(joint *j, float **planes, double **numbers)
{
    pave_result result = PAVE_OK;
    size_t n = j->size, count = (size_t)j->wanted->count;
    *planes = pv_allocate(j->at->context, 5 * n, sizeof **planes, &result);
    j->stopped = result ? NULL : pv_allocate(j->at->context, n, 1, &result);
    *numbers = result ? NULL : pv_allocate(j->at->context, 2 * count, sizeof **numbers, &result);
    if (result)
        return result;
    j->filter = *planes, j->direction = *planes + n, j->slope = *planes + 2 * n, j->step = *planes + 3 * n;
    j->before = *planes + 4 * n, j->norm = *numbers, j->left = *numbers + count;
    return pv_statistics_create_like(j->at->context, j->wanted, &j->product);
}

pave_result pv_texture_approach(pv_texture *at, pv_texture *change, const pv_statistics *wanted, int32_t channel,
                                float *plane, int32_t *steps, pv_statistics *is)
{
    joint j = { .at = at, .change = change, .wanted = wanted, .is = is, .channel = channel, .plane = plane,
                .size = pv_level_size(&at->steerable, 0) };
    float *planes = NULL;
    double *numbers = NULL, was = 0, is_now = 0;
    pave_result result = make_room(&j, &planes, &numbers);
    if (!result)
        result = find_filter(&j);
    if (!result) {
        find_norms(&j);
        result = look(&j, &was);
    }
    if (!result && was > 0)
        result = conjugate_gradients(&j, *steps);
    double told = result ? 0 : square_sum(j.left, wanted->count);
    if (!result && was > 0)
        result = take_step(&j, was, &is_now);
    if (!result && was > 0)
        *steps = choose_steps(*steps, was, told, is_now);
    if (!result)
        pv_company_keep(at, channel);
    pv_release(j.stopped);
    pv_statistics_free(j.product);
    pv_release(planes);
    pv_release(numbers);
    return result;
}
