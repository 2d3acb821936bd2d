/* Priority flood from many seeds at once: each voxel goes to the seed whose front reaches it first, which makes Voronoi
 * cells (Fig. 3). */
#include "solid/grow.h"

#include "util/random.h"

#include <string.h>

typedef struct front {
    uint64_t key; /* squared distance from the seed, then a random number, so that no direction comes first */
    uint32_t voxel;
    int32_t seed;
} front;

typedef struct growth {
    pave_context *context;
    const pv_grid *grid;
    pv_flood *flood;
    uint64_t seed;
    front *heap;
    int64_t size, room;
    int32_t (*at)[3]; /* of each seed */
    int64_t seed_room;
} growth;

static int before(const front *a, const front *b)
{
    return a->key != b->key ? a->key < b->key : a->voxel != b->voxel ? a->voxel < b->voxel : a->seed < b->seed;
}

static pave_result push(growth *g, front f)
{
    pave_result result = PAVE_OK;
    if (g->size == g->room) {
        front *grown = pv_resize(g->context, g->heap, (size_t)g->room, (size_t)g->room * 2, sizeof *grown, &result);
        if (!grown)
            return result;
        g->heap = grown;
        g->room *= 2;
    }
    int64_t i = g->size++;
    for (; i > 0 && before(&f, &g->heap[(i - 1) / 2]); i = (i - 1) / 2)
        g->heap[i] = g->heap[(i - 1) / 2];
    g->heap[i] = f;
    return PAVE_OK;
}

static front pop(growth *g)
{
    front top = g->heap[0], last = g->heap[--g->size];
    int64_t i = 0;
    for (int64_t child; (child = 2 * i + 1) < g->size; i = child) {
        if (child + 1 < g->size && before(&g->heap[child + 1], &g->heap[child]))
            child++;
        if (before(&last, &g->heap[child]))
            break;
        g->heap[i] = g->heap[child];
    }
    g->heap[i] = last;
    return top;
}

static void place(const pv_grid *grid, uint32_t voxel, int32_t at[3])
{
    at[0] = (int32_t)(voxel % (uint32_t)grid->size[0]);
    at[1] = (int32_t)(voxel / (uint32_t)grid->size[0] % (uint32_t)grid->size[1]);
    at[2] = (int32_t)(voxel / (uint32_t)grid->size[0] / (uint32_t)grid->size[1]);
}

static uint64_t distance(const pv_grid *grid, const int32_t a[3], const int32_t b[3])
{
    uint64_t sum = 0;
    for (int k = 0; k < 3; k++) {
        int64_t d = a[k] < b[k] ? b[k] - a[k] : a[k] - b[k];
        if (grid->periodic && grid->size[k] - d < d)
            d = grid->size[k] - d;
        sum += (uint64_t)(d * d);
    }
    return sum;
}

static pave_result reach(growth *g, int64_t voxel, int32_t seed)
{
    int32_t at[3];
    if (voxel < 0 || g->grid->state[voxel] == PAVE_VOXEL_OUTSIDE || g->flood->cells[voxel] >= 0)
        return PAVE_OK;
    place(g->grid, (uint32_t)voxel, at);
    uint32_t chance = pv_draw(g->seed, PV_DRAW_SEED, (uint32_t)voxel, 0, 1).word[0];
    uint64_t far = distance(g->grid, at, g->at[seed]);
    return push(g, (front){ far << 24 | chance >> 8, (uint32_t)voxel, seed });
}

static pave_result add_seed(growth *g, int64_t voxel)
{
    pave_result result = PAVE_OK;
    if (g->flood->seeds == g->seed_room) {
        void *grown = pv_resize(g->context, g->at, (size_t)g->seed_room, (size_t)g->seed_room * 2, sizeof *g->at,
                                &result);
        if (!grown)
            return result;
        g->at = grown;
        g->seed_room *= 2;
    }
    place(g->grid, (uint32_t)voxel, g->at[g->flood->seeds]);
    return reach(g, voxel, g->flood->seeds++);
}

/* Measured voxels, or random ones of the stone: the n-th by chance, n drawn for each seed. */
static pave_result add_seeds(growth *g, int32_t wanted)
{
    const pv_grid *grid = g->grid;
    pave_result result = PAVE_OK;
    int64_t inside = 0;
    for (int64_t i = 0; i < grid->voxels && !result; i++) {
        inside += grid->state[i] == PAVE_VOXEL_FREE;
        if (grid->state[i] == PAVE_VOXEL_MEASURED)
            result = add_seed(g, i);
    }
    if (g->flood->seeds || !inside)
        return result;
    for (uint32_t i = 0, tries = 0; i < (uint32_t)wanted && tries < 64u * (uint32_t)wanted && !result; tries++) {
        pv_random r = pv_draw(g->seed, PV_DRAW_SEED, tries, 0, 0);
        int64_t voxel = pv_grid_at(grid, (int32_t)pv_below(r.word[0], (uint32_t)grid->size[0]),
                                   (int32_t)pv_below(r.word[1], (uint32_t)grid->size[1]),
                                   (int32_t)pv_below(r.word[2], (uint32_t)grid->size[2]));
        if (grid->state[voxel] == PAVE_VOXEL_FREE)
            result = add_seed(g, voxel), i++;
    }
    return result;
}

static pave_result grow(growth *g)
{
    enum { BATCH = 4096 };
    pv_flood *flood = g->flood;
    pave_result result = PAVE_OK;
    while (g->size && !result) {
        front f = pop(g);
        int32_t at[3];
        if (flood->cells[f.voxel] >= 0)
            continue;
        flood->cells[f.voxel] = f.seed;
        if (g->grid->state[f.voxel] == PAVE_VOXEL_FREE)
            flood->order[flood->count++] = f.voxel;
        place(g->grid, f.voxel, at);
        for (int i = 0; i < 6 && !result; i++)
            result = reach(g, pv_grid_beside(g->grid, at, i), f.seed);
        if (!result && flood->count % BATCH == 0)
            result = pv_progress(g->context, 0);
    }
    return result;
}

/* Parts of the stone without a seed get one. */
static pave_result grow_everywhere(growth *g)
{
    pave_result result = grow(g);
    int32_t more = 0;
    for (int64_t i = 0; i < g->grid->voxels && !result; i++) {
        if (g->grid->state[i] == PAVE_VOXEL_OUTSIDE || g->flood->cells[i] >= 0)
            continue;
        result = add_seed(g, i);
        if (!result)
            result = grow(g);
        more++;
    }
    if (more && !result)
        pv_note(g->context, PAVE_MESSAGE_INFO, "%d parts of the stone had no seed and got one", (int)more);
    return result;
}

static int32_t level_of(const pv_grid *grid, const int32_t *level, uint32_t voxel)
{
    int32_t at[3], most = 0, r = grid->reach;
    place(grid, voxel, at);
    for (int p = 0; p < PV_PLANES; p++) {
        int u = pv_plane_u(p), v = pv_plane_v(p);
        int64_t here = grid->step[p][at[p] + r];
        for (int32_t y = 0; y <= 2 * r; y++)
            for (int32_t x = 0; x <= 2 * r; x++) {
                int64_t su = grid->step[u][at[u] + x], sv = grid->step[v][at[v] + y];
                if (su >= 0 && sv >= 0 && level[here + su + sv] > most)
                    most = level[here + su + sv];
            }
    }
    for (int i = 0; i < 6 && pv_grid_lags(grid) > 1; i++) { /* steps between voxels that far apart count, too */
        int64_t other = pv_grid_towards(grid, at, i, PV_FAR);
        if (other >= 0 && level[other] > most)
            most = level[other];
    }
    return most + 1;
}

/* Regroups the order by level, keeping it within a level. */
static pave_result group(growth *g, int32_t *level)
{
    enum { BATCH = 4096 };
    pv_flood *flood = g->flood;
    pave_result result = PAVE_OK;
    for (int64_t i = 0; i < flood->count && !result; i++) {
        int32_t l = level[flood->order[i]] = level_of(g->grid, level, flood->order[i]);
        flood->levels = l > flood->levels ? l : flood->levels;
        if (i % BATCH == 0)
            result = pv_progress(g->context, 0);
    }
    if (!result)
        flood->level = pv_allocate_zeroed(g->context, (size_t)flood->levels + 2, sizeof *flood->level, &result);
    uint32_t *sorted = result ? NULL : pv_allocate(g->context, (size_t)flood->count, sizeof *sorted, &result);
    if (result)
        return result;
    for (int64_t i = 0; i < flood->count; i++)
        flood->level[level[flood->order[i]] + 1]++;
    for (int32_t l = 0; l <= flood->levels; l++)
        flood->level[l + 1] += flood->level[l];
    for (int64_t i = 0; i < flood->count; i++)
        sorted[flood->level[level[flood->order[i]]]++] = flood->order[i];
    pv_release(flood->order);
    flood->order = sorted;
    return PAVE_OK;
}

pave_result pv_flood_create(pave_context *context, const pv_grid *grid, int32_t seeds, uint64_t seed, pv_flood *flood)
{
    enum { ROOM = 1024 };
    pave_result result = PAVE_OK;
    growth g = { context, grid, flood, seed, NULL, 0, ROOM, NULL, ROOM };
    size_t n = (size_t)grid->voxels;
    int32_t *level = NULL;
    memset(flood, 0, sizeof *flood);
    flood->cells = pv_allocate(context, n, sizeof *flood->cells, &result);
    flood->order = result ? NULL : pv_allocate(context, n, sizeof *flood->order, &result);
    g.heap = result ? NULL : pv_allocate(context, ROOM, sizeof *g.heap, &result);
    g.at = result ? NULL : pv_allocate(context, ROOM, sizeof *g.at, &result);
    if (!result) {
        memset(flood->cells, -1, n * sizeof *flood->cells);
        result = add_seeds(&g, seeds);
    }
    if (!result)
        result = grow_everywhere(&g);
    pv_release(g.heap);
    pv_release(g.at);
    if (!result)
        level = pv_allocate_zeroed(context, n, sizeof *level, &result);
    if (!result)
        result = group(&g, level);
    pv_release(level);
    if (result)
        pv_flood_free(flood);
    return result;
}

void pv_flood_free(pv_flood *flood)
{
    pv_release(flood->order);
    pv_release(flood->level);
    pv_release(flood->cells);
    memset(flood, 0, sizeof *flood);
}
