/* The relief under all lights: what reaches each of its points, and what a texel sends to each view. */
#pragma once

#include "btf/relief.h"

typedef struct pv_scene {
    pave_btf_synthesis_params params;
    pv_relief relief;
    int32_t directions;
    float (*toward)[3]; /* directions in the grid's frame: x to the right, y down, z up */
    float *shade;       /* [point][light]: heights below which the point would lie in shadow, texels */
    uint16_t *bounced;  /* [point][light][3], halves: irradiance from other parts of the relief; NULL: none */
} pv_scene;

/* Casts shadows and bounces light. Progress of 0..share of the stage. */
pave_result pv_scene_create(pave_context *context, const pave_btf_synthesis_params *params,
                            const pave_direction *directions, int32_t count, double share, pv_scene **out);
void pv_scene_free(pv_scene **scene);

enum { PV_MOST_LIGHTS = 256 };

/* What a texel sends to one view under all lights, [light][3], and to all views: its ABRDF. Any thread. */
void pv_scene_view(const pv_scene *scene, int64_t texel, int32_t view, float *out);
void pv_scene_texel(const pv_scene *scene, int64_t texel, float *out);

/* `rays` places that a point sees, spread by the cosine: their indices, -1 for the sky. */
void pv_scene_sight(const pv_scene *scene, int32_t point, int32_t *seen);
