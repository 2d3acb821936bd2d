// The exact distance of a pixel from a site as its depth, so that the depth test finds the nearest.
//
// Positive floats are in the order of their bits: 2^-126 with d2 added to its bits is a float for each d2, and no
// denormal one, and below 1 for less than 127 px. Beyond, which is beyond any margin, all are as far.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "parameters.glsl"
#include "metric.glsl"

layout(constant_id = 0) const bool NARROW = true; // 32 bits are enough

layout(location = 0) flat in ivec4 place;
layout(location = 1) flat in ivec3 shape;

layout(location = 0) out uint label;

void main()
{
    ivec2 p = 256 * ivec2(gl_FragCoord.xy) + 128;
    Site s = Site(place, ivec4(shape, 0));
    uint d2 = NARROW ? metric_narrow(s, p) : uint(min(metric(s, p.x, p.y), uint64_t(FARTHEST)));
    label = uint(shape.z);
    gl_FragDepth = uintBitsToFloat(NEAREST + min(d2, FARTHEST));
}
