/* What faces are cut from. */
#include "maps/quarry.h"

#include "image/image.h"
#include "solid/solid.h"
#include "util/half.h"
#include "util/light.h"

#include <math.h>
#include <string.h>

/* Bands of rows between two looks whether to stop. */
enum { VALUES_AT_ONCE = 1 << 18 };

static double value_at(const pv_quarry *b, int64_t index)
{
    double value;
    switch (b->type) {
    case PAVE_U8: return (double)b->light[((const uint8_t *)b->values)[index]];
    case PAVE_U16: return (double)b->light[((const uint16_t *)b->values)[index]];
    case PAVE_F16: value = (double)pv_half_value(((const uint16_t *)b->values)[index]); break;
    default: value = (double)((const float *)b->values)[index];
    }
    return b->coded ? pv_linear_light(value) : value;
}

/* Whole numbers stand for display values, or for what they are. */
static pave_result make_table(pave_context *context, pv_quarry *b, int display)
{
    pave_result result = PAVE_OK;
    int32_t count = b->type == PAVE_U8 ? 256 : b->type == PAVE_U16 ? 65536 : 0;
    b->coded = display && !count;
    if (!count)
        return PAVE_OK;
    b->light = pv_allocate(context, (size_t)count, sizeof *b->light, &result);
    for (int32_t i = 0; i < count && !result; i++) {
        double value = (double)i / (count - 1);
        b->light[i] = (float)(display ? pv_linear_light(value) : value);
    }
    return result;
}

/* How much a voxel differs from the next one along an axis, which may be across the border. */
static void add_difference(const pv_quarry *b, int64_t index, int axis, double inner[3], double across[3])
{
    const int64_t step[3] = { 1, b->size[0], (int64_t)b->size[0] * b->size[1] };
    int32_t place = (int32_t)(index / step[axis] % b->size[axis]);
    int last = place + 1 == b->size[axis];
    int64_t next = last ? index - place * step[axis] : index + step[axis];
    double here = value_at(b, index * b->channels + b->colour[1]);
    double there = value_at(b, next * b->channels + b->colour[1]);
    (last ? across : inner)[axis] += fabs(there - here);
}

static void set_seams(pv_quarry *b, const double inner[3], const double across[3])
{
    for (int a = 0; a < 3; a++)
        if (b->size[a] > 1)
            b->seam[a] = across[a] * (b->size[a] - 1) / fmax(inner[a], 1e-12);
}

/* Looks at every voxel: is it a number, what is their mean, and do opposite sides fit? */
static pave_result survey(pave_context *context, pv_quarry *b, const char *what)
{
    int64_t voxels = (int64_t)b->size[0] * b->size[1] * b->size[2];
    double sum[3] = { 0, 0, 0 }, squares[3] = { 0, 0, 0 }, inner[3] = { 0, 0, 0 }, across[3] = { 0, 0, 0 };
    for (int64_t i = 0; i < voxels; i++) {
        pave_result result = i % VALUES_AT_ONCE ? PAVE_OK : pv_progress(context, 0);
        if (result)
            return result;
        for (int c = 0; c < 3; c++) {
            double value = value_at(b, i * b->channels + b->colour[c]);
            if (!isfinite(value))
                return pv_fail(context, PAVE_ERR_ARGUMENT, "%s: has a value that is no number at %d,%d,%d", what,
                               (int)(i % b->size[0]), (int)(i / b->size[0] % b->size[1]),
                               (int)(i / b->size[0] / b->size[1]));
            sum[c] += value;
            squares[c] += value * value;
        }
        for (int a = 0; a < 3 && isfinite(sum[1]); a++)
            add_difference(b, i, a, inner, across);
    }
    set_seams(b, inner, across);
    for (int c = 0; c < 3; c++) {
        b->mean[c] = sum[c] / (double)voxels;
        b->deviation[c] = sqrt(fmax(squares[c] / (double)voxels - b->mean[c] * b->mean[c], 0));
    }
    return PAVE_OK;
}

static pave_result complete(pave_context *context, pv_quarry *b, int display, const char *what)
{
    pave_result result = make_table(context, b, display);
    if (!result)
        result = survey(context, b, what);
    if (result)
        pv_quarry_free(b);
    return result;
}

pave_result pv_quarry_of_image(pave_context *context, const pave_image *image, const char *what, pv_quarry *out)
{
    memset(out, 0, sizeof *out);
    if (!image)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%s: is NULL", what);
    if (image->type == PAVE_U32)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: holds labels, and not colours", what);
    int32_t red = pv_image_channel(image, "R"), green = pv_image_channel(image, "G"),
            blue = pv_image_channel(image, "B");
    int in_colour = red >= 0 && green >= 0 && blue >= 0;
    *out = (pv_quarry){ .size = { image->width, image->height, 1 }, .channels = image->channels, .type = image->type,
                       .values = image->pixels };
    if (in_colour)
        out->colour[0] = red, out->colour[1] = green, out->colour[2] = blue;
    return complete(context, out, image->encoding == PAVE_DISPLAY, what);
}

static pave_result check_states(pave_context *context, const pave_volume *volume, const char *what)
{
    int64_t voxels = (int64_t)volume->size[0] * volume->size[1] * volume->size[2];
    for (int64_t i = 0; i < voxels; i++) {
        if (volume->states[i] < PAVE_VOXEL_MEASURED)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "%s: voxel %d,%d,%d has no value; faces are cut from full boxes",
                           what, (int)(i % volume->size[0]), (int)(i / volume->size[0] % volume->size[1]),
                           (int)(i / volume->size[0] / volume->size[1]));
        pave_result result = i % VALUES_AT_ONCE ? PAVE_OK : pv_progress(context, 0);
        if (result)
            return result;
    }
    return PAVE_OK;
}

pave_result pv_quarry_of_volume(pave_context *context, const pave_volume *volume, const char *what, pv_quarry *out)
{
    memset(out, 0, sizeof *out);
    if (!volume)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%s: is NULL", what);
    if (volume->channels != 1 && volume->channels != 3)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: has %d channels, and a colour has 1 or 3", what,
                       (int)volume->channels);
    pave_result result = check_states(context, volume, what);
    if (result)
        return result;
    *out = (pv_quarry){ .size = { volume->size[0], volume->size[1], volume->size[2] }, .channels = volume->channels,
                       .type = volume->type, .values = volume->values };
    if (volume->channels == 3)
        out->colour[1] = 1, out->colour[2] = 2;
    return complete(context, out, volume->type != PAVE_F32, what);
}

void pv_quarry_free(pv_quarry *block)
{
    pv_release(block->light);
    block->light = NULL;
}

/* A voxel's number along an axis as one of the block's own. */
static int64_t fold(const pv_quarry *b, int axis, int64_t at)
{
    if (at >= 0 && at < b->size[axis])
        return at;
    int64_t size = b->size[axis], period = b->mirrors[axis] ? 2 * size : size;
    at %= period;
    at += at < 0 ? period : 0;
    return at < size ? at : period - 1 - at;
}

/* The voxels below and above a place, and the weight of the one above. */
static double neighbours(const pv_quarry *b, int axis, double place, int64_t out[2])
{
    double below = floor(place);
    out[0] = fold(b, axis, (int64_t)below);
    out[1] = fold(b, axis, (int64_t)below + 1);
    return b->size[axis] > 1 ? place - below : 0;
}

void pv_quarry_at(const pv_quarry *b, const double place[3], double light[3])
{
    int64_t at[3][2];
    double above[3];
    int colours = b->colour[0] == b->colour[1] ? 1 : 3;
    for (int a = 0; a < 3; a++)
        above[a] = neighbours(b, a, place[a], at[a]);
    light[0] = light[1] = light[2] = 0;
    for (int i = 0; i < 8; i++) {
        int x = i & 1, y = i >> 1 & 1, z = i >> 2;
        double weight = (x ? above[0] : 1 - above[0]) * (y ? above[1] : 1 - above[1]) * (z ? above[2] : 1 - above[2]);
        if (weight == 0)
            continue;
        int64_t voxel = ((at[2][z] * b->size[1] + at[1][y]) * b->size[0] + at[0][x]) * b->channels;
        for (int c = 0; c < colours; c++)
            light[c] += weight * value_at(b, voxel + b->colour[c]);
    }
    if (colours == 1)
        light[1] = light[2] = light[0];
}
