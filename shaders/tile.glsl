// A tile that is shared by LANES invocations side by side in a subgroup; each has ROWS rows of 8 pixels. Control flow
// around these functions must be the same throughout a subgroup.
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require

layout(constant_id = 0) const int LANES = 8; // 8, or less if the subgroups are smaller
const int ROWS = 8 / LANES, QUADS = 2 * ROWS;

layout(local_size_x = 64) in;

layout(constant_id = 2) const bool MASKED = false;

ivec4 owner[QUADS];  // the labels of this lane's pixels
int lane, neighbour; // among the tile's lanes; of the tile's first lane in the subgroup

// The number of the invocation's tile in the block.
int share_tiles()
{
    lane = int(gl_LocalInvocationIndex) % LANES;
    neighbour = int(gl_SubgroupInvocationID) - lane;
    return int(gl_WorkGroupID.x) * (64 / LANES) + int(gl_LocalInvocationIndex) / LANES;
}

int from_lane(int v, int k)
{
    return subgroupShuffle(v, uint(neighbour + k));
}

ivec2 first_of(int q)
{
    return ivec2(q % 2 * 4, lane * ROWS + q / 2);
}

// Pixels outside the plane belong to nobody, masked ones count for nobody.
void drop_outside(ivec2 origin)
{
    int tile = origin.y / 8 * plane.tiles_across + origin.x / 8;
    for (int q = 0; q < QUADS; q++) {
        ivec2 at = origin + first_of(q), in_tile = first_of(q);
        uint masked = MASKED ? mask[2 * tile + in_tile.y / 4] >> (in_tile.y % 4 * 8 + in_tile.x) : 0;
        for (int i = 0; i < 4; i++) {
            bool counts = at.y < plane.height && at.x + i < plane.width && (masked >> i & 1) == 0;
            owner[q][i] = counts ? owner[q][i] : -1;
        }
    }
}

// The tile's pixels that belong to a site: 8 bits of their number, 12 each of the sums of their x and y in the tile.
int owned(int index)
{
    int part = 0;
    for (int q = 0; q < QUADS; q++)
        for (int i = 0; i < 4; i++)
            part += owner[q][i] == index ? 1 + (first_of(q).x + i << 8) + (first_of(q).y << 20) : 0;
    for (int step = 1; step < LANES; step *= 2)
        part += subgroupShuffleXor(part, uint(step));
    return part;
}

// Adds them to the site's sum; the tile lies within 127 px of it.
void add_near(int index, int owned, ivec2 origin, ivec2 site_place)
{
    ivec2 d = origin - (site_place >> 8) + 128;
    int count = owned & 255, x = (owned >> 8 & 4095) + count * d.x, y = (owned >> 20) + count * d.y;
    atomicAdd(sum[index].near, uint64_t(count) | uint64_t(x) << 16 | uint64_t(y) << 40);
}
