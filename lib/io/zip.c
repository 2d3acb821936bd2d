/* Zip archives: the directory at the end is read strictly, members are inflated by zlib. */
#include "io/zip.h"

#include "io/output.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

enum { TAIL = 22, TAIL64 = 56, LOCATOR = 20, ENTRY = 46, LOCAL = 30, COMMENT = 65535, PIECE = 1 << 16 };

static uint64_t number(const uint8_t *p, int bytes)
{
    uint64_t value = 0;
    for (int i = bytes; i-- > 0;)
        value = value << 8 | p[i];
    return value;
}

static pave_result damaged(const pv_zip *zip, const char *reason)
{
    return pv_fail(zip->input.context, PAVE_ERR_FORMAT, "%s: is a damaged zip archive: %s", zip->input.path, reason);
}

/* Where the directory is, by the record at the end of the file, behind which there may be a comment. */
typedef struct tail {
    uint64_t count, size, at;
} tail;

static pave_result read_tail64(pv_zip *zip, int64_t locator_at, tail *out)
{
    uint8_t locator[LOCATOR], record[TAIL64];
    if (locator_at < 0)
        return damaged(zip, "it has no directory");
    pave_result result = pv_input_read(&zip->input, locator_at, locator, LOCATOR);
    if (result)
        return result;
    uint64_t at = number(locator + 8, 8);
    if (memcmp(locator, "PK\6\7", 4) || at > (uint64_t)locator_at || (uint64_t)locator_at - at < TAIL64)
        return damaged(zip, "it has no directory");
    result = pv_input_read(&zip->input, (int64_t)at, record, TAIL64);
    if (!result && memcmp(record, "PK\6\6", 4))
        return damaged(zip, "it has no directory");
    *out = (tail){ number(record + 32, 8), number(record + 40, 8), number(record + 48, 8) };
    return result;
}

static pave_result find_tail(pv_zip *zip, tail *out)
{
    pave_result result = PAVE_OK;
    int64_t size = zip->input.size, span = size < TAIL + COMMENT ? size : TAIL + COMMENT, i = span - TAIL;
    uint8_t *end = pv_allocate(zip->input.context, (size_t)span, 1, &result);
    if (!result)
        result = pv_input_read(&zip->input, size - span, end, span);
    while (!result && i >= 0 &&
           (memcmp(end + i, "PK\5\6", 4) || (int64_t)number(end + i + 20, 2) != span - i - TAIL))
        i--;
    if (!result && i < 0)
        result = damaged(zip, "it has no directory");
    if (!result) {
        *out = (tail){ number(end + i + 10, 2), number(end + i + 12, 4), number(end + i + 16, 4) };
        if (out->count == 0xFFFF || out->size == 0xFFFFFFFF || out->at == 0xFFFFFFFF)
            result = read_tail64(zip, size - span + i - LOCATOR, out);
    }
    pv_release(end);
    return result;
}

/* Numbers that do not fit into the entry stand in its extra field 1, in this order, only those that do not fit. */
static int widen(const uint8_t *extra, size_t size, uint64_t *const values[3])
{
    while (size >= 4) {
        size_t id = number(extra, 2), length = number(extra + 2, 2);
        if (length > size - 4)
            return 0;
        const uint8_t *p = extra + 4, *end = p + length;
        for (int i = 0; i < 3 && id == 1; i++) {
            if (*values[i] != 0xFFFFFFFF)
                continue;
            if (end - p < 8)
                return 0;
            *values[i] = number(p, 8);
            p += 8;
        }
        extra += 4 + length;
        size -= 4 + length;
    }
    return 1;
}

/* Takes one entry; how long it is, or 0. The name is ended with 0 where the next entry, or the slack, begins. */
static size_t read_entry(const pv_zip *zip, uint8_t *p, size_t left, pv_zip_member *out)
{
    if (left < ENTRY || memcmp(p, "PK\1\2", 4))
        return 0;
    size_t name = number(p + 28, 2), extra = number(p + 30, 2), comment = number(p + 32, 2);
    if (name + extra + comment > left - ENTRY)
        return 0;
    uint64_t packed = number(p + 20, 4), size = number(p + 24, 4), at = number(p + 42, 4);
    uint64_t *const wide[3] = { &size, &packed, &at };
    uint64_t whole = (uint64_t)zip->input.size;
    if (!widen(p + ENTRY + name, extra, wide) || at > whole || packed > whole - at || size / 1100 > packed)
        return 0;
    *out = (pv_zip_member){ .at = (int64_t)at, .packed = (int64_t)packed, .size = (int64_t)size };
    out->check = (uint32_t)number(p + 16, 4);
    out->method = number(p + 8, 2) & 1 ? -1 : (int)number(p + 10, 2); /* -1: encrypted */
    memmove(p + ENTRY - 1, p + ENTRY, name);
    p[ENTRY - 1 + name] = 0;
    out->name = (char *)p + ENTRY - 1;
    return ENTRY + name + extra + comment;
}

static pave_result read_directory(pv_zip *zip, const tail *t)
{
    pave_result result = PAVE_OK;
    if (t->size > (uint64_t)zip->input.size || t->at > (uint64_t)zip->input.size - t->size ||
        t->count > t->size / ENTRY)
        return damaged(zip, "its directory lies outside of it");
    zip->directory = pv_allocate(zip->input.context, (size_t)t->size, 1, &result);
    if (!result)
        zip->member = pv_allocate(zip->input.context, (size_t)t->count, sizeof *zip->member, &result);
    if (!result)
        result = pv_input_read(&zip->input, (int64_t)t->at, zip->directory, (int64_t)t->size);
    size_t at = 0, length = 1;
    for (uint64_t i = 0; i < t->count && length && !result; i++, at += length) {
        length = read_entry(zip, zip->directory + at, (size_t)t->size - at, &zip->member[i]);
        zip->count += length > 0;
    }
    return result || length ? result : damaged(zip, "an entry of its directory makes no sense");
}

pave_result pv_zip_open(pave_context *context, const char *path, pv_zip *out)
{
    tail t = { 0, 0, 0 };
    memset(out, 0, sizeof *out);
    pave_result result = pv_input_open(context, path, &out->input);
    if (!result && out->input.size < TAIL)
        result = damaged(out, "it is cut short");
    if (!result)
        result = find_tail(out, &t);
    return result ? result : read_directory(out, &t);
}

void pv_zip_close(pv_zip *zip)
{
    pv_input_close(&zip->input);
    pv_release(zip->directory);
    pv_release(zip->member);
}

static void *take(void *context, unsigned count, unsigned size)
{
    pave_result result;
    return pv_allocate(context, count, size, &result);
}

static void give(void *context, void *block)
{
    (void)context;
    pv_release(block);
}

/* A member being unpacked. */
typedef struct unpacking {
    const pv_zip *zip;
    const pv_zip_member *member;
    int file;
    int64_t written;
    uint32_t check;
} unpacking;

static pave_result put(unpacking *u, const uint8_t *bytes, size_t size)
{
    if (u->written + (int64_t)size > u->member->size)
        return damaged(u->zip, "a member is longer than it says");
    for (size_t done = 0; done < size;) {
        ssize_t n = pwrite(u->file, bytes + done, size - done, u->written + (int64_t)done);
        if (n < 0 && errno != EINTR)
            return pv_fail(u->zip->input.context, PAVE_ERR_IO, "%s: a member cannot be unpacked: %s",
                           u->zip->input.path, pv_system_error(errno));
        done += n > 0 ? (size_t)n : 0;
    }
    u->check = (uint32_t)crc32(u->check, bytes, (uInt)size);
    u->written += (int64_t)size;
    return PAVE_OK;
}

static pave_result inflate_piece(unpacking *u, z_stream *z, int *ended)
{
    uint8_t out[PIECE];
    pave_result result = PAVE_OK;
    do {
        z->next_out = out;
        z->avail_out = PIECE;
        int code = inflate(z, Z_NO_FLUSH);
        *ended = code == Z_STREAM_END;
        if (code != Z_OK && code != Z_STREAM_END && code != Z_BUF_ERROR)
            return damaged(u->zip, "a member cannot be inflated");
        result = put(u, out, PIECE - z->avail_out);
    } while (!result && !*ended && !z->avail_out);
    return result;
}

static pave_result copy(unpacking *u, int64_t from, z_stream *z)
{
    uint8_t in[PIECE];
    int ended = !z;
    pave_result result = PAVE_OK;
    for (int64_t left = u->member->packed, n; left && !result; left -= n, from += n) {
        n = left < PIECE ? left : PIECE;
        result = pv_input_read(&u->zip->input, from, in, n);
        if (result || (z && ended))
            break;
        if (z) {
            z->next_in = in;
            z->avail_in = (uInt)n;
            result = inflate_piece(u, z, &ended);
        } else
            result = put(u, in, (size_t)n);
    }
    if (!result && (!ended || u->written != u->member->size || u->check != u->member->check))
        result = damaged(u->zip, "a member does not unpack to what it should");
    return result;
}

pave_result pv_zip_unpack(const pv_zip *zip, int64_t index, int file)
{
    const pv_zip_member *member = &zip->member[index];
    unpacking u = { zip, member, file, 0, 0 };
    uint8_t local[LOCAL];
    if (member->method != 0 && member->method != 8)
        return pv_fail(zip->input.context, PAVE_ERR_UNSUPPORTED,
                       "%s: %s is packed in a way that is not read (only stored and deflated members are)",
                       zip->input.path, member->name);
    if (zip->input.size - member->at < LOCAL)
        return damaged(zip, "a member lies outside of it");
    pave_result result = pv_input_read(&zip->input, member->at, local, LOCAL);
    if (result)
        return result;
    int64_t from = member->at + LOCAL + (int64_t)number(local + 26, 2) + (int64_t)number(local + 28, 2);
    if (memcmp(local, "PK\3\4", 4) || from > zip->input.size || member->packed > zip->input.size - from)
        return damaged(zip, "a member lies outside of it");
    if (ftruncate(file, 0))
        return pv_fail(zip->input.context, PAVE_ERR_IO, "%s: a member cannot be unpacked: %s", zip->input.path,
                       pv_system_error(errno));
    z_stream z = { .zalloc = take, .zfree = give, .opaque = zip->input.context };
    if (member->method == 8 && inflateInit2(&z, -15) != Z_OK)
        return pv_fail(zip->input.context, PAVE_ERR_MEMORY, "%s: there is no memory to inflate it", zip->input.path);
    result = copy(&u, from, member->method == 8 ? &z : NULL);
    if (member->method == 8)
        inflateEnd(&z);
    return result;
}
