/* The bank: all exemplars, in all ways they may be laid, as they are compared. */
#pragma once

#include "image/image.h"

#include <pave/tiling.h>

enum { PV_MOST_EXEMPLARS = 16, PV_TURNS = 8, PV_BANK_SPARE = 16, PV_CELL = 8 };
enum { PV_COST_UNIT = 16 }; /* costs are in 1/16 of a grey level of 255 */

/* One exemplar in one way to lay it. */
typedef struct pv_sheet {
    int32_t exemplar, turn;
    int32_t width, height;
    int32_t first; /* place of its pixel (0, 0) */
} pv_sheet;

/* Sheets lie one below the other in one picture, each with a border of one pixel that repeats its outermost ones: so
 * what would follow a pixel to the right is always the next one, and below it one `stride` further. */
typedef struct pv_bank {
    int32_t sheets;
    pv_sheet sheet[PV_MOST_EXEMPLARS * PV_TURNS];
    int32_t stride, pixels;
    int32_t depth;     /* values a pixel: its channels, and the distance to joints where that is used */
    int32_t white;     /* greatest value */
    int16_t *values;   /* PV_BANK_SPARE more than there are, for vectors */
    uint8_t *usable;   /* not the borders */
    int32_t *blocked;  /* how many pixels above and left of each place are not usable, in the picture */
    uint8_t *border;   /* place lies in a sheet's border */
    int16_t *bright;   /* brightness, 0..white, not flattened */
    int32_t *home;     /* the upright sheet's place of the same exemplar's pixel */
    int32_t *cell;     /* the number of the PV_CELL x PV_CELL px of the exemplar that a place lies in */
    int32_t cells;
    int16_t *stone;    /* what a cut costs here that goes through a stone: more the further inside; 0 in joints, and
                        * everywhere unless joints enclose stones */
    int plain;         /* all is usable, and of one colour */
    double contrast;   /* how much two pixels differ, against what is usual: 1 */
    double feature;    /* size of what the exemplars are made of, px; 0: not known */
    int64_t all, usable_count; /* pixels of the upright sheets */
} pv_bank;

pave_result pv_bank_create(pave_context *context, const pave_image *const *exemplars, int32_t count,
                           const pave_tiling_params *params, pv_bank *out);
void pv_bank_free(pv_bank *bank);

/* The sheet that a place lies in. */
const pv_sheet *pv_bank_sheet(const pv_bank *bank, int32_t place);

/* Where a place is in its exemplar. */
pave_source pv_bank_source(const pv_bank *bank, int32_t place);

/* Are all pixels of a rectangle usable? `place` is its first one. */
static inline int pv_bank_clear(const pv_bank *bank, int32_t place, int32_t width, int32_t height)
{
    const int32_t *sum = bank->blocked + place;
    int32_t above = -bank->stride - 1, below = (height - 1) * bank->stride;
    return sum[below + width - 1] - sum[below - 1] - sum[above + width] + sum[above] == 0;
}

/* joints.c: marks the dark lines, or else the bright ones, between stones in a picture of one sheet. */
typedef struct pv_grey {
    int32_t width, height, stride, white;
    const int16_t *values;
} pv_grey;

typedef struct pv_joints {
    uint8_t *joint;    /* of the picture's size, as is */
    int32_t *distance; /* to the joints' border, in thirds of a px, negative inside */
    double feature;    /* size of the features, px; 0: not known */
    int enclose;       /* joints enclose stones, but for gaps of a px or two */
} pv_joints;

pave_result pv_joints_find(pave_context *context, const pv_grey *grey, pv_joints *out);
void pv_joints_free(pv_joints *joints);

/* The sum of the squared sizes of the areas between joints. */
pave_result pv_joints_areas(pave_context *context, int32_t width, int32_t height, const uint8_t *joint,
                            double *squares);

/* The mean of a square of 2 * radius + 1 px around every pixel, cut off at the border; `out` has no stride. */
pave_result pv_box_mean(pave_context *context, const pv_grey *grey, int32_t radius, int32_t *out);
