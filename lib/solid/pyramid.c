/* Coarse structure first: a random start at the coarsest level, passes over it, and each level handed to the next by
 * its sources, so that the finer one begins as sharp as the sample (Lefebvre and Hoppe 2005). */
#include "solid/pyramid.h"

#include "util/random.h"

#include <string.h>

/* A coarse voxel is of the stone if one of its eight is; if one is measured it is too, with that value. */
static void coarsen_voxel(const pv_grid *fine, pv_grid *coarse, const int32_t at[3])
{
    int64_t to = pv_grid_at(coarse, at[0], at[1], at[2]);
    coarse->state[to] = PAVE_VOXEL_OUTSIDE;
    for (int i = 0; i < 8; i++) {
        int32_t x = 2 * at[0] + (i & 1), y = 2 * at[1] + (i >> 1 & 1), z = 2 * at[2] + (i >> 2);
        if (x >= fine->size[0] || y >= fine->size[1] || z >= fine->size[2])
            continue;
        int64_t from = pv_grid_at(fine, x, y, z);
        if (fine->state[from] == PAVE_VOXEL_MEASURED) {
            coarse->state[to] = PAVE_VOXEL_MEASURED;
            coarse->class[to] = fine->class[from];
            memcpy(coarse->feature + to * coarse->features, fine->feature + from * fine->features,
                   (size_t)fine->features);
            return;
        }
        if (fine->state[from] == PAVE_VOXEL_FREE)
            coarse->state[to] = PAVE_VOXEL_FREE;
    }
}

static pave_result coarsen(pave_context *context, const pv_grid *fine, pv_grid *coarse)
{
    int32_t size[3], at[3];
    for (int a = 0; a < 3; a++)
        size[a] = (fine->size[a] + 1) / 2;
    pave_result result = pv_grid_create(context, size, fine->periodic, fine->reach, fine->features, coarse);
    if (!result)
        result = pv_grid_open_sources(context, coarse);
    for (at[2] = 0; at[2] < size[2] && !result; at[2]++)
        for (at[1] = 0; at[1] < size[1]; at[1]++)
            for (at[0] = 0; at[0] < size[0]; at[0]++)
                coarsen_voxel(fine, coarse, at);
    return result;
}

static void set_from_source(pv_grid *grid, int64_t voxel, const pv_windows *bank, int32_t source)
{
    if (grid->state[voxel] == PAVE_VOXEL_MEASURED)
        return;
    grid->state[voxel] = PAVE_VOXEL_FILLED;
    grid->class[voxel] = bank->class[source];
    memcpy(grid->feature + voxel * grid->features, bank->feature + (size_t)source * (size_t)grid->features,
           (size_t)grid->features);
}

static void start_random(const pv_sampler *s)
{
    pv_grid *grid = s->grid;
    for (int64_t i = 0; i < grid->voxels; i++) {
        if (grid->state[i] == PAVE_VOXEL_OUTSIDE)
            continue;
        pv_random r = pv_draw(s->seed, PV_DRAW_START, (uint32_t)i, 1, 0);
        int p = (int)pv_below(r.word[3], PV_PLANES);
        for (int q = 0; q < PV_PLANES; q++)
            grid->source[q][i] = s->bank[q]->inner[pv_below(r.word[q], (uint32_t)s->bank[q]->inner_count)];
        set_from_source(grid, i, s->bank[p], grid->source[p][i]);
    }
}

/* The position at the finer level, for the child at (dx, dy) of a coarse texel. */
static int32_t finer(const pv_windows *coarse, const pv_windows *fine, int32_t position, int32_t dx, int32_t dy)
{
    int32_t area = coarse->width * coarse->height, copy = position / area, i = position % area;
    int32_t row = copy ? coarse->height : coarse->width, fine_row = copy ? fine->height : fine->width;
    return copy * fine->width * fine->height + (2 * (i / row) + dy) * fine_row + 2 * (i % row) + dx;
}

static void start_from_coarse(const pv_sampler *s, const pv_grid *coarse, const pv_windows *const bank[PV_PLANES])
{
    pv_grid *grid = s->grid;
    int32_t at[3];
    int64_t i = 0;
    for (at[2] = 0; at[2] < grid->size[2]; at[2]++)
        for (at[1] = 0; at[1] < grid->size[1]; at[1]++)
            for (at[0] = 0; at[0] < grid->size[0]; at[0]++, i++) {
                if (grid->state[i] == PAVE_VOXEL_OUTSIDE)
                    continue;
                int64_t from = pv_grid_at(coarse, at[0] / 2, at[1] / 2, at[2] / 2);
                for (int p = 0; p < PV_PLANES; p++)
                    grid->source[p][i] = finer(bank[p], s->bank[p], coarse->source[p][from], at[pv_plane_u(p)] & 1,
                                               at[pv_plane_v(p)] & 1);
                int p = (int)pv_below(pv_draw(s->seed, PV_DRAW_START, (uint32_t)(from), 2, 0).word[0], PV_PLANES);
                set_from_source(grid, i, s->bank[p], grid->source[p][i]);
            }
}

static pave_result passes(pave_context *context, const pv_recipe *recipe, const pv_sampler *sampler, double from,
                          double to)
{
    pv_work work;
    pave_result result = pv_work_begin(context, sampler, &work);
    work.weight_class = recipe->weight_class;
    work.weight_step = recipe->weight_step;
    work.weight_use = recipe->weight_use;
    work.sampler.agree = recipe->agree;
    work.sampler.steps = 1;
    if (!result)
        pv_work_count(&work);
    for (int32_t i = 0; i < recipe->passes && !result; i++) {
        int32_t last = recipe->passes > 1 ? recipe->passes - 1 : 1;
        work.sampler.temperature = recipe->hot + (recipe->cold - recipe->hot) * i / last;
        result = pv_work_pass(&work, from + (to - from) * i / recipe->passes,
                              from + (to - from) * (i + 1) / recipe->passes);
    }
    return pv_work_end(&work, result);
}

static pave_result make_banks(pave_context *context, const pv_pyramid *pyramid, int32_t level,
                              pv_windows own[PV_PLANES], const pv_windows *bank[PV_PLANES])
{
    pave_result result = PAVE_OK;
    for (int p = 0; p < PV_PLANES && !result; p++) {
        bank[p] = &own[pyramid->same ? 0 : p];
        if (p == 0 || !pyramid->same)
            result = pv_windows_create(context, &pyramid->texels[level][p], pyramid->side, pyramid->sigma,
                                       pyramid->same, 1, pyramid->seed, &own[p]);
    }
    return result;
}

/* Makes a level after the coarser ones; `to` is its share of the work, and an eighth of it the next's. */
static pave_result run_level(pave_context *context, const pv_pyramid *pyramid, int32_t level, pv_grid *grid, double to)
{
    pv_grid coarse = { 0 };
    pv_windows own[2][PV_PLANES];
    const pv_windows *bank[2][PV_PLANES];
    double from = level + 1 < pyramid->levels ? to / 8 : 0;
    pave_result result = PAVE_OK;
    memset(own, 0, sizeof own);
    if (level + 1 < pyramid->levels)
        result = coarsen(context, grid, &coarse);
    if (!result && coarse.voxels)
        result = run_level(context, pyramid, level + 1, &coarse, from);
    if (!result && coarse.voxels)
        result = make_banks(context, pyramid, level + 1, own[1], bank[1]);
    if (!result)
        result = make_banks(context, pyramid, level, own[0], bank[0]);
    pv_sampler s = { .grid = grid, .seed = pyramid->seed + (uint64_t)level * 7919, .labels = pyramid->labels };
    memcpy(s.bank, bank[0], sizeof s.bank);
    if (!result && coarse.voxels)
        start_from_coarse(&s, &coarse, bank[1]);
    else if (!result)
        start_random(&s);
    pv_grid_free(&coarse);
    if (!result)
        result = passes(context, &pyramid->recipe[level], &s, from, to);
    for (int i = 0; i < 2 * PV_PLANES; i++)
        pv_windows_free(&own[i / PV_PLANES][i % PV_PLANES]);
    return result;
}

pave_result pv_pyramid_run(pave_context *context, pv_pyramid *pyramid, pv_grid *grid)
{
    return run_level(context, pyramid, 0, grid, 1);
}
