// Labels the tiles for which 32 bits are enough, and adds their pixels to the sums of their sites.
//
// Each lane fetches one candidate at a time and the lanes hand them round, for fetching costs more than the metric
// itself. A lane without work repeats its last candidate, to no effect.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "plane.glsl"
#include "metric.glsl"
#include "tile.glsl"

ivec4 least[QUADS];

// One candidate against the pixels of this lane: `metric` in 32 bits, modulo 2^32 until the shift.
void offer(int u0, int v0, int c, int s, int half_x, int half_y, int index)
{
    ivec4 cx = ivec4(0, c, 2 * c, 3 * c) << 8, sx = ivec4(0, s, 2 * s, 3 * s) << 8;
    for (int q = 0; q < QUADS; q++) {
        int x = q % 2 * 1024, y = (lane * ROWS + q / 2) * 256;
        ivec4 u = (u0 + x * c + y * s + cx) >> 16, v = (v0 + y * c - x * s - sx) >> 16;
        ivec4 d;
        if (METRIC == 0) {
            u = max(abs(u) - half_x, 0);
            v = max(abs(v) - half_y, 0);
            d = u * u + v * v;
        } else {
            uvec4 a = uvec4(abs(u)) * uint(half_x) >> 16, b = uvec4(abs(v)) * uint(half_y) >> 16;
            a = METRIC == 2 ? a + b : max(a, b);
            d = ivec4(a * a);
        }
        for (int i = 0; i < 4; i++) {
            bool better = d[i] < least[q][i] || (d[i] == least[q][i] && index < owner[q][i]);
            least[q][i] = better ? d[i] : least[q][i];
            owner[q][i] = better ? index : owner[q][i];
        }
    }
}

Site fetch(int head, int n, int slot)
{
    return sorted_site(uint(n > 0 ? list[head + 1 + min(slot, n - 1)] : 0));
}

void decide(ivec2 origin, int head, int n, int most)
{
    for (int q = 0; q < QUADS; q++) {
        least[q] = ivec4(INT_MAX);
        owner[q] = ivec4(INT_MAX);
    }
    for (int chunk = 0; chunk < most; chunk += LANES) {
        Site s = fetch(head, n, chunk + lane);
        ivec2 d = 256 * origin + 128 - s.place.xy;
        int u0 = d.x * s.place.z + d.y * s.place.w + 32768, v0 = d.y * s.place.z - d.x * s.place.w + 32768;
        for (int k = 0; k < min(LANES, most - chunk); k++)
            offer(from_lane(u0, k), from_lane(v0, k), from_lane(s.place.z, k), from_lane(s.place.w, k),
                  from_lane(s.shape.x, k), from_lane(s.shape.y, k), from_lane(s.shape.z, k));
    }
}

// How far a pixel of the tile is from its site.
void report(ivec2 origin, int n)
{
    int farthest = 0;
    for (int q = 0; q < QUADS; q++)
        for (int i = 0; i < 4; i++) {
            ivec2 pixel = origin + first_of(q) + ivec2(i, 0);
            farthest = max(farthest, pixel.x < plane.width && pixel.y < plane.height ? least[q][i] : 0);
        }
    for (int step = 1; step < LANES; step *= 2)
        farthest = max(farthest, subgroupShuffleXor(farthest, uint(step)));
    if (lane == 0 && n > 0 && watched(origin))
        atomicMax(total_radius, uint(range(sqrt(float(farthest)) * 1.001 + 8.0)));
}

void collect(ivec2 origin, int head, int n, int most)
{
    for (int chunk = 0; chunk < most; chunk += LANES) {
        Site s = fetch(head, n, chunk + lane);
        int mine = 0;
        for (int k = 0; k < min(LANES, most - chunk); k++) {
            int part = owned(from_lane(s.shape.z, k));
            mine = lane == k ? part : mine;
        }
        if (chunk + lane < n && mine != 0)
            add_near(s.shape.z, mine, origin, s.place.xy);
    }
}

void main()
{
    int at = share_tiles(), head = at * (plane.capacity + 1);
    ivec2 origin = corner(at);
    int n = at < plane.count ? max(list[head], 0) : 0, most = subgroupMax(n);

    decide(origin, head, n, most);
    if (plane.write == 0) {
        report(origin, n);
        drop_outside(origin);
        collect(origin, head, n, most);
    } else if (n > 0) {
        for (int q = 0; q < QUADS; q++)
            labels[at * 16 + lane * QUADS + q] = owner[q];
    }
}
