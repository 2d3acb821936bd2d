// A site as a rectangle that holds all places up to a margin from it: its box grown by it, or a pyramid as high. One
// instance a site, whose index is its label.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "parameters.glsl"

layout(constant_id = 1) const int METRIC = 0;

layout(location = 0) in ivec4 site_place;
layout(location = 1) in ivec2 site_half;

layout(location = 0) flat out ivec4 place; // from the corner of the block
layout(location = 1) flat out ivec3 shape; // half_x, half_y, index

void main()
{
    vec2 side = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 2.0 - 1.0;
    vec2 extent = METRIC == 0 ? vec2(site_half + grown()) : float(grown()) * 65536.0 / vec2(site_half);
    vec2 w = side * extent, turn = vec2(site_place.zw) / 65536.0;
    vec2 way = vec2(w.x * turn.x - w.y * turn.y, w.x * turn.y + w.y * turn.x);
    place = site_place - ivec4(256 * corner(0), 0, 0);
    gl_Position = vec4((vec2(place.xy) + way) / (1024.0 * vec2(plane.columns, plane.rows)) - 1.0, 0.0, 1.0);
    shape = ivec3(site_half, plane.base + gl_InstanceIndex);
}
