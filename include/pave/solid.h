/* Digital stones: volumes of voxels that look in every direction like a flat sample.
 *
 * Source: Schellewald, Perakis and Theoharis 2013, section 4. A measured voxel keeps its value exactly; the others grow
 * around seeds, each drawn from the sample by what surrounds it. What the paper calls early is done anew in the best
 * mode: all three planes through a voxel must fit at once, coarse structure first, and the histograms of the whole are
 * held (docs/papers.md).
 *
 * Axes      x runs along a row, y down the rows of a slice, z from slice to slice; voxel (x, y, z) is value number
 *           (z * height + y) * width + x. Its centre lies at origin + spacing * (x, y, z) in the world.
 * Values    a voxel has the sample's channels and type. Every value occurs in the sample.
 * Same      bytes for any number of threads and in every locale: docs/determinism.md.
 */
#ifndef PAVE_SOLID_H
#define PAVE_SOLID_H

#include <pave/image.h>
#include <pave/stones.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pave_volume pave_volume;
typedef struct pave_mesh pave_mesh;

/* What a voxel is. */
enum {
    PAVE_VOXEL_OUTSIDE = 0,  /* not part of the stone; its value is 0 */
    PAVE_VOXEL_FREE = 1,     /* of the stone, without a value: only in volumes that are handed in */
    PAVE_VOXEL_MEASURED = 2, /* a value that was given */
    PAVE_VOXEL_FILLED = 3    /* a value that was made */
};

typedef struct pave_volume_params {
    size_t size;
    int32_t width, height, depth; /* voxels, from 1 */
    int32_t channels;             /* 1 to 8 */
    int32_t type;                 /* PAVE_U8, PAVE_U16 or PAVE_F32 */
    double spacing;               /* side of a voxel */
    double origin[3];             /* centre of the first voxel */
} pave_volume_params;

#define PAVE_VOLUME_PARAMS_INIT { sizeof(pave_volume_params), 0, 0, 0, 1, PAVE_U8, 1.0, { 0, 0, 0 } }

PAVE_API void pave_volume_params_init(pave_volume_params *params, size_t size);

/* Copies values, channels interleaved, into a new volume. `states`, one byte a voxel, may be NULL: all MEASURED. */
PAVE_API pave_result pave_volume_create(pave_context *context, const pave_volume_params *params, const void *values,
                                        const uint8_t *states, pave_volume **out);
PAVE_API void pave_volume_free(pave_volume **volume);

PAVE_API int32_t pave_volume_width(const pave_volume *volume);
PAVE_API int32_t pave_volume_height(const pave_volume *volume);
PAVE_API int32_t pave_volume_depth(const pave_volume *volume);
PAVE_API int32_t pave_volume_channels(const pave_volume *volume);
PAVE_API int32_t pave_volume_type(const pave_volume *volume);
PAVE_API double pave_volume_spacing(const pave_volume *volume);
PAVE_API const double *pave_volume_origin(const pave_volume *volume);
PAVE_API const void *pave_volume_values(const pave_volume *volume);
PAVE_API const uint8_t *pave_volume_states(const pave_volume *volume);

/* The seed that each voxel was reached from, -1 outside: the Voronoi cells of the paper's Figs. 3 and 4. NULL where no
 * flood was asked for (pave_solid_params.cells, or the modes paper and fast). */
PAVE_API const int32_t *pave_volume_cells(const pave_volume *volume);

/* How the inside of the stone was told: "box", or of a mesh "parity ...", "winding number ..." or "generalised winding
 * number ..."; "" for a volume that was handed in. */
PAVE_API const char *pave_volume_shape(const pave_volume *volume);

/* The value at a point of the world, one float a channel, 0..1 for whole-number types: trilinear among the voxels of
 * the stone, whose weights are made to sum to 1. Beyond the stone the nearest voxel of the 26 around counts; 0 and a
 * return of 0 if there is none, else 1. Any thread. Cost: 8 voxels. */
PAVE_API int32_t pave_volume_sample(const pave_volume *volume, double x, double y, double z, float *out);

/* A cut: the voxels with coordinate `index` on axis 0 (x: image of y by z), 1 (y: x by z) or 2 (z: x by y). */
PAVE_API pave_result pave_volume_slice(pave_context *context, const pave_volume *volume, int32_t axis, int32_t index,
                                       pave_image **out);

/* The same of the cells, each in a grey of its own. */
PAVE_API pave_result pave_volume_slice_cells(pave_context *context, const pave_volume *volume, int32_t axis,
                                             int32_t index, pave_image **out);

/* A surface: triangles of vertices, as indices from 0. Copied. Not a finite coordinate or a triangle without its
 * vertices is PAVE_ERR_ARGUMENT. */
PAVE_API pave_result pave_mesh_create(pave_context *context, const double *vertices, int64_t vertex_count,
                                      const int32_t *triangles, int64_t triangle_count, pave_mesh **out);
PAVE_API void pave_mesh_free(pave_mesh **mesh);
PAVE_API int64_t pave_mesh_vertex_count(const pave_mesh *mesh);
PAVE_API int64_t pave_mesh_triangle_count(const pave_mesh *mesh);
PAVE_API const double *pave_mesh_vertices(const pave_mesh *mesh);
PAVE_API const int32_t *pave_mesh_triangles(const pave_mesh *mesh);

enum { PAVE_SOLID_PAPER = 0, PAVE_SOLID_BEST = 1, PAVE_SOLID_FAST = 2 };

typedef struct pave_solid_params {
    size_t size;
    int32_t mode;         /* PAVE_SOLID_ */
    int32_t width;        /* of the box, voxels; a mesh or a partial volume say it themselves */
    int32_t height;
    int32_t depth;        /* 1: a flat picture (Fig. 2), by the same code, in paper mode */
    int32_t resolution;   /* with a mesh: voxels along its longest side */
    int32_t seeds;        /* random seeds; only if nothing is measured */
    uint64_t seed;        /* another seed, another stone */
    int32_t window;       /* side of the neighbourhood, odd; paper mode 5 */
    double epsilon;       /* candidates within 1 + epsilon of the best are drawn from */
    double sigma;         /* of the window's Gaussian in paper mode, in windows; 1/6.4 is customary */
    int32_t levels;       /* of best mode's pyramid; 0: by the size of the sample's features */
    int32_t periodic;     /* 1: opposite sides fit; boxes only */
    int32_t match;        /* 1: the sample's histogram is met to the voxel, of one channel; 0: as it comes */
    int32_t cells;        /* 1: keep the cells of the flood in every mode */
} pave_solid_params;

#define PAVE_SOLID_PARAMS_INIT \
    { sizeof(pave_solid_params), PAVE_SOLID_BEST, 64, 64, 64, 128, 19, 1, 5, 0.1, 0.15625, 0, 0, 1, 0 }

PAVE_API void pave_solid_params_init(pave_solid_params *params, size_t size);

/* What a stone is made from. Zero what is not there. */
typedef struct pave_solid_input {
    size_t size;
    const pave_image *exemplar[3]; /* by the normal of the plane they are seen in: x, y, z; [1] and [2] NULL: one sample
                                      for all, in every direction */
    const pave_mesh *mesh;         /* the stone's shape; NULL: a box */
    const pave_volume *partial;    /* MEASURED voxels are kept, FREE ones filled; its size holds */
    int64_t point_count;
    const double *points;          /* x, y, z in the world, each */
    const double *point_values;    /* channels each, as stored in the sample: 0..255 for PAVE_U8, and so on */
    int32_t slice_count;
    const pave_image *const *slices; /* laid on voxel planes from their corner on */
    const int32_t *slice_places;     /* axis, index, each */
} pave_solid_input;

#define PAVE_SOLID_INPUT_INIT \
    { sizeof(pave_solid_input), { NULL, NULL, NULL }, NULL, NULL, 0, NULL, NULL, 0, NULL, NULL }

PAVE_API void pave_solid_input_init(pave_solid_input *input, size_t size);

/* Makes a stone. Memory: docs/formats.md. Cost: about 30 us a voxel and thread, whatever the size of the sample.
 * Errors: PAVE_ERR_ARGUMENT for measurements outside the stone or contradicting each other (the first is named), a
 * sample smaller than its window; PAVE_ERR_FORMAT for a mesh without inside; PAVE_ERR_LIMIT beyond max_bytes. */
PAVE_API pave_result pave_solid_create(pave_context *context, const pave_solid_input *input,
                                       const pave_solid_params *params, pave_volume **out);

/* What a stone is judged by, against its sample. One channel; vectors by their mean. */
typedef struct pave_solid_measure {
    size_t size;
    double emd;            /* histogram distance, grey levels of 255 */
    double phase;          /* difference of the share above the sample's Otsu threshold; of a sample with at most 8
                              values the greatest difference of any value's share */
    double s2_rmse;        /* two-point correlation of that phase, lags 1..12, against the mean of the sample's axes */
    double cov_error;      /* the same of (S2 - phi^2) / (phi - phi^2): structure without drift */
    double isotropy;       /* greatest difference of S2 between two axes, lags 1..8 */
    double correlation[3]; /* between neighbours along x, y, z */
    double correlation_reference;
    double sharpness;      /* mean difference of neighbours / the sample's: under 1 blurred, over 1 noisy */
    double speckle;        /* share of voxels whose six neighbours are all of the other phase */
    double slice_distance; /* sliced Wasserstein distance of 5 x 5 patches, worst axis, grey levels; NaN with a mesh */
    double walls;          /* difference across the flood's cell walls / inside cells: 1 is invisible; NaN without */
    double measured;       /* difference of measured voxels from their neighbours / that of all; NaN without */
    int64_t voxels, measured_voxels;
    double use;              /* entropy of how often each place of the sample was taken / the greatest possible: 1 is
                                evenly; of a volume that was handed in, NaN */
    double constraint_error; /* greatest difference from what was measured, as stored: 0; NaN as above */
} pave_solid_measure;

/* Fills `measure`, whose size must be set. */
PAVE_API pave_result pave_solid_measure_against(pave_context *context, const pave_image *exemplar,
                                                const pave_volume *volume, pave_solid_measure *measure);

#ifdef __cplusplus
}
#endif

#endif
