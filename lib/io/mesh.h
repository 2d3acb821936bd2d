/* What the readers of meshes share: a file, and the surface as it grows. */
#pragma once

#include "base/context.h"

enum { PV_MESH_LINE = 1 << 16 };

typedef struct pv_mesh_reader {
    pave_context *context;
    const char *path;
    const uint8_t *bytes;
    int64_t size, at;
    int64_t line; /* 0 where there are none */
    double *vertices;
    int32_t *triangles;
    int64_t vertex_count, vertex_room, triangle_count, triangle_room; /* in numbers, not triples */
} pv_mesh_reader;

/* A polygon, corner by corner, as a fan around its first. */
typedef struct pv_polygon_fan {
    int64_t first, last, corners;
} pv_polygon_fan;

/* Fails with what is wrong, and the line. */
pave_result pv_mesh_wrong(const pv_mesh_reader *r, const char *what);

pave_result pv_mesh_vertex(pv_mesh_reader *r, const double p[3]);
pave_result pv_mesh_triangle(pv_mesh_reader *r, int64_t a, int64_t b, int64_t c);
pave_result pv_mesh_corner(pv_mesh_reader *r, pv_polygon_fan *p, int64_t vertex);

/* The next line, without its end, cut to `capacity`; a backslash at the end goes on with the next. 0 at the end. */
int pv_mesh_line(pv_mesh_reader *r, char *out, size_t capacity);
/* The next word of a line, which is cut there; NULL: none. */
char *pv_mesh_word(char **rest);
int pv_mesh_numbers(char **rest, double *out, int count);
/* A number of so many bytes; its kind: 'f'loating, 'i'nteger, 'u'nsigned. */
double pv_mesh_number(const uint8_t *from, char kind, int bytes, int big);

pave_result pv_mesh_read_obj(pv_mesh_reader *r);
pave_result pv_mesh_read_stl(pv_mesh_reader *r);
pave_result pv_mesh_read_ply(pv_mesh_reader *r);
