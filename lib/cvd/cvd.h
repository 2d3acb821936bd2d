/* The diagram from inside. */
#pragma once

#include "backend/backend.h"
#include "base/params.h"
#include "image/image.h"

extern const pv_table pv_cvd_table;

/* A part of the plane, px. */
typedef struct pv_rect {
    int32_t x, y, width, height;
} pv_rect;

/* How far from its home's first copy a copy is: whole periods, 1/256 px. */
typedef struct pv_shift {
    int32_t x, y;
} pv_shift;

/* All px are the diagram's own, `scale` to one of the drawing along a side; but those of params are the drawing's. */
struct pave_cvd {
    int32_t scale;
    pv_place place; /* of the region that was computed: the window and what is needed around it */
    pv_rect window;
    int32_t width, height; /* of the region, which may shrink while sites move */
    int32_t reserve;       /* how far around the window the region may reach, px */
    int32_t repeats;       /* the plane does, and the region may lie anywhere */
    int32_t site_count;
    int32_t *labels;        /* of the region, as places in sites */
    int32_t *window_labels; /* of the window; the same array if the window is the region */
    pave_site *sites;       /* in the plane's coordinates */
    int32_t *numbers;       /* in the whole plane */
    pv_shift *shifts;       /* NULL if the plane does not repeat */
    uint8_t *mine;          /* has the window this site's home cell's corner? Then its stone belongs to the window */
    int32_t exact;          /* labels are exact from this far inside the region's open borders, 1/256 px */
    int32_t radius;         /* no pixel is farther from its site, 1/256 px */
    int32_t far, stray;     /* the greatest of what the steps reported: pv_step */
    int32_t steps;
    double movement;        /* mean over the sites in the last step, px */
    pave_cvd_params params; /* half_side as it was used */
    int32_t backend;
    char backend_name[128];
};

/* h in px, as given or for a number of stones on a plane of this size. */
double pv_half_side(const pave_cvd_params *params, int32_t width, int32_t height);

/* pave_cvd_create on a field that may end too near to the window: then *out is NULL, and *needed tells how far around
 * the window it should reach, px. */
pave_result pv_cvd_create(pave_context *context, const pave_field *field, const pave_cvd_params *given,
                          int32_t *needed, pave_cvd **out);

/* First sites of a region, in its own coordinates. The arrays are the caller's to release, also on failure. */
typedef struct pv_seeds {
    pave_site *sites;
    pv_home *homes;
    int32_t *numbers;
    pv_shift *shifts; /* NULL if the plane does not repeat */
    int32_t count;
} pv_seeds;

/* seeds.c: draws the sites of the plane's region that `plane` describes. */
pave_result pv_seeds_draw(pave_context *context, const pave_cvd_params *params, const pv_plane *plane,
                          const pv_place *place, pv_seeds *out);
void pv_seeds_free(pv_seeds *seeds);

/* window.c: how far the iterations can carry something. The margin inside a region's open borders within which sites
 * may not be what they are in the whole plane, 1/256 px: before the first step 0, after each as follows. */
int32_t pv_margin_after(const pv_plane *plane, int32_t margin, int32_t radius);

/* The greatest distance that a site of the plane may have to the corner of its box, 1/256 px. */
int32_t pv_most_reach(const pave_cvd_params *params);

/* A first guess of the margin that iterations from `step` on will need, px. */
int32_t pv_margin_guess(const pave_cvd_params *params, int32_t step);

/* The window grown by `margin` px, cut to what lies within `bounds`. */
pv_rect pv_rect_grown(pv_rect window, int32_t margin, pv_rect bounds);

/* How far the window is from the nearest border of the region that is not a border of the plane, px; INT32_MAX if all
 * are. A plane that repeats has none. */
int32_t pv_rect_room(pv_rect window, pv_rect region, const pave_cvd *plane);

/* region.c: the diagram of a region by itself; with `copies`, sites first drawn outside the plane follow those inside
 * it. */
pave_result pv_region_make(pave_context *context, const pave_field *field, pv_rect region, int copies, pave_cvd *cvd);
void pv_region_drop(pave_cvd *cvd);
pv_rect pv_region_rect(const pave_cvd *cvd); /* the region */

/* A region's borders that are not borders of the plane: PV_LEFT and so on. */
int32_t pv_region_open(const pave_cvd *cvd, pv_rect region);

/* Describes the region's plane; without edges. */
void pv_region_plane(const pave_cvd *cvd, pv_plane *plane);

/* The greatest distance from a pixel of a part of the region to its site, 1/256 px. */
int32_t pv_region_radius(const pave_cvd *cvd, pv_rect part);

/* Which sites belong to the window. */
void pv_region_share(const pv_home *homes, pave_cvd *cvd);

/* iterate.c: has an engine move the region's sites and label its pixels; leaves less of the region, with less of
 * `seeds` and `edge`, if what iterations have taken from it need not be computed. Without seeds all of it stays. */
pave_result pv_iterate(pave_context *context, pv_plane *plane, pv_seeds *seeds, uint16_t *edge, pave_cvd *cvd);

/* torus.c: how much of the plane around one period it takes to compute the whole of a plane that repeats, px; and the
 * diagram of the window and `wanted` px around it from that. */
int32_t pv_torus_sites(const pave_cvd *cvd); /* in a period */
pave_result pv_torus_originals(pave_context *context, const pave_cvd *cvd, int32_t **originals); /* by number */
int32_t pv_torus_guess(const pave_cvd_params *params);
pave_result pv_torus_make(pave_context *context, const pave_field *field, int32_t wanted, pave_cvd *cvd);
