// Labels the tiles for which 32 bits are enough, and adds their pixels to the sums of their sites.
//
// A tile is shared by LANES invocations that lie side by side in a subgroup; each has ROWS rows of 8 pixels. Each lane
// fetches one candidate at a time and the lanes hand them round, for fetching costs more than the metric itself.
// Control flow is the same throughout a subgroup: a lane without work repeats its last candidate, to no effect.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "plane.glsl"
#include "metric.glsl"

layout(constant_id = 0) const int LANES = 8; // 8, or less if the subgroups are smaller
const int ROWS = 8 / LANES, QUADS = 2 * ROWS;

layout(local_size_x = 64) in;

ivec4 least[QUADS], owner[QUADS];
int lane, neighbour; // among the tile's lanes; of the tile's first lane in the subgroup

int from_lane(int v, int k)
{
    return subgroupShuffle(v, uint(neighbour + k));
}

// One candidate against the pixels of this lane: `metric` in 32 bits, modulo 2^32 until the shift.
void offer(int u0, int v0, int c, int s, int half_x, int half_y, int index)
{
    ivec4 cx = ivec4(0, c, 2 * c, 3 * c) << 8, sx = ivec4(0, s, 2 * s, 3 * s) << 8;
    for (int q = 0; q < QUADS; q++) {
        int x = q % 2 * 1024, y = (lane * ROWS + q / 2) * 256;
        ivec4 u = (u0 + x * c + y * s + cx) >> 16, v = (v0 + y * c - x * s - sx) >> 16;
        u = max(abs(u) - half_x, 0);
        v = max(abs(v) - half_y, 0);
        ivec4 d = u * u + v * v;
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

// Pixels outside the plane belong to nobody.
void drop_outside(ivec2 origin)
{
    for (int q = 0; q < QUADS; q++) {
        bool inside = origin.y + lane * ROWS + q / 2 < plane.height;
        for (int i = 0; i < 4; i++)
            owner[q][i] = inside && origin.x + q % 2 * 4 + i < plane.width ? owner[q][i] : -1;
    }
}

// Pixels of this lane that belong to a site: 8 bits of their number, 12 each of the sums of their x and y in the tile.
int owned(int index)
{
    int sum = 0;
    for (int q = 0; q < QUADS; q++)
        for (int i = 0; i < 4; i++)
            sum += owner[q][i] == index ? 1 + ((q % 2 * 4 + i) << 8) + ((lane * ROWS + q / 2) << 20) : 0;
    return sum;
}

void collect(ivec2 origin, int head, int n, int most)
{
    for (int chunk = 0; chunk < most; chunk += LANES) {
        Site s = fetch(head, n, chunk + lane);
        int mine = 0;
        for (int k = 0; k < min(LANES, most - chunk); k++) {
            int part = owned(from_lane(s.shape.z, k));
            for (int step = 1; step < LANES; step *= 2)
                part += subgroupShuffleXor(part, uint(step));
            mine = lane == k ? part : mine;
        }
        if (chunk + lane >= n || mine == 0)
            continue;
        ivec2 d = origin - (s.place.xy >> 8) + 128;
        int count = mine & 255, x = (mine >> 8 & 4095) + count * d.x, y = (mine >> 20) + count * d.y;
        atomicAdd(sum[s.shape.z].near, uint64_t(count) | uint64_t(x) << 16 | uint64_t(y) << 40);
    }
}

void main()
{
    lane = int(gl_LocalInvocationIndex) % LANES;
    neighbour = int(gl_SubgroupInvocationID) - lane;
    int at = int(gl_WorkGroupID.x) * (64 / LANES) + int(gl_LocalInvocationIndex) / LANES;
    int head = at * (plane.capacity + 1);
    ivec2 origin = corner(at);
    int n = at < plane.count ? max(list[head], 0) : 0, most = subgroupMax(n);

    decide(origin, head, n, most);
    if (plane.write == 0) {
        drop_outside(origin);
        collect(origin, head, n, most);
    } else if (n > 0) {
        for (int q = 0; q < QUADS; q++)
            labels[at * 16 + lane * QUADS + q] = owner[q];
    }
}
