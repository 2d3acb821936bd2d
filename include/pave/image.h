/* Images: what drawings, fields and textures are stored in. */
#ifndef PAVE_IMAGE_H
#define PAVE_IMAGE_H

#include <pave/params.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pave_image pave_image;

/* How a channel is stored. Integers stand for 0..1 except PAVE_U32, which is a plain count (labels). */
enum { PAVE_U8 = 1, PAVE_U16 = 2, PAVE_U32 = 3, PAVE_F16 = 4, PAVE_F32 = 5 };

/* What a value means: as shown on a display (sRGB-coded), proportional to light, or data. */
enum { PAVE_DISPLAY = 0, PAVE_LINEAR = 1, PAVE_DATA = 2 };

typedef struct pave_image_params {
    size_t size;
    int32_t width;    /* px, from 1 */
    int32_t height;   /* px, from 1 */
    int32_t channels; /* 1 to 32 */
    int32_t type;     /* PAVE_U8 ... PAVE_F32 */
    int32_t encoding; /* PAVE_DISPLAY ... */
    int32_t alpha;    /* index of the alpha channel, not premultiplied; -1: none */
    const char *names; /* channel names, "R,G,B"; NULL: Y, YA, RGB or RGBA by the number of channels; copied */
} pave_image_params;

#define PAVE_IMAGE_PARAMS_INIT { sizeof(pave_image_params), 0, 0, 1, PAVE_U8, PAVE_DISPLAY, -1, NULL }

PAVE_API void pave_image_params_init(pave_image_params *params, size_t size);

/* Copies `pixels` into a new image: rows from the top, pixels from the left, channels interleaved, no padding. NULL
 * pixels give an image of zeros. Cost: one pass. */
PAVE_API pave_result pave_image_create(pave_context *context, const pave_image_params *params, const void *pixels,
                                       pave_image **out);
PAVE_API void pave_image_free(pave_image **image);

PAVE_API int32_t pave_image_width(const pave_image *image);
PAVE_API int32_t pave_image_height(const pave_image *image);
PAVE_API int32_t pave_image_channels(const pave_image *image);
PAVE_API int32_t pave_image_type(const pave_image *image);
PAVE_API int32_t pave_image_encoding(const pave_image *image);
PAVE_API int32_t pave_image_alpha(const pave_image *image);

/* Name of a channel; NULL if there is no such channel. */
PAVE_API const char *pave_image_channel_name(const pave_image *image, int32_t channel);

/* The pixels, laid out as in pave_image_create. */
PAVE_API const void *pave_image_pixels(const pave_image *image);

typedef struct pave_threshold_params {
    size_t size;
    double threshold; /* display value from which a pixel is white, 0..1 */
    int32_t invert;   /* 1: swap black and white */
} pave_threshold_params;

#define PAVE_THRESHOLD_PARAMS_INIT { sizeof(pave_threshold_params), 0.5, 0 }

PAVE_API void pave_threshold_params_init(pave_threshold_params *params, size_t size);

/* Turns any image into a drawing: one PAVE_U8 channel, 0 (black) or 255 (white). A pixel is laid over white by its
 * alpha, colours become luma (Rec. 601, on display values), linear light is coded for display first; images named
 * otherwise than R, G and B use their first channel. NaN counts as black. If there were greys the drawing remembers
 * them, to a 255th, for best mode: between pixels of a smooth edge the contour is where they cross the threshold. Cost:
 * one pass. */
PAVE_API pave_result pave_image_threshold(pave_context *context, const pave_image *image,
                                          const pave_threshold_params *params, pave_image **out);

/* Widens what is thin in a drawing (one PAVE_U8 channel, as from pave_image_threshold or pave_image_quantise) to about
 * `least` px, 0..200, in place of what is around it: a line less than so wide comes out within one px of that, tips get
 * blunt, corners of what is wide stay as they are. Where two thin features touch both keep half of the room. With
 * `periodic` 1 the drawing is looked at as repeating. Each pixel depends on those within 2 least + 6 px. Cost: a pass
 * of `least` steps a pixel; 8 bytes a pixel. */
PAVE_API pave_result pave_image_widen(pave_context *context, const pave_image *drawing, double least, int32_t periodic,
                                      pave_image **out);

/* How an image becomes a drawing of more colours than black and white. */
typedef struct pave_palette_params {
    size_t size;
    int32_t colours;      /* how many to find in the image; 0: black and white, by threshold */
    pave_palette palette; /* or those given: then nothing is looked for, whatever `colours` says */
} pave_palette_params;

#define PAVE_PALETTE_PARAMS_INIT { sizeof(pave_palette_params), 0, { 0, { 0 } } }

PAVE_API void pave_palette_params_init(pave_palette_params *params, size_t size);

/* Finds the colours of a flat-coloured image, at most `colours` (2..256), dark ones first: k-means in OKLab (Ottosson
 * 2020) on whole numbers, so that every machine and any number of threads find the same. An entry is the very colour
 * that half of its pixels have; if there is none, the mean, in linear light, of those close to the most frequent one,
 * or of all. Pixels are laid over white by their alpha. There may be fewer entries than asked for. Cost: one pass, and
 * up to 64 MiB for a photograph. */
PAVE_API pave_result pave_palette_find(pave_context *context, const pave_image *image, int32_t colours,
                                       pave_palette *out);

/* Turns any image into a drawing in the colours of a palette: one PAVE_U8 channel, the entry of each pixel. It is the
 * nearest one in OKLab, except that pixels on the way from one entry to another, as smooth edges have them, go to the
 * nearer of the two that are found within 3 px, and not to a third entry that happens to lie between; up to 22 entries
 * such ways are known. A line of one px in a colour between those on both sides of it counts as such an edge. Pixels
 * are laid over white by their alpha. Cost: two passes. */
PAVE_API pave_result pave_image_quantise(pave_context *context, const pave_image *image, const pave_palette *palette,
                                         pave_image **out);

/* The palette of a drawing; its count is 0 for one in black and white, and for other images. */
PAVE_API const pave_palette *pave_image_palette(const pave_image *image);

#ifdef __cplusplus
}
#endif

#endif
