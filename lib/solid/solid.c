/* A digital stone: shape and measurements, samples, growth, values. Schellewald et al. 2013, section 4. */
#include "solid/solid.h"

#include "base/parallel.h"
#include "solid/domain.h"
#include "solid/match.h"
#include "solid/pyramid.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const pave_solid_params default_params = PAVE_SOLID_PARAMS_INIT;
static const pave_solid_input default_input = PAVE_SOLID_INPUT_INIT;

enum { MOST_VOXELS = 1 << 20, MOST_SEEDS = 1 << 24 };

static const pv_param solid_rows[] = {
    PV_CHOICE(pave_solid_params, mode, "paper|best|fast", "the text to the letter, or better"),
    PV_INTEGER(pave_solid_params, width, "voxels", 1, MOST_VOXELS, "of the box, along x"),
    PV_INTEGER(pave_solid_params, height, "voxels", 1, MOST_VOXELS, "of the box, along y"),
    PV_INTEGER(pave_solid_params, depth, "voxels", 1, MOST_VOXELS, "of the box, along z; 1: a flat picture"),
    PV_INTEGER(pave_solid_params, resolution, "voxels", 1, MOST_VOXELS, "along the longest side of a mesh"),
    PV_INTEGER(pave_solid_params, seeds, "", 1, MOST_SEEDS, "random seeds, where nothing is measured"),
    PV_SEED(pave_solid_params, seed, "another seed, another stone"),
    PV_INTEGER(pave_solid_params, window, "voxels", 3, PV_MOST_SIDE, "side of the neighbourhood, odd"),
    PV_REAL(pave_solid_params, epsilon, "", 0, 10, "paper: draw from what matches within 1 + epsilon of the best"),
    PV_REAL(pave_solid_params, sigma, "windows", 0.05, 10, "paper: deviation of the window's Gaussian"),
    PV_INTEGER(pave_solid_params, levels, "", 0, PV_MOST_LEVELS, "best: levels of the pyramid; 0: by the sample"),
    PV_FLAG(pave_solid_params, periodic, "opposite sides fit"),
    PV_CHOICE(pave_solid_params, match, "free|exact", "best, fast: the sample's histogram, near it or to the voxel"),
    PV_FLAG(pave_solid_params, cells, "keep the cells of the flood in every mode"),
};

const pv_table pv_solid_table = PV_TABLE("solid", default_params, solid_rows);

void pave_solid_params_init(pave_solid_params *params, size_t size)
{
    pv_params_init(&pv_solid_table, params, size);
}

void pave_solid_input_init(pave_solid_input *input, size_t size)
{
    const pv_table table = { "solid input", sizeof default_input, &default_input, NULL, 0 };
    pv_params_init(&table, input, size);
}

/* What a stone is made with. */
typedef struct making {
    pave_context *context;
    pave_solid_input input;
    pave_solid_params params;
    const pave_image *sample[PV_PLANES];
    int32_t samples; /* 1 or 3 */
    pv_palette palette;
    pv_pyramid pyramid;
    pv_grid grid;
    pv_flood flood;
    pv_windows bank[PV_PLANES]; /* at the full level */
    pave_volume *volume;
} making;

static pave_result check_samples(making *m)
{
    const pave_solid_input *in = &m->input;
    int more = in->exemplar[1] != NULL;
    if (!in->exemplar[0] || (in->exemplar[2] != NULL) != more)
        return pv_fail(m->context, PAVE_ERR_ARGUMENT, "a stone has one sample, or three");
    m->samples = more ? 3 : 1;
    for (int p = 0; p < PV_PLANES; p++) {
        const pave_image *image = m->sample[p] = in->exemplar[more ? p : 0];
        if (image->width <= m->params.window || image->height <= m->params.window)
            return pv_fail(m->context, PAVE_ERR_ARGUMENT, "the sample of %d x %d px is too small for a window of %d",
                           (int)image->width, (int)image->height, (int)m->params.window);
        if ((int64_t)image->width * image->height > (int64_t)1 << 26)
            return pv_fail(m->context, PAVE_ERR_LIMIT, "a sample of %d x %d px is beyond the limit of 2^26 px",
                           (int)image->width, (int)image->height);
    }
    return PAVE_OK;
}

static pave_result read_arguments(making *m, const pave_solid_input *input, const pave_solid_params *params)
{
    pave_result result = pv_struct_read(m->context, "solid input", &default_input, sizeof default_input, input,
                                        &m->input);
    if (!result)
        result = pv_params_read(m->context, &pv_solid_table, params, &m->params);
    if (!result && m->params.window % 2 == 0)
        result = pv_fail(m->context, PAVE_ERR_ARGUMENT, "window is %d, but must be odd", (int)m->params.window);
    if (!result && m->params.periodic && m->input.mesh)
        result = pv_fail(m->context, PAVE_ERR_ARGUMENT, "only a box can be periodic, not a mesh");
    if (!result && (m->input.point_count < 0 || m->input.slice_count < 0))
        result = pv_fail(m->context, PAVE_ERR_ARGUMENT, "the number of measurements is below 0");
    return result ? result : check_samples(m);
}

/* Held against the limit before anything of the size is made. */
static pave_result check_memory(making *m)
{
    if (m->input.mesh || m->input.partial)
        return PAVE_OK;
    double voxels = (double)m->params.width * m->params.height * m->params.depth;
    double each = 3 * sizeof(int32_t) + 3 + m->palette.features + 2.0 * m->palette.channels;
    if (voxels > 4294967295.0 || voxels * each > (double)m->context->limits.max_bytes)
        return pv_fail(m->context, PAVE_ERR_LIMIT, "%d x %d x %d voxels need %.0f MiB, and the limit is %.0f",
                       (int)m->params.width, (int)m->params.height, (int)m->params.depth, voxels * each / 1048576,
                       (double)m->context->limits.max_bytes / 1048576);
    return PAVE_OK;
}

static pave_result make_texels(making *m)
{
    pv_pyramid *p = &m->pyramid;
    pave_result result = PAVE_OK;
    p->same = m->samples == 1;
    p->labels = m->palette.labels;
    for (int32_t i = 0; i < m->samples && !result; i++)
        result = pv_texels_create(m->context, &m->palette, m->sample[i], &p->texels[0][i]);
    return result;
}

/* The mean length of a run of equal labels, or of one side of the mean: how large features are. */
static double feature_size(const pv_texels *t, int labels)
{
    int64_t n = (int64_t)t->width * t->height, sum = 0, changes = 0;
    for (int64_t i = 0; i < n; i++)
        sum += t->class[i];
    for (int64_t i = 0; i + 1 < n; i++) {
        int a = t->class[i], b = t->class[i + 1];
        changes += (i + 1) % t->width && (labels ? a != b : (a * n > sum) != (b * n > sum));
    }
    return (double)n / (double)(changes + t->height);
}

/* A window of 5 holds features of about 4 voxels, and each level doubles that; more levels than needed cost fine
 * detail. Every sample must still be some windows wide at its coarsest. */
static int32_t choose_levels(const making *m)
{
    enum { WINDOWS = 4 };
    int32_t levels = 2, side = INT32_MAX;
    double size = 0;
    for (int32_t i = 0; i < m->samples; i++) {
        const pave_image *s = m->sample[i];
        int32_t least = s->width < s->height ? s->width : s->height;
        side = least < side ? least : side;
        size = fmax(size, feature_size(&m->pyramid.texels[0][i], m->palette.labels));
    }
    for (double held = m->params.window; held < size && levels < PV_MOST_LEVELS; held *= 4)
        levels++;
    if (m->params.levels)
        levels = m->params.levels;
    while (levels > 1 && side >> (levels - 1) < WINDOWS * m->params.window)
        levels--;
    return levels;
}

/* By level, from the full one. */
static const pv_recipe recipes[] = {
    { 5, 64, 13, 512, 256, 256, 14 }, { 8, 128, 13, 512, 256, 256, 14 }, { 16, 128, 13, 512, 256, 256, 14 },
};

enum { LABELS_AGREE = 6 }; /* of labels neighbourhoods decide, not how near values are */

static pave_result prepare_pyramid(making *m)
{
    pv_pyramid *p = &m->pyramid;
    pave_result result = PAVE_OK;
    p->levels = choose_levels(m);
    p->side = m->params.window;
    p->sigma = 1.1 * m->params.window / 5;
    p->seed = m->params.seed;
    for (int32_t l = 0; l < p->levels; l++)
        p->recipe[l] = recipes[l < 2 ? l : 2];
    for (int32_t l = 0; l < p->levels && p->labels; l++)
        p->recipe[l].agree = LABELS_AGREE;
    for (int32_t l = 1; l < p->levels; l++)
        for (int32_t i = 0; i < m->samples && !result; i++)
            result = pv_texels_halve(m->context, &p->texels[l - 1][i], p->labels, &p->texels[l][i]);
    return result;
}

static pave_result make_grid(making *m)
{
    const pave_volume *v = m->volume;
    double stored[PV_MOST_FEATURES];
    pave_result result = pv_grid_create(m->context, v->size, m->params.periodic, m->params.window / 2,
                                        m->palette.features, &m->grid);
    if (result)
        return result;
    memcpy(m->grid.state, v->states, (size_t)m->grid.voxels);
    for (int64_t i = 0; i < m->grid.voxels; i++) {
        if (v->states[i] != PAVE_VOXEL_MEASURED)
            continue;
        for (int32_t c = 0; c < v->channels; c++)
            stored[c] = pv_volume_stored(v->values, v->type, i * v->channels + c);
        pv_palette_encode(&m->palette, stored, m->grid.feature + i * m->palette.features, &m->grid.class[i]);
    }
    return PAVE_OK;
}

static pave_result make_bank(making *m, int transposed, int alike, double sigma)
{
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < m->samples && !result; i++)
        result = pv_windows_create(m->context, &m->pyramid.texels[0][i], m->params.window, sigma, transposed, alike,
                                m->params.seed, &m->bank[i]);
    return result;
}

static pv_sampler sampler_of(making *m)
{
    pv_sampler s = { .grid = &m->grid, .seed = m->params.seed, .labels = m->palette.labels };
    s.agree = m->palette.labels ? LABELS_AGREE : recipes[0].agree;
    for (int p = 0; p < PV_PLANES; p++)
        s.bank[p] = &m->bank[m->samples == 1 ? 0 : p];
    return s;
}

/* One random plane for each voxel, in the order of the flood (4.1.2, 4.1.3). */
static pave_result grow_as_paper(making *m)
{
    pv_work work;
    pave_result result = make_bank(m, 0, 0, m->params.sigma * m->params.window);
    if (result)
        return result;
    pv_sampler s = sampler_of(m);
    s.paper = 1;
    s.temperature = (int32_t)floor(256 * m->params.epsilon + 0.5);
    result = pv_work_begin(m->context, &s, &work);
    if (!result)
        result = pv_work_flood(&work, &m->flood, 0, 1);
    return pv_work_end(&work, result);
}

/* Three planes at once in the order of the flood, then passes over all. */
static pave_result grow_fast(making *m)
{
    enum { PASSES = 4 };
    pv_work work;
    pave_result result = make_bank(m, m->samples == 1, 1, 1.1 * m->params.window / 5);
    if (result)
        return result;
    pv_sampler s = sampler_of(m);
    s.temperature = recipes[0].cold;
    result = pv_work_begin(m->context, &s, &work);
    work.sampler.control = &work.control;
    if (!result)
        pv_work_count(&work);
    if (!result)
        result = pv_work_flood(&work, &m->flood, 0, 1.0 / (1 + PASSES));
    work.sampler.steps = 1;
    for (int i = 1; i <= PASSES && !result; i++)
        result = pv_work_pass(&work, (double)i / (1 + PASSES), (i + 1.0) / (1 + PASSES));
    return pv_work_end(&work, result);
}

static pave_result grow_best(making *m)
{
    pave_result result = prepare_pyramid(m);
    if (!result)
        result = pv_pyramid_run(m->context, &m->pyramid, &m->grid);
    return result ? result : make_bank(m, m->samples == 1, 0, 1);
}

static pave_result grow(making *m)
{
    pave_result result = PAVE_OK;
    if (m->params.mode != PAVE_SOLID_BEST || m->params.cells)
        result = pv_flood_create(m->context, &m->grid, m->params.seeds, m->params.seed, &m->flood);
    if (!result)
        result = pv_grid_open_sources(m->context, &m->grid);
    if (result)
        return result;
    switch (m->params.mode) {
    case PAVE_SOLID_PAPER: return grow_as_paper(m);
    case PAVE_SOLID_FAST: return grow_fast(m);
    default: return grow_best(m);
    }
}

static void store_texel(making *m, int64_t voxel, int p, int32_t position)
{
    const pv_windows *bank = &m->bank[m->samples == 1 ? 0 : p];
    int32_t area = bank->width * bank->height, i = position % area;
    double stored[PV_MOST_FEATURES];
    int32_t texel = position < area ? i : i % bank->height * bank->width + i / bank->height;
    pv_palette_pixel(&m->palette, m->sample[p], texel, stored);
    for (int32_t c = 0; c < m->volume->channels; c++)
        pv_volume_store(m->volume->values, m->volume->type, voxel * m->volume->channels + c, stored[c]);
}

/* The value of that source which is most like what the voxel was found to be. */
static void store_source(making *m, int64_t voxel)
{
    const pv_grid *g = &m->grid;
    int32_t least = INT32_MAX;
    int best = 0;
    for (int p = 0; p < PV_PLANES; p++) {
        if (g->source[p][voxel] < 0)
            continue;
        const pv_windows *bank = &m->bank[m->samples == 1 ? 0 : p];
        const uint8_t *a = bank->feature + (size_t)g->source[p][voxel] * (size_t)g->features;
        int32_t far = 0;
        for (int32_t f = 0; f < g->features; f++)
            far += abs(a[f] - g->feature[voxel * g->features + f]);
        if (far < least)
            least = far, best = p;
    }
    store_texel(m, voxel, best, g->source[best][voxel]);
}

static int64_t count_uses(const making *m, int p, int64_t *uses)
{
    int64_t all = 0;
    for (int64_t i = 0; i < m->grid.voxels; i++)
        if (m->grid.state[i] == PAVE_VOXEL_FILLED && m->grid.source[p][i] >= 0)
            uses[m->grid.source[p][i]]++, all++;
    return all;
}

/* How evenly the sample's places are used: the entropy of their uses, of the greatest that there can be. */
static pave_result measure_use(making *m)
{
    pave_result result = PAVE_OK;
    const pv_windows *bank = &m->bank[0];
    double entropy = 0;
    int64_t all = 0;
    int64_t *uses = pv_allocate_zeroed(m->context, (size_t)bank->positions, sizeof *uses, &result);
    for (int p = 0; p < PV_PLANES && uses; p++)
        if (p == 0 || m->samples == 1)
            all += count_uses(m, p, uses);
    for (int32_t i = 0; i < bank->positions && uses; i++)
        if (uses[i])
            entropy -= (double)uses[i] / (double)all * log((double)uses[i] / (double)all);
    pv_release(uses);
    if (all > 1)
        m->volume->use = entropy / log(fmin((double)all, bank->inner_count));
    return result;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The r-th of the free voxels gets the value of that rank in the sample. */
static pave_result store_matched(making *m)
{
    pave_result result = PAVE_OK;
    int64_t pixels = 0, count = 0, all = 0;
    for (int32_t i = 0; i < m->samples; i++)
        all += (int64_t)m->sample[i]->width * m->sample[i]->height;
    double *values = pv_allocate(m->context, (size_t)all, sizeof *values, &result);
    uint32_t *ranks = values ? pv_allocate(m->context, (size_t)m->grid.voxels, sizeof *ranks, &result) : NULL;
    if (ranks)
        result = pv_match_ranks(m->context, &m->grid, m->params.seed, ranks, &count);
    if (ranks && !result) {
        for (int32_t s = 0; s < m->samples; s++)
            for (int64_t i = 0; i < (int64_t)m->sample[s]->width * m->sample[s]->height; i++)
                pv_palette_pixel(&m->palette, m->sample[s], i, &values[pixels++]);
        qsort(values, (size_t)pixels, sizeof *values, ascending);
        for (int64_t i = 0; i < m->grid.voxels; i++)
            if (m->grid.state[i] == PAVE_VOXEL_FILLED)
                pv_volume_store(m->volume->values, m->volume->type, i,
                                values[(int64_t)(((double)ranks[i] + 0.5) / (double)count * (double)pixels)]);
    }
    pv_release(values);
    pv_release(ranks);
    return result;
}

static pave_result store_values(making *m)
{
    pave_result result = PAVE_OK;
    pv_release(m->flood.order);
    m->flood.order = NULL;
    if (m->params.match && m->params.mode != PAVE_SOLID_PAPER && m->palette.channels == 1)
        result = store_matched(m);
    else
        for (int64_t i = 0; i < m->grid.voxels; i++)
            if (m->grid.state[i] == PAVE_VOXEL_FILLED)
                store_source(m, i);
    memcpy(m->volume->states, m->grid.state, (size_t)m->grid.voxels);
    m->volume->cells = m->flood.cells;
    m->volume->seeds = m->flood.seeds;
    m->volume->params = m->params;
    m->volume->params.levels = m->params.mode == PAVE_SOLID_BEST ? m->pyramid.levels : 1;
    m->volume->labels = m->palette.labels;
    m->volume->samples = m->samples;
    m->flood.cells = NULL;
    if (!result)
        result = measure_use(m);
    return result ? result : pv_domain_check(m->context, &m->input, &m->palette, m->volume,
                                             &m->volume->constraint_error);
}

static void clean_up(making *m)
{
    for (int32_t l = 0; l < PV_MOST_LEVELS; l++)
        for (int p = 0; p < PV_PLANES; p++)
            pv_texels_free(&m->pyramid.texels[l][p]);
    for (int p = 0; p < PV_PLANES; p++)
        pv_windows_free(&m->bank[p]);
    pv_flood_free(&m->flood);
    pv_grid_free(&m->grid);
}

static pave_result make(making *m)
{
    pave_result result = pv_palette_create(m->context, m->sample, m->samples, &m->palette);
    if (!result)
        result = check_memory(m);
    if (!result)
        result = pv_domain_create(m->context, &m->input, &m->params, &m->palette, &m->volume);
    if (!result && m->volume->size[2] == 1)
        m->params.mode = PAVE_SOLID_PAPER;
    if (!result)
        result = make_texels(m);
    if (!result)
        result = make_grid(m);
    if (!result)
        result = grow(m);
    return result ? result : store_values(m);
}

pave_result pave_solid_create(pave_context *context, const pave_solid_input *input, const pave_solid_params *params,
                              pave_volume **out)
{
    if (out)
        *out = NULL;
    if (!context || !input || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = PAVE_OK;
    making *m = pv_allocate_zeroed(context, 1, sizeof *m, &result);
    if (!m)
        return result;
    m->context = context;
    pv_call outer = pv_call_begin(context, "stone", 0, 1);
    result = read_arguments(m, input, params);
    if (!result)
        result = make(m);
    pv_call_end(context, outer);
    clean_up(m);
    if (result)
        pave_volume_free(&m->volume);
    *out = m->volume;
    pv_release(m);
    return result;
}
