/* Mosaics: a photo laid in oriented tiles that follow its edges.
 * Source: Hausner 2001, "Simulating Decorative Mosaics". What the text leaves open is a parameter here. */
#ifndef PAVE_MOSAIC_H
#define PAVE_MOSAIC_H

#include <pave/stones.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a mosaic is made from. Images have the photo's size; NULL where there is none. */
typedef struct pave_curves pave_curves;
typedef struct pave_mosaic_sources {
    size_t size;
    const pave_image *photo;     /* colours; where its alpha is under one half there is no tile */
    const pave_curves *curves;   /* edges as the artist draws them */
    const pave_image *edges;     /* edges as a mask: lines lighter than one half; they are thinned */
    const pave_image *direction; /* the field itself: two channels, x and y of a vector (integers: 1/2 is 0), or one, an
                                    angle of which 1 is a whole turn */
    const pave_image *sizes;     /* the relative side of tiles, or regions: see `size_from` */
    const uint8_t *palette;      /* r, g, b of the tesserae in stock, display values; NULL: any colour */
    const int32_t *stock;        /* how many there are of each colour; NULL: as many as it takes */
    int32_t palette_count;
} pave_mosaic_sources;

#define PAVE_MOSAIC_SOURCES_INIT { sizeof(pave_mosaic_sources), NULL, NULL, NULL, NULL, NULL, NULL, NULL, 0 }

enum { PAVE_TILE_SQUARE = 0, PAVE_TILE_ELLIPSE = 1, PAVE_TILE_CELL = 2 };
enum { PAVE_PYRAMID_SQUARE = 0, PAVE_PYRAMID_DIAMOND = 1 };
enum { PAVE_DIRECTION_AUTO = 0, PAVE_DIRECTION_GRADIENT = 1, PAVE_DIRECTION_HARMONIC = 2 };
enum { PAVE_SIZE_EVEN = 0, PAVE_SIZE_IMAGE = 1, PAVE_SIZE_REGIONS = 2, PAVE_SIZE_DETAIL = 3 };
enum { PAVE_START_JITTER = 0, PAVE_START_RANDOM = 1 };
enum { PAVE_COLOUR_AREA = 0, PAVE_COLOUR_POINT = 1 };

/* Lengths are in mean tile sides d = sqrt(area / tiles) where the unit says "sides". */
typedef struct pave_mosaic_params {
    size_t size;
    int32_t mode;             /* PAVE_MODE_BEST: the cells as a mesh of quadrilaterals that leaves no holes;
                                 PAVE_MODE_PAPER: the text to the letter, plain tiles */
    int32_t tiles;            /* number of tiles */
    double tile_side;         /* or the side of a tile, px; 0: by the number */
    double aspect;            /* long side over short side, beta squared in the text; the long one lies along edges */
    uint64_t seed;
    int32_t direction;        /* PAVE_DIRECTION_: the gradient of the distance from the edges (the text, paper mode), or
                                 the harmonic extension of the edges' own directions (best mode) */
    double strength;          /* of the edges that are found where none are given: 0 none .. 1 the faintest */
    int32_t size_from;        /* PAVE_SIZE_: all alike; from the image, black 0 .. white 1; by its regions, blue
                                 background, green figure, magenta detail (Fig. 10b); by the photo's own detail */
    double size_figure;       /* side of tiles in the figure and in the detail, where the background's is 1; by the */
    double size_detail;       /* photo's own detail sides are between 1 and size_detail */
    int32_t pyramid;          /* PAVE_PYRAMID_: the metric max(|u|, |v|), or the text's own |u| + |v| */
    int32_t start;            /* PAVE_START_: stratified, or by rejection sampling */
    int32_t iterations;       /* of Lloyd's method: free, */
    int32_t avoiding;         /* with the edges masked, */
    int32_t closing;          /* and free again */
    double relaxation;        /* 1: sites move to the centroids of their cells; more: beyond */
    double edge_width;        /* half the thickness of masked edges, sides */
    double joint;             /* best mode: between tiles, sides */
    double delta;             /* paper mode: side of a tile, sides of its cell */
    int32_t shape;            /* paper mode: PAVE_TILE_ */
    int32_t colour;           /* PAVE_COLOUR_: mean under the tile in linear light, or the pixel at its centre */
    int32_t periodic;         /* 1: the photo's opposite borders meet, and so do the tiles across them */
    int32_t chips;            /* best mode: 1: all tiles have four corners if they can, and chips fill what
                                 they leave free; 0: only where that would be a hole */
} pave_mosaic_params;

#define PAVE_MOSAIC_PARAMS_INIT \
    { sizeof(pave_mosaic_params), PAVE_MODE_BEST, 2000, 0.0, 1.0, 1, PAVE_DIRECTION_AUTO, 0.5, PAVE_SIZE_EVEN, \
      0.7, 0.5, PAVE_PYRAMID_SQUARE, PAVE_START_JITTER, 40, 20, 1, 1.4, 0.2, 0.05, 0.8, PAVE_TILE_SQUARE, \
      PAVE_COLOUR_AREA, 0, 0 }

PAVE_API void pave_mosaic_params_init(pave_mosaic_params *params, size_t size);
PAVE_API void pave_mosaic_sources_init(pave_mosaic_sources *sources, size_t size);

/* Curves as polylines: curve i has the points starts[i] .. starts[i + 1] - 1, x and y in px; both are copied. */
PAVE_API pave_result pave_curves_create(pave_context *context, int32_t count, const int64_t *starts,
                                        const double *points, pave_curves **out);
/* Reads the outlines of an SVG file: path, polyline, polygon, line, rect, circle and ellipse, with transforms. */
PAVE_API pave_result pave_curves_read(pave_context *context, const char *path, pave_curves **out);
PAVE_API void pave_curves_free(pave_curves **curves);
PAVE_API int32_t pave_curves_count(const pave_curves *curves);
PAVE_API const int64_t *pave_curves_starts(const pave_curves *curves);
PAVE_API const double *pave_curves_points(const pave_curves *curves);

/* Where the edges are and how the field turns. */
typedef struct pave_guide pave_guide;

/* Finds or takes over the edges, and computes the direction field (section 4). */
PAVE_API pave_result pave_guide_create(pave_context *context, const pave_mosaic_sources *sources,
                                       const pave_mosaic_params *params, pave_guide **out);
PAVE_API void pave_guide_free(pave_guide **guide);
PAVE_API int32_t pave_guide_width(const pave_guide *guide);
PAVE_API int32_t pave_guide_height(const pave_guide *guide);

/* For each pixel: 1 on an edge; and the direction along the edges, of which 65536 make a turn. */
PAVE_API const uint8_t *pave_guide_edges(const pave_guide *guide);
PAVE_API const uint16_t *pave_guide_directions(const pave_guide *guide);

/* Places around which the field turns by a part of a turn, so that no rows can follow it there: x and y in px. */
PAVE_API int32_t pave_guide_singularity_count(const pave_guide *guide);
PAVE_API const double *pave_guide_singularities(const pave_guide *guide);

/* Lays the mosaic; `guide` may be NULL, then it is made from the sources. The stones have colours of their own:
 * pave_stones_rgb. Cost: .8 Mpx and 2000 tiles take half a second on two cores. */
PAVE_API pave_result pave_mosaic_create(pave_context *context, const pave_mosaic_sources *sources,
                                        const pave_guide *guide, const pave_mosaic_params *params, pave_stones **out);

/* What a mosaic is judged by, with the names of docs/mosaic.md. */
typedef struct pave_mosaic_measure {
    size_t size;
    int32_t tiles;         /* polygons that came out, without chips */
    int32_t lost;          /* sites without one */
    int32_t singularities; /* of the field */
    double tile_side;      /* d, px */
    double coverage;       /* sum of areas / area of the photo */
    double overlap;        /* area that two tiles share / area of the photo */
    double corners4;       /* share of tiles with four corners */
    double squareness;     /* mean over these of the largest deviation of a corner from 90 degrees */
    double aspect;         /* median long side / short side */
    double side_cv;        /* standard deviation / mean of the root of the area */
    double field_angle;    /* mean angle between a tile's sides and the field in it, degrees */
    double edge_angle;     /* the same against the edges near it */
    double straddlers;     /* share of tiles that an edge cuts into parts of which the smaller has 15 % or more */
    double delta_e;        /* mean CIEDE2000 of a tile against the mean light under it */
    double delta_e_p95;
    double sizes_met;      /* share of tiles with a side within 25 % of the wanted one */
    double size_error;     /* mean of |side / wanted side - 1| */
    int32_t chips;         /* the last of the stones: they count only for coverage and overlap */
    int32_t reserved;      /* 0 */
} pave_mosaic_measure;

/* Fills `measure`, whose size must be set. PAVE_ERR_ARGUMENT if the stones are no mosaic. */
PAVE_API pave_result pave_mosaic_measure_of(pave_context *context, const pave_stones *stones,
                                            pave_mosaic_measure *measure);

#ifdef __cplusplus
}
#endif

#endif
