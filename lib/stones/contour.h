/* Where junctions lie, and how chains bend between them. */
#pragma once

#include "stones/net.h"
#include "stones/tess.h"

typedef struct pv_outline {
    pv_cell *junction;
    uint8_t *kind;     /* of junctions, PV_BORDER, PV_CONTOUR */
    int64_t *first;    /* bends of chain c: bend[first[c]] .. bend[first[c + 1] - 1], from its start */
    pv_cell *bend;
    int64_t room;
    uint8_t *rough;    /* chains that have one bend in their middle: 1; that are kept crack by crack: 2 */
} pv_outline;

enum {
    PV_CONTOUR_REACH = 12, /* px along the contour that a place on it depends on */
    PV_SMOOTH_REACH = 3    /* px around an edge that tell whether it is smooth */
};

/* isoline.c: is the edge of a drawing between the pixels on the left and on the right of (x, y), if it is upright, or
 * else above and below, a smooth one? Then the way from the middle to where it is, px. */
int pv_isoline(const struct pave_image *drawing, int32_t x, int32_t y, int upright, double *way);

/* Straight chains between pieces of one colour; between colours the contour: a line that leaves the pixels of either
 * colour on their side wherever their edge is smooth, and keeps corners. */
pave_result pv_outline_draw(pave_context *context, const pv_net *net, const pv_tess_place *place, pv_outline *out);

/* Makes chains rough and draws again. */
pave_result pv_outline_redraw(pave_context *context, const pv_net *net, const pv_tess_place *place, pv_outline *out);
void pv_outline_free(pv_outline *outline);

/* mesh.c: the faces of pieces, their outline drawn. Where straight chains would cross they are drawn crack by crack. */
pave_result pv_tess_trace(pave_context *context, const pv_pieces *pieces, const pv_tess_place *place, pv_tess *out);
