/* Search: 16 values at once, by AVX2. The twin of pv_compare_portable. */
#include "tiling/search.h"

#ifdef PV_SEARCH_AVX2

#include <immintrin.h>

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif

enum { TOGETHER = 16 }; /* taps whose squares, of values up to 4095, stay within 32 bits */

static inline int64_t total(__m256i sums)
{
    __m256i low = _mm256_unpacklo_epi32(sums, _mm256_setzero_si256());
    __m256i high = _mm256_unpackhi_epi32(sums, _mm256_setzero_si256());
    __m256i wide = _mm256_add_epi64(low, high);
    __m128i half = _mm_add_epi64(_mm256_castsi256_si128(wide), _mm256_extracti128_si256(wide, 1));
    return _mm_cvtsi128_si64(half) + _mm_extract_epi64(half, 1);
}

int64_t pv_compare_avx2(const pv_query *query, int32_t place, int64_t bound)
{
    const int16_t *at = query->bank->values + (int64_t)place * query->bank->depth;
    const pv_tap *tap = query->taps, *last = tap + query->tap_count;
    int64_t sum = 0;
    while (tap < last && sum < bound) {
        const pv_tap *end = last - tap > TOGETHER ? tap + TOGETHER : last;
        __m256i squares = _mm256_setzero_si256();
        for (; tap < end; tap++) {
            __m256i there = _mm256_loadu_si256((const void *)(at + tap->shift));
            __m256i d = _mm256_sub_epi16(there, _mm256_load_si256((const void *)tap->value));
            d = _mm256_and_si256(d, _mm256_load_si256((const void *)tap->mask));
            squares = _mm256_add_epi32(squares, _mm256_madd_epi16(d, d));
        }
        sum += total(squares);
    }
    return sum;
}

#ifdef __clang__
#pragma clang attribute pop
#endif
#endif
