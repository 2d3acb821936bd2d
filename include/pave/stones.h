/* Stones: the polygons of a pavement.
 * Source: Waintraub and Celes 2012, III.C. What the text leaves open is a parameter here, with its reading. */
#ifndef PAVE_STONES_H
#define PAVE_STONES_H

#include <pave/cvd.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pave_stones pave_stones;

enum {
    PAVE_MODE_PAPER = 0, /* the text to the letter */
    PAVE_MODE_BEST = 1   /* the same spirit without its flaws: cells split by colour, one contour for both colours,
                            vertices made flat by min-cost assignment, each stone inscribed in its own cell, so that
                            no two overlap. A window needs far more around it than in the paper's mode, about 1000 px
                            at h = 4; a periodic plane as a whole a third of that */
};

/* Joints of best mode. */
enum {
    PAVE_JOINT_PAPER = 0, /* every corner moves half the grout towards the centroid: joints of varying width */
    PAVE_JOINT_EVEN = 1   /* every side moves half the grout inwards */
};

/* What becomes of parts of the drawing that are too small for a stone, in best mode. */
enum {
    PAVE_THIN_KEEP = 0, /* thin stones */
    PAVE_THIN_DROP = 1, /* they go to the stones around them */
    PAVE_THIN_WIDEN = 2 /* pave_lay widens them first (pave_image_widen) to thin_width; what comes later than that
                           keeps what it gets */
};

enum {
    PAVE_BORDER_WRAPPED = 0, /* each once and whole, where its site was first drawn: it may hang over the border */
    PAVE_BORDER_CUT = 1      /* cut along the border, each part moved into the plane: polygons in a row with the same
                                site; what is left of one thinner than 1/500 px is dropped */
};

typedef struct pave_stones_params {
    size_t size;
    int32_t mode;        /* PAVE_MODE_ */
    double grout;        /* joint width, px: every vertex moves half of it towards the stone's centroid; never so far
                            that the stone loses convexity or more than half of its extent there */
    double wide_angle;   /* an inner angle beyond this many degrees is wide; the text says 120 */
    int32_t passes;      /* times that wide angles are flattened in the shared tessellation. In each pass every
                            polygon with more than four corners asks for its widest ones, a vertex goes to the polygon
                            where it is widest, and all move at once by 0.6 of their way, so that no order is involved;
                            vertices between stones of different colours stay */
    double drop_angle;   /* wide corners of the single polygon are dropped from this angle on, degrees */
    double small_edge;   /* shorter edges of the single polygon lose an end, half sides */
    int32_t joint_style; /* PAVE_JOINT_ */
    int32_t thin;        /* PAVE_THIN_: pieces of less than a quarter of a stone that touch none of their colour */
    int32_t border;      /* PAVE_BORDER_: stones that cross the border of a periodic plane (pave_field_params) */
    double thin_width;   /* of PAVE_THIN_WIDEN, half sides */
    double aspect;       /* best mode: stones longer than so many times their width are cut across; 0: none is */
} pave_stones_params;

#define PAVE_STONES_PARAMS_INIT \
    { sizeof(pave_stones_params), PAVE_MODE_BEST, 1.0, 120.0, 5, 120.0, 0.5, PAVE_JOINT_EVEN, PAVE_THIN_KEEP, \
      PAVE_BORDER_WRAPPED, 1.0, 0.0 }

PAVE_API void pave_stones_params_init(pave_stones_params *params, size_t size);

/* Extracts the stones of a diagram. `drawing` and `field` are those that the diagram was made from.
 * Cost: linear in pixels and stones; 1 s for 100 000 stones at most. */
PAVE_API pave_result pave_stones_create(pave_context *context, const pave_image *drawing, const pave_field *field,
                                        const pave_cvd *cvd, const pave_stones_params *params, pave_stones **out);
PAVE_API void pave_stones_free(pave_stones **stones);

/* The window: its corner in the plane, and its size, px. A stone belongs to the window that holds the corner of the
 * lattice cell in which its site was first drawn; so windows that share out the plane share out its stones. Stones of a
 * periodic plane lie where their sites were first drawn, wherever the window is. */
PAVE_API int32_t pave_stones_x(const pave_stones *stones);
PAVE_API int32_t pave_stones_y(const pave_stones *stones);
PAVE_API int32_t pave_stones_width(const pave_stones *stones);
PAVE_API int32_t pave_stones_height(const pave_stones *stones);

PAVE_API int32_t pave_stones_count(const pave_stones *stones);

/* Where each stone's vertices begin: count + 1 numbers, the last is the number of all vertices. */
PAVE_API const int64_t *pave_stones_starts(const pave_stones *stones);

/* x, y of every vertex in the plane, px, counter-clockwise as seen (y grows down), each a multiple of 1/1000 px. */
PAVE_API const double *pave_stones_vertices(const pave_stones *stones);

/* Colour of each stone: the drawing's pixel value at the stone's centroid: 0 black, 255 white, or an entry of the
 * palette. */
PAVE_API const uint8_t *pave_stones_colours(const pave_stones *stones);

/* The palette of the stones; its count is 0 where they are black and white. */
PAVE_API const pave_palette *pave_stones_palette(const pave_stones *stones);

/* Colour of each stone as r, g, b, display values, for stones that have colours of their own, as tiles of a mosaic and
 * those from an SVG file; NULL for others. */
PAVE_API const uint8_t *pave_stones_rgb(const pave_stones *stones);

/* Site of each stone: its number in the whole plane. Ascending; polygons of the same number are parts of one stone that
 * was cut (PAVE_BORDER_CUT), or stones of a cell that the drawing divides (best mode). */
PAVE_API const int32_t *pave_stones_sites(const pave_stones *stones);

enum { PAVE_REPORT_BINS = 32 };

/* What is counted while a pavement is laid; of a merged one, the sums. */
typedef struct pave_report {
    size_t size;
    int32_t sites;                               /* n of Eq. 1 */
    int32_t stones;                              /* polygons that came out */
    int32_t lost;                                /* sites without a stone: an empty cell, or fewer than 3 vertices */
    int32_t repaired;                            /* stones that the last pass had to make valid */
    int32_t vanished;                            /* stones that the joints left nothing of */
    int32_t reduced;                             /* stones that the joints took a corner of */
    int64_t corners_before[PAVE_REPORT_BINS];    /* cells by number of vertices as traced (Fig. 9), */
    int64_t corners_after[PAVE_REPORT_BINS];     /* stones at the end; in the last bin: so many or more */
    int64_t areas[PAVE_REPORT_BINS];             /* stones by area (Fig. 12), in steps of area_step */
    double area_step;                            /* px^2 */
    double area_mean;                            /* px^2 */
    double area_deviation;                       /* standard deviation, px^2 */
    double coverage;                             /* sum of areas / area of the plane */
    double half_side;                            /* px */
    double seconds_field;                        /* time spent in each stage; 0 where pave_lay did not run it */
    double seconds_cvd;
    double seconds_stones;
    int32_t steps;                               /* of the diagram: pave_cvd_steps, pave_cvd_movement */
    double movement;
} pave_report;

/* Fills `report`, whose size must be set. */
PAVE_API pave_result pave_stones_report(pave_context *context, const pave_stones *stones, pave_report *report);

/* How stones are judged. */
typedef struct pave_stones_measure_params {
    size_t size;
    double half_side;   /* h, px, that near, far, thin and small are told by; 0: the one that the stones were laid
                           with, or else the root of the window's area by stones, halved (Eq. 1) */
    double joint_limit; /* a gap wider than this is a hole and not a joint, half sides */
} pave_stones_measure_params;

#define PAVE_STONES_MEASURE_PARAMS_INIT { sizeof(pave_stones_measure_params), 0.0, 1.5 }

PAVE_API void pave_stones_measure_params_init(pave_stones_measure_params *params, size_t size);

/* What stones are judged by. A share is 0..1: of all stones, or of all pixels of the window. A stone is invalid if it
 * has fewer than 3 corners, touches or crosses itself, or has no area; only valid ones cover ground. What is on the
 * ground is told at the pixels' centres. */
typedef struct pave_stones_measures {
    size_t size;
    int32_t width, height;              /* of the window, px */
    double half_side;                   /* h as it was used, px */
    int32_t stones;
    int32_t invalid;
    int32_t clockwise;                  /* valid stones that go round the other way than most */
    int32_t overlapping;                /* valid stones that overlap another one: exact, touching is not overlapping */
    int64_t vertices[PAVE_REPORT_BINS]; /* stones by number of corners; in the last bin: so many or more */
    double quads;                       /* share of stones with four corners */
    double triangles;                   /* share of stones with three */
    double nonconvex;                   /* share of stones that are valid and turn both ways, by more than 1e-6 of their
                                           area at a corner */
    double overlap;                     /* areas that two stones share, summed over all pairs / area of the window */
    double coverage;                    /* sum of areas / area of the window */
    double uncovered;                   /* share of pixels under no stone */
    double multiple;                    /* share of pixels under more than one */
    double mismatch;                    /* share of pixels under stones none of which has the drawing's colour */
    double straddlers;                  /* share of stones with under 95 % of their pixels in their own colour */
    double area_mean;                   /* px^2 */
    double area_median;                 /* px^2 */
    double area_cv;                     /* standard deviation / mean */
    double sliver;                      /* share of stones with 4 pi area / perimeter^2 under 0.3 */
    double tiny;                        /* share of stones under 1/8 of the median area */
    double small;                       /* share of stones under h^2, a quarter of a mean one */
    double thin;                        /* share of stones that fit through a slit of width h */
    double edge_mean, edge_max;         /* from where stones' colours change to the drawing's nearest edge, px; infinite
                                           if there is none */
    double missed_mean, missed_max;     /* and from the drawing's edges to where stones' colours change */
    double axis_bias;                   /* R4: stones more than 3 h from edges all lie alike (1) or as they like (0);
                                           the length of the mean of exp(4 i direction) */
    double near_mean, near_p90;         /* degrees, 0..45, between stones within 1.5 h of an edge and that edge; 22.5
                                           if they lie as they like; the mean, and what 90 % do not exceed */
    int32_t far_stones, near_stones;    /* how many those are */
    double joint_mean, joint_deviation; /* px, from a stone's side straight out to the next stone, by length */
    double joint_p5, joint_p95;         /* px, what 5 % and 95 % of the length of joints do not exceed */
    double jointed;                     /* share of the sides' length that has a joint, not a hole or the border */
} pave_stones_measures;

/* Judges stones against their drawing (one channel: see pave_image_threshold and pave_image_quantise), which is of
 * the size of their plane; colours are compared as its entries, each stone's being the nearest one. `out`, whose size
 * must be set, is filled; the stones may come from pave_stones_read, and need not be good ones. Of a window, only
 * what lies in it is looked at. Where pixels are under no stone, their colour for edge_ and missed_ is that of the
 * nearest stone by steps to side neighbours; distances are measured as in pave_field_create, exactly, and from
 * halfway between the pixels on both sides of an edge; where both have the edge they are 0. A stone lies along its
 * sides, weighted by length, as they are with quarter turns being all the same. Cost: linear; 0.3 s for 16 000 stones
 * and 1 Mpx, 24 bytes a pixel. */
PAVE_API pave_result pave_stones_measure(pave_context *context, const pave_image *drawing, const pave_stones *stones,
                                         const pave_stones_measure_params *params, pave_stones_measures *out);

#ifdef __cplusplus
}
#endif

#endif
