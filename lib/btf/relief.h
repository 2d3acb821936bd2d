/* A periodic relief of stone and what it is made of: the scene that the generator photographs. */
#pragma once

#include "btf/btf.h"

enum { PV_MATERIALS = 16 };

/* Lambert below GGX (Walter et al. 2007), roughness along x and along y. */
typedef struct pv_material {
    float diffuse[3];
    float rough_x, rough_y;
    float mirror; /* reflectance at normal incidence */
} pv_material;

/* Lengths in texels. Grid points lie `spacing` apart, x fastest; the grid repeats. */
typedef struct pv_relief {
    int32_t side, texels;
    float spacing, lowest, highest;
    float *height;
    float *dirt;         /* 0 clean .. 1 dusty: paler and rougher */
    uint8_t *label;      /* of the material */
    float (*normal)[3];
    pv_material materials[PV_MATERIALS];
    int32_t material_count;
} pv_relief;

pave_result pv_relief_create(pave_context *context, const pave_btf_synthesis_params *params, pv_relief *out);
void pv_relief_free(pv_relief *relief);

/* Height at a place, in grid units; bilinear. */
float pv_relief_height(const pv_relief *relief, float x, float y);

/* Goes from (x, y, z), in grid units, along `step` (a vector; the height in texels, x and y in grid units) until it is
 * below the relief or above its highest point. 1 and the place if it hits. */
int pv_relief_hit(const pv_relief *relief, const float from[3], const float direction[3], float place[2]);
