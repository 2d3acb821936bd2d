#version 300 es
// One pixel of a site's frustum: its label, and its squared distance as depth, so that the nearest site is seen.
//
// As bits of a float, from the least normal one on, integers keep their order and none is lost. The least depth wins,
// and the first drawn among equals: sites come in the order of their indices.

precision highp float;
precision highp int;

const uint NARROW = 127u * 256u; // nearer than this 32 bits hold the distance

uniform int metric; // PAVE_METRIC_: box, square, diamond

flat in ivec4 site_place;
flat in ivec3 site_shape;

layout(location = 0) out uint label;

// The twin of pv_metric in lib/backend/metric.h, of the way from the site to the pixel.
uint squared(ivec2 d)
{
    ivec2 turn = site_place.zw;
    ivec2 w = (ivec2(d.x * turn.x + d.y * turn.y, d.y * turn.x - d.x * turn.y) + 32768) >> 16;
    if (metric == 0) {
        w = max(abs(w) - site_shape.xy, 0);
        return uint(w.x * w.x) + uint(w.y * w.y);
    }
    uvec2 z = (uvec2(abs(w)) * uvec2(site_shape.xy)) >> 16u;
    uint most = metric == 2 ? z.x + z.y : max(z.x, z.y);
    return most * most;
}

void main()
{
    ivec2 d = 256 * ivec2(gl_FragCoord.xy) + 128 - site_place.xy;
    bool near = uint(d.x * d.x) + uint(d.y * d.y) < NARROW * NARROW;
    label = uint(site_shape.z);
    gl_FragDepth = near ? uintBitsToFloat(0x00800000u + squared(d)) : 1.0;
}
