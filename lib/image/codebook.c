/* Colours in a byte each: entries of a palette, and as many points between two of them as there is room for. So what a
 * pixel is between can be told later, by those around it, without its colour being kept. */
#include "image/palette.h"

#include "base/parallel.h"

#include <string.h>

/* As near as this to an entry in OKLab (0.03) a pixel is of it. */
enum { PURE = 490, ROWS = 16, CACHE = 1024 };
enum { ROUNDING = 3 * 3 * 3 }; /* squared, of display values */

static int32_t square(pv_rgb p, pv_rgb q)
{
    int32_t r = p.r - q.r, g = p.g - q.g, b = p.b - q.b;
    return r * r + g * g + b * b;
}

static uint8_t between(uint8_t a, uint8_t b, int32_t at, int32_t parts)
{
    return (uint8_t)((a * (parts - at) + b * at + parts / 2) / parts);
}

static void add_points(pv_codebook *book, pv_rgb a, pv_rgb b, int32_t points)
{
    for (int32_t i = 1; i <= points; i++)
        book->colour[book->codes++] = (pv_rgb){ between(a.r, b.r, i, points + 1), between(a.g, b.g, i, points + 1),
                                                between(a.b, b.b, i, points + 1) };
}

static int32_t way_of(int32_t a, int32_t b)
{
    return b * (b - 1) / 2 + a;
}

static uint8_t mixed_light(const pv_oklab *tables, uint8_t a, uint8_t b, int32_t quarters)
{
    int64_t light = (int64_t)tables->light[a] * (4 - quarters) + (int64_t)tables->light[b] * quarters;
    return pv_display_of(tables, light / 4);
}

static void add_ways(pv_codebook *book)
{
    for (int32_t b = 1; b < book->entries; b++)
        for (int32_t a = 0; a < b; a++)
            for (int32_t q = 1; q <= 3; q++) {
                pv_rgb p = book->colour[a], r = book->colour[b];
                book->way[way_of(a, b)][q - 1] = (pv_rgb){ mixed_light(&book->tables, p.r, r.r, q),
                                                           mixed_light(&book->tables, p.g, r.g, q),
                                                           mixed_light(&book->tables, p.b, r.b, q) };
            }
}

/* The nearest entry; the lower one among equals. */
static uint8_t nearest_entry(const pv_codebook *book, pv_rgb colour, int64_t *distance)
{
    pv_lab lab = pv_oklab_of(&book->tables, colour);
    uint8_t best = 0;
    *distance = INT64_MAX;
    for (int32_t e = 0; e < book->entries; e++) {
        int64_t d = pv_lab_distance(lab, book->lab[e]);
        if (d < *distance)
            *distance = d, best = (uint8_t)e;
    }
    return best;
}

uint8_t pv_nearest_entry(const pv_codebook *book, pv_rgb colour)
{
    int64_t distance;
    return nearest_entry(book, colour, &distance);
}

pave_result pv_codebook_create(pave_context *context, const pave_palette *palette, pv_codebook **out)
{
    pave_result result = PAVE_OK;
    int64_t distance;
    pv_codebook *book = *out = pv_allocate_zeroed(context, 1, sizeof *book, &result);
    if (!book)
        return result;
    pv_oklab_begin(&book->tables);
    book->entries = book->codes = palette->count;
    for (int32_t e = 0; e < book->entries; e++) {
        memcpy(&book->colour[e], palette->rgb + 3 * e, 3);
        book->lab[e] = pv_oklab_of(&book->tables, book->colour[e]);
    }
    int32_t pairs = book->entries * (book->entries - 1) / 2, points = pairs ? (256 - book->entries) / pairs : 0;
    for (int32_t a = 0; a < book->entries; a++)
        for (int32_t b = a + 1; b < book->entries; b++)
            add_points(book, book->colour[a], book->colour[b], points);
    if (book->codes > book->entries)
        add_ways(book);
    for (int32_t c = 0; c < book->codes; c++)
        book->nearest[c] = nearest_entry(book, book->colour[c], &distance);
    return PAVE_OK;
}

static uint8_t code_of(const pv_codebook *book, pv_rgb colour)
{
    int64_t distance;
    uint8_t code = nearest_entry(book, colour, &distance);
    int32_t least = INT32_MAX;
    if (distance <= PURE * PURE || book->codes == book->entries)
        return code;
    for (int32_t c = 0; c < book->codes; c++) {
        int32_t d = square(colour, book->colour[c]);
        if (d < least)
            least = d, code = (uint8_t)c;
    }
    return code;
}

typedef struct encoding {
    const pv_codebook *book;
    pv_pixels_of pixels;
    uint8_t *codes;
} encoding;

/* Neighbours are mostly of one colour, and of few colours all together. */
static void encode_rows(void *data, int32_t band, int32_t worker)
{
    (void)worker;
    const encoding *e = data;
    const pave_image *image = e->pixels.image;
    int64_t from = (int64_t)band * ROWS * image->width, to = from + (int64_t)ROWS * image->width;
    int64_t all = (int64_t)image->width * image->height;
    struct { uint32_t key; uint8_t code; } cache[CACHE];
    memset(cache, 0xFF, sizeof cache);
    for (int64_t i = from; i < (to < all ? to : all); i++) {
        pv_rgb c = pv_pixel_rgb(&e->pixels, i);
        uint32_t key = (uint32_t)c.r << 16 | (uint32_t)c.g << 8 | c.b, at = (key * 0x9E3779B1u >> 22) % CACHE;
        if (cache[at].key != key) {
            cache[at].key = key;
            cache[at].code = code_of(e->book, c);
        }
        e->codes[i] = cache[at].code;
    }
}

pave_result pv_encode(pave_context *context, const pv_codebook *book, const pave_image *image, uint8_t *codes)
{
    encoding e = { book, pv_pixels_begin(image), codes };
    return pv_parallel(context, (image->height + ROWS - 1) / ROWS, encode_rows, &e, 0, 0.5);
}

/* How far a colour is from the straight between two others, squared, and where along it is nearest, 0..1. */
static double off_the_straight(pv_rgb p, pv_rgb a, pv_rgb b, double *where)
{
    double along = (p.r - a.r) * (b.r - a.r) + (p.g - a.g) * (b.g - a.g) + (p.b - a.b) * (b.b - a.b);
    double length = square(a, b), t = length > 0 ? along / length : 0;
    *where = t = t < 0 ? 0 : t > 1 ? 1 : t;
    return square(p, a) - 2 * t * along + t * t * length;
}

/* The same for the way between two entries, a < b: whichever is nearer of the straight, which mixtures of display
 * values are on, and the bent one that mixtures of light are on; and whether it is more of b. */
static double off_the_way(const pv_codebook *book, pv_rgb p, int32_t a, int32_t b, int *second)
{
    double t, least = off_the_straight(p, book->colour[a], book->colour[b], &t);
    const pv_rgb *way = book->way[way_of(a, b)];
    const pv_rgb bends[5] = { book->colour[a], way[0], way[1], way[2], book->colour[b] };
    *second = t > 0.5;
    for (int q = 0; q < 4; q++) {
        double off = off_the_straight(p, bends[q], bends[q + 1], &t);
        if (off + ROUNDING < least)
            least = off, *second = q >= 2;
    }
    return least;
}

/* The code at a place; -1 beyond what there is. */
static int32_t code_at(const pv_codes *codes, int32_t x, int32_t y)
{
    if (x < codes->left || y < codes->top || x >= codes->right || y >= codes->bottom)
        return -1;
    return codes->code[(int64_t)y * codes->width + x];
}

enum { SLACK = 16 * 16, NEAR = PV_RESOLVE_REACH / 2 };

/* The first entry from a pixel on one way, past mixtures; -1 if it is the pixel's own, or too far. */
static int32_t look(const pv_codebook *book, const pv_codes *codes, int32_t x, int32_t y, int32_t dx, int32_t dy)
{
    int32_t own = code_at(codes, x, y);
    for (int32_t i = 1; i <= NEAR; i++) {
        int32_t code = code_at(codes, x + i * dx, y + i * dy);
        if (code < 0 || code == own)
            return -1;
        if (code < book->entries)
            return code;
    }
    return -1;
}

/* A pixel that is exactly of an entry is taken for an edge if it lies alone between two others that make it up. */
static uint8_t resolve_entry(const pv_codebook *book, const pv_codes *codes, int32_t x, int32_t y, uint8_t code)
{
    static const int32_t ways[4][2] = { { 1, 0 }, { 0, 1 }, { 1, 1 }, { 1, -1 } };
    for (int k = 0; k < 4; k++) {
        int32_t p = look(book, codes, x, y, -ways[k][0], -ways[k][1]);
        int32_t q = look(book, codes, x, y, ways[k][0], ways[k][1]);
        int second;
        if (p < 0 || q < 0 || p == q)
            continue;
        int32_t low = p < q ? p : q, high = p < q ? q : p;
        if (off_the_way(book, book->colour[code], low, high, &second) <= SLACK)
            return (uint8_t)(second ? high : low);
    }
    return code;
}

/* Entries around a pixel, in the square ring of a radius. */
static void gather(const pv_codebook *book, const pv_codes *codes, int32_t x, int32_t y, int32_t radius,
                   uint8_t *present, int32_t *count)
{
    for (int32_t dy = -radius; dy <= radius; dy++)
        for (int32_t dx = -radius; dx <= radius; dx += dy == -radius || dy == radius ? 1 : 2 * radius) {
            int32_t code = code_at(codes, x + dx, y + dy);
            if (code < 0 || code >= book->entries)
                continue;
            code = resolve_entry(book, codes, x + dx, y + dy, (uint8_t)code);
            *count += !present[code];
            present[code] = 1;
        }
}

/* The pair among those present that a colour lies between best; -1 if none fits it better than its nearest entry. */
static int32_t best_pair(const pv_codebook *book, const uint8_t *present, uint8_t code)
{
    pv_rgb p = book->colour[code];
    double least = square(p, book->colour[book->nearest[code]]);
    int32_t best = -1;
    for (int32_t a = 0; a < book->entries; a++)
        for (int32_t b = a + 1; b < book->entries && present[a]; b++) {
            int second;
            double off = present[b] ? off_the_way(book, p, a, b, &second) : least;
            if (off < least)
                least = off, best = second ? b : a;
        }
    return best;
}

uint8_t pv_resolve(const pv_codebook *book, const pv_codes *codes, int32_t x, int32_t y)
{
    uint8_t code = codes->code[(int64_t)y * codes->width + x], present[256] = { 0 };
    int32_t count = 0;
    if (book->codes == book->entries)
        return code;
    if (code < book->entries)
        return resolve_entry(book, codes, x, y, code);
    for (int32_t radius = 1; radius <= NEAR; radius++) {
        gather(book, codes, x, y, radius, present, &count);
        int32_t found = count > 1 ? best_pair(book, present, code) : -1;
        if (found >= 0)
            return (uint8_t)found;
    }
    return book->nearest[code];
}
