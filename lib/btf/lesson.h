/* What a regression learns from: texels of the sample and of its copies, and kernels that stand on some of them. */
#pragma once

#include "btf/enlarge.h"

enum { PV_FOLDS = 4 };

/* Texels of the sample that are learned from, quarter after quarter, those of its copies after its own, and some of
 * them that kernels stand on. */
typedef struct pv_lesson {
    pv_enlarge *e;
    const pv_around *around;
    int32_t copies, texels, centres, features;
    int32_t sampled[PV_FOLDS], copied[PV_FOLDS]; /* texels of a quarter in the sample, and in each copy */
    int32_t from[PV_FOLDS + 1];
    int64_t *texel; /* of the sample, or of a copy */
    float *feature; /* [texel][feature] */
    float *target;  /* [texel][coefficient], less the mean */
    float *centre;  /* [centre][feature] */
    double scale;   /* mean square distance of texels and centres */
    double width;   /* of the kernel: exp(-distance^2 / (2 width scale)) */
    float *kernel;  /* [texel][centre] */
    double *own;    /* [centre][centre] */
    double *gram;   /* [fold][centre][centre]: kernel' kernel */
    double *side;   /* [fold][coefficient][centre]: target' kernel */
} pv_lesson;

/* At most `most` texels of the sample, three times as many of its first so many copies, and so many kernels. */
pave_result pv_lesson_open(const pv_around *around, int32_t copies, int32_t most, int32_t centres, pv_lesson *out);
void pv_lesson_free(pv_lesson *lesson);

/* Sums over each quarter, with a kernel of that width. */
pave_result pv_lesson_study(pv_lesson *lesson, double width);

/* The kernels at a texel that is described so: [centre]. */
void pv_lesson_kernels(const pv_lesson *lesson, const float *feature, float *out);
