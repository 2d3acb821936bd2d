/* Pixels under a polygon. */
#pragma once

#include <stdint.h>

/* The pixels whose centres lie in a polygon, row by row: for each row from..to-1, see pv_cover_row. */
typedef struct pv_cover {
    const double *xy;
    int64_t corners;
    int32_t width, height; /* of the picture */
    int32_t top, bottom;   /* rows that may have pixels */
} pv_cover;

enum { PV_COVER_RUNS = 16 };

pv_cover pv_cover_of(const double *xy, int64_t corners, int32_t width, int32_t height);

/* The runs of a row: from[i] .. to[i] - 1. Returns how many. */
int32_t pv_cover_row(const pv_cover *cover, int32_t y, int32_t from[PV_COVER_RUNS], int32_t to[PV_COVER_RUNS]);
