/* What is between channels: covariances of their pixels, and of the magnitudes of their bands. While one channel is
 * changed the others stand still. */
#include "statistics/texture.h"

#include <math.h>
#include <string.h>

static size_t size_of(const pv_texture *t, int32_t scale)
{
    return pv_level_size(&t->steerable, scale);
}

pave_result pv_company_create(pave_context *context, const pv_statistics *like, int32_t width, int32_t height,
                              const float *planes, pv_company *out)
{
    pave_result result = PAVE_OK;
    size_t channels = (size_t)like->channels;
    *out = (pv_company){ .channels = like->channels, .size = (size_t)width * (size_t)height, .planes = planes };
    for (int32_t s = 0; s < like->settings.scales; s++)
        out->per_channel += (out->size >> 2 * s) * (size_t)like->settings.orientations;
    out->known = pv_allocate_zeroed(context, channels, 1, &result);
    if (!result && like->settings.cross > 1)
        out->magnitudes = pv_allocate(context, channels, out->per_channel * sizeof *out->magnitudes, &result);
    if (result)
        pv_company_free(out);
    return result;
}

void pv_company_free(pv_company *company)
{
    pv_release(company->known);
    pv_release(company->magnitudes);
    memset(company, 0, sizeof *company);
}

float *pv_company_magnitude(const pv_texture *texture, int32_t channel, int32_t scale, int32_t orientation)
{
    const pv_company *c = texture->company;
    size_t at = (size_t)channel * c->per_channel;
    for (int32_t s = 0; s < scale; s++)
        at += size_of(texture, s) * (size_t)texture->steerable.orientations;
    return c->magnitudes + at + size_of(texture, scale) * (size_t)orientation;
}

void pv_company_keep(const pv_texture *texture, int32_t channel)
{
    const pv_texture *t = texture;
    if (!t->company)
        return;
    t->company->known[channel] = 1;
    for (int32_t s = 0; s < t->steerable.scales && t->company->magnitudes; s++)
        for (int32_t k = 0; k < t->steerable.orientations; k++)
            memcpy(pv_company_magnitude(t, channel, s, k), t->magnitude[s][k], size_of(t, s) * sizeof(float));
}

static int is_known(const pv_company *company, int32_t other, int32_t channel)
{
    return other != channel && company->known[other];
}

static double covariance(const float *a, const float *b, size_t size)
{
    double mean_a = pv_mean(a, size), mean_b = pv_mean(b, size), sum = 0;
    for (size_t i = 0; i < size; i++)
        sum += (a[i] - mean_a) * (b[i] - mean_b);
    return sum / (double)size;
}

static void gather_magnitudes(const pv_texture *t, int32_t channel, int32_t other, pv_statistics *into)
{
    int32_t pairs = into->channels * (into->channels - 1) / 2;
    for (int32_t s = 0; s < t->steerable.scales && t->company->magnitudes; s++)
        for (int32_t k = 0; k < t->steerable.orientations; k++)
            pv_statistics_at(into, PV_CHANNEL_MAGNITUDES, 0, s)[k * pairs + pv_pair(channel, other)] =
                pv_mean_product(t->magnitude[s][k], pv_company_magnitude(t, other, s, k),
                                t->steerable.level[s].width, t->steerable.level[s].height, 0, 0);
}

void pv_company_gather(const pv_texture *texture, const float *plane, int32_t channel, pv_statistics *into)
{
    const pv_company *c = texture->company;
    for (int32_t other = 0; c && other < c->channels; other++)
        if (is_known(c, other, channel)) {
            pv_statistics_at(into, PV_CHANNELS, 0, 0)[pv_pair(channel, other)] =
                covariance(plane, c->planes + (size_t)other * c->size, c->size);
            gather_magnitudes(texture, channel, other, into);
        }
}

void pv_company_gather_change(const pv_texture *change, const float *direction, int32_t channel, pv_statistics *into)
{
    pv_company_gather(change, direction, channel, into);
}

/* The others' pixels, less their means, each times its weight. */
void pv_company_grade(const pv_texture *texture, int32_t channel, const pv_statistics *weights, float *out)
{
    const pv_company *c = texture->company;
    for (int32_t other = 0; c && other < c->channels; other++) {
        const float *plane = c->planes + (size_t)other * c->size;
        float weight = is_known(c, other, channel)
                           ? (float)pv_statistics_at(weights, PV_CHANNELS, 0, 0)[pv_pair(channel, other)] : 0;
        double mean = weight != 0 ? pv_mean(plane, c->size) : 0;
        for (size_t i = 0; i < c->size && weight != 0; i++)
            out[i] += weight * (plane[i] - (float)mean);
    }
}
