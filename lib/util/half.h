/* IEEE half floats. */
#pragma once

#include <stdint.h>
#include <string.h>

static inline float pv_half_value(uint16_t half)
{
    /* The bits as a float are 2^-112 of the value, denormals too; infinity and NaN lie at the top of both scales. */
    uint32_t bits = (uint32_t)(half & 0x7FFF) << 13;
    float value;
    if (bits >= 0x0F800000)
        bits |= 0x7F800000;
    memcpy(&value, &bits, sizeof value);
    value = bits >= 0x7F800000 ? value : value * 0x1p112f;
    return half & 0x8000 ? -value : value;
}

/* Rounds to nearest, ties to even; beyond the range to infinity. */
static inline uint16_t pv_half(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t sign = bits >> 16 & 0x8000, magnitude = bits & 0x7FFFFFFF;
    if (magnitude > 0x7F800000)
        return (uint16_t)(sign | 0x7E00);
    if (magnitude >= 0x477FF000)
        return (uint16_t)(sign | 0x7C00);
    if (magnitude < 0x38800000) { /* subnormal: adding 1/2 rounds to multiples of 2^-24 */
        float shifted;
        memcpy(&shifted, &magnitude, sizeof shifted);
        shifted += 0.5f;
        memcpy(&magnitude, &shifted, sizeof magnitude);
        return (uint16_t)(sign | (magnitude - 0x3F000000));
    }
    uint32_t rounded = magnitude + 0xFFF + (magnitude >> 13 & 1);
    return (uint16_t)(sign | (rounded - 0x38000000) >> 13);
}
