/* Seamless tilings: a large texture, or one that repeats without a seam, from a small one.
 * Source: Hartanto 2007, "Generating a seamless tiling of a nature image" (mode paper); Efros and Freeman 2001 (mode
 * fast); Kwatra et al. 2003 (mode best). */
#ifndef PAVE_TILING_H
#define PAVE_TILING_H

#include <pave/image.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pave_tiling pave_tiling;

enum {
    PAVE_TILING_BEST = 0,  /* copies of the exemplar, cut where they differ least; the worst seams are cut again */
    PAVE_TILING_FAST = 1,  /* blocks of the exemplar, cut where they differ least */
    PAVE_TILING_PAPER = 2  /* the text to the letter: blocks side by side, averaged where they overlap */
};

/* In which directions the result repeats without a seam. Mode paper knows none of them. */
enum { PAVE_PERIODIC_XY = 0, PAVE_PERIODIC_X = 1, PAVE_PERIODIC_Y = 2, PAVE_PERIODIC_NONE = 3 };

/* How blocks are compared with the exemplar. All find the same block. */
enum {
    PAVE_SEARCH_AUTO = 0,      /* by size; on a graphics processor if the context's backend is Vulkan */
    PAVE_SEARCH_REFERENCE = 1, /* one pixel after the other: the definition, for tests */
    PAVE_SEARCH_DIRECT = 2,    /* vectors of pixels */
    PAVE_SEARCH_FFT = 3,       /* all differences at once by Fourier transforms, near ties by integers */
    PAVE_SEARCH_VULKAN = 4     /* vectors of pixels, by a compute shader */
};

typedef struct pave_tiling_params {
    size_t size;
    int32_t mode;           /* PAVE_TILING_ */
    int32_t extent[2];      /* width and height of the result, px; 0: twice the exemplar's; with keep the exemplar's,
                               with wang a tile as large as the exemplar */
    int32_t periodic;       /* PAVE_PERIODIC_ */
    uint64_t seed;          /* everything random follows from it */
    int32_t fraction;       /* side of a block, px; 0: paper 20, otherwise from the size of the features */
    int32_t overlap;        /* how far blocks overlap, px; 0: paper 3, otherwise a third of the block's step */
    int32_t search;         /* PAVE_SEARCH_ */
    int32_t keep;           /* 1: make the image itself tile: only a band at its border changes */
    int32_t band;           /* width of that band, px; 0: a feature and a half */
    int32_t wang;           /* 2 or 3: a complete set of Wang tiles with so many colours of edges; 0: none. The result
                               is colours^2 x colours^2 tiles that fit, the whole periodic */
    int32_t turns;          /* 1: copies may be turned by quarter turns */
    int32_t flips;          /* 1: copies may be mirrored */
    int32_t rounds;         /* best: how many turns every part has to cut its worst seams again; 0: by size. A result
                               of up to four exemplars is laid three times for a third of them, and the best of the
                               three has the other two thirds */
    double flatten;         /* share of slow changes of brightness that is taken out for comparing, 0..1 */
    double joints;          /* weight of the distance to joints (dark or bright lines between stones) */
    double coverage;        /* weight of using all of the exemplar evenly */
    double repeat;          /* weight of not showing the same thing twice nearby, or at regular steps */
    double guide_weight;    /* weight of the guide image */
    double opaque;          /* pixels whose alpha is less are not used */
} pave_tiling_params;

#define PAVE_TILING_PARAMS_INIT \
    { sizeof(pave_tiling_params), PAVE_TILING_BEST, { 0, 0 }, PAVE_PERIODIC_XY, 1, 0, 0, PAVE_SEARCH_AUTO, 0, 0, 0, \
      0, 0, 0, 0.3, 1.0, 0.6, 0.2, 1.0, 0.5 }

PAVE_API void pave_tiling_params_init(pave_tiling_params *params, size_t size);

/* Makes a tiling from `count` exemplars (1 to 16; the same channels, type and encoding). Pixels with an alpha under
 * `opaque`, and those that are not finite, are not used. 8-bit channels are compared as they are; others as 4096
 * steps between the exemplars' least and greatest value. Everything that decides is integer: the same tiling comes
 * out for every number of threads, way of searching and backend.
 * `guide` is NULL, or an image as large as the result whose brightness the result is to follow.
 * Errors: PAVE_ERR_ARGUMENT if the exemplar has not room for a fraction, or the fraction not for an overlap.
 * Cost: best, 20 to 50 us a pixel of the result on one core, fast 1 us; memory about 40 bytes a pixel. */
PAVE_API pave_result pave_tiling_create(pave_context *context, const pave_image *const *exemplars, int32_t count,
                                        const pave_image *guide, const pave_tiling_params *params,
                                        pave_tiling **out);
PAVE_API void pave_tiling_free(pave_tiling **tiling);

PAVE_API int32_t pave_tiling_width(const pave_tiling *tiling);
PAVE_API int32_t pave_tiling_height(const pave_tiling *tiling);

/* Where a pixel of the result comes from: which exemplar, which of its pixels, and how that was turned: quarter turns
 * clockwise, and 4 if it was mirrored left to right before. */
typedef struct pave_source { int32_t exemplar, x, y, turn; } pave_source;

/* The sources of all pixels, row by row from the top. Where mode paper averages, the block laid last. */
PAVE_API const pave_source *pave_tiling_sources(const pave_tiling *tiling);

/* The same as an image of four PAVE_U32 channels: exemplar, x, y, turn. */
PAVE_API pave_result pave_tiling_source_image(pave_context *context, const pave_tiling *tiling, pave_image **out);

/* Lays images as the tiling says: the exemplars themselves, or companions (normals, heights ...) that belong to them,
 * one for each, of the same size; any channels and type. Pixels are copied bit for bit, but for mode paper, which
 * averages (Eq. 2), rounding to the nearest, halves up. Directions in them are not turned with copies that are: see
 * pave_tiling_apply_normals. */
PAVE_API pave_result pave_tiling_apply(pave_context *context, const pave_tiling *tiling,
                                       const pave_image *const *images, int32_t count, pave_image **out);

/* The same for normal maps: the first two channels of a pixel, x to the right and y (`up` 1: upwards, as in OpenGL and
 * glTF; 0: downwards, as in Direct3D), are turned and mirrored with the copy that it belongs to (`turns`, `flips`).
 * Whole numbers mean -1 .. 1, so that 0 lies in the middle of their range; floats are the components themselves.
 * Errors: PAVE_ERR_ARGUMENT for images of one channel. */
PAVE_API pave_result pave_tiling_apply_normals(pave_context *context, const pave_tiling *tiling,
                                               const pave_image *const *images, int32_t count, int32_t up,
                                               pave_image **out);

/* What a tiling is judged by: a vector, for no figure means anything alone. Noise has no seam, a copy no error. */
typedef struct pave_tiling_measure {
    size_t size;
    double seam_x, seam_y;   /* mean difference across the border / across interior lines; 1: no seam, -1: not asked */
    double worst_line;       /* greatest mean difference of an interior line / the mean one */
    double coherence;        /* RMS difference, of 0..255, of 9x9 patches to the nearest ones in the exemplar, mean */
    double completeness;     /* the same from the exemplar to the result */
    double entropy;          /* how evenly the nearest ones lie over the exemplar's 8x8 cells, 0..1 */
    double overuse;          /* share of the most used cell / even share */
    double histogram;        /* mean difference of the grey levels' quantiles, of 0..255 */
    double sharpness;        /* gradient energy / exemplar's */
    double seam_energy;      /* mean per pixel, of 0..255: both pixels' differences + 1 where sources do not adjoin */
    double seam_share;       /* share of neighbours whose sources do not adjoin */
    double joint_share;      /* share of joint pixels / exemplar's */
    double stone_ratio;      /* mean size of the areas between joints, weighted by size / exemplar's */
    double repeat;           /* highest peak of the autocorrelation beyond 16 px, -1..1 */
    double feature;          /* size of the features that was found, px */
    double seconds;          /* that making the tiling took */
    double sliced;           /* sliced Wasserstein distance of 7x7 patches, of 0..255, to the exemplar's */
    double seam_inner;       /* mean difference across seams of the inside / between other neighbours; 0: no seams */
} pave_tiling_measure;

/* Fills `measure`, whose size must be set. `exemplars` are those that the tiling was made from. The definitions are
 * those of the usual judges: at most 256 x 256 px of the first exemplar and 512 x 512 px of the result.
 * Cost: seconds. */
PAVE_API pave_result pave_tiling_judge(pave_context *context, const pave_tiling *tiling,
                                       const pave_image *const *exemplars, int32_t count,
                                       pave_tiling_measure *measure);

/* Number of candidates for a block (Eq. 3): 11881 for one of 20 x 20 px in an exemplar of 128 x 128; 0 if it does not
 * fit. */
PAVE_API int64_t pave_tiling_fractions(int32_t width, int32_t height, int32_t fraction_width, int32_t fraction_height);

/* A tile of a Wang set: where it lies in the result, and the colours of its edges. */
typedef struct pave_wang_tile { int32_t x, y, north, east, south, west; } pave_wang_tile;

/* The tiles of a set, row by row; none without `wang`. All are of the same size, px. */
PAVE_API int32_t pave_tiling_wang_count(const pave_tiling *tiling);
PAVE_API int32_t pave_tiling_wang_width(const pave_tiling *tiling);
PAVE_API int32_t pave_tiling_wang_height(const pave_tiling *tiling);
PAVE_API const pave_wang_tile *pave_tiling_wang_tiles(const pave_tiling *tiling);

#ifdef __cplusplus
}
#endif

#endif
