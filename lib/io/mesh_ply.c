/* Stanford PLY: text and both ends of binary, any properties. */
#include "io/mesh.h"

#include "util/text.h"

#include <math.h>
#include <string.h>

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
    pv_mesh_reader *r;
    int format; /* 0 text, 1 little, 2 big */
    element elements[MOST_ELEMENTS];
    int element_count;
    char line[PV_MESH_LINE], *rest;
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
        return pv_mesh_wrong(p->r, "a property without an element, or too many");
    element *e = &p->elements[p->element_count - 1];
    property *q = &e->properties[e->property_count++];
    char *type = pv_mesh_word(&rest);
    *q = (property){ .what = -1 };
    q->list = type && !strcmp(type, "list");
    if (q->list && !ply_type(pv_mesh_word(&rest), &q->count_kind, &q->count_bytes))
        return pv_mesh_wrong(p->r, "a list of an unknown type");
    if (!ply_type(q->list ? pv_mesh_word(&rest) : type, &q->kind, &q->bytes))
        return pv_mesh_wrong(p->r, "a property of an unknown type");
    char *name = pv_mesh_word(&rest);
    if (name && e->vertex && !q->list && name[0] >= 'x' && name[0] <= 'z' && !name[1])
        q->what = name[0] - 'x';
    if (name && e->face && q->list && (!strcmp(name, "vertex_indices") || !strcmp(name, "vertex_index")))
        q->what = 3;
    return PAVE_OK;
}

static pave_result ply_head_line(ply *p, int *done)
{
    char *rest = p->line, *word = pv_mesh_word(&rest), *name;
    double count;
    if (!word || !strcmp(word, "comment") || !strcmp(word, "obj_info") || !strcmp(word, "ply"))
        return PAVE_OK;
    *done = !strcmp(word, "end_header");
    if (!strcmp(word, "format")) {
        name = pv_mesh_word(&rest);
        p->format = !name ? -1 : !strcmp(name, "ascii") ? 0 : !strcmp(name, "binary_little_endian") ? 1
                    : !strcmp(name, "binary_big_endian") ? 2 : -1;
        return p->format < 0 ? pv_mesh_wrong(p->r, "is of an unknown PLY format") : PAVE_OK;
    }
    if (!strcmp(word, "element")) {
        name = pv_mesh_word(&rest);
        if (!name || p->element_count == MOST_ELEMENTS || !pv_mesh_numbers(&rest, &count, 1) || count < 0 ||
            count > 1e10)
            return pv_mesh_wrong(p->r, "an element without name or number, or too many");
        p->elements[p->element_count++] = (element){ .count = (int64_t)count, .vertex = !strcmp(name, "vertex"),
                                                     .face = !strcmp(name, "face") };
    }
    return strcmp(word, "property") ? PAVE_OK : ply_property(p, rest);
}

static int ply_value(ply *p, char kind, int bytes, double *out)
{
    pv_mesh_reader *r = p->r;
    if (p->format == 0) {
        char *word;
        while (!(word = pv_mesh_word(&p->rest))) {
            if (!pv_mesh_line(r, p->line, PV_MESH_LINE))
                return 0;
            p->rest = p->line;
        }
        return pv_parse_number(word, out);
    }
    if (r->size - r->at < bytes)
        return 0;
    *out = pv_mesh_number(r->bytes + r->at, kind, bytes, p->format == 2);
    r->at += bytes;
    return 1;
}

static pave_result ply_list(ply *p, const property *q)
{
    double count, index;
    pv_polygon_fan face = { 0, 0, 0 };
    pave_result result = PAVE_OK;
    if (!ply_value(p, q->count_kind, q->count_bytes, &count) || count < 0)
        return pv_mesh_wrong(p->r, "ends within its elements, or has a word that is no number");
    for (double i = 0; i < count && !result; i++) {
        if (!ply_value(p, q->kind, q->bytes, &index))
            return pv_mesh_wrong(p->r, "ends within its elements, or has a word that is no number");
        if (q->what != 3)
            continue;
        if (index < 0 || index != floor(index) || index * 3 >= (double)p->r->vertex_count)
            return pv_mesh_wrong(p->r, "a face names a vertex that there is not");
        result = pv_mesh_corner(p->r, &face, (int64_t)index);
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
            result = pv_mesh_wrong(p->r, "ends within its elements, or has a word that is no number");
        else if (q->what >= 0)
            at[q->what] = value;
    }
    return result || !e->vertex ? result : pv_mesh_vertex(p->r, at);
}

static pave_result ply_read(ply *p)
{
    pave_result result = PAVE_OK;
    int done = 0;
    while (!result && !done) {
        if (!pv_mesh_line(p->r, p->line, PV_MESH_LINE))
            return pv_mesh_wrong(p->r, "ends within its header");
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

pave_result pv_mesh_read_ply(pv_mesh_reader *r)
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
