// A voxel of stone and what it is compared with: the GLSL twin of lib/solid/grid.h and lib/solid/bank.h. What takes one
// byte in memory there takes its share of a word here that is this voxel's alone, so that neighbours write at once.
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_GOOGLE_include_directive : require

#include "random.glsl"

layout(constant_id = 0) const int SIDE = 5;     // of the window
layout(constant_id = 1) const int FEATURES = 1; // numbers that voxels are compared by

const int RADIUS = SIDE / 2;
const int TAPS = SIDE * SIDE;
const int WORDS = (2 + FEATURES + 3) / 4; // of a voxel or a texel: state or inside, class, features; a byte each
const int CLASSES = 256, STEPS = 16, LAGS = 2, FAR = 4, NEAREST = 3;
const int FREE = 1, MEASURED = 2, FILLED = 3;
const uint DRAW_VOXEL = 50;

layout(push_constant, std430) uniform Push {
    int first[3], every[3], count[3]; // lanes of coordinates, unless voxels come in an order
    int base, items, ordered;
    uint seed_low, seed_high, sweep;
    int temperature, agree, steered, steps;
} push;

struct Plane {
    int width, height, positions, inner_count;
    int total, centre;
    uint floor_low, floor_high;
    int texels, nearest, inner, class_start, root, use; // where in their buffers
};

layout(binding = 0, std430) buffer Voxels { uint word[]; } voxels;
layout(binding = 1, std430) buffer SourceX { int at[]; } source_x;
layout(binding = 2, std430) buffer SourceY { int at[]; } source_y;
layout(binding = 3, std430) buffer SourceZ { int at[]; } source_z;
layout(binding = 4, std430) readonly buffer Texels { uint word[]; } texels;
layout(binding = 5, std430) readonly buffer Tables { int number[]; } tables;
layout(binding = 6, std430) readonly buffer Control { uint factor[]; } control; // of classes, steps, uses
layout(binding = 7, std430) buffer Tally { int count[]; } tally;                // the same
layout(binding = 8, std430) readonly buffer Order { uint voxel[]; } order;
layout(binding = 9, std430) readonly buffer Setting {
    int size[3], steps_at[3], bins_at[3]; // where in the tables those of each axis lie
    int lags, labels;
    Plane plane[3];
} setting;

int plane_u(int p) { return p == 0 ? 1 : 0; }
int plane_v(int p) { return p == 2 ? 1 : 2; }

int source_of(int p, int voxel)
{
    return p == 0 ? source_x.at[voxel] : p == 1 ? source_y.at[voxel] : source_z.at[voxel];
}

void set_source(int p, int voxel, int position)
{
    if (p == 0)
        source_x.at[voxel] = position;
    else if (p == 1)
        source_y.at[voxel] = position;
    else
        source_z.at[voxel] = position;
}

int voxel_byte(int voxel, int i)
{
    return int(voxels.word[voxel * WORDS + (i >> 2)] >> (8 * (i & 3)) & 255u);
}

int texel_byte(int p, int position, int i)
{
    return int(texels.word[setting.plane[p].texels + position * WORDS + (i >> 2)] >> (8 * (i & 3)) & 255u);
}

int state_of(int voxel) { return int(voxels.word[voxel * WORDS] & 255u); }
int class_of(int voxel) { return voxel_byte(voxel, 1); }
int voxel_feature(int voxel, int f) { return voxel_byte(voxel, 2 + f); }
int texel_class(int p, int position) { return texel_byte(p, position, 1); }
int texel_feature(int p, int position, int f) { return texel_byte(p, position, 2 + f); }

bool is_inside(int p, int position)
{
    return position >= 0 && position < setting.plane[p].positions && texel_byte(p, position, 0) != 0;
}

bool is_there(int voxel)
{
    return voxel >= 0 && state_of(voxel) >= MEASURED;
}

int row_of(int p, int position)
{
    return position < setting.plane[p].width * setting.plane[p].height ? setting.plane[p].width
                                                                       : setting.plane[p].height;
}

// What coordinate `to` of an axis adds to a voxel's index; -1: outside.
int step_of(int axis, int to)
{
    return tables.number[setting.steps_at[axis] + to + RADIUS];
}

// The voxel (x, y) beside one in a plane; -1: none.
int voxel_in_plane(ivec3 at, int p, int x, int y)
{
    int u = plane_u(p), v = plane_v(p);
    int along_u = step_of(u, at[u] + x), along_v = step_of(v, at[v] + y);
    return along_u < 0 || along_v < 0 ? -1 : step_of(p, at[p]) + along_u + along_v;
}

// The voxel `lag` beside `at`, which = 0..5: -x +x -y +y -z +z; -1: none.
int towards(ivec3 at, int which, int lag)
{
    int axis = which >> 1, to = at[axis] + ((which & 1) != 0 ? lag : -lag), index = 0;
    if (to < -RADIUS || to >= setting.size[axis] + RADIUS)
        return -1;
    for (int a = 0; a < 3; a++) {
        int along = step_of(a, a == axis ? to : at[a]);
        if (along < 0)
            return -1;
        index += along;
    }
    return index;
}

// Does the surface cut the voxel's windows (1) or not (0)? The twin of pv_grid_layer.
int layer_of(ivec3 at)
{
    for (int i = 0; i < 6; i++) {
        int other = towards(at, i, RADIUS);
        if (other < 0 || state_of(other) == 0)
            return 1;
    }
    return 0;
}

int bin_of(int axis, int lag, int a, int b)
{
    return tables.number[setting.bins_at[axis] + lag * CLASSES + abs(a - b)];
}

uvec4 draw_voxel(uint voxel, uint which)
{
    return philox(uvec4(voxel, push.sweep, which, DRAW_VOXEL), uvec2(push.seed_low, push.seed_high));
}

// The voxel of an item.
ivec3 place_of(int item)
{
    if (push.ordered != 0) {
        int voxel = int(order.voxel[item]), w = setting.size[0], h = setting.size[1];
        return ivec3(voxel % w, voxel / w % h, voxel / w / h);
    }
    int row = item / push.count[0];
    return ivec3(push.first[0] + item % push.count[0] * push.every[0],
                 push.first[1] + row % push.count[1] * push.every[1],
                 push.first[2] + row / push.count[1] * push.every[2]);
}

const int STEP_FACTORS = 2 * CLASSES, USE_FACTORS = STEP_FACTORS + 3 * LAGS * STEPS;

// Where the histogram of such a step counts.
int step_place(int axis, int lag, int a, int b)
{
    return STEP_FACTORS + (axis * LAGS + lag) * STEPS + bin_of(axis, lag, a, b);
}

void count_steps(ivec3 at, int voxel, int class_, int by)
{
    for (int l = 0; l < setting.lags; l++)
        for (int i = 0; i < 6; i++) {
            int other = towards(at, i, l == 0 ? 1 : FAR);
            if (is_there(other) && other != voxel)
                atomicAdd(tally.count[step_place(i >> 1, l, class_, class_of(other))], by);
        }
}
