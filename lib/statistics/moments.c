/* Moments of a plane: measured, and moved along their gradients to what is wanted.
 * Source: Portilla and Simoncelli 2000, appendix. */
#include "statistics/texture.h"

#include <math.h>

enum { MOST_ORDER = 4, HALVINGS = 60 };

double pv_mean(const float *plane, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += plane[i];
    return sum / (double)count;
}

pv_moments pv_moments_of(const float *plane, size_t count)
{
    pv_moments m = { pv_mean(plane, count), 0, 0, 3, plane[0], plane[0] };
    double second = 0, third = 0, fourth = 0;
    for (size_t i = 0; i < count; i++) {
        m.least = fmin(m.least, plane[i]);
        m.greatest = fmax(m.greatest, plane[i]);
    }
    for (size_t i = 0; i < count; i++) {
        double d = plane[i] - m.mean, square = d * d;
        second += square;
        third += d * square;
        fourth += square * square;
    }
    m.variance = second / (double)count;
    if (m.variance > 1e-12 * m.mean * m.mean && m.variance > 1e-30) {
        m.skewness = third / (double)count / pow(m.variance, 1.5);
        m.kurtosis = fourth / (double)count / (m.variance * m.variance);
    }
    return m;
}

void pv_shape_of(const float *plane, size_t count, double shape[2])
{
    pv_moments m = pv_moments_of(plane, count);
    shape[0] = m.skewness, shape[1] = m.kurtosis;
}

/* Means of x^i g^j for i + j = order, by j. */
typedef struct mixed { double of[MOST_ORDER + 1], gradient; } mixed;

/* The gradient of a moment without its parts along mean and variance. x has mean 0. */
static inline double gradient_at(double x, int order, const pv_moments *m)
{
    double deviation = sqrt(m->variance);
    return order == 3 ? x * x - m->variance - m->skewness * deviation * x
                      : x * x * x - m->kurtosis * m->variance * x - m->skewness * deviation * m->variance;
}

void pv_shape_gradient(const float *plane, size_t count, const double weights[2], float *out)
{
    pv_moments m = pv_moments_of(plane, count);
    double third = m.variance > 0 ? weights[0] * 3 / pow(m.variance, 1.5) : 0;
    double fourth = m.variance > 0 ? weights[1] * 4 / (m.variance * m.variance) : 0;
    for (size_t i = 0; i < count; i++) {
        double x = plane[i] - m.mean;
        out[i] += (float)(third * gradient_at(x, 3, &m) + fourth * gradient_at(x, 4, &m));
    }
}

void pv_shape_change(const float *plane, const float *direction, size_t count, double change[2])
{
    pv_moments m = pv_moments_of(plane, count);
    change[0] = change[1] = 0;
    for (size_t i = 0; i < count && m.variance > 0; i++) {
        double x = plane[i] - m.mean;
        change[0] += gradient_at(x, 3, &m) * direction[i];
        change[1] += gradient_at(x, 4, &m) * direction[i];
    }
    change[0] *= m.variance > 0 ? 3 / pow(m.variance, 1.5) / (double)count : 0;
    change[1] *= m.variance > 0 ? 4 / (m.variance * m.variance) / (double)count : 0;
}

double pv_deviation_change(const float *plane, const float *direction, size_t count)
{
    pv_moments m = pv_moments_of(plane, count);
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (plane[i] - m.mean) * direction[i];
    return m.variance > 0 ? sum / (double)count / sqrt(m.variance) : 0;
}

static mixed mix(const float *plane, size_t count, int order, const pv_moments *m)
{
    mixed sum = { { 0 }, 0 };
    for (size_t i = 0; i < count; i++) {
        double x = plane[i] - m->mean, g = gradient_at(x, order, m);
        double powers[2][MOST_ORDER + 1] = { { 1, x, x * x, x * x * x, x * x * x * x },
                                             { 1, g, g * g, g * g * g, g * g * g * g } };
        for (int j = 0; j <= order; j++)
            sum.of[j] += powers[0][order - j] * powers[1][j];
        sum.gradient += g * g;
    }
    for (int j = 0; j <= order; j++)
        sum.of[j] /= (double)count;
    sum.gradient /= (double)count;
    return sum;
}

/* The moment of x + step g over its deviation's power. */
static double moved(const mixed *m, int order, double variance, double step)
{
    static const double binomial[2][MOST_ORDER + 1] = { { 1, 3, 3, 1, 0 }, { 1, 4, 6, 4, 1 } };
    double sum = 0, power = 1;
    for (int j = 0; j <= order; j++, power *= step)
        sum += binomial[order - 3][j] * power * m->of[j];
    return sum / pow(variance + step * step * m->gradient, order / 2.0);
}

/* The root nearest to 0, or the step that comes nearest to the moment wanted before it turns away again. */
static double find_step(const mixed *m, int order, double variance, double wanted)
{
    double from = moved(m, order, variance, 0), sign = wanted > from ? 1 : -1;
    double before = 0, step = 1e-6 * sqrt(variance / m->gradient), value = from;
    for (int i = 0; i < 200 && sign * (wanted - value) > 0; i++, step *= 1.2) {
        double next = moved(m, order, variance, sign * step);
        if (sign * (next - value) < 0)
            return sign * before;
        if (sign * (wanted - next) <= 0)
            break;
        before = step;
        value = next;
    }
    for (int i = 0; i < HALVINGS; i++) {
        double middle = (before + step) / 2;
        *(sign * (wanted - moved(m, order, variance, sign * middle)) > 0 ? &before : &step) = middle;
    }
    return sign * (before + step) / 2;
}

void pv_move_moment(float *plane, size_t count, int order, double wanted)
{
    pv_moments m = pv_moments_of(plane, count);
    if (m.variance <= 1e-12 * m.mean * m.mean || m.variance < 1e-30)
        return;
    mixed sums = mix(plane, count, order, &m);
    if (sums.gradient <= 1e-12 * pow(m.variance, order - 1))
        return;
    double step = find_step(&sums, order, m.variance, wanted);
    double scale = sqrt(m.variance / (m.variance + step * step * sums.gradient));
    for (size_t i = 0; i < count; i++) {
        double x = plane[i] - m.mean;
        plane[i] = (float)(m.mean + scale * (x + step * gradient_at(x, order, &m)));
    }
}

/* The pixels at the ends become the ends, for what is only cut off may be too narrow. */
void pv_impose_range(float *plane, size_t count, double mean, double least, double greatest)
{
    size_t low = 0, high = 0;
    float shift = (float)(mean - pv_mean(plane, count));
    for (size_t i = 0; i < count; i++)
        plane[i] += shift;
    for (size_t i = 1; i < count; i++) {
        low = plane[i] < plane[low] ? i : low;
        high = plane[i] > plane[high] ? i : high;
    }
    plane[low] = (float)least, plane[high] = (float)greatest;
    for (size_t i = 0; i < count; i++)
        plane[i] = plane[i] < (float)least ? (float)least : plane[i] > (float)greatest ? (float)greatest : plane[i];
}

void pv_impose_marginal(float *plane, size_t count, const double pixels[4], const double shape[2])
{
    pv_moments m = pv_moments_of(plane, count);
    double scale = m.variance > 0 ? pixels[1] / sqrt(m.variance) : 0;
    for (size_t i = 0; i < count; i++)
        plane[i] = (float)(pixels[0] + scale * (plane[i] - m.mean));
    if (pixels[1] > 0) {
        pv_move_moment(plane, count, 3, shape[0]);
        pv_move_moment(plane, count, 4, shape[1]);
    }
    pv_impose_range(plane, count, pixels[0], pixels[2], pixels[3]);
}
