/* OKLab in whole numbers. */
#include "util/oklab.h"

/* Newton's steps, for pow differs between C libraries. */
static double fifth_root(double v)
{
    double t = 1;
    for (int i = 0; i < 60; i++)
        t = (4 * t + v / (t * t * t * t)) / 5;
    return t;
}

/* IEC 61966-2-1; x^2.4 is x^2 times the fifth root of x^2. */
static int32_t light_of(int32_t code)
{
    double v = code / 255.0, x = (v + 0.055) / 1.055;
    double light = v <= 0.04045 ? v / 12.92 : x * x * fifth_root(x * x);
    return (int32_t)(light * PV_LIGHT_ONE + 0.5);
}

/* Roots grow with what they are roots of, so each begins where the last one ended. */
void pv_oklab_begin(pv_oklab *tables)
{
    uint64_t root = 0;
    for (int32_t i = 0; i < 256; i++)
        tables->light[i] = light_of(i);
    for (uint64_t i = 0; i <= PV_LIGHT_ONE; i++) {
        while ((root + 1) * (root + 1) * (root + 1) <= i << 26)
            root++;
        tables->root[i] = (uint16_t)root;
    }
}

static int32_t mixed(int64_t x, int64_t y, int64_t z, const int32_t *share)
{
    return (int32_t)((x * share[0] + y * share[1] + z * share[2] + 32768) >> 16);
}

/* The two matrices in 1/65536; rows of the first sum up to 1, rows of the second to 1, 0 and 0. */
pv_lab pv_oklab_of(const pv_oklab *tables, pv_rgb c)
{
    static const int32_t cones[3][3] = { { 27015, 35149, 3372 }, { 13887, 44610, 7039 }, { 5787, 18462, 41287 } };
    static const int32_t axes[3][3] = { { 13792, 52011, -267 }, { 129629, -159160, 29531 }, { 1698, 51300, -52998 } };
    int32_t r = tables->light[c.r], g = tables->light[c.g], b = tables->light[c.b];
    int32_t l = tables->root[mixed(r, g, b, cones[0])];
    int32_t m = tables->root[mixed(r, g, b, cones[1])];
    int32_t s = tables->root[mixed(r, g, b, cones[2])];
    return (pv_lab){ mixed(l, m, s, axes[0]), mixed(l, m, s, axes[1]), mixed(l, m, s, axes[2]) };
}

uint8_t pv_display_of(const pv_oklab *tables, int64_t light)
{
    int32_t code = 0;
    while (code < 255 && 2 * light > (int64_t)tables->light[code] + tables->light[code + 1])
        code++;
    return (uint8_t)code;
}
