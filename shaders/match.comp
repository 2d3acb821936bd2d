// How much a block of a picture differs from what lies at each of a row of places: the GLSL twin of
// pv_compare_reference in lib/tiling/search.c.
#version 450
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

layout(local_size_x = 64) in;

layout(push_constant, std430) uniform Match {
    int first, stride;  // value index of the first place, and from one row of places to the next
    int depth, across;  // values a pixel, places a row
    int base, count;    // the places of this dispatch
    int entries;        // values of the block that count
} match;

layout(binding = 0, std430) readonly buffer Values { uint two[]; } values;
layout(binding = 1, std430) readonly buffer Block { ivec2 entry[]; } block; // where from the place, and the value
layout(binding = 2, std430) writeonly buffer Costs { uint64_t cost[]; } costs;

const int TOGETHER = 128; // squares of 0..4095 that 32 bits hold the sum of

uint value_at(int at)
{
    return values.two[at >> 1] >> (16 * (at & 1)) & 0xffffu;
}

void main()
{
    int at = int(gl_GlobalInvocationID.x);
    if (at >= match.count)
        return;
    int place = match.base + at;
    int from = match.first + place / match.across * match.stride + place % match.across * match.depth;
    uint64_t sum = 0;
    for (int i = 0; i < match.entries;) {
        uint part = 0;
        for (int end = min(i + TOGETHER, match.entries); i < end; i++) {
            int d = int(value_at(from + block.entry[i].x)) - block.entry[i].y;
            part += uint(d * d);
        }
        sum += part;
    }
    costs.cost[at] = sum;
}
