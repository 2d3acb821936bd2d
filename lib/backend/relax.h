/* How a site moves between two labellings (III.B). The C twin of shaders/relax.comp. */
#pragma once

#include "backend/backend.h"
#include "util/noise.h"

/* The pixels of a cell: how many, and the sums of their columns and rows. */
typedef struct pv_sum {
    int64_t count, x, y;
} pv_sum;

/* Turns a site at its place: along the edge if one is near, by the noise otherwise. */
void pv_site_turn(const pv_plane *plane, pave_site *site);

/* One row of plane->near, from plane->edge: a byte for each PV_NEAR px of the plane's width. */
void pv_near_row(const pv_plane *plane, int32_t row, uint8_t *near);

/* Fetches the edges around a site that is soon to move; it seldom moves far from there. */
void pv_site_prefetch(const pv_plane *plane, const pave_site *site);

/* How far a site is from its home cell, in x or in y, 1/256 px. */
int32_t pv_site_stray(const pv_plane *plane, int32_t index, const pave_site *site);

/* Moves a copy to where its original is, as long as that is in the plane: it stops at the border. */
void pv_site_copy(const pv_plane *plane, int32_t index, pave_site *sites);

/* Moves site `index` to its cell's centroid, and off the edge, by which it turns. Returns whether there is none near:
 * then the noise is still to turn it. */
int pv_site_relax(const pv_plane *plane, int32_t index, int32_t iteration, const pv_sum *sum, pave_site *site);

/* Turns a site by the noise. `cell` is kept from site to site. */
void pv_site_turn_by_noise(const pv_plane *plane, pv_noise_cell *cell, pave_site *site);
