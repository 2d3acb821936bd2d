/* Fixed-point arithmetic that is the same on every machine. The C twin of shaders/fixed.glsl. */
#pragma once

#include <math.h>
#include <stdint.h>

static inline int64_t pv_ceil_div(int64_t a, int64_t b)
{
    return a / b + (a % b > 0);
}

static inline int64_t pv_floor_div(int64_t a, int64_t b)
{
    return a / b - (a % b < 0);
}

/* What is left of a modulo b, 0 .. b - 1. */
static inline int32_t pv_modulo(int32_t a, int32_t b)
{
    return a % b < 0 ? a % b + b : a % b;
}

/* The root, rounded down. Floating point only guesses it. */
static inline uint32_t pv_isqrt(uint64_t v)
{
    double guess = sqrt((double)v);
    uint64_t root = guess < UINT32_MAX ? (uint64_t)guess : UINT32_MAX;
    while (root * root > v)
        root--;
    while (root < UINT32_MAX && (root + 1) * (root + 1) <= v)
        root++;
    return (uint32_t)root;
}

/* Sine of a quarter turn times t / 16384, in 1/65536. The polynomial is within 1e-6. */
static inline int32_t pv_quarter_sine(int32_t t)
{
    int64_t x = (int64_t)t << 16, x2 = (x * x) >> 30;
    int64_t p = 85291978 - ((x2 * 4652626) >> 30);
    p = 693522166 - ((x2 * p) >> 30);
    p = 1686624005 - ((x2 * p) >> 30);
    return (int32_t)(((x * p >> 30) + 8192) >> 14);
}

/* Cosine and sine, in 1/65536, of an angle of which 65536 make a turn. */
static inline void pv_turn(int32_t angle, int32_t *cosine, int32_t *sine)
{
    int32_t t = angle & 16383, quarter = (angle >> 14) & 3;
    int32_t s = pv_quarter_sine(t), c = pv_quarter_sine(16384 - t);
    *cosine = quarter == 0 ? c : quarter == 1 ? -s : quarter == 2 ? -c : s;
    *sine = quarter == 0 ? s : quarter == 1 ? c : quarter == 2 ? -s : -c;
}
