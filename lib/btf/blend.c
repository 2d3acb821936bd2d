/* Every texel from the patches that it is in, and from its own ABRDF (den Brok 2014, 4.1.2), tile by tile. */
#include "btf/rebuild.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { TILE = 64, STRIPE = 128 };

/* How many patches a place of a row of texels is in. */
static int32_t covers(int32_t at, int32_t side, int32_t patch)
{
    int32_t first = at - patch + 1 > 0 ? at - patch + 1 : 0, last = at < side - patch ? at : side - patch;
    return last - first + 1;
}

float pv_rebuild_blend(const pv_rebuild *r, int64_t texel)
{
    int32_t x = (int32_t)(texel % r->sparse->width), y = (int32_t)(texel / r->sparse->width), p = r->model->patch;
    return 1 / (float)(covers(x, r->sparse->width, p) * covers(y, r->sparse->height, p));
}

/* Coefficients of the patches in which the tile's texels have one place, weighted; zeros where there is none. */
static void gather(const pv_rebuild *r, const pv_part *p, int64_t first, int32_t count, int32_t place, float share,
                   float *to)
{
    int32_t side = r->model->patch, width = r->sparse->width;
    for (int32_t i = 0; i < count; i++) {
        int32_t x = (int32_t)((first + i) % width) - place % side, y = (int32_t)((first + i) / width) - place / side;
        int inside = x >= 0 && y >= 0 && x < pv_rebuild_wide(r) && y < pv_rebuild_high(r);
        const float *from = inside ? p->coefficients + ((int64_t)y * pv_rebuild_wide(r) + x) * p->components : NULL;
        float weight = share * pv_rebuild_blend(r, first + i);
        for (int32_t k = 0; k < p->components; k++)
            to[(int64_t)i * p->components + k] = from ? weight * from[k] : 0;
    }
}

/* One plane of a tile's texels, for a stripe of pairs: [texel][pair]. */
static void add_plane(const pv_rebuild *r, int32_t plane, int64_t first, int32_t count, int64_t pair, int32_t pairs,
                      float *gathered, float *out)
{
    const pv_part *patches = &r->part[plane][PV_OF_PATCHES], *texels = &r->part[plane][PV_OF_TEXELS];
    const pv_basis *basis = r->model->basis[plane];
    int32_t most = basis[PV_OF_PATCHES].components, own = basis[PV_OF_TEXELS].components;
    float begun = 0;
    for (int32_t q = 0; q < pv_rebuild_places(r, PV_OF_PATCHES) && patches->components; q++, begun = 1) {
        gather(r, patches, first, count, q, (float)r->settings[plane].share, gathered);
        pv_multiply(&r->algebra, 0, 1, count, pairs, patches->components, gathered, patches->components,
                    basis[PV_OF_PATCHES].left + (q * pv_model_pairs(r->model) + pair) * most, most, begun, out, STRIPE);
    }
    if (texels->components)
        pv_multiply(&r->algebra, 0, 1, count, pairs, texels->components,
                    texels->coefficients + first * texels->components, texels->components,
                    basis[PV_OF_TEXELS].left + pair * own, own, begun, out, STRIPE);
}

/* Takes a texel's values, [plane][pair], back to samples; `values` has room for both. */
static void put_texel(const pv_rebuild *r, int64_t texel, int64_t pair, int32_t pairs, const float *const *planes,
                      float *values)
{
    const pave_btf_model *m = r->model;
    int32_t channels = m->channels;
    for (int32_t i = 0; i < pairs; i++)
        for (int32_t c = 0; c < m->planes; c++) {
            float value = planes[c][i] + m->mean[c * pv_model_pairs(m) + pair + i];
            values[i * m->planes + c] = fminf(fmaxf(value, m->range[c][0]), m->range[c][1]);
        }
    float *samples = values + STRIPE * m->planes;
    pv_colour_decode(m->colour, m->least, r->out->colour_space, channels, values, pairs, samples);
    for (int32_t i = 0; i < pairs * channels; i++)
        samples[i] = fmaxf(samples[i], 0);
    pv_btf_put(r->out, texel, pair * channels, (int64_t)pairs * channels, samples);
}

static size_t tile_room(const pv_rebuild *r)
{
    int32_t most = 1;
    for (int32_t c = 0; c < r->model->planes; c++)
        most = r->part[c][PV_OF_PATCHES].components > most ? r->part[c][PV_OF_PATCHES].components : most;
    return (size_t)TILE * (size_t)(most + r->model->planes * STRIPE) + (size_t)STRIPE * 2 * (size_t)r->model->planes;
}

static int32_t stripes(const pv_rebuild *r)
{
    return (int32_t)((pv_model_pairs(r->model) + STRIPE - 1) / STRIPE);
}

static void put_tile(void *data, int32_t index, int32_t worker)
{
    const pv_rebuild *r = data;
    const pave_btf_model *m = r->model;
    int64_t first = (int64_t)(index / stripes(r)) * TILE, pair = (int64_t)(index % stripes(r)) * STRIPE;
    int64_t texels = pv_btf_texels(r->out) - first, pairs = pv_model_pairs(m) - pair;
    int32_t count = (int32_t)(texels < TILE ? texels : TILE), width = (int32_t)(pairs < STRIPE ? pairs : STRIPE);
    float *values = r->tile + (size_t)worker * tile_room(r), *planes = values + STRIPE * 2 * m->planes;
    float *gathered = planes + (size_t)m->planes * TILE * STRIPE;
    for (int32_t c = 0; c < m->planes; c++)
        add_plane(r, c, first, count, pair, width, gathered, planes + (size_t)c * TILE * STRIPE);
    for (int32_t i = 0; i < count; i++) {
        const float *rows[PV_BTF_CHANNELS];
        for (int32_t c = 0; c < m->planes; c++)
            rows[c] = planes + ((size_t)c * TILE + (size_t)i) * STRIPE;
        put_texel(r, first + i, pair, width, rows, values);
    }
}

pave_result pv_rebuild_blend_all(pv_rebuild *r)
{
    pave_result result = PAVE_OK;
    int64_t tiles = (pv_btf_texels(r->out) + TILE - 1) / TILE;
    if (tiles * stripes(r) > INT32_MAX)
        return pv_fail(r->context, PAVE_ERR_LIMIT, "a BTF of %d x %d texels is too large to be reconstructed at once",
                       (int)r->out->width, (int)r->out->height);
    r->tile = pv_allocate(r->context, (size_t)pv_workers(r->context), tile_room(r) * sizeof *r->tile, &result);
    return result ? result : pv_parallel(r->context, (int32_t)tiles * stripes(r), put_tile, r, 0.4, 1);
}
