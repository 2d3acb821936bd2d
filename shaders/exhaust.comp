// One voxel of stone a workgroup, as the paper does: one random plane, all neighbourhoods of the sample, one at random
// of those within 1 + epsilon of the nearest. The GLSL twin of sample_paper in lib/solid/sample.c.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "voxels.glsl"

const int LANES = 64;
layout(local_size_x = LANES) in;

shared int seen[TAPS * FEATURES], shift_x[TAPS], shift_y[TAPS], taps; // present ones
shared int roots[TAPS];
shared int least[LANES], within[LANES];

// The patch as one of the eight ways to look at a plane sees it: where tap (x, y) comes from.
ivec2 turned(int way, int x, int y)
{
    int last = SIDE - 1, fx = (way & 1) != 0 ? last - x : x, fy = (way & 2) != 0 ? last - y : y;
    return (way & 4) != 0 ? ivec2(fy, fx) : ivec2(fx, fy);
}

void gather(ivec3 at, int p, int way)
{
    taps = 0;
    for (int tap = 0; tap < TAPS; tap++) {
        int x = tap % SIDE, y = tap / SIDE;
        ivec2 from = turned(way, x, y);
        int other = voxel_in_plane(at, p, from.x - RADIUS, from.y - RADIUS);
        int root = tables.number[setting.plane[p].root + tap];
        if (!is_there(other) || root == 0)
            continue;
        for (int f = 0; f < FEATURES; f++)
            seen[taps * FEATURES + f] = voxel_feature(other, f);
        shift_x[taps] = x - RADIUS;
        shift_y[taps] = y - RADIUS;
        roots[taps++] = root;
    }
}

// All that is above `bound` is alike.
int distance_to(int p, int position, int64_t bound)
{
    int sum = 0, row = row_of(p, position);
    for (int i = 0; i < taps && sum <= bound; i++)
        for (int f = 0; f < FEATURES; f++) {
            int d = texel_feature(p, position + shift_y[i] * row + shift_x[i], f) - seen[i * FEATURES + f];
            sum += d * d * roots[i] * roots[i];
        }
    return sum;
}

void store(int voxel, int p, int position)
{
    int class_ = texel_class(p, position);
    atomicAdd(tally.count[USE_FACTORS + setting.plane[p].use + position], 1);
    atomicAdd(tally.count[class_], 1);
    set_source(p, voxel, position);
    for (int i = 0; i < WORDS; i++) {
        uint word = texels.word[setting.plane[p].texels + position * WORDS + i];
        voxels.word[voxel * WORDS + i] = i == 0 ? word & ~255u | uint(FILLED) : word;
    }
}

void main()
{
    int item = int(gl_WorkGroupID.x), lane = int(gl_LocalInvocationID.x);
    ivec3 at = place_of(push.base + item);
    int voxel = step_of(0, at.x) + step_of(1, at.y) + step_of(2, at.z);
    uvec4 chance = draw_voxel(uint(voxel), 0);
    bool flat_ = setting.size[2] == 1;
    int p = flat_ ? 2 : int(below(chance[1], 3)), way = flat_ ? 0 : int(chance[2] & 7u);
    if (lane == 0)
        gather(at, p, way);
    barrier();

    int inner = setting.plane[p].inner, all = setting.plane[p].inner_count;
    int each = (all + LANES - 1) / LANES, from = min(lane * each, all), to = min(from + each, all);
    int mine = 0x7fffffff;
    for (int i = from; i < to; i++)
        mine = min(mine, distance_to(p, tables.number[inner + i], mine));
    least[lane] = mine;
    barrier();
    for (int i = 0; i < LANES; i++)
        mine = min(mine, least[i]);
    int64_t most = int64_t(mine) + (int64_t(mine) * push.temperature >> 8);
    int count = 0;
    for (int i = from; i < to; i++)
        count += distance_to(p, tables.number[inner + i], most) <= most ? 1 : 0;
    within[lane] = count;
    barrier();

    int before = 0, together = 0;
    for (int i = 0; i < LANES; i++) {
        before += i < lane ? within[i] : 0;
        together += within[i];
    }
    int drawn = int(below(chance[0], uint(together))) - before;
    if (drawn < 0 || drawn >= count)
        return;
    for (int i = from; i < to; i++)
        if (distance_to(p, tables.number[inner + i], most) <= most && drawn-- == 0) {
            store(voxel, p, tables.number[inner + i]);
            return;
        }
}
