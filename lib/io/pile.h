/* A pile of stones: a pavement, or a part of one, that is read stone by stone in the order of their numbers, however
 * many there are. Writers take piles, so that what is in memory, in a file or in many files is written alike. */
#pragma once

#include "stones/stones.h"

typedef struct pv_stone {
    int32_t number;
    int32_t part;    /* of a stone that was cut: 0, 1 ... */
    int32_t corners; /* 0: the pile is at its end */
    uint8_t colour;
    const uint8_t *rgb; /* of a tile of a mosaic; NULL: a stone */
    const int32_t *xy; /* 1/1000 px; valid until the next stone */
} pv_stone;

typedef struct pv_pile {
    pave_stones head;    /* window, report and parameters; of its arrays only those in memory are set */
    int64_t counts[256]; /* stones of each colour */
    pave_result (*next)(pave_context *context, struct pv_pile *pile, pv_stone *out);
    void (*rewind)(struct pv_pile *pile);
    void *source;
    void (*close)(struct pv_pile *pile);
} pv_pile;

/* A pile of the stones in memory. */
pave_result pv_pile_of(pave_context *context, const pave_stones *stones, pv_pile *out);

/* A pile of the stones in files that pv_stones_file_write wrote: windows of one pavement, merged. Files are opened for
 * a moment at a time, so there may be any number. */
pave_result pv_pile_open(pave_context *context, const char *const *paths, int32_t count, pv_pile *out);

void pv_pile_close(pv_pile *pile);
