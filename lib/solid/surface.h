/* What can be told of a mesh before it is filled. */
#pragma once

#include "solid/solid.h"

/* Vertices at the same place count as one. */
typedef struct pv_surface {
    int32_t *triangles; /* 3 a triangle, of merged vertices; degenerate ones are dropped */
    int64_t count;
    int64_t open_edges;    /* with one triangle */
    int64_t crowded_edges; /* with more than two */
    int64_t turned_edges;  /* whose two triangles run the same way along them */
} pv_surface;

pave_result pv_surface_create(pave_context *context, const pave_mesh *mesh, pv_surface *out);
void pv_surface_free(pv_surface *surface);

/* winding.c: the generalised winding number, for surfaces with holes (Jacobson et al. 2013), by a tree whose distant
 * parts count as dipoles (Barill et al. 2018). */
typedef struct pv_winding pv_winding;

pave_result pv_winding_create(pave_context *context, const double *vertices, const pv_surface *surface,
                              pv_winding **out);
void pv_winding_free(pv_winding *winding);
double pv_winding_number(const pv_winding *winding, const double point[3]);
