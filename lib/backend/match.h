/* Matching on a graphics device: how much a block differs from what lies at many places of a picture. */
#pragma once

#include "base/context.h"

typedef struct pv_matcher pv_matcher;

/* One value of the block that counts: how far it lies from the place, in values, and what it is. */
typedef struct pv_match_entry { int32_t shift, value; } pv_match_entry;

/* Places in rows, all numbers in values of the picture. */
typedef struct pv_match_places {
    int32_t first, stride; /* the first place, and from one row of places to the next */
    int32_t depth, across, down;
} pv_match_places;

/* Is there a GPU? Software does not count. */
int pv_matcher_has_gpu(pave_context *context);

/* Opens a device and brings the picture there: `count` values of 0..4095. PAVE_ERR_DEVICE if there is no device,
 * PAVE_ERR_UNSUPPORTED if the picture is too large for it, or there is no Vulkan in this build. */
pave_result pv_matcher_open(pave_context *context, const int16_t *values, int64_t count, int32_t most_entries,
                            pv_matcher **out);
void pv_matcher_close(pv_matcher *matcher);

/* Sums of squared differences at all places, row by row. */
pave_result pv_matcher_run(pv_matcher *matcher, const pv_match_entry *entries, int32_t count,
                           const pv_match_places *places, uint64_t *costs);
