// Counts the sites of each bucket: the first of three passes of a counting sort.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "plane.glsl"

layout(local_size_x = 64) in;

void main()
{
    int at = int(gl_GlobalInvocationID.x);
    if (at >= plane.count)
        return;
    int i = plane.base + at;
    ivec2 b = bucket_of(site[6 * i], site[6 * i + 1]);
    atomicAdd(first[b.y * (plane.across + 1) + b.x + 1], 1);
}
