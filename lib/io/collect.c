/* Stones read back: a file of either kind, collected into memory. */
#include <pave/io.h>

#include "io/collect.h"
#include "io/input.h"
#include "io/pile.h"
#include "io/stonefile.h"

#include <errno.h>
#include <string.h>

pave_result pv_collect_begin(pave_context *context, pv_collection *out)
{
    pave_result result = PAVE_OK;
    memset(out, 0, sizeof *out);
    pave_stones *stones = out->stones = pv_allocate_zeroed(context, 1, sizeof *stones, &result);
    if (!result)
        stones->starts = pv_allocate_zeroed(context, 1, sizeof *stones->starts, &result);
    if (!result)
        stones->vertices = pv_allocate(context, 0, 1, &result);
    if (!result)
        stones->colours = pv_allocate(context, 0, 1, &result);
    if (!result)
        stones->sites = pv_allocate(context, 0, 1, &result);
    if (!result)
        stones->rgb = pv_allocate(context, 0, 1, &result);
    if (result)
        return result;
    pave_threshold_params_init(&stones->threshold, sizeof stones->threshold);
    pave_palette_params_init(&stones->palette, sizeof stones->palette);
    pave_field_params_init(&stones->field, sizeof stones->field);
    pave_cvd_params_init(&stones->cvd, sizeof stones->cvd);
    pave_stones_params_init(&stones->params, sizeof stones->params);
    stones->report.size = sizeof stones->report;
    return PAVE_OK;
}

static pave_result grow(pave_context *context, void *array, size_t size, int64_t held, int64_t room)
{
    pave_result result = PAVE_OK;
    void **block = array, *larger = pv_resize(context, *block, (size_t)held, (size_t)room, size, &result);
    if (larger)
        *block = larger;
    return result;
}

static pave_result make_room(pave_context *context, pv_collection *c)
{
    pave_stones *s = c->stones;
    int64_t count = s->count, room = 2 * count + 64;
    if (count >= context->limits.max_stones || count >= INT32_MAX / 4)
        return pv_fail(context, PAVE_ERR_LIMIT, "more stones than the limit of %lld",
                       (long long)context->limits.max_stones);
    pave_result result = grow(context, &s->starts, sizeof *s->starts, count + 1, room + 1);
    if (!result)
        result = grow(context, &s->colours, sizeof *s->colours, count, room);
    if (!result)
        result = grow(context, &s->sites, sizeof *s->sites, count, room);
    if (!result)
        result = grow(context, &s->rgb, 3, count, room);
    if (!result)
        c->room = (int32_t)room;
    return result;
}

pave_result pv_collect_add(pave_context *context, pv_collection *c, const pv_stone *stone, const uint8_t *rgb)
{
    pave_stones *s = c->stones;
    pave_result result = PAVE_OK;
    int64_t at = s->starts[s->count], needed = at + stone->corners, room = 2 * needed + 256;
    if (s->count == c->room || s->count >= context->limits.max_stones)
        result = make_room(context, c);
    if (!result && needed > c->corners_room) {
        result = grow(context, &s->vertices, 2 * sizeof *s->vertices, at, room);
        c->corners_room = result ? c->corners_room : room;
    }
    if (result)
        return result;
    for (int64_t i = 0; i < 2 * (int64_t)stone->corners; i++)
        s->vertices[2 * at + i] = stone->xy[i] / 1000.0;
    s->colours[s->count] = stone->colour;
    s->sites[s->count] = stone->number;
    memcpy(s->rgb + 3 * (int64_t)s->count, rgb, 3);
    s->starts[++s->count] = needed;
    return PAVE_OK;
}

void pv_collect_end(pv_collection *collection)
{
    pave_stones_free(&collection->stones);
}

/* A file that pave wrote as .stones is a pile; its head knows all but the stones, whose colours are entries. */
static pave_result collect_pile(pave_context *context, const char *path, pv_collection *c)
{
    pv_pile pile;
    pv_stone stone;
    pave_result result = pv_pile_open(context, &path, 1, &pile);
    if (result)
        return result;
    pave_stones arrays = *c->stones;
    *c->stones = pile.head;
    c->stones->count = 0;
    c->stones->starts = arrays.starts;
    c->stones->vertices = arrays.vertices;
    c->stones->colours = arrays.colours;
    c->stones->sites = arrays.sites;
    c->stones->rgb = arrays.rgb;
    while (!result) {
        result = pile.next(context, &pile, &stone);
        if (result || !stone.corners)
            break;
        result = pv_collect_add(context, c, &stone, (const uint8_t[3]){ 0 });
    }
    pv_release(c->stones->rgb);
    c->stones->rgb = NULL;
    pv_pile_close(&pile);
    return result;
}

static pave_result collect(pave_context *context, const char *path, pv_collection *c)
{
    pv_input input;
    uint8_t *bytes = NULL;
    int64_t n = (int64_t)strlen(PV_STONE_FILE_MAGIC);
    pave_result result = pv_input_open(context, path, &input);
    if (!result)
        result = pv_input_load(&input, &bytes);
    int own = !result && input.size >= n && !memcmp(bytes, PV_STONE_FILE_MAGIC, (size_t)n);
    if (!result && !own)
        result = pv_svg_read(context, path, (char *)bytes, (size_t)input.size, c);
    pv_release(bytes);
    pv_input_close(&input);
    return own ? collect_pile(context, path, c) : result;
}

pave_result pave_stones_read(pave_context *context, const char *path, pave_stones **out)
{
    if (out)
        *out = NULL;
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!path || !out)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_stones_read: path or out is NULL");
    int before = errno;
    pv_collection collection;
    pv_call outer = pv_call_begin(context, "read", 0, 1);
    pave_result result = pv_collect_begin(context, &collection);
    if (!result)
        result = collect(context, path, &collection);
    if (!result) {
        *out = collection.stones;
        collection.stones = NULL;
    }
    pv_collect_end(&collection);
    pv_call_end(context, outer);
    errno = before;
    return result;
}
