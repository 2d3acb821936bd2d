/* Stones from inside: the tessellation on its way from pixels to polygons. */
#pragma once

#include "base/params.h"

#include <pave/stones.h>

extern const pv_table pv_stones_table;

struct pave_stones {
    int32_t x, y, width, height; /* of the window */
    int32_t plane_width, plane_height;
    uint64_t drawing; /* pv_bitmap_hash of the whole drawing, where windows of it are laid; else 0 */
    int32_t count;
    int64_t *starts;
    double *vertices;
    uint8_t *colours;
    int32_t *sites;
    int32_t *parts;
    pave_measure measure;
    pave_cvd_params cvd; /* how it was made, for the report */
    pave_stones_params params;
    pave_field_params field;
    pave_threshold_params threshold;
    int32_t backend;
    char backend_name[128];
};

typedef struct pv_point {
    double x, y; /* px; y grows down */
} pv_point;

/* Polygons that share their vertices. Ring r, one for each site, is corner[first[r]] .. corner[first[r+1]-1],
 * counter-clockwise as seen. */
typedef struct pv_mesh {
    double left, top, right, bottom; /* of the region, in the plane */
    int32_t vertex_count, ring_count;
    pv_point *vertex;
    int32_t *owner;      /* the ring in which a vertex has been made flat, -1: none */
    uint8_t *low, *high; /* least and greatest colour of the rings around a vertex: not the same on the contour */
    int64_t *first;
    int32_t *corner;
} pv_mesh;

/* trace.c: finds the vertices of a label image and puts them in cyclic order around each label. */
pave_result pv_mesh_trace(pave_context *context, const pave_cvd *cvd, pv_mesh *mesh);
void pv_mesh_free(pv_mesh *mesh);

/* colour.c: a ring is coloured as the drawing is under the mean of its corners; sets low and high. */
void pv_mesh_colour(const pave_image *drawing, pv_mesh *mesh);

/* flatten.c: moves the vertices of wide angles onto the line between their neighbours. */
pave_result pv_mesh_flatten(pave_context *context, const pave_stones_params *params, pv_mesh *mesh);

/* snap.c: moves vertices that are on the wrong side of an edge of the drawing onto it. */
pave_result pv_mesh_snap(pave_context *context, const pave_image *drawing, const pave_field *field, pv_mesh *mesh);

/* isolate.c: the window's stones, each by itself; `out` has its window and parameters set. */
pave_result pv_stones_isolate(pave_context *context, const pave_image *drawing, const pave_cvd *cvd,
                              const pv_mesh *mesh, pave_stones *out);

/* best.c: the stones of the best mode; `out` has its window and parameters set. */
pave_result pv_stones_best(pave_context *context, const pave_image *drawing, const pave_cvd *cvd, pave_stones *out);

/* measure.c: counts a cell of so many vertices as traced; counts and measures finished stones. */
void pv_measure_cell(pave_measure *measure, int64_t corners);
void pv_measure_stones(const pave_cvd *cvd, pave_stones *stones);

/* How much deeper than where its labels begin to be exact a diagram's window must lie for its stones to be those of
 * the whole, and how much deeper it lies; both px. */
double pv_stones_margin(const pave_cvd *cvd, const pave_stones_params *params);
double pv_stones_room(const pave_cvd *cvd);

/* The diagram's pixels to one of the drawing that a mode is best with. */
int32_t pv_stones_supersample(const pave_stones_params *params);

/* Pixel value of the drawing under a point, the nearest one for points on the rim or beyond. */
uint8_t pv_colour_at(const pave_image *drawing, pv_point p);
