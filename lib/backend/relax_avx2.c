/* Turning four sites by the noise at once: pv_noise and pv_turn with their numbers in the low halves of 64-bit lanes.
 * Products are whole and sums of products, too; each shift right leaves what fits 32 bits. */
#include "backend/cpu.h"

#ifdef PV_AVX2

#include <immintrin.h>

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif

static inline __m256i number(int64_t v)
{
    return _mm256_set1_epi64x(v);
}

static inline __m256i times(__m256i a, __m256i b)
{
    return _mm256_mul_epi32(a, b);
}

static inline __m256i plus(__m256i a, __m256i b)
{
    return _mm256_add_epi64(a, b);
}

static inline __m256i minus(__m256i a, __m256i b)
{
    return _mm256_sub_epi64(a, b);
}

/* a * b / 2^16, rounded down */
static inline __m256i part(__m256i a, __m256i b)
{
    return _mm256_srli_epi64(times(a, b), 16);
}

static inline __m256i corner(const pv_noise_cell *cell, int i, __m256i fx, __m256i fy)
{
    __m256i x = times(number(cell->cosine[i]), fx), y = times(number(cell->sine[i]), fy);
    return _mm256_srli_epi64(plus(x, y), 16);
}

static inline __m256i fade(__m256i t)
{
    __m256i poly = plus(part(t, minus(times(t, number(6)), number(15 * 65536))), number(10 * 65536));
    return part(part(part(t, t), t), poly);
}

static inline __m256i noise(const pv_noise_cell *cell, __m256i fx, __m256i fy)
{
    __m256i one = number(65536), gx = minus(fx, one), gy = minus(fy, one), u = fade(fx), v = fade(fy);
    __m256i a = corner(cell, 0, fx, fy), b = corner(cell, 1, gx, fy);
    __m256i c = corner(cell, 2, fx, gy), d = corner(cell, 3, gx, gy);
    a = plus(a, part(minus(b, a), u));
    c = plus(c, part(minus(d, c), u));
    return part(plus(a, part(minus(c, a), v)), number(92682));
}

static inline __m256i scaled(__m256i a, __m256i b)
{
    return _mm256_srli_epi64(times(a, b), 30);
}

static inline __m256i quarter_sine(__m256i t)
{
    __m256i x = _mm256_slli_epi64(t, 16), x2 = scaled(x, x);
    __m256i p = minus(number(85291978), scaled(x2, number(4652626)));
    p = minus(number(693522166), scaled(x2, p));
    p = minus(number(1686624005), scaled(x2, p));
    return _mm256_srli_epi64(plus(scaled(x, p), number(8192)), 14);
}

static inline __m256i negated_if(__m256i v, __m256i bit)
{
    __m256i all = minus(_mm256_setzero_si256(), bit);
    return minus(_mm256_xor_si256(v, all), all);
}

static inline void turn(__m256i angle, __m256i *cosine, __m256i *sine)
{
    __m256i t = _mm256_and_si256(angle, number(16383)), one = number(1);
    __m256i odd = _mm256_and_si256(_mm256_srli_epi64(angle, 14), one);
    __m256i half = _mm256_and_si256(_mm256_srli_epi64(angle, 15), one), swap = minus(_mm256_setzero_si256(), odd);
    __m256i s = quarter_sine(t), c = quarter_sine(minus(number(16384), t));
    *cosine = negated_if(_mm256_blendv_epi8(c, s, swap), _mm256_xor_si256(odd, half));
    *sine = negated_if(_mm256_blendv_epi8(s, c, swap), half);
}

/* How far into the cell, 1/65536; half a numerator too large outweighs what is lost by multiplying. */
static inline __m256i way(__m128i place, double per_span)
{
    __m256d d = _mm256_add_pd(_mm256_mul_pd(_mm256_cvtepi32_pd(place), _mm256_set1_pd(65536)), _mm256_set1_pd(0.5));
    return _mm256_cvtepi32_epi64(_mm256_cvttpd_epi32(_mm256_mul_pd(d, _mm256_set1_pd(per_span))));
}

static inline __m128i lacking(__m128i v, int32_t span)
{
    return _mm_or_si128(_mm_cmpgt_epi32(_mm_setzero_si128(), v), _mm_cmpgt_epi32(v, _mm_set1_epi32(span - 1)));
}

int pv_sites_turn_avx2(const pv_plane *plane, const pv_noise_cell *cell, pave_site *const site[4])
{
    int32_t span = plane->noise_wave;
    if (!cell->known || plane->direction || plane->period_x || plane->period_y)
        return 0;
    int32_t left = (int32_t)((int64_t)cell->x * span - plane->origin_x);
    int32_t top = (int32_t)((int64_t)cell->y * span - plane->origin_y);
    __m128i x = _mm_setr_epi32(site[0]->x, site[1]->x, site[2]->x, site[3]->x);
    __m128i y = _mm_setr_epi32(site[0]->y, site[1]->y, site[2]->y, site[3]->y);
    x = _mm_sub_epi32(x, _mm_set1_epi32(left));
    y = _mm_sub_epi32(y, _mm_set1_epi32(top));
    __m128i out = _mm_or_si128(lacking(x, span), lacking(y, span));
    if (!_mm_testz_si128(out, out))
        return 0;
    double per_span = 1.0 / span;
    __m256i cosine, sine, n = noise(cell, way(x, per_span), way(y, per_span));
    turn(part(n, number(plane->noise_swing)), &cosine, &sine);
    int64_t c[4], s[4];
    _mm256_storeu_si256((__m256i *)(void *)c, cosine);
    _mm256_storeu_si256((__m256i *)(void *)s, sine);
    for (int i = 0; i < 4; i++) {
        site[i]->cosine = (int32_t)c[i];
        site[i]->sine = (int32_t)s[i];
    }
    return 1;
}

#ifdef __clang__
#pragma clang attribute pop
#endif

#endif
