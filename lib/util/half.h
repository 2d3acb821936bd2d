/* IEEE half floats. */
#pragma once

#include <math.h>
#include <stdint.h>

static inline float pv_half_value(uint16_t half)
{
    int32_t exponent = half >> 10 & 31, fraction = half & 1023;
    float value = exponent == 31 ? (fraction ? NAN : INFINITY)
                  : exponent     ? ldexpf((float)(1024 + fraction), exponent - 25)
                                 : ldexpf((float)fraction, -24);
    return half & 0x8000 ? -value : value;
}
