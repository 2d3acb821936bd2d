// Takes the labels that were drawn, a workgroup a tile: into the sums of their sites, or to `labels`.
//
// Every box is drawn wherever the metric gives its site no more than the margin. So a pixel that found a site within
// the margin has met all that could be as near, and is exact. A tile with another pixel goes into the queue, to be
// drawn again with a greater margin or searched for; `list` says which tiles are done.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "plane.glsl"
#include "metric.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 12) uniform utexture2D label_image;
layout(set = 0, binding = 13) uniform texture2D depth_image;

shared uint farthest;

// To `near` if that may be: within 126 px of the site. See `Sum`.
void add(int label, ivec2 pixel)
{
    ivec2 d = pixel - (ivec2(site[6 * label], site[6 * label + 1]) >> 8);
    if (all(lessThan(abs(d), ivec2(126))) && d.x * d.x + d.y * d.y < 126 * 126) {
        d += 128;
        atomicAdd(sum[label].near, uint64_t(1) | uint64_t(d.x) << 16 | uint64_t(d.y) << 40);
        return;
    }
    atomicAdd(sum[label].count, uint64_t(1));
    atomicAdd(sum[label].x, uint64_t(pixel.x));
    atomicAdd(sum[label].y, uint64_t(pixel.y));
}

void main()
{
    int at = int(gl_WorkGroupID.x), me = int(gl_LocalInvocationIndex);
    ivec2 in_tile = ivec2(me % TILE, me / TILE), pixel = corner(at) + in_tile, texel = pixel - corner(0);
    bool inside = pixel.x < plane.width && pixel.y < plane.height;
    if (list[at] > 0)
        return;
    if (me == 0)
        farthest = 0;
    barrier();
    if (inside)
        atomicMax(farthest, floatBitsToUint(texelFetch(depth_image, texel, 0).x) - NEAREST);
    barrier();
    uint most = farthest;
    if (most > uint(plane.margin) * uint(plane.margin)) {
        if (me == 0) {
            list[at] = -1;
            queue[atomicAdd(queued, 1)] = uint(at);
        }
        return;
    }
    int label = inside ? int(texelFetch(label_image, texel, 0).x) : -1;
    if (plane.write != 0)
        labels[at * 16 + me / 4][me % 4] = label;
    else if (inside)
        add(label, pixel);
    if (me == 0) {
        list[at] = 1;
        atomicAdd(far[min(int(sqrt(float(most))) >> 7, 255)], 1);
    }
}
