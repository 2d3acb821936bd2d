/* Stones collected one by one, until there is a pavement in memory. */
#pragma once

#include "stones/stones.h"

#include "util/polygon.h"

typedef struct pv_collection {
    pave_stones *stones;
    int32_t room;         /* for stones */
    int64_t corners_room; /* for corners */
} pv_collection;

pave_result pv_collect_begin(pave_context *context, pv_collection *out);

/* Adds a stone; its ring is in 1/1000 px. */
pave_result pv_collect_add(pave_context *context, pv_collection *collection, int32_t number, uint8_t colour,
                           const int32_t *xy, int32_t corners);

/* Frees what has been collected, unless it was taken (stones set to NULL). */
void pv_collect_end(pv_collection *collection);

/* svg_read.c: stones from an SVG file in memory. */
pave_result pv_svg_read(pave_context *context, const char *path, const char *bytes, size_t size,
                        pv_collection *collection);
