/* Search: how much a block differs from what lies at every place of the bank (Eq. 1), in whole numbers. */
#pragma once

#include "base/parallel.h"
#include "tiling/bank.h"

enum { PV_TAP = 16 /* values that are compared at once */ };

/* A run of values of the block: where it lies from the block's first one, what is there, and what of it counts. */
typedef struct pv_tap {
    int32_t shift, unused[7];
    int16_t value[PV_TAP], mask[PV_TAP];
} pv_tap;

/* The block searched for. */
typedef struct pv_query {
    const pv_bank *bank;
    int32_t width, height; /* px */
    int32_t most;          /* px there is room for */
    int16_t *value;        /* as many a pixel as the bank has */
    uint8_t *counts;       /* which pixels do */
    pv_tap *taps;
    int32_t tap_count;
} pv_query;

pave_result pv_query_create(pave_context *context, const pv_bank *bank, int32_t most_width, int32_t most_height,
                            pv_query *out);
void pv_query_free(pv_query *query);

/* Makes a block of this size with nothing in it that counts; value and counts are then to be set, and after that
 * pv_query_end called. */
void pv_query_begin(pv_query *query, int32_t width, int32_t height);
void pv_query_end(pv_query *query);

/* Sets a pixel to what lies at a place. */
void pv_query_set(pv_query *query, int32_t x, int32_t y, int32_t place);

/* A part of a sheet, of places for the block's first pixel, every one or every `step`th of them across and down. */
typedef struct pv_places {
    const pv_sheet *sheet;
    int32_t x, y, across, down, step;
} pv_places;

/* The places of a sheet where the block has room; none: across is 0. */
pv_places pv_places_all(const pv_sheet *sheet, int32_t width, int32_t height);

/* Of many places, those an even number of px from (x, y): a quarter of the work. Copies that all lie on one raster of
 * 2 px also stay copies when a result is halved, as mip maps are. */
pv_places pv_places_even(pv_places places, int32_t x, int32_t y);

static inline int32_t pv_place_at(const pv_bank *bank, const pv_places *places, int32_t x, int32_t y)
{
    return places->sheet->first + (places->y + y * places->step) * bank->stride + places->x + x * places->step;
}

/* One difference; anything from `bound` on may be told instead if it is not less than that. */
typedef int64_t pv_compare(const pv_query *query, int32_t place, int64_t bound);
pv_compare pv_compare_reference, pv_compare_portable;
#ifdef __x86_64__
#define PV_SEARCH_AVX2 1
pv_compare pv_compare_avx2;
#endif
pv_compare *pv_compare_choose(int32_t search);

/* The differences at `places`, row by row; PV_NO_PLACE where a pixel of the block would not be usable. */
#define PV_NO_PLACE INT64_MAX
void pv_search_all(const pv_query *query, pv_places places, pv_compare *compare, int64_t *out);

/* search_fft.c: one sheet's spectra. Lowers *difference, and sets *place, if there is a lesser one in the sheet. */
typedef struct pv_spectra pv_spectra;
pave_result pv_spectra_create(pave_context *context, const pv_bank *bank, const pv_sheet *sheet, pv_spectra **out);
void pv_spectra_free(pv_spectra *spectra);
pave_result pv_spectra_least(pv_spectra *spectra, const pv_query *query, int32_t *place, int64_t *difference);

/* May a device be tried? */
enum { PV_GPU_NEVER = 0, PV_GPU_IF_LARGE = 1, PV_GPU_ALWAYS = 2 /* tests */ };

/* What searches of one bank share. */
typedef struct pv_searcher {
    const pv_bank *bank;
    int32_t search;
    int32_t may_gpu;                                   /* PV_GPU_; if nobody chose, large searches try one */
    pv_spectra *spectra[PV_MOST_EXEMPLARS * PV_TURNS]; /* made when first used */
    struct pv_matcher *matcher;                        /* on a graphics device, opened when first used */
} pv_searcher;

/* Resolves PAVE_SEARCH_AUTO by the context's backend: on a Vulkan backend, by Vulkan. Who names a device gets an error
 * where it fails; if neither is named, a GPU does what is large, and where it fails the CPU goes on. */
pv_searcher pv_searcher_of(const pave_context *context, const pv_bank *bank, int32_t search);
void pv_searcher_free(pv_searcher *searcher);

/* The differences at places of one sheet, as pv_search_all, by all threads or the graphics device. */
pave_result pv_search_costs(pave_context *context, pv_searcher *searcher, const pv_query *query,
                            const pv_places *places, int64_t *costs);

/* search_vulkan.c: the same on the device, but for places that are not usable. */
pave_result pv_vulkan_costs(pave_context *context, pv_searcher *searcher, const pv_query *query,
                            const pv_places *places, int64_t *costs);
void pv_vulkan_close(pv_searcher *searcher);
int pv_vulkan_is_there(pave_context *context); /* a GPU; software does not count */

/* The place with the least difference, the first in scan order among equals, over all sheets; -1: there is none. Works
 * with all threads. */
pave_result pv_search_least(pave_context *context, pv_searcher *searcher, const pv_query *query, int32_t *place,
                            int64_t *difference);
