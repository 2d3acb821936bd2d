/* Cells along a line, in integers, as even as a period lets them be. The C twin of shaders/lattice.glsl. */
#pragma once

#include "util/fixed.h"

/* A whole number of cells in each span. Where it repeats, a place is the same as one a span farther on. */
typedef struct pv_lattice {
    int32_t span, cells, repeats;
} pv_lattice;

/* Cells of about this length; as many as fit best into the period, if there is one. */
static inline pv_lattice pv_lattice_of(int32_t cell, int32_t period)
{
    int64_t fit = (2 * (int64_t)period + cell) / (2 * (int64_t)cell);
    return period ? (pv_lattice){ period, fit > 0 ? (int32_t)fit : 1, 1 } : (pv_lattice){ cell, 1, 0 };
}

/* A place as one of the first period. */
static inline int32_t pv_lattice_place(const pv_lattice *l, int32_t at)
{
    return l->repeats ? pv_modulo(at, l->span) : at;
}

static inline int32_t pv_lattice_cell(const pv_lattice *l, int64_t place)
{
    return (int32_t)pv_floor_div(place * l->cells, l->span);
}

/* The first place of a cell. */
static inline int64_t pv_lattice_start(const pv_lattice *l, int32_t cell)
{
    return pv_ceil_div((int64_t)cell * l->span, l->cells);
}
