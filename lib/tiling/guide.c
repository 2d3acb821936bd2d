/* Guides: the brightness that a result is to follow. */
#include "tiling/tiling.h"

#include <math.h>
#include <string.h>

enum { LEVELS = 4096 };

static int32_t level_of(double value)
{
    value = floor(value * (LEVELS - 1) + 0.5);
    return value > 0 ? value < LEVELS ? (int32_t)value : LEVELS - 1 : 0;
}

/* Mean of the colours; what is not finite counts as dark. Whole-number types have their own range, others 0..1. */
static int32_t brightness(const pave_image *guide, int64_t pixel)
{
    double sum = 0;
    int32_t count = 0;
    for (int32_t c = 0; c < guide->channels; c++) {
        double value = pv_image_value(guide, pixel * guide->channels + c);
        if (c == guide->alpha && guide->channels > 1)
            continue;
        sum += isfinite(value) ? value : 0;
        count++;
    }
    return level_of(sum / count);
}

/* For each level of the guide, the exemplars' brightness that as many of their pixels are under. */
static void make_curve(const pv_bank *bank, const int64_t *guide, int64_t pixels, const int64_t *own, int16_t *curve)
{
    int64_t below = 0, under = own[0];
    int32_t level = 0;
    for (int32_t i = 0; i < LEVELS; i++) {
        double middle = ((double)below + guide[i] / 2.0) / (double)pixels;
        while (level < bank->white && (double)under < middle * (double)bank->usable_count)
            under += own[++level];
        curve[i] = (int16_t)level;
        below += guide[i];
    }
}

pave_result pv_guide_read(pave_context *context, const pv_bank *bank, const pave_image *guide, int16_t **tones)
{
    pave_result result = PAVE_OK;
    int64_t n = (int64_t)guide->width * guide->height;
    int64_t *counts = pv_allocate_zeroed(context, 2 * LEVELS, sizeof *counts, &result), *own = counts + LEVELS;
    int16_t *curve = result ? NULL : pv_allocate(context, LEVELS, sizeof *curve, &result);
    *tones = result ? NULL : pv_allocate(context, (size_t)n, sizeof **tones, &result);
    for (int64_t i = 0; i < n && !result; i++)
        counts[brightness(guide, i)]++;
    for (int32_t i = 0; i < bank->pixels && !result; i++)
        if (bank->usable[i] && bank->home[i] == i)
            own[bank->bright[i]]++;
    if (!result)
        make_curve(bank, counts, n, own, curve);
    for (int64_t i = 0; i < n && !result; i++)
        (*tones)[i] = curve[brightness(guide, i)];
    pv_release(counts);
    pv_release(curve);
    return result;
}
