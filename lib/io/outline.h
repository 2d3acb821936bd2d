/* Outlines of SVG shapes as polylines, in pixels of the picture. */
#pragma once

#include "base/context.h"

/* x' = a x + c y + e, y' = b x + d y + f. */
typedef struct pv_transform {
    double a, b, c, d, e, f;
} pv_transform;

/* Polylines that grow. */
typedef struct pv_outlines {
    pave_context *context;
    pave_result result; /* of the first thing that went wrong; nothing is added after it */
    int64_t *starts;    /* count + 1 */
    double *points;
    int32_t count;
    int64_t point_count, starts_room, points_room;
    double x, y;        /* the last point, before the transform */
} pv_outlines;

void pv_outline_begin(pv_outlines *o, const pv_transform *t, double x, double y);
void pv_outline_line(pv_outlines *o, const pv_transform *t, double x, double y);
void pv_outline_cubic(pv_outlines *o, const pv_transform *t, const double control[6]);
void pv_outline_ellipse(pv_outlines *o, const pv_transform *t, double cx, double cy, double rx, double ry);
/* From the last point; SVG 1.1, F.6. */
void pv_outline_arc(pv_outlines *o, const pv_transform *t, double rx, double ry, double turn, int large, int sweep,
                    double x, double y);

/* Reads a path's data; returns 0 where it is not well formed, after what was. */
int pv_outline_path(pv_outlines *o, const pv_transform *t, const char *data);

/* The next number of a list, NULL at its end or where none is. */
const char *pv_outline_number(const char *text, double *number);
