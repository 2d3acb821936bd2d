// Labels the tiles that `label` cannot: 64-bit arithmetic, and all sites where a list would be too long.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "plane.glsl"
#include "metric.glsl"
#include "search.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 2) const bool MASKED = false;

shared int owner[64];

uint64_t least = uint64_t(0) - 1;
int label = INT_MAX;

void offer(const Site s, int x, int y)
{
    uint64_t d = metric(s, x, y);
    if (d < least || (d == least && s.shape.z < label)) {
        least = d;
        label = s.shape.z;
    }
}

bool visit(uint i, ivec2 p)
{
    offer(sorted_site(i), p.x, p.y);
    return true;
}

// Any site first; then all that could be as near as the nearest of those.
void search(ivec2 p)
{
    for (int ring = 1; label == INT_MAX && !lost; ring *= 2)
        search_box(square(p, ring), p);
    search_box(box_within(p, range(sqrt(float(least)) + 8.0)), p);
    if (lost)
        atomicAdd(total_lost, 1);
}

// The first pixel of each site in the tile adds them all.
void collect(ivec2 origin, int me)
{
    uint n = 0, x = 0, y = 0;
    for (int i = 0; i < 64; i++) {
        if (owner[i] != label)
            continue;
        if (i < me)
            return;
        n++;
        x += uint(origin.x + i % TILE);
        y += uint(origin.y + i / TILE);
    }
    atomicAdd(sum[label].count, uint64_t(n));
    atomicAdd(sum[label].x, uint64_t(x));
    atomicAdd(sum[label].y, uint64_t(y));
}

void main()
{
    int at = int(queue[gl_WorkGroupID.x]), me = int(gl_LocalInvocationIndex);
    int head = at * (plane.capacity + 1), n = abs(list[head]);
    ivec2 origin = corner(at), pixel = origin + ivec2(me % TILE, me / TILE), p = 256 * pixel + 128;

    if (n > plane.capacity)
        search(p);
    else
        for (int k = 1; k <= n; k++)
            offer(sorted_site(uint(list[head + k])), p.x, p.y);

    bool inside = pixel.x < plane.width && pixel.y < plane.height;
    inside = inside && !lost;
    if (inside && watched(origin))
        atomicMax(total_radius, uint(range(sqrt(float(least)) * 1.001 + 8.0)));
    bool counts = inside && !(MASKED && (mask[2 * (origin.y / 8 * plane.tiles_across + origin.x / 8) + me / 32] >>
                                         me % 32 & 1) != 0);
    owner[me] = counts ? label : -1;
    barrier();
    if (plane.write != 0)
        labels[at * 16 + me / 4][me % 4] = label;
    else if (counts)
        collect(origin, me);
}
