/* A tessellation: faces that share their vertices, on an integer grid, so that what holds of it holds exactly. */
#pragma once

#include "stones/pieces.h"
#include "util/polygon.h"

struct pave_image;

enum { PV_GRID = 1000 }; /* grid units a px: what every output format carries exactly */

/* What a vertex is. */
enum {
    PV_BORDER = 1,  /* on the border of the region: never moves */
    PV_CONTOUR = 2, /* between colours: moved only along with the contour */
    PV_BEND = 4     /* of a chain between two faces, not a junction */
};

/* Ring f, one a face, is corner[first[f]] .. corner[first[f + 1] - 1], counter-clockwise as seen (y goes down). Each
 * side of a ring is also one of a neighbour's, backwards, or on the border. Vertices are in an order that does not
 * depend on the region: junctions by place, then bends. */
typedef struct pv_tess {
    int32_t vertex_count, face_count;
    pv_cell period;    /* of a plane that repeats; 0: it does not */
    pv_cell whole;     /* where a period begins that is all there, with what is around it, */
    int32_t has_whole; /* if there is one */
    pv_cell *at;       /* in the plane */
    uint8_t *kind;
    int32_t *flat;     /* the face in which the vertex is to lie on a straight side, -1: none */
    int64_t *first;
    int32_t *corner;
    int64_t *star;     /* vertex v occurs at the places spoke[star[v]] .. spoke[star[v + 1] - 1] of `corner`, */
    int64_t *spoke;    /* ascending */
    int32_t *face_of;  /* of a place of `corner` */
    int32_t *label;    /* of faces: as in pv_pieces */
    int32_t *part;
    uint8_t *colour;
} pv_tess;

/* Where a raster lies in the plane: its pixel (0, 0) has the corner (x, y), in pixels of which `scale` make one px.
 * Joints slide along the contour to corners that are nearer than `slide` px. */
typedef struct pv_tess_place {
    int32_t x, y, scale;
    double slide;
    pv_cell period; /* px, of a plane that repeats; 0: it does not */
    const struct pave_image *drawing; /* whose levels tell where edges are; NULL: between pixels is all there is */
} pv_tess_place;

static inline int32_t pv_tess_size(const pv_tess *tess, int32_t face)
{
    return (int32_t)(tess->first[face + 1] - tess->first[face]);
}

/* The place of `corner` after or before this one in its ring. */
static inline int64_t pv_tess_next(const pv_tess *tess, int64_t place)
{
    int32_t face = tess->face_of[place];
    return place + 1 < tess->first[face + 1] ? place + 1 : tess->first[face];
}

static inline int64_t pv_tess_previous(const pv_tess *tess, int64_t place)
{
    int32_t face = tess->face_of[place];
    return place > tess->first[face] ? place - 1 : tess->first[face + 1] - 1;
}

/* Copies a ring's vertices, at most `most`; returns how many there are. */
int32_t pv_tess_ring(const pv_tess *tess, int32_t face, pv_cell *ring, int32_t most);

/* Indexes stars and faces of places after rings have changed. */
pave_result pv_tess_index(pave_context *context, pv_tess *tess);

/* Drops vertices from rings where one follows itself, then those that are in no ring. */
pave_result pv_tess_compact(pave_context *context, pv_tess *tess);

/* Is every ring simple and counter-clockwise, every side but those on the border shared by two faces, every vertex
 * used? Then the faces cover the region once. Says what is wrong by the context's message. Cost: linear. */
pave_result pv_tess_check(pave_context *context, const pv_tess *tess);

void pv_tess_free(pv_tess *tess);

/* best.c: the tessellation that the stones of a diagram are cut from. */
struct pave_cvd;
struct pave_stones_params;
pave_result pv_best_tess(pave_context *context, const struct pave_image *drawing, const struct pave_cvd *cvd,
                         const struct pave_stones_params *params, pv_tess *out);
