/* Volumes in and out: NRRD (raw or gzip), VTK image data, raw with a sidecar, a stack of TIFF pages by number. */
#include "io/input.h"
#include "io/output.h"
#include "image/image.h"
#include "solid/solid.h"
#include "util/json.h"
#include "util/text.h"

#include <pave/io.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { HEAD = 4096, CHUNK = 1 << 20, NUMBER = 40, MOST_PATH = 4096 };

typedef struct head {
    char text[HEAD];
    size_t length;
} head;

static void add(head *h, const char *text)
{
    size_t n = strlen(text);
    if (h->length + n < HEAD)
        memcpy(h->text + h->length, text, n + 1), h->length += n;
}

static void add_number(head *h, double value)
{
    char text[NUMBER];
    pv_text_number(text, sizeof text, value);
    add(h, text);
}

static void add_whole(head *h, int64_t value)
{
    char text[NUMBER];
    snprintf(text, sizeof text, "%lld", (long long)value);
    add(h, text);
}

static size_t value_bytes(const pave_volume *v)
{
    return (size_t)v->size[0] * (size_t)v->size[1] * (size_t)v->size[2] * (size_t)v->channels * pv_type_bytes(v->type);
}

static void nrrd_head(const pave_volume *v, const char *encoding, head *h)
{
    h->length = 0;
    add(h, "NRRD0004\n# complete header: http://teem.sourceforge.net/nrrd/format.html\ntype: ");
    add(h, v->type == PAVE_U8 ? "uint8" : v->type == PAVE_U16 ? "uint16" : "float");
    add(h, v->channels > 1 ? "\ndimension: 4" : "\ndimension: 3");
    add(h, "\nspace dimension: 3\nsizes: ");
    if (v->channels > 1)
        add_whole(h, v->channels), add(h, " ");
    for (int a = 0; a < 3; a++)
        add_whole(h, v->size[a]), add(h, a < 2 ? " " : "\n");
    add(h, v->channels > 1 ? "space directions: none" : "space directions:");
    for (int a = 0; a < 3; a++) {
        add(h, " (");
        for (int b = 0; b < 3; b++)
            add_number(h, a == b ? v->spacing : 0), add(h, b < 2 ? "," : ")");
    }
    add(h, v->channels > 1 ? "\nkinds: vector domain domain domain\nspace origin: (" :
                             "\nkinds: domain domain domain\nspace origin: (");
    for (int a = 0; a < 3; a++)
        add_number(h, v->origin[a]), add(h, a < 2 ? "," : ")\n");
    add(h, "endian: little\nencoding: ");
    add(h, encoding);
    add(h, "\n\n");
}

static pave_result put_bytes(pave_context *context, pv_output *output, const pave_volume *v)
{
    pave_result result = PAVE_OK;
    size_t all = value_bytes(v);
    for (size_t at = 0; at < all && !result; at += CHUNK) {
        pv_output_bytes(output, v->values + at, all - at < CHUNK ? all - at : CHUNK);
        result = pv_progress(context, (double)at / (double)all);
    }
    return result;
}

static pave_result put_gzip(pave_context *context, pv_output *output, const pave_volume *v)
{
    pave_result result = PAVE_OK;
    size_t all = value_bytes(v), at = 0;
    uint8_t *packed = pv_allocate(context, CHUNK, 1, &result);
    z_stream z;
    memset(&z, 0, sizeof z);
    if (!packed)
        return result;
    if (deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return pv_release(packed), pv_fail(context, PAVE_ERR_MEMORY, "out of memory: zlib cannot start");
    for (int done = 0; !done && !result;) {
        size_t n = all - at < CHUNK ? all - at : CHUNK;
        z.next_in = (uint8_t *)(uintptr_t)(v->values + at);
        z.avail_in = (uInt)n;
        at += n;
        do {
            z.next_out = packed;
            z.avail_out = CHUNK;
            done = deflate(&z, at < all ? Z_NO_FLUSH : Z_FINISH) == Z_STREAM_END;
            pv_output_bytes(output, packed, CHUNK - z.avail_out);
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
    head h;
    nrrd_head(v, packed ? "gzip" : "raw", &h);
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    pv_output_text(output, h.text);
    return pv_output_close(output, packed ? put_gzip(context, output, v) : put_bytes(context, output, v));
}

static pave_result write_nrrd_raw(pave_context *context, const pave_volume *v, const char *path)
{
    return write_nrrd(context, v, path, 0);
}

static pave_result write_nrrd_gzip(pave_context *context, const pave_volume *v, const char *path)
{
    return write_nrrd(context, v, path, 1);
}

static void vti_head(const pave_volume *v, head *h)
{
    h->length = 0;
    add(h, "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt64\">\n<ImageData WholeExtent=\"");
    for (int a = 0; a < 3; a++)
        add(h, "0 "), add_whole(h, v->size[a] - 1), add(h, a < 2 ? " " : "\" Origin=\"");
    for (int a = 0; a < 3; a++)
        add_number(h, v->origin[a]), add(h, a < 2 ? " " : "\" Spacing=\"");
    for (int a = 0; a < 3; a++)
        add_number(h, v->spacing), add(h, a < 2 ? " " : "\">\n<Piece Extent=\"");
    for (int a = 0; a < 3; a++)
        add(h, "0 "), add_whole(h, v->size[a] - 1), add(h, a < 2 ? " " : "\">\n");
    add(h, "<PointData Scalars=\"stone\">\n<DataArray type=\"");
    add(h, v->type == PAVE_U8 ? "UInt8" : v->type == PAVE_U16 ? "UInt16" : "Float32");
    add(h, "\" Name=\"stone\" NumberOfComponents=\"");
    add_whole(h, v->channels);
    add(h, "\" format=\"appended\" offset=\"0\"/>\n</PointData>\n</Piece>\n</ImageData>\n"
           "<AppendedData encoding=\"raw\">\n_");
}

static pave_result write_vti(pave_context *context, const pave_volume *v, const char *path)
{
    pv_output *output;
    head h;
    uint64_t bytes = value_bytes(v);
    vti_head(v, &h);
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    pv_output_text(output, h.text);
    pv_output_bytes(output, &bytes, sizeof bytes);
    result = put_bytes(context, output, v);
    pv_output_text(output, "\n</AppendedData>\n</VTKFile>\n");
    return pv_output_close(output, result);
}

/* The sidecar of a raw file is a detached NRRD header, which other programs open as it is. */
static pave_result write_raw(pave_context *context, const pave_volume *v, const char *path)
{
    pv_output *output;
    head h;
    char sidecar[MOST_PATH];
    const char *name = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
    if (strlen(path) + 6 > sizeof sidecar)
        return pv_fail(context, PAVE_ERR_IO, "%s: cannot be written: the name is too long", path);
    snprintf(sidecar, sizeof sidecar, "%s.nhdr", path);
    pave_result result = pv_output_open(context, path, 0, &output);
    if (!result)
        result = pv_output_close(output, put_bytes(context, output, v));
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

/* "stone.tif" becomes "stone-0000.tif" and so on: one page a slice along z. */
static int page_path(const char *path, int32_t page, char out[MOST_PATH])
{
    const char *dot = strrchr(path, '.');
    int n = snprintf(out, MOST_PATH, "%.*s-%04d%s", (int)(dot - path), path, (int)page, dot);
    return n > 0 && n < MOST_PATH;
}

static pave_result write_tiff(pave_context *context, const pave_volume *v, const char *path)
{
    char page[MOST_PATH];
    pave_result result = PAVE_OK;
    for (int32_t z = 0; z < v->size[2] && !result; z++) {
        pave_image *image = NULL;
        if (!page_path(path, z, page))
            return pv_fail(context, PAVE_ERR_IO, "%s: cannot be written: the name is too long", path);
        result = pave_volume_slice(context, v, 2, z, &image);
        if (!result)
            result = pave_image_write(context, image, page);
        pave_image_free(&image);
    }
    return result;
}

typedef pave_result volume_writer(pave_context *context, const pave_volume *volume, const char *path);

static const struct { const char *format, *ending; volume_writer *write; } formats[] = {
    { "nrrd", ".nrrd", write_nrrd_raw }, { "nrrd-gzip", ".nrrd.gz", write_nrrd_gzip }, { "vti", ".vti", write_vti },
    { "raw", ".raw", write_raw },        { "tiff", ".tif", write_tiff },               { "tiff", ".tiff", write_tiff },
};

static int ends_with(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    return n >= m && !strcmp(path + n - m, ending);
}

const char *pave_volume_format(const char *path)
{
    for (size_t i = 0; path && i < sizeof formats / sizeof *formats; i++)
        if (ends_with(path, formats[i].ending))
            return formats[i].format;
    return NULL;
}

pave_result pave_volume_write(pave_context *context, const pave_volume *volume, const char *path, const char *format)
{
    if (!context || !volume || !path)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    pave_result result = PAVE_ERR_UNSUPPORTED;
    pv_call outer = pv_call_begin(context, "write", 0, 1);
    const char *chosen = format ? format : pave_volume_format(path);
    volume_writer *write = NULL;
    for (size_t i = 0; chosen && i < sizeof formats / sizeof *formats; i++)
        if (!strcmp(formats[i].format, chosen))
            write = formats[i].write;
    if (write)
        result = write(context, volume, path);
    else
        result = pv_fail(context, result, "%s: a volume is written as .nrrd, .nrrd.gz, .vti, .raw or .tif", path);
    pv_call_end(context, outer);
    errno = before;
    return result;
}

/* What a header says. */
typedef struct layout {
    pave_volume_params place;
    int64_t data;   /* where values begin */
    int packed, big;
    char file[MOST_PATH]; /* values lie in another file */
} layout;

static int read_sizes(const char *text, layout *l, int dimension)
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

/* All numbers of a line, whatever stands between them; returns how many. */
static int read_reals(const char *text, double *out, int most)
{
    int count = 0;
    while (*text && count < most) {
        char word[NUMBER];
        size_t n = strspn(text, "0123456789+-.eE");
        if (n && n < sizeof word) {
            memcpy(word, text, n);
            word[n] = 0;
            count += pv_parse_number(word, &out[count]);
        }
        text += n ? n : 1;
    }
    return count;
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

static pave_result nrrd_field(pave_context *context, const char *path, const char *key, const char *value, layout *l,
                              int *dimension)
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
    else if (!strcmp(key, "space directions") && read_reals(value, n, 9) == 9)
        l->place.spacing = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    else if (!strcmp(key, "space origin") && read_reals(value, n, 3) == 3)
        memcpy(l->place.origin, n, sizeof l->place.origin);
    else if (!strcmp(key, "data file") || !strcmp(key, "datafile"))
        snprintf(l->file, sizeof l->file, "%s", value);
    return fine ? PAVE_OK : pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: an NRRD with %s '%s' is not read", path, key,
                                    value);
}

static pave_result read_nrrd_head(pave_context *context, const char *path, char *text, layout *l)
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

static pave_result read_vti_head(pave_context *context, const char *path, char *text, int64_t length, layout *l)
{
    const char *extent = strstr(text, "WholeExtent=\""), *type = strstr(text, "<DataArray type=\"");
    const char *parts = strstr(text, "NumberOfComponents=\""), *data = memmem(text, (size_t)length, "\n_", 2);
    const char *origin = strstr(text, "Origin=\""), *spacing = strstr(text, "Spacing=\"");
    double e[6], s[3];
    if (!extent || !type || !data || !strstr(text, "encoding=\"raw\"") || !strstr(text, "UInt64") ||
        read_reals(extent, e, 6) != 6)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: of VTK image data, one raw appended array is read", path);
    l->place.width = (int32_t)(e[1] - e[0]) + 1;
    l->place.height = (int32_t)(e[3] - e[2]) + 1;
    l->place.depth = (int32_t)(e[5] - e[4]) + 1;
    type += strlen("<DataArray type=\"");
    l->place.type = !strncmp(type, "UInt8\"", 6) ? PAVE_U8 : !strncmp(type, "UInt16\"", 7) ? PAVE_U16
                    : !strncmp(type, "Float32\"", 8) ? PAVE_F32 : 0;
    l->place.channels = parts ? atoi(parts + strlen("NumberOfComponents=\"")) : 1;
    if (origin)
        read_reals(origin + 8, l->place.origin, 3);
    if (spacing && read_reals(spacing + 9, s, 3) == 3)
        l->place.spacing = s[0];
    l->data = data - text + 2 + (int64_t)sizeof(uint64_t);
    return PAVE_OK;
}

static pave_result inflate_values(pave_context *context, const char *path, const uint8_t *bytes, int64_t size,
                                  pave_volume *v)
{
    z_stream z;
    size_t all = value_bytes(v), at = 0;
    int64_t from = 0;
    int status = Z_OK;
    memset(&z, 0, sizeof z);
    if (inflateInit2(&z, 15 + 32) != Z_OK)
        return pv_fail(context, PAVE_ERR_MEMORY, "out of memory: zlib cannot start");
    while (status == Z_OK && at < all && (from < size || z.avail_in)) {
        if (!z.avail_in) {
            z.next_in = (uint8_t *)(uintptr_t)(bytes + from);
            z.avail_in = (uInt)(size - from < CHUNK ? size - from : CHUNK);
            from += z.avail_in;
        }
        z.next_out = v->values + at;
        z.avail_out = (uInt)(all - at < CHUNK ? all - at : CHUNK);
        uInt room = z.avail_out;
        status = inflate(&z, Z_NO_FLUSH);
        at += room - z.avail_out;
    }
    inflateEnd(&z);
    return at == all ? PAVE_OK : pv_fail(context, PAVE_ERR_FORMAT, "%s: its compressed values are damaged", path);
}

static void swap_ends(pave_volume *v)
{
    size_t each = pv_type_bytes(v->type), all = value_bytes(v);
    for (size_t at = 0; at < all && each > 1; at += each)
        for (size_t i = 0; i < each / 2; i++) {
            uint8_t b = v->values[at + i];
            v->values[at + i] = v->values[at + each - 1 - i];
            v->values[at + each - 1 - i] = b;
        }
}

/* NaN is a voxel without a value. */
static void set_states(pave_volume *v)
{
    int64_t n = (int64_t)v->size[0] * v->size[1] * v->size[2];
    for (int64_t i = 0; i < n; i++) {
        v->states[i] = PAVE_VOXEL_MEASURED;
        for (int32_t c = 0; c < v->channels; c++)
            if (v->type == PAVE_F32 && !isfinite(((const float *)(const void *)v->values)[i * v->channels + c]))
                v->states[i] = PAVE_VOXEL_FREE;
    }
}

static pave_result read_values(pave_context *context, pv_input *input, const layout *l, pave_volume **out)
{
    uint8_t *bytes = NULL;
    pave_result result = pv_volume_new(context, &l->place, out);
    if (result)
        return result;
    pave_volume *v = *out;
    int64_t left = input->size - l->data;
    if (l->packed) {
        result = pv_input_load(input, &bytes);
        if (!result)
            result = inflate_values(context, input->path, bytes + l->data, left, v);
    } else if (left < (int64_t)value_bytes(v))
        result = pv_fail(context, PAVE_ERR_FORMAT, "%s: holds %lld bytes of values, but its header speaks of %zu",
                         input->path, (long long)left, value_bytes(v));
    else
        result = pv_input_read(input, l->data, v->values, (int64_t)value_bytes(v));
    pv_release(bytes);
    if (!result && l->big)
        swap_ends(v);
    if (!result)
        set_states(v);
    return result;
}

static pave_result read_file(pave_context *context, const char *path, pave_volume **out)
{
    pv_input input, values;
    char text[HEAD + 1], other[2 * MOST_PATH];
    layout l = { .place = PAVE_VOLUME_PARAMS_INIT };
    pave_result result = pv_input_open(context, path, &input);
    int64_t length = input.size < HEAD ? input.size : HEAD;
    if (!result)
        result = pv_input_read(&input, 0, text, length);
    if (!result) {
        text[length] = 0;
        result = !memcmp(text, "NRRD", 4)       ? read_nrrd_head(context, path, text, &l)
                 : strstr(text, "<VTKFile")     ? read_vti_head(context, path, text, length, &l)
                                                : pv_fail(context, PAVE_ERR_UNSUPPORTED,
                                                          "%s: volumes are read from NRRD and VTK image data", path);
    }
    if (!result && l.file[0]) {
        const char *slash = strrchr(path, '/');
        snprintf(other, sizeof other, "%.*s%s", slash ? (int)(slash - path) + 1 : 0, path, l.file);
        result = pv_input_open(context, other, &values);
        if (!result)
            result = read_values(context, &values, &l, out);
        pv_input_close(&values);
    } else if (!result)
        result = read_values(context, &input, &l, out);
    pv_input_close(&input);
    return result;
}

static pave_result add_page(pave_context *context, const pave_image *image, int32_t page, pave_volume *v)
{
    if (image->width != v->size[0] || image->height != v->size[1] || image->channels != v->channels ||
        image->type != v->type)
        return pv_fail(context, PAVE_ERR_FORMAT, "page %d of the stack differs from the first", (int)page);
    size_t bytes = value_bytes(v) / (size_t)v->size[2];
    memcpy(v->values + (size_t)page * bytes, image->pixels, bytes);
    return PAVE_OK;
}

static pave_result read_page(pave_context *context, const char *path, int32_t page, pave_image **out)
{
    char name[MOST_PATH];
    if (!page_path(path, page, name))
        return pv_fail(context, PAVE_ERR_IO, "%s: cannot be read: the name is too long", path);
    return pave_image_read(context, name, out);
}

/* How many pages there are, without a gap. */
static int32_t count_pages(const char *path)
{
    char name[MOST_PATH];
    int32_t pages = 0;
    for (; pages < 1 << 20 && page_path(path, pages, name); pages++) {
        FILE *file = fopen(name, "rb");
        if (!file)
            break;
        fclose(file);
    }
    return pages;
}

static pave_result read_stack(pave_context *context, const char *path, pave_volume **out)
{
    pave_volume_params place = PAVE_VOLUME_PARAMS_INIT;
    pave_result result = PAVE_OK;
    int32_t pages = count_pages(path);
    for (int32_t z = 0; (z < pages || z == 0) && !result; z++) {
        pave_image *image = NULL;
        result = read_page(context, path, z, &image);
        if (!result && z == 0) {
            place.width = image->width;
            place.height = image->height;
            place.depth = pages;
            place.channels = image->channels;
            place.type = image->type;
            result = pv_volume_new(context, &place, out);
        }
        if (!result)
            result = add_page(context, image, z, *out);
        pave_image_free(&image);
    }
    if (!result)
        set_states(*out);
    return result;
}

pave_result pave_volume_read(pave_context *context, const char *path, pave_volume **out)
{
    if (out)
        *out = NULL;
    if (!context || !path || !out)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    char sidecar[MOST_PATH];
    pv_call outer = pv_call_begin(context, "read", 0, 1);
    pave_result result = PAVE_OK;
    if (ends_with(path, ".tif") || ends_with(path, ".tiff"))
        result = read_stack(context, path, out);
    else if (ends_with(path, ".raw") && strlen(path) + 6 < sizeof sidecar) {
        snprintf(sidecar, sizeof sidecar, "%s.nhdr", path);
        result = read_file(context, sidecar, out);
    } else
        result = read_file(context, path, out);
    if (result)
        pave_volume_free(out);
    pv_call_end(context, outer);
    errno = before;
    return result;
}
