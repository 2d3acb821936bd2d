/* The colours of a pavement, the same in the SVG and in the picture. */
#pragma once

#include "stones/stones.h"

typedef struct pv_colour { uint8_t r, g, b; } pv_colour;

static const pv_colour pv_grout = { 0x8C, 0x85, 0x79 };

/* Basalt for black, limestone for white, plain grey between. */
static inline pv_colour pv_stone_colour(uint8_t value)
{
    if (value == 0)
        return (pv_colour){ 0x1F, 0x1D, 0x1B };
    if (value == 255)
        return (pv_colour){ 0xF4, 0xF1, 0xEA };
    return (pv_colour){ value, value, value };
}

/* What a stone with this value is painted with. */
static inline pv_colour pv_laid_colour(const pave_stones *stones, uint8_t value)
{
    const uint8_t *rgb = stones->palette.palette.rgb + 3 * value;
    return stones->palette.palette.count ? (pv_colour){ rgb[0], rgb[1], rgb[2] } : pv_stone_colour(value);
}
