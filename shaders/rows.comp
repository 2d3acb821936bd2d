// Gives each row of buckets its stretch of `sorted`, and each bucket its part of it: a workgroup a row, a stretch of
// buckets an invocation. Rows may lie in any order.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "plane.glsl"

layout(local_size_x = 64) in;

shared uint part[64], row_begin;

void main()
{
    int row = (plane.base + int(gl_WorkGroupID.x)) * (plane.across + 1), me = int(gl_LocalInvocationIndex);
    int stretch = (plane.across + 63) / 64, from = 1 + me * stretch, to = min(from + stretch, plane.across + 1);
    uint mine = 0;
    for (int c = from; c < to; c++)
        mine += first[row + c];
    part[me] = mine;
    barrier();
    uint before = 0;
    for (int i = 0; i < me; i++)
        before += part[i];
    if (me == 63) {
        row_begin = atomicAdd(total_sorted, before + mine);
        first[row] = row_begin;
    }
    barrier();
    uint begin = row_begin + before;
    for (int c = from; c < to; c++) {
        uint n = first[row + c];
        first[row + c] = begin;
        begin += n;
    }
}
