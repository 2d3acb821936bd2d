/* Counter-based random numbers: a function of (seed, what for, where), never of order.
 * Source: Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3" (Philox 4x32, 10 rounds).
 * The C twin of shaders/random.glsl. */
#pragma once

#include <stdint.h>

/* What a number is drawn for: part of the counter, so that no two uses share numbers. */
enum { PV_DRAW_SITES = 1, PV_DRAW_SCALE = 2, PV_DRAW_NOISE = 3, PV_DRAW_REVIVE = 4 };
enum { PV_DRAW_VOXEL = 50, PV_DRAW_ALIKE = 51, PV_DRAW_SEED = 52, PV_DRAW_RANK = 53, PV_DRAW_START = 54 };
enum { PV_DRAW_BLOCKS = 40, PV_DRAW_ROUNDS = 41, PV_DRAW_FRACTION = 42, PV_DRAW_EDGES = 43 }; /* of textures */
enum { PV_DRAW_RELIEF = 40, PV_DRAW_MATERIAL = 41, PV_DRAW_RAY = 42, PV_DRAW_SKETCH = 43,
       PV_DRAW_PLAN = 44, PV_DRAW_WHITE = 48 }; /* of BTFs: never both */
enum { PV_DRAW_FACE = 60, PV_DRAW_SURFACE = 61, PV_DRAW_PLANE = 62, PV_DRAW_SAND = 63 }; /* of maps */

typedef struct pv_random { uint32_t word[4]; } pv_random;

static inline pv_random pv_philox(pv_random counter, uint32_t key0, uint32_t key1)
{
    uint32_t *w = counter.word;
    for (int round = 0; round < 10; round++) {
        uint64_t p = (uint64_t)w[0] * 0xD2511F53u, q = (uint64_t)w[2] * 0xCD9E8D57u;
        uint32_t w0 = (uint32_t)(q >> 32) ^ w[1] ^ key0, w2 = (uint32_t)(p >> 32) ^ w[3] ^ key1;
        w[0] = w0, w[1] = (uint32_t)q, w[2] = w2, w[3] = (uint32_t)p;
        key0 += 0x9E3779B9u, key1 += 0xBB67AE85u;
    }
    return counter;
}

static inline pv_random pv_draw(uint64_t seed, uint32_t use, uint32_t x, uint32_t y, uint32_t which)
{
    pv_random counter = { { x, y, which, use } };
    return pv_philox(counter, (uint32_t)seed, (uint32_t)(seed >> 32));
}

/* A word as a number of 0 .. range-1. */
static inline uint32_t pv_below(uint32_t word, uint32_t range)
{
    return (uint32_t)((uint64_t)word * range >> 32);
}
