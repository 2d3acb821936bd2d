/* Tiles with candidate lists, by AVX2.
 *
 * The sites of a window of buckets are measured, eight at a time, at the centres of the tile's four quarters. A site
 * can own a pixel of a quarter only if its distance there is at most the least one plus twice the quarter's radius, for
 * no metric changes by more than the way walked. The window is large enough if it holds all places within the range of
 * that distance; if not, it grows and is measured again.
 *
 * The few sites that remain are offered to all 64 pixels; a key of distance and rank finds each pixel's nearest, and
 * the lower index among equals. Tiles that do not fit this scheme take the portable path. */
#include "backend/cpu.h"

#ifdef PV_AVX2

#include "backend/metric.h"
#include "util/fixed.h"

#include <immintrin.h>

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2,bmi,bmi2,popcnt"))), apply_to = function)
#else
#pragma GCC target("avx2,bmi,bmi2,popcnt")
#endif

/* What depends on the metric is made once for each. */
#define ALWAYS static inline __attribute__((always_inline))

enum {
    QUARTERS = 4,
    VECTORS = 32, /* of sites in a window */
    SLOTS = VECTORS * PV_LANES,
    STEP = 4 * 256,  /* from one quarter's centre to the next */
    NEAR = 84 * 256, /* a site within NEAR of the first quarter's centre, in x and y, is within 127 px of every pixel */
    /* Twice a quarter's radius of 1.5*sqrt(2) px; the metric's errors at two sites and two places; the root's error. */
    BOUND = 1087 + 4 * PV_METRIC_SLACK + 1,
    SPARE = 4 * PV_METRIC_SLACK, /* more than the metric's errors where a distance tells how far to look */
    ACROSS = 2010,               /* a quarter's centre to the farthest pixel, 5.5*sqrt(2) px, and the metric's errors */
};

typedef struct window {
    int32_t left, right, top, bottom; /* buckets, inclusive */
} window;

typedef struct tile {
    int32_t x0, y0; /* first pixel */
    int32_t margin; /* how far from the quarters' centres to look, as the last tile needed it */
    int32_t vectors;
    int32_t base[VECTORS];  /* where in the columns a vector of sites begins */
    int32_t meant[VECTORS]; /* how many of its sites are in the window; the others are sites all the same, or far */
    __m256i distance[VECTORS][QUARTERS];
    int32_t count, bits;                /* candidates; what their ranks take */
    int32_t found[SLOTS + PV_LANES];    /* their places in the columns */
    int32_t unsorted[SLOTS + PV_LANES]; /* their indices */
    int32_t place[SLOTS + 1];           /* both again, by rank; and what has none */
    int32_t index[SLOTS + 1];
    __m256i owner[PV_TILE];             /* each pixel's rank, row by row */
} tile;

static inline int32_t min(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static inline int32_t max(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

static inline __m256i load(const int32_t *from)
{
    return _mm256_loadu_si256((const __m256i *)(const void *)from);
}

static inline void store(int32_t *to, __m256i v)
{
    _mm256_storeu_si256((__m256i *)(void *)to, v);
}

static inline __m256i broadcast(const int32_t *from)
{
    return _mm256_set1_epi32(*from);
}

/* Squared distance from the numerators of u and v: their high halves are u and v. */
ALWAYS __m256i squared(int32_t metric, __m256i u, __m256i v, __m256i box)
{
    __m256i uv = _mm256_abs_epi16(_mm256_blend_epi16(_mm256_srli_epi32(u, 16), v, 0xaa));
    if (metric == PAVE_METRIC_BOX) {
        uv = _mm256_subs_epu16(uv, box);
        return _mm256_madd_epi16(uv, uv);
    }
    uv = _mm256_mulhi_epu16(uv, box);
    __m256i swapped = _mm256_srli_epi32(uv, 16);
    uv = metric == PAVE_METRIC_DIAMOND ? _mm256_add_epi16(uv, swapped) : _mm256_max_epu16(uv, swapped);
    uv = _mm256_and_si256(uv, _mm256_set1_epi32(0xffff));
    return _mm256_madd_epi16(uv, uv);
}

/* Measures eight sites from `at` on at the four quarters; far ones get INT32_MAX, whatever wrapped round before. */
ALWAYS void measure_vector(int32_t metric, const pv_columns *c, int32_t at, __m256i px, __m256i py, __m256i *distance,
                                  __m256i *least)
{
    const __m256i half = _mm256_set1_epi32(32768);
    __m256i dx = _mm256_sub_epi32(px, load(c->x + at)), dy = _mm256_sub_epi32(py, load(c->y + at));
    __m256i cosine = load(c->cosine + at), sine = load(c->sine + at), box = load(c->box + at);
    __m256i far = _mm256_max_epi32(_mm256_abs_epi32(dx), _mm256_abs_epi32(dy));
    __m256i out = _mm256_srli_epi32(_mm256_cmpgt_epi32(far, _mm256_set1_epi32(NEAR)), 1);
    __m256i u = _mm256_add_epi32(_mm256_mullo_epi32(dx, cosine), _mm256_mullo_epi32(dy, sine));
    __m256i v = _mm256_sub_epi32(_mm256_mullo_epi32(dy, cosine), _mm256_mullo_epi32(dx, sine));
    u = _mm256_add_epi32(u, half);
    v = _mm256_add_epi32(v, half);
    cosine = _mm256_slli_epi32(cosine, 10); /* times STEP */
    sine = _mm256_slli_epi32(sine, 10);
    __m256i right_u = _mm256_add_epi32(u, cosine), right_v = _mm256_sub_epi32(v, sine);
    __m256i below_u = _mm256_add_epi32(u, sine), below_v = _mm256_add_epi32(v, cosine);
    distance[0] = squared(metric, u, v, box);
    distance[1] = squared(metric, right_u, right_v, box);
    distance[2] = squared(metric, below_u, below_v, box);
    distance[3] = squared(metric, _mm256_add_epi32(right_u, sine), _mm256_add_epi32(right_v, cosine), box);
    for (int q = 0; q < QUARTERS; q++) {
        distance[q] = _mm256_max_epi32(distance[q], out);
        least[q] = _mm256_min_epi32(least[q], distance[q]);
    }
}

/* The least of each of four vectors. */
static inline __m128i least_of(const __m256i *v)
{
    __m256i a = _mm256_min_epi32(_mm256_unpacklo_epi32(v[0], v[1]), _mm256_unpackhi_epi32(v[0], v[1]));
    __m256i b = _mm256_min_epi32(_mm256_unpacklo_epi32(v[2], v[3]), _mm256_unpackhi_epi32(v[2], v[3]));
    a = _mm256_min_epi32(_mm256_unpacklo_epi64(a, b), _mm256_unpackhi_epi64(a, b));
    return _mm_min_epi32(_mm256_castsi256_si128(a), _mm256_extracti128_si256(a, 1));
}

/* Measures the window's sites. The least squared distance at each quarter; 0 if there are too many sites. */
ALWAYS int measure(int32_t metric, const pv_cpu *cpu, tile *t, const window *w, __m128i *nearest)
{
    __m256i px = _mm256_set1_epi32(256 * (t->x0 + 2)), py = _mm256_set1_epi32(256 * (t->y0 + 2));
    __m256i none = _mm256_set1_epi32(INT32_MAX), least[QUARTERS] = { none, none, none, none };
    const pv_columns columns = cpu->columns;
    int32_t vectors = 0;
    for (int32_t row = w->top; row <= w->bottom; row++) {
        const int32_t *first = cpu->first + (int64_t)row * cpu->across;
        int32_t at = first[w->left], end = first[w->right + 1];
        do {
            if (vectors == VECTORS)
                return 0;
            t->base[vectors] = at;
            t->meant[vectors] = min(end - at, PV_LANES);
            measure_vector(metric, &columns, at, px, py, t->distance[vectors], least);
            vectors++;
            at += PV_LANES;
        } while (at < end);
    }
    t->vectors = vectors;
    *nearest = least_of(least);
    return 1;
}

/* The bucket that something so far along lies in. The product may come to one more. */
static inline int32_t bucket_at(const pv_cpu *cpu, int32_t way, int32_t buckets)
{
    int32_t b = way > 0 ? (int32_t)((uint32_t)way * cpu->per_bucket >> 32) : 0;
    b -= b * cpu->bucket > max(way, 0);
    return b < buckets ? b : buckets - 1;
}

/* A window that holds all places up to `margin` from the quarters' centres: search ends for that. */
static inline window window_around(const pv_cpu *cpu, int32_t x, int32_t y, int32_t margin)
{
    return (window){ bucket_at(cpu, x - margin, cpu->across), bucket_at(cpu, x + STEP + margin, cpu->across),
                     bucket_at(cpu, y - margin, cpu->down), bucket_at(cpu, y + STEP + margin, cpu->down) };
}

/* How far from the quarters' centres the window reaches to the left, right, top and bottom. */
static inline __m128i room_in(const pv_cpu *cpu, const window *w, int32_t x, int32_t y)
{
    int32_t b = cpu->bucket;
    return _mm_setr_epi32(w->left > 0 ? x - w->left * b : INT32_MAX,
                          w->right < cpu->across - 1 ? (w->right + 1) * b - x - STEP : INT32_MAX,
                          w->top > 0 ? y - w->top * b : INT32_MAX,
                          w->bottom < cpu->down - 1 ? (w->bottom + 1) * b - y - STEP : INT32_MAX);
}

/* Finds a window that holds all sites that may own pixels of the tile, measures them, and tells the squared distance
 * up to which they may. 0 if the tile does not fit the scheme. Each side of the window is held against the two quarters
 * next to it: the others need no more, for their distances differ by at most STEP. */
ALWAYS int search(int32_t metric, const pv_cpu *cpu, tile *t, __m128i *within)
{
    int32_t x = 256 * (t->x0 + 2), y = 256 * (t->y0 + 2);
    for (;;) {
        __m128i nearest;
        window w = window_around(cpu, x, y, t->margin);
        if (!measure(metric, cpu, t, &w, &nearest))
            return 0;
        __m128 bound = _mm_add_ps(_mm_sqrt_ps(_mm_cvtepi32_ps(nearest)), _mm_set1_ps(BOUND));
        __m128 range = _mm_add_ps(bound, _mm_set1_ps(SPARE));
        if (metric != PAVE_METRIC_BOX) /* 2^30: beyond NEAR, and an integer */
            range = _mm_min_ps(_mm_mul_ps(range, _mm_set1_ps((float)cpu->stretch)), _mm_set1_ps(0x1p30f));
        __m128i need = _mm_add_epi32(_mm_cvtps_epi32(range), _mm_set1_epi32(cpu->reach));
        need = _mm_max_epi32(_mm_shuffle_epi32(need, _MM_SHUFFLE(2, 0, 1, 0)),
                             _mm_shuffle_epi32(need, _MM_SHUFFLE(3, 1, 3, 2)));
        t->margin = max(_mm_extract_epi32(need, 0), _mm_extract_epi32(need, 1));
        if (t->margin > NEAR - STEP)
            return 0;
        __m128i lacking = _mm_cmpgt_epi32(need, room_in(cpu, &w, x, y));
        if (_mm_testz_si128(lacking, lacking)) {
            *within = _mm_cvtps_epi32(_mm_mul_ps(bound, bound));
            return 1;
        }
    }
}

/* Which of eight measured sites are within a quarter's bound. */
static inline uint32_t kept(const __m256i *distance, const __m256i *within)
{
    __m256i out = _mm256_cmpgt_epi32(distance[0], within[0]);
    for (int q = 1; q < QUARTERS; q++)
        out = _mm256_and_si256(out, _mm256_cmpgt_epi32(distance[q], within[q]));
    return (uint32_t)~_mm256_movemask_ps(_mm256_castsi256_ps(out)) & 0xff;
}

/* Lists the sites within the bounds. */
static inline void list(const pv_cpu *cpu, tile *t, __m128i bounds)
{
    __m256i b = _mm256_broadcastsi128_si256(bounds);
    __m256i within[QUARTERS] = { _mm256_shuffle_epi32(b, 0x00), _mm256_shuffle_epi32(b, 0x55),
                                 _mm256_shuffle_epi32(b, 0xaa), _mm256_shuffle_epi32(b, 0xff) };
    t->count = 0;
    for (int32_t i = 0; i < t->vectors; i++) {
        uint32_t keep = _bzhi_u32(kept(t->distance[i], within), (uint32_t)t->meant[i]);
        __m256i chosen = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)&cpu->squeeze[keep]));
        __m256i places = _mm256_add_epi32(_mm256_set1_epi32(t->base[i]), chosen);
        store(t->found + t->count, places);
        store(t->unsorted + t->count, _mm256_permutevar8x32_epi32(load(cpu->index + t->base[i]), chosen));
        t->count += _mm_popcnt_u32(keep);
    }
}

/* Of eight indices, how many of `count` others are lower. */
static inline __m256i ranks_of(__m256i v, const int32_t *others, int32_t count)
{
    __m256i rank = _mm256_setzero_si256();
    for (int32_t k = 0; k < count; k += PV_LANES)
        for (int32_t i = k; i < k + PV_LANES; i++)
            rank = _mm256_sub_epi32(rank, _mm256_cmpgt_epi32(v, broadcast(others + i)));
    return rank;
}

/* Ranks the candidates by index: each one's place is the number of lower indices. What fills the last vector up ranks
 * after them all. */
static inline void sort(tile *t)
{
    int32_t rank[PV_LANES];
    store(t->unsorted + t->count, _mm256_set1_epi32(INT32_MAX));
    for (int32_t k = 0; k < t->count; k += PV_LANES) {
        store(rank, ranks_of(load(t->unsorted + k), t->unsorted, t->count));
        for (int32_t i = 0; i < PV_LANES; i++) {
            t->index[rank[i]] = t->unsorted[k + i];
            t->place[rank[i]] = t->found[k + i];
        }
    }
}

/* Keys of the tile's rows: the squared distance, and below it the rank in `bits` bits. Keeps the greatest squared
 * distances of all tiles in `farthest`. */
ALWAYS void decide(int32_t metric, const pv_cpu *cpu, tile *t, __m256i *farthest)
{
    const pv_columns *c = &cpu->columns;
    const __m128i bits = _mm_cvtsi32_si128(t->bits);
    const __m256i half = _mm256_set1_epi32(32768);
    __m256i px = _mm256_add_epi32(_mm256_set1_epi32(256 * t->x0 + 128),
                                  _mm256_setr_epi32(0, 256, 512, 768, 1024, 1280, 1536, 1792));
    __m256i py = _mm256_set1_epi32(256 * t->y0 + 128), key[PV_TILE];
    for (int r = 0; r < PV_TILE; r++)
        key[r] = _mm256_set1_epi32(-1);
    int32_t k = 0;
    do {
        int32_t i = t->place[k];
        __m256i dx = _mm256_sub_epi32(px, broadcast(c->x + i)), dy = _mm256_sub_epi32(py, broadcast(c->y + i));
        __m256i cosine = broadcast(c->cosine + i), sine = broadcast(c->sine + i), box = broadcast(c->box + i);
        __m256i u = _mm256_add_epi32(_mm256_mullo_epi32(dx, cosine), _mm256_mullo_epi32(dy, sine));
        __m256i v = _mm256_sub_epi32(_mm256_mullo_epi32(dy, cosine), _mm256_mullo_epi32(dx, sine));
        __m256i rank = _mm256_set1_epi32(k);
        u = _mm256_add_epi32(u, half);
        v = _mm256_add_epi32(v, half);
        cosine = _mm256_slli_epi32(cosine, 8);
        sine = _mm256_slli_epi32(sine, 8);
#pragma GCC unroll 8
        for (int r = 0; r < PV_TILE; r++) {
            __m256i d = _mm256_or_si256(_mm256_sll_epi32(squared(metric, u, v, box), bits), rank);
            key[r] = _mm256_min_epu32(key[r], d);
            u = _mm256_add_epi32(u, sine);
            v = _mm256_add_epi32(v, cosine);
        }
    } while (++k < t->count);
    __m256i ranks = _mm256_sub_epi32(_mm256_sll_epi32(_mm256_set1_epi32(1), bits), _mm256_set1_epi32(1));
    __m256i most = key[0];
    for (int r = 0; r < PV_TILE; r++) {
        t->owner[r] = _mm256_and_si256(key[r], ranks);
        most = _mm256_max_epu32(most, key[r]);
    }
    *farthest = _mm256_max_epu32(*farthest, _mm256_srl_epi32(most, bits));
}

/* The owners of four rows as bytes: columns 0..3 of each row, then columns 4..7 of each. */
static inline __m256i pack(const __m256i *row)
{
    return _mm256_packus_epi16(_mm256_packus_epi32(row[0], row[1]), _mm256_packus_epi32(row[2], row[3]));
}

static inline int64_t bits_in(uint64_t v)
{
    return (int64_t)_mm_popcnt_u64(v);
}

/* Adds the pixels of `inside`, a bit for each in the order of pack, to their owners' sums. */
static inline void collect(const tile *t, uint64_t inside, pv_sum *sums)
{
    __m256i top = pack(t->owner), bottom = pack(t->owner + 4), rank = _mm256_setzero_si256();
    int64_t x0 = t->x0, y0 = t->y0;
    for (int32_t k = 0; k < t->count; k++) {
        uint64_t low = (uint32_t)_mm256_movemask_epi8(_mm256_cmpeq_epi8(top, rank));
        uint64_t high = (uint32_t)_mm256_movemask_epi8(_mm256_cmpeq_epi8(bottom, rank));
        uint64_t mine = (high << 32 | low) & inside;
        int64_t count = bits_in(mine);
        int64_t x = bits_in(mine & 0xaaaaaaaaaaaaaaaa) + 2 * bits_in(mine & 0xcccccccccccccccc) +
                    4 * bits_in(mine & 0xffff0000ffff0000);
        int64_t y = bits_in(mine & 0xf0f0f0f0f0f0f0f0) + 2 * bits_in(mine & 0xff00ff00ff00ff00) +
                    4 * bits_in(mine >> 32);
        pv_sum_add(&sums[t->index[k]], count, count * x0 + x, count * y0 + y);
        rank = _mm256_sub_epi8(rank, _mm256_set1_epi8(-1));
    }
}

/* The tile's pixels inside the plane, in the order of pack. */
static inline uint64_t inside_of(int32_t columns, int32_t rows)
{
    uint64_t left = (1u << min(columns, 4)) - 1, right = (1u << max(columns - 4, 0)) - 1, row = right << 16 | left;
    uint64_t inside = 0;
    for (int32_t r = 0; r < rows; r++)
        inside |= row << (r % 4 * 4 + r / 4 * 32);
    return inside;
}

static inline void write_labels(const pv_cpu *cpu, const tile *t, int32_t columns, int32_t rows, int32_t *labels)
{
    const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    __m256i inside = _mm256_cmpgt_epi32(_mm256_set1_epi32(columns), lanes);
    int32_t *to = labels + (int64_t)t->y0 * cpu->plane.width + t->x0;
    for (int32_t r = 0; r < rows; r++, to += cpu->plane.width)
        _mm256_maskstore_epi32(to, inside, _mm256_i32gather_epi32(t->index, t->owner[r], 4));
}

/* The mask of the tile, a bit for each pixel in the order of pack. */
static inline uint64_t mask_of(const pv_cpu *cpu, const tile *t)
{
    uint64_t mask = pv_tile_mask(&cpu->plane, t->x0, t->y0), left = _pext_u64(mask, 0x0f0f0f0f0f0f0f0f);
    uint64_t right = _pext_u64(mask, 0xf0f0f0f0f0f0f0f0);
    return (left & 0xffff) | (right & 0xffff) << 16 | (left >> 16) << 32 | (right >> 16) << 48;
}

/* Finds the tile's candidates. 0 if it does not fit the scheme. */
ALWAYS int find(int32_t metric, const pv_cpu *cpu, tile *t)
{
    __m128i within;
    if (cpu->reach > NEAR - STEP - BOUND || !search(metric, cpu, t, &within))
        return 0;
    list(cpu, t, within);
    t->bits = t->count > 1 ? 32 - __builtin_clz((uint32_t)t->count - 1) : 0;
    uint64_t farthest = (uint64_t)((t->margin - cpu->reach) / cpu->stretch) + ACROSS; /* of a candidate from a pixel */
    return !(farthest * farthest >> (32 - t->bits));
}

ALWAYS void label_tile(int32_t metric, const pv_cpu *cpu, tile *t, __m256i *farthest, pv_sum *sums, int32_t *labels)
{
    sort(t);
    decide(metric, cpu, t, farthest);
    int32_t columns = min(cpu->plane.width - t->x0, PV_TILE), rows = min(cpu->plane.height - t->y0, PV_TILE);
    uint64_t inside = columns + rows == 2 * PV_TILE ? ~(uint64_t)0 : inside_of(columns, rows);
    collect(t, cpu->plane.mask ? inside & ~mask_of(cpu, t) : inside, sums);
    if (labels)
        write_labels(cpu, t, columns, rows, labels);
}

static int32_t first_margin(const pv_cpu *cpu)
{
    return min(cpu->bucket + cpu->reach, NEAR - STEP);
}

ALWAYS int32_t label_row(int32_t metric, const pv_cpu *cpu, int32_t ty, pv_sum *sums, int32_t *labels)
{
    tile t;
    int32_t radius = 0, squares[PV_LANES];
    __m256i farthest = _mm256_setzero_si256();
    t.y0 = ty * PV_TILE;
    t.margin = first_margin(cpu);
    for (t.x0 = 0; t.x0 < cpu->plane.width; t.x0 += PV_TILE) {
        __m256i before = farthest;
        int counts = pv_watched(cpu, t.x0, t.y0);
        if (find(metric, cpu, &t)) {
            label_tile(metric, cpu, &t, &farthest, sums, labels);
            farthest = counts ? farthest : before;
            continue;
        }
        int32_t here = pv_label_tile_portable(cpu, t.x0, t.y0, sums, labels);
        radius = counts ? max(radius, here) : radius;
        t.margin = first_margin(cpu);
    }
    store(squares, farthest);
    for (int i = 0; i < PV_LANES; i++)
        radius = max(radius, pv_cpu_range(cpu, pv_isqrt((uint32_t)squares[i]) + 1 + PV_METRIC_SLACK));
    return radius;
}

int32_t pv_label_row_avx2(const pv_cpu *cpu, int32_t ty, pv_sum *sums, int32_t *labels)
{
    if (cpu->plane.metric == PAVE_METRIC_BOX)
        return label_row(PAVE_METRIC_BOX, cpu, ty, sums, labels);
    if (cpu->plane.metric == PAVE_METRIC_SQUARE)
        return label_row(PAVE_METRIC_SQUARE, cpu, ty, sums, labels);
    return label_row(PAVE_METRIC_DIAMOND, cpu, ty, sums, labels);
}

#ifdef __clang__
#pragma clang attribute pop
#endif

#endif
