/* Maps: stones are laid in their bed, seen from above, and shaded by their heights. */
#include "maps/maps.h"

#include "image/image.h"
#include "util/fixed.h"

#include <math.h>
#include <string.h>

static const pave_maps_params default_params = PAVE_MAPS_PARAMS_INIT;
static const pave_maps_input default_input = PAVE_MAPS_INPUT_INIT;

static const pv_param rows[] = {
    PV_REAL(pave_maps_params, scale, "", 1.0 / 64, 64, "px of the maps to one of the drawing"),
    PV_WINDOW(pave_maps_params, window, "the part that is mapped, px of the drawing; as it is in the whole"),
    PV_SEED(pave_maps_params, seed, "another seed, other faces"),
    PV_REAL(pave_maps_params, texels, "", 0, 64, "px of a texture, or voxels, to one px of the drawing; 0: as scale"),
    PV_CHOICE(pave_maps_params, turns, "any|quarter|none", "how the stones' faces are turned in their texture"),
    PV_CHOICE(pave_maps_params, repeat, "auto|wrap|mirror",
              "beyond the border of a texture or volume; auto: its other side if that fits"),
    PV_CHOICE(pave_maps_params, tint, "auto|no|yes",
              "textures take the stones' colours; auto: if there are fewer of them than colours"),
    PV_REAL(pave_maps_params, variation, "", 0, 1, "how much lighter or darker a stone may be"),
    PV_REAL(pave_maps_params, bevel, "half sides", 0, 4, "radius of the rounded edges"),
    PV_REAL(pave_maps_params, tilt, "degrees", 0, 45, "most that a stone is tilted"),
    PV_REAL(pave_maps_params, lift, "half sides", 0, 4, "most that a stone is raised or lowered"),
    PV_REAL(pave_maps_params, relief, "half sides", -4, 4, "how much higher white is than black in a face"),
    PV_REAL(pave_maps_params, joint_depth, "half sides", 0, 16, "how far the joints lie under the faces"),
    PV_REAL(pave_maps_params, joint_sand, "half sides", 0, 4, "how rough the joints are"),
    { "joint_colour", PAVE_PARAM_PALETTE, "", 0, 256, NULL, "colour of the joints; none: grey sand",
      offsetof(pave_maps_params, joint_colour) },
    PV_REAL(pave_maps_params, roughness, "", 0, 1, "of stones"),
    PV_REAL(pave_maps_params, roughness_variation, "", 0, 1, "how far a stone's own may be off that"),
    PV_REAL(pave_maps_params, joint_roughness, "", 0, 1, "of joints"),
    PV_REAL(pave_maps_params, occlusion, "half sides", 0, 16, "how far is looked for what shades a point; 0: not"),
    PV_CHOICE(pave_maps_params, normal, "up|down", "where y of a normal points: OpenGL and glTF, or Direct3D"),
    PV_REAL(pave_maps_params, half_side, "px", 0, 4096, "half the side of a mean stone; 0: as they were laid"),
};

const pv_table pv_maps_table = PV_TABLE("maps", default_params, rows);

void pave_maps_params_init(pave_maps_params *params, size_t size)
{
    pv_params_init(&pv_maps_table, params, size);
}

void pave_maps_input_init(pave_maps_input *input, size_t size)
{
    const pv_table table = { "maps input", sizeof default_input, &default_input, NULL, 0 };
    pv_params_init(&table, input, size);
}

/* One map: its channels and what they are called. */
typedef struct kind {
    int32_t channels, type; /* type 0: the bed's */
    const char *names;
} kind;

static const kind kinds[PAVE_MAP_COUNT] = {
    [PAVE_MAP_COLOUR] = { 3, 0, NULL },         [PAVE_MAP_HEIGHT] = { 1, PAVE_F32, NULL },
    [PAVE_MAP_NORMAL] = { 3, PAVE_U16, NULL },  [PAVE_MAP_ROUGHNESS] = { 1, PAVE_U8, NULL },
    [PAVE_MAP_OCCLUSION] = { 1, PAVE_U8, NULL }, [PAVE_MAP_MASK] = { 1, PAVE_U8, NULL },
    [PAVE_MAP_ID] = { 2, PAVE_U32, "id,part" },
};

static pave_result new_images(pave_context *context, const pv_bed *bed, pave_maps *maps)
{
    pave_result result = PAVE_OK;
    for (int i = 0; i < PAVE_MAP_COUNT && !result; i++) {
        pave_image_params shape = PAVE_IMAGE_PARAMS_INIT;
        shape.width = maps->frame.width;
        shape.height = maps->frame.height;
        shape.channels = kinds[i].channels;
        shape.type = kinds[i].type ? kinds[i].type : bed->colour_type;
        shape.encoding = kinds[i].type ? PAVE_DATA : shape.type == PAVE_F32 ? PAVE_LINEAR : PAVE_DISPLAY;
        shape.names = kinds[i].names;
        result = pv_image_new(context, &shape, &maps->image[i]);
    }
    return result;
}

/* The window asked for, or that of the stones. */
static pave_result find_frame(pave_context *context, const pv_bed *bed, pave_maps *maps)
{
    const int32_t *w = bed->params.window;
    const pave_stones *s = bed->stones;
    int given = w[2] > 0 && w[3] > 0;
    if (!given && (w[2] || w[3]))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the window %d,%d,%d,%d has no area", w[0], w[1], w[2], w[3]);
    double x = given ? w[0] : s->x, y = given ? w[1] : s->y;
    const double box[4] = { x, y, x + (given ? w[2] : s->width), y + (given ? w[3] : s->height) };
    return pv_frame_of(context, bed, box, &maps->frame);
}

/* As far as parameters let heights be. */
static void find_range(const pv_bed *bed, pave_maps *maps)
{
    const pave_maps_params *p = &bed->params;
    int32_t cosine, sine;
    pv_turn((int32_t)floor(p->tilt / 360 * 65536 + 0.5), &cosine, &sine);
    maps->lowest = -bed->depth - bed->sand;
    maps->highest = (p->lift + 2.0 * sine / cosine + fabs(p->relief)) * bed->half_side;
}

/* The part of the heights that is not rim. */
static void crop(const float *from, int32_t rim, pave_image *to)
{
    int64_t row = to->width + 2 * (int64_t)rim;
    for (int64_t y = 0; y < to->height; y++)
        memcpy((float *)to->pixels + y * to->width, from + (y + rim) * row + rim, (size_t)to->width * sizeof *from);
}

static pave_result draw(pave_context *context, const pv_bed *bed, pave_maps *maps)
{
    pave_result result = PAVE_OK;
    double reach = bed->params.occlusion * bed->half_side * bed->scale;
    pave_image **image = maps->image;
    pv_plate plate = { .frame = maps->frame, .rim = pv_shade_rim(reach), .colour = image[PAVE_MAP_COLOUR]->pixels,
                       .roughness = image[PAVE_MAP_ROUGHNESS]->pixels, .mask = image[PAVE_MAP_MASK]->pixels,
                       .id = image[PAVE_MAP_ID]->pixels };
    size_t width = (size_t)plate.frame.width + 2 * (size_t)plate.rim;
    plate.height = pv_allocate(context, width * sizeof(float), (size_t)plate.frame.height + 2 * (size_t)plate.rim,
                               &result);
    if (!result)
        result = pv_plate_paint(context, bed, &plate, 0.05, 0.8);
    const pv_shades shades = { plate.height, maps->frame.width, maps->frame.height, plate.rim, bed->scale,
                               bed->params.normal == PAVE_NORMAL_UP, image[PAVE_MAP_NORMAL]->pixels,
                               image[PAVE_MAP_OCCLUSION]->pixels, reach };
    if (!result)
        result = pv_shade(context, &shades, 0.8, 1);
    if (!result)
        crop(plate.height, plate.rim, image[PAVE_MAP_HEIGHT]);
    pv_release(plate.height);
    return result;
}

static pave_result make(pave_context *context, const pave_maps_input *input, const pave_maps_params *params,
                        pave_maps *maps)
{
    pv_bed bed;
    pave_result result = pv_bed_open(context, input, params, &bed);
    if (!result)
        result = find_frame(context, &bed, maps);
    if (!result)
        result = new_images(context, &bed, maps);
    if (!result) {
        maps->params = bed.params;
        maps->params.half_side = bed.half_side;
        maps->params.texels = bed.texels;
        if (!maps->params.window[2])
            memcpy(maps->params.window, (int32_t[4]){ bed.stones->x, bed.stones->y, bed.stones->width,
                                                      bed.stones->height }, sizeof maps->params.window);
        find_range(&bed, maps);
        result = draw(context, &bed, maps);
    }
    pv_bed_close(&bed);
    return result;
}

pave_result pave_maps_create(pave_context *context, const pave_maps_input *given_input,
                             const pave_maps_params *given, pave_maps **out)
{
    pave_maps_params params;
    pave_maps_input input;
    if (out)
        *out = NULL;
    if (!context || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_maps_table, given, &params);
    if (!result)
        result = pv_struct_read(context, "maps input", &default_input, sizeof input, given_input, &input);
    if (result)
        return result;
    pv_call outer = pv_call_begin(context, "maps", 0, 1);
    *out = pv_allocate_zeroed(context, 1, sizeof **out, &result);
    if (!result)
        result = make(context, &input, &params, *out);
    if (result)
        pave_maps_free(out);
    pv_call_end(context, outer);
    return result;
}

void pave_maps_free(pave_maps **maps)
{
    if (!maps || !*maps)
        return;
    for (int i = 0; i < PAVE_MAP_COUNT; i++)
        pave_image_free(&(*maps)->image[i]);
    pv_release(*maps);
    *maps = NULL;
}

const pave_image *pave_maps_image(const pave_maps *maps, int32_t map)
{
    return map >= 0 && map < PAVE_MAP_COUNT ? maps->image[map] : NULL;
}

int64_t pave_maps_x(const pave_maps *maps) { return maps->frame.x; }
int64_t pave_maps_y(const pave_maps *maps) { return maps->frame.y; }
double pave_maps_lowest(const pave_maps *maps) { return maps->lowest; }
double pave_maps_highest(const pave_maps *maps) { return maps->highest; }
