/* What follows from heights: normals, and how much of the sky each point sees. */
#include "maps/maps.h"

#include "base/parallel.h"
#include "util/fixed.h"

#include <math.h>

enum { ROWS = 8, WAYS = 16, STEPS = 10 };

/* A place around a point, and 1 / its distance in px of the drawing. */
typedef struct look {
    int64_t offset;
    float nearness;
} look;

typedef struct shading {
    const pv_shades *s;
    int64_t row; /* heights from row to row */
    int32_t steps;
    look looks[WAYS][STEPS];
} shading;

int32_t pv_shade_rim(double reach)
{
    return reach > 1 ? (int32_t)ceil(reach) : 1;
}

/* Steps grow: what is near shades most. */
static void plan_looks(shading *d, double reach)
{
    d->steps = reach >= 1 ? reach < STEPS ? (int32_t)reach : STEPS : 0;
    for (int32_t w = 0; w < WAYS; w++) {
        int32_t cosine, sine;
        pv_turn(w * (65536 / WAYS) + 2048, &cosine, &sine);
        for (int32_t i = 0; i < d->steps; i++) {
            double part = (i + 1.0) / d->steps, far = 1 + (reach - 1) * part * part;
            double x = floor(far * cosine / 65536 + 0.5), y = floor(far * sine / 65536 + 0.5);
            double length = sqrt(x * x + y * y) / d->s->scale;
            d->looks[w][i] = (look){ (int64_t)y * d->row + (int64_t)x, length > 0 ? (float)(1 / length) : 0 };
        }
    }
}

/* The share of the sky above the horizon, weighted by the cosine: of each way cos^2 of the horizon's angle. */
static uint8_t open_sky(const shading *d, const float *at)
{
    float sum = 0;
    for (int32_t w = 0; w < WAYS; w++) {
        float steepest = 0;
        for (int32_t i = 0; i < d->steps; i++) {
            float steep = (at[d->looks[w][i].offset] - *at) * d->looks[w][i].nearness;
            steepest = steep > steepest ? steep : steepest;
        }
        sum += 1 / (1 + steepest * steepest);
    }
    return (uint8_t)(sum * (255.0f / WAYS) + 0.5f);
}

void pv_normal_of(double across, double down, int32_t up, double out[3])
{
    double length = sqrt(across * across + down * down + 1);
    out[0] = (1 - across / length) / 2;
    out[1] = (1 + (up ? down : -down) / length) / 2;
    out[2] = (1 + 1 / length) / 2;
}

static void put_normal(const shading *d, const float *at, uint16_t out[3])
{
    double across = ((double)at[1] - (double)at[-1]) / 2 * d->s->scale;
    double down = ((double)at[d->row] - (double)at[-d->row]) / 2 * d->s->scale;
    double n[3];
    pv_normal_of(across, down, d->s->up, n);
    for (int c = 0; c < 3; c++)
        out[c] = (uint16_t)(n[c] * 65535 + 0.5);
}

static void shade_rows(void *data, int32_t begin, int32_t end, int32_t worker)
{
    const shading *d = data;
    const pv_shades *s = d->s;
    (void)worker;
    for (int32_t y = begin; y < end; y++)
        for (int32_t x = 0; x < s->width; x++) {
            const float *at = s->height + (y + s->rim) * d->row + x + s->rim;
            int64_t pixel = (int64_t)y * s->width + x;
            if (s->normal)
                put_normal(d, at, s->normal + 3 * pixel);
            if (s->occlusion)
                s->occlusion[pixel] = open_sky(d, at);
        }
}

pave_result pv_shade(pave_context *context, const pv_shades *shades, double from, double to)
{
    shading d = { .s = shades, .row = shades->width + 2 * (int64_t)shades->rim };
    plan_looks(&d, shades->reach);
    return pv_parallel_runs(context, shades->height_px, ROWS, shade_rows, &d, from, to);
}
