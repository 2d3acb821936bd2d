/* The centroidal Voronoi diagram of oriented boxes: which stone each pixel belongs to.
 * Source: Waintraub and Celes 2012, III.B. The arithmetic is integer throughout: docs/determinism.md. */
#ifndef PAVE_CVD_H
#define PAVE_CVD_H

#include <pave/field.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pave_cvd pave_cvd;

/* Lengths are in pixels of the drawing, or in half sides where the unit says "half sides". */
typedef struct pave_cvd_params {
    size_t size;
    double half_side;       /* h: half the side of a mean stone, px; the text's default is 4 */
    int32_t stones;         /* 0, or the number of stones wanted: sets half_side by Eq. 1 */
    int32_t iterations;     /* most times that sites move to the centroid of their cell */
    uint64_t seed;          /* everything random follows from it */
    double cap;             /* half extent of the metric's flat box, half sides (Fig. 5 gives no number) */
    double scale_min;       /* the box is stretched by s_x, drawn uniformly from scale_min..scale_max */
    double scale_max;
    double noise_angle;     /* rotation away from edges: Perlin noise of -1..1 times this, degrees */
    double noise_length;    /* wave length of that noise, half sides */
    double push_within;     /* sites nearer to an edge than this are moved and aligned, half sides; 0: none */
    double push_to;         /* to this distance from the edge, half sides */
    int32_t supersample;    /* pixels of the diagram to one of the drawing, along a side: on the drawing's own pixels
                               cells line up with the axes; 0: as many as the stones' mode is best with, which pave_lay
                               knows (2, or 1 in paper mode; 1 for a diagram by itself) */
    int32_t window[4];      /* x, y, width, height of the part that is wanted, px; all 0: the whole plane */
    double window_margin;   /* how far around the window labels must be exact too, half sides: what the stones stage
                               looks at; pave_lay makes it larger where it has to */
    double relaxation;      /* W: a site goes W times the way to the centroid of its cell, and then no farther from the
                               centroid than 2h in x and in y; 1 is Lloyd's method, 1.5 to 1.8 is still sooner */
    double until_still;     /* end before `iterations`, after the step in which the sites moved by no more than this on
                               average, px; 0: never. Not for windows: it looks at all sites of the plane */
} pave_cvd_params;

#define PAVE_CVD_PARAMS_INIT \
    { sizeof(pave_cvd_params), 4.0, 0, 20, 1, 0.5, 0.5, 2.0, 180.0, 32.0, 1.5, 1.0, 0, \
      { 0, 0, 0, 0 }, 64.0, 1.0, 0.0 }

PAVE_API void pave_cvd_params_init(pave_cvd_params *params, size_t size);

/* How far a point is from a site, where (u, v) is the point less the site, turned by the rotation (cosine, sine). */
enum {
    PAVE_METRIC_BOX = 0,    /* its distance from the box |u| <= half_x, |v| <= half_y: stones of a pavement */
    PAVE_METRIC_SQUARE = 1, /* max(half_x |u|, half_y |v|): a pyramid over a rectangle, for tiles of a mosaic */
    PAVE_METRIC_DIAMOND = 2 /* half_x |u| + half_y |v|: a pyramid over a rhombus, as Hausner writes it */
};

/* A site, in fixed point. px are the diagram's own here, of which `supersample` make one of the drawing. */
typedef struct pave_site {
    int32_t x, y;           /* 1/256 px; (0, 0) is the plane's top left corner, y grows down */
    int32_t cosine, sine;   /* 1/65536 */
    int32_t half_x, half_y; /* half extents of the box, 1/256 px; or slopes of the pyramid, 1/65536 */
} pave_site;

/* Computes the diagram over the drawing of `field`, or over a window of it, on the context's backend. A pixel belongs
 * to the site at the smallest distance, and to the site of lower index among equals. A site whose cell came out empty
 * is drawn again at random in the lattice cell (2h x 2h) where it lies.
 * A window has the labels and sites that the whole has there, bit for bit: more than the window is computed, as far as
 * iterations can carry something, and it is checked afterwards that it was enough.
 * Where the field is periodic so is the diagram: a whole number of lattice cells fits into the drawing, sites have
 * copies whole periods away, and a window may lie across the border: it begins inside the drawing and is no larger. A
 * drawing that repeats must have the area of a stone, 4h^2: PAVE_ERR_ARGUMENT.
 * Cost: about iterations * pixels * 4 ns on one AVX2 core; memory 6 bytes a pixel and 150 a site. */
PAVE_API pave_result pave_cvd_create(pave_context *context, const pave_field *field, const pave_cvd_params *params,
                                     pave_cvd **out);
PAVE_API void pave_cvd_free(pave_cvd **cvd);

/* The window: its corner in the plane, and its size, in the diagram's own px. */
PAVE_API int32_t pave_cvd_x(const pave_cvd *cvd);
PAVE_API int32_t pave_cvd_y(const pave_cvd *cvd);
PAVE_API int32_t pave_cvd_width(const pave_cvd *cvd);
PAVE_API int32_t pave_cvd_height(const pave_cvd *cvd);

/* h in px of the drawing: as given, or as it follows from the number of stones. */
PAVE_API double pave_cvd_half_side(const pave_cvd *cvd);

/* The diagram's px to one of the drawing, along a side. */
PAVE_API int32_t pave_cvd_supersample(const pave_cvd *cvd);

/* The site of each pixel of the window, row by row from the top: its place in pave_cvd_sites. */
PAVE_API const int32_t *pave_cvd_labels(const pave_cvd *cvd);

PAVE_API int32_t pave_cvd_site_count(const pave_cvd *cvd);
PAVE_API const pave_site *pave_cvd_sites(const pave_cvd *cvd);

/* The number of each site in the whole plane; ascending, but in a periodic one, where copies share theirs. Where there
 * is a window pave_cvd_sites holds the sites that were computed for it, some of them around it and not exact. */
PAVE_API const int32_t *pave_cvd_site_numbers(const pave_cvd *cvd);

/* The steps that were done, `iterations` or less; and by how much the sites moved in the last one: the larger of the
 * ways in x and in y, the mean over all sites, px; 0 without a step, -1 of a window, for which it is not known. */
PAVE_API int32_t pave_cvd_steps(const pave_cvd *cvd);
PAVE_API double pave_cvd_movement(const pave_cvd *cvd);

/* The backend that ran (PAVE_BACKEND_), and its name, "cpu (AVX2)". */
PAVE_API int32_t pave_cvd_backend(const pave_cvd *cvd);
PAVE_API const char *pave_cvd_backend_name(const pave_cvd *cvd);

/* The diagram as an image of one PAVE_U32 channel named "label". */
PAVE_API pave_result pave_cvd_image(pave_context *context, const pave_cvd *cvd, pave_image **out);

#ifdef __cplusplus
}
#endif

#endif
