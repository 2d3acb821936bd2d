/* Meshes in and out: Wavefront OBJ, Stanford PLY, STL; coloured PLY out. What is met in real files is taken: polygons,
 * indices from the end, carriage returns, texture and normal indices, any property of a vertex, STL that says "solid"
 * and is binary. */
#include "io/input.h"
#include "io/output.h"
#include "solid/solid.h"
#include "util/text.h"

#include <pave/io.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct reader {
    pave_context *context;
    const char *path;
    const uint8_t *bytes;
    int64_t size, at;
    int64_t line;
    double *vertices;
    int32_t *triangles;
    int64_t vertex_count, vertex_room, triangle_count, triangle_room; /* in numbers, not triples */
} reader;

static pave_result wrong(const reader *r, const char *what)
{
    if (r->line)
        return pv_fail(r->context, PAVE_ERR_FORMAT, "%s: line %lld: %s", r->path, (long long)r->line, what);
    return pv_fail(r->context, PAVE_ERR_FORMAT, "%s: %s", r->path, what);
}

static pave_result more(pave_context *context, void **array, int64_t *room, int64_t wanted, size_t size)
{
    pave_result result = PAVE_OK;
    if (wanted <= *room)
        return PAVE_OK;
    int64_t grown = *room * 2 > wanted ? *room * 2 : wanted + 3072;
    void *block = *array ? pv_resize(context, *array, (size_t)*room, (size_t)grown, size, &result)
                         : pv_allocate(context, (size_t)grown, size, &result);
    if (!block)
        return result;
    *array = block;
    *room = grown;
    return PAVE_OK;
}

static pave_result add_vertex(reader *r, const double p[3])
{
    if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
        return wrong(r, "a coordinate is not a finite number");
    pave_result result = more(r->context, (void **)&r->vertices, &r->vertex_room, r->vertex_count + 3, sizeof *p);
    if (result)
        return result;
    memcpy(r->vertices + r->vertex_count, p, 3 * sizeof *p);
    r->vertex_count += 3;
    return PAVE_OK;
}

static pave_result add_triangle(reader *r, int64_t a, int64_t b, int64_t c)
{
    pave_result result = more(r->context, (void **)&r->triangles, &r->triangle_room, r->triangle_count + 3,
                              sizeof *r->triangles);
    if (result)
        return result;
    int32_t *to = r->triangles + r->triangle_count;
    to[0] = (int32_t)a, to[1] = (int32_t)b, to[2] = (int32_t)c;
    r->triangle_count += 3;
    return PAVE_OK;
}

/* A polygon, corner by corner, as a fan around its first. */
typedef struct polygon {
    int64_t first, last, corners;
} polygon;

static pave_result add_corner(reader *r, polygon *p, int64_t vertex)
{
    pave_result result = PAVE_OK;
    if (p->corners == 0)
        p->first = vertex;
    if (p->corners >= 2)
        result = add_triangle(r, p->first, p->last, vertex);
    p->last = vertex;
    p->corners++;
    return result;
}

/* The next line, without its end, cut to `capacity`; a backslash at the end goes on with the next. 0 at the end. */
static int next_line(reader *r, char *out, size_t capacity)
{
    size_t n = 0;
    if (r->at >= r->size)
        return 0;
    r->line++;
    while (r->at < r->size) {
        char c = (char)r->bytes[r->at++];
        if (c == '\r' && r->at < r->size && r->bytes[r->at] == '\n')
            c = (char)r->bytes[r->at++];
        if ((c == '\n' || c == '\r') && n && out[n - 1] == '\\') {
            out[n - 1] = ' ';
            r->line++;
            continue;
        }
        if (c == '\n' || c == '\r')
            break;
        if (n + 1 < capacity)
            out[n++] = c ? c : ' ';
    }
    out[n] = 0;
    return 1;
}

static char *next_word(char **rest)
{
    char *p = *rest + strspn(*rest, " \t"), *end = p + strcspn(p, " \t");
    if (!*p)
        return NULL;
    *rest = *end ? end + 1 : end;
    *end = 0;
    return p;
}

static int read_numbers(char **rest, double *out, int count)
{
    for (int i = 0; i < count; i++) {
        char *word = next_word(rest);
        if (!word || !pv_parse_number(word, &out[i]))
            return 0;
    }
    return 1;
}

/* "7", "7/1", "7//3", "-1/2/3": the vertex, from 0; -1 if it is none. */
static int64_t obj_vertex(const reader *r, char *word)
{
    double value;
    word[strcspn(word, "/")] = 0;
    if (!pv_parse_number(word, &value) || value != floor(value) || value == 0 || fabs(value) > INT32_MAX)
        return -1;
    int64_t count = r->vertex_count / 3, index = value < 0 ? count + (int64_t)value : (int64_t)value - 1;
    return index >= 0 && index < count ? index : -1;
}

static pave_result obj_line(reader *r, char *line)
{
    char *rest = line, *word = next_word(&rest);
    double p[3];
    polygon face = { 0, 0, 0 };
    pave_result result = PAVE_OK;
    if (!word)
        return PAVE_OK;
    if (!strcmp(word, "v"))
        return read_numbers(&rest, p, 3) ? add_vertex(r, p) : wrong(r, "a vertex needs three finite numbers");
    if (strcmp(word, "f"))
        return PAVE_OK;
    while (!result && (word = next_word(&rest)) && *word != '#') {
        int64_t vertex = obj_vertex(r, word);
        result = vertex < 0 ? wrong(r, "a face names a vertex that there is not") : add_corner(r, &face, vertex);
    }
    return result || face.corners >= 3 ? result : wrong(r, "a face has fewer than three corners");
}

enum { LINE = 1 << 16 };

static pave_result read_obj(reader *r)
{
    pave_result result = PAVE_OK;
    char *line = pv_allocate(r->context, LINE, 1, &result);
    while (!result && next_line(r, line, LINE)) {
        result = obj_line(r, line);
        if (!result && r->line % 8192 == 0)
            result = pv_progress(r->context, 0.9 * (double)r->at / (double)r->size);
    }
    pv_release(line);
    return result;
}

/* A number of an STL or PLY file. */
static double number_at(const uint8_t *from, char kind, int bytes, int big)
{
    uint8_t b[8] = { 0 };
    for (int i = 0; i < bytes; i++)
        b[i] = from[big ? bytes - 1 - i : i];
    uint64_t u = 0;
    for (int i = 7; i >= 0; i--)
        u = u << 8 | b[i];
    if (kind == 'f' && bytes == 4) {
        uint32_t u4 = (uint32_t)u;
        float f;
        memcpy(&f, &u4, 4);
        return f;
    }
    if (kind == 'f') {
        double d;
        memcpy(&d, &u, 8);
        return d;
    }
    if (kind == 'i' && u >> (8 * bytes - 1))
        return (double)(int64_t)(u - ((uint64_t)1 << (8 * bytes)));
    return (double)u;
}

static pave_result read_binary_stl(reader *r, int64_t count)
{
    enum { HEAD = 84, RECORD = 50, NORMAL = 12 };
    pave_result result = PAVE_OK;
    for (int64_t t = 0; t < count && !result; t++) {
        int64_t first = r->vertex_count / 3;
        for (int c = 0; c < 3 && !result; c++) {
            const uint8_t *from = r->bytes + HEAD + t * RECORD + NORMAL + 12 * c;
            double p[3];
            for (int k = 0; k < 3; k++)
                p[k] = number_at(from + 4 * k, 'f', 4, 0);
            result = add_vertex(r, p);
        }
        if (!result)
            result = add_triangle(r, first, first + 1, first + 2);
    }
    return result;
}

static pave_result read_text_stl(reader *r)
{
    pave_result result = PAVE_OK;
    char line[512];
    polygon face = { 0, 0, 0 };
    while (!result && next_line(r, line, sizeof line)) {
        char *rest = line, *word = next_word(&rest);
        double p[3];
        if (word && !strcmp(word, "facet"))
            face = (polygon){ 0, 0, 0 };
        if (!word || strcmp(word, "vertex"))
            continue;
        result = read_numbers(&rest, p, 3) ? add_vertex(r, p) : wrong(r, "a vertex needs three finite numbers");
        if (!result)
            result = add_corner(r, &face, r->vertex_count / 3 - 1);
    }
    return result;
}

/* Binary if its size is what its count of triangles says, whatever its first word. */
static pave_result read_stl(reader *r)
{
    int64_t count = r->size >= 84 ? (int64_t)number_at(r->bytes + 80, 'u', 4, 0) : -1;
    if (count >= 0 && 84 + 50 * count == r->size)
        return read_binary_stl(r, count);
    if (r->size >= 5 && !memcmp(r->bytes, "solid", 5))
        return read_text_stl(r);
    return wrong(r, "is not an STL file: its size does not fit its number of triangles");
}

enum { MOST_PROPERTIES = 64, MOST_ELEMENTS = 16 };

typedef struct property {
    int list, bytes, count_bytes;
    char kind, count_kind;
    int what; /* 0..2: x, y, z; 3: vertex indices; -1: other */
} property;

typedef struct element {
    int64_t count;
    int vertex, face;
    property properties[MOST_PROPERTIES];
    int property_count;
} element;

typedef struct ply {
    reader *r;
    int format; /* 0 text, 1 little, 2 big */
    element elements[MOST_ELEMENTS];
    int element_count;
    char line[LINE], *rest;
} ply;

static int ply_type(const char *name, char *kind, int *bytes)
{
    static const struct { const char *name; char kind; int bytes; } types[] = {
        { "char", 'i', 1 },  { "int8", 'i', 1 },   { "uchar", 'u', 1 }, { "uint8", 'u', 1 },   { "short", 'i', 2 },
        { "int16", 'i', 2 }, { "ushort", 'u', 2 }, { "uint16", 'u', 2 }, { "int", 'i', 4 },    { "int32", 'i', 4 },
        { "uint", 'u', 4 },  { "uint32", 'u', 4 }, { "float", 'f', 4 }, { "float32", 'f', 4 }, { "double", 'f', 8 },
        { "float64", 'f', 8 },
    };
    for (size_t i = 0; name && i < sizeof types / sizeof *types; i++)
        if (!strcmp(types[i].name, name))
            return *kind = types[i].kind, *bytes = types[i].bytes, 1;
    return 0;
}

static pave_result ply_property(ply *p, char *rest)
{
    if (!p->element_count || p->elements[p->element_count - 1].property_count == MOST_PROPERTIES)
        return wrong(p->r, "a property without an element, or too many");
    element *e = &p->elements[p->element_count - 1];
    property *q = &e->properties[e->property_count++];
    char *type = next_word(&rest);
    *q = (property){ .what = -1 };
    q->list = type && !strcmp(type, "list");
    if (q->list && !ply_type(next_word(&rest), &q->count_kind, &q->count_bytes))
        return wrong(p->r, "a list of an unknown type");
    if (!ply_type(q->list ? next_word(&rest) : type, &q->kind, &q->bytes))
        return wrong(p->r, "a property of an unknown type");
    char *name = next_word(&rest);
    if (name && e->vertex && !q->list && name[0] >= 'x' && name[0] <= 'z' && !name[1])
        q->what = name[0] - 'x';
    if (name && e->face && q->list && (!strcmp(name, "vertex_indices") || !strcmp(name, "vertex_index")))
        q->what = 3;
    return PAVE_OK;
}

static pave_result ply_head_line(ply *p, int *done)
{
    char *rest = p->line, *word = next_word(&rest), *name;
    double count;
    if (!word || !strcmp(word, "comment") || !strcmp(word, "obj_info") || !strcmp(word, "ply"))
        return PAVE_OK;
    *done = !strcmp(word, "end_header");
    if (!strcmp(word, "format")) {
        name = next_word(&rest);
        p->format = !name ? -1 : !strcmp(name, "ascii") ? 0 : !strcmp(name, "binary_little_endian") ? 1
                    : !strcmp(name, "binary_big_endian") ? 2 : -1;
        return p->format < 0 ? wrong(p->r, "is of an unknown PLY format") : PAVE_OK;
    }
    if (!strcmp(word, "element")) {
        name = next_word(&rest);
        if (!name || p->element_count == MOST_ELEMENTS || !read_numbers(&rest, &count, 1) || count < 0 || count > 1e10)
            return wrong(p->r, "an element without name or number, or too many");
        p->elements[p->element_count++] = (element){ .count = (int64_t)count, .vertex = !strcmp(name, "vertex"),
                                                     .face = !strcmp(name, "face") };
    }
    return strcmp(word, "property") ? PAVE_OK : ply_property(p, rest);
}

static int ply_value(ply *p, char kind, int bytes, double *out)
{
    reader *r = p->r;
    if (p->format == 0) {
        char *word;
        while (!(word = next_word(&p->rest))) {
            if (!next_line(r, p->line, LINE))
                return 0;
            p->rest = p->line;
        }
        return pv_parse_number(word, out);
    }
    if (r->size - r->at < bytes)
        return 0;
    *out = number_at(r->bytes + r->at, kind, bytes, p->format == 2);
    r->at += bytes;
    return 1;
}

static pave_result ply_list(ply *p, const property *q)
{
    double count, index;
    polygon face = { 0, 0, 0 };
    pave_result result = PAVE_OK;
    if (!ply_value(p, q->count_kind, q->count_bytes, &count) || count < 0)
        return wrong(p->r, "ends within its elements, or has a word that is no number");
    for (double i = 0; i < count && !result; i++) {
        if (!ply_value(p, q->kind, q->bytes, &index))
            return wrong(p->r, "ends within its elements, or has a word that is no number");
        if (q->what != 3)
            continue;
        if (index < 0 || index != floor(index) || index * 3 >= (double)p->r->vertex_count)
            return wrong(p->r, "a face names a vertex that there is not");
        result = add_corner(p->r, &face, (int64_t)index);
    }
    return result;
}

static pave_result ply_one(ply *p, const element *e)
{
    double at[3] = { 0, 0, 0 }, value;
    pave_result result = PAVE_OK;
    for (int i = 0; i < e->property_count && !result; i++) {
        const property *q = &e->properties[i];
        if (q->list)
            result = ply_list(p, q);
        else if (!ply_value(p, q->kind, q->bytes, &value))
            result = wrong(p->r, "ends within its elements, or has a word that is no number");
        else if (q->what >= 0)
            at[q->what] = value;
    }
    return result || !e->vertex ? result : add_vertex(p->r, at);
}

static pave_result ply_read(ply *p)
{
    pave_result result = PAVE_OK;
    int done = 0;
    while (!result && !done) {
        if (!next_line(p->r, p->line, LINE))
            return wrong(p->r, "ends within its header");
        result = ply_head_line(p, &done);
    }
    if (p->format > 0)
        p->r->line = 0;
    p->line[0] = 0;
    p->rest = p->line;
    for (int i = 0; i < p->element_count && !result; i++)
        for (int64_t n = 0; n < p->elements[i].count && !result; n++) {
            result = ply_one(p, &p->elements[i]);
            if (!result && n % 8192 == 0)
                result = pv_progress(p->r->context, 0.9 * (double)p->r->at / (double)p->r->size);
        }
    return result;
}

static pave_result read_ply(reader *r)
{
    pave_result result = PAVE_OK;
    ply *p = pv_allocate_zeroed(r->context, 1, sizeof *p, &result);
    if (!p)
        return result;
    p->r = r;
    result = ply_read(p);
    pv_release(p);
    return result;
}

static int ends_with(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    return n >= m && !strcasecmp(path + n - m, ending);
}

static pave_result read_mesh(reader *r, pave_mesh **out)
{
    pave_result result = r->size >= 3 && !memcmp(r->bytes, "ply", 3) ? read_ply(r)
                         : ends_with(r->path, ".stl")                 ? read_stl(r)
                         : ends_with(r->path, ".obj")                 ? read_obj(r)
                                                                      : PAVE_ERR_UNSUPPORTED;
    if (result == PAVE_ERR_UNSUPPORTED)
        return pv_fail(r->context, result, "%s: meshes are read from .obj, .ply and .stl", r->path);
    r->line = 0;
    if (!result && !r->triangle_count)
        result = wrong(r, "has no triangles");
    if (!result)
        result = pave_mesh_create(r->context, r->vertices, r->vertex_count / 3, r->triangles, r->triangle_count / 3,
                                  out);
    return result;
}

pave_result pave_mesh_read(pave_context *context, const char *path, pave_mesh **out)
{
    if (out)
        *out = NULL;
    if (!context || !path || !out)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    pv_input input;
    uint8_t *bytes = NULL;
    reader r = { .context = context, .path = path };
    pv_call outer = pv_call_begin(context, "read", 0, 1);
    pave_result result = pv_input_open(context, path, &input);
    if (!result)
        result = pv_input_load(&input, &bytes);
    if (!result) {
        r.bytes = bytes;
        r.size = input.size;
        result = read_mesh(&r, out);
    }
    pv_input_close(&input);
    pv_release(bytes);
    pv_release(r.vertices);
    pv_release(r.triangles);
    pv_call_end(context, outer);
    errno = before;
    return result;
}

static void put_vertex(pv_output *output, const pave_mesh *mesh, const pave_volume *volume, int64_t i)
{
    const double *p = mesh->vertices + 3 * i;
    float value[8] = { 0 }, place[3] = { (float)p[0], (float)p[1], (float)p[2] };
    uint8_t colour[3];
    pave_volume_sample(volume, p[0], p[1], p[2], value);
    for (int c = 0; c < 3; c++) {
        float v = volume->channels >= 3 ? value[c] : value[0];
        colour[c] = (uint8_t)floor(255 * fmin(fmax(v, 0), 1) + 0.5);
    }
    pv_output_bytes(output, place, sizeof place);
    pv_output_bytes(output, colour, sizeof colour);
}

pave_result pave_surface_write(pave_context *context, const pave_mesh *mesh, const pave_volume *volume,
                               const char *path)
{
    pv_output *output;
    char head[256];
    if (!context || !mesh || !volume || !path)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    snprintf(head, sizeof head, "element vertex %lld\nproperty float x\nproperty float y\nproperty float z\n"
             "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face %lld\n"
             "property list uchar int vertex_indices\nend_header\n", (long long)mesh->vertex_count,
             (long long)mesh->triangle_count);
    pv_output_text(output, "ply\nformat binary_little_endian 1.0\n");
    pv_output_text(output, head);
    for (int64_t i = 0; i < mesh->vertex_count; i++)
        put_vertex(output, mesh, volume, i);
    for (int64_t i = 0; i < mesh->triangle_count; i++) {
        pv_output_bytes(output, "\3", 1);
        pv_output_bytes(output, mesh->triangles + 3 * i, 3 * sizeof *mesh->triangles);
    }
    return pv_output_close(output, PAVE_OK);
}
