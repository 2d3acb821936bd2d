/* One voxel. Best mode asks that its neighbourhoods in all three planes look like the sample's at one common value; the
 * paper's (4.1.3) looks at one random plane and draws from all that match within 1 + epsilon. All in whole numbers. */
#include "solid/sample.h"

#include "util/random.h"

#include <stdlib.h>
#include <string.h>

enum { KEPT = 6, MOST_LISTED = 64, FORCED = 8, FORCED_AGREE = 1024, MEASURED_WEIGHT = 4 };

typedef struct candidate {
    int32_t position;
    int64_t distance;
} candidate;

typedef struct plane_choice {
    int32_t listed[MOST_LISTED], listed_count;
    uint64_t filter;
    candidate kept[KEPT];
    int kept_count;
    int64_t present; /* weight of the taps present, a measured one counting sixteen times */
    int64_t weight;  /* share of the plane's taps that are present, 1/256 */
} plane_choice;

typedef struct choice {
    const pv_sampler *s;
    pv_scratch *scratch;
    const int32_t *at;
    int64_t voxel;
    int layer;
    int forced; /* the value is measured */
    pv_random random;
    plane_choice plane[PV_PLANES];
    int64_t beside[PV_LAGS][6]; /* voxels 1 and PV_FAR beside it that count; -1: none */
} choice;

pave_result pv_scratch_create(pave_context *context, const pv_sampler *sampler, pv_scratch *scratch)
{
    pave_result result = PAVE_OK;
    memset(scratch, 0, sizeof *scratch);
    for (int p = 0; p < PV_PLANES && !result; p++) {
        const pv_windows *bank = sampler->bank[p];
        size_t n = (size_t)bank->window.stride;
        scratch->patch[p] = pv_allocate_zeroed(context, n, sizeof(int16_t), &result);
        scratch->presence[p] = result ? NULL : pv_allocate_zeroed(context, n, sizeof(int16_t), &result);
        if (!result)
            scratch->tally.uses[p] = pv_allocate_zeroed(context, (size_t)bank->positions, sizeof(int32_t), &result);
        if (!result && !scratch->distance && sampler->paper)
            scratch->distance = pv_allocate(context, (size_t)bank->positions, sizeof(int32_t), &result);
    }
    return result;
}

void pv_scratch_free(pv_scratch *scratch)
{
    for (int p = 0; p < PV_PLANES; p++) {
        pv_release(scratch->patch[p]);
        pv_release(scratch->presence[p]);
        pv_release(scratch->tally.uses[p]);
    }
    pv_release(scratch->distance);
}

static int is_there(const pv_grid *grid, int64_t voxel)
{
    return voxel >= 0 && grid->state[voxel] >= PAVE_VOXEL_MEASURED;
}

static int16_t voxel_weight(const pv_sampler *sampler, int64_t voxel)
{
    return sampler->grid->state[voxel] == PAVE_VOXEL_MEASURED && !sampler->paper ? MEASURED_WEIGHT : 1;
}

/* The voxel's neighbourhood in a plane, weighted like the bank's. */
static void gather(choice *c, int p)
{
    const pv_grid *grid = c->s->grid;
    const pv_window *w = &c->s->bank[p]->window;
    int u = pv_plane_u(p), v = pv_plane_v(p), r = w->radius, n = w->features;
    int64_t here = grid->step[p][c->at[p] + grid->reach];
    const int64_t *step_u = grid->step[u] + c->at[u] + grid->reach, *step_v = grid->step[v] + c->at[v] + grid->reach;
    int16_t *patch = c->scratch->patch[p], *presence = c->scratch->presence[p];
    int64_t present = 0, area = 0;
    for (int y = -r, tap = 0; y <= r; y++)
        for (int x = -r; x <= r; x++, tap += n) {
            int64_t voxel = step_u[x] < 0 || step_v[y] < 0 ? -1 : here + step_u[x] + step_v[y];
            int16_t there = !is_there(grid, voxel) ? 0 : voxel_weight(c->s, voxel);
            int64_t root = w->root[tap];
            area += there ? root * root : 0;
            present += root * root * there * there;
            for (int f = 0; f < n; f++) {
                presence[tap + f] = there;
                patch[tap + f] = there ? (int16_t)(grid->feature[voxel * n + f] * w->root[tap + f]) : 0;
            }
        }
    c->plane[p].present = present;
    c->plane[p].weight = 1 + area * 256 / w->total;
}

static void list(choice *c, int p, int32_t position)
{
    plane_choice *plane = &c->plane[p];
    if (position < 0 || position >= c->s->bank[p]->positions || !c->s->bank[p]->inside[position])
        return;
    uint64_t bit = (uint64_t)1 << ((uint32_t)position * 2654435769u >> 26);
    if (plane->filter & bit)
        for (int32_t i = 0; i < plane->listed_count; i++)
            if (plane->listed[i] == position)
                return;
    plane->filter |= bit;
    if (plane->listed_count == MOST_LISTED)
        return;
    plane->listed[plane->listed_count++] = position;
    __builtin_prefetch(c->s->bank[p]->patch + (size_t)position * (size_t)c->s->bank[p]->window.stride);
}

static void list_with_alike(choice *c, int p, int32_t position, int alike)
{
    const pv_windows *bank = c->s->bank[p];
    list(c, p, position);
    if (position < 0 || position >= bank->positions || !bank->inside[position])
        return;
    for (int k = 0; k < alike; k++)
        list(c, p, bank->nearest[(size_t)position * PV_NEAREST + (size_t)k]);
}

/* k-coherence: what the neighbours' sources say about this place, and what is alike. */
static void list_coherent(choice *c, int p)
{
    const pv_grid *grid = c->s->grid;
    const pv_windows *bank = c->s->bank[p];
    int u = pv_plane_u(p), v = pv_plane_v(p);
    int64_t here = grid->step[p][c->at[p] + grid->reach];
    const int64_t *step_u = grid->step[u] + c->at[u] + grid->reach, *step_v = grid->step[v] + c->at[v] + grid->reach;
    for (int y = -1; y <= 1; y++)
        for (int x = -1; x <= 1; x++) {
            int64_t voxel = step_u[x] < 0 || step_v[y] < 0 ? -1 : here + step_u[x] + step_v[y];
            int32_t source = is_there(grid, voxel) ? grid->source[p][voxel] : -1;
            if (source >= 0)
                list_with_alike(c, p, source - y * pv_windows_row(bank, source) - x, x && y ? 1 : PV_NEAREST);
        }
    for (int q = 0; q < PV_PLANES; q++)
        if (q != p && c->s->bank[q] == bank && is_there(grid, c->voxel))
            list(c, p, grid->source[q][c->voxel]);
}

static void list_random(choice *c, int p)
{
    const pv_windows *bank = c->s->bank[p];
    list(c, p, bank->inner[pv_below(c->random.word[1 + p], (uint32_t)bank->inner_count)]);
    if (!c->forced)
        return;
    int class = c->s->grid->class[c->voxel], from = bank->class_start[class], to = bank->class_start[class + 1];
    for (uint32_t i = 0; i < FORCED && to > from; i++) {
        pv_random r = pv_draw(c->s->seed, PV_DRAW_VOXEL, (uint32_t)c->voxel, c->s->pass, 1 + i);
        list(c, p, bank->inner[from + (int32_t)pv_below(r.word[p], (uint32_t)(to - from))]);
    }
}

static void look_beside(choice *c)
{
    const pv_grid *grid = c->s->grid;
    for (int l = 0; l < pv_grid_lags(grid); l++)
        for (int i = 0; i < 6; i++) {
            int64_t other = pv_grid_towards(grid, c->at, i, l ? PV_FAR : 1);
            c->beside[l][i] = is_there(grid, other) ? other : -1;
        }
}

static void keep(plane_choice *plane, int32_t position, int64_t distance)
{
    int i = plane->kept_count;
    if (i == KEPT && distance >= plane->kept[KEPT - 1].distance)
        return;
    if (i < KEPT)
        plane->kept_count++;
    else
        i--;
    for (; i > 0 && distance < plane->kept[i - 1].distance; i--)
        plane->kept[i] = plane->kept[i - 1];
    plane->kept[i] = (candidate){ position, distance };
}

static void keep_best(choice *c, int p)
{
    const pv_windows *bank = c->s->bank[p];
    plane_choice *plane = &c->plane[p];
    int32_t distance[MOST_LISTED];
    int64_t least = pv_windows_floor(bank);
    c->s->distances(bank, c->scratch->patch[p], c->scratch->presence[p], plane->listed, plane->listed_count, distance);
    for (int32_t i = 0; i < plane->listed_count; i++) {
        int64_t d = distance[i];
        if (plane->present != bank->window.total) /* a division less where all is there */
            d = plane->present ? d * bank->window.total / plane->present : 0;
        d += least;
        if (c->s->control)
            d = d * c->s->control->use_factor[p][plane->listed[i]] >> 8;
        keep(plane, plane->listed[i], d);
    }
}

static int64_t value_distance(const choice *c, const pv_windows *bank, const uint8_t *a, const uint8_t *b)
{
    int64_t d = 0;
    for (int32_t f = 0; f < bank->features; f++)
        d += ((int64_t)a[f] - b[f]) * ((int64_t)a[f] - b[f]);
    return d * bank->window.centre * (c->forced ? FORCED_AGREE : c->s->agree) >> 6;
}

static const uint8_t *feature_of(const pv_windows *bank, int32_t position)
{
    return bank->feature + (size_t)position * (size_t)bank->features;
}

/* What it costs if the voxel has this value; the best source of each plane goes to `source`. */
static int64_t value_cost(const choice *c, const uint8_t *value, int32_t source[PV_PLANES])
{
    int64_t cost = 0;
    for (int p = 0; p < PV_PLANES; p++) {
        const plane_choice *plane = &c->plane[p];
        const pv_windows *bank = c->s->bank[p];
        int64_t least = INT64_MAX;
        source[p] = -1;
        for (int i = 0; i < plane->kept_count && plane->kept[i].distance < least; i++) {
            const uint8_t *other = feature_of(bank, plane->kept[i].position);
            int64_t d = plane->kept[i].distance + value_distance(c, bank, other, value);
            if (d < least)
                least = d, source[p] = plane->kept[i].position;
        }
        cost += plane->kept_count ? least * plane->weight >> 8 : 0;
    }
    return cost;
}

static int are_like(const choice *c, int axis, int a, int b)
{
    const uint8_t *bin = c->s->step[axis][0].bin;
    return bin[abs(a - b)] <= bin[0] || bin[abs(a - b)] < PV_STEPS / 2;
}

/* A measured voxel with few like it around it stands out as a speck: being unlike it costs more, the lonelier it is. */
static int64_t loneliness(const choice *c, int64_t measured, int which, uint8_t class)
{
    enum { COMPANY = 3 };
    const pv_grid *grid = c->s->grid;
    int32_t at[3] = { c->at[0], c->at[1], c->at[2] };
    int alike = 0;
    if (are_like(c, which / 2, class, grid->class[measured]))
        return 1;
    at[which / 2] = (at[which / 2] + (which & 1 ? 1 : -1) + grid->size[which / 2]) % grid->size[which / 2];
    for (int i = 0; i < 6; i++) {
        int64_t beside = pv_grid_beside(grid, at, i);
        alike += beside != c->voxel && is_there(grid, beside) &&
                 are_like(c, which / 2, grid->class[measured], grid->class[beside]);
    }
    return alike < COMPANY ? 1 + 2 * (COMPANY - alike) : 1;
}

/* How the statistics of the whole look upon a class here, and the measured voxels beside it. A label that none of the
 * neighbours has would be a speck. */
static int64_t steered(const choice *c, int64_t cost, uint8_t class)
{
    const pv_control *control = c->s->control;
    const pv_grid *grid = c->s->grid;
    int alike = 0, others = 0;
    if (!control)
        return cost;
    cost = cost * control->class_factor[c->layer][class] >> 8;
    for (int l = 0; l < pv_grid_lags(grid) && c->s->steps; l++) {
        int64_t sum = 0, count = 0;
        for (int i = 0; i < 6; i++) {
            int64_t other = c->beside[l][i];
            if (other < 0)
                continue;
            if (l == 0 && grid->state[other] == PAVE_VOXEL_MEASURED)
                cost *= loneliness(c, other, i, class);
            alike += l == 0 && grid->class[other] == class;
            others += l == 0;
            sum += control->step_factor[i / 2][l][c->s->step[i / 2][l].bin[abs(class - grid->class[other])]];
            count++;
        }
        cost = count ? cost * sum / (256 * count) : cost;
    }
    return c->s->labels && others > 3 && !alike ? 2 * cost : cost;
}

typedef struct option {
    const uint8_t *feature;
    uint8_t class;
    int64_t cost;
    int32_t source[PV_PLANES];
} option;

static int list_options(const choice *c, option options[])
{
    int count = 0;
    for (int p = 0; p < PV_PLANES; p++)
        for (int i = 0; i < c->plane[p].kept_count; i++) {
            const pv_windows *bank = c->s->bank[p];
            int32_t position = c->plane[p].kept[i].position;
            const uint8_t *feature = feature_of(bank, position);
            int known = 0;
            for (int k = 0; k < count && !known; k++)
                known = options[k].class == bank->class[position] &&
                        !memcmp(options[k].feature, feature, (size_t)bank->features);
            if (!known)
                options[count++] = (option){ feature, bank->class[position], 0, { 0 } };
        }
    return count;
}

static const option *draw_option(const choice *c, option options[], int count)
{
    int64_t least = INT64_MAX;
    int within = 0;
    for (int i = 0; i < count; i++) {
        options[i].cost = steered(c, value_cost(c, options[i].feature, options[i].source), options[i].class);
        least = options[i].cost < least ? options[i].cost : least;
    }
    int64_t most = least + (least * c->s->temperature >> 8);
    for (int i = 0; i < count; i++)
        within += options[i].cost <= most;
    int drawn = (int)pv_below(c->random.word[0], (uint32_t)within);
    for (int i = 0; i < count; i++)
        if (options[i].cost <= most && drawn-- == 0)
            return &options[i];
    return NULL;
}

static void count_steps(const choice *c, int class, int by)
{
    const pv_grid *grid = c->s->grid;
    /* The paper's mode holds no steps, and what it does together lies apart by its window only. */
    for (int l = 0; l < pv_grid_lags(grid) && !c->s->paper; l++)
        for (int i = 0; i < 6; i++) {
            int64_t other = c->beside[l][i];
            if (other >= 0 && other != c->voxel)
                c->scratch->tally.steps[i / 2][l][c->s->step[i / 2][l].bin[abs(class - grid->class[other])]] += by;
        }
}

/* Writes the voxel, and counts what changes. */
static void store(const choice *c, const uint8_t *feature, int class, const int32_t source[PV_PLANES])
{
    pv_grid *grid = c->s->grid;
    pv_tally *tally = &c->scratch->tally;
    int was = is_there(grid, c->voxel);
    for (int p = 0; p < PV_PLANES; p++) {
        if (grid->source[p][c->voxel] >= 0)
            tally->uses[p][grid->source[p][c->voxel]]--;
        if (source[p] >= 0)
            tally->uses[p][source[p]]++;
        grid->source[p][c->voxel] = source[p];
    }
    if (c->forced)
        return;
    if (!was || grid->class[c->voxel] != class) {
        if (was) {
            count_steps(c, grid->class[c->voxel], -1);
            tally->classes[c->layer][grid->class[c->voxel]]--;
        }
        count_steps(c, class, 1);
        tally->classes[c->layer][class]++;
    }
    grid->class[c->voxel] = (uint8_t)class;
    memcpy(grid->feature + c->voxel * grid->features, feature, (size_t)grid->features);
    grid->state[c->voxel] = PAVE_VOXEL_FILLED;
}

static void sample_planes(choice *c)
{
    option options[KEPT * PV_PLANES];
    int32_t source[PV_PLANES];
    for (int p = 0; p < PV_PLANES; p++) {
        gather(c, p);
        list_coherent(c, p);
        list_random(c, p);
        keep_best(c, p);
    }
    if (c->forced) {
        value_cost(c, c->s->grid->feature + c->voxel * c->s->grid->features, source);
        store(c, NULL, 0, source);
        return;
    }
    look_beside(c);
    int count = list_options(c, options);
    const option *drawn = draw_option(c, options, count);
    store(c, drawn->feature, drawn->class, drawn->source);
}

/* The patch as one of the eight ways to look at a plane sees it. */
static void turn(const pv_window *w, int way, int16_t *patch, int16_t *presence)
{
    int16_t was[PV_MOST_SIDE * PV_MOST_SIDE * PV_MOST_FEATURES], were[PV_MOST_SIDE * PV_MOST_SIDE * PV_MOST_FEATURES];
    int last = w->side - 1, n = w->features;
    memcpy(was, patch, (size_t)w->taps * sizeof *patch);
    memcpy(were, presence, (size_t)w->taps * sizeof *presence);
    for (int y = 0; y <= last; y++)
        for (int x = 0; x <= last; x++) {
            int fx = way & 1 ? last - x : x, fy = way & 2 ? last - y : y;
            int from = way & 4 ? fx * w->side + fy : fy * w->side + fx, to = y * w->side + x;
            memcpy(patch + to * n, was + from * n, (size_t)n * sizeof *patch);
            memcpy(presence + to * n, were + from * n, (size_t)n * sizeof *presence);
        }
}

/* All positions within 1 + epsilon of the nearest; one of them, at random (Efros and Leung 1999). */
static int32_t draw_match(const choice *c, int p)
{
    const pv_windows *bank = c->s->bank[p];
    int32_t *distance = c->scratch->distance, least = INT32_MAX, within = 0;
    c->s->distances(bank, c->scratch->patch[p], c->scratch->presence[p], bank->inner, bank->inner_count, distance);
    for (int32_t i = 0; i < bank->inner_count; i++)
        least = distance[i] < least ? distance[i] : least;
    int64_t most = least + ((int64_t)least * c->s->temperature >> 8);
    for (int32_t i = 0; i < bank->inner_count; i++)
        within += distance[i] <= most;
    int32_t drawn = (int32_t)pv_below(c->random.word[0], (uint32_t)within);
    for (int32_t i = 0; i < bank->inner_count; i++)
        if (distance[i] <= most && drawn-- == 0)
            return bank->inner[i];
    return bank->inner[0];
}

static void sample_paper(choice *c)
{
    int flat = c->s->grid->size[2] == 1;
    int p = flat ? 2 : (int)pv_below(c->random.word[1], 3), way = flat ? 0 : (int)(c->random.word[2] & 7);
    int32_t source[PV_PLANES] = { -1, -1, -1 };
    gather(c, p);
    turn(&c->s->bank[p]->window, way, c->scratch->patch[p], c->scratch->presence[p]);
    source[p] = draw_match(c, p);
    store(c, feature_of(c->s->bank[p], source[p]), c->s->bank[p]->class[source[p]], source);
}

void pv_sample(const pv_sampler *sampler, pv_scratch *scratch, const int32_t at[3])
{
    choice c = { .s = sampler, .scratch = scratch, .at = at };
    c.voxel = pv_grid_at(sampler->grid, at[0], at[1], at[2]);
    c.layer = pv_grid_layer(sampler->grid, at);
    c.forced = sampler->grid->state[c.voxel] == PAVE_VOXEL_MEASURED;
    c.random = pv_draw(sampler->seed, PV_DRAW_VOXEL, (uint32_t)c.voxel, sampler->pass, 0);
    if (sampler->paper && !c.forced)
        sample_paper(&c);
    else if (!sampler->paper)
        sample_planes(&c);
}
