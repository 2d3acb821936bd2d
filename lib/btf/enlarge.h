/* An enlargement under way (Steinhausen et al. 2014): the sample's coefficients, and what photographs say. */
#pragma once

#include "btf/algebra.h"
#include "btf/model.h"
#include "btf/symmetry.h"
#include "statistics/planes.h"

extern const pv_table pv_btf_enlarge_table;

/* The texels of a rectangle, each with so many channels: [y][x][channel]. */
typedef struct pv_texels {
    int32_t width, height, channels;
    float *values;
} pv_texels;

static inline int64_t pv_texels_count(const pv_texels *t)
{
    return (int64_t)t->width * t->height;
}

/* Beyond the borders texels are mirrored. */
static inline int64_t pv_mirrored(int64_t i, int64_t count)
{
    while (count > 1 && (i < 0 || i >= count))
        i = i < 0 ? -i : 2 * (count - 1) - i;
    return count > 1 ? i : 0;
}

/* A guide is one plane (log Y, U/Y or V/Y) of one photograph. What it shows of a texel hangs on the coefficients of
 * that plane: row . coefficients + offset, but for an error of this variance. */
typedef struct pv_guide {
    int32_t plane;
    const float *row; /* [component of its plane] */
    float *own;       /* where the row is of its own, and not the basis's */
    double offset, noise;
} pv_guide;

/* The sample turned or mirrored, where that takes views to views and lights to lights: another piece of its class, but
 * that its texels stay in their places. What lies at x, y of a texel in the copy does at `place` times that in the
 * sample. Copy 0 is the sample itself. */
typedef struct pv_turned {
    double place[4];
    int32_t *view, *light;        /* which of the sample's its own are */
    float *turn[PV_BTF_CHANNELS]; /* of the coefficients of each plane; NULL: they are the sample's */
    pv_texels seen;               /* guides */
} pv_turned;

enum { PV_MOST_COPIES = 24 };

/* Texels of the sample that were held out, and what a prediction missed of them. */
typedef struct pv_held_out {
    int64_t count;
    int64_t *texel;
    float *missed; /* [..][coefficient]: predicted less true */
} pv_held_out;

static inline void pv_held_out_free(pv_held_out *held)
{
    pv_release(held->texel);
    pv_release(held->missed);
}

typedef struct pv_enlarge {
    pave_context *context;
    pv_algebra algebra;
    const pave_btf *sample, *photos;
    const pave_btf_plan *plan;
    const pave_image *mean;
    const pave_btf_enlarge_params *params;
    pave_btf *out;          /* its left factors are the sample's eigen-ABRDFs */
    int32_t planes, coefficients, photographs, guides;
    int32_t first[PV_BTF_CHANNELS + 1]; /* coefficient of each plane */
    pv_texels known, made;  /* coefficients of the sample, and of the whole */
    pv_texels seen, given;  /* guides of the sample, which copy 0 owns, and of the whole */
    pv_turned copy[PV_MOST_COPIES];
    int32_t copies, straight; /* straight: those that take texels to texels; they come first */
    pv_guide *guide;
    int32_t *given_pair, *sample_pair; /* of the photographs and of the sample; the mean picture has none */
    double *middle;         /* [coefficient]: mean over the sample */
    double *spread;         /* [coefficient][coefficient]: covariance over the sample */
    pv_held_out held;
    double left;            /* of the sample's variance, what a prediction misses, as found on parts held out */
    int32_t rounds;
} pv_enlarge;

pave_result pv_texels_new(pave_context *context, int32_t width, int32_t height, int32_t channels, pv_texels *out);

/* Values of what is factored: samples darker than epsilon are lifted to it first, in place, so that no shadow weighs
 * more than what is lit, and no ratio of colours blows up. */
void pv_enlarge_encode(const pv_enlarge *e, float *samples, int64_t count, float *out);

/* The sample's eigen-ABRDFs and coefficients (Eqs. 8, 9). */
pave_result pv_enlarge_factor(pv_enlarge *e);

/* Reads the photographs, and finds what the sample would look like on them. */
pave_result pv_enlarge_guide(pv_enlarge *e);

/* The guides that a copy of the sample shows. */
pave_result pv_enlarge_see(const pv_enlarge *e, const pv_turned *copy, pv_texels *out);

/* ---- More of the class ---- */

pave_result pv_enlarge_copy(pv_enlarge *e);
void pv_enlarge_free_copies(pv_enlarge *e);

/* A texel's coefficients in a copy. */
void pv_enlarge_copied(const pv_enlarge *e, const pv_turned *copy, int64_t texel, float *out);

/* ---- Predicting from what is around a texel ---- */

/* Vectors less their mean, along the axes in which they vary most. */
typedef struct pv_axes {
    int32_t from, to;
    float *mean; /* [from] */
    float *turn; /* [from][to] */
} pv_axes;

/* How to describe what the guides show around a texel: principal components of their windows. */
typedef struct pv_around {
    pv_enlarge *e;
    double sigma; /* weights in a window fall as a Gaussian of so many texels */
    pv_axes guides, windows; /* a feature for each of the windows' axes */
} pv_around;

/* Learns the axes from the sample. */
pave_result pv_around_learn(pv_enlarge *e, double sigma, pv_around *out);
void pv_around_free(pv_around *around);

/* [texel][feature] of texels of a copy of the sample, or of the whole (NULL) from the first. */
pave_result pv_around_describe(const pv_around *around, const pv_turned *copy, const int64_t *texels, int64_t count,
                               float *out);

/* Coefficients of the whole by kernel ridge regression; finds what it misses where texels are `held` out, too. */
pave_result pv_enlarge_predict(pv_enlarge *e, double from, double to);

/* ---- Texture Optimization ---- */

/* Sets the coefficients of the whole by Texture Optimization (Eqs. 2, 3) at so many levels, each half as fine as the
 * one before; all photographs together weigh `balance` times what the texture weighs. */
pave_result pv_enlarge_optimize(pv_enlarge *e, int32_t levels, double balance, double from, double to);

/* Both: the regression, and beside it windows put together anew; finds `left`, too. */
pave_result pv_enlarge_mix(pv_enlarge *e);

/* How much of `made`, the sample's texels put together anew, beside the regression would have missed least of what was
 * held out: 0 to 1. */
double pv_enlarge_share(const pv_enlarge *e, const float *made);

/* ---- What photographs demand ---- */

/* Eqs. 4 to 6: the point nearest to `before` (by share) and `after` that shows just what the guides show. */
pave_result pv_enlarge_force(pv_enlarge *e, const float *before, const float *after, double share, float *out);

/* ---- Octaves ---- */

enum { PV_OCTAVES = 4 };

/* The power of the slopes of each octave of each coefficient, [octave][coefficient]: of the sample, and of the
 * whole. */
pave_result pv_enlarge_octaves(const pv_enlarge *e, double *own, double *made);

/* Scales the octaves of each coefficient of the whole until their power is that of the sample, as far as photographs do
 * not tell that the whole differs. */
pave_result pv_enlarge_sharpen(pv_enlarge *e);

/* ---- How it came out ---- */

/* Portilla and Simoncelli's statistics of the first so many coefficients. */
pave_result pv_enlarge_statistics(const pv_enlarge *e, const pv_texels *t, int32_t channels, pv_statistics **out);

pave_result pv_enlarge_judge(const pv_enlarge *e, pave_btf_enlargement *report);
