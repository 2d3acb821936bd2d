/* Models from inside: footprints of stones, the solids on them, and the pictures around those. */
#pragma once

#include "maps/maps.h"

enum { PV_FINE = 64, PV_MOST_SEGMENTS = 8 };

/* The outline of a stone without corners that hardly are any: counter-clockwise, valid. */
typedef struct pv_footprint {
    int64_t first; /* of its corners */
    int32_t corners, segments;
    double bevel;  /* px: what there is room for */
    double bottom; /* height, px */
    int64_t first_vertex, first_triangle;
} pv_footprint;

/* Where a side's strip lies in the pictures, px. */
typedef struct pv_strip {
    int32_t x, y;
} pv_strip;

struct pave_model {
    int32_t stones;
    int64_t vertices, triangles;
    float *position, *normal, *coordinate, *colour;
    uint32_t *triangle;
    int64_t *starts;
    pave_image *picture[PAVE_SKIN_COUNT];
    double joint_roughness, roughness; /* for materials without pictures */
};

typedef struct pv_modelling {
    const pv_bed *bed;
    pave_model_params params;
    pave_model *model;
    pv_frame frame; /* around all stones and the window */
    double middle[2]; /* of the window, px of the drawing */
    double bottom;  /* height of stones' undersides, px, unless they are sunk deeper */
    pv_footprint *footprint;
    pv_cell *corner; /* 1 / (1000 PV_FINE) px of the drawing, from the stone's first corner */
    int32_t most_corners;
    int32_t width, height, strip_height; /* of the pictures, px */
    pv_strip *strip; /* of the side after each corner */
    double cosine[PV_MOST_SEGMENTS + 1], sine[PV_MOST_SEGMENTS + 1]; /* of a rounding, from upright to flat */
} pv_modelling;

/* footprint.c: those of all stones. */
pave_result pv_footprints_make(pave_context *context, pv_modelling *m);

/* A ring inside of a ring, each side moved in by so many px; is it one that a solid can have? */
int pv_footprint_inset(const pv_cell *ring, int32_t corners, double inset, pv_cell *out);

/* The corner `i` of a ring moved in by that much. */
void pv_footprint_corner(const pv_cell *ring, int32_t corners, int32_t i, double inset, double out[2]);

/* The unit normal of the side after corner `i`, outwards. */
void pv_footprint_normal(const pv_cell *ring, int32_t corners, int32_t i, double out[2]);

/* Triangles that fill a valid ring, corners - 2 of them; `work` has room for the corners. */
void pv_footprint_fill(const pv_cell *ring, int32_t corners, int32_t *work, int32_t *triangles);

/* prism.c: vertices and triangles of a stone, as they are counted, and written. */
int64_t pv_prism_vertices(int32_t corners, int32_t segments);
int64_t pv_prism_triangles(int32_t corners, int32_t segments);
pave_result pv_prisms_build(pave_context *context, pv_modelling *m, double from, double to);
void pv_floor_build(pv_modelling *m);

/* skin.c: places for the sides, and the pictures. */
pave_result pv_skin_plan(pave_context *context, pv_modelling *m);
pave_result pv_skin_paint(pave_context *context, pv_modelling *m, double from, double to);

/* A px of a side: `along` px of the drawing from corner `i`, and `down` px from its upper end. */
pv_patch pv_side_patch(const pv_modelling *m, int32_t stone, int32_t i, double along, double down);

/* A place, px from the stone's first corner, as px of the maps from its origin. */
static inline void pv_model_place(const pv_modelling *m, int32_t stone, double x, double y, double out[2])
{
    const pv_laid *laid = &m->bed->laid[stone];
    const double *v = m->bed->stones->vertices + 2 * laid->first;
    out[0] = (v[0] + x) * m->bed->scale - (double)laid->x;
    out[1] = (v[1] + y) * m->bed->scale - (double)laid->y;
}

static inline double pv_fine(int32_t units)
{
    return (double)units / (1000 * PV_FINE);
}
