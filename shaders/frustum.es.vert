#version 300 es
// A site's frustum from above: the rectangle that holds all places up to a margin from it, a box grown by it or a
// pyramid as high. A strip of two triangles, an instance for each site.
//
// Lengths are in 1/256 px from the corner of the tile that is drawn.

layout(location = 0) in ivec4 place; // x, y, cosine, sine
layout(location = 1) in ivec3 shape; // half extents or slopes, and the site's index

uniform int metric;
uniform float margin;
uniform vec4 frame; // at * frame.xy + frame.zw is in clip space

flat out ivec4 site_place;
flat out ivec3 site_shape;

void main()
{
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    vec2 extent = metric == 0 ? vec2(shape.xy) + margin : margin * 65536.0 / vec2(shape.xy);
    vec2 w = corner * extent, turn = vec2(place.zw) / 65536.0;
    vec2 at = vec2(place.xy) + vec2(w.x * turn.x - w.y * turn.y, w.x * turn.y + w.y * turn.x);
    gl_Position = vec4(at * frame.xy + frame.zw, 0.0, 1.0);
    site_place = place;
    site_shape = shape;
}
