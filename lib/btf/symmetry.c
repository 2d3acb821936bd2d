/* Mirrors and turns that a set of directions keeps. */
#include "btf/symmetry.h"

#include <string.h>

static const double near_enough = 2e-3; /* rad */

static pave_direction moved(pave_direction d, const double across[4])
{
    double from[3], to[3];
    pv_direction_vector(d, from);
    to[0] = across[0] * from[0] + across[1] * from[1];
    to[1] = across[2] * from[0] + across[3] * from[1];
    to[2] = from[2];
    return pv_vector_direction(to);
}

int pv_directions_moved(const pv_directions *directions, const double across[4], int32_t *out)
{
    for (int32_t i = 0; i < directions->count; i++) {
        double away;
        out[i] = pv_directions_nearest(directions, moved(directions->direction[i], across), &away);
        if (away > near_enough)
            return 0;
    }
    return 1;
}

pave_result pv_symmetry_find(pave_context *context, const pv_directions *views, const pv_directions *lights,
                             int wanted, pv_symmetry *out)
{
    pave_result result = PAVE_OK;
    memset(out, 0, sizeof *out);
    for (int32_t flips = 0; flips < (wanted ? 4 : 1) && !result; flips++) {
        const double across[4] = { flips & 1 ? -1 : 1, 0, 0, flips & 2 ? -1 : 1 };
        int32_t k = out->count;
        out->view[k] = pv_allocate(context, (size_t)views->count, sizeof **out->view, &result);
        if (!result)
            out->light[k] = pv_allocate(context, (size_t)lights->count, sizeof **out->light, &result);
        out->flips[k] = flips;
        if (!result && pv_directions_moved(views, across, out->view[k]) &&
            pv_directions_moved(lights, across, out->light[k])) {
            out->count++;
            continue;
        }
        pv_release(out->view[k]);
        pv_release(out->light[k]);
        out->view[k] = out->light[k] = NULL;
    }
    if (result)
        pv_symmetry_free(out);
    return result;
}

void pv_symmetry_free(pv_symmetry *symmetry)
{
    for (int32_t k = 0; k < symmetry->count; k++) {
        pv_release(symmetry->view[k]);
        pv_release(symmetry->light[k]);
    }
    symmetry->count = 0;
}
