/* Linear models of a class of materials from inside: eigen-ABRDFs, eigen-ABTFs, and how far to trust them. */
#pragma once

#include "btf/algebra.h"
#include "btf/btf.h"

extern const pv_table pv_btf_model_table, pv_btf_plan_table, pv_btf_reconstruct_table;

enum { PV_OF_TEXELS = 0, PV_OF_PATCHES = 1, PV_MOST_RUNGS = 12, PV_MOST_PATCH = 9, PV_MOST_COMPONENTS = 16384 };

/* An orthonormal basis, rows [y of the patch][x][view][light], and how much materials of the class have of each of its
 * vectors. */
typedef struct pv_basis {
    int32_t components;
    float *left;      /* [row][component] */
    float *deviation; /* [component]: root mean square of a column's coefficients, falling */
    double whole;     /* mean square of a value, less the mean */
    double outside;   /* of what a material that the basis does not know has outside of it, if found; else of those it
                         was made of */
} pv_basis;

/* How to reconstruct from so many samples, found on materials that were held out. */
typedef struct pv_rung {
    double samples;
    double noise[2]; /* of ABRDFs, and of ABTFs: variance of a measured value about what the basis says */
    double rest;     /* the same for ABRDFs of what the ABTFs leave */
    double share;    /* 0 .. 1: how much of the ABTFs' prediction is taken before the ABRDFs' */
    double trust;    /* true error over the predicted one */
} pv_rung;

struct pave_btf_model {
    int32_t channels, planes, colour, cosine, patch, materials, symmetry;
    pv_directions views, lights;
    char names[PV_BTF_CHANNELS][PV_BTF_NAME];
    float least;            /* added before logarithms */
    int64_t texels, patches; /* that it was made of */
    float (*range)[2];      /* [plane]: of the values that it was made of */
    float *mean;            /* [plane][pair]: what is taken off first */
    pv_basis (*basis)[2];   /* [plane][PV_OF_] */
    int32_t rungs;          /* 0: none was held out */
    pv_rung (*rung)[PV_MOST_RUNGS]; /* [plane] */
    void *map;              /* of the file where the bases lie; NULL: they are in memory */
    size_t map_bytes;
};

static inline int64_t pv_model_pairs(const pave_btf_model *model)
{
    return (int64_t)model->views.count * model->lights.count;
}

static inline int64_t pv_basis_rows(const pave_btf_model *model, int32_t of)
{
    return pv_model_pairs(model) * (of == PV_OF_PATCHES ? model->patch * model->patch : 1);
}

struct pave_btf_plan {
    int32_t count;
    int32_t *view, *light;
    double *expected;
    pave_direction *from, *to; /* directions of each view and light */
    double before, after;      /* condition numbers */
};

/* A plan of some pairs, [view][light]. */
pave_result pv_plan_new(pave_context *context, const pv_directions *views, const pv_directions *lights,
                        const int32_t *pairs, int32_t count, pave_btf_plan **out);

/* Marks the first `samples` pairs of a plan, 0: all, in `wanted`, [view][light]. PAVE_ERR_ARGUMENT if it has not so
 * many, or is of more directions than what `holder` names ("the model has"). */
pave_result pv_plan_mark(pave_context *context, const pave_btf_plan *plan, int32_t samples, const char *holder,
                         int32_t views, int32_t lights, uint8_t *wanted);

/* A model without bases. */
pave_result pv_model_new(pave_context *context, int32_t planes, const pave_direction *views, int32_t view_count,
                         const pave_direction *lights, int32_t light_count, pave_btf_model **out);

/* A model of the directions and channels that all these have, without bases. */
pave_result pv_model_frame(pave_context *context, const pave_btf *const *btfs, int32_t count,
                           const pave_btf_model_params *given, pave_btf_model **out);

/* Fits the bases and finds the rungs of a model that has its frame and mean. */
pave_result pv_model_fit(pave_context *context, const pave_btf *const *btfs, int32_t count,
                         const pave_btf_model_params *params, pave_btf_model *model);

/* Takes off what a grey diffuse plane would send. */
void pv_model_set_mean(pave_btf_model *model);

void pv_model_drop_bases(pave_btf_model *model);

/* Samples as the values that models are about: a texel's planes, each [pair], less the mean. */
typedef struct pv_values {
    const pave_btf *btf;
    const pave_btf_model *model;
    float *room; /* two texels for each worker */
} pv_values;

pave_result pv_values_open(pave_context *context, const pave_btf *btf, const pave_btf_model *model, pv_values *out);
void pv_values_close(pv_values *values);
int pv_values_read(const pv_values *values, int64_t texel, int32_t worker, float *const *out); /* 0: not all finite */

/* The settings for so many samples: between those of the rungs. */
pv_rung pv_model_settings(const pave_btf_model *model, int32_t plane, double samples);

/* The rows of a basis for some pairs, of every place of the patch: [place][pair][component]. */
void pv_basis_rows_of(const pave_btf_model *model, const pv_basis *basis, int32_t places, const int32_t *pairs,
                      int32_t count, float *out);

/* Greedy choice of pairs by the first plane's ABRDFs: `pairs` and `left`, the trace of what remains unknown after each,
 * have `count` places. */
pave_result pv_plan_greedy(pave_context *context, const pave_btf_model *model, double noise, int32_t count,
                           int32_t *pairs, double *left);

/* The same by whole views and whole lights: each pair of a view and a light that were chosen. What one brings is taken
 * over what it costs: a picture each, and `shot_cost` for a light. `count` is the most, and what it came to. */
pave_result pv_plan_dome(pave_context *context, const pave_btf_model *model, double noise, double shot_cost,
                         int32_t *pairs, double *left, int32_t *count);

/* Chance, as long as the condition number falls. */
pave_result pv_plan_swap(pave_context *context, const pave_btf_model *model, const pave_btf_plan_params *params,
                         int32_t *pairs, double *before, double *after);
