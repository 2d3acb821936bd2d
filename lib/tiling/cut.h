/* Cuts: which pixels of a copy, laid over what is there, are taken. */
#pragma once

#include "tiling/flow.h"
#include "tiling/tiling.h"

#include <math.h>

enum { PV_MUST = 1 << 28 };

typedef struct pv_cut {
    pv_flow flow, coarse; /* of pixels, and of blocks of 2 x 2 */
    uint8_t *state;       /* band.c: of each node */
    int32_t *laid;        /* what is laid, by node of the flow */
    int32_t *unlike;      /* what that differs by from the copy */
    uint8_t *taken;       /* the cut: pixels of the area, row by row, that are the copy's */
} pv_cut;

/* What else a pixel of the area costs with a source; NULL: nothing. */
typedef int32_t pv_price(const void *data, int32_t x, int32_t y, int32_t place);

pave_result pv_cut_create(pave_context *context, int32_t most_width, int32_t most_height, pv_cut *out);
void pv_cut_free(pv_cut *cut);

/* Cuts the copy whose pixel `first` of the bank lies on the area's first one. The area lies within the canvas, or
 * around its border where that wraps, and within the copy. Returns by how much costs fall. The cut is the least of all
 * where pixels are not laid yet, else the least within a band. */
int64_t pv_cut_find(pv_cut *cut, const pv_canvas *canvas, pv_area area, int32_t first, pv_price *price,
                    const void *data);

/* band.c: finds the cut of what the flow holds; returns 0, with the flow as it was, where there is no such cut. `gain`
 * is what is gained without what the flow has left. */
int pv_band_find(pv_cut *cut, int64_t *gain);
int pv_band_taken(const pv_cut *cut, int32_t x, int32_t y);

/* Lays the pixels taken. */
void pv_cut_lay(const uint8_t *taken, pv_canvas *canvas, pv_area area, int32_t first);

/* How two pixels of the bank differ, and how deep inside of stones both are. The root is IEEE's, and so the same
 * everywhere. */
static inline int32_t pv_differ(const pv_bank *bank, int32_t i, int32_t j)
{
    const int16_t *a = bank->values + (int64_t)i * bank->depth, *b = bank->values + (int64_t)j * bank->depth;
    int32_t sum = 0;
    for (int32_t k = 0; k < bank->depth; k++) {
        int32_t d = a[k] - b[k];
        sum += d * d;
    }
    int32_t through = bank->stone[i] < bank->stone[j] ? bank->stone[i] : bank->stone[j];
    return (int32_t)(sqrtf((float)sum) * (PV_COST_UNIT * 255.0f / (float)bank->white)) + through;
}

/* What it costs that a pixel comes from `a` and the next one, a step further, from `b`. */
static inline int32_t pv_seam(const pv_bank *bank, int32_t a, int32_t b, int32_t step)
{
    return a + step == b ? 0 : pv_differ(bank, a, b - step) + pv_differ(bank, a + step, b) + PV_COST_UNIT;
}

static inline int32_t pv_wrapped(int32_t x, int32_t size)
{
    return x < 0 ? x + size : x < size ? x : x - size;
}

/* The pixel of a canvas, whose coordinates may go once around. */
static inline int32_t pv_pixel(const pv_canvas *canvas, int32_t x, int32_t y)
{
    return pv_wrapped(y, canvas->height) * canvas->width + pv_wrapped(x, canvas->width);
}

/* Is there such a pixel? */
static inline int pv_inside(const pv_canvas *canvas, int32_t x, int32_t y)
{
    return (canvas->wrap_x || (x >= 0 && x < canvas->width)) && (canvas->wrap_y || (y >= 0 && y < canvas->height));
}
