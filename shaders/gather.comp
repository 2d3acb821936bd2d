// Takes the labels that were drawn, tile by tile: into the sums of their sites, or to `labels`.
//
// Every box is drawn wherever the metric gives its site no more than the margin. So a pixel that found a site within
// the margin has met all that could be as near, and is exact. A tile with another pixel goes into the queue, to be
// drawn again with a greater margin or searched for; `list` says which tiles are done.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_KHR_shader_subgroup_vote : require
#include "plane.glsl"
#include "metric.glsl"
#include "tile.glsl"

layout(set = 0, binding = 13) uniform utexture2D label_image;
layout(set = 0, binding = 14) uniform texture2D depth_image;

// Fetches the labels; the tile's greatest squared distance.
int fetch(ivec2 origin)
{
    int most = 0;
    ivec2 block = corner(0);
    for (int q = 0; q < QUADS; q++)
        for (int i = 0; i < 4; i++) {
            ivec2 pixel = origin + first_of(q) + ivec2(i, 0);
            int d2 = int(floatBitsToUint(texelFetch(depth_image, pixel - block, 0).x) - NEAREST);
            owner[q][i] = int(texelFetch(label_image, pixel - block, 0).x);
            most = max(most, pixel.x < plane.width && pixel.y < plane.height ? d2 : 0);
        }
    for (int step = 1; step < LANES; step *= 2)
        most = max(most, subgroupShuffleXor(most, uint(step)));
    return most;
}

void add(int index, int owned, ivec2 origin)
{
    ivec2 place = ivec2(site[6 * index], site[6 * index + 1]), d = origin + 4 - (place >> 8);
    if (all(lessThan(abs(d), ivec2(120))) && d.x * d.x + d.y * d.y < 120 * 120) {
        add_near(index, owned, origin, place);
        return;
    }
    int count = owned & 255;
    atomicAdd(sum[index].count, uint64_t(count));
    atomicAdd(sum[index].x, uint64_t((owned >> 8 & 4095) + count * origin.x));
    atomicAdd(sum[index].y, uint64_t((owned >> 20) + count * origin.y));
}

int lowest_label()
{
    uint least = uint(-1);
    for (int q = 0; q < QUADS; q++)
        for (int i = 0; i < 4; i++)
            least = min(least, uint(owner[q][i]));
    for (int step = 1; step < LANES; step *= 2)
        least = min(least, subgroupShuffleXor(least, uint(step)));
    return int(least);
}

// One label after another, of all tiles of the subgroup at a time.
void collect(ivec2 origin)
{
    for (int index = lowest_label(); subgroupAny(index >= 0); index = lowest_label()) {
        int part = owned(index);
        if (lane == 0 && index >= 0)
            add(index, part, origin);
        for (int q = 0; q < QUADS; q++)
            for (int i = 0; i < 4; i++)
                owner[q][i] = owner[q][i] == index ? -1 : owner[q][i];
    }
}

void main()
{
    int at = share_tiles();
    bool wanted = at < plane.count && list[min(at, plane.count - 1)] <= 0;
    ivec2 origin = corner(min(at, plane.count - 1));
    int most = fetch(origin);
    bool exact = wanted && most <= plane.margin * plane.margin;

    if (plane.write == 0)
        drop_outside(origin);
    for (int q = 0; q < QUADS; q++)
        owner[q] = exact ? owner[q] : ivec4(-1);
    if (plane.write == 0)
        collect(origin);
    else if (exact)
        for (int q = 0; q < QUADS; q++)
            labels[at * 16 + lane * QUADS + q] = owner[q];
    if (lane != 0 || !wanted)
        return;
    list[at] = exact ? 1 : -1;
    uint distance = uint(sqrt(float(most)));
    if (exact) {
        atomicAdd(far[min(distance >> 7, 255)], 1);
        if (watched(origin))
            atomicMax(total_radius, uint(range(float(distance) + 8.0)));
    } else {
        queue[atomicAdd(queued, 1)] = uint(at);
    }
}
