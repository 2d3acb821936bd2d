/* Gradient noise in the plane (Perlin 1985, with the fade curve of 2002), in integers.
 * The C twin of shaders/noise.glsl. */
#pragma once

#include "util/fixed.h"

/* One well-mixed word for a lattice point. */
static inline uint32_t pv_lattice_hash(uint32_t key, int32_t x, int32_t y)
{
    uint32_t h = key ^ (uint32_t)x * 0x9E3779B1u;
    h = (h ^ h >> 15) * 0x85EBCA6Bu;
    h ^= (uint32_t)y * 0xC2B2AE35u;
    h = (h ^ h >> 13) * 0x27D4EB2Fu;
    h = (h ^ h >> 16) * 0x165667B1u;
    return h ^ h >> 15;
}

/* A lattice cell's gradients, at its corners (0, 0), (1, 0), (0, 1), (1, 1). Kept from call to call, it saves most
 * of the work where points come in spatial order. */
typedef struct pv_noise_cell {
    int32_t known, x, y;
    int32_t cosine[4], sine[4];
} pv_noise_cell;

static inline void pv_noise_enter(pv_noise_cell *cell, uint32_t key, int32_t x, int32_t y)
{
    if (cell->known && cell->x == x && cell->y == y)
        return;
    cell->known = 1;
    cell->x = x;
    cell->y = y;
    for (int32_t i = 0; i < 4; i++)
        pv_turn((int32_t)(pv_lattice_hash(key, x + i % 2, y + i / 2) >> 16), &cell->cosine[i], &cell->sine[i]);
}

static inline int64_t pv_noise_corner(const pv_noise_cell *cell, int32_t i, int64_t fx, int64_t fy)
{
    return (cell->cosine[i] * fx + cell->sine[i] * fy) >> 16;
}

static inline int64_t pv_fade(int64_t t)
{
    int64_t poly = ((t * (6 * t - 15 * 65536) >> 16) + 10 * 65536);
    return (((t * t >> 16) * t >> 16) * poly) >> 16;
}

/* Noise at (x, y), -1 .. 1 in 1/65536; x, y and the wave length in the same unit. `cell` starts as zeroes. */
static inline int32_t pv_noise(pv_noise_cell *cell, uint32_t key, int32_t x, int32_t y, int32_t wave)
{
    int32_t ix = (int32_t)pv_floor_div(x, wave), iy = (int32_t)pv_floor_div(y, wave);
    int64_t fx = (((int64_t)x - (int64_t)ix * wave) << 16) / wave;
    int64_t fy = (((int64_t)y - (int64_t)iy * wave) << 16) / wave;
    pv_noise_enter(cell, key, ix, iy);
    int64_t a = pv_noise_corner(cell, 0, fx, fy), b = pv_noise_corner(cell, 1, fx - 65536, fy);
    int64_t c = pv_noise_corner(cell, 2, fx, fy - 65536), d = pv_noise_corner(cell, 3, fx - 65536, fy - 65536);
    int64_t u = pv_fade(fx), v = pv_fade(fy);
    a += (b - a) * u >> 16;
    c += (d - c) * u >> 16;
    return (int32_t)((a + ((c - a) * v >> 16)) * 92682 >> 16);
}
