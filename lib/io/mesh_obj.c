/* Wavefront OBJ: polygons, indices from the end, texture and normal indices, lines that go on. */
#include "io/mesh.h"

#include "util/text.h"

#include <math.h>
#include <string.h>

/* "7", "7/1", "7//3", "-1/2/3": the vertex, from 0; -1 if it is none. */
static int64_t obj_vertex(const pv_mesh_reader *r, char *word)
{
    double value;
    word[strcspn(word, "/")] = 0;
    if (!pv_parse_number(word, &value) || value != floor(value) || value == 0 || fabs(value) > INT32_MAX)
        return -1;
    int64_t count = r->vertex_count / 3, index = value < 0 ? count + (int64_t)value : (int64_t)value - 1;
    return index >= 0 && index < count ? index : -1;
}

static pave_result obj_line(pv_mesh_reader *r, char *line)
{
    char *rest = line, *word = pv_mesh_word(&rest);
    double p[3];
    pv_polygon_fan face = { 0, 0, 0 };
    pave_result result = PAVE_OK;
    if (!word)
        return PAVE_OK;
    if (!strcmp(word, "v"))
        return pv_mesh_numbers(&rest, p, 3) ? pv_mesh_vertex(r, p)
                                            : pv_mesh_wrong(r, "a vertex needs three finite numbers");
    if (strcmp(word, "f"))
        return PAVE_OK;
    while (!result && (word = pv_mesh_word(&rest)) && *word != '#') {
        int64_t vertex = obj_vertex(r, word);
        result = vertex < 0 ? pv_mesh_wrong(r, "a face names a vertex that there is not")
                            : pv_mesh_corner(r, &face, vertex);
    }
    return result || face.corners >= 3 ? result : pv_mesh_wrong(r, "a face has fewer than three corners");
}

pave_result pv_mesh_read_obj(pv_mesh_reader *r)
{
    pave_result result = PAVE_OK;
    char *line = pv_allocate(r->context, PV_MESH_LINE, 1, &result);
    while (!result && pv_mesh_line(r, line, PV_MESH_LINE)) {
        result = obj_line(r, line);
        if (!result && r->line % 8192 == 0)
            result = pv_progress(r->context, 0.9 * (double)r->at / (double)r->size);
    }
    pv_release(line);
    return result;
}
