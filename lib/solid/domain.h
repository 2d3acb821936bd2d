/* Where the stone is, and what is known of it. */
#pragma once

#include "solid/exemplar.h"
#include "solid/grid.h"

/* Makes the volume: box, mesh or partial volume, states OUTSIDE, FREE and MEASURED, the measured values in place. */
pave_result pv_domain_create(pave_context *context, const pave_solid_input *input, const pave_solid_params *params,
                             const pv_palette *palette, pave_volume **out);

/* The greatest difference of the stone from what was measured, as stored: 0. */
pave_result pv_domain_check(pave_context *context, const pave_solid_input *input, const pv_palette *palette,
                            pave_volume *volume, double *error);
