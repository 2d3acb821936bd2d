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
    PAVE_MODE_BEST = 1   /* the same spirit without its flaws: stones that could be laid */
};

/* Joints of best mode. */
enum {
    PAVE_JOINT_PAPER = 0, /* every corner moves half the grout towards the centroid: joints of varying width */
    PAVE_JOINT_EVEN = 1   /* every side moves half the grout inwards */
};

/* What becomes of parts of the drawing that are too small for a stone, in best mode. */
enum {
    PAVE_THIN_KEEP = 0,  /* thin stones */
    PAVE_THIN_WIDEN = 1, /* the drawing is thickened there */
    PAVE_THIN_DROP = 2   /* they go to the stones around them */
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
    int32_t thin;        /* PAVE_THIN_ */
    double aspect;       /* stones longer than this times their width are divided */
} pave_stones_params;

#define PAVE_STONES_PARAMS_INIT \
    { sizeof(pave_stones_params), PAVE_MODE_BEST, 1.0, 120.0, 5, 120.0, 0.5, \
      PAVE_JOINT_EVEN, PAVE_THIN_KEEP, 4.0 }

PAVE_API void pave_stones_params_init(pave_stones_params *params, size_t size);

/* Extracts the stones of a diagram. `drawing` and `field` are those that the diagram was made from.
 * Cost: linear in pixels and stones; 1 s for 100 000 stones at most. */
PAVE_API pave_result pave_stones_create(pave_context *context, const pave_image *drawing, const pave_field *field,
                                        const pave_cvd *cvd, const pave_stones_params *params, pave_stones **out);
PAVE_API void pave_stones_free(pave_stones **stones);

/* The window: its corner in the plane, and its size, px. A stone belongs to the window that holds the corner of the
 * lattice cell in which its site was first drawn; so windows that share out the plane share out its stones. */
PAVE_API int32_t pave_stones_x(const pave_stones *stones);
PAVE_API int32_t pave_stones_y(const pave_stones *stones);
PAVE_API int32_t pave_stones_width(const pave_stones *stones);
PAVE_API int32_t pave_stones_height(const pave_stones *stones);

PAVE_API int32_t pave_stones_count(const pave_stones *stones);

/* Where each stone's vertices begin: count + 1 numbers, the last is the number of all vertices. */
PAVE_API const int64_t *pave_stones_starts(const pave_stones *stones);

/* x, y of every vertex in the plane, px, counter-clockwise as seen (y grows down), each a multiple of 1/1000 px. */
PAVE_API const double *pave_stones_vertices(const pave_stones *stones);

/* Colour of each stone: the drawing's pixel value at the stone's centroid, 0 black ... 255 white. */
PAVE_API const uint8_t *pave_stones_colours(const pave_stones *stones);

/* Site of each stone: its number in the whole plane. Ascending. In best mode a cell that the drawing divides gives
 * several stones of one site, with parts 0, 1 ... */
PAVE_API const int32_t *pave_stones_sites(const pave_stones *stones);
PAVE_API const int32_t *pave_stones_parts(const pave_stones *stones);

enum { PAVE_MEASURE_BINS = 32 };

/* What a pavement is judged by. */
typedef struct pave_measure {
    size_t size;
    int32_t sites;                               /* n of Eq. 1 */
    int32_t stones;                              /* polygons that came out */
    int32_t lost;                                /* sites without a stone: an empty cell, or fewer than 3 vertices */
    int32_t repaired;                            /* stones that the last pass had to make valid */
    int32_t vanished;                            /* stones that the joints left nothing of */
    int32_t reduced;                             /* stones that the joints took a corner of */
    int64_t corners_before[PAVE_MEASURE_BINS];   /* cells by number of vertices as traced (Fig. 9), */
    int64_t corners_after[PAVE_MEASURE_BINS];    /* stones at the end; in the last bin: so many or more */
    int64_t areas[PAVE_MEASURE_BINS];            /* stones by area (Fig. 12), in steps of area_step */
    double area_step;                            /* px^2 */
    double area_mean;                            /* px^2 */
    double area_deviation;                       /* standard deviation, px^2 */
    double coverage;                             /* sum of areas / area of the plane */
    double half_side;                            /* px */
    double seconds_field;                        /* time spent in each stage; 0 where pave_lay did not run it */
    double seconds_cvd;
    double seconds_stones;
} pave_measure;

/* Fills `measure`, whose size must be set. */
PAVE_API pave_result pave_stones_measure(pave_context *context, const pave_stones *stones, pave_measure *measure);

#ifdef __cplusplus
}
#endif

#endif
