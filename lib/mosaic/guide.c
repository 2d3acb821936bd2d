/* The guide: which edges the tiles are to follow, and the direction field that follows from them (section 4). */
#include "mosaic/mosaic.h"

#include "image/image.h"

#include <math.h>
#include <string.h>

static pave_result has_size(pave_context *context, const pave_image *image, const char *what, const pave_guide *guide)
{
    if (!image || (image->width == guide->width && image->height == guide->height))
        return PAVE_OK;
    return pv_fail(context, PAVE_ERR_ARGUMENT, "%s has %d x %d px, the photo %d x %d", what, (int)image->width,
                   (int)image->height, (int)guide->width, (int)guide->height);
}

static int64_t count_marks(const pave_guide *guide)
{
    int64_t count = 0;
    for (int64_t i = 0; i < (int64_t)guide->width * guide->height; i++)
        count += guide->edge[i];
    return count;
}

/* The artist's edges as they are; others cleaned. */
static pave_result gather_edges(pave_context *context, const pave_mosaic_sources *sources,
                                const pave_mosaic_params *params, const pv_photo *photo, double side,
                                pave_guide *guide)
{
    pave_result result = PAVE_OK;
    if (sources->edges)
        result = pv_edges_take(context, sources->edges, guide);
    if (sources->curves && !result)
        pv_edges_draw(sources->curves, guide);
    if (!sources->edges && !sources->curves && !result) {
        result = pv_edges_find(context, photo, side, params->strength, guide);
        if (!result)
            result = pv_edges_clean(context, 5 * side, 0.8 * side, guide);
    }
    if (!result && !count_marks(guide)) {
        if (sources->edges || sources->curves)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "none of the edges given lies in the photo");
        pv_note(context, PAVE_MESSAGE_INFO, "no edges were found: rows follow %s",
                guide->wraps ? "the axes" : "the frame");
    }
    return result;
}

static pave_result make_field(pave_context *context, const pave_mosaic_sources *sources,
                              const pave_mosaic_params *params, double side, pave_guide *guide)
{
    int32_t fold = params->aspect != 1 ? 2 : 4, kind = params->direction;
    if (sources->direction)
        return pv_field_take(context, sources->direction, guide);
    if (kind == PAVE_DIRECTION_AUTO)
        kind = params->mode == PAVE_MODE_PAPER ? PAVE_DIRECTION_GRADIENT : PAVE_DIRECTION_HARMONIC;
    if (kind == PAVE_DIRECTION_GRADIENT)
        return pv_field_gradient(context, guide);
    return pv_field_harmonic(context, fold, side, guide);
}

static pave_result make(pave_context *context, const pave_mosaic_sources *sources, const pave_mosaic_params *params,
                        const pv_photo *photo, pave_guide *guide)
{
    size_t pixels = (size_t)guide->width * (size_t)guide->height;
    double side = params->tile_side;
    pave_result result = has_size(context, sources->edges, "the image of edges", guide);
    if (!result)
        result = has_size(context, sources->direction, "the image of directions", guide);
    if (!result)
        guide->edge = pv_allocate_zeroed(context, pixels, 1, &result);
    if (!result)
        guide->direction = pv_allocate_zeroed(context, pixels, sizeof *guide->direction, &result);
    if (!result)
        guide->way = pv_allocate_zeroed(context, 2 * pixels, sizeof *guide->way, &result);
    if (!result)
        result = gather_edges(context, sources, params, photo, side, guide);
    if (!result && count_marks(guide))
        result = pv_distance_from(context, guide->edge, guide->width, guide->height, guide->wraps, &guide->away);
    if (!result)
        result = make_field(context, sources, params, side, guide);
    return result ? result : pv_field_singularities(context, params->aspect != 1 ? 2 : 4, side, guide);
}

pave_result pv_guide_make(pave_context *context, const pave_mosaic_sources *sources, const pave_mosaic_params *params,
                          const pv_photo *photo, pave_guide **out)
{
    pave_result result = PAVE_OK;
    pave_guide *guide = pv_allocate_zeroed(context, 1, sizeof *guide, &result);
    *out = NULL;
    if (!guide)
        return result;
    guide->width = photo->width;
    guide->height = photo->height;
    guide->wraps = params->periodic;
    result = make(context, sources, params, photo, guide);
    if (result)
        pave_guide_free(&guide);
    *out = guide;
    return result;
}

void pave_guide_free(pave_guide **guide)
{
    if (!guide || !*guide)
        return;
    pv_release((*guide)->edge);
    pv_release((*guide)->direction);
    pv_release((*guide)->away);
    pv_release((*guide)->way);
    pv_release((*guide)->singularity);
    pv_release(*guide);
    *guide = NULL;
}

int32_t pave_guide_width(const pave_guide *guide) { return guide->width; }
int32_t pave_guide_height(const pave_guide *guide) { return guide->height; }
const uint8_t *pave_guide_edges(const pave_guide *guide) { return guide->edge; }
const uint16_t *pave_guide_directions(const pave_guide *guide) { return guide->direction; }
int32_t pave_guide_singularity_count(const pave_guide *guide) { return guide->singularities; }
const double *pave_guide_singularities(const pave_guide *guide) { return guide->singularity; }
