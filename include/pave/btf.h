/* Bidirectional texture functions: how a flat piece of material looks from all views under all lights.
 * Sources: den Brok, Steinhausen, Hullin and Klein 2014, "Patch-based sparse reconstruction of material BTFs", 2 and
 * 3.2; Steinhausen, den Brok, Hullin and Klein 2014, "Acquiring bidirectional texture functions for large-scale
 * material samples", 3.
 *
 * A BTF holds one sample for each texel, view, light and channel: radiance towards the view under a directional light
 * of unit irradiance (a white diffuse plane has 1/pi), times the cosine of the light's inclination if `cosine` is set.
 * The samples of a texel, [view][light][channel], are its apparent BRDF (ABRDF); those of a pair of view and light,
 * [y][x][channel], are a texture. Texel (0, 0) is at the top left; x grows to the right and y down. Azimuth 0 is
 * towards the right and 90 degrees towards the top. */
#ifndef PAVE_BTF_H
#define PAVE_BTF_H

#include <pave/image.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pave_btf pave_btf;

/* A direction above the surface, in radians: inclination from the normal, and azimuth. */
typedef struct pave_direction {
    float theta, phi;
} pave_direction;

/* Directions that measuring devices use, for views and lights alike. */
enum {
    PAVE_DIRECTIONS_UBO81 = 0,  /* the 81 of UBO2003, ATRIUM and UTIA: rings every 15 degrees */
    PAVE_DIRECTIONS_DOME151 = 1 /* the 151 of Bonn's Dome I (UBO2014) */
};

/* Writes at most `room` directions of a set and returns how many it has; 0 for an unknown set. Any thread. */
PAVE_API int32_t pave_directions(int32_t set, pave_direction *out, int32_t room);

typedef struct pave_btf_params {
    size_t size;
    int32_t width;    /* texels */
    int32_t height;   /* texels */
    int32_t channels; /* 1 to 32 */
    int32_t type;     /* PAVE_F16 or PAVE_F32 */
    int32_t views;
    int32_t lights;
    const pave_direction *view_directions;  /* `views` of them; copied */
    const pave_direction *light_directions; /* `lights` of them; copied */
    int32_t cosine;        /* 1: samples hold the cosine of the light's inclination as a factor */
    double pixels_per_mm;  /* 0: not known */
    const char *names;     /* channel names, "R,G,B"; NULL: R, G, B for three, Y for one, otherwise 0, 1, 2 ... */
} pave_btf_params;

#define PAVE_BTF_PARAMS_INIT { sizeof(pave_btf_params), 0, 0, 3, PAVE_F16, 0, 0, NULL, NULL, 1, 0, NULL }

PAVE_API void pave_btf_params_init(pave_btf_params *params, size_t size);

/* Copies `samples`, [y][x][view][light][channel] without padding, into a new BTF. No two views, and no two lights, may
 * have the same direction; all lie within 90 degrees of the normal. NULL samples give zeros. */
PAVE_API pave_result pave_btf_create(pave_context *context, const pave_btf_params *params, const void *samples,
                                     pave_btf **out);
PAVE_API void pave_btf_free(pave_btf **btf);

PAVE_API int32_t pave_btf_width(const pave_btf *btf);
PAVE_API int32_t pave_btf_height(const pave_btf *btf);
PAVE_API int32_t pave_btf_channels(const pave_btf *btf);
PAVE_API const char *pave_btf_channel_name(const pave_btf *btf, int32_t channel);
PAVE_API int32_t pave_btf_views(const pave_btf *btf);
PAVE_API int32_t pave_btf_lights(const pave_btf *btf);
PAVE_API const pave_direction *pave_btf_view_directions(const pave_btf *btf);
PAVE_API const pave_direction *pave_btf_light_directions(const pave_btf *btf);
PAVE_API int32_t pave_btf_cosine(const pave_btf *btf);
PAVE_API double pave_btf_pixels_per_mm(const pave_btf *btf);

/* 1 for pairs of view and light that were not measured, [view][light]: their samples are 0. NULL: none is missing. */
PAVE_API const uint8_t *pave_btf_missing(const pave_btf *btf);

/* Components of a channel's factors, 0 where samples are held as they are. */
PAVE_API int32_t pave_btf_components(const pave_btf *btf, int32_t channel);

/* Of a BTF whose channels are factored one by one: a channel's eigen-ABRDFs, [view][light][component], and how much of
 * each a texel has, [y][x][component]; their products are what the colour model makes samples of (log Y, U/Y, V/Y).
 * NULL otherwise. They are the BTF's own. */
PAVE_API const float *pave_btf_eigenvectors(const pave_btf *btf, int32_t channel);
PAVE_API const float *pave_btf_coefficients(const pave_btf *btf, int32_t channel);

/* Samples as floats, decoded if the BTF is factored. `out` is the caller's. Any thread.
 * Cost: linear in what is written, times the components of a factored BTF. */
PAVE_API void pave_btf_abrdf(const pave_btf *btf, int32_t x, int32_t y, float *out);
PAVE_API void pave_btf_texture(const pave_btf *btf, int32_t view, int32_t light, float *out);

/* The three directions around `direction` and their weights, which are not negative and sum to 1: barycentric in a
 * Delaunay triangulation of the parabolic plane (x, y) / (1 + z). Directions below the lowest ring take its nearest.
 * `of_lights` chooses the set. Any thread. */
PAVE_API void pave_btf_weights(const pave_btf *btf, int32_t of_lights, pave_direction direction, int32_t index[3],
                               double weight[3]);

/* One texel seen from any view under any light: the mean of nine samples by their weights. Below the lowest ring of
 * lights samples that hold the cosine fade with it. `out` has a float for each channel. Any thread. */
PAVE_API void pave_btf_lookup(const pave_btf *btf, int32_t x, int32_t y, pave_direction view, pave_direction light,
                              float *out);

/* ---- An honest generator: a relief of stone, ray-cast ---- */

/* Classes of stone-like surface, rising in depth and gloss, and two controls. */
enum {
    PAVE_BTF_FLAT = 0,      /* one material on a plane: every ABRDF is the BRDF itself */
    PAVE_BTF_MINERALS = 1,  /* a plane of four materials */
    PAVE_BTF_SAWN = 2,      /* sawn stone: a shallow fractal */
    PAVE_BTF_POLISHED = 3,  /* polished granite: almost a plane, glossy */
    PAVE_BTF_TILE = 4,      /* worn plates with joints */
    PAVE_BTF_GROOVED = 5,   /* grooves like those of wood */
    PAVE_BTF_BRUSHED = 6,   /* brushed metal-like, anisotropic gloss */
    PAVE_BTF_CONCRETE = 7,  /* fine relief with pores */
    PAVE_BTF_COBBLE = 8,    /* rounded cobbles with deep joints */
    PAVE_BTF_ASPHALT = 9,   /* small aggregate in dark binder */
    PAVE_BTF_GRAVEL = 10,   /* loose coarse aggregate */
    PAVE_BTF_CLASSES = 11
};

typedef struct pave_btf_synthesis_params {
    size_t size;
    int32_t class_of;   /* PAVE_BTF_FLAT ... */
    int32_t texels;     /* a side */
    int32_t directions; /* PAVE_DIRECTIONS_, of views and lights */
    uint64_t seed;      /* another seed, another material of the class */
    int32_t samples;    /* rays for each texel and view */
    int32_t bounces;    /* of diffuse light between parts of the relief; 0: none */
    int32_t rays;       /* for each point of the relief, to gather what bounces */
    int32_t shadows;    /* 0: light passes through the relief */
    double relief;      /* the relief's heights are multiplied by this; 0: a plane */
    int32_t stored;     /* 1: the samples are held in memory. 0: they are made anew whenever they are read, which is
                           how a BTF larger than memory is written to a file */
    int32_t window[4];  /* x, y, width, height: only these texels of the material; zeros: all */
} pave_btf_synthesis_params;

#define PAVE_BTF_SYNTHESIS_PARAMS_INIT \
    { sizeof(pave_btf_synthesis_params), PAVE_BTF_GRAVEL, 64, PAVE_DIRECTIONS_UBO81, 1, 4, 3, 32, 1, 1.0, 1, \
      { 0, 0, 0, 0 } }

PAVE_API void pave_btf_synthesis_params_init(pave_btf_synthesis_params *params, size_t size);

/* Makes the BTF of a periodic height field with materials that vary from place to place (Lambert and GGX): masking,
 * parallax, shadows and diffuse interreflection are ray-cast. The samples hold the cosine. The same bytes for every
 * number of threads. Memory: 2 bytes for each sample; time: about 10 ns for each sample and ray. */
PAVE_API pave_result pave_btf_synthesize(pave_context *context, const pave_btf_synthesis_params *params,
                                         pave_btf **out);

/* ---- Compression ---- */

/* What is factored (den Brok 2014, 3.1): the logarithm takes the range out of highlights. Samples below 0 count as
 * 0, and 1e-5 is added before a logarithm or a division. */
enum {
    PAVE_BTF_COLOUR_AUTO = 0,    /* log Y, U/Y, V/Y for R, G and B; the logarithm of each channel for others */
    PAVE_BTF_COLOUR_LOG_YUV = 1, /* log Y, U/Y, V/Y */
    PAVE_BTF_COLOUR_LOG = 2,     /* the logarithm of each channel */
    PAVE_BTF_COLOUR_PLAIN = 3    /* the samples themselves */
};

typedef struct pave_btf_compress_params {
    size_t size;
    int32_t components; /* for each channel, or just for the first of log Y, U/Y, V/Y; */
    int32_t second;     /* for the second of these; 0: half as many */
    int32_t third;
    double error;       /* greatest relative error of each channel's matrix in the Frobenius norm; then as many
                           components as it takes, at most `components`; 0: just `components` */
    int32_t colour;     /* PAVE_BTF_COLOUR_ */
    int32_t joint;      /* 1: all channels are factored as one matrix, as FMF files want it */
    int32_t passes;     /* over the data; each brings the error nearer to that of the exact SVD */
    int32_t type;       /* PAVE_F16 or PAVE_F32: of the factors */
} pave_btf_compress_params;

#define PAVE_BTF_COMPRESS_PARAMS_INIT \
    { sizeof(pave_btf_compress_params), 64, 0, 0, 0, PAVE_BTF_COLOUR_AUTO, 0, 3, PAVE_F16 }

PAVE_API void pave_btf_compress_params_init(pave_btf_compress_params *params, size_t size);

/* Factors a BTF: each channel's matrix [view][light] x [texel] is replaced by its truncated singular value
 * decomposition, found by randomised subspace iteration (Halko, Martinsson and Tropp 2011) over blocks of texels, so
 * that the samples may be larger than memory. The same bytes for every number of threads; another processor may round
 * otherwise. Needs OpenBLAS when it runs (PAVE_ERR_UNSUPPORTED without). PAVE_ERR_FORMAT names the first texel with
 * samples that are infinite or no numbers. */
PAVE_API pave_result pave_btf_compress(pave_context *context, const pave_btf *btf,
                                       const pave_btf_compress_params *params, pave_btf **out);

/* One basis for several materials (den Brok 2014, 4.1), which are factored alike and have the same width and
 * directions: left factors and singular values of all their matrices side by side, at most `components` for each
 * channel, found from the factors alone and exactly so up to what they left out. The result is a BTF in which the
 * materials lie below each other. Needs OpenBLAS when it runs.
 * Memory: rows times the components of all together, and the square of these. */
PAVE_API pave_result pave_btf_merge(pave_context *context, const pave_btf *const *btfs, int32_t count,
                                    int32_t components, pave_btf **out);

/* Of a BTF that pave_btf_compress or pave_btf_merge made: the relative error of a channel's matrix in the Frobenius
 * norm (of a merged one: beyond the errors of what was merged). Otherwise 0. */
PAVE_API double pave_btf_error(const pave_btf *btf, int32_t channel);

/* ---- Whole materials from a few samples (den Brok et al. 2014) ---- */

/* What is known of a class of materials: a basis of their ABRDFs (eigen-ABRDFs) and one of the ABRDFs of small patches
 * of texels (eigen-ABTFs), how much materials have of each vector, and how far that may be trusted. Immutable; any
 * thread may read it. */
typedef struct pave_btf_model pave_btf_model;

typedef struct pave_btf_model_params {
    size_t size;
    int32_t patch;      /* side of a patch of texels, odd; 1: no patches */
    int32_t components; /* eigen-ABTFs of each channel, at most */
    int32_t abrdfs;     /* eigen-ABRDFs of each channel, at most */
    int32_t material;   /* components kept of each material's first channel; half as many of the others */
    int32_t stride;     /* texels from one training patch to the next; 0: `patch`, so that none overlap */
    int32_t colour;     /* PAVE_BTF_COLOUR_ */
    double epsilon;     /* added to samples before a logarithm or a division. A white diffuse plane sends 0.318 */
    int32_t symmetric;  /* 1: mirrored and turned copies of the materials belong to the class too, as far as the
                           directions allow */
    int32_t validate;   /* 1: three materials are held out in turn, to find how best to reconstruct */
    int32_t passes;     /* over each material's samples */
} pave_btf_model_params;

#define PAVE_BTF_MODEL_PARAMS_INIT \
    { sizeof(pave_btf_model_params), 3, 2048, 1024, 200, 0, PAVE_BTF_COLOUR_AUTO, 0.00032, 1, 1, 3 }

PAVE_API void pave_btf_model_params_init(pave_btf_model_params *params, size_t size);

/* Fits a model to materials that have been measured completely and have the same channels and directions (4.1): each
 * material's own bases first, by passes over its samples, then all merged. From each logarithm that of a grey diffuse
 * plane is taken first, so that the cosine of the light is no news. Copies (mirrors, half a turn) are exact and cost
 * nothing: bases fall into blocks of even and odd functions. The same bytes for every number of threads; another
 * processor may round otherwise. Needs OpenBLAS when it runs.
 * Memory: views x lights x patch^2 floats, times `material` x count + `components`, for the first channel and half of
 * that for others. PAVE_ERR_ARGUMENT: they differ, or one has missing pairs or is black. */
PAVE_API pave_result pave_btf_model_create(pave_context *context, const pave_btf *const *btfs, int32_t count,
                                           const pave_btf_model_params *params, pave_btf_model **out);
PAVE_API void pave_btf_model_free(pave_btf_model **model);

/* Shares materials out to so many classes of alike ones, each to be given to a model of its own: k-means on their
 * models (roots of the covariances of the first channel's ABRDFs, made one in length), the best of all starts from
 * seeds that lie farthest apart.
 * `labels` gets the class of each, from 0; `within` (NULL: not wanted) what materials differ from the mean of their
 * class, over what they differ from that of all, 0 .. 1. Needs OpenBLAS when it runs. */
PAVE_API pave_result pave_btf_cluster(pave_context *context, const pave_btf *const *btfs, int32_t count,
                                      int32_t classes, const pave_btf_model_params *params, int32_t *labels,
                                      double *within);

PAVE_API int32_t pave_btf_model_materials(const pave_btf_model *model);
PAVE_API int32_t pave_btf_model_patch(const pave_btf_model *model);
PAVE_API int32_t pave_btf_model_channels(const pave_btf_model *model);
PAVE_API int32_t pave_btf_model_views(const pave_btf_model *model);
PAVE_API int32_t pave_btf_model_lights(const pave_btf_model *model);

/* Copies that the symmetry of the directions made of each material: 1, 2 or 4. */
PAVE_API int32_t pave_btf_model_copies(const pave_btf_model *model);

/* Components of a channel (of log Y, U/Y, V/Y), and the root mean square of each one's coefficients, falling. */
PAVE_API int32_t pave_btf_model_components(const pave_btf_model *model, int32_t channel, int32_t of_patches);
PAVE_API const float *pave_btf_model_deviations(const pave_btf_model *model, int32_t channel, int32_t of_patches);

/* One vector: [y of the patch][x][view][light]. `out` is the caller's. */
PAVE_API void pave_btf_model_vector(const pave_btf_model *model, int32_t channel, int32_t of_patches, int32_t index,
                                    float *out);

/* Which pairs of view and light to measure, and in which order. Immutable; any thread may read it. */
typedef struct pave_btf_plan pave_btf_plan;

enum {
    PAVE_BTF_PLAN_GREEDY = 0,   /* each pair is the one that leaves least unknown, as the model has it; so the first so
                                   many of a plan are the plan for so many */
    PAVE_BTF_PLAN_SWAP = 1,     /* den Brok 2014, Algorithm 1: chance, as long as the condition number falls */
    PAVE_BTF_PLAN_PARABOLIC = 2 /* 4.2: the same map of directions for views and lights: 7 x 7 cells, of which 37 lie
                                   in the disc, give 1369 pairs */
};

typedef struct pave_btf_plan_params {
    size_t size;
    int32_t method;   /* PAVE_BTF_PLAN_ */
    int32_t samples;  /* pairs; of a map, at most, and of a dome too */
    int32_t abrdfs;   /* swap: so many eigen-ABRDFs are to be found; 0: all */
    int32_t patches;  /* swap: 1, the ABTFs' system is meant, and not the ABRDFs' */
    int32_t components; /* swap: alike, of the eigen-ABTFs */
    int32_t steps;    /* swap: tries */
    uint64_t seed;    /* swap: of chance */
    int32_t dome;     /* greedy: 1, whole views times lights, as a dome of cameras and lamps takes them */
    double shot_cost; /* greedy, dome: what a lamp costs besides its pictures, in pictures */
    double noise;     /* greedy: standard deviation of a measured value; 0: what the model found */
} pave_btf_plan_params;

#define PAVE_BTF_PLAN_PARAMS_INIT \
    { sizeof(pave_btf_plan_params), PAVE_BTF_PLAN_GREEDY, 1369, 0, 1, 0, 1000, 1, 0, 4, 0 }

PAVE_API void pave_btf_plan_params_init(pave_btf_plan_params *params, size_t size);

/* Plans a measurement for a model. Greedy plans are decided by additions and multiplications in a fixed order: the same
 * for the same model on every machine. Cost of a greedy one: samples x views x lights x eigen-ABRDFs; of a swap:
 * a symmetric eigenvalue problem a step, which needs OpenBLAS. */
PAVE_API pave_result pave_btf_plan_create(pave_context *context, const pave_btf_model *model,
                                          const pave_btf_plan_params *params, pave_btf_plan **out);
PAVE_API void pave_btf_plan_free(pave_btf_plan **plan);

/* A plan by hand: `count` pairs, by the numbers of a BTF's views and lights, in their order. */
PAVE_API pave_result pave_btf_plan_of_pairs(pave_context *context, const pave_btf *btf, const int32_t *views,
                                            const int32_t *lights, int32_t count, pave_btf_plan **out);

/* The pairs in their order, as numbers of the model's views and lights, and the root mean square error that is expected
 * in the first channel once so many are measured (0: not known). */
PAVE_API int32_t pave_btf_plan_samples(const pave_btf_plan *plan);
PAVE_API const int32_t *pave_btf_plan_views(const pave_btf_plan *plan);
PAVE_API const int32_t *pave_btf_plan_lights(const pave_btf_plan *plan);
PAVE_API const double *pave_btf_plan_expected(const pave_btf_plan *plan);

/* Of a swap: the condition number before and after; otherwise 0. */
PAVE_API void pave_btf_plan_condition(const pave_btf_plan *plan, double *before, double *after);

enum {
    PAVE_BTF_BEST = 0,   /* with the model's prior: ABTFs first, and then ABRDFs of what they leave */
    PAVE_BTF_PAPER = 1,  /* the pseudo-inverse (Eq. 3) */
    PAVE_BTF_PROJECT = 2 /* a complete BTF onto the basis: the least error that the basis allows */
};

enum { PAVE_BTF_BOTH = 0, PAVE_BTF_ABRDFS = 1, PAVE_BTF_ABTFS = 2 };

typedef struct pave_btf_reconstruct_params {
    size_t size;
    int32_t mode;       /* PAVE_BTF_BEST ... */
    int32_t basis;      /* PAVE_BTF_BOTH (by the text, ABTFs), PAVE_BTF_ABRDFS or PAVE_BTF_ABTFS */
    int32_t components; /* eigen-ABTFs of each channel; 0: all */
    int32_t abrdfs;     /* eigen-ABRDFs of each channel; 0: all */
    int32_t samples;    /* of the plan, the first; 0: all */
    double cut;         /* paper: singular values below this share of the greatest do not count */
    double noise;       /* best: standard deviation of measured values besides what the model expects; in logarithms */
    int32_t type;       /* PAVE_F16 or PAVE_F32: of the samples */
} pave_btf_reconstruct_params;

#define PAVE_BTF_RECONSTRUCT_PARAMS_INIT \
    { sizeof(pave_btf_reconstruct_params), PAVE_BTF_BEST, PAVE_BTF_BOTH, 0, 0, 0, 1e-5, 0, PAVE_F16 }

PAVE_API void pave_btf_reconstruct_params_init(pave_btf_reconstruct_params *params, size_t size);

/* Reconstructs all pairs of view and light from some. `sparse` has the model's channels and some of its directions (the
 * nearest within a degree is meant); pairs that it marks as missing, and with a plan (NULL: none) those that are not in
 * it, are not looked at. Samples that are no numbers count as not measured. Patches lie at every texel and are blended
 * evenly (4.1.2). What comes out is cut to the range of what the model was made of.
 * `errors` (NULL: not wanted; best mode only) becomes a picture of what root mean square error the model expects in the
 * first channel of each texel, from how well it explains what was measured there.
 * PAVE_ERR_ARGUMENT: the model is of other directions or channels; nothing was measured, or nothing but black; in paper
 * mode fewer samples than unknowns, with the number that is needed.
 * Memory: all samples of the result; coefficients of every texel and patch. Needs OpenBLAS when it runs. */
PAVE_API pave_result pave_btf_reconstruct(pave_context *context, const pave_btf_model *model, const pave_btf *sparse,
                                          const pave_btf_plan *plan, const pave_btf_reconstruct_params *params,
                                          pave_btf **out, pave_image **errors);

/* ---- Whole materials from a small region and a few photographs (Steinhausen et al. 2014) ---- */

enum { PAVE_BTF_AIM_ERROR = 0, PAVE_BTF_AIM_LOOK = 1 };

typedef struct pave_btf_enlarge_params {
    size_t size;
    int32_t mode;          /* PAVE_BTF_BEST or PAVE_BTF_PAPER */
    int32_t aim;           /* best: PAVE_BTF_AIM_ERROR, or PAVE_BTF_AIM_LOOK */
    int32_t stage;         /* paper: 1, Texture Optimization alone; 2, statistics imposed once; 3, Algorithm 1 */
    int32_t components;    /* eigen-ABRDFs of the sample's luminance, or of each channel */
    int32_t chroma;        /* of U/Y and V/Y each; 0: half as many */
    int32_t colour;        /* PAVE_BTF_COLOUR_ */
    double epsilon;        /* darker samples count as this before logarithms and divisions. White is 0.318 */
    int32_t neighbourhood; /* side of a window of Texture Optimization, texels */
    int32_t levels;        /* paper: 3 are 1/4, 1/2 and 1 */
    double balance;        /* paper: what all photographs together weigh over what the texture does. Lambda (Eq. 3) is
                              this times views x lights over the number of photographs: 20000 for one of 22801 */
    double share;          /* paper: alpha / (alpha + beta) (Eq. 4) */
    int32_t samples;       /* of the plan, the first so many; 0: all */
    int32_t x, y;          /* where the sample's top left texel lies in the whole; -1: it is from elsewhere */
    int32_t passes;        /* over the sample, to factor it */
    int32_t type;          /* PAVE_F16 or PAVE_F32: of the factors */
    int32_t symmetric;     /* best: 1: the sample turned and mirrored is learned from, too, by all multiples of 30
                              degrees that its directions keep; parts that are held out tell whether that helps */
} pave_btf_enlarge_params;

#define PAVE_BTF_ENLARGE_PARAMS_INIT \
    { sizeof(pave_btf_enlarge_params), PAVE_BTF_BEST, PAVE_BTF_AIM_ERROR, 3, 128, 0, PAVE_BTF_COLOUR_AUTO, 0.00032, 8, \
      3, 0.877, 0.5, 0, -1, -1, 3, PAVE_F16, 1 }

PAVE_API void pave_btf_enlarge_params_init(pave_btf_enlarge_params *params, size_t size);

/* How it came out, as far as the truth is not needed for that. */
typedef struct pave_btf_enlargement {
    size_t size; /* set by the caller */
    int32_t photographs, rounds; /* rounds: of Texture Optimization and of Algorithm 1 */
    double explained;  /* best: the share of what the sample varies by that the photographs explain: each quarter of it
                          predicted from the others; */
    double expected;   /* and the root mean square error of a value that is to be expected of the whole */
    double least;      /* root mean square of what the components leave of the sample */
    double missed;     /* root mean square of what the photographs show and the result does not */
    double sharpness;  /* mean square difference of neighbours over the sample's: below 1 is blurred */
    double spectrum;   /* root mean square logarithm of the power of octaves' slopes over the sample's */
    double statistics; /* relative distance of Portilla and Simoncelli's statistics from the sample's. These three are 0
                          if the sample is plain */
} pave_btf_enlargement;

/* Makes the BTF of a large piece of material from a complete one of a small region, `sample`, and photographs of all of
 * it: `photographs` is a BTF of the whole with some pairs of the sample's directions (the nearest within a degree is
 * meant), the others marked as missing or, with a plan (NULL: none), not in it; `mean` is the picture from the top view
 * under even light, the mean over all lights (Eq. 10; linear values are meant as they are, others as sRGB). One of both
 * may be NULL.
 * Best mode predicts coefficients from what the photographs show around a texel, by kernel ridge regression learned on
 * the sample and its turned and mirrored copies, and mixes them with windows of the sample put together anew (Texture
 * Optimization at the finest level, from windows that show the same), as far as that served where parts of the sample
 * were made from the rest. That is the least error, and smooth. To look at, each octave of each coefficient gets the
 * sample's power, or that of the whole, as far as the photographs tell how they differ. Paper mode is Algorithm 1:
 * Texture Optimization, then in turns the sample's statistics (Portilla and Simoncelli) and the photographs, forced
 * (Eqs. 4 to 6).
 * The same bytes for every number of threads; another processor may round otherwise. Needs OpenBLAS when it runs.
 * PAVE_ERR_ARGUMENT: the sample is too small or not complete; photographs of other sizes, directions or channels, black
 * ones, and such as contradict the sample; the message names them.
 * Memory: factors of the sample, (components + chroma x 2) + 3 x photographs floats for each texel of the whole and the
 * sample, and about 1 GiB. `report` may be NULL. */
PAVE_API pave_result pave_btf_enlarge(pave_context *context, const pave_btf *sample, const pave_btf *photographs,
                                      const pave_btf_plan *plan, const pave_image *mean,
                                      const pave_btf_enlarge_params *params, pave_btf **out,
                                      pave_btf_enlargement *report);

/* ---- How sound it is, and how far two are apart ---- */

typedef struct pave_btf_texels_params {
    size_t size;
    int32_t texels; /* looked at, spread evenly from the first to the last; 0: all */
} pave_btf_texels_params;

#define PAVE_BTF_TEXELS_PARAMS_INIT { sizeof(pave_btf_texels_params), 256 }

PAVE_API void pave_btf_texels_params_init(pave_btf_texels_params *params, size_t size);

/* What the samples of the texels looked at have to say; pairs that are missing are left out. */
typedef struct pave_btf_diagnosis {
    size_t size;                 /* set by the caller */
    int32_t view_set, light_set; /* PAVE_DIRECTIONS_ if they are one, in its order; -1 if not */
    int64_t texels, samples;     /* looked at */
    int64_t missing;             /* pairs of view and light */
    int64_t not_finite, negative;
    int64_t saturated;           /* samples that equal the greatest of their channel */
    double least, greatest, mean;
    double reciprocity; /* of the mean over texels and channels, without the light's cosine: the rms difference of
                           pairs with view and light exchanged, over the rms. NAN if no light is where a view is */
    double albedo;      /* mean over texels, views and channels: what leaves of even light from the hemisphere, by
                           the share of it that lies nearest to each light; white and diffuse is exactly 1 */
    double albedo_over; /* the share of these albedos that are above 1 */
} pave_btf_diagnosis;

/* Cost: linear in the samples looked at, times the components of a factored BTF. */
PAVE_API pave_result pave_btf_diagnose(pave_context *context, const pave_btf *btf,
                                       const pave_btf_texels_params *params, pave_btf_diagnosis *out);

/* The albedo of each texel, mean over views, as a picture of the BTF's channels. */
PAVE_API pave_result pave_btf_albedo(pave_context *context, const pave_btf *btf, pave_image **out);

typedef struct pave_btf_measure_params {
    size_t size;
    int32_t texels; /* looked at, spread evenly from the first to the last; 0: all */
    double epsilon; /* added to samples before a logarithm. Percentages hang on it, and on white being 0.318 */
} pave_btf_measure_params;

#define PAVE_BTF_MEASURE_PARAMS_INIT { sizeof(pave_btf_measure_params), 256, 1e-5 }

PAVE_API void pave_btf_measure_params_init(pave_btf_measure_params *params, size_t size);

typedef struct pave_btf_difference {
    size_t size; /* set by the caller */
    int64_t texels;
    double rmse;     /* of the ABRDF of a texel, mean over texels (Steinhausen 2014, Eq. 11), on samples as they are */
    double rmse_log; /* the same on log(sample + epsilon) */
    double relative; /* Frobenius norm of the difference over that of b, on log luminance (den Brok 2014, Table 2) */
    double direction_error; /* degrees, the greatest between directions of the same number */
    double whole;     /* what `relative` is over: the root mean square of log luminance of b, */
    double variation; /* and of what texels of b differ from the mean ABRDF of those looked at: */
    double centred;   /* `relative`, over this instead */
    double linear;    /* Frobenius norm of the difference over that of b, on luminance as it is */
} pave_btf_difference;

/* How far `a` is from `b`, which have the same texels, channels and numbers of directions. */
PAVE_API pave_result pave_btf_measure(pave_context *context, const pave_btf *a, const pave_btf *b,
                                      const pave_btf_measure_params *params, pave_btf_difference *out);

/* ---- Looking at it ---- */

enum { PAVE_BTF_ON_PLANE = 0, PAVE_BTF_ON_CYLINDER = 1, PAVE_BTF_ON_SPHERE = 2 };

typedef struct pave_btf_view_params {
    size_t size;
    int32_t shape;      /* PAVE_BTF_ON_PLANE ... */
    int32_t side;       /* of the picture, px */
    double light_theta; /* where the lamp is, degrees: from the axis z, which stands on the plane, */
    double light_phi;   /* and about it from x, which points to the right */
    double view_theta;  /* where the camera is, alike; it is far away and looks at the middle */
    double view_phi;
    double repeats;     /* of the texture across the plane, or half-way around a cylinder or sphere */
    double exposure;    /* powers of two; 0: a white diffuse plane that faces the lamp is 1 */
    int32_t samples;    /* for each side of a pixel */
} pave_btf_view_params;

#define PAVE_BTF_VIEW_PARAMS_INIT { sizeof(pave_btf_view_params), PAVE_BTF_ON_SPHERE, 512, 35, 120, 0, 0, 2, 0, 2 }

PAVE_API void pave_btf_view_params_init(pave_btf_view_params *params, size_t size);

/* A picture of the material on a plane, or on a cylinder or sphere about the upright axis y, in linear light, with an
 * alpha channel. `environment`, a picture of all directions (latitude by longitude, +y up, its middle towards +z),
 * takes the lamp's place; NULL: the lamp. Cost: 36 lookups a sample, and for an environment three for each light. With
 * a Vulkan backend the device adds them up, the same but for rounding: of factored BTFs of up to three channels,
 * PAVE_ERR_UNSUPPORTED for others. */
PAVE_API pave_result pave_btf_view(pave_context *context, const pave_btf *btf, const pave_image *environment,
                                   const pave_btf_view_params *params, pave_image **out);

/* `scale` times the difference of the pictures of two BTFs, without its sign. */
PAVE_API pave_result pave_btf_view_difference(pave_context *context, const pave_btf *a, const pave_btf *b,
                                              const pave_image *environment, const pave_btf_view_params *params,
                                              double scale, pave_image **out);

typedef struct pave_btf_sheet_params {
    size_t size;
    int32_t views;  /* shown, spread over all in their order */
    int32_t lights; /* alike, of a contact sheet */
    int32_t tile;   /* side of each picture, px */
    int32_t x, y;   /* texel of a plot; -1: the mean over texels (at most 1024, spread) */
    double exposure; /* powers of two; 0: a white diffuse plane that faces the lamp is 1 */
} pave_btf_sheet_params;

#define PAVE_BTF_SHEET_PARAMS_INIT { sizeof(pave_btf_sheet_params), 5, 7, 96, -1, -1, 0 }

PAVE_API void pave_btf_sheet_params_init(pave_btf_sheet_params *params, size_t size);

/* Textures side by side: a row for each view shown, a column for each light. */
PAVE_API pave_result pave_btf_contact_sheet(pave_context *context, const pave_btf *btf,
                                            const pave_btf_sheet_params *params, pave_image **out);

/* An ABRDF as discs, one for each view shown: the hemisphere of lights in the parabolic plane, around its pole. */
PAVE_API pave_result pave_btf_plot(pave_context *context, const pave_btf *btf, const pave_btf_sheet_params *params,
                                   pave_image **out);

#ifdef __cplusplus
}
#endif

#endif
