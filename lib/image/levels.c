/* Levels of a drawing: the greys that it was made from, which tell where between two pixels its edge is. */
#include "image/image.h"

#include <math.h>

enum { MOST_CUT = 255 * 256 - 1 };

/* Odd, so that no level is on it. */
int32_t pv_level_cut(double threshold)
{
    int32_t cut = (int32_t)floor(threshold * 255 * 256) | 1;
    return cut < MOST_CUT ? cut : MOST_CUT;
}

uint8_t pv_level_of(double value, int white, int32_t cut)
{
    int32_t level = value >= 1 ? 255 : value > 0 ? (int32_t)(value * 255 + 0.5) : 0, most = cut >> 8;
    if (white)
        return (uint8_t)(level > most ? level : most + 1);
    return (uint8_t)(level < most ? level : most);
}

static size_t size_of(const pave_image *image)
{
    return (size_t)image->width * (size_t)image->height;
}

pave_result pv_levels_new(pave_context *context, pave_image *drawing, int32_t cut)
{
    pave_result result = PAVE_OK;
    drawing->levels = pv_allocate(context, size_of(drawing), 1, &result);
    drawing->cut = cut;
    return result;
}

void pv_levels_tidy(pave_image *drawing)
{
    for (size_t i = 0; drawing->levels && i < size_of(drawing); i++)
        if (drawing->levels[i] != 0 && drawing->levels[i] != 255)
            return;
    pv_release(drawing->levels);
    drawing->levels = NULL;
    drawing->cut = 0;
}

pave_result pv_levels_split(pave_context *context, pave_image *image, int32_t cut)
{
    pave_result result = pv_levels_new(context, image, cut);
    if (result)
        return result;
    uint8_t *levels = image->pixels, *pixels = image->levels;
    for (size_t i = 0; i < size_of(image); i++)
        pixels[i] = 256 * levels[i] > cut ? 255 : 0;
    image->pixels = pixels;
    image->levels = levels;
    return PAVE_OK;
}
