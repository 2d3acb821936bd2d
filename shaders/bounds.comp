// Finds where the sites of a chunk lie: a workgroup a chunk.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "plane.glsl"

layout(local_size_x = 64) in;

shared int low_x, low_y, high_x, high_y;

void main()
{
    int c = plane.base + int(gl_WorkGroupID.x), me = int(gl_LocalInvocationIndex);
    if (me == 0) {
        low_x = low_y = INT_MAX;
        high_x = high_y = -1;
    }
    barrier();
    for (int i = c * CHUNK + me; i < min((c + 1) * CHUNK, plane.sites); i += 64) {
        atomicMin(low_x, site[6 * i]);
        atomicMin(low_y, site[6 * i + 1]);
        atomicMax(high_x, site[6 * i]);
        atomicMax(high_y, site[6 * i + 1]);
    }
    barrier();
    if (me == 0) {
        chunk[c].low = ivec2(low_x, low_y);
        chunk[c].high = ivec2(high_x, high_y);
    }
}
