/* Joints: the lines between stones, how far each pixel is from them, and how large the stones are. */
#include "tiling/bank.h"

#include "util/fixed.h"

#include <stdlib.h>
#include <string.h>

enum { FAR = 1 << 20, LOCAL = 20, LEAST_JOINT = 12, UNIT = 3 /* of distances: thirds of a px */ };

static const double OPEN = 0.8; /* a largest area of this share: joints close nothing */

static int64_t *integral(pave_context *context, const pv_grey *grey, int square, pave_result *result)
{
    int32_t across = grey->width + 1;
    int64_t *sum = pv_allocate_zeroed(context, (size_t)across * ((size_t)grey->height + 1), sizeof *sum, result);
    for (int32_t y = 0; sum && y < grey->height; y++) {
        int64_t row = 0;
        for (int32_t x = 0; x < grey->width; x++) {
            int64_t v = grey->values[(int64_t)y * grey->stride + x];
            row += square ? v * v : v;
            sum[(int64_t)(y + 1) * across + x + 1] = sum[(int64_t)y * across + x + 1] + row;
        }
    }
    return sum;
}

typedef struct box { int64_t area; int32_t left, right, top, bottom; } box;

static box box_at(const pv_grey *grey, int32_t x, int32_t y, int32_t radius)
{
    box b = { 0, x - radius, x + radius + 1, y - radius, y + radius + 1 };
    b.left = b.left < 0 ? 0 : b.left;
    b.top = b.top < 0 ? 0 : b.top;
    b.right = b.right > grey->width ? grey->width : b.right;
    b.bottom = b.bottom > grey->height ? grey->height : b.bottom;
    b.area = (int64_t)(b.right - b.left) * (b.bottom - b.top);
    return b;
}

static int64_t box_sum(const int64_t *sum, int32_t across, const box *b)
{
    const int64_t *top = sum + (int64_t)b->top * across, *bottom = sum + (int64_t)b->bottom * across;
    return bottom[b->right] - bottom[b->left] - top[b->right] + top[b->left];
}

pave_result pv_box_mean(pave_context *context, const pv_grey *grey, int32_t radius, int32_t *out)
{
    pave_result result = PAVE_OK;
    int64_t *sum = integral(context, grey, 0, &result);
    for (int32_t y = 0; sum && y < grey->height; y++)
        for (int32_t x = 0; x < grey->width; x++) {
            box b = box_at(grey, x, y, radius);
            out[(int64_t)y * grey->width + x] = (int32_t)(box_sum(sum, grey->width + 1, &b) / b.area);
        }
    pv_release(sum);
    return result;
}

static int32_t clamp(int32_t v, int32_t most)
{
    return v < 0 ? 0 : v > most ? most : v;
}

/* 16 times the mean of 3 x 3 pixels, weighted 1 2 1. */
static int32_t smooth(const pv_grey *grey, int32_t x, int32_t y)
{
    int32_t total = 0;
    for (int32_t k = 0; k < 9; k++) {
        int32_t u = clamp(x + k % 3 - 1, grey->width - 1), v = clamp(y + k / 3 - 1, grey->height - 1);
        total += (2 - abs(k % 3 - 1)) * (2 - abs(k / 3 - 1)) * grey->values[(int64_t)v * grey->stride + u];
    }
    return total;
}

/* Marks what is 0.9 deviations darker (sign 1) or brighter (sign -1) than what surrounds it. */
static pave_result mark(pave_context *context, const pv_grey *grey, int sign, uint8_t *joint)
{
    pave_result result = PAVE_OK;
    int64_t *sum = integral(context, grey, 0, &result), *squares = NULL;
    if (!result)
        squares = integral(context, grey, 1, &result);
    for (int32_t y = 0; !result && y < grey->height; y++)
        for (int32_t x = 0; x < grey->width; x++) {
            box b = box_at(grey, x, y, LOCAL);
            int64_t s = box_sum(sum, grey->width + 1, &b), q = box_sum(squares, grey->width + 1, &b);
            double below = sign * ((double)s / (double)b.area - smooth(grey, x, y) / 16.0);
            double variance = ((double)q - (double)s * (double)s / (double)b.area) / (double)b.area;
            joint[(int64_t)y * grey->width + x] = below > 0 && below * below > 0.81 * variance && variance > 0;
        }
    pv_release(sum);
    pv_release(squares);
    return result;
}

/* Finds the connected part that pixel `start` belongs to, in `queue`; returns its size. */
static int32_t flood(const uint8_t *mask, int32_t width, int32_t height, int32_t start, uint8_t *seen, int32_t *queue)
{
    int32_t count = 1;
    queue[0] = start;
    seen[start] = 1;
    for (int32_t i = 0; i < count; i++) {
        int32_t p = queue[i], x = p % width, y = p / width;
        const int32_t next[4] = { x + 1 < width ? p + 1 : p, x ? p - 1 : p, y + 1 < height ? p + width : p,
                                  y ? p - width : p };
        for (int k = 0; k < 4; k++)
            if (!seen[next[k]] && mask[next[k]] == mask[start]) {
                seen[next[k]] = 1;
                queue[count++] = next[k];
            }
    }
    return count;
}

/* Drops joints of a few pixels; returns the share of the largest area without one: 1 if joints close nothing. */
static pave_result clean(pave_context *context, int32_t width, int32_t height, uint8_t *joint, double *largest)
{
    pave_result result = PAVE_OK;
    int32_t n = width * height;
    uint8_t *seen = pv_allocate_zeroed(context, (size_t)n, 2, &result);
    int32_t *queue = pv_allocate(context, (size_t)n, sizeof *queue, &result), most = 0;
    for (int32_t i = 0; !result && i < n; i++) {
        int32_t count = joint[i] && !seen[i] ? flood(joint, width, height, i, seen, queue) : LEAST_JOINT;
        for (int32_t k = 0; count < LEAST_JOINT && k < count; k++)
            joint[queue[k]] = 0;
    }
    for (int32_t i = 0; !result && i < n; i++)
        if (!joint[i] && !seen[n + i]) {
            int32_t count = flood(joint, width, height, i, seen + n, queue);
            most = count > most ? count : most;
        }
    *largest = (double)most / n;
    pv_release(seen);
    pv_release(queue);
    return result;
}

/* Chamfer distance, in thirds of a px, to the nearest pixel where joint != inside. */
static void spread(int32_t width, int32_t height, const uint8_t *joint, int inside, int32_t *d)
{
    for (int32_t i = 0; i < width * height; i++)
        d[i] = joint[i] != inside ? 0 : FAR;
    for (int pass = 0; pass < 2; pass++)
        for (int32_t i = 0; i < width * height; i++) {
            int32_t p = pass ? width * height - 1 - i : i, x = p % width, y = p / width, s = pass ? 1 : -1;
            int across = x + s >= 0 && x + s < width, down = y + s >= 0 && y + s < height;
            int back = x - s >= 0 && x - s < width;
            int32_t least = d[p];
            if (across && d[p + s] + 3 < least)
                least = d[p + s] + 3;
            if (down && d[p + s * width] + 3 < least)
                least = d[p + s * width] + 3;
            if (down && across && d[p + s * width + s] + 4 < least)
                least = d[p + s * width + s] + 4;
            if (down && back && d[p + s * width - s] + 4 < least)
                least = d[p + s * width - s] + 4;
            d[p] = least;
        }
}

/* Twice the distance that 5 in 100 pixels outside joints exceed, and half as much again, for that is less than half a
 * stone: the size of the features. 0 without joints. */
static pave_result measure(pave_context *context, int32_t n, const int32_t *distance, double *feature)
{
    pave_result result = PAVE_OK;
    enum { MOST = 4096 };
    int32_t *bins = pv_allocate_zeroed(context, MOST, sizeof *bins, &result), total = 0, above = 0, k = MOST - 1;
    *feature = 0;
    if (result)
        return result;
    for (int32_t i = 0; i < n; i++)
        if (distance[i] > 0) {
            bins[distance[i] < MOST ? distance[i] : MOST - 1]++;
            total++;
        }
    while (k > 0 && above + bins[k] <= total / 20)
        above += bins[k--];
    if (total && k < MOST - 1)
        *feature = 1.4 * 2 * k / UNIT;
    pv_release(bins);
    return result;
}

/* Do joints enclose stones? Where there are none but for gaps of a px or two, what is further inside falls into
 * several parts, none of which is most of it. */
static pave_result enclose(pave_context *context, const pv_grey *grey, const int32_t *distance, int *out)
{
    enum { GAP = UNIT };
    pave_result result = PAVE_OK;
    int32_t n = grey->width * grey->height, all = 0, most = 0;
    uint8_t *inside = pv_allocate_zeroed(context, (size_t)n, 2, &result), *seen = inside ? inside + n : NULL;
    int32_t *queue = result ? NULL : pv_allocate(context, (size_t)n, sizeof *queue, &result);
    for (int32_t i = 0; !result && i < n; i++)
        all += inside[i] = distance[i] > GAP;
    for (int32_t i = 0; !result && i < n; i++)
        if (inside[i] && !seen[i]) {
            int32_t count = flood(inside, grey->width, grey->height, i, seen, queue);
            most = count > most ? count : most;
        }
    *out = most > 0 && 2 * most < all;
    pv_release(inside);
    pv_release(queue);
    return result;
}

static pave_result try(pave_context *context, const pv_grey *grey, int sign, uint8_t *joint, double *largest)
{
    pave_result result = mark(context, grey, sign, joint);
    return result ? result : clean(context, grey->width, grey->height, joint, largest);
}

static pave_result find_distance(pave_context *context, const pv_grey *grey, const pv_joints *joints)
{
    pave_result result;
    int32_t n = grey->width * grey->height;
    int32_t *inner = pv_allocate(context, (size_t)n, sizeof *inner, &result);
    if (!inner)
        return result;
    spread(grey->width, grey->height, joints->joint, 0, joints->distance);
    spread(grey->width, grey->height, joints->joint, 1, inner);
    for (int32_t i = 0; i < n; i++)
        joints->distance[i] = joints->joint[i] ? -inner[i] : joints->distance[i];
    pv_release(inner);
    return PAVE_OK;
}

/* Dark joints, or bright mortar where that closes far better. */
static pave_result find(pave_context *context, const pv_grey *grey, pv_joints *out)
{
    int32_t n = grey->width * grey->height, side = grey->width < grey->height ? grey->width : grey->height;
    double dark = 1, light = 1;
    pave_result result = try(context, grey, -1, out->joint, &light);
    if (!result)
        result = try(context, grey, 1, out->joint, &dark);
    if (!result && light < 0.5 * dark)
        result = try(context, grey, -1, out->joint, &light);
    if (!result)
        result = find_distance(context, grey, out);
    if (!result)
        result = measure(context, n, out->distance, &out->feature);
    if ((light < 0.5 * dark ? light : dark) > OPEN && out->feature > 0.4 * side)
        out->feature = 0;
    return result ? result : enclose(context, grey, out->distance, &out->enclose);
}

pave_result pv_joints_find(pave_context *context, const pv_grey *grey, pv_joints *out)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)grey->width * (size_t)grey->height;
    memset(out, 0, sizeof *out);
    out->joint = pv_allocate(context, n, 1, &result);
    out->distance = result ? NULL : pv_allocate(context, n, sizeof *out->distance, &result);
    if (!result)
        result = find(context, grey, out);
    if (result)
        pv_joints_free(out);
    return result;
}

void pv_joints_free(pv_joints *joints)
{
    pv_release(joints->joint);
    pv_release(joints->distance);
    memset(joints, 0, sizeof *joints);
}

pave_result pv_joints_areas(pave_context *context, int32_t width, int32_t height, const uint8_t *joint,
                            double *squares)
{
    pave_result result = PAVE_OK;
    size_t n = (size_t)width * (size_t)height;
    uint8_t *seen = pv_allocate_zeroed(context, n, 1, &result);
    int32_t *queue = result ? NULL : pv_allocate(context, n, sizeof *queue, &result);
    *squares = 0;
    for (int32_t i = 0; !result && i < (int32_t)n; i++)
        if (!joint[i] && !seen[i]) {
            double count = flood(joint, width, height, i, seen, queue);
            *squares += count * count;
        }
    pv_release(seen);
    pv_release(queue);
    return result;
}
