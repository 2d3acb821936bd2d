// One voxel of stone an invocation, by all three planes at once: the GLSL twin of lib/solid/sample.c.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "voxels.glsl"

layout(local_size_x = 64) in;

const int KEPT = 6, MOST_LISTED = 64, FORCED = 8, FORCED_AGREE = 1024, MEASURED_WEIGHT = 4, COMPANY = 3;
const int64_t MOST = 0x7fffffffffffffffl;

ivec3 at;
int voxel, layer;
bool forced; // the value is measured
uvec4 chance;

// Of the plane at hand.
int patch_[TAPS * FEATURES];
int presence[TAPS];
int listed[MOST_LISTED], listed_count;
uint64_t known;
int64_t present;

// Of all three.
int kept[3][KEPT], kept_count[3];
int64_t kept_distance[3][KEPT], weight[3];

int root_of(int p, int tap) { return tables.number[setting.plane[p].root + tap]; }

void gather(int p)
{
    int64_t area = 0;
    present = 0;
    for (int tap = 0; tap < TAPS; tap++) {
        int other = voxel_in_plane(at, p, tap % SIDE - RADIUS, tap / SIDE - RADIUS), root = root_of(p, tap);
        int there = !is_there(other) ? 0 : state_of(other) == MEASURED ? MEASURED_WEIGHT : 1;
        area += there != 0 ? root * root : 0;
        present += root * root * there * there;
        presence[tap] = there;
        for (int f = 0; f < FEATURES; f++)
            patch_[tap * FEATURES + f] = there != 0 ? voxel_feature(other, f) * root : 0;
    }
    weight[p] = 1 + area * 256 / setting.plane[p].total;
}

void list(int p, int position)
{
    if (!is_inside(p, position))
        return;
    uint64_t bit = uint64_t(1) << (uint(position) * 2654435769u >> 26);
    if ((known & bit) != 0)
        for (int i = 0; i < listed_count; i++)
            if (listed[i] == position)
                return;
    known |= bit;
    if (listed_count < MOST_LISTED)
        listed[listed_count++] = position;
}

void list_with_alike(int p, int position, int alike)
{
    list(p, position);
    for (int k = 0; k < alike && is_inside(p, position); k++)
        list(p, tables.number[setting.plane[p].nearest + position * NEAREST + k]);
}

void list_coherent(int p)
{
    for (int y = -1; y <= 1; y++)
        for (int x = -1; x <= 1; x++) {
            int other = voxel_in_plane(at, p, x, y), source = is_there(other) ? source_of(p, other) : -1;
            if (source >= 0)
                list_with_alike(p, source - y * row_of(p, source) - x, x != 0 && y != 0 ? 1 : NEAREST);
        }
    for (int q = 0; q < 3; q++)
        if (q != p && setting.plane[q].texels == setting.plane[p].texels && is_there(voxel))
            list(p, source_of(q, voxel));
}

void list_random(int p)
{
    int inner = setting.plane[p].inner;
    list(p, tables.number[inner + int(below(chance[1 + p], uint(setting.plane[p].inner_count)))]);
    if (!forced)
        return;
    int start = setting.plane[p].class_start + class_of(voxel);
    int from = tables.number[start], to = tables.number[start + 1];
    for (uint i = 0; i < FORCED && to > from; i++)
        list(p, tables.number[inner + from + int(below(draw_voxel(uint(voxel), 1 + i)[p], uint(to - from)))]);
}

int distance_to(int p, int position)
{
    int sum = 0, row = row_of(p, position);
    for (int tap = 0; tap < TAPS; tap++) {
        if (presence[tap] == 0)
            continue;
        int theirs = position + (tap / SIDE - RADIUS) * row + tap % SIDE - RADIUS, root = root_of(p, tap);
        for (int f = 0; f < FEATURES; f++) {
            int d = (texel_feature(p, theirs, f) * root - patch_[tap * FEATURES + f]) * presence[tap];
            sum += d * d;
        }
    }
    return sum;
}

void keep(int p, int position, int64_t distance)
{
    int i = kept_count[p];
    if (i == KEPT && distance >= kept_distance[p][KEPT - 1])
        return;
    if (i < KEPT)
        kept_count[p]++;
    else
        i--;
    for (; i > 0 && distance < kept_distance[p][i - 1]; i--) {
        kept[p][i] = kept[p][i - 1];
        kept_distance[p][i] = kept_distance[p][i - 1];
    }
    kept[p][i] = position;
    kept_distance[p][i] = distance;
}

void keep_best(int p)
{
    int64_t least = int64_t(packUint2x32(uvec2(setting.plane[p].floor_low, setting.plane[p].floor_high)));
    kept_count[p] = 0;
    for (int i = 0; i < listed_count; i++) {
        int64_t d = present != 0 ? int64_t(distance_to(p, listed[i])) * setting.plane[p].total / present : 0;
        d += least;
        if (push.steered != 0)
            d = d * int64_t(control.factor[USE_FACTORS + setting.plane[p].use + listed[i]]) >> 8;
        keep(p, listed[i], d);
    }
}

// What it costs if the voxel has the value of texel (of, position), or, for of = -1, its own.
int value_of(int of, int position, int f)
{
    return of < 0 ? voxel_feature(voxel, f) : texel_feature(of, position, f);
}

int64_t value_distance(int p, int position, int of, int value)
{
    int64_t d = 0;
    for (int f = 0; f < FEATURES; f++) {
        int64_t one = texel_feature(p, position, f) - value_of(of, value, f);
        d += one * one;
    }
    return d * setting.plane[p].centre * (forced ? FORCED_AGREE : push.agree) >> 6;
}

int64_t value_cost(int of, int value, out ivec3 source)
{
    int64_t cost = 0;
    for (int p = 0; p < 3; p++) {
        int64_t least = MOST;
        source[p] = -1;
        for (int i = 0; i < kept_count[p] && kept_distance[p][i] < least; i++) {
            int64_t d = kept_distance[p][i] + value_distance(p, kept[p][i], of, value);
            if (d < least) {
                least = d;
                source[p] = kept[p][i];
            }
        }
        cost += kept_count[p] != 0 ? least * weight[p] >> 8 : 0;
    }
    return cost;
}

bool are_like(int p, int a, int b)
{
    int least = bin_of(p, 0, 0, 0), bin = bin_of(p, 0, a, b);
    return bin <= least || bin < STEPS / 2;
}

int loneliness(int measured, int which, int class_)
{
    ivec3 there = at;
    int alike = 0, axis = which >> 1;
    if (are_like(axis, class_, class_of(measured)))
        return 1;
    there[axis] = (there[axis] + ((which & 1) != 0 ? 1 : -1) + setting.size[axis]) % setting.size[axis];
    for (int i = 0; i < 6; i++) {
        int beside = towards(there, i, 1);
        if (beside != voxel && is_there(beside) && are_like(axis, class_of(measured), class_of(beside)))
            alike++;
    }
    return alike < COMPANY ? 1 + 2 * (COMPANY - alike) : 1;
}

int64_t steered(int64_t cost, int class_)
{
    if (push.steered == 0)
        return cost;
    cost = cost * int64_t(control.factor[layer * CLASSES + class_]) >> 8;
    int alike = 0, others = 0;
    for (int l = 0; l < setting.lags && push.steps != 0; l++) {
        int64_t sum = 0, count = 0;
        for (int i = 0; i < 6; i++) {
            int other = towards(at, i, l == 0 ? 1 : FAR);
            if (!is_there(other))
                continue;
            if (l == 0 && state_of(other) == MEASURED)
                cost *= loneliness(other, i, class_);
            alike += l == 0 && class_of(other) == class_ ? 1 : 0;
            others += l == 0 ? 1 : 0;
            sum += control.factor[step_place(i >> 1, l, class_, class_of(other))];
            count++;
        }
        cost = count != 0 ? cost * sum / (256 * count) : cost;
    }
    return setting.labels != 0 && others > 3 && alike == 0 ? 2 * cost : cost;
}

bool same_value(int p, int a, int q, int b)
{
    bool same = texel_class(p, a) == texel_class(q, b);
    for (int f = 0; f < FEATURES; f++)
        same = same && texel_feature(p, a, f) == texel_feature(q, b, f);
    return same;
}

void store(ivec3 source, int p, int value)
{
    bool was = is_there(voxel);
    for (int q = 0; q < 3; q++) {
        int before = source_of(q, voxel), use = USE_FACTORS + setting.plane[q].use;
        if (before >= 0)
            atomicAdd(tally.count[use + before], -1);
        if (source[q] >= 0)
            atomicAdd(tally.count[use + source[q]], 1);
        set_source(q, voxel, source[q]);
    }
    if (forced)
        return;
    int class_ = texel_class(p, value), old = class_of(voxel);
    if (!was || old != class_) {
        if (was) {
            count_steps(at, voxel, old, -1);
            atomicAdd(tally.count[layer * CLASSES + old], -1);
        }
        count_steps(at, voxel, class_, 1);
        atomicAdd(tally.count[layer * CLASSES + class_], 1);
    }
    for (int i = 0; i < WORDS; i++) {
        uint word = texels.word[setting.plane[p].texels + value * WORDS + i];
        voxels.word[voxel * WORDS + i] = i == 0 ? word & ~255u | uint(FILLED) : word;
    }
}

void choose()
{
    int value[3 * KEPT], of[3 * KEPT], count = 0, within = 0;
    int64_t cost[3 * KEPT], least = MOST;
    ivec3 source;
    for (int p = 0; p < 3; p++)
        for (int i = 0; i < kept_count[p]; i++) {
            bool known_ = false;
            for (int k = 0; k < count && !known_; k++)
                known_ = same_value(of[k], value[k], p, kept[p][i]);
            if (!known_) {
                of[count] = p;
                value[count++] = kept[p][i];
            }
        }
    for (int i = 0; i < count; i++) {
        cost[i] = steered(value_cost(of[i], value[i], source), texel_class(of[i], value[i]));
        least = min(least, cost[i]);
    }
    int64_t most = least + (least * push.temperature >> 8);
    for (int i = 0; i < count; i++)
        within += cost[i] <= most ? 1 : 0;
    int drawn = int(below(chance[0], uint(within)));
    for (int i = 0; i < count; i++)
        if (cost[i] <= most && drawn-- == 0) {
            value_cost(of[i], value[i], source);
            store(source, of[i], value[i]);
            return;
        }
}

void main()
{
    int item = int(gl_GlobalInvocationID.x);
    if (item >= push.items)
        return;
    at = place_of(push.base + item);
    voxel = step_of(0, at.x) + step_of(1, at.y) + step_of(2, at.z);
    int state = state_of(voxel);
    if (state == 0)
        return;
    layer = layer_of(at);
    forced = state == MEASURED;
    chance = draw_voxel(uint(voxel), 0);
    for (int p = 0; p < 3; p++) {
        listed_count = 0;
        known = 0;
        gather(p);
        list_coherent(p);
        list_random(p);
        keep_best(p);
    }
    ivec3 source;
    if (forced) {
        value_cost(-1, 0, source);
        store(source, 0, 0);
    } else
        choose();
}
