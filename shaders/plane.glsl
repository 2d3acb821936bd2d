// The buffers that the shaders share.
#extension GL_EXT_shader_atomic_int64 : require
#include "parameters.glsl"

// The pixels of a cell. Those within 127 px of the site are counted in `near`, as one number: 16 bits of count, 24 of
// x - site.x + 128 and 24 of y - site.y + 128, all in whole px. A disc of 127 px has too few pixels to overflow them.
struct Sum {
    uint64_t near;
    uint64_t count, x, y;
};

const int CHUNK = 1024;

// Sites that are drawn, or left out, together: where they lie, and how they are drawn (VkDrawIndirectCommand).
struct Chunk {
    ivec2 low, high;
    uint vertices, instances, first_vertex, first_instance;
};

layout(std430, set = 0, binding = 0) buffer Sites { int site[]; };  // 6 a site: pave_site
layout(std430, set = 0, binding = 1) buffer Homes { ivec4 home[]; }; // pv_home
layout(std430, set = 0, binding = 2) buffer Sums { Sum sum[]; };
layout(std430, set = 0, binding = 3) buffer Sorted { Site sorted[]; };
// across + 1 a row: where bucket c of the row begins in `sorted`, and at c + 1 where it ends.
layout(std430, set = 0, binding = 4) buffer First { uint first[]; };
// capacity + 1 a tile of the band: the number of candidates, and their places in `sorted`. The number is negative if
// 32 bits are not enough for them, and -(capacity + 1) if there are too many.
layout(std430, set = 0, binding = 5) buffer Lists { int list[]; };
// Groups to dispatch, and the tiles of the band that `wide` has to label.
layout(std430, set = 0, binding = 6) buffer Queue { uint queued, groups_y, groups_z, queue[]; };
layout(std430, set = 0, binding = 7) buffer Labels { ivec4 labels[]; }; // 16 a tile of the band, row by row
layout(std430, set = 0, binding = 8) buffer Totals {
    uint total_sorted, total_empty, total_moved, total_lost;
    uint total_radius; // no pixel is farther from its site
    uint total_stray;  // no original is farther from its home cell
    uint64_t total_way; // of all sites: the larger of the moves in x and in y
    uint far[];
};
layout(std430, set = 0, binding = 9) buffer Chunks { Chunk chunk[]; };
layout(std430, set = 0, binding = 10) buffer Mask { uint mask[]; }; // 2 a tile: bit 8 * y + x of a masked pixel
layout(std430, set = 0, binding = 11) buffer Edge { uint two[]; } edge[4]; // 2 px a word, 2^26 px a part

// `sorted` again, to read: drivers on processors fetch texels much faster than they load from buffers.
layout(set = 0, binding = 12) uniform isamplerBuffer sorted_texels;

Site sorted_site(uint i)
{
    return Site(texelFetch(sorted_texels, int(2 * i)), texelFetch(sorted_texels, int(2 * i + 1)));
}

ivec2 bucket_of(int x, int y)
{
    return ivec2(x / plane.cell, y / plane.cell);
}
