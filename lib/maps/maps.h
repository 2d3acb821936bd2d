/* Maps from inside: stones as they lie in their bed, and what can be seen of them. */
#pragma once

#include "base/params.h"
#include "maps/quarry.h"
#include "stones/stones.h"
#include "util/polygon.h"

#include <pave/maps.h>

extern const pv_table pv_maps_table, pv_model_table;

enum { PV_MAP_GRID = 1000 }; /* corners are told in so many parts of a px of the maps */

/* The part of the plane that the maps show, px of the maps. */
typedef struct pv_frame {
    int64_t x, y;
    int32_t width, height;
} pv_frame;

struct pave_maps {
    pv_frame frame;
    double lowest, highest;  /* px */
    pave_maps_params params; /* with what was left to the library */
    pave_image *image[PAVE_MAP_COUNT];
};

/* How a stone's face is cut from its block: in voxels, `start + turn * (way from the anchor, px * texels)`. */
typedef struct pv_face {
    int32_t block;      /* -1: none; its colour is plain */
    int32_t tinted;
    double anchor[2];   /* px of the maps from the stone's origin */
    double turn[3][3];
    double start[3];
    double paint[3];    /* of a plain or tinted face: linear light */
    double contrast[3]; /* of a tinted face: less than 1 where the block's would be lighter than white */
    double brightness;
} pv_face;

/* A stone in its bed. */
typedef struct pv_laid {
    int64_t first;          /* of its corners */
    int32_t corners;
    int32_t number, part;   /* of the map PAVE_MAP_ID */
    int64_t x, y;           /* its origin in the plane, px of the maps */
    int32_t width, height;  /* px of the maps that it touches from there on */
    double middle[2];       /* of its corners, px of the maps from the origin */
    double lift, slope[2];  /* px; px a px */
    double roughness;
    pv_face face;
} pv_laid;

typedef struct pv_bed {
    const pave_stones *stones;
    pave_maps_params params;
    double scale, texels, half_side;
    double bevel, depth, sand, relief; /* px */
    int32_t samples;                   /* across a px of the maps */
    int32_t count;
    pv_laid *laid;
    pv_cell *corner; /* 1/1000 px of the maps from the stone's origin */
    int32_t blocks;
    pv_quarry *block;
    pv_quarry joint;         /* its values are NULL: a colour */
    double joint_paint[3];  /* linear light */
    int32_t colour_type;    /* of maps: PAVE_U8, PAVE_U16 or PAVE_F32 */
} pv_bed;

/* bed.c: vets what was given and lays the stones. */
pave_result pv_bed_open(pave_context *context, const pave_maps_input *input, const pave_maps_params *params,
                        pv_bed *out);
void pv_bed_close(pv_bed *bed);

/* The smallest frame around px of the drawing; PAVE_ERR_LIMIT if it is too large. */
pave_result pv_frame_of(pave_context *context, const pv_bed *bed, const double box[4], pv_frame *out);

/* A px of a face: its centre, px of the maps from the stone's origin and px under the face, and the ways to the next
 * px to the right and below. */
typedef struct pv_patch {
    double at[3], across[3], down[3];
} pv_patch;

/* face.c: draws how a stone is cut, `radius` px around; and cuts: the mean light of a px, and returns how much lighter
 * the block is there than its mean; how steep that makes it, to the right and down. */
void pv_face_draw(const pv_bed *bed, double radius, pv_laid *laid);
double pv_face_light(const pv_bed *bed, const pv_laid *laid, const pv_patch *patch, double light[3]);
void pv_face_slope(const pv_bed *bed, const pv_laid *laid, const pv_patch *patch, double slope[2]);

/* What there is of a stone in a px of the maps. */
typedef struct pv_cover {
    double share; /* of the px that it covers */
    int inside;   /* the px's centre lies in it */
    double inset; /* of the centre from the stone's edge, px of the maps; less than 0: beyond */
} pv_cover;

/* surface.c: x, y count px of the maps from the stone's origin. */
pv_cover pv_stone_cover(const pv_bed *bed, const pv_laid *laid, int32_t x, int32_t y);

/* How much lower than its face a rounded edge is, so far in, px. */
double pv_bevel_drop(double bevel, double inset);

/* The stone there, so far in from its edge: which px of its face; its colour and height. */
pv_patch pv_stone_patch(const pv_bed *bed, int32_t x, int32_t y, double inset);
double pv_stone_surface(const pv_bed *bed, const pv_laid *laid, const pv_patch *patch, double light[3]);

/* The plane of a stone's face, px. */
double pv_stone_plane(const pv_bed *bed, const pv_laid *laid, double x, double y);

/* The joints at a px of the plane: colour and height. */
double pv_joint_surface(const pv_bed *bed, int64_t x, int64_t y, double light[3]);

/* paint.c: what is seen from above. Arrays of the frame's px that are NULL are not wanted; heights are of the frame
 * and `rim` px around it. */
typedef struct pv_plate {
    pv_frame frame;
    int32_t rim;
    double bleed; /* stones' colours go so far beyond their edges, px of the maps, and are not mixed with joints' */
    void *colour;    /* three of the bed's colour_type */
    float *height;
    uint8_t *roughness, *mask;
    uint32_t *id;    /* number and part */
    uint8_t *grain;  /* normals of what stands out of plane faces, y up */
} pv_plate;

pave_result pv_plate_paint(pave_context *context, const pv_bed *bed, pv_plate *plate, double from, double to);

/* Linear light to what the bed's maps hold, `index` triples on. */
typedef struct pv_coder {
    int32_t type;
    uint8_t code[(1 << 14) + 1];
} pv_coder;

void pv_coder_begin(pv_coder *coder, int32_t type);
void pv_grain_put(double across, double down, uint8_t out[3]);
void pv_coder_put(const pv_coder *coder, void *out, int64_t index, const double light[3]);

/* shade.c: what follows from heights; `slope` px of the maps to a px of heights. */
typedef struct pv_shades {
    const float *height;
    int32_t width, height_px, rim; /* without the rim */
    double scale;
    int32_t up;
    uint16_t *normal;   /* NULL: not wanted */
    uint8_t *occlusion; /* NULL: not wanted */
    double reach;       /* px of the maps */
} pv_shades;

/* The unit normal of a slope to the right and down the picture, -1..1 as 0..1; `up`: y is up. */
void pv_normal_of(double across, double down, int32_t up, double out[3]);

int32_t pv_shade_rim(double reach);
pave_result pv_shade(pave_context *context, const pv_shades *shades, double from, double to);

/* A word as a number of 0 .. 1, and of -1 .. 1. */
static inline double pv_unit(uint32_t word)
{
    return (double)word / 4294967296.0;
}

static inline double pv_signed_unit(uint32_t word)
{
    return 2 * pv_unit(word) - 1;
}

static inline double pv_clamped(double value, double least, double most)
{
    return value > least ? value < most ? value : most : least; /* NaN: least */
}

static inline double pv_luminance(const double light[3])
{
    return 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
}
