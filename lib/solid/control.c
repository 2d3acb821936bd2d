/* Passes over the volume. Which voxels are done together depends on the volume alone, and what they read is fixed
 * before they are: so any number of threads gives the same bytes. */
#include "solid/control.h"

#include "base/parallel.h"
#include "util/random.h"

#include <stdlib.h>
#include <string.h>

static int shares_bank(const pv_work *work, int p)
{
    return p > 0 && work->sampler.bank[p] == work->sampler.bank[0];
}

/* Along an axis the two planes that it lies in say how much voxels differ; one sample for all has no directions. */
static void make_steps(pv_work *work, int axis, int lag)
{
    int64_t counts[PV_CLASSES] = { 0 };
    for (int p = 0; p < PV_PLANES; p++) {
        const pv_windows *bank = work->sampler.bank[p];
        for (int d = 0; d < PV_CLASSES && p != axis; d++)
            counts[d] += bank->copies == 2 ? bank->apart[0][lag][d] + bank->apart[1][lag][d]
                                           : bank->apart[pv_plane_v(p) == axis][lag][d];
    }
    pv_steps_create(counts, &work->step[axis][lag]);
    for (int s = 0; s < PV_STEPS; s++)
        work->control.push[axis][lag][s] = 1;
}

pave_result pv_work_begin(pave_context *context, const pv_sampler *sampler, pv_work *work)
{
    pave_result result = PAVE_OK;
    memset(work, 0, sizeof *work);
    work->context = context;
    work->sampler = *sampler;
    work->sampler.step = work->step;
    work->sampler.distances = pv_distances_choose(context->backend == PAVE_BACKEND_CPU_PORTABLE);
    work->weight_class = work->weight_step = 256;
    work->weight_use = 128;
    for (int i = 0; i < 3 * PV_LAGS; i++)
        make_steps(work, i / PV_LAGS, i % PV_LAGS);
    work->workers = pv_workers(context);
    work->scratch = pv_allocate_zeroed(context, (size_t)work->workers, sizeof *work->scratch, &result);
    for (int32_t i = 0; i < work->workers && !result; i++)
        result = pv_scratch_create(context, sampler, &work->scratch[i]);
    for (int p = 0; p < PV_PLANES && !result; p++) {
        size_t n = (size_t)sampler->bank[p]->positions;
        if (shares_bank(work, p)) {
            work->control.uses[p] = work->control.uses[0];
            work->control.use_factor[p] = work->control.use_factor[0];
            continue;
        }
        work->control.uses[p] = pv_allocate_zeroed(context, n, sizeof(int32_t), &result);
        if (!result)
            work->control.use_factor[p] = pv_allocate_zeroed(context, n, sizeof(uint16_t), &result);
    }
    int on_device = context->backend == PAVE_BACKEND_VULKAN_COMPUTE || context->backend == PAVE_BACKEND_VULKAN_RASTER;
    return result || !on_device ? result : pv_device_open(context, &work->sampler, &work->device);
}

pave_result pv_work_end(pv_work *work, pave_result result)
{
    if (!result && work->device)
        result = pv_device_fetch(work->device, &work->sampler);
    pv_device_close(work->device);
    for (int32_t i = 0; i < work->workers && work->scratch; i++)
        pv_scratch_free(&work->scratch[i]);
    pv_release(work->scratch);
    for (int p = 0; p < PV_PLANES; p++)
        if (!shares_bank(work, p)) {
            pv_release(work->control.uses[p]);
            pv_release(work->control.use_factor[p]);
        }
    memset(work, 0, sizeof *work);
    return result;
}

/* have / wanted, to the power of weight (in 256ths, as a blend of powers 0, 1, 2), held within 1/8 and 8. */
static uint32_t factor(int64_t have, int64_t all, int64_t wanted, int64_t wanted_all, int32_t weight)
{
    double ratio = ((double)have / (double)all + 1e-4) / ((double)wanted / (double)wanted_all + 1e-4);
    double power = weight <= 256 ? 1 + (ratio - 1) * weight / 256 : ratio * (1 + (ratio - 1) * (weight - 256) / 256);
    power = power < 0.125 ? 0.125 : power > 8 ? 8 : power;
    return (uint32_t)(256 * power + 0.5);
}

static void freeze_uses(pv_work *work, int p)
{
    pv_control *control = &work->control;
    const pv_windows *bank = work->sampler.bank[p];
    int64_t all = 0;
    for (int32_t i = 0; i < bank->positions; i++)
        all += control->uses[p][i];
    for (int32_t i = 0; i < bank->positions; i++) {
        int64_t over = control->uses[p][i] * (int64_t)bank->inner_count - all;
        int64_t penalty = over > 0 && all > 0 ? over * work->weight_use / all : 0;
        control->use_factor[p][i] = (uint16_t)(256 + (penalty < 8192 ? penalty : 8192));
    }
}

/* A factor that knows the present only settles where it still is wrong: what stays off its target is pushed more and
 * more, as by the integral part of a controller. */
static double push_more(double push, uint32_t off)
{
    enum { SLOWLY = 1024 };
    push *= 1 + ((double)off - 256) / SLOWLY;
    return push < 0.25 ? 0.25 : push > 4 ? 4 : push;
}

static void freeze_steps(pv_work *work, int axis, int lag)
{
    pv_control *control = &work->control;
    const pv_steps *wanted = &work->step[axis][lag];
    int64_t all = 0;
    for (int s = 0; s < PV_STEPS; s++)
        all += control->steps[axis][lag][s];
    for (int s = 0; s < PV_STEPS; s++) {
        double *push = &control->push[axis][lag][s];
        uint32_t off = 256;
        if (all > 0 && wanted->total)
            off = factor(control->steps[axis][lag][s], all, wanted->target[s], wanted->total, work->weight_step);
        *push = push_more(*push, off);
        control->step_factor[axis][lag][s] = (uint32_t)(off * *push + 0.5);
    }
}

static void freeze_classes(pv_work *work, int layer)
{
    const pv_windows *bank = work->sampler.bank[0];
    const int64_t *have = work->control.classes[layer];
    int64_t all = 0;
    for (int c = 0; c < PV_CLASSES; c++)
        all += have[c];
    for (int c = 0; c < PV_CLASSES; c++)
        work->control.class_factor[layer][c] =
            all ? factor(have[c], all, bank->target[c], bank->target_total, work->weight_class) : 256;
}

static pave_result freeze(pv_work *work)
{
    pv_control *control = &work->control;
    for (int layer = 0; layer < PV_LAYERS; layer++)
        freeze_classes(work, layer);
    for (int i = 0; i < 3 * PV_LAGS; i++)
        freeze_steps(work, i / PV_LAGS, i % PV_LAGS);
    for (int p = 0; p < PV_PLANES; p++)
        if (!shares_bank(work, p))
            freeze_uses(work, p);
    return work->device ? pv_device_steer(work->device, &work->sampler, control) : PAVE_OK;
}

static void add_tally(pv_control *control, pv_tally *tally, const pv_sampler *sampler)
{
    for (int c = 0; c < PV_LAYERS * PV_CLASSES; c++)
        control->classes[c / PV_CLASSES][c % PV_CLASSES] += tally->classes[c / PV_CLASSES][c % PV_CLASSES];
    for (int a = 0; a < 3; a++)
        for (int s = 0; s < PV_LAGS * PV_STEPS; s++)
            control->steps[a][s / PV_STEPS][s % PV_STEPS] += tally->steps[a][s / PV_STEPS][s % PV_STEPS];
    memset(tally->classes, 0, sizeof tally->classes);
    memset(tally->steps, 0, sizeof tally->steps);
    for (int p = 0; p < PV_PLANES; p++) {
        for (int32_t i = 0; i < sampler->bank[p]->positions; i++)
            control->uses[p][i] += tally->uses[p][i];
        memset(tally->uses[p], 0, (size_t)sampler->bank[p]->positions * sizeof *tally->uses[p]);
    }
}

static pave_result settle(pv_work *work)
{
    if (work->device)
        return pv_device_settle(work->device, &work->sampler, &work->control);
    for (int32_t i = 0; i < work->workers; i++)
        add_tally(&work->control, &work->scratch[i].tally, &work->sampler);
    return PAVE_OK;
}

void pv_work_count(pv_work *work)
{
    pv_control *control = &work->control;
    const pv_grid *grid = work->sampler.grid;
    memset(control->classes, 0, sizeof control->classes);
    memset(control->steps, 0, sizeof control->steps);
    for (int p = 0; p < PV_PLANES; p++)
        memset(control->uses[p], 0, (size_t)work->sampler.bank[p]->positions * sizeof **control->uses);
    int32_t at[3];
    int64_t i = 0;
    for (at[2] = 0; at[2] < grid->size[2]; at[2]++)
        for (at[1] = 0; at[1] < grid->size[1]; at[1]++)
            for (at[0] = 0; at[0] < grid->size[0]; at[0]++, i++) {
                if (grid->state[i] < PAVE_VOXEL_MEASURED)
                    continue;
                control->classes[pv_grid_layer(grid, at)][grid->class[i]]++;
                for (int k = 0; k < 3 * pv_grid_lags(grid); k++) {
                    int64_t other = pv_grid_towards(grid, at, 2 * (k % 3) + 1, k < 3 ? 1 : PV_FAR);
                    if (other >= 0 && grid->state[other] >= PAVE_VOXEL_MEASURED)
                        control->steps[k % 3][k / 3][work->step[k % 3][k / 3]
                                                         .bin[abs(grid->class[i] - grid->class[other])]]++;
                }
                for (int p = 0; p < PV_PLANES; p++)
                    if (grid->source[p][i] >= 0)
                        control->uses[p][grid->source[p][i]]++;
            }
}

/* Coordinates of one class are further apart than the window reaches, also around the end of a periodic axis. */
static pv_lane lane_of(const pv_grid *grid, int axis, int32_t class)
{
    int32_t n = grid->size[axis], every = grid->reach + 1, regular = grid->periodic ? n - n % every : n;
    if (class >= every)
        return (pv_lane){ regular + class - every, 1, 1 };
    return (pv_lane){ class, every, (regular - class + every - 1) / every };
}

static int32_t lane_classes(const pv_grid *grid, int axis)
{
    int32_t n = grid->size[axis], every = grid->reach + 1;
    if (n <= every)
        return n;
    return grid->periodic ? every + n % every : every;
}

typedef struct colour {
    pv_work *work;
    pv_lane x, y, z;
    int32_t rows_each;
} colour;

static void colour_task(void *data, int32_t index, int32_t worker)
{
    const colour *c = data;
    const pv_sampler *s = &c->work->sampler;
    int32_t rows = c->y.count * c->z.count, end = (index + 1) * c->rows_each;
    for (int32_t row = index * c->rows_each; row < end && row < rows; row++) {
        int32_t at[3] = { 0, c->y.first + row % c->y.count * c->y.every, c->z.first + row / c->y.count * c->z.every };
        for (int32_t i = 0; i < c->x.count; i++) {
            at[0] = c->x.first + i * c->x.every;
            if (s->grid->state[pv_grid_at(s->grid, at[0], at[1], at[2])] != PAVE_VOXEL_OUTSIDE)
                pv_sample(s, &c->work->scratch[worker], at);
        }
    }
}

static pave_result run_lanes(const colour *c, double to)
{
    const pv_lane lanes[3] = { c->x, c->y, c->z };
    pave_result result = pv_device_lanes(c->work->device, &c->work->sampler, lanes);
    return result ? result : pv_progress(c->work->context, to);
}

static pave_result run_colour(pv_work *work, int32_t which, double from, double to)
{
    enum { VOXELS = 400 };
    const pv_grid *grid = work->sampler.grid;
    int32_t nx = lane_classes(grid, 0), ny = lane_classes(grid, 1);
    colour c = { work, lane_of(grid, 0, which % nx), lane_of(grid, 1, which / nx % ny),
                 lane_of(grid, 2, which / nx / ny), 1 };
    if (c.x.count < 1 || c.y.count < 1 || c.z.count < 1)
        return PAVE_OK;
    int32_t rows = c.y.count * c.z.count;
    c.rows_each = (VOXELS + c.x.count - 1) / c.x.count;
    pave_result result = freeze(work);
    if (!result && work->device)
        result = run_lanes(&c, to);
    else if (!result)
        result = pv_parallel(work->context, (rows + c.rows_each - 1) / c.rows_each, colour_task, &c, from, to);
    return result ? result : settle(work);
}

pave_result pv_work_pass(pv_work *work, double from, double to)
{
    const pv_grid *grid = work->sampler.grid;
    int32_t colours = lane_classes(grid, 0) * lane_classes(grid, 1) * lane_classes(grid, 2);
    pave_result result = PAVE_OK;
    work->sampler.control = &work->control;
    work->sampler.pass++;
    uint32_t start = pv_draw(work->sampler.seed, PV_DRAW_START, work->sampler.pass, 0, 0).word[0];
    for (int32_t i = 0; i < colours && !result; i++) {
        int32_t which = (int32_t)((start + (uint64_t)i * 10) % (uint32_t)colours); /* 10 and 27, 64, 125.. */
        if (colours % 2 == 0 || colours % 5 == 0)
            which = (int32_t)((start + (uint64_t)i) % (uint32_t)colours);
        result = run_colour(work, which, from + (to - from) * i / colours, from + (to - from) * (i + 1) / colours);
    }
    return result;
}

typedef struct flood_level {
    pv_work *work;
    const uint32_t *order;
    int64_t count;
} flood_level;

enum { FLOOD_BATCH = 24 };

static void flood_task(void *data, int32_t index, int32_t worker)
{
    const flood_level *level = data;
    const pv_grid *grid = level->work->sampler.grid;
    int64_t end = ((int64_t)index + 1) * FLOOD_BATCH;
    for (int64_t i = (int64_t)index * FLOOD_BATCH; i < end && i < level->count; i++) {
        uint32_t voxel = level->order[i], w = (uint32_t)grid->size[0], h = (uint32_t)grid->size[1];
        int32_t at[3] = { (int32_t)(voxel % w), (int32_t)(voxel / w % h), (int32_t)(voxel / w / h) };
        pv_sample(&level->work->sampler, &level->work->scratch[worker], at);
    }
}

static pave_result run_flood_level(flood_level *level, double from, double to)
{
    const pv_work *work = level->work;
    if (!work->device)
        return pv_parallel(work->context, (int32_t)((level->count + FLOOD_BATCH - 1) / FLOOD_BATCH), flood_task, level,
                           from, to);
    pave_result result = pv_device_order(work->device, &work->sampler, level->order, level->count);
    return result ? result : pv_progress(work->context, to);
}

pave_result pv_work_flood(pv_work *work, const pv_flood *flood, double from, double to)
{
    enum { FREEZE = 512 };
    pave_result result = PAVE_OK;
    int64_t since = FREEZE;
    for (int32_t l = 0; l < flood->levels && !result; l++) {
        flood_level level = { work, flood->order + flood->level[l], flood->level[l + 1] - flood->level[l] };
        if (since >= FREEZE && work->sampler.control) {
            result = settle(work);
            if (!result)
                result = freeze(work);
            since = 0;
        }
        since += level.count;
        double a = (double)flood->level[l] / (double)flood->count;
        double b = (double)flood->level[l + 1] / (double)flood->count;
        if (!result)
            result = run_flood_level(&level, from + (to - from) * a, from + (to - from) * b);
    }
    return result ? result : settle(work);
}
