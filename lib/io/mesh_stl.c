/* STL, text and binary: some binary files say "solid", too. */
#include "io/mesh.h"

#include <string.h>

static pave_result read_binary_stl(pv_mesh_reader *r, int64_t count)
{
    enum { HEAD = 84, RECORD = 50, NORMAL = 12 };
    pave_result result = PAVE_OK;
    for (int64_t t = 0; t < count && !result; t++) {
        int64_t first = r->vertex_count / 3;
        for (int c = 0; c < 3 && !result; c++) {
            const uint8_t *from = r->bytes + HEAD + t * RECORD + NORMAL + 12 * c;
            double p[3];
            for (int k = 0; k < 3; k++)
                p[k] = pv_mesh_number(from + 4 * k, 'f', 4, 0);
            result = pv_mesh_vertex(r, p);
        }
        if (!result)
            result = pv_mesh_triangle(r, first, first + 1, first + 2);
    }
    return result;
}

static pave_result read_text_stl(pv_mesh_reader *r)
{
    pave_result result = PAVE_OK;
    char line[512];
    pv_polygon_fan face = { 0, 0, 0 };
    while (!result && pv_mesh_line(r, line, sizeof line)) {
        char *rest = line, *word = pv_mesh_word(&rest);
        double p[3];
        if (word && !strcmp(word, "facet"))
            face = (pv_polygon_fan){ 0, 0, 0 };
        if (!word || strcmp(word, "vertex"))
            continue;
        result = pv_mesh_numbers(&rest, p, 3) ? pv_mesh_vertex(r, p)
                                              : pv_mesh_wrong(r, "a vertex needs three finite numbers");
        if (!result)
            result = pv_mesh_corner(r, &face, r->vertex_count / 3 - 1);
    }
    return result;
}

/* Binary if its size is what its count of triangles says, whatever its first word. */
pave_result pv_mesh_read_stl(pv_mesh_reader *r)
{
    int64_t count = r->size >= 84 ? (int64_t)pv_mesh_number(r->bytes + 80, 'u', 4, 0) : -1;
    if (count >= 0 && 84 + 50 * count == r->size)
        return read_binary_stl(r, count);
    if (r->size >= 5 && !memcmp(r->bytes, "solid", 5))
        return read_text_stl(r);
    return pv_mesh_wrong(r, "is not an STL file: its size does not fit its number of triangles");
}
