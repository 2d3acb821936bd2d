/* Bidirectional texture functions from inside: samples as they are, or factors. */
#pragma once

#include "base/params.h"

#include <pave/btf.h>

extern const pv_table pv_btf_synthesis_table, pv_btf_compress_table, pv_btf_texels_table,
    pv_btf_measure_table;
extern const pv_table pv_btf_view_table, pv_btf_sheet_table;

enum { PV_BTF_CHANNELS = 32, PV_BTF_NAME = 64, PV_BTF_TEXT = 81 };

/* How factored values become samples; the numbers are those of Bonn's files. */
enum {
    PV_COLOUR_RGB = 0,
    PV_COLOUR_YUV = 1,
    PV_COLOUR_PCA = 3,
    PV_COLOUR_YCOCG = 4,
    PV_COLOUR_SPECTRAL = 6,   /* each channel by itself */
    PV_COLOUR_LOG_Y_UV = 9,   /* log Y, U, V */
    PV_COLOUR_LOGS_YUV = 10,  /* log Y, log U, log V */
    PV_COLOUR_LOG_YUV = 11,   /* log Y, U/Y, V/Y */
    PV_COLOUR_LOG = 12        /* the logarithm of each channel */
};

/* Samples, texel after texel, each [view][light][channel]. They lie in memory or in a file that is mapped; a file may
 * have a gap after every `chunk` texels. */
typedef struct pv_samples {
    const uint8_t *first;
    size_t texel_bytes, gap;
    int32_t chunk;
    const int32_t *slots; /* where each texel lies, -1: nowhere; NULL: in order */
    void *block;          /* freed with the BTF */
    void *map;
    size_t map_bytes;
} pv_samples;

/* A channel's matrix, rows [view][light], columns [y][x]: left * right', where `right` holds the singular values. All
 * channels as one matrix have the rows [view][light][channel]. */
typedef struct pv_factors {
    int32_t components;
    float *left, *right, *singular;
    double error;
} pv_factors;

/* Delaunay triangles of directions in the parabolic plane. Corners beyond the horizon stand for a real direction. */
typedef struct pv_directions {
    int32_t count, corners, triangles;
    pave_direction *direction;
    int32_t (*corner)[2]; /* in the parabolic plane, 2^-24 */
    int32_t *stands_for;
    int32_t (*triangle)[3];
} pv_directions;

struct pv_scene;

struct pave_btf {
    int32_t width, height, channels, type;
    pv_directions views, lights;
    int32_t cosine;
    double pixels_per_mm;
    float rgb_scale[3];
    char names[PV_BTF_CHANNELS][PV_BTF_NAME];
    char setup[PV_BTF_TEXT], sensor[PV_BTF_TEXT], source[PV_BTF_TEXT]; /* what measured it */
    char *notes;                                                       /* XML of the measurement; NULL: none */
    uint8_t *missing;
    pv_samples samples;
    int32_t colour;      /* PV_COLOUR_: of the factors */
    float colour_space[12]; /* of PV_COLOUR_PCA: mean, and rows of the transform */
    int32_t factor_type; /* PAVE_F16 or PAVE_F32: how precise the factors are */
    int32_t joint;       /* all channels are one matrix */
    pv_factors *factors; /* pv_btf_planes of them; NULL: the samples are there */
    struct pv_scene *scene; /* from which samples are made when they are read; NULL: none */
};

static inline int64_t pv_btf_texels(const pave_btf *btf)
{
    return (int64_t)btf->width * btf->height;
}

/* Samples of a texel. */
static inline int64_t pv_btf_length(const pave_btf *btf)
{
    return (int64_t)btf->views.count * btf->lights.count * btf->channels;
}

/* Matrices that a factored BTF has, and the rows of each. */
static inline int32_t pv_btf_planes(const pave_btf *btf)
{
    return btf->joint ? 1 : btf->channels;
}

static inline int64_t pv_btf_rows(const pave_btf *btf)
{
    return (int64_t)btf->views.count * btf->lights.count * (btf->joint ? btf->channels : 1);
}

/* A BTF with neither samples nor factors; everything is checked but the memory that samples would take. */
pave_result pv_btf_new(pave_context *context, const pave_btf_params *params, pave_btf **out);

/* Bytes that its samples take, room for them in memory, not yet written, or wherever there is some. */
double pv_btf_sample_bytes(const pave_btf *btf);
pave_result pv_btf_allocate_samples(pave_context *context, pave_btf *btf);
void pv_btf_place_samples(pave_btf *btf, void *at);

/* Room for the factors of a matrix. */
pave_result pv_btf_allocate_factors(pave_context *context, pave_btf *btf, int32_t plane, int32_t components);

/* Makes a copy of everything but samples and factors. */
pave_result pv_btf_copy_frame(pave_context *context, const pave_btf *btf, pave_btf **out);

/* Samples `first` .. `first + count - 1` of a texel as floats; only where there are samples. */
void pv_btf_samples(const pave_btf *btf, int64_t texel, int64_t first, int64_t count, float *out);

/* A texel has been read: what is mapped of it no longer counts as this process's memory. Read again, it comes
 * from the system's cache, or from the file. */
void pv_btf_leave(const pave_btf *btf, int64_t texel);

/* All channels of one texel under one pair of view and light. */
void pv_btf_sample(const pave_btf *btf, int64_t texel, int64_t pair, float *out);

/* A texel from one view: [light][channel]. */
void pv_btf_from_view(const pave_btf *btf, int64_t texel, int32_t view, float *out);

/* The samples that a view and a light lie among, and their weights. */
typedef struct pv_mix {
    int64_t pair[9];
    double weight[9];
} pv_mix;

/* Lights below the lowest ring fade towards the horizon, where no light is left. */
void pv_btf_mix(const pave_btf *btf, pave_direction view, pave_direction light, pv_mix *out);

/* Are all of them finite? */
int pv_all_finite(const float *values, int64_t count);

/* Writes some of a texel's samples where room was made for them. */
void pv_btf_put(pave_btf *btf, int64_t texel, int64_t first, int64_t count, const float *values);

/* Directions: checked (finite, above the horizon, none twice), copied and triangulated. */
pave_result pv_directions_create(pave_context *context, const char *what, const pave_direction *given, int32_t count,
                                 pv_directions *out);
void pv_directions_free(pv_directions *directions);
void pv_directions_weigh(const pv_directions *directions, pave_direction direction, int32_t index[3],
                         double weight[3]);

/* How much of the hemisphere lies nearest to each direction: 2 pi together. */
void pv_directions_share(const pv_directions *directions, double *share);

/* A direction as a unit vector, and back. */
void pv_direction_vector(pave_direction direction, double vector[3]);
pave_direction pv_vector_direction(const double vector[3]);

/* The angle between two, and the one nearest to another, with the angle between them: radians. */
double pv_direction_distance(pave_direction a, pave_direction b);
int32_t pv_directions_nearest(const pv_directions *directions, pave_direction direction, double *distance);

/* Which of `all` each of `own` is, within a degree; PAVE_ERR_ARGUMENT if one is none of them, or two are the same.
 * `holder` ("the model") has `all`, and `what` they are ("view"). */
pave_result pv_directions_match(pave_context *context, const char *holder, const char *what, const pv_directions *own,
                                const pv_directions *all, int32_t *out);

/* A picture of a BTF's channels, and of alpha if asked, in linear light; its pixels are not yet written. */
pave_result pv_btf_picture(pave_context *context, const pave_btf *btf, int32_t width, int32_t height, int alpha,
                           pave_image **out);

/* Colour models that can be decoded, and those that have three channels. */
int pv_colour_known(int32_t colour);
int pv_colour_is_triple(int32_t colour);

/* The colour model that PAVE_BTF_COLOUR_ stands for. */
pave_result pv_colour_choose(pave_context *context, int32_t asked, int32_t channels, int32_t joint, int32_t *colour);

/* `count` pixels from samples to what is factored (RGB, LOG and LOG_YUV), and back from any model. `least` is added
 * before a logarithm or a division; in files it is 1e-5. `space` is that of PV_COLOUR_PCA. */
#define PV_LEAST_LIGHT 1e-5f
void pv_colour_encode(int32_t colour, float least, int32_t channels, const float *samples, int64_t count, float *out);
void pv_colour_decode(int32_t colour, float least, const float space[12], int32_t channels, const float *values,
                      int64_t count, float *out);
