/* Photos whose opposite borders meet: one period with so much of its copies around it that everything can be done as
 * in the plane. Only the tiles of the period's own sites are kept; the others are theirs again, a period away. */
#include "mosaic/mosaic.h"

#include "util/fixed.h"

#include <math.h>
#include <string.h>

enum { GUESS = 7, BLOCK = 8, GRID = 1000 }; /* sides */

/* Blocks of the mesh (of half a period at most) and what faces depend on around them; measured. */
int32_t pv_period_guess(const pv_work *w)
{
    double longer = w->width > w->height ? w->width : w->height;
    return (int32_t)ceil(GUESS * w->side + fmin(BLOCK * w->side, longer / 2)) + 8;
}

/* An array of the period's pixels as one of the wider plane's; NULL stays NULL. */
static void *repeat(pave_context *context, const pv_work *wide, const void *from, size_t size, pave_result *result)
{
    const pv_work *w = wide->period;
    if (!from || *result)
        return NULL;
    char *out = pv_allocate(context, (size_t)wide->width * (size_t)wide->height, size, result);
    for (int32_t y = 0; y < wide->height && out; y++) {
        const char *row = (const char *)from + (size_t)pv_modulo(y - wide->margin, w->height) * (size_t)w->width * size;
        char *to = out + (size_t)y * (size_t)wide->width * size;
        for (int32_t x = 0, at; x < wide->width; x += at) {
            int32_t start = pv_modulo(x - wide->margin, w->width);
            at = w->width - start < wide->width - x ? w->width - start : wide->width - x;
            memcpy(to + (size_t)x * size, row + (size_t)start * size, (size_t)at * size);
        }
    }
    return out;
}

static pave_result check(pave_context *context, const pv_work *wide)
{
    int64_t pixels = (int64_t)wide->width * wide->height;
    if (pixels <= context->limits.max_pixels && pixels <= INT32_MAX)
        return PAVE_OK;
    return pv_fail(context, PAVE_ERR_LIMIT, "%d tiles that repeat need %lld px of the photo's copies around it, beyond "
                   "the limit of %lld (max_pixels): lay more tiles, or a smaller photo", (int)wide->n,
                   (long long)pixels, (long long)context->limits.max_pixels);
}

pave_result pv_period_widen(pave_context *context, const pv_work *w, int32_t margin, pave_guide *guide, pv_work *wide)
{
    pave_result result = PAVE_OK;
    *wide = *w;
    wide->period = w;
    wide->guide = guide;
    wide->margin = margin;
    wide->width += 2 * margin;
    wide->height += 2 * margin;
    wide->photo = (pv_photo){ .width = wide->width, .height = wide->height };
    *guide = (pave_guide){ .width = wide->width, .height = wide->height, .singularities = w->guide->singularities };
    wide->size = NULL;
    result = check(context, wide);
    wide->photo.light = repeat(context, wide, w->photo.light, 3 * sizeof(float), &result);
    wide->photo.hole = repeat(context, wide, w->photo.hole, 1, &result);
    wide->size = repeat(context, wide, w->size, sizeof(float), &result);
    guide->edge = repeat(context, wide, w->guide->edge, 1, &result);
    guide->direction = repeat(context, wide, w->guide->direction, sizeof(uint16_t), &result);
    guide->away = repeat(context, wide, w->guide->away, sizeof(float), &result);
    guide->way = repeat(context, wide, w->guide->way, 2 * sizeof(float), &result);
    return result;
}

void pv_period_drop(pave_guide *guide, pv_work *wide)
{
    pv_photo_free(&wide->photo);
    pv_release(wide->size);
    pave_cvd_free(&wide->cvd);
    pv_release(guide->edge);
    pv_release(guide->direction);
    pv_release(guide->away);
    pv_release(guide->way);
}

static uint64_t mix(uint64_t h, int32_t v)
{
    h = (h ^ (uint32_t)v) * 0x9e3779b97f4a7c15u;
    return (h ^ h >> 29) * 0xbf58476d1ce4e5b9u;
}

static uint64_t hash(const pv_work *w, pv_cell a, pv_cell b)
{
    int32_t across = PV_GRID * w->period->width, down = PV_GRID * w->period->height;
    uint64_t h = mix(mix(1, pv_modulo(a.x, across)), pv_modulo(a.y, down));
    h = mix(mix(h, pv_modulo(b.x, across)), pv_modulo(b.y, down));
    return h ^ h >> 32;
}

/* Is a face with this side the other way round one where no tile is to be? */
static int borders_hole(const pv_work *w, const pv_tess *tess, int32_t a, int32_t b)
{
    for (int64_t s = tess->star[b]; s < tess->star[b + 1]; s++)
        if (tess->corner[pv_tess_next(tess, tess->spoke[s])] == a)
            return tess->label[tess->face_of[tess->spoke[s]]] >= w->cvd->site_count;
    return 0;
}

/* With each side the same side comes the other way round, so that nothing is left of the sum. */
int pv_period_closes(const pv_work *w, const pv_tess *tess)
{
    uint64_t sum = 0;
    for (int32_t f = 0; f < tess->face_count; f++) {
        if (!pv_is_tile(w, tess->label[f]))
            continue;
        for (int64_t p = tess->first[f]; p < tess->first[f + 1]; p++) {
            int32_t a = tess->corner[p], b = tess->corner[pv_tess_next(tess, p)];
            if (!w->photo.hole || !borders_hole(w, tess, a, b))
                sum += hash(w, tess->at[a], tess->at[b]) - hash(w, tess->at[b], tess->at[a]);
        }
    }
    return sum == 0;
}

void pv_period_settle(const pv_work *w, pave_stones *stones)
{
    for (int64_t i = 0; i < 2 * stones->starts[stones->count]; i++)
        stones->vertices[i] = (floor(stones->vertices[i] * GRID + 0.5) - (double)w->margin * GRID) / GRID;
}

pave_result pv_period_copies(pave_context *context, const pave_stones *stones, pave_stones *out)
{
    pave_result result = PAVE_OK;
    int64_t corners = stones->starts[stones->count];
    out->plane_width = 3 * stones->plane_width;
    out->plane_height = 3 * stones->plane_height;
    out->starts = pv_allocate_zeroed(context, 9 * (size_t)stones->count + 1, sizeof *out->starts, &result);
    if (!result)
        out->vertices = pv_allocate(context, 18 * (size_t)corners, sizeof *out->vertices, &result);
    for (int32_t k = 0; k < 9 && !result; k++) { /* itself first */
        int32_t place = k == 0 ? 4 : k <= 4 ? k - 1 : k;
        double x = (double)(place % 3 - 1) * stones->plane_width, y = (double)(place / 3 - 1) * stones->plane_height;
        for (int32_t i = 0; i < stones->count; i++)
            out->starts[++out->count] = k * corners + stones->starts[i + 1];
        for (int64_t i = 0; i < corners; i++) {
            out->vertices[2 * (k * corners + i)] = stones->vertices[2 * i] + x;
            out->vertices[2 * (k * corners + i) + 1] = stones->vertices[2 * i + 1] + y;
        }
    }
    return result;
}
