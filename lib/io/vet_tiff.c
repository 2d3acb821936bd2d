/* TIFF and BigTIFF files: the first directory, with only the tags that describe the picture left in it.
 * Source: TIFF 6.0 (Adobe 1992), section 2; BigTIFF (Joris Van Damme 2007). */
#include "io/vet.h"

#include <string.h>

enum { WIDTH = 256, HEIGHT = 257, BITS = 258, COMPRESSION = 259, ORIENTATION = 274, SAMPLES = 277, STRIP_HEIGHT = 278,
       STRIP_BYTES = 279, TILE_WIDTH = 322, TILE_HEIGHT = 323, TILE_BYTES = 325, EXTRA_SAMPLES = 338 };
enum { MOST_ENTRIES = 65536 }; /* tags have 16 bits */

typedef struct tiff_file {
    pave_context *context;
    pv_encoded *file;
    uint8_t *directory; /* with its count before it and the place of the next one behind */
    int big_endian, big; /* big: BigTIFF */
    uint64_t tile_width, tile_height, strip_height, compression;
    uint64_t parts, part_bytes; /* strips or tiles, and the most bytes of one in the file */
} tiff_file;

static pave_result damaged(const tiff_file *tiff, const char *reason)
{
    return pv_damaged(tiff->context, tiff->file, "TIFF", reason);
}

static uint64_t get(const tiff_file *tiff, const uint8_t *p, int bytes)
{
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++)
        value = value << 8 | p[tiff->big_endian ? i : bytes - 1 - i];
    return value;
}

static void put(const tiff_file *tiff, uint8_t *p, int bytes, uint64_t value)
{
    for (int i = 0; i < bytes; i++)
        p[tiff->big_endian ? bytes - 1 - i : i] = (uint8_t)(value >> 8 * i);
}

/* What describes a picture: everything else (profiles, Exif, IPTC, XMP, other directories) is left out. */
static int wanted(uint64_t tag)
{
    static const uint16_t tags[] = {
        WIDTH, HEIGHT, BITS, COMPRESSION, 262, 266, 273, SAMPLES, STRIP_HEIGHT, STRIP_BYTES, 284, 292, 293,
        317, 320, TILE_WIDTH, TILE_HEIGHT, 324, TILE_BYTES, 332, EXTRA_SAMPLES, 339, 347, 529, 530, 531, 532,
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
    case STRIP_HEIGHT: tiff->strip_height = value; break;
    case TILE_WIDTH: tiff->tile_width = value; break;
    case TILE_HEIGHT: tiff->tile_height = value; break;
    case EXTRA_SAMPLES: file->premultiplied = value == 1; break;
    }
}

/* How many strips or tiles there are, and the longest. */
static pave_result measure_parts(tiff_file *tiff, const uint8_t *inside, int64_t from, uint64_t count, int size)
{
    tiff->parts = count;
    tiff->part_bytes = 0;
    for (uint64_t i = 0; i < count; i++, from += size) {
        const uint8_t *at = inside ? inside + i * (uint64_t)size : NULL;
        pave_result result = inside ? PAVE_OK : pv_input_look(tiff->file->input, from, size, &at);
        if (result)
            return result;
        uint64_t bytes = get(tiff, at, size);
        tiff->part_bytes = bytes > tiff->part_bytes ? bytes : tiff->part_bytes;
    }
    return PAVE_OK;
}

/* Reads one entry and its first value; its data must lie inside the file. */
static pave_result take_entry(tiff_file *tiff, const uint8_t *entry)
{
    int word = tiff->big ? 8 : 4;
    uint64_t tag = get(tiff, entry, 2), type = get(tiff, entry + 2, 2), count = get(tiff, entry + 4, word), bytes;
    const uint8_t *value = entry + 4 + word, *inside = value;
    pave_result result = PAVE_OK;
    int64_t from = 0;
    int size = type_bytes(type);
    if (!size || !count || __builtin_mul_overflow(count, (uint64_t)size, &bytes))
        return damaged(tiff, "a directory entry has an impossible type or count");
    if (bytes > (uint64_t)word) {
        uint64_t offset = get(tiff, value, word);
        if (bytes > tiff->file->whole || offset > tiff->file->whole - bytes)
            return damaged(tiff, "a directory entry points outside the file");
        from = (int64_t)offset;
        inside = NULL;
        result = pv_input_look(tiff->file->input, from, size, &value);
    }
    if (!result)
        note(tiff, tag, get(tiff, value, size));
    if (!result && (tag == STRIP_BYTES || tag == TILE_BYTES))
        result = measure_parts(tiff, inside, from, count, size);
    return result;
}

/* Tags ascend in a directory; a repeated one would make the decoder read another value than was checked here. */
static pave_result walk_directory(tiff_file *tiff, uint64_t entries)
{
    int size = tiff->big ? 20 : 12, word = tiff->big ? 8 : 4, count_bytes = tiff->big ? 8 : 2;
    uint8_t *entry = tiff->directory + count_bytes, *kept = entry;
    uint64_t before = 0;
    for (uint64_t i = 0; i < entries; i++, entry += size) {
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
        memmove(kept, entry, (size_t)size);
        kept += size;
    }
    put(tiff, tiff->directory, count_bytes, (uint64_t)(kept - tiff->directory - count_bytes) / (uint64_t)size);
    put(tiff, kept, word, 0); /* no further directory */
    return PAVE_OK;
}

/* The directory that the decoder sees: what was vetted, where it was. */
static pave_result read_directory(tiff_file *tiff, int64_t at, uint64_t entries)
{
    pv_encoded *file = tiff->file;
    pave_result result = PAVE_OK;
    int64_t size = tiff->big ? 8 + (int64_t)entries * 20 + 8 : 2 + (int64_t)entries * 12 + 4;
    tiff->directory = file->bytes = pv_allocate(tiff->context, (size_t)size, 1, &result);
    if (!result)
        result = pv_input_read(file->input, at, tiff->directory, size);
    if (!result)
        result = walk_directory(tiff, entries);
    file->size = 0;
    pv_keep(file, 0, at, NULL);
    pv_keep(file, at, size, tiff->directory);
    pv_keep(file, at + size, (int64_t)file->whole - at - size, NULL);
    return result;
}

/* A strip or tile, packed and not. A single strip without compression is read by rows. */
static void set_at_once(const tiff_file *tiff)
{
    pv_encoded *file = tiff->file;
    double rows = tiff->tile_height ? (double)tiff->tile_height : (double)tiff->strip_height;
    double unpacked = pv_picture_bytes(file);
    if (tiff->tile_height)
        unpacked = unpacked / (double)file->width / (double)file->height * (double)tiff->tile_width * rows;
    else if (tiff->strip_height && rows < (double)file->height)
        unpacked = unpacked / (double)file->height * rows;
    double packed = tiff->part_bytes < file->whole ? (double)tiff->part_bytes : (double)file->whole;
    int by_rows = tiff->compression == 1 && tiff->parts == 1 && !tiff->tile_height;
    file->at_once = by_rows ? 0 : (int64_t)(packed + unpacked);
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
    uint8_t head[16], count[8];
    tiff_file tiff = { .context = context, .file = file, .compression = 1 };
    file->format = "tiff";
    file->channels = file->bits = 1;
    if (file->whole < sizeof head)
        return damaged(&tiff, "it is cut short");
    pave_result result = pv_input_read(file->input, 0, head, sizeof head);
    if (result)
        return result;
    tiff.big_endian = head[0] == 'M';
    tiff.big = head[tiff.big_endian ? 3 : 2] == '+';
    int word = tiff.big ? 8 : 4, count_bytes = tiff.big ? 8 : 2;
    uint64_t at = get(&tiff, head + word, word), room = file->whole - (uint64_t)count_bytes;
    if (at > room)
        return damaged(&tiff, "its directory lies outside the file");
    result = pv_input_read(file->input, (int64_t)at, count, count_bytes);
    if (result)
        return result;
    uint64_t entries = get(&tiff, count, count_bytes);
    room -= at;
    if (room < (uint64_t)word || entries > (room - (uint64_t)word) / (tiff.big ? 20 : 12))
        return damaged(&tiff, "its directory is cut short");
    result = entries > MOST_ENTRIES ? damaged(&tiff, "its directory is not in order")
                                    : read_directory(&tiff, (int64_t)at, entries);
    if (!result)
        result = pv_check_claims(context, file);
    if (!result && !good_compression(tiff.compression))
        result = pv_fail(context, PAVE_ERR_UNSUPPORTED,
                         "%s: TIFF compression %d is not read; save it with LZW or Deflate", file->path,
                         (int)tiff.compression);
    if (!result)
        result = check_tiles(&tiff);
    if (!result)
        set_at_once(&tiff);
    return result;
}
