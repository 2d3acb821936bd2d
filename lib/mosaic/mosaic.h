/* Mosaics from inside. */
#pragma once

#include "cvd/cvd.h"
#include "stones/stones.h"
#include "stones/tess.h"
#include "util/fixed.h"

#include <pave/mosaic.h>

extern const pv_table pv_mosaic_table;

/* The photo in the two ways that it is looked at. */
typedef struct pv_photo {
    int32_t width, height;
    float *light; /* r, g, b of each pixel, proportional to light, 0..1 */
    float *lab;   /* CIELAB of each pixel */
    uint8_t *hole; /* 1: transparent; NULL: no pixel is */
} pv_photo;

/* photo.c */
pave_result pv_photo_create(pave_context *context, const pave_image *image, pv_photo *out);
void pv_photo_free(pv_photo *photo);
/* Conversions of r, g, b in light and of CIELAB, without the libm, so that they are the same everywhere. */
void pv_tile_lab(const double light[3], double lab[3]);
double pv_tile_light(double display);
uint8_t pv_tile_code(double light);
/* How far apart two colours look. */
double pv_ciede2000(const double a[3], const double b[3]);

struct pave_curves {
    int32_t count;
    int64_t *starts;
    double *points;
};

struct pave_guide {
    int32_t width, height;
    int32_t wraps; /* its borders meet */
    uint8_t *edge;
    uint16_t *direction;
    float *away; /* from the nearest edge, px; NULL: there are none */
    float *way; /* along the edge, 2 a pixel: the double angle as a vector; only on edges */
    int32_t singularities;
    double *singularity;
};

/* edges.c: edges as pixels, one wide. All mark them in `guide->edge`, which is clear. */
pave_result pv_edges_find(pave_context *context, const pv_photo *photo, double side, double strength,
                          pave_guide *guide);
pave_result pv_edges_take(pave_context *context, const pave_image *mask, pave_guide *guide);
void pv_edges_draw(const pave_curves *curves, pave_guide *guide);
/* chains.c: of found edges keeps those that tiles can follow: no shorter than `least` px, no nearer to a stronger one
 * than `apart`, not along the border. */
pave_result pv_edges_clean(pave_context *context, double least, double apart, pave_guide *guide);

/* field.c: the direction field from the edges. */
pave_result pv_field_gradient(pave_context *context, pave_guide *guide);
pave_result pv_field_harmonic(pave_context *context, int32_t fold, double side, pave_guide *guide);
pave_result pv_field_take(pave_context *context, const pave_image *image, pave_guide *guide);
pave_result pv_field_singularities(pave_context *context, int32_t fold, double side, pave_guide *guide);

/* A place along a line of `length`: what lies beyond its ends is at the other end if it wraps, else at this one. */
static inline int32_t pv_inside(int32_t v, int32_t length, int32_t wraps)
{
    if (v >= 0 && v < length)
        return v;
    return wraps ? pv_modulo(v, length) : v < 0 ? 0 : length - 1;
}

/* guide.c */
pave_result pv_guide_make(pave_context *context, const pave_mosaic_sources *sources, const pave_mosaic_params *params,
                          const pv_photo *photo, pave_guide **out);

/* One mosaic on its way from photo to tiles. */
typedef struct pv_work {
    const pave_mosaic_sources *sources;
    const pave_mosaic_params *params;
    const pave_guide *guide;
    pv_photo photo;
    int32_t width, height;
    int32_t n;       /* tiles wanted */
    double side;     /* d, px: of the mean tile */
    float *size;     /* of a tile at each pixel, relative; NULL: 1 everywhere */
    double size_min; /* the least of them */
    double scale;    /* times size: a tile's side, px */
    pave_cvd *cvd;
    const struct pv_work *period; /* what repeats: this is it with `margin` px of its copies around; or NULL */
    int32_t margin, needed;       /* needed: once it is packed, how large the margin should have been */
} pv_work;

/* Is the label one of a tile that is wanted, not of a hole or of a copy? */
static inline int pv_is_tile(const pv_work *w, int32_t label)
{
    return label < w->cvd->site_count && w->cvd->mine[label];
}

/* The side that a tile at (x, y) is wanted to have, px. */
static inline double pv_wanted_side(const pv_work *w, double x, double y)
{
    int32_t ix = x > 0 ? (int32_t)x : 0, iy = y > 0 ? (int32_t)y : 0;
    ix = ix < w->width ? ix : w->width - 1;
    iy = iy < w->height ? iy : w->height - 1;
    return w->size ? w->scale * (double)w->size[(int64_t)iy * w->width + ix] : w->scale;
}

/* size.c: how large tiles are to be where. */
pave_result pv_sizes_read(pave_context *context, pv_work *w);

/* sow.c: the first sites, `w->n` of them, with slopes and directions still to be set. */
pave_result pv_sites_sow(pave_context *context, const pv_work *w, pave_site *sites, int32_t *count);

/* pack.c: Lloyd's method, with the edges masked for a while (sections 3 and 6). */
pave_result pv_tiles_pack(pave_context *context, pv_work *w);

/* period.c: a first guess of the margin; one period with that much around it; does each side of the period's faces lie
 * on another of them, or on a copy? And tiles moved from there to where the period is, and with copies around. */
int32_t pv_period_guess(const pv_work *w);
pave_result pv_period_widen(pave_context *context, const pv_work *w, int32_t margin, pave_guide *guide, pv_work *wide);
void pv_period_drop(pave_guide *guide, pv_work *wide);
int pv_period_closes(const pv_work *w, const pv_tess *tess);
void pv_period_settle(const pv_work *w, pave_stones *stones);
pave_result pv_period_copies(pave_context *context, const pave_stones *stones, pave_stones *out);

/* What is kept of a mosaic with its stones. */
typedef struct pv_mosaic_record {
    pave_mosaic_params params;
    pave_mosaic_measure measure;
    int32_t served; /* sites that have a tile */
    int32_t chips;  /* the last of the stones */
} pv_mosaic_record;

/* tiles.c: the text's own tiles. */
pave_result pv_tiles_cut(pave_context *context, const pv_work *w, pave_stones *out);

/* quads.c: tiles as quadrilaterals that leave nothing between them but joints; or, if `plain`, cells as they are.
 * *closed: 0: a period's margin is too small. */
pave_result pv_quads_cut(pave_context *context, const pv_work *w, int plain, int *closed, pave_stones *out);

/* cut.c: a tile in each face, or if `plain` the face itself. */
pave_result pv_faces_cut(pave_context *context, const pv_work *w, const pv_tess *tess, int plain, pave_stones *out);

/* colour.c */
pave_result pv_tiles_colour(pave_context *context, const pv_work *w, pave_stones *stones);

/* overlap.c: the area that two tiles share, summed over all pairs, px^2. */
pave_result pv_overlap(pave_context *context, const pave_stones *stones, int periodic, double *area);

/* judge.c */
pave_result pv_mosaic_judge(pave_context *context, const pv_work *w, const pave_stones *stones,
                            pave_mosaic_measure *out);

/* Distance from the nearest marked pixel, px; a large number where there is none. */
pave_result pv_distance_from(pave_context *context, const uint8_t *marks, int32_t width, int32_t height, int32_t wraps,
                             float **out);
