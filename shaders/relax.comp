// Moves every site: centroid, push off the edge, turn (III.B). The GLSL twin of lib/backend/relax.c.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "plane.glsl"
#include "fixed.glsl"
#include "random.glsl"
#include "lattice.glsl"
#include "noise.glsl"

layout(local_size_x = 64) in;

int edge_at(int x, int y)
{
    x = clamp(x, 0, plane.width - 1);
    y = clamp(y, 0, plane.height - 1);
    int64_t at = int64_t(y) * plane.width + x;
    uint word = uint(at & 0x3ffffff) >> 1, two;
    switch (int(at >> 26)) {
    case 0: two = edge[0].two[word]; break;
    case 1: two = edge[1].two[word]; break;
    case 2: two = edge[2].two[word]; break;
    default: two = edge[3].two[word]; break;
    }
    return int(two >> (16 * int(at & 1)) & 0xffff);
}

// Scales a vector below 2^20 to 65536. False if it has no direction.
bool normalised(int x, int y, out ivec2 unit)
{
    int64_t lx = x, ly = y;
    unit = ivec2(0);
    if (x == 0 && y == 0)
        return false;
    while (lx * lx + ly * ly < int64_t(1) << 36) {
        lx *= 2;
        ly *= 2;
    }
    int64_t length = int64_t(isqrt(uint64_t(lx * lx + ly * ly) << 22)); // 1/2048
    unit = ivec2(int(divide_rounded(lx << 27, length)), int(divide_rounded(ly << 27, length)));
    return true;
}

// Is p within push_within of an edge, and how does the distance change there? Sobel, normalised.
bool near_edge(ivec2 p, out int distance, out ivec2 normal)
{
    distance = 0;
    normal = ivec2(0);
    if (plane.edge_shift < 0)
        return false;
    int x = p.x >> 8, y = p.y >> 8;
    distance = edge_at(x, y) << plane.edge_shift;
    if (distance >= plane.push_within)
        return false;
    int nw = edge_at(x - 1, y - 1), n = edge_at(x, y - 1), ne = edge_at(x + 1, y - 1);
    int w = edge_at(x - 1, y), e = edge_at(x + 1, y);
    int sw = edge_at(x - 1, y + 1), s = edge_at(x, y + 1), se = edge_at(x + 1, y + 1);
    return normalised((ne - nw) + 2 * (e - w) + (se - sw), (sw - nw) + 2 * (s - n) + (se - ne), normal);
}

// All sums are of pixels, and so not negative.
int mean(int64_t sum, int64_t count)
{
    return int(128 + int64_t(uint64_t(256 * sum + (count >> 1)) / uint64_t(count)));
}

// So far beyond the centroid as the relaxation says, or short of it.
int past(int from, int middle)
{
    int way = int((int64_t(plane.excess) * (middle - from) + 32768) >> 16);
    return middle + clamp(way, -plane.cell, plane.cell);
}

ivec2 centre(int i, ivec2 site_px, out bool empty)
{
    Sum s = sum[i];
    sum[i] = Sum(0, 0, 0, 0);
    int64_t near = int64_t(s.near & 0xffff), count = near + int64_t(s.count);
    int64_t x = int64_t(s.x) + int64_t(s.near >> 16 & 0xffffff) + near * (site_px.x - 128);
    int64_t y = int64_t(s.y) + int64_t(s.near >> 40) + near * (site_px.y - 128);
    empty = count == 0;
    return empty ? ivec2(0) : ivec2(mean(x, count), mean(y, count));
}

// Another place in the same cell.
int elsewhere(int place, int origin, Lattice l, uint word)
{
    int at = lattice_place(l, place + origin), cell = lattice_cell(l, at);
    int start = lattice_start(l, cell);
    return place - at + start + int(below(word, uint(lattice_start(l, cell + 1) - start)));
}

// An empty cell lies under the boxes of its neighbours; a new place at random in the lattice cell where the site lies
// gets it out.
ivec2 revived(int i, ivec2 p)
{
    uvec4 w = philox(uvec4(home[i].xy, plane.iteration * 64 + home[i].z, DRAW_REVIVE),
                     uvec2(plane.seed_low, plane.seed_high));
    return ivec2(elsewhere(p.x, plane.origin_x, lattice_of(plane.cell, plane.period_x), w.x),
                 elsewhere(p.y, plane.origin_y, lattice_of(plane.cell, plane.period_y), w.y));
}

int beyond(int place, int origin, Lattice l, int cell)
{
    int at = place + origin;
    return max(0, max(lattice_start(l, cell) - at, at - lattice_start(l, cell + 1)));
}

int stray(int i, ivec2 p)
{
    return max(beyond(p.x, plane.origin_x, lattice_of(plane.cell, plane.period_x), home[i].x),
               beyond(p.y, plane.origin_y, lattice_of(plane.cell, plane.period_y), home[i].y));
}

ivec2 direction(ivec2 p, bool near, ivec2 normal)
{
    if (plane.edge_shift == -2)
        return turned(edge_at(p.x >> 8, p.y >> 8));
    if (near) // Eq. 3: a quarter turn from the gradient
        return ivec2(normal.y, -normal.x);
    int64_t n = noise(plane.noise_key, lattice_of(plane.noise_wave, plane.period_x),
                      lattice_of(plane.noise_wave, plane.period_y), p.x + plane.origin_x, p.y + plane.origin_y);
    return turned(int(n * plane.noise_swing >> 16));
}

int pushed(int x, int way, int normal)
{
    return x + int((int64_t(way) * normal + 32768) >> 16);
}

void main()
{
    int at = int(gl_GlobalInvocationID.x);
    if (at >= plane.count)
        return;
    int i = plane.base + at, distance;
    ivec2 last = 256 * ivec2(plane.width, plane.height) - 1, before = ivec2(site[6 * i], site[6 * i + 1]), normal;
    bool empty;
    ivec2 p = centre(i, before >> 8, empty);
    if (home[i].w != 0) // copy.comp moves it
        return;
    p = empty ? revived(i, before) : ivec2(past(before.x, p.x), past(before.y, p.y));
    p = clamp(p, ivec2(0), last);
    bool near = near_edge(p, distance, normal);
    if (near) {
        int way = plane.push_to - distance;
        p = clamp(ivec2(pushed(p.x, way, normal.x), pushed(p.y, way, normal.y)), ivec2(0), last);
    }
    ivec2 turn = direction(p, near, normal);
    site[6 * i] = p.x;
    site[6 * i + 1] = p.y;
    site[6 * i + 2] = turn.x;
    site[6 * i + 3] = turn.y;
    if (empty)
        atomicAdd(total_empty, 1);
    if (p != before)
        atomicAdd(total_moved, 1);
    ivec2 move = abs(p - before);
    atomicAdd(total_way, uint64_t(max(move.x, move.y)));
    if (plane.period_x != 0)
        atomicMax(total_stray, uint(stray(i, p)));
}
