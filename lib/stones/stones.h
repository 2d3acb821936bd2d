/* Stones from inside: the tessellation on its way from pixels to polygons. */
#pragma once

#include "base/params.h"

#include <pave/stones.h>

#include <math.h>

extern const pv_table pv_stones_table, pv_measure_table;

struct pave_stones {
    int32_t x, y, width, height; /* of the window */
    int32_t plane_width, plane_height;
    uint64_t drawing; /* pv_bitmap_hash of the whole drawing, where windows of it are laid; else 0 */
    int32_t count;
    int64_t *starts;
    double *vertices;
    uint8_t *colours;
    int32_t *sites;
    uint8_t *rgb; /* r, g, b of each stone, where that is all that is known of its colour; else NULL */
    struct pv_mosaic_record *mosaic; /* how it was made; NULL: a pavement */
    int32_t painted;                 /* later stones lie over earlier ones */
    pave_report report;
    pave_cvd_params cvd; /* how it was made, for the report */
    pave_stones_params params;
    pave_field_params field;
    pave_threshold_params threshold;
    pave_palette_params palette; /* its count is 0: black and white */
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

/* What a vertex is moved by, on a grid so fine that it does not tell and so coarse that adding is exact: then copies of
 * a stone, far from each other in a plane that repeats, go the same ways. */
static inline double pv_way(double way)
{
    return floor(way * 1048576 + 0.5) / 1048576;
}

enum { PV_RINGS = 512 }; /* done by a thread at a time */

/* trace.c: finds the vertices of a label image and puts them in cyclic order around each label. */
pave_result pv_mesh_trace(pave_context *context, const pave_cvd *cvd, pv_mesh *mesh);
void pv_mesh_free(pv_mesh *mesh);

/* colour.c: a ring is coloured as the drawing is under the mean of its corners; sets low and high. Progress
 * stays `at`. */
pave_result pv_mesh_colour(pave_context *context, const pave_image *drawing, double at, pv_mesh *mesh);

/* flatten.c: moves the vertices of wide angles onto the line between their neighbours. */
pave_result pv_mesh_flatten(pave_context *context, const pave_stones_params *params, pv_mesh *mesh);

/* snap.c: moves vertices that are on the wrong side of an edge of the drawing onto it. */
pave_result pv_mesh_snap(pave_context *context, const pave_image *drawing, const pave_field *field, pv_mesh *mesh);

/* isolate.c: the window's stones, each by itself; `out` has its window and parameters set. */
pave_result pv_stones_isolate(pave_context *context, const pave_image *drawing, const pave_cvd *cvd,
                              const pv_mesh *mesh, pave_stones *out);

/* best.c: the stones of the best mode; `out` has its window and parameters set. */
pave_result pv_stones_best(pave_context *context, const pave_image *drawing, const pave_cvd *cvd, pave_stones *out);

/* order.c: arrays for n stones of so many corners, or fewer; without them again; in the order of their sites, for a
 * window across the border of a plane that repeats has those of the highest numbers first. */
pave_result pv_stones_allocate(pave_context *context, size_t n, size_t corners, pave_stones *out);
void pv_stones_drop(pave_stones *stones);
pave_result pv_stones_sort(pave_context *context, pave_stones *stones);

/* cut.c: cuts stones along the borders of the plane's periods and moves all parts into the first. */
pave_result pv_stones_cut(pave_context *context, pave_stones *stones);

/* count.c: counts a cell of so many vertices as traced; counts and areas of finished stones. */
void pv_count_cell(pave_report *report, int64_t corners);
void pv_stones_count(const pave_cvd *cvd, pave_stones *stones);

/* How much deeper than where its labels begin to be exact a diagram's window must lie for its stones to be those of
 * the whole, and how much deeper it lies; both px. */
double pv_stones_margin(const pave_cvd *cvd, const pave_stones_params *params);
double pv_stones_room(const pave_cvd *cvd);

/* A guess for a diagram yet to be made of a plane, half sides. */
double pv_stones_margin_guess(int32_t width, int32_t height, int repeats, const pave_cvd_params *cvd,
                              const pave_stones_params *params);

/* The drawing with its thin features widened, if that is asked for, in its place. */
pave_result pv_stones_widen(pave_context *context, const pave_cvd_params *cvd, const pave_stones_params *params,
                            int repeats, pave_image **drawing);

/* How wide thin features are made, px; 0: they are not. */
double pv_stones_thin_width(int32_t width, int32_t height, const pave_cvd_params *cvd,
                            const pave_stones_params *params);

/* best.c: how far around the window a diagram is looked at where no pixel is farther from its site than `radius`,
 * px. */
double pv_best_reach(const pave_cvd *cvd, double radius);

/* The diagram's pixels to one of the drawing that a mode is best with. */
int32_t pv_stones_supersample(const pave_stones_params *params);

/* Half the side of a mean stone, px: the one they were laid with, or else the root of the window's area by stones,
 * halved (Eq. 1). */
double pv_stones_half_side(const pave_stones *stones);

/* Pixel value of the drawing under a point, the nearest one for points on the rim or beyond. */
uint8_t pv_colour_at(const pave_image *drawing, pv_point p);
