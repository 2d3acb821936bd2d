/* Bidirectional texture functions from inside: samples as they are, or factors. */
#pragma once

#include "base/params.h"

#include <pave/btf.h>

extern const pv_table pv_btf_synthesis_table, pv_btf_compress_table;

enum { PV_BTF_CHANNELS = 32, PV_BTF_NAME = 64, PV_BTF_TEXT = 81 };

/* How factored values become samples; the numbers are those of Bonn's files. */
enum { PV_COLOUR_RGB = 0, PV_COLOUR_LOG_YUV = 11, PV_COLOUR_LOG = 12 };

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

/* A channel's matrix, rows [view][light], columns [y][x]: left * right', each row of `right` times the singular
 * values. */
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
    int32_t factor_type; /* PAVE_F16 or PAVE_F32: how precise the factors are */
    pv_factors *factors; /* one for each channel; NULL: the samples are there */
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

/* A BTF with neither samples nor factors; everything is checked but the memory that samples would take. */
pave_result pv_btf_new(pave_context *context, const pave_btf_params *params, pave_btf **out);

/* Room for its samples, not yet written. */
pave_result pv_btf_allocate_samples(pave_context *context, pave_btf *btf);

/* Room for the factors of a channel. */
pave_result pv_btf_allocate_factors(pave_context *context, pave_btf *btf, int32_t channel, int32_t components);

/* Makes a copy of everything but samples and factors. */
pave_result pv_btf_copy_frame(pave_context *context, const pave_btf *btf, pave_btf **out);

/* Samples `first` .. `first + count - 1` of a texel as floats; only where there are samples. */
void pv_btf_samples(const pave_btf *btf, int64_t texel, int64_t first, int64_t count, float *out);

/* Stores a whole texel that pv_btf_allocate_samples made room for. */
void pv_btf_store(pave_btf *btf, int64_t texel, const float *values);

/* Directions: checked (finite, above the horizon, none twice), copied and triangulated. */
pave_result pv_directions_create(pave_context *context, const char *what, const pave_direction *given, int32_t count,
                                 pv_directions *out);
void pv_directions_free(pv_directions *directions);
void pv_directions_weigh(const pv_directions *directions, pave_direction direction, int32_t index[3],
                         double weight[3]);

/* A direction as a unit vector, and back. */
void pv_direction_vector(pave_direction direction, double vector[3]);
pave_direction pv_vector_direction(const double vector[3]);

/* `count` pixels of `channels` values from samples to what is factored, and back. */
void pv_colour_encode(int32_t colour, int32_t channels, const float *samples, int64_t count, float *out);
void pv_colour_decode(int32_t colour, int32_t channels, const float *values, int64_t count, float *out);
