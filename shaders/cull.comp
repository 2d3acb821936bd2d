// Decides which chunks of sites are drawn to a block: those with a site from where a box could reach it.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "plane.glsl"

layout(local_size_x = 64) in;

void main()
{
    int at = int(gl_GlobalInvocationID.x);
    if (at >= plane.count)
        return;
    int c = plane.base + at, reach = plane.reach + int(2.0 * float(grown()) * STRETCH);
    ivec2 first = 256 * corner(0), last = first + 2048 * ivec2(plane.columns, plane.rows);
    bool near = all(greaterThanEqual(chunk[c].high, first - reach)) && all(lessThanEqual(chunk[c].low, last + reach));
    chunk[c].vertices = 4;
    chunk[c].instances = near ? uint(min(CHUNK, plane.sites - c * CHUNK)) : 0;
    chunk[c].first_vertex = chunk[c].first_instance = 0;
}
