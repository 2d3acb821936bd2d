/* Gradient noise in the plane (Perlin 1985, with the fade curve of 2002), in integers.
 * The C twin of shaders/noise.glsl. */
#pragma once

#include "util/lattice.h"

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

static inline int32_t pv_noise_next(const pv_lattice *l, int32_t i)
{
    return l->repeats && i + 1 == l->cells ? 0 : i + 1;
}

static inline void pv_noise_enter(pv_noise_cell *cell, uint32_t key, const pv_lattice *across, const pv_lattice *down,
                                  int32_t x, int32_t y)
{
    if (cell->known && cell->x == x && cell->y == y)
        return;
    cell->known = 1;
    cell->x = x;
    cell->y = y;
    int32_t columns[] = { x, pv_noise_next(across, x) }, rows[] = { y, pv_noise_next(down, y) };
    for (int32_t i = 0; i < 4; i++)
        pv_turn((int32_t)(pv_lattice_hash(key, columns[i % 2], rows[i / 2]) >> 16), &cell->cosine[i], &cell->sine[i]);
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

/* How far into its cell a place is, in 1/65536 of the cell. */
static inline int64_t pv_noise_way(const pv_lattice *l, int32_t place, int32_t cell)
{
    return (((int64_t)place * l->cells - (int64_t)cell * l->span) << 16) / l->span;
}

/* Noise at (x, y), -1 .. 1 in 1/65536; the lattices' cells are its waves. `cell` starts as zeroes. */
static inline int32_t pv_noise(pv_noise_cell *cell, uint32_t key, const pv_lattice *across, const pv_lattice *down,
                               int32_t x, int32_t y)
{
    x = pv_lattice_place(across, x);
    y = pv_lattice_place(down, y);
    int32_t ix = pv_lattice_cell(across, x), iy = pv_lattice_cell(down, y);
    int64_t fx = pv_noise_way(across, x, ix), fy = pv_noise_way(down, y, iy);
    pv_noise_enter(cell, key, across, down, ix, iy);
    int64_t a = pv_noise_corner(cell, 0, fx, fy), b = pv_noise_corner(cell, 1, fx - 65536, fy);
    int64_t c = pv_noise_corner(cell, 2, fx, fy - 65536), d = pv_noise_corner(cell, 3, fx - 65536, fy - 65536);
    int64_t u = pv_fade(fx), v = pv_fade(fy);
    a += (b - a) * u >> 16;
    c += (d - c) * u >> 16;
    return (int32_t)((a + ((c - a) * v >> 16)) * 92682 >> 16);
}
