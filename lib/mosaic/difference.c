/* CIEDE2000. Source: Sharma, Wu and Dalal 2005. */
#include "mosaic/mosaic.h"

#include <math.h>

static double seventh(double v)
{
    return v * v * v * v * v * v * v;
}

static double degrees_of(double y, double x)
{
    double a = x == 0 && y == 0 ? 0 : atan2(y, x) * (180 / 3.14159265358979323846);
    return a < 0 ? a + 360 : a;
}

static double cosine(double degrees)
{
    return cos(degrees * (3.14159265358979323846 / 180));
}

double pv_ciede2000(const double p[3], const double q[3])
{
    double mean = (hypot(p[1], p[2]) + hypot(q[1], q[2])) / 2, far = seventh(25);
    double g = 1.5 - 0.5 * sqrt(seventh(mean) / (seventh(mean) + far)), a1 = p[1] * g, a2 = q[1] * g;
    double c1 = hypot(a1, p[2]), c2 = hypot(a2, q[2]), h1 = degrees_of(p[2], a1), h2 = degrees_of(q[2], a2);
    double way = h2 - h1, sum = h1 + h2, hue = sum;
    way = c1 * c2 == 0 ? 0 : way > 180 ? way - 360 : way < -180 ? way + 360 : way;
    if (c1 * c2 != 0)
        hue = fabs(h1 - h2) <= 180 ? sum / 2 : sum < 360 ? (sum + 360) / 2 : (sum - 360) / 2;
    double lightness = (p[0] + q[0]) / 2 - 50, chroma = (c1 + c2) / 2;
    double t = 1 - 0.17 * cosine(hue - 30) + 0.24 * cosine(2 * hue) + 0.32 * cosine(3 * hue + 6) -
               0.20 * cosine(4 * hue - 63);
    double sl = 1 + 0.015 * lightness * lightness / sqrt(20 + lightness * lightness), sc = 1 + 0.045 * chroma;
    double sh = 1 + 0.015 * chroma * t, bend = (hue - 275) / 25;
    double turn = -2 * sqrt(seventh(chroma) / (seventh(chroma) + far)) * cosine(60 * exp(-bend * bend) - 90);
    double l = (q[0] - p[0]) / sl, c = (c2 - c1) / sc, h = 2 * sqrt(c1 * c2) * cosine(way / 2 - 90) / sh;
    return sqrt(l * l + c * c + h * h + turn * c * h);
}
