/* Volumes: storage, cuts, values at a point. */
#include "solid/solid.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const pave_volume_params default_params = PAVE_VOLUME_PARAMS_INIT;

static const pv_param volume_rows[] = {
    PV_INTEGER(pave_volume_params, width, "voxels", 1, 1 << 20, "width"),
    PV_INTEGER(pave_volume_params, height, "voxels", 1, 1 << 20, "height"),
    PV_INTEGER(pave_volume_params, depth, "voxels", 1, 1 << 20, "depth"),
    PV_INTEGER(pave_volume_params, channels, "", 1, 8, "number of channels"),
    PV_INTEGER(pave_volume_params, type, "", PAVE_U8, PAVE_F32, "how a value is stored"),
};

static const pv_table volume_table = PV_TABLE("volume", default_params, volume_rows);

void pave_volume_params_init(pave_volume_params *params, size_t size)
{
    pv_params_init(&volume_table, params, size);
}

static pave_result check(pave_context *context, const pave_volume_params *p)
{
    if (p->type == PAVE_U32 || p->type == PAVE_F16)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a volume holds 8 or 16 bit whole numbers or floats");
    if (!(p->spacing > 0) || !isfinite(p->spacing) || !isfinite(p->origin[0]) || !isfinite(p->origin[1]) ||
        !isfinite(p->origin[2]))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "a volume's spacing must be above 0, and its origin finite");
    double voxels = (double)p->width * p->height * p->depth;
    if (voxels > 4294967295.0)
        return pv_fail(context, PAVE_ERR_LIMIT, "%d x %d x %d voxels are beyond the limit of 2^32", (int)p->width,
                       (int)p->height, (int)p->depth);
    return PAVE_OK;
}

pave_result pv_volume_new(pave_context *context, const pave_volume_params *given, pave_volume **out)
{
    pave_volume_params p;
    *out = NULL;
    pave_result result = pv_params_read(context, &volume_table, given, &p);
    if (!result)
        result = check(context, &p);
    if (result)
        return result;
    pave_volume *volume = pv_allocate_zeroed(context, 1, sizeof *volume, &result);
    if (!volume)
        return result;
    volume->size[0] = p.width;
    volume->size[1] = p.height;
    volume->size[2] = p.depth;
    volume->channels = p.channels;
    volume->type = p.type;
    volume->spacing = p.spacing;
    memcpy(volume->origin, p.origin, sizeof volume->origin);
    volume->params.mode = -1;
    volume->use = volume->constraint_error = NAN;
    size_t n = (size_t)p.width * (size_t)p.height * (size_t)p.depth;
    volume->values = pv_allocate(context, n, (size_t)p.channels * pv_type_bytes(p.type), &result);
    if (!result)
        volume->states = pv_allocate(context, n, 1, &result);
    if (result)
        pave_volume_free(&volume);
    *out = volume;
    return result;
}

pave_result pave_volume_create(pave_context *context, const pave_volume_params *params, const void *values,
                               const uint8_t *states, pave_volume **out)
{
    if (out)
        *out = NULL;
    if (!context || !params || !values || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_volume_new(context, params, out);
    if (result)
        return result;
    pave_volume *volume = *out;
    size_t n = (size_t)volume->size[0] * (size_t)volume->size[1] * (size_t)volume->size[2];
    memcpy(volume->values, values, n * (size_t)volume->channels * pv_type_bytes(volume->type));
    if (!states) {
        memset(volume->states, PAVE_VOXEL_MEASURED, n);
        return PAVE_OK;
    }
    memcpy(volume->states, states, n);
    for (size_t i = 0; i < n && !result; i++)
        if (states[i] > PAVE_VOXEL_FILLED)
            result = pv_fail(context, PAVE_ERR_ARGUMENT, "state %d of voxel %zu is none of PAVE_VOXEL_", states[i], i);
    if (result)
        pave_volume_free(out);
    return result;
}

void pave_volume_free(pave_volume **volume)
{
    if (!volume || !*volume)
        return;
    pv_release((*volume)->values);
    pv_release((*volume)->states);
    pv_release((*volume)->cells);
    pv_release(*volume);
    *volume = NULL;
}

int32_t pave_volume_width(const pave_volume *volume) { return volume->size[0]; }
int32_t pave_volume_height(const pave_volume *volume) { return volume->size[1]; }
int32_t pave_volume_depth(const pave_volume *volume) { return volume->size[2]; }
int32_t pave_volume_channels(const pave_volume *volume) { return volume->channels; }
int32_t pave_volume_type(const pave_volume *volume) { return volume->type; }
double pave_volume_spacing(const pave_volume *volume) { return volume->spacing; }
const double *pave_volume_origin(const pave_volume *volume) { return volume->origin; }
const void *pave_volume_values(const pave_volume *volume) { return volume->values; }
const uint8_t *pave_volume_states(const pave_volume *volume) { return volume->states; }
const int32_t *pave_volume_cells(const pave_volume *volume) { return volume->cells; }

const char *pave_volume_shape(const pave_volume *volume) { return volume->shape; }

double pv_volume_stored(const void *values, int32_t type, int64_t index)
{
    switch (type) {
    case PAVE_U8: return ((const uint8_t *)values)[index];
    case PAVE_U16: return ((const uint16_t *)values)[index];
    default: return ((const float *)values)[index];
    }
}

void pv_volume_store(void *values, int32_t type, int64_t index, double stored)
{
    switch (type) {
    case PAVE_U8: ((uint8_t *)values)[index] = (uint8_t)stored; break;
    case PAVE_U16: ((uint16_t *)values)[index] = (uint16_t)stored; break;
    default: ((float *)values)[index] = (float)stored;
    }
}

static int64_t at(const pave_volume *volume, const int32_t p[3])
{
    for (int a = 0; a < 3; a++)
        if (p[a] < 0 || p[a] >= volume->size[a])
            return -1;
    int64_t index = ((int64_t)p[2] * volume->size[1] + p[1]) * volume->size[0] + p[0];
    return volume->states[index] < PAVE_VOXEL_MEASURED ? -1 : index;
}

static void add(const pave_volume *volume, int64_t voxel, double weight, float *out)
{
    double full = volume->type == PAVE_U8 ? 255 : volume->type == PAVE_U16 ? 65535 : 1;
    for (int32_t c = 0; c < volume->channels; c++)
        out[c] += (float)(weight / full * pv_volume_stored(volume->values, volume->type, voxel * volume->channels + c));
}

/* The nearest voxel of the 3 x 3 x 3 around a point; -1: all are outside. */
static int64_t nearest(const pave_volume *volume, const double p[3])
{
    double least = INFINITY;
    int64_t found = -1;
    for (int i = 0; i < 27; i++) {
        const int32_t offset[3] = { i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1 };
        int32_t v[3];
        double far = 0;
        for (int a = 0; a < 3; a++) {
            v[a] = (int32_t)floor(p[a] + 0.5) + offset[a];
            far += (p[a] - v[a]) * (p[a] - v[a]);
        }
        int64_t index = at(volume, v);
        if (index >= 0 && far < least)
            least = far, found = index;
    }
    return found;
}

int32_t pave_volume_sample(const pave_volume *volume, double x, double y, double z, float *out)
{
    double p[3] = { x, y, z }, sum = 0, weight[8];
    int64_t index[8];
    int32_t first[3];
    memset(out, 0, (size_t)volume->channels * sizeof *out);
    for (int a = 0; a < 3; a++) {
        p[a] = (p[a] - volume->origin[a]) / volume->spacing;
        if (!(p[a] > -2 && p[a] < volume->size[a] + 1))
            return 0;
        first[a] = (int32_t)floor(p[a]);
    }
    for (int i = 0; i < 8; i++) {
        const int32_t v[3] = { first[0] + (i & 1), first[1] + (i >> 1 & 1), first[2] + (i >> 2) };
        index[i] = at(volume, v);
        weight[i] = index[i] < 0 ? 0 : 1;
        for (int a = 0; a < 3; a++)
            weight[i] *= 1 - fabs(p[a] - v[a]);
        sum += weight[i];
    }
    for (int i = 0; i < 8 && sum > 0; i++)
        if (index[i] >= 0)
            add(volume, index[i], weight[i] / sum, out);
    int64_t other = sum > 0 ? -1 : nearest(volume, p);
    if (other >= 0)
        add(volume, other, 1, out);
    return sum > 0 || other >= 0;
}

/* Makes a pixel of a voxel. */
typedef void pixel_maker(const pave_volume *volume, int64_t voxel, uint8_t *pixel);

static void take_values(const pave_volume *volume, int64_t voxel, uint8_t *pixel)
{
    size_t bytes = (size_t)volume->channels * pv_type_bytes(volume->type);
    memcpy(pixel, volume->values + (size_t)voxel * bytes, bytes);
}

static void take_cell(const pave_volume *volume, int64_t voxel, uint8_t *pixel)
{
    int32_t cell = volume->cells[voxel];
    *pixel = (uint8_t)(cell < 0 ? 0 : 40 + (uint32_t)cell * 89u % 216u);
}

/* The voxels of a plane, each as such a pixel. */
static pave_result make_slice(pave_context *context, const pave_volume *volume, int32_t axis, int32_t index,
                              int32_t channels, int32_t type, pixel_maker *maker, pave_image **out)
{
    pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
    if (axis < 0 || axis > 2 || index < 0 || index >= volume->size[axis])
        return pv_fail(context, PAVE_ERR_ARGUMENT, "there is no slice %d on axis %d", (int)index, (int)axis);
    int u = axis == 0, v = axis == 2 ? 1 : 2;
    const int64_t along[3] = { 1, volume->size[0], (int64_t)volume->size[0] * volume->size[1] };
    shape.width = volume->size[u];
    shape.height = volume->size[v];
    shape.channels = channels;
    shape.type = type;
    pave_result result = pv_image_new(context, &shape, out);
    if (result)
        return result;
    uint8_t *to = (*out)->pixels;
    for (int64_t y = 0; y < shape.height; y++)
        for (int64_t x = 0; x < shape.width; x++, to += (size_t)channels * pv_type_bytes(type))
            maker(volume, along[axis] * index + x * along[u] + y * along[v], to);
    return PAVE_OK;
}

pave_result pave_volume_slice(pave_context *context, const pave_volume *volume, int32_t axis, int32_t index,
                              pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !volume || !out)
        return PAVE_ERR_ARGUMENT;
    return make_slice(context, volume, axis, index, volume->channels, volume->type, take_values, out);
}

pave_result pave_volume_slice_cells(pave_context *context, const pave_volume *volume, int32_t axis, int32_t index,
                                    pave_image **out)
{
    if (out)
        *out = NULL;
    if (!context || !volume || !out)
        return PAVE_ERR_ARGUMENT;
    if (!volume->cells)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "this volume was made without cells");
    return make_slice(context, volume, axis, index, 1, PAVE_U8, take_cell, out);
}
