/* Display values and linear light (sRGB, IEC 61966-2-1). */
#pragma once

#include <math.h>

static inline double pv_display_code(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static inline double pv_linear_light(double display)
{
    return display <= 0.04045 ? display / 12.92 : pow((display + 0.055) / 1.055, 2.4);
}
