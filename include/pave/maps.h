/* Maps and models: what a renderer takes of a laid pavement.
 *
 * Every stone gets a face of its own, cut from a texture or from a volume of stone at a place and in a direction drawn
 * for this stone alone, rounded at its edge, a little higher or lower than its neighbours and a little tilted. From
 * these surfaces and the joints between them come maps (colour, height, normal ...), and a model of solid stones.
 *
 * Same      bytes for any number of threads. A pixel is a function of where it is in the plane, the stones, parameters
 *           and seed: maps of a window are the crop of those of the whole, and maps of a plane that repeats tile.
 * Units     px are those of the drawing that the stones lie in, unless "px of the maps" is said; h is half the side of
 *           a mean stone. Heights are px too, 0 at a face that is neither lifted nor tilted, up is positive.
 */
#ifndef PAVE_MAPS_H
#define PAVE_MAPS_H

#include <pave/image.h>
#include <pave/solid.h>
#include <pave/stones.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pave_maps pave_maps;
typedef struct pave_model pave_model;

/* How faces are turned, each by itself. */
enum {
    PAVE_TURNS_ANY = 0,     /* by any angle; in a volume, to any plane */
    PAVE_TURNS_QUARTER = 1, /* by quarter turns: texels stay texels where texels and scale agree */
    PAVE_TURNS_NONE = 2     /* not at all; in a volume, planes across z */
};

/* What is beyond the border of a texture or volume. */
enum {
    PAVE_REPEAT_AUTO = 0,  /* along each axis: its other side if that fits, else its mirror image */
    PAVE_REPEAT_WRAP = 1,  /* its other side, as what pave_tiling_create and periodic volumes make wants it */
    PAVE_REPEAT_MIRROR = 2 /* its mirror image; faces that fit are cut where they do not reach it */
};

/* Whether stones have the colours of the pavement (each texture's mean becomes the stone's colour), or of textures. */
enum {
    PAVE_TINT_AUTO = 0, /* yes where there are fewer textures than colours of stones */
    PAVE_TINT_NO = 1,
    PAVE_TINT_YES = 2
};

/* Where the second component of a normal points in the picture: up as in OpenGL and glTF, or down as in Direct3D. */
enum { PAVE_NORMAL_UP = 0, PAVE_NORMAL_DOWN = 1 };

typedef struct pave_maps_params {
    size_t size;
    double scale;               /* px of the maps to one of the drawing */
    int32_t window[4];          /* x, y, width, height of the part that is mapped, px; width 0: that of the stones */
    uint64_t seed;              /* another seed, other faces */
    double texels;              /* px of a texture, or voxels, to one px; 0: as scale */
    int32_t turns;              /* PAVE_TURNS_ */
    int32_t repeat;             /* PAVE_REPEAT_ */
    int32_t tint;               /* PAVE_TINT_ */
    double variation;           /* how much lighter or darker a stone may be than its colour, 0..1 */
    double bevel;               /* radius of the rounded edges, h */
    double tilt;                /* most that a stone is tilted, degrees; its rim moves by no more than 2 h would */
    double lift;                /* most that a stone is raised or lowered, h */
    double relief;              /* how much higher white is than black in a face, h; less than 0: lower */
    double joint_depth;         /* how far the joints lie under the faces, h */
    double joint_sand;          /* how rough the joints are, h */
    pave_palette joint_colour;  /* one colour; none: grey sand */
    double roughness;           /* of stones, 0 smooth .. 1 */
    double roughness_variation; /* how far a stone's own may be off that */
    double joint_roughness;     /* of joints */
    double occlusion;           /* how far around a point is looked at for what shades it, h; 0: all is open */
    int32_t normal;             /* PAVE_NORMAL_ */
    double half_side;           /* h, px; 0: the one that the stones were laid with, or else the root of the window's
                                   area by stones, halved (Eq. 1) */
} pave_maps_params;

#define PAVE_MAPS_PARAMS_INIT \
    { sizeof(pave_maps_params), 4.0, { 0, 0, 0, 0 }, 1, 0.0, PAVE_TURNS_ANY, PAVE_REPEAT_AUTO, PAVE_TINT_AUTO, 0.08, \
      0.25, 1.5, 0.05, 0.05, 0.3, 0.03, { 0, { 0 } }, 0.7, 0.1, 0.95, 2.0, PAVE_NORMAL_UP, 0.0 }

PAVE_API void pave_maps_params_init(pave_maps_params *params, size_t size);

/* What faces are cut from: textures or volumes, or neither for plain colour. One serves for all stones; else there is
 * one for each colour of stone: black, white, or the entries of the palette in order. If there are fewer, they serve in
 * turn. Images: grey or R, G, B; 8 or 16 bits, half or float; alpha is not looked at. Volumes: the same, of one or
 * three channels, every voxel with a value. */
typedef struct pave_maps_input {
    size_t size;
    const pave_stones *stones;
    const pave_image *const *textures;
    int32_t texture_count; /* 0 to 256 */
    int32_t volume_count;  /* 0 to 256 */
    const pave_volume *const *volumes;
    const pave_image *joint; /* texture of the joints, from the plane's origin on; NULL: joint_colour */
} pave_maps_input;

#define PAVE_MAPS_INPUT_INIT { sizeof(pave_maps_input), NULL, NULL, 0, 0, NULL, NULL }

PAVE_API void pave_maps_input_init(pave_maps_input *input, size_t size);

/* The maps. Whole numbers stand for 0..1. */
enum {
    PAVE_MAP_COLOUR = 0,    /* R, G, B: display values of 8 bits, of 16 if a texture has more, or linear light as floats
                               if one is of floats; the light of stones and joints mixed by the area they cover */
    PAVE_MAP_HEIGHT = 1,    /* float, px; mixed alike */
    PAVE_MAP_NORMAL = 2,    /* x, y, z of 16 bits, -1..1 as 0..1: of the slope between the neighbours of a pixel */
    PAVE_MAP_ROUGHNESS = 3, /* 8 bits */
    PAVE_MAP_OCCLUSION = 4, /* 8 bits: how much of the sky is seen, weighted by the cosine (16 directions) */
    PAVE_MAP_MASK = 5,      /* 8 bits: share of the pixel that stones cover, exactly */
    PAVE_MAP_ID = 6,        /* two whole numbers (PAVE_U32), "id" and "part", of the stone under the pixel's centre: its
                               number in the plane (pave_stones_sites) + 1, 0 for joints; and which it is, 0, 1 ..., of
                               several polygons of that number. Copies in a plane that repeats are the same stone */
    PAVE_MAP_COUNT = 7
};

/* Makes the maps. Bilinear in linear light; where a texture has n texels to a pixel of the maps, the mean of n x n
 * samples. With PAVE_TURNS_QUARTER or NONE, texels equal to scale and both whole, pixels are those of the texture, bit
 * for bit (without variation and tint).
 * Errors: PAVE_ERR_ARGUMENT without stones, for more textures than colours, textures with values that are no numbers,
 * volumes with voxels without a value, or a plane that repeats whose period is not a whole number of px of the maps;
 * PAVE_ERR_UNSUPPORTED for textures of PAVE_U32 (labels) and volumes of two channels, or more than three;
 * PAVE_ERR_LIMIT before anything is made that is beyond the context's limits.
 * Cost: about 0.4 us a pixel on one core; 30 bytes a pixel. Writing PNG files of them takes twice as long. */
PAVE_API pave_result pave_maps_create(pave_context *context, const pave_maps_input *input,
                                      const pave_maps_params *params, pave_maps **out);
PAVE_API void pave_maps_free(pave_maps **maps);

/* One of the maps, PAVE_MAP_; it lives as long as the maps do. NULL if there is no such map. */
PAVE_API const pave_image *pave_maps_image(const pave_maps *maps, int32_t map);

/* Corner of the maps in the plane, px of the maps; and the least and greatest height that the parameters allow, px. */
PAVE_API int64_t pave_maps_x(const pave_maps *maps);
PAVE_API int64_t pave_maps_y(const pave_maps *maps);
PAVE_API double pave_maps_lowest(const pave_maps *maps);
PAVE_API double pave_maps_highest(const pave_maps *maps);

/* How a model gets its colours. */
enum {
    PAVE_SKIN_MAPS = 0,    /* from pictures of all faces and sides, cut as for the maps */
    PAVE_SKIN_VERTICES = 1 /* one at each vertex: small, for pavements seen from afar */
};

typedef struct pave_model_params {
    size_t size;
    double pixels_per_metre; /* px of the drawing */
    double thickness;        /* of the stones, from their faces down, h; at least as deep as the joints */
    int32_t segments;        /* of the rounding of an edge; 0: sharp edges */
    int32_t skin;            /* PAVE_SKIN_ */
    int32_t ground;          /* 1: with a floor at the height of the joints */
} pave_model_params;

#define PAVE_MODEL_PARAMS_INIT { sizeof(pave_model_params), 100.0, 1.0, 2, PAVE_SKIN_MAPS, 1 }

PAVE_API void pave_model_params_init(pave_model_params *params, size_t size);

/* Makes a model: every stone a closed solid, each once, also those that hang over the window or over the border of a
 * plane that repeats; params->window and normal are not looked at. Sides go on where faces end: in a volume they are
 * cut from it, a texture is folded down over the edge. x is to the right, y up, z down the drawing, in metres from
 * the middle of the window. Edges are rounded as in the maps, but less where a stone is too narrow.
 * Stones that cross themselves or are thinner than 1/100 px are left out, with a warning.
 * Errors: as pave_maps_create; PAVE_ERR_FORMAT if no stone is left; PAVE_ERR_LIMIT for more vertices than 32-bit
 * indices tell apart, or a stone larger than 16000 px. Cost: 1.5 KB a stone of four corners, and with maps 40 bytes a
 * pixel. */
PAVE_API pave_result pave_model_create(pave_context *context, const pave_maps_input *input,
                                       const pave_maps_params *maps, const pave_model_params *params,
                                       pave_model **out);
PAVE_API void pave_model_free(pave_model **model);

/* Vertices: x, y, z; and unit normals. Of PAVE_SKIN_MAPS u, v of the pictures, (0, 0) at the top left, else NULL; of
 * PAVE_SKIN_VERTICES r, g, b of linear light, else NULL. Triangles are counter-clockwise from outside. */
PAVE_API int64_t pave_model_vertex_count(const pave_model *model);
PAVE_API const float *pave_model_positions(const pave_model *model);
PAVE_API const float *pave_model_normals(const pave_model *model);
PAVE_API const float *pave_model_coordinates(const pave_model *model);
PAVE_API const float *pave_model_colours(const pave_model *model);
PAVE_API int64_t pave_model_triangle_count(const pave_model *model);
PAVE_API const uint32_t *pave_model_triangles(const pave_model *model);

/* Where each stone's triangles begin: stones + 1 numbers, in the order of the stones; after the last stone's come the
 * two of the floor, if there is one. */
PAVE_API int32_t pave_model_stone_count(const pave_model *model);
PAVE_API const int64_t *pave_model_starts(const pave_model *model);

/* The pictures of PAVE_SKIN_MAPS: faces above, the floor below them, and then the sides, in strips. */
enum {
    PAVE_SKIN_COLOUR = 0,  /* R, G, B, display values of 8 bits */
    PAVE_SKIN_SURFACE = 1, /* occlusion, roughness, 0: 8 bits */
    PAVE_SKIN_NORMAL = 2,  /* of what stands out by `relief`, y up, 8 bits; NULL where nothing does */
    PAVE_SKIN_COUNT = 3
};
PAVE_API const pave_image *pave_model_picture(const pave_model *model, int32_t picture);

#ifdef __cplusplus
}
#endif

#endif
