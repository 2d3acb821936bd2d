/* The bed: what was given is vetted, and every stone gets its place, its face and how it lies. */
#include "maps/maps.h"

#include "image/image.h"
#include "stones/palette.h"
#include "util/fixed.h"
#include "util/light.h"
#include "util/random.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_SIDE = 1 << 20, MOST_SAMPLES = 16, STONES_AT_ONCE = 4096 };
static const double most_seam = 1.5;

/* Colours that a stone can be of. */
static int32_t colours_of(const pave_stones *stones)
{
    return stones->palette.palette.count ? stones->palette.palette.count : 2;
}

static pave_result check_input(pave_context *context, const pave_maps_input *input, const pave_maps_params *params)
{
    int32_t textures = input->texture_count, volumes = input->volume_count;
    if (!input->stones || input->stones->count < 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "there are no stones to make maps of");
    if (textures < 0 || volumes < 0 || (textures && !input->textures) || (volumes && !input->volumes))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "textures or volumes are NULL");
    if (textures && volumes)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "faces are cut from textures or from volumes, not from both");
    if (textures + volumes > colours_of(input->stones))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "there are %d %s, but stones of %d colours", textures + volumes,
                       textures ? "textures" : "volumes", colours_of(input->stones));
    if (params->joint_colour.count > 1)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "joint_colour is one colour, and not %d",
                       params->joint_colour.count);
    return PAVE_OK;
}

/* Maps of a plane that repeats repeat by whole px, or not at all. */
static pave_result check_period(pave_context *context, const pave_stones *stones, double scale)
{
    double width = stones->plane_width * scale, height = stones->plane_height * scale;
    if (!stones->field.periodic || (width == floor(width) && height == floor(height)))
        return PAVE_OK;
    return pv_fail(context, PAVE_ERR_ARGUMENT,
                   "at a scale of %g the period of %d x %d px is %g x %g px of the maps, and must be whole", scale,
                   stones->plane_width, stones->plane_height, width, height);
}

/* Its sides fit if they differ hardly more than neighbours do. */
static void set_border(const pv_bed *bed, pv_quarry *block)
{
    for (int a = 0; a < 3; a++)
        block->mirrors[a] = bed->params.repeat == PAVE_REPEAT_MIRROR ||
                            (bed->params.repeat == PAVE_REPEAT_AUTO && block->seam[a] > most_seam);
}

static pave_result read_blocks(pave_context *context, const pave_maps_input *input, pv_bed *bed)
{
    pave_result result = PAVE_OK;
    int32_t count = input->texture_count + input->volume_count;
    char name[32];
    bed->block = pv_allocate_zeroed(context, (size_t)count, sizeof *bed->block, &result);
    for (int32_t i = 0; i < count && !result; i++) {
        snprintf(name, sizeof name, "%s %d", input->texture_count ? "texture" : "volume", (int)i + 1);
        result = input->texture_count ? pv_quarry_of_image(context, input->textures[i], name, &bed->block[i])
                                      : pv_quarry_of_volume(context, input->volumes[i], name, &bed->block[i]);
        set_border(bed, &bed->block[i]);
        bed->blocks += !result;
    }
    if (!result && input->joint)
        result = pv_quarry_of_image(context, input->joint, "the joints' texture", &bed->joint);
    set_border(bed, &bed->joint);
    return result;
}

/* As deep as the deepest block: bytes, 16 bits, floats. */
static int32_t deepest(const pv_bed *bed)
{
    int32_t type = PAVE_U8;
    for (int32_t i = 0; i <= bed->blocks; i++) {
        const pv_quarry *block = i < bed->blocks ? &bed->block[i] : &bed->joint;
        int32_t of_block = block->type == PAVE_F16 ? PAVE_F32 : block->type;
        type = block->values && of_block > type ? of_block : type;
    }
    return type;
}

static void paint_of(pv_colour colour, double light[3])
{
    light[0] = pv_linear_light(colour.r / 255.0);
    light[1] = pv_linear_light(colour.g / 255.0);
    light[2] = pv_linear_light(colour.b / 255.0);
}

static void set_lengths(pv_bed *bed)
{
    const pave_maps_params *p = &bed->params;
    const uint8_t *joint = p->joint_colour.rgb;
    bed->half_side = p->half_side > 0 ? p->half_side : pv_stones_half_side(bed->stones);
    bed->scale = p->scale;
    bed->texels = p->texels > 0 ? p->texels : p->scale;
    bed->bevel = p->bevel * bed->half_side;
    bed->depth = p->joint_depth * bed->half_side;
    bed->sand = p->joint_sand * bed->half_side;
    bed->relief = p->relief * bed->half_side;
    bed->samples = (int32_t)pv_clamped(ceil(bed->texels / bed->scale), 1, MOST_SAMPLES);
    paint_of(p->joint_colour.count ? (pv_colour){ joint[0], joint[1], joint[2] } : pv_grout, bed->joint_paint);
}

/* Its corners, from the px where its box begins. */
static pave_result place(pave_context *context, pv_bed *bed, int32_t s, pv_laid *laid)
{
    const pave_stones *stones = bed->stones;
    const double *v = stones->vertices + 2 * laid->first;
    double low[2] = { INFINITY, INFINITY }, high[2] = { -INFINITY, -INFINITY }, grid = PV_MAP_GRID;
    for (int32_t i = 0; i < 2 * laid->corners; i++) {
        double at = floor(v[i] * grid * bed->scale + 0.5) / grid;
        low[i % 2] = at < low[i % 2] ? at : low[i % 2];
        high[i % 2] = at > high[i % 2] ? at : high[i % 2];
    }
    if (laid->corners < 1)
        low[0] = low[1] = high[0] = high[1] = 0;
    if (!(high[0] - low[0] < MOST_SIDE - 2) || !(high[1] - low[1] < MOST_SIDE - 2) ||
        !(fabs(low[0]) < 1e15) || !(fabs(low[1]) < 1e15))
        return pv_fail(context, PAVE_ERR_LIMIT, "stone %d is beyond the limit of %d px of the maps", s, MOST_SIDE);
    laid->x = (int64_t)floor(low[0]);
    laid->y = (int64_t)floor(low[1]);
    laid->width = (int32_t)(floor(high[0]) - floor(low[0])) + 1;
    laid->height = (int32_t)(floor(high[1]) - floor(low[1])) + 1;
    for (int32_t i = 0; i < laid->corners; i++) {
        pv_cell *c = &bed->corner[laid->first + i];
        c->x = (int32_t)(floor(v[2 * i] * grid * bed->scale + 0.5) - grid * (double)laid->x);
        c->y = (int32_t)(floor(v[2 * i + 1] * grid * bed->scale + 0.5) - grid * (double)laid->y);
        laid->middle[0] += c->x / (grid * laid->corners);
        laid->middle[1] += c->y / (grid * laid->corners);
    }
    return PAVE_OK;
}

/* The farthest corner from the middle, px of the drawing. */
static double radius_of(const pv_bed *bed, const pv_laid *laid)
{
    double most = 0;
    for (int32_t i = 0; i < laid->corners; i++) {
        pv_cell c = bed->corner[laid->first + i];
        double x = (double)c.x / PV_MAP_GRID - laid->middle[0], y = (double)c.y / PV_MAP_GRID - laid->middle[1];
        most = x * x + y * y > most ? x * x + y * y : most;
    }
    return sqrt(most) / bed->scale;
}

/* How it lies: a little higher or lower, and tilted towards anywhere. */
static void settle(const pv_bed *bed, double radius, pv_laid *laid)
{
    const pave_maps_params *p = &bed->params;
    int32_t cosine, sine;
    pv_random r = pv_draw(p->seed, PV_DRAW_SURFACE, (uint32_t)laid->number, (uint32_t)laid->part, 0);
    pv_turn((int32_t)floor(p->tilt / 360 * 65536 + 0.5), &cosine, &sine);
    double steep = sqrt(pv_unit(r.word[1])) * sine / cosine;
    steep *= radius > 2 * bed->half_side ? 2 * bed->half_side / radius : 1;
    pv_turn((int32_t)(r.word[0] >> 16), &cosine, &sine);
    laid->slope[0] = steep * cosine / 65536;
    laid->slope[1] = steep * sine / 65536;
    laid->lift = p->lift * bed->half_side * pv_signed_unit(r.word[2]);
    laid->roughness = pv_clamped(p->roughness + p->roughness_variation * pv_signed_unit(r.word[3]), 0, 1);
}

/* Cut from the block of its colour, from a whole px of the drawing on. */
static void dress(const pv_bed *bed, int32_t s, double radius, pv_laid *laid)
{
    const pave_stones *stones = bed->stones;
    int32_t colours = colours_of(stones), value = stones->colours[s], tint = bed->params.tint;
    const uint8_t *rgb = stones->rgb ? stones->rgb + 3 * (int64_t)s : NULL;
    pv_face *face = &laid->face;
    int32_t index = stones->palette.palette.count ? value : value >= 128;
    face->block = bed->blocks ? index % bed->blocks : -1;
    face->tinted = tint == PAVE_TINT_YES || (tint == PAVE_TINT_AUTO && bed->blocks < colours);
    paint_of(rgb ? (pv_colour){ rgb[0], rgb[1], rgb[2] } : pv_laid_colour(stones, stones->colours[s]), face->paint);
    face->anchor[0] = floor(((double)laid->x + laid->middle[0]) / bed->scale) * bed->scale - (double)laid->x;
    face->anchor[1] = floor(((double)laid->y + laid->middle[1]) / bed->scale) * bed->scale - (double)laid->y;
    pv_face_draw(bed, radius + 2, laid);
}

static pave_result lay(pave_context *context, pv_bed *bed, double to)
{
    const pave_stones *stones = bed->stones;
    pave_result result = PAVE_OK;
    for (int32_t s = 0; s < bed->count && !result; s++) {
        pv_laid *laid = &bed->laid[s];
        int follows = s && stones->sites[s] == stones->sites[s - 1];
        laid->first = stones->starts[s];
        laid->corners = (int32_t)(stones->starts[s + 1] - stones->starts[s]);
        laid->number = stones->sites[s];
        laid->part = follows ? laid[-1].part + 1 : 0;
        result = place(context, bed, s, laid);
        double radius = radius_of(bed, laid);
        settle(bed, radius, laid);
        dress(bed, s, radius, laid);
        if (!result && s % STONES_AT_ONCE == 0)
            result = pv_progress(context, to * s / bed->count);
    }
    return result;
}

pave_result pv_bed_open(pave_context *context, const pave_maps_input *input, const pave_maps_params *params,
                        pv_bed *bed)
{
    memset(bed, 0, sizeof *bed);
    pave_result result = check_input(context, input, params);
    if (!result)
        result = check_period(context, input->stones, params->scale);
    if (result)
        return result;
    bed->stones = input->stones;
    bed->params = *params;
    bed->count = input->stones->count;
    set_lengths(bed);
    result = read_blocks(context, input, bed);
    bed->colour_type = deepest(bed);
    if (!result)
        bed->laid = pv_allocate_zeroed(context, (size_t)bed->count, sizeof *bed->laid, &result);
    if (!result)
        bed->corner = pv_allocate(context, (size_t)bed->stones->starts[bed->count], sizeof *bed->corner, &result);
    return result ? result : lay(context, bed, 0.05);
}

void pv_bed_close(pv_bed *bed)
{
    for (int32_t i = 0; i < bed->blocks; i++)
        pv_quarry_free(&bed->block[i]);
    pv_quarry_free(&bed->joint);
    pv_release(bed->block);
    pv_release(bed->laid);
    pv_release(bed->corner);
    memset(bed, 0, sizeof *bed);
}

pave_result pv_frame_of(pave_context *context, const pv_bed *bed, const double box[4], pv_frame *out)
{
    double left = floor(box[0] * bed->scale), top = floor(box[1] * bed->scale);
    double right = ceil(box[2] * bed->scale), bottom = ceil(box[3] * bed->scale);
    pave_result result = pv_check_size(context, "maps", (int64_t)pv_clamped(right - left, 0, 1e15),
                                       (int64_t)pv_clamped(bottom - top, 0, 1e15));
    *out = (pv_frame){ (int64_t)left, (int64_t)top, (int32_t)pv_clamped(right - left, 0, MOST_SIDE),
                       (int32_t)pv_clamped(bottom - top, 0, MOST_SIDE) };
    return result;
}
