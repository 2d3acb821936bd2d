/* Images read part by part: into an image, or into a drawing with one bit a pixel however large it is. */
#pragma once

#include "cvd/cvd.h"
#include "image/palette.h"

/* What a drawing may take of memory while it is read and laid. */
typedef struct pv_room {
    int64_t bytes;      /* a bitmap takes an eighth of that at most; a larger one goes into an unnamed file */
    const char *beside; /* which lies beside this one */
} pv_room;

/* What a file is read as: an image, or a histogram, or else a drawing, in codes if there is a book for them. */
typedef struct pv_target {
    pave_image **image;
    pv_histogram *histogram;
    const pave_threshold_params *threshold;
    const pv_codebook *book;
    const pv_room *room;
    pv_bitmap *drawing;
} pv_target;

/* An image file that can be read in parts: each begins at a multiple of `columns` and `rows` and ends at one or at the
 * border. */
typedef struct pv_blocks {
    const char *path;
    pave_image_params shape;
    int32_t columns, rows;
    int32_t premultiplied; /* its colours are, by alpha */
    int64_t at_once;       /* bytes that reading takes, whatever the part */
    double begun;          /* share of the time that is over */
    pave_result (*read)(void *user, pv_rect part, void *pixels);
    void *user;
} pv_blocks;

pave_result pv_blocks_read(pave_context *context, const pv_blocks *blocks, const pv_target *target);

/* Reads an image file that is open, whatever its format. */
struct pv_input;
pave_result pv_image_read_input(pave_context *context, struct pv_input *input, const pv_target *target);

/* Reads an image file as a drawing: codes of the palette, or by the threshold if that is
 * empty or NULL. */
pave_result pv_drawing_read(pave_context *context, const char *path, const pave_threshold_params *threshold,
                            const pave_palette *palette, const pv_room *room, pv_bitmap *out);

/* Finds the palette of an image file. */
pave_result pv_palette_read(pave_context *context, const char *path, int32_t colours, const pv_room *room,
                            pave_palette *out);
