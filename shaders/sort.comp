// Copies each site into its bucket. Within a bucket the order is left to chance: nothing may depend on it.
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
    Site s;
    s.place = ivec4(site[6 * i], site[6 * i + 1], site[6 * i + 2], site[6 * i + 3]);
    s.shape = ivec4(site[6 * i + 4], site[6 * i + 5], i, 0);
    ivec2 b = bucket_of(s.place.x, s.place.y);
    sorted[atomicAdd(first[b.y * (plane.across + 1) + b.x + 1], 1)] = s;
}
