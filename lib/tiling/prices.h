/* Prices: what pixels cost besides their seams, for what they are to the whole. */
#pragma once

#include "tiling/tiling.h"

/* How evenly the exemplar is used: the price of each of its cells, and of each brightness, as the canvas is now. */
enum { PV_LEVELS = 256 };
typedef struct pv_coverage {
    const pv_bank *bank;
    int32_t level_price[PV_LEVELS];
    double level_share[PV_LEVELS]; /* of the exemplars' pixels, up to each level */
    int32_t *price;
    int32_t *count;
    int32_t *room; /* usable pixels of each cell */
    double weight;
} pv_coverage;

pave_result pv_coverage_create(pave_context *context, const pv_bank *bank, double weight, pv_coverage *out);
void pv_coverage_free(pv_coverage *coverage);
void pv_coverage_count(pv_coverage *coverage, const pv_canvas *canvas);

/* Where else in a part of the canvas the same pixel of the exemplar shows. */
typedef struct pv_repeats {
    const pv_canvas *canvas;
    pv_area area;
    int32_t *head, *next; /* by place at home, and by pixel of the area: the pixels with the same source */
    int32_t *steps;       /* how many pairs are a step of about so much apart, by PV_STEP px */
    int32_t *step_price;
    int32_t across, down;
    int32_t radius;
    double weight;
} pv_repeats;

enum { PV_STEP = 8 };

pave_result pv_repeats_create(pave_context *context, const pv_canvas *canvas, int32_t most_width, int32_t most_height,
                              int32_t radius, double weight, pv_repeats *out);
void pv_repeats_free(pv_repeats *repeats);
void pv_repeats_count(pv_repeats *repeats, pv_area area);

/* Both together, for pixel (x, y) of the area. */
typedef struct pv_prices {
    const pv_coverage *coverage;
    const pv_repeats *repeats;
    double guide;
} pv_prices;

int32_t pv_price_of(const pv_prices *prices, int32_t x, int32_t y, int32_t place);
