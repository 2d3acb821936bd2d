/* Sampling voxels by compute shaders, the twins of sample.c. */
#include "solid/sample_device.h"

#include "backend/kernel.h"

#include <string.h>

/* The buffers, in the order of their bindings in shaders/voxels.glsl. */
enum { VOXELS, SOURCES, TEXELS = SOURCES + PV_PLANES, TABLES, CONTROL, TALLY, ORDER, SETTING, BUFFERS };
enum { STEPS = 3 * PV_LAGS * PV_STEPS, CLASSES = PV_LAYERS * PV_CLASSES, STATISTICS = CLASSES + STEPS };
enum { ORDERED = 1 << 16, GROUP = 64, MOST_SHARED = 3700 };

typedef struct plane_setting {
    int32_t width, height, positions, inner_count, total, centre;
    uint32_t floor_low, floor_high;
    int32_t texels, nearest, inner, class_start, root, use;
} plane_setting;

typedef struct setting {
    int32_t size[3], steps_at[3], bins_at[3], lags, labels;
    plane_setting plane[PV_PLANES];
} setting;

typedef struct push {
    int32_t first[3], every[3], count[3], base, items, ordered;
    uint32_t seed_low, seed_high, sweep;
    int32_t temperature, agree, steered, steps;
} push;

struct pv_device {
    pave_context *context;
    pv_kernel *kernel;
    setting setting;
    int32_t words; /* of a voxel or a texel */
    int64_t texels, numbers, factors;
    uint32_t *factor; /* what goes to CONTROL, and comes from TALLY */
    double cost;      /* of a voxel */
    int32_t paper;
};

static int is_first(const pv_sampler *s, int p)
{
    return p == 0 || s->bank[p] != s->bank[0];
}

/* What each plane has in the buffers, and where. */
static void lay_out(pv_device *d, const pv_sampler *s)
{
    const pv_grid *grid = s->grid;
    d->factors = STATISTICS;
    for (int a = 0; a < 3; a++) {
        d->setting.size[a] = grid->size[a];
        d->setting.steps_at[a] = (int32_t)d->numbers;
        d->setting.bins_at[a] = (int32_t)d->numbers + grid->size[a] + 2 * grid->reach;
        d->numbers = d->setting.bins_at[a] + PV_LAGS * PV_CLASSES;
    }
    d->setting.lags = pv_grid_lags(grid);
    d->setting.labels = s->labels;
    for (int p = 0; p < PV_PLANES; p++) {
        const pv_windows *b = s->bank[p];
        plane_setting *to = &d->setting.plane[p];
        uint64_t least = (uint64_t)pv_windows_floor(b);
        if (!is_first(s, p)) {
            *to = d->setting.plane[0];
            continue;
        }
        int32_t at = (int32_t)d->numbers, inner = at + b->positions * PV_NEAREST, start = inner + b->inner_count;
        int32_t root = start + PV_CLASSES + 1;
        *to = (plane_setting){
            b->width, b->height, b->positions, b->inner_count, b->window.total, b->window.centre, (uint32_t)least,
            (uint32_t)(least >> 32), (int32_t)d->texels, at, inner, start, root,
            (int32_t)(d->factors - STATISTICS)
        };
        d->numbers = root + b->window.side * b->window.side;
        d->texels += (int64_t)b->positions * d->words;
        d->factors += b->positions;
    }
}

static void put_byte(uint32_t *words, int64_t index, uint8_t byte)
{
    words[index / 4] |= (uint32_t)byte << 8 * (index % 4);
}

static uint8_t get_byte(const uint32_t *words, int64_t index)
{
    return (uint8_t)(words[index / 4] >> 8 * (index % 4));
}

static void fill_texels(const pv_device *d, const pv_windows *bank, uint32_t *to)
{
    for (int64_t i = 0; i < bank->positions; i++, to += d->words) {
        put_byte(to, 0, bank->inside[i]);
        put_byte(to, 1, bank->class[i]);
        for (int32_t f = 0; f < bank->features; f++)
            put_byte(to, 2 + f, bank->feature[i * bank->features + f]);
    }
}

static void fill_tables(const plane_setting *at, const pv_windows *bank, int32_t *to)
{
    size_t number = sizeof *to;
    memcpy(to + at->nearest, bank->nearest, (size_t)bank->positions * PV_NEAREST * number);
    memcpy(to + at->inner, bank->inner, (size_t)bank->inner_count * number);
    memcpy(to + at->class_start, bank->class_start, (PV_CLASSES + 1) * number);
    for (int32_t i = 0; i < bank->window.side * bank->window.side; i++)
        to[at->root + i] = bank->window.root[i * bank->features];
}

static void fill_axis(const pv_device *d, const pv_sampler *s, int axis, int32_t *to)
{
    for (int32_t i = 0; i < s->grid->size[axis] + 2 * s->grid->reach; i++)
        to[d->setting.steps_at[axis] + i] = (int32_t)s->grid->step[axis][i];
    for (int32_t i = 0; i < PV_LAGS * PV_CLASSES; i++)
        to[d->setting.bins_at[axis] + i] = s->step[axis][i / PV_CLASSES].bin[i % PV_CLASSES];
}

static pave_result write_banks(pv_device *d, const pv_sampler *s)
{
    pave_result result = PAVE_OK;
    uint32_t *texels = pv_allocate_zeroed(d->context, (size_t)d->texels, sizeof *texels, &result);
    int32_t *tables = texels ? pv_allocate_zeroed(d->context, (size_t)d->numbers, sizeof *tables, &result) : NULL;
    if (tables) {
        for (int a = 0; a < 3; a++)
            fill_axis(d, s, a, tables);
        for (int p = 0; p < PV_PLANES; p++)
            if (is_first(s, p)) {
                fill_texels(d, s->bank[p], texels + d->setting.plane[p].texels);
                fill_tables(&d->setting.plane[p], s->bank[p], tables);
            }
        result = pv_kernel_write(d->kernel, TEXELS, texels, d->texels * 4);
    }
    if (!result)
        result = pv_kernel_write(d->kernel, TABLES, tables, d->numbers * 4);
    pv_release(texels);
    pv_release(tables);
    return result;
}

static pave_result write_grid(pv_device *d, const pv_grid *grid)
{
    pave_result result = PAVE_OK;
    uint32_t *words = pv_allocate_zeroed(d->context, (size_t)grid->voxels, (size_t)d->words * sizeof *words, &result);
    for (int64_t i = 0; i < grid->voxels && !result; i++) {
        uint32_t *to = words + i * d->words;
        put_byte(to, 0, grid->state[i]);
        put_byte(to, 1, grid->class[i]);
        for (int32_t f = 0; f < grid->features; f++)
            put_byte(to, 2 + f, grid->feature[i * grid->features + f]);
    }
    if (!result)
        result = pv_kernel_write(d->kernel, VOXELS, words, grid->voxels * d->words * 4);
    for (int p = 0; p < PV_PLANES && !result; p++)
        result = pv_kernel_write(d->kernel, SOURCES + p, grid->source[p], grid->voxels * 4);
    pv_release(words);
    return result;
}

static pave_result open_kernel(pv_device *d, const pv_sampler *s)
{
    const pv_window *w = &s->bank[0]->window;
    int64_t voxels = s->grid->voxels;
    pv_kernel_params params = {
        .shader = s->paper ? PV_KERNEL_EXHAUST : PV_KERNEL_VOXELS, .buffers = BUFFERS,
        .constants = { w->side, w->features }, .what = "the stone or its sample is",
        .bytes = { [VOXELS] = voxels * d->words * 4, [SOURCES] = voxels * 4, [SOURCES + 1] = voxels * 4,
                   [SOURCES + 2] = voxels * 4, [TEXELS] = d->texels * 4, [TABLES] = d->numbers * 4,
                   [CONTROL] = d->factors * 4, [TALLY] = d->factors * 4, [ORDER] = ORDERED * 4,
                   [SETTING] = sizeof d->setting },
    };
    if (w->side * w->side * (w->features + 3) > MOST_SHARED)
        return pv_fail(d->context, PAVE_ERR_UNSUPPORTED, "a window of %d with %d numbers a voxel is too large for "
                       "graphics devices", (int)w->side, (int)w->features);
    return pv_kernel_open(d->context, &params, &d->kernel);
}

pave_result pv_device_open(pave_context *context, const pv_sampler *s, pv_device **out)
{
    enum { CANDIDATES = 40 };
    pave_result result = PAVE_OK;
    pv_device *d = pv_allocate_zeroed(context, 1, sizeof *d, &result);
    *out = NULL;
    if (!d)
        return result;
    d->context = context;
    d->paper = s->paper;
    d->words = (2 + s->grid->features + 3) / 4;
    d->cost = (double)s->bank[0]->window.taps * (s->paper ? 2 * s->bank[0]->inner_count : CANDIDATES * PV_PLANES);
    lay_out(d, s);
    d->factor = pv_allocate_zeroed(context, (size_t)d->factors, sizeof *d->factor, &result);
    if (!result)
        result = open_kernel(d, s);
    if (!result)
        result = pv_kernel_write(d->kernel, SETTING, &d->setting, sizeof d->setting);
    if (!result)
        result = pv_kernel_write(d->kernel, TALLY, d->factor, d->factors * 4);
    if (!result)
        result = write_banks(d, s);
    if (!result)
        result = write_grid(d, s->grid);
    if (result)
        pv_device_close(d);
    else
        *out = d;
    return result;
}

void pv_device_close(pv_device *d)
{
    if (!d)
        return;
    pv_kernel_close(d->kernel);
    pv_release(d->factor);
    pv_release(d);
}

static pave_result run(pv_device *d, const pv_sampler *s, const pv_lane lanes[3], int64_t items)
{
    pave_result result = PAVE_OK;
    push p = { .ordered = !lanes, .seed_low = (uint32_t)s->seed, .seed_high = (uint32_t)(s->seed >> 32),
               .sweep = s->pass, .temperature = s->temperature, .agree = s->agree, .steered = s->control != NULL,
               .steps = s->steps };
    for (int a = 0; a < 3 && lanes; a++)
        p.first[a] = lanes[a].first, p.every[a] = lanes[a].every, p.count[a] = lanes[a].count;
    for (; p.base < items && !result; p.base += p.items) {
        int32_t group = d->paper ? 1 : GROUP;
        p.items = pv_kernel_slice(d->kernel, (int32_t)(items - p.base), group, d->cost);
        result = pv_kernel_run(d->kernel, &p, sizeof p, (p.items + group - 1) / group, p.items * d->cost);
        if (!result)
            result = pv_progress(d->context, 0);
    }
    return result;
}

pave_result pv_device_lanes(pv_device *d, const pv_sampler *s, const pv_lane lanes[3])
{
    return run(d, s, lanes, (int64_t)lanes[0].count * lanes[1].count * lanes[2].count);
}

pave_result pv_device_order(pv_device *d, const pv_sampler *s, const uint32_t *order, int64_t count)
{
    pave_result result = PAVE_OK;
    for (int64_t at = 0, some; at < count && !result; at += some) {
        some = count - at < ORDERED ? count - at : ORDERED;
        result = pv_kernel_write(d->kernel, ORDER, order + at, some * 4);
        if (!result)
            result = run(d, s, NULL, some);
    }
    return result;
}

pave_result pv_device_steer(pv_device *d, const pv_sampler *s, const pv_control *control)
{
    memcpy(d->factor, control->class_factor, sizeof control->class_factor);
    memcpy(d->factor + CLASSES, control->step_factor, sizeof control->step_factor);
    for (int p = 0; p < PV_PLANES; p++)
        for (int32_t i = 0; i < s->bank[p]->positions && is_first(s, p); i++)
            d->factor[STATISTICS + d->setting.plane[p].use + i] = control->use_factor[p][i];
    return pv_kernel_write(d->kernel, CONTROL, d->factor, d->factors * 4);
}

pave_result pv_device_settle(pv_device *d, const pv_sampler *s, pv_control *control)
{
    pave_result result = pv_kernel_read(d->kernel, TALLY, d->factor, d->factors * 4);
    const int32_t *change = (const int32_t *)d->factor;
    if (result)
        return result;
    for (int c = 0; c < CLASSES; c++)
        control->classes[c / PV_CLASSES][c % PV_CLASSES] += change[c];
    for (int i = 0; i < STEPS; i++)
        control->steps[i / (PV_LAGS * PV_STEPS)][i / PV_STEPS % PV_LAGS][i % PV_STEPS] += change[CLASSES + i];
    for (int p = 0; p < PV_PLANES; p++)
        for (int32_t i = 0; i < s->bank[p]->positions && is_first(s, p); i++)
            control->uses[p][i] += change[STATISTICS + d->setting.plane[p].use + i];
    memset(d->factor, 0, (size_t)d->factors * sizeof *d->factor);
    return pv_kernel_write(d->kernel, TALLY, d->factor, d->factors * 4);
}

pave_result pv_device_fetch(pv_device *d, const pv_sampler *s)
{
    pave_result result = PAVE_OK;
    pv_grid *grid = s->grid;
    uint32_t *words = pv_allocate(d->context, (size_t)grid->voxels, (size_t)d->words * sizeof *words, &result);
    if (words)
        result = pv_kernel_read(d->kernel, VOXELS, words, grid->voxels * d->words * 4);
    for (int64_t i = 0; i < grid->voxels && !result; i++) {
        const uint32_t *from = words + i * d->words;
        grid->state[i] = get_byte(from, 0);
        grid->class[i] = get_byte(from, 1);
        for (int32_t f = 0; f < grid->features; f++)
            grid->feature[i * grid->features + f] = get_byte(from, 2 + f);
    }
    for (int p = 0; p < PV_PLANES && !result; p++)
        result = pv_kernel_read(d->kernel, SOURCES + p, grid->source[p], grid->voxels * 4);
    pv_release(words);
    return result;
}
