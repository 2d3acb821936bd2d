/* Stones collected one by one, until there is a pavement in memory. */
#pragma once

#include "io/pile.h"

typedef struct pv_collection {
    pave_stones *stones;
    int32_t room;         /* for stones */
    int64_t corners_room; /* for corners */
} pv_collection;

pave_result pv_collect_begin(pave_context *context, pv_collection *out);

pave_result pv_collect_add(pave_context *context, pv_collection *collection, const pv_stone *stone,
                           const uint8_t *rgb);

/* Frees what has been collected, unless it was taken (stones set to NULL). */
void pv_collect_end(pv_collection *collection);

/* svg_read.c: stones from an SVG file in memory. */
pave_result pv_svg_read(pave_context *context, const char *path, const char *bytes, size_t size,
                        pv_collection *collection);
