/* Rank matching, by counting instead of sorting. */
#include "solid/match.h"

#include "util/random.h"

enum { MEANS = 2048, KEYS = PV_CLASSES * MEANS };

static uint32_t key_of(const pv_grid *grid, int64_t voxel, const int32_t at[3])
{
    uint32_t sum = 0, count = 0;
    for (int i = 0; i < 6; i++) {
        int64_t beside = pv_grid_beside(grid, at, i);
        if (beside >= 0 && grid->state[beside] != PAVE_VOXEL_OUTSIDE)
            sum += grid->class[beside], count++;
    }
    return grid->class[voxel] * (uint32_t)MEANS + (count ? sum * 8 / count : 0);
}

typedef void visit(void *data, int64_t voxel, uint32_t key);

static void each(const pv_grid *grid, visit *visitor, void *data)
{
    int32_t at[3];
    int64_t i = 0;
    for (at[2] = 0; at[2] < grid->size[2]; at[2]++)
        for (at[1] = 0; at[1] < grid->size[1]; at[1]++)
            for (at[0] = 0; at[0] < grid->size[0]; at[0]++, i++)
                if (grid->state[i] == PAVE_VOXEL_FILLED)
                    visitor(data, i, key_of(grid, i, at));
}

typedef struct matching {
    uint32_t *first, *many; /* [key]: the first rank, and how many share it */
    uint32_t *ranks;
    uint64_t seed;
} matching;

static void count_key(void *data, int64_t voxel, uint32_t key)
{
    (void)voxel;
    ((matching *)data)->many[key]++;
}

static void draw_rank(void *data, int64_t voxel, uint32_t key)
{
    matching *m = data;
    uint32_t chance = pv_draw(m->seed, PV_DRAW_RANK, (uint32_t)voxel, 0, 0).word[0];
    m->ranks[voxel] = m->first[key] + pv_below(chance, m->many[key]);
}

pave_result pv_match_ranks(pave_context *context, const pv_grid *grid, uint64_t seed, uint32_t *ranks, int64_t *count)
{
    pave_result result = PAVE_OK;
    matching m = { NULL, NULL, ranks, seed };
    m.first = pv_allocate_zeroed(context, KEYS, sizeof *m.first, &result);
    m.many = m.first ? pv_allocate_zeroed(context, KEYS, sizeof *m.many, &result) : NULL;
    *count = 0;
    if (m.many) {
        each(grid, count_key, &m);
        for (int32_t k = 0; k < KEYS; k++) {
            m.first[k] = (uint32_t)*count;
            *count += m.many[k];
        }
        each(grid, draw_rank, &m);
        result = PAVE_OK;
    }
    pv_release(m.first);
    pv_release(m.many);
    return result;
}
