/* Distances of neighbourhoods, 16 values at once, by AVX2. The twin of the loop in distance.c. */
#include "solid/bank.h"

#ifdef PV_DISTANCE_AVX2

#include <immintrin.h>

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif

static inline int32_t total(__m256i sums)
{
    __m128i four = _mm_add_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256(sums, 1));
    four = _mm_add_epi32(four, _mm_shuffle_epi32(four, 0x4e));
    return _mm_cvtsi128_si32(_mm_add_epi32(four, _mm_shuffle_epi32(four, 0xb1)));
}

void pv_distances_avx2(const pv_windows *bank, const int16_t *patch, const int16_t *presence, const int32_t *positions,
                       int32_t count, int32_t *out)
{
    int32_t stride = bank->window.stride;
    const __m256i *mine = (const __m256i *)(const void *)patch, *there = (const __m256i *)(const void *)presence;
    for (int32_t i = 0; i < count; i++) {
        const __m256i *theirs = (const __m256i *)(const void *)(bank->patch + (size_t)positions[i] * (size_t)stride);
        __m256i sums = _mm256_setzero_si256();
        for (int32_t k = 0; k < stride / 16; k++) {
            __m256i d = _mm256_mullo_epi16(_mm256_sub_epi16(theirs[k], mine[k]), there[k]);
            sums = _mm256_add_epi32(sums, _mm256_madd_epi16(d, d));
        }
        out[i] = total(sums);
    }
}

#ifdef __clang__
#pragma clang attribute pop
#endif

#endif
