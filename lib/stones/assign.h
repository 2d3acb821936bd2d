/* In which face each vertex is to be flat. */
#pragma once

#include "stones/blocks.h"

/* In a tessellation whose vertices have three faces each, faces have four corners on average once every inner vertex is
 * flat in one of its three. A face of d corners can take d - 4 flat ones, and to bend a vertex straight in a face costs
 * 1 - cos of the angle it lacks; no more than that of `most_lack` degrees. The cheapest choice with the fewest corners
 * left over is made block by block of the lattice, twice: the second time in blocks moved by half, where each block
 * takes what lies around it as given. Vertices between colours can be flat only in the face that is alone with its
 * colour there. Sets tess->flat. */
typedef struct pv_assign_params {
    int64_t block;       /* side of a block, grid units */
    double most_lack;    /* degrees */
    double contour_lack; /* degrees, for vertices of the contour */
} pv_assign_params;

pave_result pv_assign_flats(pave_context *context, const pv_assign_params *params, pv_tess *tess, double from,
                            double to);

/* Does the vertex at a place of `corner` count as a corner of its face? Junctions do unless they are flat there, bends
 * where they are convex by 30 degrees or more. */
int pv_is_corner(const pv_tess *tess, int64_t place);
