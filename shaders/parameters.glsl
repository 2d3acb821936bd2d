// The parameters of a shader, and what a site is. The GLSL twin of lib/backend/vulkan/engine.h.
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

layout(push_constant, std430) uniform Plane {
    int width, height, sites; // px, px, number
    int origin_x, origin_y;   // of the corner in the whole plane, 1/256 px
    int period_x, period_y;   // after which home lattice and noise repeat, 1/256 px; 0: never
    int cell;                 // side of the home lattice's cells and of the buckets, 1/256 px
    int across, down;         // buckets in x and y
    int tiles_across;
    int reach;                // a point at distance d from a site lies within d * STRETCH + reach of it
    int capacity;             // of a tile's candidate list
    int edge_shift;           // -1: no edges; -2: `edge` holds directions
    int push_within, push_to;
    int noise_wave, noise_swing;
    uint noise_key, seed_low, seed_high;
    int iteration;
    int base, count;          // the sites, or the tiles of the block, of this dispatch
    int write;                // labels are wanted, not sums
    int patience;             // rounds that a search may take
    int block, columns, rows; // the tiles under way, a rectangle: the first, and their number in x and y
    int excess;               // relaxation - 1, 1/65536
    int margin;               // of the boxes drawn: what is proven, 1/256 px
    uint unwatched;           // 4 bits: open borders, left, top, right, bottom; 28: nearer to them pixels do not count
} plane;

layout(constant_id = 3) const float STRETCH = 1.0;

const int INT_MAX = 0x7fffffff;

// A site, and its index while it lies in bucket order.
struct Site {
    ivec4 place; // x, y, cosine, sine
    ivec4 shape; // half_x, half_y: extents or slopes; index
};

// The margin that is drawn; lib/backend/vulkan/raster.c says why.
int grown()
{
    return plane.margin + 64 + (plane.reach >> 12);
}

// Does a tile count for the radius, the first pixel of which is p?
bool watched(ivec2 p)
{
    int deep = int(plane.unwatched >> 4);
    return (p.x + 8 > deep || (plane.unwatched & 1u) == 0) && (p.y + 8 > deep || (plane.unwatched & 2u) == 0) &&
           (p.x < plane.width - deep || (plane.unwatched & 4u) == 0) &&
           (p.y < plane.height - deep || (plane.unwatched & 8u) == 0);
}

// The first pixel of a tile of the block.
ivec2 corner(int at)
{
    int tile = plane.block + at / plane.columns * plane.tiles_across + at % plane.columns;
    return ivec2(tile % plane.tiles_across, tile / plane.tiles_across) * 8;
}
