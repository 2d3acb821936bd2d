/* How large tiles are to be where (5.2): from an image, from its regions as in Fig. 10b, or from the photo's detail. */
#include "mosaic/mosaic.h"

#include "image/image.h"

#include <math.h>
#include <string.h>

#define LEAST_SIZE 0.1

static double channel(const pave_image *image, int64_t pixel, const char *name)
{
    int32_t c = pv_image_channel(image, name);
    return pv_image_value(image, pixel * image->channels + (c < 0 ? 0 : c));
}

/* Blue is background, green figure, magenta detail. */
static double region_size(const pv_work *w, const pave_image *image, int64_t pixel)
{
    double r = channel(image, pixel, "R"), g = channel(image, pixel, "G"), b = channel(image, pixel, "B");
    if (g >= r && g >= b)
        return w->params->size_figure;
    return r > 0.5 * b ? w->params->size_detail : 1;
}

static double image_size(const pave_image *image, int64_t pixel)
{
    double v = 0.299 * channel(image, pixel, "R") + 0.587 * channel(image, pixel, "G") +
               0.114 * channel(image, pixel, "B");
    return v > LEAST_SIZE ? v < 1 ? v : 1 : LEAST_SIZE;
}

/* Sums over all pixels above and left of a corner, of L and of its square, or of a size. */
static void add_up(const pv_work *w, int squares, const float *from, int32_t stride, double *sum)
{
    size_t row = (size_t)w->width + 1;
    memset(sum, 0, row * sizeof *sum);
    for (int32_t y = 0; y < w->height; y++) {
        double run = 0;
        sum[((size_t)y + 1) * row] = 0;
        for (int32_t x = 0; x < w->width; x++) {
            double v = (double)from[stride * ((int64_t)y * w->width + x)];
            run += squares ? v * v : v;
            sum[((size_t)y + 1) * row + (size_t)x + 1] = sum[(size_t)y * row + (size_t)x + 1] + run;
        }
    }
}

/* A stretch of a line, in two parts where it goes beyond the ends of one that wraps. */
typedef struct stretch {
    int32_t from[2], to[2], parts;
} stretch;

static stretch stretch_around(int32_t at, int32_t radius, int32_t length, int32_t wraps)
{
    radius = 2 * radius + 1 < length || !wraps ? radius : (length - 1) / 2;
    int32_t low = at - radius, high = at + radius + 1;
    if (!wraps || (low >= 0 && high <= length))
        return (stretch){ { low > 0 ? low : 0, 0 }, { high < length ? high : length, 0 }, 1 };
    return low < 0 ? (stretch){ { low + length, 0 }, { length, high }, 2 }
                   : (stretch){ { low, 0 }, { length, high - length }, 2 };
}

static double mean_around(const pv_work *w, const double *sum, int32_t x, int32_t y, int32_t radius)
{
    size_t row = (size_t)w->width + 1;
    stretch across = stretch_around(x, radius, w->width, w->params->periodic);
    stretch down = stretch_around(y, radius, w->height, w->params->periodic);
    double all = 0, count = 0;
    for (int32_t k = 0; k < across.parts * down.parts; k++) {
        int32_t l = across.from[k % across.parts], r = across.to[k % across.parts];
        int32_t t = down.from[k / across.parts], b = down.to[k / across.parts];
        all += sum[(size_t)b * row + (size_t)r] - sum[(size_t)b * row + (size_t)l] -
               sum[(size_t)t * row + (size_t)r] + sum[(size_t)t * row + (size_t)l];
        count += (double)(r - l) * (b - t);
    }
    return all / count;
}

/* The least value that a share of all pixels is below. */
static double quantile(const pv_work *w, double share)
{
    int64_t bins[1024] = { 0 }, sum = 0, pixels = (int64_t)w->width * w->height;
    for (int64_t i = 0; i < pixels; i++)
        bins[(int)fmin(1023, 16 * (double)w->size[i])]++;
    int at = 0;
    for (; at < 1023 && sum + bins[at] < share * (double)pixels; at++)
        sum += bins[at];
    return (at + 1) / 16.0;
}

/* Where the lightness varies much within a tile's reach, tiles are small; sizes change slowly. */
static pave_result sizes_by_detail(pave_context *context, pv_work *w)
{
    pave_result result = PAVE_OK;
    size_t corners = ((size_t)w->width + 1) * ((size_t)w->height + 1);
    int32_t radius = (int32_t)fmax(1, w->side);
    double *sum = pv_allocate(context, corners, sizeof *sum, &result), *squares = NULL;
    if (!result)
        squares = pv_allocate(context, corners, sizeof *squares, &result);
    if (!result) {
        add_up(w, 0, w->photo.lab, 3, sum);
        add_up(w, 1, w->photo.lab, 3, squares);
        for (int64_t i = 0; i < (int64_t)w->width * w->height; i++) {
            int32_t x = (int32_t)(i % w->width), y = (int32_t)(i / w->width);
            double mean = mean_around(w, sum, x, y, radius), v = mean_around(w, squares, x, y, radius) - mean * mean;
            w->size[i] = (float)sqrt(v > 0 ? v : 0);
        }
        double low = quantile(w, 0.3), high = quantile(w, 0.9), least = w->params->size_detail;
        for (int64_t i = 0; i < (int64_t)w->width * w->height; i++) {
            double t = high > low ? ((double)w->size[i] - low) / (high - low) : 0;
            w->size[i] = (float)(1 + (t > 0 ? t < 1 ? t : 1 : 0) * (least - 1));
        }
        add_up(w, 0, w->size, 1, sum);
        for (int64_t i = 0; i < (int64_t)w->width * w->height; i++)
            w->size[i] = (float)mean_around(w, sum, (int32_t)(i % w->width), (int32_t)(i / w->width), radius);
    }
    pv_release(sum);
    pv_release(squares);
    return result;
}

static pave_result fill(pave_context *context, pv_work *w)
{
    const pave_image *image = w->sources->sizes;
    if (w->params->size_from == PAVE_SIZE_DETAIL)
        return sizes_by_detail(context, w);
    for (int64_t i = 0; i < (int64_t)w->width * w->height; i++)
        w->size[i] = (float)(w->params->size_from == PAVE_SIZE_REGIONS ? region_size(w, image, i)
                                                                       : image_size(image, i));
    return PAVE_OK;
}

static pave_result check(pave_context *context, const pv_work *w)
{
    const pave_image *image = w->sources->sizes;
    int needed = w->params->size_from == PAVE_SIZE_IMAGE || w->params->size_from == PAVE_SIZE_REGIONS;
    if (needed && !image)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "sizes are to come from an image, but there is none");
    if (image && !needed)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "there is an image of sizes, but size_from is not of an image");
    if (image && (image->width != w->width || image->height != w->height))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the image of sizes has %d x %d px, the photo %d x %d",
                       (int)image->width, (int)image->height, (int)w->width, (int)w->height);
    return PAVE_OK;
}

/* How many tiles of size 1 and side 1 px it would take. */
static double demand(pv_work *w)
{
    double sum = 0, least = 1;
    for (int64_t i = 0; i < (int64_t)w->width * w->height; i++) {
        double s = w->size ? (double)w->size[i] : 1;
        if (w->photo.hole && w->photo.hole[i])
            continue;
        sum += 1 / (s * s);
        least = s < least ? s : least;
    }
    w->size_min = least;
    return sum;
}

static int64_t solid_pixels(const pv_work *w)
{
    int64_t count = 0;
    for (int64_t i = 0; i < (int64_t)w->width * w->height; i++)
        count += !(w->photo.hole && w->photo.hole[i]);
    return count;
}

pave_result pv_sizes_read(pave_context *context, pv_work *w)
{
    pave_result result = check(context, w);
    double pixels = (double)solid_pixels(w), side = w->params->tile_side;
    w->side = side > 0 ? side : sqrt(pixels / w->params->tiles);
    if (!result && w->params->size_from != PAVE_SIZE_EVEN) {
        w->size = pv_allocate(context, (size_t)w->width * (size_t)w->height, sizeof *w->size, &result);
        if (!result)
            result = fill(context, w);
    }
    if (result)
        return result;
    double all = demand(w), n = side > 0 ? floor(all / (side * side) + 0.5) : w->params->tiles;
    if (n > pixels)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%.0f tiles are more than the photo's %.0f pixels", n, pixels);
    if (n > (double)context->limits.max_stones || n > INT32_MAX / 4)
        return pv_fail(context, PAVE_ERR_LIMIT, "%.0f tiles are beyond the limit of %lld (max_stones)", n,
                       (long long)context->limits.max_stones);
    w->n = n < 1 ? 1 : (int32_t)n;
    w->scale = sqrt(all / w->n);
    w->side = sqrt(pixels / w->n);
    return PAVE_OK;
}
