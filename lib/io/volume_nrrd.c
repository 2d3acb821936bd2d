/* NRRD, raw or compressed inside, and bare values with a detached NRRD header. */
#include "io/volume.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

static void nrrd_head(const pave_volume *v, const char *encoding, pv_volume_head *h)
{
    h->length = 0;
    pv_head_text(h, "NRRD0004\n# complete header: http://teem.sourceforge.net/nrrd/format.html\ntype: ");
    pv_head_text(h, v->type == PAVE_U8 ? "uint8" : v->type == PAVE_U16 ? "uint16" : "float");
    pv_head_text(h, v->channels > 1 ? "\ndimension: 4" : "\ndimension: 3");
    pv_head_text(h, "\nspace dimension: 3\nsizes: ");
    if (v->channels > 1)
        pv_head_whole(h, v->channels), pv_head_text(h, " ");
    for (int a = 0; a < 3; a++)
        pv_head_whole(h, v->size[a]), pv_head_text(h, a < 2 ? " " : "\n");
    pv_head_text(h, v->channels > 1 ? "space directions: none" : "space directions:");
    for (int a = 0; a < 3; a++) {
        pv_head_text(h, " (");
        for (int b = 0; b < 3; b++)
            pv_head_number(h, a == b ? v->spacing : 0), pv_head_text(h, b < 2 ? "," : ")");
    }
    pv_head_text(h, v->channels > 1 ? "\nkinds: vector domain domain domain\nspace origin: (" :
                             "\nkinds: domain domain domain\nspace origin: (");
    for (int a = 0; a < 3; a++)
        pv_head_number(h, v->origin[a]), pv_head_text(h, a < 2 ? "," : ")\n");
    pv_head_text(h, "endian: little\nencoding: ");
    pv_head_text(h, encoding);
    pv_head_text(h, "\n\n");
}

static pave_result put_gzip(pave_context *context, pv_output *output, const pave_volume *v)
{
    pave_result result = PAVE_OK;
    size_t all = pv_volume_bytes(v), at = 0;
    uint8_t *packed = pv_allocate(context, PV_VOLUME_CHUNK, 1, &result);
    z_stream z;
    memset(&z, 0, sizeof z);
    if (!packed)
        return result;
    if (deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return pv_release(packed), pv_fail(context, PAVE_ERR_MEMORY, "out of memory: zlib cannot start");
    for (int done = 0; !done && !result;) {
        size_t n = all - at < PV_VOLUME_CHUNK ? all - at : PV_VOLUME_CHUNK;
        z.next_in = (uint8_t *)(uintptr_t)(v->values + at);
        z.avail_in = (uInt)n;
        at += n;
        do {
            z.next_out = packed;
            z.avail_out = PV_VOLUME_CHUNK;
            done = deflate(&z, at < all ? Z_NO_FLUSH : Z_FINISH) == Z_STREAM_END;
            pv_output_bytes(output, packed, PV_VOLUME_CHUNK - z.avail_out);
        } while (!z.avail_out);
        result = pv_progress(context, (double)at / (double)all);
    }
    deflateEnd(&z);
    pv_release(packed);
    return result;
}

static pave_result write_nrrd(pave_context *context, const pave_volume *v, const char *path, int packed)
{
    pv_output *output;
    pv_volume_head h;
    nrrd_head(v, packed ? "gzip" : "raw", &h);
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    pv_output_text(output, h.text);
    return pv_output_close(output, packed ? put_gzip(context, output, v) : pv_volume_put(context, output, v));
}

pave_result pv_nrrd_write(pave_context *context, const pave_volume *v, const char *path)
{
    return write_nrrd(context, v, path, 0);
}

pave_result pv_nrrd_write_gzip(pave_context *context, const pave_volume *v, const char *path)
{
    return write_nrrd(context, v, path, 1);
}

/* The sidecar of a raw file is a detached NRRD header, which other programs open as it is. */
pave_result pv_raw_write(pave_context *context, const pave_volume *v, const char *path)
{
    pv_output *output;
    pv_volume_head h;
    char sidecar[PV_VOLUME_PATH];
    const char *name = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
    if (strlen(path) + 6 > sizeof sidecar)
        return pv_fail(context, PAVE_ERR_IO, "%s: cannot be written: the name is too long", path);
    snprintf(sidecar, sizeof sidecar, "%s.nhdr", path);
    pave_result result = pv_output_open(context, path, 0, &output);
    if (!result)
        result = pv_output_close(output, pv_volume_put(context, output, v));
    if (!result)
        result = pv_output_open(context, sidecar, 0, &output);
    if (result)
        return result;
    nrrd_head(v, "raw", &h);
    h.text[h.length - 1] = 0; /* the blank line ends an attached header */
    pv_output_text(output, h.text);
    pv_output_text(output, "data file: ");
    pv_output_text(output, name);
    pv_output_text(output, "\n");
    return pv_output_close(output, PAVE_OK);
}

static int read_sizes(const char *text, pv_volume_layout *l, int dimension)
{
    long long n[4];
    int count = sscanf(text, "%lld %lld %lld %lld", &n[0], &n[1], &n[2], &n[3]);
    if (count != dimension || count < 3)
        return 0;
    for (int i = 0; i < count; i++)
        if (n[i] < 1 || n[i] > 1 << 20)
            return 0;
    l->place.channels = count == 4 ? (int32_t)n[0] : 1;
    l->place.width = (int32_t)n[count - 3];
    l->place.height = (int32_t)n[count - 2];
    l->place.depth = (int32_t)n[count - 1];
    return 1;
}

static int nrrd_type(const char *name, int32_t *out)
{
    static const char *const bytes[] = { "uint8", "uchar", "unsigned char", "uint8_t" };
    static const char *const words[] = { "uint16", "ushort", "unsigned short", "uint16_t", "unsigned short int" };
    for (size_t i = 0; i < sizeof bytes / sizeof *bytes; i++)
        if (!strcmp(name, bytes[i]))
            return *out = PAVE_U8, 1;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!strcmp(name, words[i]))
            return *out = PAVE_U16, 1;
    return *out = PAVE_F32, !strcmp(name, "float");
}

static pave_result nrrd_field(pave_context *context, const char *path, const char *key, const char *value,
                              pv_volume_layout *l, int *dimension)
{
    double n[9];
    int fine = 1;
    if (!strcmp(key, "type"))
        fine = nrrd_type(value, &l->place.type);
    else if (!strcmp(key, "dimension"))
        *dimension = atoi(value);
    else if (!strcmp(key, "sizes"))
        fine = read_sizes(value, l, *dimension);
    else if (!strcmp(key, "encoding")) {
        l->packed = !strcmp(value, "gzip") || !strcmp(value, "gz");
        fine = l->packed || !strcmp(value, "raw");
    } else if (!strcmp(key, "endian"))
        l->big = !strcmp(value, "big");
    else if (!strcmp(key, "space directions") && pv_volume_reals(value, n, 9) == 9)
        l->place.spacing = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    else if (!strcmp(key, "space origin") && pv_volume_reals(value, n, 3) == 3)
        memcpy(l->place.origin, n, sizeof l->place.origin);
    else if (!strcmp(key, "data file") || !strcmp(key, "datafile"))
        snprintf(l->file, sizeof l->file, "%s", value);
    return fine ? PAVE_OK : pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: an NRRD with %s '%s' is not read", path, key,
                                    value);
}

pave_result pv_nrrd_read_head(pave_context *context, const char *path, char *text, pv_volume_layout *l)
{
    pave_result result = PAVE_OK;
    int dimension = 0;
    char *line = strchr(text, '\n'), *next;
    for (line = line ? line + 1 : NULL; line && *line && !result; line = next) {
        char *end = strchr(line, '\n');
        next = end ? end + 1 : NULL;
        if (end)
            *end = 0;
        size_t n = strlen(line);
        if (n && line[n - 1] == '\r')
            line[--n] = 0;
        if (!n) {
            l->data = next ? next - text : 0;
            break;
        }
        char *colon = strstr(line, ": ");
        if (*line == '#' || !colon || colon[-1] == ':')
            continue;
        *colon = 0;
        result = nrrd_field(context, path, line, colon + 2, l, &dimension);
    }
    if (!result && !l->place.width)
        result = pv_fail(context, PAVE_ERR_FORMAT, "%s: its header has no sizes", path);
    if (!result && !l->data && !l->file[0])
        result = pv_fail(context, PAVE_ERR_FORMAT, "%s: its header does not end", path);
    return result;
}

pave_result pv_nrrd_inflate(pave_context *context, const char *path, const uint8_t *bytes, int64_t size,
                                  pave_volume *v)
{
    z_stream z;
    size_t all = pv_volume_bytes(v), at = 0;
    int64_t from = 0;
    int status = Z_OK;
    memset(&z, 0, sizeof z);
    if (inflateInit2(&z, 15 + 32) != Z_OK)
        return pv_fail(context, PAVE_ERR_MEMORY, "out of memory: zlib cannot start");
    while (status == Z_OK && at < all && (from < size || z.avail_in)) {
        if (!z.avail_in) {
            z.next_in = (uint8_t *)(uintptr_t)(bytes + from);
            z.avail_in = (uInt)(size - from < PV_VOLUME_CHUNK ? size - from : PV_VOLUME_CHUNK);
            from += z.avail_in;
        }
        z.next_out = v->values + at;
        z.avail_out = (uInt)(all - at < PV_VOLUME_CHUNK ? all - at : PV_VOLUME_CHUNK);
        uInt room = z.avail_out;
        status = inflate(&z, Z_NO_FLUSH);
        at += room - z.avail_out;
    }
    inflateEnd(&z);
    return at == all ? PAVE_OK : pv_fail(context, PAVE_ERR_FORMAT, "%s: its compressed values are damaged", path);
}
