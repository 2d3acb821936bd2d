/* Conjugate gradients on the normal equations, preconditioned vertex by vertex. */
#include "stones/rows.h"

#include <string.h>

typedef double steps[PV_ROWS_VERTICES][2];

/* The inverse of what stands on the diagonal for each vertex. */
static void invert_blocks(const pv_rows *r, pv_equations *inverse)
{
    memcpy(inverse, r->own, (size_t)r->vertices * sizeof *inverse);
    for (int32_t i = 0; i < r->count; i++)
        for (int32_t k = 0; k < r->row[i].ends; k++)
            pv_add_equation(&inverse[r->row[i].end[k]], 1, r->row[i].x[k], r->row[i].y[k], 0);
    for (int32_t v = 0; v < r->vertices; v++) {
        pv_equations *e = &inverse[v];
        double xx = e->xx, det = e->xx * e->yy - e->xy * e->xy;
        e->xx = det > 0 ? e->yy / det : 1;
        e->xy = det > 0 ? -e->xy / det : 0;
        e->yy = det > 0 ? xx / det : 1;
    }
}

static void precondition(const pv_rows *r, const pv_equations *inverse, steps in, steps out)
{
    for (int32_t v = 0; v < r->vertices; v++) {
        out[v][0] = inverse[v].xx * in[v][0] + inverse[v].xy * in[v][1];
        out[v][1] = inverse[v].xy * in[v][0] + inverse[v].yy * in[v][1];
    }
}

static void multiply(const pv_rows *r, steps in, steps out)
{
    for (int32_t v = 0; v < r->vertices; v++) {
        out[v][0] = r->own[v].xx * in[v][0] + r->own[v].xy * in[v][1];
        out[v][1] = r->own[v].xy * in[v][0] + r->own[v].yy * in[v][1];
    }
    for (int32_t i = 0; i < r->count; i++) {
        const pv_row *row = &r->row[i];
        double sum = 0;
        for (int32_t k = 0; k < row->ends; k++)
            sum += row->x[k] * in[row->end[k]][0] + row->y[k] * in[row->end[k]][1];
        for (int32_t k = 0; k < row->ends; k++) {
            out[row->end[k]][0] += row->x[k] * sum;
            out[row->end[k]][1] += row->y[k] * sum;
        }
    }
}

static double product(const pv_rows *r, steps a, steps b)
{
    double sum = 0;
    for (int32_t v = 0; v < r->vertices; v++)
        sum += a[v][0] * b[v][0] + a[v][1] * b[v][1];
    return sum;
}

static void add_scaled(const pv_rows *r, steps to, double factor, steps what)
{
    for (int32_t v = 0; v < r->vertices; v++) {
        to[v][0] += factor * what[v][0];
        to[v][1] += factor * what[v][1];
    }
}

static void right_side(const pv_rows *r, steps out)
{
    for (int32_t v = 0; v < r->vertices; v++)
        out[v][0] = r->own[v].bx, out[v][1] = r->own[v].by;
    for (int32_t i = 0; i < r->count; i++)
        for (int32_t k = 0; k < r->row[i].ends; k++) {
            out[r->row[i].end[k]][0] -= r->row[i].x[k] * r->row[i].rest;
            out[r->row[i].end[k]][1] -= r->row[i].y[k] * r->row[i].rest;
        }
}

void pv_rows_solve(pv_rows *r, int32_t rounds)
{
    pv_equations inverse[PV_ROWS_VERTICES];
    steps left, ready, way, image;
    invert_blocks(r, inverse);
    memset(r->step, 0, (size_t)r->vertices * sizeof *r->step);
    right_side(r, left);
    precondition(r, inverse, left, way);
    double square = product(r, left, way), enough = 1e-4 * square;
    for (int32_t round = 0; round < rounds && square > enough; round++) {
        multiply(r, way, image);
        double along = product(r, way, image);
        if (!(along > 0))
            return;
        add_scaled(r, r->step, square / along, way);
        add_scaled(r, left, -square / along, image);
        precondition(r, inverse, left, ready);
        double next = product(r, left, ready), keep = next / square;
        for (int32_t v = 0; v < r->vertices; v++) {
            way[v][0] = ready[v][0] + keep * way[v][0];
            way[v][1] = ready[v][1] + keep * way[v][1];
        }
        square = next;
    }
}
