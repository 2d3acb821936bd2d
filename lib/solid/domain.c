/* Where the stone is, and what is known of it: measurements are checked here and then never touched again. */
#include "solid/domain.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct domain {
    pave_context *context;
    const pave_solid_input *input;
    const pv_palette *palette;
    pave_volume *volume;
    double *error; /* not NULL: the stone is made, and held against what was measured */
} domain;

static pave_result measure(domain *d, const int32_t at[3], const double *stored, const char *what)
{
    pave_volume *v = d->volume;
    int64_t voxel = ((int64_t)at[2] * v->size[1] + at[1]) * v->size[0] + at[0];
    for (int32_t c = 0; c < v->channels; c++) {
        int64_t index = voxel * v->channels + c;
        double had = pv_volume_stored(v->values, v->type, index);
        if (d->error)
            *d->error = fmax(*d->error, fabs(had - (v->type == PAVE_F32 ? (float)stored[c] : stored[c])));
        else if (v->states[voxel] == PAVE_VOXEL_MEASURED && had != (v->type == PAVE_F32 ? (float)stored[c] : stored[c]))
            return pv_fail(d->context, PAVE_ERR_ARGUMENT,
                           "%s gives voxel %d,%d,%d the value %g, but it has been measured as %g", what, (int)at[0],
                           (int)at[1], (int)at[2], stored[c], had);
    }
    for (int32_t c = 0; c < v->channels && !d->error; c++)
        pv_volume_store(v->values, v->type, voxel * v->channels + c, stored[c]);
    v->states[voxel] = PAVE_VOXEL_MEASURED;
    return PAVE_OK;
}

static int is_inside(const pave_volume *v, const int32_t at[3])
{
    for (int a = 0; a < 3; a++)
        if (at[a] < 0 || at[a] >= v->size[a])
            return 0;
    return v->states[((int64_t)at[2] * v->size[1] + at[1]) * v->size[0] + at[0]] != PAVE_VOXEL_OUTSIDE;
}

static int is_storable(int32_t type, double stored)
{
    double most = type == PAVE_U8 ? 255 : 65535;
    return type == PAVE_F32 ? isfinite((float)stored) : stored >= 0 && stored <= most && stored == floor(stored);
}

static pave_result measure_point(domain *d, int64_t index)
{
    const pave_volume *v = d->volume;
    const double *p = d->input->points + 3 * index, *value = d->input->point_values + index * v->channels;
    int32_t at[3] = { 0, 0, 0 };
    int fits = 1;
    char what[48];
    snprintf(what, sizeof what, "measurement %lld", (long long)index + 1);
    for (int a = 0; a < 3; a++) {
        double voxel = floor((p[a] - v->origin[a]) / v->spacing + 0.5);
        fits = fits && voxel >= 0 && voxel < v->size[a];
        at[a] = fits ? (int32_t)voxel : 0;
    }
    if (!fits || !is_inside(v, at))
        return pv_fail(d->context, PAVE_ERR_ARGUMENT, "%s at %g,%g,%g lies outside the stone", what, p[0], p[1], p[2]);
    for (int32_t c = 0; c < v->channels; c++)
        if (!is_storable(v->type, value[c]))
            return pv_fail(d->context, PAVE_ERR_ARGUMENT, "%s has the value %g, which the sample's type cannot hold",
                           what, value[c]);
    return measure(d, at, value, what);
}

static pave_result measure_slice(domain *d, int32_t index)
{
    const pave_image *image = d->input->slices[index];
    const pave_volume *v = d->volume;
    int32_t axis = d->input->slice_places[2 * index], place = d->input->slice_places[2 * index + 1], at[3];
    double stored[PV_MOST_FEATURES];
    char what[48];
    snprintf(what, sizeof what, "slice %d", (int)index + 1);
    if (axis < 0 || axis > 2 || place < 0 || place >= v->size[axis])
        return pv_fail(d->context, PAVE_ERR_ARGUMENT, "%s lies on plane %d of axis %d, outside the volume", what,
                       (int)place, (int)axis);
    int u = axis == 0, w = axis == 2 ? 1 : 2;
    int32_t channels = image->channels - (image->alpha >= 0);
    if (image->width > v->size[u] || image->height > v->size[w] || channels != v->channels)
        return pv_fail(d->context, PAVE_ERR_ARGUMENT, "%s has %d x %d px and %d channels, but fits %d x %d and %d",
                       what, (int)image->width, (int)image->height, (int)channels, (int)v->size[u], (int)v->size[w],
                       (int)v->channels);
    pave_result result = PAVE_OK;
    at[axis] = place;
    for (at[w] = 0; at[w] < image->height && !result; at[w]++)
        for (at[u] = 0; at[u] < image->width && !result; at[u]++) {
            int64_t pixel = (int64_t)at[w] * image->width + at[u];
            if (!is_inside(v, at) ||
                (image->alpha >= 0 && pv_image_value(image, pixel * image->channels + image->alpha) == 0))
                continue;
            pv_palette_pixel(d->palette, image, pixel, stored);
            result = measure(d, at, stored, what);
        }
    return result;
}

/* What is free has no value yet. */
static pave_result copy_partial(domain *d)
{
    const pave_volume *from = d->input->partial;
    pave_volume *v = d->volume;
    size_t n = (size_t)v->size[0] * (size_t)v->size[1] * (size_t)v->size[2];
    memcpy(v->values, from->values, n * (size_t)v->channels * pv_type_bytes(v->type));
    for (size_t i = 0; i < n; i++)
        v->states[i] = from->states[i] == PAVE_VOXEL_FILLED ? PAVE_VOXEL_MEASURED : from->states[i];
    return PAVE_OK;
}

static pave_result make_partial(domain *d, pave_volume_params *place)
{
    const pave_volume *from = d->input->partial;
    if (from->type != d->palette->type || from->channels != d->palette->channels)
        return pv_fail(d->context, PAVE_ERR_ARGUMENT, "the partial volume and the sample differ in channels or type");
    place->width = from->size[0];
    place->height = from->size[1];
    place->depth = from->size[2];
    place->spacing = from->spacing;
    memcpy(place->origin, from->origin, sizeof place->origin);
    pave_result result = pv_volume_new(d->context, place, &d->volume);
    return result ? result : copy_partial(d);
}

static pave_result make_shape(domain *d, const pave_solid_params *params)
{
    pave_volume_params place = PAVE_VOLUME_PARAMS_INIT;
    uint8_t *states = NULL;
    char shape[96] = "box";
    pave_result result = PAVE_OK;
    place.channels = d->palette->channels;
    place.type = d->palette->type;
    place.width = params->width;
    place.height = params->height;
    place.depth = params->depth;
    if (d->input->partial)
        return make_partial(d, &place);
    if (d->input->mesh)
        result = pv_voxelize(d->context, d->input->mesh, params->resolution, &place, &states, shape);
    if (!result)
        result = pv_volume_new(d->context, &place, &d->volume);
    if (!result) {
        size_t n = (size_t)place.width * (size_t)place.height * (size_t)place.depth;
        if (states)
            memcpy(d->volume->states, states, n);
        else
            memset(d->volume->states, PAVE_VOXEL_FREE, n);
        memset(d->volume->values, 0, n * (size_t)place.channels * pv_type_bytes(place.type));
        memcpy(d->volume->shape, shape, sizeof shape);
    }
    pv_release(states);
    return result;
}

static pave_result measure_all(domain *d)
{
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < d->input->slice_count && !result; i++)
        result = measure_slice(d, i);
    for (int64_t i = 0; i < d->input->point_count && !result; i++)
        result = measure_point(d, i);
    return result;
}

pave_result pv_domain_create(pave_context *context, const pave_solid_input *input, const pave_solid_params *params,
                             const pv_palette *palette, pave_volume **out)
{
    domain d = { context, input, palette, NULL, NULL };
    pave_result result = PAVE_OK;
    if (input->mesh && input->partial)
        result = pv_fail(context, PAVE_ERR_ARGUMENT, "a mesh and a partial volume cannot both say where the stone is");
    if (!result)
        result = make_shape(&d, params);
    if (!result)
        result = measure_all(&d);
    if (result)
        pave_volume_free(&d.volume);
    *out = d.volume;
    return result;
}

pave_result pv_domain_check(pave_context *context, const pave_solid_input *input, const pv_palette *palette,
                            pave_volume *volume, double *error)
{
    domain d = { context, input, palette, volume, error };
    const pave_volume *from = input->partial;
    int64_t n = (int64_t)volume->size[0] * volume->size[1] * volume->size[2] * volume->channels;
    *error = 0;
    for (int64_t i = 0; i < n && from; i++)
        if (from->states[i / volume->channels] >= PAVE_VOXEL_MEASURED)
            *error = fmax(*error, fabs(pv_volume_stored(volume->values, volume->type, i) -
                                       pv_volume_stored(from->values, from->type, i)));
    return measure_all(&d);
}
