/* Images from inside. */
#pragma once

#include "base/params.h"

#include <pave/image.h>

enum { PV_MOST_CHANNELS = 32, PV_CHANNEL_NAME = 64 };

extern const pv_table pv_threshold_table, pv_palette_table;

/* Where pixels lie that are part of a larger plane. */
typedef struct pv_place {
    int32_t x, y;          /* of the first pixel in the plane, px */
    int32_t width, height; /* of the plane, px */
} pv_place;

/* Is a part of the plane, of this size, all of it? */
static inline int pv_is_whole(const pv_place *place, int32_t width, int32_t height)
{
    return !place->x && !place->y && width == place->width && height == place->height;
}

struct pave_image {
    int32_t width, height, channels, type, encoding, alpha;
    pv_place place;
    char names[PV_MOST_CHANNELS][PV_CHANNEL_NAME];
    void *pixels;
    uint8_t *levels;      /* of a drawing in black and white: the greys it was made from; NULL: there were none */
    int32_t cut;          /* with levels: white where 256 times them is more than that, which is odd */
    pave_palette palette; /* of a drawing whose pixels are its entries, */
    uint64_t hash;        /* and its name */
};

/* A part of the plane, wherever it lies, from a drawing that is the whole of it and repeats beyond it. */
pave_result pv_image_repeat(pave_context *context, const pave_image *drawing, int32_t x, int32_t y, int32_t width,
                            int32_t height, pave_image **out);

/* Copies such a part of pixels of `size` bytes from a plane of pixels. */
void pv_repeat(const pv_place *plane, const void *pixels, size_t size, int32_t width, int32_t height, void *out);

/* widen.c: how far around a pixel of a drawing widened to so many px it depends on it, px; a part of a drawing. */
int32_t pv_widen_reach(int32_t least);
pave_result pv_image_crop(pave_context *context, const pave_image *drawing, pv_place part, pave_image **out);

/* levels.c: the cut for a threshold, display value; the level of a display value on its side of the cut. */
int32_t pv_level_cut(double threshold);
uint8_t pv_level_of(double value, int white, int32_t cut);

/* Room for levels beside the pixels of a drawing; they are the caller's to write. */
pave_result pv_levels_new(pave_context *context, pave_image *drawing, int32_t cut);

/* Drops levels that say no more than the pixels do. */
void pv_levels_tidy(pave_image *drawing);

/* Makes the pixels of an image its levels, and those by the cut its pixels. */
pave_result pv_levels_split(pave_context *context, pave_image *image, int32_t cut);

/* Bytes of one value of a type; 0 for an unknown type. */
size_t pv_type_bytes(int32_t type);

/* A new image whose pixels are not yet written (they are the caller's to fill before anyone else sees the image). All
 * limits are checked first. */
pave_result pv_image_new(pave_context *context, const pave_image_params *params, pave_image **out);

/* Is there a channel of this name, and where: -1 if not. */
int32_t pv_image_channel(const pave_image *image, const char *name);

/* One value as a number: 0..1 for PAVE_U8 and PAVE_U16, as stored for the others. */
double pv_image_value(const pave_image *image, int64_t index);

/* Checks a width and height against the context's limits before anything is made of that size. `what` begins the
 * sentence of a failure: "drawing.png". */
pave_result pv_check_size(pave_context *context, const char *what, int64_t width, int64_t height);
