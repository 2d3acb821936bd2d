/* What a stone is judged by, against its sample: histogram, two-point statistics, texture of slices, flaws. */
#include "solid/exemplar.h"

#include "util/random.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Grey levels, 0..255, of an image or a volume, and what of it counts. */
typedef struct plane3 {
    int32_t size[3];
    int64_t count;
    float *grey;
    const uint8_t *state; /* NULL: all */
    uint8_t *phase;
} plane3;

enum { LAGS = 12, ISOTROPY_LAGS = 8, QUANTILES = 513, PATCHES = 4000, DIRECTIONS = 64, SIDE = 5, TAPS = SIDE * SIDE };

static int counts(const plane3 *p, int64_t i)
{
    return !p->state || p->state[i] >= PAVE_VOXEL_MEASURED;
}

static double full_of(int32_t type)
{
    return type == PAVE_U8 ? 255 : type == PAVE_U16 ? 65535 : 1;
}

static float mean_grey(const void *values, int32_t type, int64_t first, int32_t channels)
{
    double sum = 0;
    for (int32_t c = 0; c < channels; c++)
        sum += pv_volume_stored(values, type, first + c);
    return (float)(sum / channels * 255 / full_of(type));
}

static pave_result open_planes(pave_context *context, plane3 *p)
{
    pave_result result = PAVE_OK;
    p->count = (int64_t)p->size[0] * p->size[1] * p->size[2];
    p->grey = pv_allocate(context, (size_t)p->count, sizeof *p->grey, &result);
    if (p->grey)
        p->phase = pv_allocate(context, (size_t)p->count, 1, &result);
    return p->phase ? PAVE_OK : result;
}

static void close_planes(plane3 *p)
{
    pv_release(p->grey);
    pv_release(p->phase);
}

static pave_result open_sample(pave_context *context, const pave_image *image, plane3 *p)
{
    *p = (plane3){ .size = { image->width, image->height, 1 } };
    pave_result result = open_planes(context, p);
    int32_t channels = image->channels - (image->alpha >= 0);
    for (int64_t i = 0; i < p->count && !result; i++) {
        double sum = 0;
        for (int32_t c = 0; c < image->channels; c++)
            sum += c == image->alpha ? 0 : pv_image_value(image, i * image->channels + c);
        p->grey[i] = (float)(sum / channels * 255);
    }
    return result;
}

static pave_result open_volume(pave_context *context, const pave_volume *v, plane3 *p)
{
    *p = (plane3){ .size = { v->size[0], v->size[1], v->size[2] }, .state = v->states };
    pave_result result = open_planes(context, p);
    for (int64_t i = 0; i < p->count && !result; i++)
        p->grey[i] = mean_grey(v->values, v->type, i * v->channels, v->channels);
    return result;
}

static double otsu(const plane3 *p)
{
    double h[256] = { 0 }, w = 0, mu = 0, mean = 0, best = -1;
    int cut = 0;
    for (int64_t i = 0; i < p->count; i++)
        h[(int)floor(fmin(fmax(p->grey[i], 0), 255) + 0.5)] += 1.0 / (double)p->count;
    for (int i = 0; i < 256; i++)
        mean += h[i] * i;
    for (int i = 0; i < 256; i++) {
        w += h[i];
        mu += h[i] * i;
        double s = w > 0 && w < 1 ? (mean * w - mu) * (mean * w - mu) / (w * (1 - w)) : -1;
        if (s > best)
            best = s, cut = i;
    }
    return cut + 0.5;
}

static double set_phase(plane3 *p, double cut)
{
    int64_t above = 0, all = 0;
    for (int64_t i = 0; i < p->count; i++) {
        p->phase[i] = counts(p, i) && p->grey[i] > cut;
        above += p->phase[i];
        all += counts(p, i);
    }
    return all ? (double)above / (double)all : 0;
}

/* Over all pairs of voxels `lag` apart along an axis: how many there are, and what is made of them. */
typedef struct pairs {
    double count, both, difference, sum_a, sum_b, sum_aa, sum_bb, sum_ab;
} pairs;

static pairs pair_up(const plane3 *p, int axis, int32_t lag)
{
    const int64_t along[3] = { 1, p->size[0], (int64_t)p->size[0] * p->size[1] };
    pairs q = { 0 };
    for (int64_t i = 0; i < p->count; i++) {
        int32_t at = (int32_t)(i / along[axis] % p->size[axis]);
        int64_t j = i + lag * along[axis];
        if (at + lag >= p->size[axis] || !counts(p, i) || !counts(p, j))
            continue;
        double a = p->grey[i], b = p->grey[j];
        q.count++;
        q.both += p->phase[i] && p->phase[j];
        q.difference += fabs(a - b);
        q.sum_a += a, q.sum_b += b, q.sum_aa += a * a, q.sum_bb += b * b, q.sum_ab += a * b;
    }
    return q;
}

static double correlation(const pairs *q)
{
    double ab = q->sum_ab - q->sum_a * q->sum_b / q->count, aa = q->sum_aa - q->sum_a * q->sum_a / q->count;
    double bb = q->sum_bb - q->sum_b * q->sum_b / q->count;
    return aa > 0 && bb > 0 ? ab / sqrt(aa * bb) : 0;
}

static double two_point(const pairs *q)
{
    return q->count ? q->both / q->count : 0;
}

static void measure_pairs(const plane3 *sample, const plane3 *stone, double phi_e, double phi_v, pave_solid_measure *m)
{
    double s2 = 0, cov = 0, sharp = 0, sharp_ref = 0;
    int32_t least = stone->size[0] < stone->size[1] ? stone->size[0] : stone->size[1], lags = 0;
    least = stone->size[2] < least ? stone->size[2] : least;
    for (int32_t lag = 1; lag <= LAGS && (lag < least / 2 || lag == 1); lag++, lags++) {
        double ref = 0, mean = 0, s[3];
        for (int a = 0; a < 3; a++) {
            pairs q = pair_up(stone, a, lag), r = a < 2 ? pair_up(sample, a, lag) : q;
            ref += a < 2 ? two_point(&r) / 2 : 0;
            s[a] = two_point(&q);
            mean += s[a] / 3;
            if (lag > 1)
                continue;
            m->correlation[a] = q.count ? correlation(&q) : 0;
            m->correlation_reference += a < 2 ? correlation(&r) / 2 : 0;
            sharp += q.count ? q.difference / q.count / 3 : 0;
            sharp_ref += a < 2 ? r.difference / r.count / 2 : 0;
        }
        for (int a = 0; a < 3 && lag <= ISOTROPY_LAGS; a++)
            m->isotropy = fmax(m->isotropy, fabs(s[a] - s[(a + 1) % 3]));
        double n_v = (mean - phi_v * phi_v) / fmax(phi_v - phi_v * phi_v, 1e-9);
        double n_e = (ref - phi_e * phi_e) / fmax(phi_e - phi_e * phi_e, 1e-9);
        s2 += (mean - ref) * (mean - ref);
        cov += (n_v - n_e) * (n_v - n_e);
    }
    m->s2_rmse = sqrt(s2 / lags);
    m->cov_error = sqrt(cov / lags);
    m->sharpness = sharp_ref > 0 ? sharp / sharp_ref : 1;
}

static int ascending(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static double quantile(const float *sorted, int64_t count, double q)
{
    double at = q * (double)(count - 1);
    int64_t i = (int64_t)floor(at);
    return i + 1 < count ? sorted[i] + (at - (double)i) * (sorted[i + 1] - sorted[i]) : sorted[i];
}

static pave_result measure_histogram(pave_context *context, const plane3 *sample, const plane3 *stone,
                                     pave_solid_measure *m)
{
    pave_result result = PAVE_OK;
    int64_t n = 0;
    float *a = pv_allocate(context, (size_t)sample->count, sizeof *a, &result);
    float *b = a ? pv_allocate(context, (size_t)stone->count, sizeof *b, &result) : NULL;
    if (b) {
        memcpy(a, sample->grey, (size_t)sample->count * sizeof *a);
        for (int64_t i = 0; i < stone->count; i++)
            if (counts(stone, i))
                b[n++] = stone->grey[i];
        qsort(a, (size_t)sample->count, sizeof *a, ascending);
        qsort(b, (size_t)n, sizeof *b, ascending);
        for (int i = 0; i < QUANTILES && n; i++)
            m->emd += fabs(quantile(a, sample->count, i / (QUANTILES - 1.0)) - quantile(b, n, i / (QUANTILES - 1.0))) /
                      QUANTILES;
        result = PAVE_OK;
    }
    pv_release(a);
    pv_release(b);
    return result;
}

/* The greatest difference of a label's share, of a sample with few values. */
static double label_difference(const plane3 *sample, const plane3 *stone, double otherwise)
{
    float label[PV_MOST_LABELS];
    int64_t in_sample[PV_MOST_LABELS] = { 0 }, in_stone[PV_MOST_LABELS] = { 0 }, all = 0;
    int found = 0;
    double most = 0;
    for (int64_t i = 0; i < sample->count; i++) {
        int l = 0;
        while (l < found && label[l] != sample->grey[i])
            l++;
        if (l == PV_MOST_LABELS)
            return otherwise;
        if (l == found)
            label[found++] = sample->grey[i];
        in_sample[l]++;
    }
    for (int64_t i = 0; i < stone->count; i++) {
        all += counts(stone, i);
        for (int l = 0; l < found; l++)
            in_stone[l] += counts(stone, i) && label[l] == stone->grey[i];
    }
    for (int l = 0; l < found && all; l++)
        most = fmax(most, fabs((double)in_sample[l] / (double)sample->count - (double)in_stone[l] / (double)all));
    return most;
}

/* Voxels among the six others; what is measured, and the walls of cells. */
static void measure_flaws(const pave_volume *v, const plane3 *stone, pave_solid_measure *m)
{
    double all = 0, pair_count = 0, near_measured = 0, measured = 0, across = 0, walls = 0, inside = 0, cells = 0;
    int64_t specks = 0;
    const int64_t along[3] = { 1, v->size[0], (int64_t)v->size[0] * v->size[1] };
    for (int64_t i = 0; i < stone->count; i++) {
        int others = 0, there = 0;
        if (!counts(stone, i))
            continue;
        m->voxels++;
        m->measured_voxels += v->states[i] == PAVE_VOXEL_MEASURED;
        for (int b = 0; b < 6; b++) {
            int64_t at = i / along[b / 2] % v->size[b / 2], j = i + (b & 1 ? along[b / 2] : -along[b / 2]);
            if ((b & 1 ? at + 1 >= v->size[b / 2] : at == 0) || !counts(stone, j))
                continue;
            double d = fabs(stone->grey[i] - stone->grey[j]);
            there++;
            others += stone->phase[i] != stone->phase[j];
            all += d, pair_count++;
            if (v->states[i] == PAVE_VOXEL_MEASURED && v->states[j] != PAVE_VOXEL_MEASURED)
                near_measured += d, measured++;
            if (v->cells && v->cells[i] != v->cells[j])
                across += d, walls++;
            else if (v->cells)
                inside += d, cells++;
        }
        specks += there && others == there;
    }
    m->speckle = m->voxels ? (double)specks / (double)m->voxels : 0;
    m->measured = measured && all > 0 ? near_measured / measured / (all / pair_count) : NAN;
    m->walls = walls && inside > 0 ? across / walls / (inside / cells) : NAN;
}

/* 5 x 5 patches at random places of slices across an axis; of the sample, across z. */
static void draw_patches(const plane3 *p, int axis, uint32_t use, float *patches)
{
    enum { SLICES = 8 };
    int u = axis == 0, w = axis == 2 ? 1 : 2;
    const int64_t along[3] = { 1, p->size[0], (int64_t)p->size[0] * p->size[1] };
    for (uint32_t i = 0; i < PATCHES; i++) {
        pv_random r = pv_draw(use, PV_DRAW_RANK, i, 0, 1);
        int64_t slice = (int64_t)(i % SLICES) * (p->size[axis] - 1) / (SLICES - 1);
        int64_t x = pv_below(r.word[0], (uint32_t)(p->size[u] - SIDE));
        int64_t y = pv_below(r.word[1], (uint32_t)(p->size[w] - SIDE));
        for (int t = 0; t < TAPS; t++)
            patches[i * TAPS + (uint32_t)t] = p->grey[slice * along[axis] + (x + t % SIDE) * along[u] +
                                                      (y + t / SIDE) * along[w]];
    }
}

static void project(const float *patches, uint32_t direction, float *out)
{
    double d[TAPS], length = 0;
    for (uint32_t t = 0; t < TAPS; t++) { /* the sum of twelve uniform numbers is nearly normal */
        d[t] = -6;
        for (uint32_t k = 0; k < 3; k++) {
            pv_random r = pv_draw(direction, PV_DRAW_RANK, t, k, 2);
            for (int w = 0; w < 4; w++)
                d[t] += r.word[w] / 4294967296.0;
        }
        length += d[t] * d[t];
    }
    for (int i = 0; i < PATCHES; i++) {
        double sum = 0;
        for (int t = 0; t < TAPS; t++)
            sum += d[t] * patches[i * TAPS + t];
        out[i] = (float)(sum / sqrt(length));
    }
    qsort(out, PATCHES, sizeof *out, ascending);
}

static pave_result measure_slices(pave_context *context, const plane3 *sample, const plane3 *stone,
                                  pave_solid_measure *m)
{
    pave_result result = PAVE_OK;
    float *room = pv_allocate(context, 2 * (size_t)PATCHES * (TAPS + 1), sizeof *room, &result);
    if (!room)
        return result;
    float *a = room, *b = a + PATCHES * TAPS, *pa = b + PATCHES * TAPS, *pb = pa + PATCHES;
    draw_patches(sample, 2, 1, a);
    m->slice_distance = 0;
    for (int axis = 0; axis < 3; axis++) {
        double sum = 0;
        draw_patches(stone, axis, 2 + (uint32_t)axis, b);
        for (uint32_t d = 0; d < DIRECTIONS; d++) {
            project(a, d, pa);
            project(b, d, pb);
            for (int i = 0; i < PATCHES; i++)
                sum += fabs(pa[i] - pb[i]);
        }
        m->slice_distance = fmax(m->slice_distance, sum / PATCHES / DIRECTIONS);
    }
    pv_release(room);
    return PAVE_OK;
}

static int sliceable(const plane3 *sample, const plane3 *stone)
{
    for (int a = 0; a < 3; a++)
        if (stone->size[a] <= SIDE || (a < 2 && sample->size[a] <= SIDE))
            return 0;
    for (int64_t i = 0; i < stone->count; i++)
        if (!counts(stone, i))
            return 0;
    return 1;
}

static pave_result measure(pave_context *context, plane3 *sample, plane3 *stone, const pave_volume *volume,
                           pave_solid_measure *m)
{
    double cut = otsu(sample), phi_e = set_phase(sample, cut), phi_v = set_phase(stone, cut);
    pave_result result = measure_histogram(context, sample, stone, m);
    m->phase = label_difference(sample, stone, fabs(phi_e - phi_v));
    measure_pairs(sample, stone, phi_e, phi_v, m);
    measure_flaws(volume, stone, m);
    m->use = volume->use;
    m->constraint_error = volume->constraint_error;
    m->slice_distance = NAN;
    return result || !sliceable(sample, stone) ? result : measure_slices(context, sample, stone, m);
}

pave_result pave_solid_measure_against(pave_context *context, const pave_image *exemplar, const pave_volume *volume,
                                       pave_solid_measure *out)
{
    static const pave_solid_measure nothing = { .size = sizeof nothing };
    pave_solid_measure m;
    plane3 sample = { 0 }, stone = { 0 };
    if (!context || !exemplar || !volume || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_struct_read(context, "solid measure", &nothing, sizeof nothing, &nothing, &m);
    if (!result && out->size < sizeof m)
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "the measure's size is not set");
    if (!result)
        result = open_sample(context, exemplar, &sample);
    if (!result)
        result = open_volume(context, volume, &stone);
    if (!result)
        result = measure(context, &sample, &stone, volume, &m);
    close_planes(&sample);
    close_planes(&stone);
    m.size = out->size;
    if (!result)
        memcpy(out, &m, sizeof m);
    return result;
}
