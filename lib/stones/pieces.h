/* Label images as pieces: connected, of one colour and without holes, ready to be traced. */
#pragma once

#include "base/context.h"

/* Labels with colours below them. */
typedef struct pv_label_image {
    int32_t width, height;
    const int32_t *labels;
    int32_t stride;         /* of a row of labels */
    int32_t label_count;
    const uint8_t *colours; /* NULL: all of one colour */
    int32_t colour_width;   /* of a row of colours */
    int32_t colour_x, colour_y; /* of the first label's pixel among the colours, in pixels of labels */
    int32_t scale;          /* pixels of labels to one of colours, along a side */
} pv_label_image;

typedef struct pv_pieces {
    int32_t width, height;
    int32_t *face;   /* of each pixel: its piece */
    int32_t count;   /* pieces are in the order of their labels, then of their first pixels */
    int32_t *label;
    int32_t *part;   /* 0 for the first piece of a label */
    uint8_t *colour;
    int64_t *area;   /* pixels */
} pv_pieces;

enum { PV_PIECES_ROUNDS = 3 };

/* Splits labels by colour and 4-connectivity; pieces of less than `least` pixels are merged with the neighbour of their
 * colour, or with `fill` of any colour, along the longest contact, in at most PV_PIECES_ROUNDS rounds that each look no
 * farther than a neighbour's neighbour; pieces that enclose others are cut. */
pave_result pv_pieces_split(pave_context *context, const pv_label_image *image, int64_t least, int fill,
                            pv_pieces *out);
void pv_pieces_free(pv_pieces *pieces);
