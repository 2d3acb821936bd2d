/* Judging stones, from inside: what the measures work on. */
#pragma once

#include "field/field.h"
#include "image/palette.h"
#include "stones/stones.h"
#include "stones/tess.h"

#include "util/polygon.h"

/* Stones as rings of whole numbers, counter-clockwise, no corner twice in a row. */
typedef struct pv_survey {
    const pave_image *drawing; /* of the whole plane */
    const pave_stones *stones;
    int32_t count;
    int64_t *first; /* ring s is corner[first[s]] .. corner[first[s + 1] - 1] */
    pv_cell *corner;
    uint8_t *valid;
    uint8_t *colour; /* as a value of the drawing */
    double *area; /* px^2 */
    double half_side;
    double joint_limit; /* px */
} pv_survey;

static inline const pv_cell *pv_survey_ring(const pv_survey *survey, int32_t s, int32_t *count)
{
    *count = (int32_t)(survey->first[s + 1] - survey->first[s]);
    return survey->corner + survey->first[s];
}

/* survey.c */
pave_result pv_survey_make(pave_context *context, const pave_image *drawing, const pave_stones *stones,
                           const pave_stones_measure_params *params, pv_survey *out, int32_t *clockwise);
void pv_survey_free(pv_survey *survey);

/* Boxes in buckets of the plane: who may meet whom. */
typedef struct pv_box {
    int32_t left, top, right, bottom; /* 1/1000 px */
} pv_box;

typedef struct pv_buckets {
    int32_t left, top, side, columns, rows; /* 1/1000 px; what lies outside counts to the nearest bucket */
    int64_t *first; /* bucket b holds member[first[b]] .. member[first[b + 1] - 1], ascending */
    int32_t *member;
} pv_buckets;

/* buckets.c */
pv_box pv_box_of(const pv_cell *ring, int32_t count);
pave_result pv_buckets_fill(pave_context *context, const pave_stones *plane, const pv_box *box, int32_t count,
                            pv_buckets *out);
void pv_buckets_free(pv_buckets *buckets);
int32_t pv_bucket_column(const pv_buckets *buckets, int32_t x);
int32_t pv_bucket_row(const pv_buckets *buckets, int32_t y);

/* Each fills its part of the measures. */
pave_result pv_measure_shapes(pave_context *context, const pv_survey *survey, pave_stones_measures *out);
pave_result pv_measure_overlap(pave_context *context, const pv_survey *survey, pave_stones_measures *out);
pave_result pv_measure_directions(pave_context *context, const pv_survey *survey, const pave_field *field,
                                  pave_stones_measures *out);
pave_result pv_measure_joints(pave_context *context, const pv_survey *survey, pave_stones_measures *out);

/* ground.c: what is under the stones; `painted`, one value a pixel of the window, becomes the stones' colours there,
 * and where none is that of the nearest one. */
pave_result pv_measure_ground(pave_context *context, const pv_survey *survey, pave_image **painted,
                              pave_stones_measures *out);
pave_result pv_measure_edges(pave_context *context, const pv_survey *survey, const pave_field *field,
                             const pave_image *painted, pave_stones_measures *out);
