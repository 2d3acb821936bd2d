/* Sliced distance: how much the patches of two pictures differ as a whole, whichever lie where: seen along many
 * directions through the space of patches, the mean distance of their sorted values (sliced Wasserstein distance).
 * Source: Rabin et al. 2011, "Wasserstein barycenter and its application to texture mixing", section 2. */
#include "tiling/tiling.h"

#include "util/random.h"

#include <math.h>
#include <stdlib.h>

enum { SIDE = 7, RGB = 3, VALUES = SIDE * SIDE * RGB, PATCHES = 4000, DIRECTIONS = 64, USE = 44 };

static double uniform(uint32_t word)
{
    return (word + 0.5) / 4294967296.0;
}

/* A direction, all equally likely. */
static void draw_direction(uint32_t which, float *out)
{
    const double turn = 6.283185307179586;
    double squares = 0;
    for (uint32_t i = 0; i < VALUES; i++) {
        pv_random r = pv_draw(1, USE, which, i, 0);
        double v = sqrt(-2 * log(uniform(r.word[0]))) * cos(turn * uniform(r.word[1]));
        out[i] = (float)v;
        squares += v * v;
    }
    for (uint32_t i = 0; i < VALUES; i++)
        out[i] = (float)(out[i] / sqrt(squares));
}

static float along(const float *rgb, int32_t width, const float *direction)
{
    float sum = 0;
    for (int32_t y = 0; y < SIDE; y++)
        for (int32_t k = 0; k < SIDE * RGB; k++)
            sum += rgb[(int64_t)y * width * RGB + k] * direction[y * SIDE * RGB + k];
    return sum;
}

static int ascending(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Patches at random places, along one direction, sorted. */
static void project(const pv_picture *p, uint32_t which, const float *direction, float *out)
{
    for (uint32_t i = 0; i < PATCHES; i++) {
        pv_random r = pv_draw(1, USE, i, which, 1);
        int64_t x = pv_below(r.word[0], (uint32_t)(p->width - SIDE));
        int64_t y = pv_below(r.word[1], (uint32_t)(p->height - SIDE));
        out[i] = along(p->rgb + RGB * (y * p->width + x), p->width, direction);
    }
    qsort(out, PATCHES, sizeof *out, ascending);
}

pave_result pv_sliced_distance(pave_context *context, const pv_picture *a, const pv_picture *b, double *distance)
{
    float direction[VALUES];
    pave_result result = PAVE_OK;
    double sum = 0;
    *distance = 0;
    if (a->width <= SIDE || a->height <= SIDE || b->width <= SIDE || b->height <= SIDE)
        return PAVE_OK;
    float *of_a = pv_allocate(context, 2 * PATCHES, sizeof *of_a, &result), *of_b = of_a + PATCHES;
    for (uint32_t k = 0; k < DIRECTIONS && !result; k++) {
        draw_direction(k, direction);
        project(a, 0, direction, of_a);
        project(b, 1, direction, of_b);
        for (int32_t i = 0; i < PATCHES; i++)
            sum += fabs((double)of_a[i] - of_b[i]);
        result = pv_progress(context, 0);
    }
    *distance = sum / (PATCHES * DIRECTIONS);
    pv_release(of_a);
    return result;
}
