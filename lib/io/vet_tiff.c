/* TIFF and BigTIFF files: the first directory, with only the tags that describe the picture left in it.
 * Source: TIFF 6.0 (Adobe 1992), section 2; BigTIFF (Joris Van Damme 2007). */
#include "io/vet.h"

#include <string.h>

enum { WIDTH = 256, HEIGHT = 257, BITS = 258, COMPRESSION = 259, ORIENTATION = 274, SAMPLES = 277, TILE_WIDTH = 322,
       TILE_HEIGHT = 323, EXTRA_SAMPLES = 338 };

typedef struct tiff_file {
    pave_context *context;
    pv_encoded *file;
    int big_endian, big; /* big: BigTIFF */
    uint64_t tile_width, tile_height, compression;
} tiff_file;

static pave_result damaged(const tiff_file *tiff, const char *reason)
{
    return pv_damaged(tiff->context, tiff->file, "TIFF", reason);
}

static uint64_t get(const tiff_file *tiff, size_t at, int bytes)
{
    uint64_t value = 0;
    const uint8_t *p = tiff->file->bytes + at;
    for (int i = 0; i < bytes; i++)
        value = value << 8 | p[tiff->big_endian ? i : bytes - 1 - i];
    return value;
}

static void put(const tiff_file *tiff, size_t at, int bytes, uint64_t value)
{
    uint8_t *p = tiff->file->bytes + at;
    for (int i = 0; i < bytes; i++)
        p[tiff->big_endian ? bytes - 1 - i : i] = (uint8_t)(value >> 8 * i);
}

/* What describes a picture: everything else (profiles, Exif, IPTC, XMP, other directories) is left out. */
static int wanted(uint64_t tag)
{
    static const uint16_t tags[] = {
        WIDTH, HEIGHT, BITS, COMPRESSION, 262, 266, 273, SAMPLES, 278, 279, 284, 292, 293, 317, 320,
        TILE_WIDTH, TILE_HEIGHT, 324, 325, 332, EXTRA_SAMPLES, 339, 347, 529, 530, 531, 532,
    };
    for (size_t i = 0; i < sizeof tags / sizeof *tags; i++)
        if (tags[i] == tag)
            return 1;
    return 0;
}

static int type_bytes(uint64_t type)
{
    static const uint8_t bytes[19] = { 0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8 };
    return type < 19 ? bytes[type] : 0;
}

static int good_compression(uint64_t compression)
{
    static const uint16_t good[] = { 1, 2, 3, 4, 5, 7, 8, 32773, 32946, 50000 };
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        if (good[i] == compression)
            return 1;
    return 0;
}

static void note(tiff_file *tiff, uint64_t tag, uint64_t value)
{
    pv_encoded *file = tiff->file;
    int32_t small = value < 65536 ? (int32_t)value : 65535;
    switch (tag) {
    case WIDTH: file->width = value <= INT32_MAX ? (int64_t)value : INT32_MAX; break;
    case HEIGHT: file->height = value <= INT32_MAX ? (int64_t)value : INT32_MAX; break;
    case BITS: file->bits = small; break;
    case COMPRESSION: tiff->compression = value; break;
    case ORIENTATION: file->orientation = value >= 1 && value <= 8 ? small : 1; break;
    case SAMPLES: file->channels = small; break;
    case TILE_WIDTH: tiff->tile_width = value; break;
    case TILE_HEIGHT: tiff->tile_height = value; break;
    case EXTRA_SAMPLES: file->premultiplied = value == 1; break;
    }
}

/* Reads one entry and its first value; its data must lie inside the file. */
static pave_result take_entry(tiff_file *tiff, size_t at)
{
    int word = tiff->big ? 8 : 4;
    uint64_t tag = get(tiff, at, 2), type = get(tiff, at + 2, 2), count = get(tiff, at + 4, word), bytes;
    size_t data = at + 4 + (size_t)word;
    int size = type_bytes(type);
    if (!size || !count || __builtin_mul_overflow(count, (uint64_t)size, &bytes))
        return damaged(tiff, "a directory entry has an impossible type or count");
    if (bytes > (uint64_t)word) {
        uint64_t offset = get(tiff, data, word);
        if (bytes > tiff->file->size || offset > tiff->file->size - bytes)
            return damaged(tiff, "a directory entry points outside the file");
        data = (size_t)offset;
    }
    note(tiff, tag, get(tiff, data, size));
    return PAVE_OK;
}

/* Tags ascend in a directory; a repeated one would make the decoder read another value than was checked here. */
static pave_result walk_directory(tiff_file *tiff, size_t at, uint64_t entries)
{
    int size = tiff->big ? 20 : 12, word = tiff->big ? 8 : 4, count_bytes = tiff->big ? 8 : 2;
    size_t entry = at + (size_t)count_bytes, kept = entry;
    uint64_t before = 0;
    for (uint64_t i = 0; i < entries; i++, entry += (size_t)size) {
        uint64_t tag = get(tiff, entry, 2);
        if (!wanted(tag) && tag != ORIENTATION)
            continue;
        if (tag <= before)
            return damaged(tiff, "its directory is not in order");
        before = tag;
        pave_result result = take_entry(tiff, entry);
        if (result)
            return result;
        if (tag == ORIENTATION) /* applied here, not by the decoder */
            continue;
        memmove(tiff->file->bytes + kept, tiff->file->bytes + entry, (size_t)size);
        kept += (size_t)size;
    }
    put(tiff, at, count_bytes, (kept - at - (size_t)count_bytes) / (size_t)size);
    put(tiff, kept, word, 0); /* no further directory */
    return PAVE_OK;
}

static pave_result check_tiles(const tiff_file *tiff)
{
    const pv_encoded *file = tiff->file;
    uint64_t most = (uint64_t)tiff->context->limits.max_side, area = tiff->tile_width * tiff->tile_height;
    if (tiff->tile_width > most || tiff->tile_height > most || area > (uint64_t)tiff->context->limits.max_pixels)
        return pv_fail(tiff->context, PAVE_ERR_LIMIT, "%s: has tiles beyond the limits", file->path);
    return PAVE_OK;
}

pave_result pv_vet_tiff(pave_context *context, pv_encoded *file)
{
    tiff_file tiff = { .context = context, .file = file, .big_endian = file->bytes[0] == 'M', .compression = 1 };
    tiff.big = file->bytes[tiff.big_endian ? 3 : 2] == '+';
    file->format = "tiff";
    file->channels = file->bits = 1;
    int word = tiff.big ? 8 : 4, count_bytes = tiff.big ? 8 : 2;
    if (file->size < 16)
        return damaged(&tiff, "it is cut short");
    uint64_t at = get(&tiff, (size_t)word, word), room;
    if (at > file->size - (uint64_t)count_bytes)
        return damaged(&tiff, "its directory lies outside the file");
    uint64_t entries = get(&tiff, (size_t)at, count_bytes);
    room = file->size - at - (uint64_t)count_bytes;
    if (room < (uint64_t)word || entries > (room - (uint64_t)word) / (tiff.big ? 20 : 12))
        return damaged(&tiff, "its directory is cut short");
    pave_result result = walk_directory(&tiff, (size_t)at, entries);
    if (!result)
        result = pv_check_claims(context, file);
    if (!result && !good_compression(tiff.compression))
        result = pv_fail(context, PAVE_ERR_UNSUPPORTED,
                         "%s: TIFF compression %d is not read; save it with LZW or Deflate", file->path,
                         (int)tiff.compression);
    return result ? result : check_tiles(&tiff);
}
