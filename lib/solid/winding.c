/* The generalised winding number of a surface at a point: the solid angle it covers, over that of the sphere. */
#include "solid/surface.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAF = 8 };

typedef struct node {
    double centre[3], area[3]; /* of the surface below: area-weighted centre, sum of normals times areas */
    double radius;             /* around the centre, of everything below */
    int32_t from, to;          /* triangles, if it is a leaf */
    int32_t child;             /* the first of two; 0: a leaf */
} node;

struct pv_winding {
    const double *vertices;
    int32_t (*triangles)[3];
    node *nodes;
    int32_t node_count;
};

/* atan2 by a polynomial in IEEE arithmetic, for libm's last digits differ between machines. Error under 1e-5. */
static double angle(double y, double x)
{
    static const double pi = 3.14159265358979323846;
    double ax = fabs(x), ay = fabs(y), most = ax > ay ? ax : ay;
    if (most == 0)
        return 0;
    double t = (ax < ay ? ax : ay) / most, s = t * t;
    double a = 0.05265332 - s * 0.01172120;
    a = t * (0.99997726 + s * (-0.33262347 + s * (0.19354346 + s * (-0.11643287 + s * a))));
    if (ay > ax)
        a = pi / 2 - a;
    if (x < 0)
        a = pi - a;
    return y < 0 ? -a : a;
}

static void minus(const double *a, const double *b, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[k] - b[k];
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double *a, const double *b, double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Van Oosterom and Strackee 1983. */
static double solid_angle(const pv_winding *w, int32_t triangle, const double point[3])
{
    double v[3][3], n[3], l[3];
    for (int k = 0; k < 3; k++) {
        minus(w->vertices + 3 * (size_t)w->triangles[triangle][k], point, v[k]);
        l[k] = sqrt(dot(v[k], v[k]));
    }
    cross(v[1], v[2], n);
    return 2 * angle(dot(v[0], n), l[0] * l[1] * l[2] + dot(v[0], v[1]) * l[2] + dot(v[1], v[2]) * l[0] +
                                       dot(v[2], v[0]) * l[1]);
}

static double centre_along(const pv_winding *w, const int32_t *t, int axis)
{
    return w->vertices[3 * (size_t)t[0] + (size_t)axis] + w->vertices[3 * (size_t)t[1] + (size_t)axis] +
           w->vertices[3 * (size_t)t[2] + (size_t)axis];
}

static void sum_up(const pv_winding *w, node *n)
{
    double all = 0;
    for (int32_t i = n->from; i < n->to; i++) {
        const double *a = w->vertices + 3 * (size_t)w->triangles[i][0];
        double e[3], f[3], area[3];
        minus(w->vertices + 3 * (size_t)w->triangles[i][1], a, e);
        minus(w->vertices + 3 * (size_t)w->triangles[i][2], a, f);
        cross(e, f, area);
        double weight = sqrt(dot(area, area)) + 1e-300;
        for (int k = 0; k < 3; k++) {
            n->area[k] += area[k] / 2;
            n->centre[k] += weight * centre_along(w, w->triangles[i], k) / 3;
        }
        all += weight;
    }
    for (int k = 0; k < 3; k++)
        n->centre[k] /= all;
    for (int32_t i = n->from; i < n->to; i++)
        for (int c = 0; c < 3; c++) {
            double d[3];
            minus(w->vertices + 3 * (size_t)w->triangles[i][c], n->centre, d);
            n->radius = fmax(n->radius, sqrt(dot(d, d)));
        }
}

/* The half of the triangles with the smaller coordinates first: quickselect by the middle one of three. */
static void split(const pv_winding *w, int32_t from, int32_t to, int axis)
{
    int32_t middle = (from + to) / 2;
    while (to - from > 1) {
        double pivot = centre_along(w, w->triangles[from + (to - from) / 2], axis);
        int32_t i = from, j = to - 1;
        while (i <= j) {
            while (centre_along(w, w->triangles[i], axis) < pivot)
                i++;
            while (centre_along(w, w->triangles[j], axis) > pivot)
                j--;
            if (i <= j) {
                int32_t swap[3];
                memcpy(swap, w->triangles[i], sizeof swap);
                memcpy(w->triangles[i++], w->triangles[j], sizeof swap);
                memcpy(w->triangles[j--], swap, sizeof swap);
            }
        }
        if (middle <= j)
            to = j + 1;
        else if (middle >= i)
            from = i;
        else
            return;
    }
}

static void build(pv_winding *w, int32_t index, int32_t from, int32_t to)
{
    node *n = &w->nodes[index];
    n->from = from;
    n->to = to;
    sum_up(w, n);
    if (to - from <= LEAF)
        return;
    double least[3] = { INFINITY, INFINITY, INFINITY }, most[3] = { -INFINITY, -INFINITY, -INFINITY };
    for (int32_t i = from; i < to; i++)
        for (int k = 0; k < 3; k++) {
            double c = centre_along(w, w->triangles[i], k);
            least[k] = fmin(least[k], c);
            most[k] = fmax(most[k], c);
        }
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (most[k] - least[k] > most[axis] - least[axis])
            axis = k;
    split(w, from, to, axis);
    int32_t child = n->child = w->node_count;
    w->node_count += 2;
    build(w, child, from, (from + to) / 2);
    build(w, child + 1, (from + to) / 2, to);
}

pave_result pv_winding_create(pave_context *context, const double *vertices, const pv_surface *surface,
                              pv_winding **out)
{
    pave_result result = PAVE_OK;
    pv_winding *w = *out = pv_allocate_zeroed(context, 1, sizeof *w, &result);
    if (!w)
        return result;
    w->vertices = vertices;
    w->triangles = pv_allocate(context, (size_t)surface->count, sizeof *w->triangles, &result);
    if (w->triangles)
        w->nodes = pv_allocate_zeroed(context, (size_t)surface->count * 2, sizeof *w->nodes, &result);
    if (!w->nodes) {
        pv_winding_free(w);
        *out = NULL;
        return result;
    }
    memcpy(w->triangles, surface->triangles, (size_t)surface->count * sizeof *w->triangles);
    w->node_count = 1;
    build(w, 0, 0, (int32_t)surface->count);
    return PAVE_OK;
}

void pv_winding_free(pv_winding *winding)
{
    if (!winding)
        return;
    pv_release(winding->triangles);
    pv_release(winding->nodes);
    pv_release(winding);
}

static double covered(const pv_winding *w, const node *n, const double point[3])
{
    static const double far = 2.5;
    double d[3], sum = 0;
    minus(n->centre, point, d);
    double length = sqrt(dot(d, d));
    if (length > far * n->radius)
        return dot(n->area, d) / (length * length * length);
    if (n->child)
        return covered(w, &w->nodes[n->child], point) + covered(w, &w->nodes[n->child + 1], point);
    for (int32_t i = n->from; i < n->to; i++)
        sum += solid_angle(w, i, point);
    return sum;
}

double pv_winding_number(const pv_winding *winding, const double point[3])
{
    return covered(winding, &winding->nodes[0], point) / (4 * 3.14159265358979323846);
}
