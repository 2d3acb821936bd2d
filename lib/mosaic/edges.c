/* Edges: found as Canny does, on the colour gradient of CIELAB; or taken from a mask and thinned; or drawn. */
#include "mosaic/mosaic.h"

#include "base/parallel.h"
#include "image/image.h"

#include <math.h>
#include <string.h>

enum { MOST_TAPS = 65, CHANNELS = 3 };

typedef struct finding {
    const pv_photo *photo;
    int32_t width, height, wraps, radius;
    float weight[MOST_TAPS];
    float *across, *smooth; /* CIELAB, blurred along rows and then along columns */
    float *slope;           /* of the colour: how steep, and its direction as a unit vector */
    uint16_t *ridge;        /* slope where it is greatest across the edge, in 1/64 */
} finding;

/* A triweight kernel is as good as a Gaussian, and exact. */
static void set_kernel(finding *f, double sigma)
{
    double sum = 0, reach = 3 * sigma;
    f->radius = (int32_t)reach < MOST_TAPS / 2 ? (int32_t)reach : MOST_TAPS / 2;
    for (int32_t k = -f->radius; k <= f->radius; k++) {
        double t = 1 - (k / (reach + 1e-9)) * (k / (reach + 1e-9));
        f->weight[k + f->radius] = (float)(t * t * t);
        sum += t * t * t;
    }
    for (int32_t k = 0; k <= 2 * f->radius; k++)
        f->weight[k] = (float)(f->weight[k] / sum);
}

static void blur_across(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const finding *f = data;
    const float *from = f->photo->lab + (int64_t)y * f->width * CHANNELS;
    float *to = f->across + (int64_t)y * f->width * CHANNELS;
    int32_t r = f->radius, inner = f->width - 2 * r > 0 ? f->width - 2 * r : 0;
    memset(to, 0, (size_t)f->width * CHANNELS * sizeof *to);
    for (int32_t k = 0; k <= 2 * r; k++)
        for (int32_t i = 0; i < inner * CHANNELS; i++)
            to[r * CHANNELS + i] += f->weight[k] * from[k * CHANNELS + i];
    for (int32_t x = 0; x < f->width; x++) {
        if (x == r && inner)
            x += inner;
        for (int32_t k = -r; k <= r && x < f->width; k++)
            for (int32_t c = 0; c < CHANNELS; c++)
                to[x * CHANNELS + c] += f->weight[k + r] * from[pv_inside(x + k, f->width, f->wraps) * CHANNELS + c];
    }
}

static void blur_down(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const finding *f = data;
    size_t row = (size_t)f->width * CHANNELS;
    float *to = f->smooth + (size_t)y * row;
    memset(to, 0, row * sizeof *to);
    for (int32_t k = -f->radius; k <= f->radius; k++) {
        const float *from = f->across + (size_t)pv_inside(y + k, f->height, f->wraps) * row;
        const float w = f->weight[k + f->radius];
        for (size_t i = 0; i < row; i++)
            to[i] += w * from[i];
    }
}

/* Di Zenzo: the steepest change of all channels together. */
static void find_slopes(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const finding *f = data;
    size_t row = (size_t)f->width * CHANNELS;
    const float *here = f->smooth + (size_t)y * row;
    const float *up = f->smooth + (size_t)pv_inside(y - 1, f->height, f->wraps) * row;
    const float *down = f->smooth + (size_t)pv_inside(y + 1, f->height, f->wraps) * row;
    for (int32_t x = 0; x < f->width; x++) {
        float xx = 0, xy = 0, yy = 0, *out = f->slope + 3 * ((int64_t)y * f->width + x);
        int32_t before = pv_inside(x - 1, f->width, f->wraps), after = pv_inside(x + 1, f->width, f->wraps);
        for (int32_t c = 0; c < CHANNELS; c++) {
            float gx = here[after * CHANNELS + c] - here[before * CHANNELS + c];
            float gy = down[x * CHANNELS + c] - up[x * CHANNELS + c];
            xx += gx * gx, xy += gx * gy, yy += gy * gy;
        }
        float split = sqrtf((xx - yy) * (xx - yy) + 4 * xy * xy), cosine = split > 0 ? (xx - yy) / split : 1;
        out[0] = sqrtf((xx + yy + split) / 2) / 2;
        out[1] = sqrtf((1 + cosine) / 2);
        out[2] = sqrtf((1 - cosine) / 2) * (xy < 0 ? -1 : 1);
    }
}

static float slope_at(const finding *f, double x, double y)
{
    int32_t ix = (int32_t)floor(x), iy = (int32_t)floor(y);
    int32_t x0 = pv_inside(ix, f->width, f->wraps), x1 = pv_inside(ix + 1, f->width, f->wraps);
    float fx = (float)(x - ix), fy = (float)(y - iy);
    const float *up = f->slope + 3 * (int64_t)pv_inside(iy, f->height, f->wraps) * f->width;
    const float *down = f->slope + 3 * (int64_t)pv_inside(iy + 1, f->height, f->wraps) * f->width;
    float a = up[3 * x0] + fx * (up[3 * x1] - up[3 * x0]), b = down[3 * x0] + fx * (down[3 * x1] - down[3 * x0]);
    return a + fy * (b - a);
}

static void find_ridges(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const finding *f = data;
    const float faint = 0.3f; /* of CIELAB a px: less is noise */
    for (int32_t x = 0; x < f->width; x++) {
        const float *s = f->slope + 3 * ((int64_t)y * f->width + x);
        int highest = s[0] > faint && s[0] >= slope_at(f, x - (double)s[1], y - (double)s[2]) &&
                      s[0] > slope_at(f, x + (double)s[1], y + (double)s[2]);
        float v = s[0] * 64 + 0.5f;
        f->ridge[(int64_t)y * f->width + x] = highest ? (uint16_t)(v < 65535 ? v : 65535) : 0;
    }
}

/* The slope that a share of all pixels does not reach, in the unit of ridges. */
static int32_t quantile(const finding *f, double share, int64_t *bins)
{
    int64_t pixels = (int64_t)f->width * f->height, sum = 0;
    memset(bins, 0, 65536 * sizeof *bins);
    for (int64_t i = 0; i < pixels; i++) {
        float v = f->slope[3 * i] * 64 + 0.5f;
        bins[v < 65535 ? (int32_t)v : 65535]++;
    }
    int32_t at = 0;
    for (; at < 65535 && sum + bins[at] <= share * (double)pixels; at++)
        sum += bins[at];
    return at;
}

/* From strong ridges along all that are not weak. */
static void follow(const finding *f, int32_t low, int32_t high, int32_t *stack, uint8_t *edge)
{
    int64_t pixels = (int64_t)f->width * f->height;
    for (int64_t i = 0; i < pixels; i++) {
        if (f->ridge[i] < high || edge[i])
            continue;
        int32_t count = 1;
        stack[0] = (int32_t)i;
        edge[i] = 1;
        while (count) {
            int32_t at = stack[--count], x = at % f->width, y = at / f->width;
            for (int32_t k = 0; k < 9; k++) {
                int32_t nx = pv_inside(x + k % 3 - 1, f->width, f->wraps);
                int32_t ny = pv_inside(y + k / 3 - 1, f->height, f->wraps), n = ny * f->width + nx;
                if (edge[n] || f->ridge[n] < low)
                    continue;
                edge[n] = 1;
                stack[count++] = n;
            }
        }
    }
}

static pave_result find(pave_context *context, finding *f, double strength, pave_guide *guide)
{
    pave_result result = PAVE_OK;
    size_t pixels = (size_t)f->width * (size_t)f->height;
    int64_t *bins = NULL;
    f->across = pv_allocate(context, CHANNELS * pixels, sizeof *f->across, &result);
    if (!result)
        f->smooth = pv_allocate(context, CHANNELS * pixels, sizeof *f->smooth, &result);
    if (!result)
        f->ridge = pv_allocate(context, pixels, sizeof *f->ridge, &result);
    if (!result)
        bins = pv_allocate(context, 65536, sizeof *bins, &result);
    if (!result)
        result = pv_parallel(context, f->height, blur_across, f, 0, 0.3);
    if (!result)
        result = pv_parallel(context, f->height, blur_down, f, 0.3, 0.6);
    f->slope = f->across; /* no longer needed */
    if (!result)
        result = pv_parallel(context, f->height, find_slopes, f, 0.6, 0.8);
    if (!result)
        result = pv_parallel(context, f->height, find_ridges, f, 0.8, 1);
    if (!result) {
        int32_t high = quantile(f, 1 - 0.14 * strength, bins), low = quantile(f, 1 - 0.4 * strength, bins);
        follow(f, low > 1 ? low : 1, high > 1 ? high : 1, (int32_t *)(void *)f->smooth, guide->edge);
    }
    pv_release(bins);
    return result;
}

pave_result pv_edges_find(pave_context *context, const pv_photo *photo, double side, double strength,
                          pave_guide *guide)
{
    finding f = { .photo = photo, .width = photo->width, .height = photo->height, .wraps = guide->wraps };
    if (strength <= 0)
        return PAVE_OK;
    set_kernel(&f, side * 0.12 > 0.5 ? side * 0.12 : 0.5);
    pave_result result = find(context, &f, strength, guide);
    pv_release(f.across);
    pv_release(f.smooth);
    pv_release(f.ridge);
    return result;
}

/* The eight neighbours of a pixel as bits, clockwise from above. */
static uint32_t around(const pave_guide *guide, int32_t x, int32_t y)
{
    static const int8_t way[8][2] = { { 0, -1 }, { 1, -1 }, { 1, 0 }, { 1, 1 }, { 0, 1 }, { -1, 1 }, { -1, 0 },
                                      { -1, -1 } };
    uint32_t bits = 0;
    for (int k = 0; k < 8; k++) {
        int32_t nx = x + way[k][0], ny = y + way[k][1], in = guide->wraps;
        in |= nx >= 0 && ny >= 0 && nx < guide->width && ny < guide->height;
        if (in && guide->edge[(int64_t)pv_inside(ny, guide->height, 1) * guide->width + pv_inside(nx, guide->width, 1)])
            bits |= 1u << k;
    }
    return bits;
}

/* May the pixel go without cutting a line? Zhang and Suen 1984, one of two kinds of pass. */
static int is_rind(uint32_t n, int pass)
{
    int count = __builtin_popcount(n), rises = __builtin_popcount(~n & (n >> 1 | n << 7) & 0xff);
    uint32_t first = pass ? 0x45 : 0x15, second = pass ? 0x51 : 0x54; /* up, right, down, left are bits 0, 2, 4, 6 */
    return count >= 2 && count <= 6 && rises == 1 && (n & first) != first && (n & second) != second;
}

static int64_t thin_once(pave_guide *guide, int pass)
{
    uint8_t *marks = guide->edge;
    int64_t gone = 0;
    for (int32_t y = 0; y < guide->height; y++)
        for (int32_t x = 0; x < guide->width; x++)
            if (marks[(int64_t)y * guide->width + x] && is_rind(around(guide, x, y), pass))
                marks[(int64_t)y * guide->width + x] = 2;
    for (int64_t i = 0; i < (int64_t)guide->width * guide->height; i++) {
        gone += marks[i] == 2;
        marks[i] = marks[i] == 1;
    }
    return gone;
}

static pave_result thin(pave_context *context, pave_guide *guide)
{
    pave_result result = PAVE_OK;
    for (int64_t gone = 1; gone && !result; result = pv_progress(context, 0))
        gone = thin_once(guide, 0) + thin_once(guide, 1);
    return result;
}

pave_result pv_edges_take(pave_context *context, const pave_image *mask, pave_guide *guide)
{
    pave_image *drawing = NULL;
    pave_result result = pave_image_threshold(context, mask, NULL, &drawing);
    if (result)
        return result;
    const uint8_t *pixels = drawing->pixels;
    for (int64_t i = 0; i < (int64_t)guide->width * guide->height; i++)
        guide->edge[i] |= pixels[i] == 255;
    pave_image_free(&drawing);
    return thin(context, guide);
}

enum { MOST_ROUNDS = 64 }; /* that a line may go around a photo whose borders meet */

/* Cuts the part of a line, 0..1, in which from + t * way is within 0..length. */
static void cut_part(double from, double way, double length, double part[2])
{
    double one = -from / way, other = (length - from) / way;
    if (way == 0) {
        part[1] = from >= 0 && from <= length ? part[1] : -1;
        return;
    }
    part[0] = fmax(part[0], fmin(one, other));
    part[1] = fmin(part[1], fmax(one, other));
}

/* No more of it is gone along than may be seen. */
static void draw_line(pave_guide *guide, const double *a, const double *b)
{
    double dx = b[0] - a[0], dy = b[1] - a[1], most = fmax(fabs(dx), fabs(dy)), part[2] = { 0, 1 };
    if (!guide->wraps) {
        cut_part(a[0], dx, guide->width, part);
        cut_part(a[1], dy, guide->height, part);
    }
    if (!(most < (guide->wraps ? MOST_ROUNDS * (double)(guide->width + guide->height) : 1e9)) || part[0] > part[1])
        return;
    int64_t steps = (int64_t)ceil(most) + 1, last = (int64_t)ceil(part[1] * (double)steps);
    double d2 = dx * dx + dy * dy, c = d2 > 0 ? (dx * dx - dy * dy) / d2 : 0, s = d2 > 0 ? 2 * dx * dy / d2 : 0;
    for (int64_t i = (int64_t)floor(part[0] * (double)steps); i <= last; i++) {
        double x = floor(a[0] + dx * (double)i / (double)steps), y = floor(a[1] + dy * (double)i / (double)steps);
        if (guide->wraps) {
            x -= floor(x / guide->width) * guide->width;
            y -= floor(y / guide->height) * guide->height;
        }
        int64_t at = (int64_t)y * guide->width + (int64_t)x;
        if (!(x >= 0 && y >= 0 && x < guide->width && y < guide->height))
            continue;
        guide->edge[at] = 1;
        guide->way[2 * at] = (float)c;
        guide->way[2 * at + 1] = (float)s;
    }
}

void pv_edges_draw(const pave_curves *curves, pave_guide *guide)
{
    for (int32_t c = 0; c < curves->count; c++)
        for (int64_t i = curves->starts[c]; i + 1 < curves->starts[c + 1]; i++)
            draw_line(guide, curves->points + 2 * i, curves->points + 2 * i + 2);
}
