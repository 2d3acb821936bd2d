/* The sample that a stone is made of, at one level of its pyramid: every neighbourhood, and which ones are alike. */
#pragma once

#include "base/context.h"
#include "image/image.h"

enum { PV_NEAREST = 3, PV_CLASSES = 256, PV_STEPS = 16, PV_LAGS = 2, PV_FAR = 4 };
enum { PV_MOST_FEATURES = 8, PV_MOST_SIDE = 31 };

/* What texels are compared by: for a few labels one number a label (all but the commonest), else the channels. */
typedef struct pv_texels {
    int32_t width, height, features;
    uint8_t *feature; /* [texel][features] */
    uint8_t *class;   /* [texel]: what is counted in histograms: the grey value, the luma, or the label's grey */
} pv_texels;

/* A Gaussian window of side x side texels. Differences are multiplied by `root`, the root of the weight, so that the
 * sum of squares over at most all taps, each counted sixteen times, stays below 2^31. */
typedef struct pv_window {
    int32_t side, radius, features;
    int32_t taps, stride; /* numbers of a neighbourhood; with padding */
    int16_t *root;        /* [stride]; 0 at the centre and in the padding */
    int32_t total;        /* sum of squares of the roots of one feature */
    int32_t centre;       /* the weight that the centre would have */
} pv_window;

/* Positions are those of the texels, then those of the transposed texels: a plane of the volume has no preferred side.
 * Only positions whose window lies inside have a neighbourhood. A step within the window's radius from such a position
 * never leaves its copy, so positions can be shifted by adding. */
typedef struct pv_windows {
    pv_window window;
    int32_t width, height, features, copies, positions;
    uint8_t *feature, *class, *inside; /* [position] */
    int16_t *patch;                    /* [position][stride], weighted */
    int32_t *nearest;                  /* [position][PV_NEAREST]: alike, but not the same; -1: none */
    int32_t *inner, inner_count;       /* positions with a neighbourhood, by class */
    int32_t class_start[PV_CLASSES + 1];
    int32_t target[PV_CLASSES];   /* texels of each class */
    int32_t target_total;
    int64_t apart[2][PV_LAGS][PV_CLASSES]; /* along x and y: pairs of texels 1 and PV_FAR apart by their difference */
    int64_t variance;             /* of a texel, summed over features */
} pv_windows;

/* Differences between voxels so far apart along an axis: their bins, and how many there should be in each. */
typedef struct pv_steps {
    uint8_t bin[PV_CLASSES];
    int64_t target[PV_STEPS], total;
} pv_steps;

/* Half the size: means of 2 x 2; a class is that of the mean. */
pave_result pv_texels_halve(pave_context *context, const pv_texels *from, int labels, pv_texels *out);
void pv_texels_free(pv_texels *texels);

pave_result pv_windows_create(pave_context *context, const pv_texels *texels, int32_t side, double sigma,
                              int transposed, int alike, uint64_t seed, pv_windows *out);
void pv_windows_free(pv_windows *bank);

/* In bins that hold about equally many, from counts by difference. */
void pv_steps_create(const int64_t counts[PV_CLASSES], pv_steps *out);

/* alike.c: fills the lists of the nearest. */
pave_result pv_windows_alike(pave_context *context, pv_windows *bank, uint64_t seed);

/* Positions in a row of the copy that a position lies in. */
static inline int32_t pv_windows_row(const pv_windows *bank, int32_t position)
{
    return position < bank->width * bank->height ? bank->width : bank->height;
}

/* What is added to every distance: without it a penalty on a distance of 0 would be none, and flat parts would take the
 * whole volume. */
static inline int64_t pv_windows_floor(const pv_windows *bank)
{
    return bank->variance * bank->window.total / 50 + 1;
}

/* Squared distances of a neighbourhood from those at `positions`; `presence` is 0 where it is not known, 4 where it is
 * measured. All arrays of values are aligned to 32 bytes. */
typedef void pv_distances(const pv_windows *bank, const int16_t *patch, const int16_t *presence,
                          const int32_t *positions, int32_t count, int32_t *out);

/* The fastest of them for this processor, or the portable one. */
pv_distances *pv_distances_choose(int32_t portable);

#if defined(__x86_64__)
#define PV_DISTANCE_AVX2
pv_distances pv_distances_avx2;
#endif
