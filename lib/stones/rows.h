/* Small sparse least squares: the steps of a few vertices that make up for what is amiss. */
#pragma once

#include <stdint.h>

/* One thing amiss: the steps along (x[k], y[k]) of the vertices end[k] should add up to -rest. */
enum { PV_ROW_ENDS = 3 };

typedef struct pv_row {
    int32_t ends, end[PV_ROW_ENDS];
    double x[PV_ROW_ENDS], y[PV_ROW_ENDS], rest;
} pv_row;

/* Sums of normal equations for one vertex's step alone. */
typedef struct pv_equations {
    double xx, xy, yy, bx, by;
} pv_equations;

/* Adds: the step along the vector n should be -rest. */
static inline void pv_add_equation(pv_equations *e, double weight, double nx, double ny, double rest)
{
    e->xx += weight * nx * nx;
    e->xy += weight * nx * ny;
    e->yy += weight * ny * ny;
    e->bx -= weight * nx * rest;
    e->by -= weight * ny * rest;
}

enum { PV_ROWS_VERTICES = 160, PV_ROWS_MOST = 1024 };

typedef struct pv_rows {
    int32_t vertices, count;
    pv_equations own[PV_ROWS_VERTICES];
    pv_row row[PV_ROWS_MOST];
    double step[PV_ROWS_VERTICES][2];
} pv_rows;

/* Sets `step` by so many rounds of conjugate gradients from no step at all, so that what no row asks for does not
 * happen. */
void pv_rows_solve(pv_rows *rows, int32_t rounds);
