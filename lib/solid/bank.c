/* The sample: windows, pyramid, neighbourhoods, histograms. */
#include "solid/bank.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* exp(-x) without libm, whose last digits differ: (1 - x/1024)^1024 by squaring. */
static double decay(double x)
{
    double v = x < 1024 ? 1 - x / 1024 : 0;
    for (int i = 0; i < 10; i++)
        v *= v;
    return v;
}

static pave_result create_window(pave_context *context, int32_t side, int32_t features, double sigma, pv_window *out)
{
    enum { LANES = 16, MOST = 1900 };
    pave_result result = PAVE_OK;
    int32_t r = side / 2, taps = side * side * features;
    *out = (pv_window){ side, r, features, taps, (taps + LANES - 1) / LANES * LANES, NULL, 0, 0 };
    out->root = pv_allocate_zeroed(context, (size_t)out->stride, sizeof *out->root, &result);
    if (!out->root)
        return result;
    double all = 0;
    for (int32_t y = -r; y <= r; y++)
        for (int32_t x = -r; x <= r; x++)
            all += decay((x * x + y * y) / (2 * sigma * sigma));
    double scale = fmin(45, sqrt(MOST / (all * features)));
    for (int32_t i = 0; i < side * side; i++) {
        int32_t x = i % side - r, y = i / side - r;
        int32_t root = (int32_t)floor(scale * decay((x * x + y * y) / (4 * sigma * sigma)) + 0.5);
        if (!x && !y)
            out->centre = root * root;
        else
            out->total += root * root;
        for (int32_t f = 0; f < features; f++)
            out->root[i * features + f] = (int16_t)(x || y ? root : 0);
    }
    return PAVE_OK;
}

static pave_result texels_create(pave_context *context, int32_t width, int32_t height, int32_t features, pv_texels *out)
{
    pave_result result = PAVE_OK;
    *out = (pv_texels){ width, height, features, NULL, NULL };
    size_t count = (size_t)width * (size_t)height;
    out->feature = pv_allocate(context, count, (size_t)features, &result);
    if (out->feature)
        out->class = pv_allocate(context, count, 1, &result);
    return result;
}

void pv_texels_free(pv_texels *texels)
{
    pv_release(texels->feature);
    pv_release(texels->class);
    memset(texels, 0, sizeof *texels);
}

/* The class of four: of labels the one that most have, the first of equals; else the mean. */
static uint8_t four(const uint8_t c[4], int labels)
{
    int best = 0, most = 0;
    if (!labels)
        return (uint8_t)((c[0] + c[1] + c[2] + c[3] + 2) / 4);
    for (int i = 0; i < 4; i++) {
        int same = 0;
        for (int j = 0; j < 4; j++)
            same += c[i] == c[j];
        if (same > most)
            most = same, best = i;
    }
    return c[best];
}

pave_result pv_texels_halve(pave_context *context, const pv_texels *from, int labels, pv_texels *out)
{
    int32_t n = from->features;
    pave_result result = texels_create(context, from->width / 2, from->height / 2, n, out);
    for (int32_t y = 0; y < out->height && !result; y++)
        for (int32_t x = 0; x < out->width; x++) {
            size_t to = (size_t)y * (size_t)out->width + (size_t)x;
            size_t a = (size_t)(2 * y) * (size_t)from->width + (size_t)(2 * x), b = a + (size_t)from->width;
            const uint8_t c[4] = { from->class[a], from->class[a + 1], from->class[b], from->class[b + 1] };
            const uint8_t *fa = from->feature + a * (size_t)n, *fb = from->feature + b * (size_t)n;
            for (int32_t f = 0; f < n; f++)
                out->feature[to * (size_t)n + (size_t)f] = (uint8_t)((fa[f] + fa[f + n] + fb[f] + fb[f + n] + 2) / 4);
            out->class[to] = four(c, labels);
        }
    return result;
}

/* Copies the texels, and once more transposed. */
static void copy_texels(const pv_texels *from, pv_windows *bank)
{
    size_t w = (size_t)from->width, h = (size_t)from->height, n = (size_t)from->features;
    memcpy(bank->feature, from->feature, w * h * n);
    memcpy(bank->class, from->class, w * h);
    for (size_t y = 0; y < w && bank->copies == 2; y++)
        for (size_t x = 0; x < h; x++) {
            memcpy(bank->feature + (w * h + y * h + x) * n, from->feature + (x * w + y) * n, n);
            bank->class[w * h + y * h + x] = from->class[x * w + y];
        }
}

static void fill_patch(pv_windows *bank, int32_t position, int32_t row)
{
    const pv_window *w = &bank->window;
    int32_t n = bank->features, wide = w->side * n;
    int16_t *to = bank->patch + (size_t)position * (size_t)w->stride;
    for (int32_t y = 0; y < w->side; y++) {
        const uint8_t *from = bank->feature + (size_t)(position + (y - w->radius) * row - w->radius) * (size_t)n;
        for (int32_t i = 0; i < wide; i++)
            to[y * wide + i] = (int16_t)(from[i] * w->root[y * wide + i]);
    }
}

static void fill_patches(pv_windows *bank)
{
    int32_t r = bank->window.radius, area = bank->width * bank->height;
    for (int32_t p = 0; p < bank->positions; p++) {
        int32_t row = pv_windows_row(bank, p), i = p % area, x = i % row, y = i / row;
        bank->inside[p] = x >= r && y >= r && x < row - r && y < area / row - r;
        if (bank->inside[p])
            fill_patch(bank, p, row);
    }
}

static void count_classes(pv_windows *bank)
{
    int32_t at[PV_CLASSES], area = bank->width * bank->height;
    for (int32_t p = 0; p < area; p++)
        bank->target[bank->class[p]]++;
    bank->target_total = area;
    for (int32_t p = 0; p < bank->positions; p++)
        bank->class_start[bank->class[p] + 1] += bank->inside[p];
    for (int32_t c = 0; c < PV_CLASSES; c++) {
        bank->class_start[c + 1] += bank->class_start[c];
        at[c] = bank->class_start[c];
    }
    for (int32_t p = 0; p < bank->positions; p++)
        if (bank->inside[p])
            bank->inner[at[bank->class[p]]++] = p;
    bank->inner_count = bank->class_start[PV_CLASSES];
}

static void count_apart(pv_windows *bank, int which, int32_t lag)
{
    for (int32_t y = 0; y < bank->height; y++)
        for (int32_t x = 0; x < bank->width; x++) {
            const uint8_t *here = bank->class + y * bank->width + x;
            if (x + lag < bank->width)
                bank->apart[0][which][abs(here[0] - here[lag])]++;
            if (y + lag < bank->height)
                bank->apart[1][which][abs(here[0] - here[lag * bank->width])]++;
        }
}

void pv_steps_create(const int64_t counts[PV_CLASSES], pv_steps *out)
{
    int64_t seen = 0;
    memset(out, 0, sizeof *out);
    for (int32_t d = 0; d < PV_CLASSES; d++)
        out->total += counts[d];
    for (int32_t d = 0; d < PV_CLASSES && out->total; d++) {
        int64_t bin = (seen + counts[d] / 2) * PV_STEPS / out->total;
        out->bin[d] = (uint8_t)(bin < PV_STEPS ? bin : PV_STEPS - 1);
        out->target[out->bin[d]] += counts[d];
        seen += counts[d];
    }
}

static void measure_variance(pv_windows *bank)
{
    int64_t n = (int64_t)bank->width * bank->height;
    for (int32_t f = 0; f < bank->features; f++) {
        int64_t sum = 0, squares = 0;
        for (int64_t i = 0; i < n; i++) {
            int64_t v = bank->feature[i * bank->features + f];
            sum += v;
            squares += v * v;
        }
        bank->variance += (squares - sum * sum / n) / n;
    }
}

static pave_result allocate(pave_context *context, pv_windows *bank)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)bank->positions;
    bank->feature = pv_allocate(context, n, (size_t)bank->features, &result);
    bank->class = result ? NULL : pv_allocate(context, n, 1, &result);
    bank->inside = result ? NULL : pv_allocate(context, n, 1, &result);
    if (!result)
        bank->patch = pv_allocate_zeroed(context, n * (size_t)bank->window.stride, sizeof *bank->patch, &result);
    bank->nearest = result ? NULL : pv_allocate(context, n * PV_NEAREST, sizeof *bank->nearest, &result);
    bank->inner = result ? NULL : pv_allocate(context, n, sizeof *bank->inner, &result);
    return result;
}

pave_result pv_windows_create(pave_context *context, const pv_texels *texels, int32_t side, double sigma,
                              int transposed, int alike, uint64_t seed, pv_windows *bank)
{
    memset(bank, 0, sizeof *bank);
    bank->width = texels->width;
    bank->height = texels->height;
    bank->features = texels->features;
    bank->copies = transposed ? 2 : 1;
    bank->positions = bank->copies * bank->width * bank->height;
    pave_result result = create_window(context, side, texels->features, sigma, &bank->window);
    if (!result)
        result = allocate(context, bank);
    if (result)
        return result;
    copy_texels(texels, bank);
    fill_patches(bank);
    count_classes(bank);
    count_apart(bank, 0, 1);
    count_apart(bank, 1, PV_FAR);
    measure_variance(bank);
    memset(bank->nearest, -1, (size_t)bank->positions * PV_NEAREST * sizeof *bank->nearest);
    return alike ? pv_windows_alike(context, bank, seed) : PAVE_OK;
}

void pv_windows_free(pv_windows *bank)
{
    pv_release(bank->window.root);
    pv_release(bank->feature);
    pv_release(bank->class);
    pv_release(bank->inside);
    pv_release(bank->patch);
    pv_release(bank->nearest);
    pv_release(bank->inner);
    memset(bank, 0, sizeof *bank);
}
