// Finds the candidates of each tile: the sites that could own one of its pixels.
//
// Let j be any site and U its greatest distance from a pixel of the tile, which lies at a corner, for all metrics are
// convex. A site can own a pixel only if it is no farther from it than U, and so no farther from the centre
// than U plus the tile's radius. The floats may be off a little: the last term of `bound` allows for that and for the
// rounding of the integer metric, twice over. A poor j makes a long list, never a wrong one.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "plane.glsl"
#include "metric.glsl"
#include "search.glsl"

layout(local_size_x = 64) in;

const float UNKNOWN = 1e38;

float least = UNKNOWN, bound = -1.0; // bound: unknown as yet
uint nearest = 0;
int head, found = 0;
bool narrow = true;

bool look(uint i, ivec2 p)
{
    float d = metric_about(sorted_site(i), p);
    nearest = d < least ? i : nearest;
    least = min(d, least);
    return true;
}

bool collect(uint i, ivec2 p)
{
    Site s = sorted_site(i);
    if (metric_about(s, p) > bound)
        return true;
    if (++found > plane.capacity)
        return false;
    list[head + found] = int(i);
    vec2 way = vec2(p - s.place.xy);
    narrow = narrow && dot(way, way) < 31000.0 * 31000.0; // 127 px less a tile's radius, and a little
    return true;
}

bool visit(uint i, ivec2 p)
{
    return bound < 0.0 ? look(i, p) : collect(i, p);
}

float farthest_corner(const Site s, ivec2 p)
{
    const int e = 7 * 128;
    return max(max(metric_about(s, p + ivec2(-e, -e)), metric_about(s, p + ivec2(e, -e))),
               max(metric_about(s, p + ivec2(-e, e)), metric_about(s, p + ivec2(e, e))));
}

void main()
{
    int at = int(gl_GlobalInvocationID.x);
    if (at >= plane.count)
        return;
    ivec2 p = 256 * (corner(at) + TILE / 2);
    head = at * (plane.capacity + 1);
    for (int ring = 1; least == UNKNOWN && !lost; ring *= 2)
        search_box(square(p, ring), p);
    bound = farthest_corner(sorted_site(nearest), p) + TILE_RADIUS;
    bound += 16.0 + range(bound) / 4096.0;
    search_box(box_within(p, range(bound)), p);

    found = lost ? plane.capacity + 1 : found;
    bool easy = narrow && found <= plane.capacity;
    list[head] = easy ? found : -found;
    if (!easy)
        queue[atomicAdd(queued, 1)] = uint(at);
}
