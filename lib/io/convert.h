/* Pixels between what images hold and what files hold. */
#pragma once

#include "image/image.h"
#include "util/half.h"
#include "util/light.h"

/* Channels R, G, B and Y that are not alpha, of an image that is not data. */
int pv_is_colour(const pave_image *image, int32_t channel);

/* Rows from..to of an image as another type and encoding, colours multiplied by alpha if asked. Whole-number types
 * clamp to 0..1; NaN becomes 0 there. */
typedef struct pv_pixels {
    int32_t type, encoding, premultiplied;
} pv_pixels;
void pv_convert_rows(const pave_image *image, int32_t from, int32_t to, pv_pixels how, void *out);

/* Divides colours by alpha, in place; where alpha is 0 they stay. */
void pv_unpremultiply(pave_image *image);

/* Turns and mirrors *image as an EXIF orientation of 1..8 asks. On failure the image is freed. */
pave_result pv_orient(pave_context *context, pave_image **image, int32_t orientation);
