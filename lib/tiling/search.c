/* Search: the direct ways. */
#include "tiling/search.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { FEW_PLACES = 8 };

pave_result pv_query_create(pave_context *context, const pv_bank *bank, int32_t most_width, int32_t most_height,
                            pv_query *out)
{
    pave_result result = PAVE_OK;
    memset(out, 0, sizeof *out);
    out->bank = bank;
    out->most = most_width * most_height;
    size_t values = (size_t)out->most * (size_t)bank->depth;
    out->value = pv_allocate(context, values + PV_TAP, sizeof *out->value, &result);
    if (!result)
        out->counts = pv_allocate(context, (size_t)out->most, 1, &result);
    if (!result)
        out->taps = pv_allocate(context, values / PV_TAP + 2 * (size_t)most_height, sizeof *out->taps, &result);
    if (result)
        pv_query_free(out);
    return result;
}

void pv_query_free(pv_query *query)
{
    pv_release(query->value);
    pv_release(query->counts);
    pv_release(query->taps);
    memset(query, 0, sizeof *query);
}

void pv_query_begin(pv_query *query, int32_t width, int32_t height)
{
    query->width = width;
    query->height = height;
    query->tap_count = 0;
    memset(query->counts, 0, (size_t)width * (size_t)height);
}

void pv_query_set(pv_query *query, int32_t x, int32_t y, int32_t place)
{
    size_t depth = (size_t)query->bank->depth, at = (size_t)(y * query->width + x);
    memcpy(query->value + at * depth, query->bank->values + (size_t)place * depth, depth * sizeof *query->value);
    query->counts[at] = 1;
}

/* Values from..from+PV_TAP of row y. */
static void make_tap(const pv_query *query, int32_t y, int32_t from, pv_tap *tap)
{
    int32_t depth = query->bank->depth, all = query->width * depth;
    tap->shift = y * query->bank->stride * depth + from;
    for (int32_t k = 0; k < PV_TAP; k++) {
        int counts = from + k < all && query->counts[y * query->width + (from + k) / depth];
        tap->mask[k] = (int16_t)-counts;
        tap->value[k] = counts ? query->value[y * all + from + k] : 0;
    }
}

void pv_query_end(pv_query *query)
{
    int32_t depth = query->bank->depth;
    query->tap_count = 0;
    for (int32_t y = 0; y < query->height; y++)
        for (int32_t from = 0; from < query->width * depth;)
            if (query->counts[y * query->width + from / depth]) {
                make_tap(query, y, from, &query->taps[query->tap_count++]);
                from += PV_TAP;
            } else {
                from = (from / depth + 1) * depth;
            }
}

int64_t pv_compare_reference(const pv_query *query, int32_t place, int64_t bound)
{
    const pv_bank *bank = query->bank;
    int64_t sum = 0;
    (void)bound;
    for (int32_t i = 0; i < query->width * query->height * bank->depth; i++) {
        int32_t pixel = i / bank->depth, x = pixel % query->width, y = pixel / query->width;
        int64_t there = bank->values[(int64_t)(place + y * bank->stride + x) * bank->depth + i % bank->depth];
        int64_t d = there - query->value[i];
        sum += query->counts[pixel] ? d * d : 0;
    }
    return sum;
}

/* 16 taps of values up to 4095 stay within 32 bits in each of 16 sums. */
int64_t pv_compare_portable(const pv_query *query, int32_t place, int64_t bound)
{
    const int16_t *at = query->bank->values + (int64_t)place * query->bank->depth;
    int64_t sum = 0;
    for (int32_t i = 0; i < query->tap_count && sum < bound;) {
        int32_t part[PV_TAP] = { 0 };
        for (int32_t end = i + PV_TAP < query->tap_count ? i + PV_TAP : query->tap_count; i < end; i++)
            for (int32_t k = 0; k < PV_TAP; k++) {
                int32_t d = (int16_t)((at[query->taps[i].shift + k] - query->taps[i].value[k]) &
                                      query->taps[i].mask[k]);
                part[k] += d * d;
            }
        for (int32_t k = 0; k < PV_TAP; k++)
            sum += part[k];
    }
    return sum;
}

pv_compare *pv_compare_choose(int32_t search)
{
    if (search == PAVE_SEARCH_REFERENCE)
        return pv_compare_reference;
#ifdef PV_SEARCH_AVX2
    if (__builtin_cpu_supports("avx2"))
        return pv_compare_avx2;
#endif
    return pv_compare_portable;
}

pv_places pv_places_all(const pv_sheet *sheet, int32_t width, int32_t height)
{
    int32_t across = sheet->width - width + 1, down = sheet->height - height + 1;
    return (pv_places){ sheet, 0, 0, across > 0 && down > 0 ? across : 0, down > 0 ? down : 0, 1 };
}

pv_places pv_places_even(pv_places p, int32_t x, int32_t y)
{
    int32_t odd_x = (p.x + x) & 1, odd_y = (p.y + y) & 1;
    if (p.across < FEW_PLACES || p.down < FEW_PLACES)
        return p;
    return (pv_places){ p.sheet, p.x + odd_x, p.y + odd_y, (p.across - odd_x + 1) / 2, (p.down - odd_y + 1) / 2, 2 };
}

void pv_search_all(const pv_query *query, pv_places places, pv_compare *compare, int64_t *out)
{
    for (int32_t y = 0; y < places.down; y++)
        for (int32_t x = 0; x < places.across; x++) {
            int32_t place = pv_place_at(query->bank, &places, x, y);
            int clear = pv_bank_clear(query->bank, place, query->width, query->height);
            *out++ = clear ? compare(query, place, PV_NO_PLACE) : PV_NO_PLACE;
        }
}

/* A search by all threads, one task a few rows of places. */
typedef struct scan {
    const pv_query *query;
    pv_compare *compare;
    pv_places places;
    int32_t rows; /* of a task */
    int32_t *best; /* of each task */
    int64_t *least;
    _Atomic int64_t bound; /* the least so far: it only saves time */
} scan;

static void scan_rows(void *data, int32_t task, int32_t worker)
{
    scan *s = data;
    int32_t end = (task + 1) * s->rows < s->places.down ? (task + 1) * s->rows : s->places.down;
    (void)worker;
    s->best[task] = -1;
    s->least[task] = PV_NO_PLACE;
    for (int32_t y = task * s->rows; y < end; y++) {
        int64_t others = atomic_load(&s->bound);
        for (int32_t x = 0; x < s->places.across; x++) {
            int32_t place = pv_place_at(s->query->bank, &s->places, x, y);
            int64_t bound = others < s->least[task] ? others + 1 : s->least[task]; /* equals of earlier rows count */
            if (!pv_bank_clear(s->query->bank, place, s->query->width, s->query->height))
                continue;
            int64_t cost = s->compare(s->query, place, bound);
            if (cost < bound)
                s->least[task] = cost, s->best[task] = place;
        }
        others = atomic_load(&s->bound);
        while (s->least[task] < others && !atomic_compare_exchange_weak(&s->bound, &others, s->least[task]))
            ;
    }
}

static pave_result scan_sheet(pave_context *context, scan *s, int32_t *place, int64_t *difference)
{
    int64_t work = (int64_t)s->places.across * s->query->tap_count;
    s->rows = (int32_t)(2000000 / (work ? work : 1)) + 1;
    int32_t tasks = (s->places.down + s->rows - 1) / s->rows;
    pave_result result = PAVE_OK;
    s->best = pv_allocate(context, (size_t)tasks, sizeof *s->best, &result);
    s->least = result ? NULL : pv_allocate(context, (size_t)tasks, sizeof *s->least, &result);
    atomic_store(&s->bound, *difference);
    if (!result)
        result = pv_parallel(context, tasks, scan_rows, s, 0, 0);
    for (int32_t i = 0; i < tasks && !result; i++)
        if (s->best[i] >= 0 && s->least[i] < *difference)
            *difference = s->least[i], *place = s->best[i];
    pv_release(s->best);
    pv_release(s->least);
    return result;
}

pv_searcher pv_searcher_of(const pave_context *context, const pv_bank *bank, int32_t search)
{
    int vulkan = context->backend == PAVE_BACKEND_VULKAN_COMPUTE || context->backend == PAVE_BACKEND_VULKAN_RASTER;
    search = search == PAVE_SEARCH_AUTO && vulkan ? PAVE_SEARCH_VULKAN : search;
    int named = search != PAVE_SEARCH_AUTO || context->backend != PAVE_BACKEND_AUTO;
    return (pv_searcher){ .bank = bank, .search = search, .may_gpu = named ? PV_GPU_NEVER : PV_GPU_IF_LARGE };
}

void pv_searcher_free(pv_searcher *searcher)
{
    for (int32_t i = 0; i < PV_MOST_EXEMPLARS * PV_TURNS; i++)
        pv_spectra_free(searcher->spectra[i]);
    pv_vulkan_close(searcher);
    memset(searcher, 0, sizeof *searcher);
}

/* Nanoseconds, about: transforms do not care how large the block is. */
static int fft_pays(const pv_query *query, pv_places places)
{
    double pixels = (double)places.sheet->width * places.sheet->height;
    double direct = 0.5 * places.across * (double)places.down * query->tap_count;
    return direct > 2.0 * pixels * (query->bank->depth + 2) * log2(pixels);
}

typedef struct rows {
    const pv_query *query;
    pv_places places;
    pv_compare *compare;
    int64_t *costs;
} rows;

static void search_row(void *data, int32_t row, int32_t worker)
{
    const rows *r = data;
    pv_places one = r->places;
    (void)worker;
    one.y += row * one.step;
    one.down = 1;
    pv_search_all(r->query, one, r->compare, r->costs + (int64_t)row * one.across);
}

static pave_result costs_by_device(pave_context *context, pv_searcher *searcher, const rows *r)
{
    const pv_places *places = &r->places;
    pave_result result = pv_vulkan_costs(context, searcher, r->query, places, r->costs);
    for (int32_t k = 0; k < places->across * places->down && !result; k++)
        if (!pv_bank_clear(r->query->bank, pv_place_at(r->query->bank, places, k % places->across, k / places->across),
                           r->query->width, r->query->height))
            r->costs[k] = PV_NO_PLACE;
    return result;
}

/* A search that takes the CPU tenths of a second, and there is a GPU. */
static int gpu_pays(pave_context *context, const pv_searcher *searcher, const rows *r)
{
    double values = (double)r->places.across * r->places.down * r->query->tap_count * PV_TAP;
    return searcher->may_gpu == PV_GPU_ALWAYS ||
           (searcher->may_gpu == PV_GPU_IF_LARGE && values > 1e9 && pv_vulkan_is_there(context));
}

pave_result pv_search_costs(pave_context *context, pv_searcher *searcher, const pv_query *query,
                            const pv_places *places, int64_t *costs)
{
    rows r = { query, *places, pv_compare_choose(searcher->search), costs };
    if (!places->across)
        return PAVE_OK;
    if (searcher->search == PAVE_SEARCH_VULKAN)
        return costs_by_device(context, searcher, &r);
    if (gpu_pays(context, searcher, &r)) {
        pave_result result = costs_by_device(context, searcher, &r);
        if (result != PAVE_ERR_DEVICE && result != PAVE_ERR_UNSUPPORTED)
            return result;
        pv_note(context, PAVE_MESSAGE_WARNING, "going on with the CPU: %s", context->text);
        searcher->may_gpu = PV_GPU_NEVER;
    }
    return pv_parallel(context, places->down, search_row, &r, 0, 0);
}

static pave_result vulkan_least(pave_context *context, pv_searcher *searcher, const pv_query *query,
                                const pv_places *places, int32_t *place, int64_t *difference)
{
    pave_result result = PAVE_OK;
    int64_t *costs = pv_allocate(context, (size_t)places->across * (size_t)places->down, sizeof *costs, &result);
    if (!result)
        result = pv_search_costs(context, searcher, query, places, costs);
    for (int32_t k = 0; k < places->across * places->down && !result; k++)
        if (costs[k] < *difference) {
            *difference = costs[k];
            *place = pv_place_at(query->bank, places, k % places->across, k / places->across);
        }
    pv_release(costs);
    return result;
}

static pave_result least_of_sheet(pave_context *context, pv_searcher *searcher, const pv_query *query, int32_t i,
                                  int32_t *place, int64_t *difference)
{
    const pv_bank *bank = query->bank;
    pv_places places = pv_places_all(&bank->sheet[i], query->width, query->height);
    scan s = { query, pv_compare_choose(searcher->search), places, 1, NULL, NULL, PV_NO_PLACE };
    pave_result result = PAVE_OK;
    if (!places.across)
        return PAVE_OK;
    if (searcher->search == PAVE_SEARCH_VULKAN)
        return vulkan_least(context, searcher, query, &places, place, difference);
    if (searcher->search != PAVE_SEARCH_FFT && (searcher->search != PAVE_SEARCH_AUTO || !fft_pays(query, places)))
        return scan_sheet(context, &s, place, difference);
    if (!searcher->spectra[i])
        result = pv_spectra_create(context, bank, &bank->sheet[i], &searcher->spectra[i]);
    return result ? result : pv_spectra_least(searcher->spectra[i], query, place, difference);
}

pave_result pv_search_least(pave_context *context, pv_searcher *searcher, const pv_query *query, int32_t *place,
                            int64_t *difference)
{
    pave_result result = PAVE_OK;
    *place = -1;
    *difference = PV_NO_PLACE;
    for (int32_t i = 0; i < query->bank->sheets && !result; i++)
        result = least_of_sheet(context, searcher, query, i, place, difference);
    return result;
}
