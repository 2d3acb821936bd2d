/* Meshes in and out: what their readers share, the choice of one, and coloured PLY. */
#include "io/mesh.h"

#include "io/input.h"
#include "io/output.h"
#include "solid/solid.h"
#include "util/text.h"

#include <pave/io.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

pave_result pv_mesh_wrong(const pv_mesh_reader *r, const char *what)
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

pave_result pv_mesh_vertex(pv_mesh_reader *r, const double p[3])
{
    if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
        return pv_mesh_wrong(r, "a coordinate is not a finite number");
    pave_result result = more(r->context, (void **)&r->vertices, &r->vertex_room, r->vertex_count + 3, sizeof *p);
    if (result)
        return result;
    memcpy(r->vertices + r->vertex_count, p, 3 * sizeof *p);
    r->vertex_count += 3;
    return PAVE_OK;
}

pave_result pv_mesh_triangle(pv_mesh_reader *r, int64_t a, int64_t b, int64_t c)
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

pave_result pv_mesh_corner(pv_mesh_reader *r, pv_polygon_fan *p, int64_t vertex)
{
    pave_result result = PAVE_OK;
    if (p->corners == 0)
        p->first = vertex;
    if (p->corners >= 2)
        result = pv_mesh_triangle(r, p->first, p->last, vertex);
    p->last = vertex;
    p->corners++;
    return result;
}

int pv_mesh_line(pv_mesh_reader *r, char *out, size_t capacity)
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

char *pv_mesh_word(char **rest)
{
    char *p = *rest + strspn(*rest, " \t"), *end = p + strcspn(p, " \t");
    if (!*p)
        return NULL;
    *rest = *end ? end + 1 : end;
    *end = 0;
    return p;
}

int pv_mesh_numbers(char **rest, double *out, int count)
{
    for (int i = 0; i < count; i++) {
        char *word = pv_mesh_word(rest);
        if (!word || !pv_parse_number(word, &out[i]))
            return 0;
    }
    return 1;
}

double pv_mesh_number(const uint8_t *from, char kind, int bytes, int big)
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

static pave_result read_mesh(pv_mesh_reader *r, pave_mesh **out)
{
    pave_result result = r->size >= 3 && !memcmp(r->bytes, "ply", 3) ? pv_mesh_read_ply(r)
                         : pv_text_ends_with(r->path, ".stl")                 ? pv_mesh_read_stl(r)
                         : pv_text_ends_with(r->path, ".obj")                 ? pv_mesh_read_obj(r)
                                                                      : PAVE_ERR_UNSUPPORTED;
    if (result == PAVE_ERR_UNSUPPORTED)
        return pv_fail(r->context, result, "%s: meshes are read from .obj, .ply and .stl", r->path);
    r->line = 0;
    if (!result && !r->triangle_count)
        result = pv_mesh_wrong(r, "has no triangles");
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
    pv_mesh_reader r = { .context = context, .path = path };
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
