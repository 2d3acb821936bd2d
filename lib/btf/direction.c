/* Directions: the sets of measuring devices, and interpolation between them in the parabolic plane. */
#include "btf/btf.h"

#include <math.h>
#include <string.h>

enum { MOST_DIRECTIONS = 4096, DOTS = 4096, ONE = 1 << 24, FAR = 4 * ONE };

static const double degree = 3.14159265358979323846 / 180;

typedef struct ring { double theta, offset; int32_t count; } ring;

static const ring ubo81[] = {
    { 0, 0, 1 }, { 15, 0, 6 }, { 30, 0, 12 }, { 45, 0, 18 }, { 60, 0, 20 }, { 75, 0, 24 },
};
static const ring dome151[] = {
    { 0, 0, 1 },   { 11, 15, 6 },   { 23.5, 0, 12 }, { 30, 15, 12 },  { 37.5, 0, 12 },
    { 45, 0, 18 }, { 52.5, 7.5, 18 }, { 60, 0, 24 },  { 67.5, 0, 24 }, { 75, 0, 24 },
};

static int32_t list_rings(const ring *rings, int32_t count, pave_direction *out, int32_t room)
{
    int32_t n = 0;
    for (int32_t i = 0; i < count; i++)
        for (int32_t k = 0; k < rings[i].count; k++, n++) {
            double phi = rings[i].offset + 360.0 * k / rings[i].count;
            if (n < room)
                out[n] = (pave_direction){ (float)(rings[i].theta * degree),
                                           (float)((phi >= 180 ? phi - 360 : phi) * degree) };
        }
    return n;
}

int32_t pave_directions(int32_t set, pave_direction *out, int32_t room)
{
    switch (set) {
    case PAVE_DIRECTIONS_UBO81: return list_rings(ubo81, sizeof ubo81 / sizeof *ubo81, out, out ? room : 0);
    case PAVE_DIRECTIONS_DOME151: return list_rings(dome151, sizeof dome151 / sizeof *dome151, out, out ? room : 0);
    default: return 0;
    }
}

void pv_direction_vector(pave_direction direction, double vector[3])
{
    vector[0] = sin((double)direction.theta) * cos((double)direction.phi);
    vector[1] = sin((double)direction.theta) * sin((double)direction.phi);
    vector[2] = cos((double)direction.theta);
}

pave_direction pv_vector_direction(const double vector[3])
{
    double across = sqrt(vector[0] * vector[0] + vector[1] * vector[1]);
    return (pave_direction){ (float)atan2(across, vector[2]), across > 0 ? (float)atan2(vector[1], vector[0]) : 0 };
}

double pv_direction_distance(pave_direction a, pave_direction b)
{
    double u[3], v[3];
    pv_direction_vector(a, u);
    pv_direction_vector(b, v);
    double chord = hypot(hypot(u[0] - v[0], u[1] - v[1]), u[2] - v[2]);
    return 2 * asin(fmin(chord / 2, 1));
}

int32_t pv_directions_nearest(const pv_directions *directions, pave_direction direction, double *distance)
{
    int32_t nearest = 0;
    *distance = INFINITY;
    for (int32_t i = 0; i < directions->count; i++) {
        double away = pv_direction_distance(directions->direction[i], direction);
        if (away < *distance) {
            *distance = away;
            nearest = i;
        }
    }
    return nearest;
}

static void project(pave_direction direction, int32_t point[2])
{
    double radius = tan(fmin((double)direction.theta, 90 * degree) / 2);
    point[0] = (int32_t)floor(radius * cos((double)direction.phi) * ONE + 0.5);
    point[1] = (int32_t)floor(radius * sin((double)direction.phi) * ONE + 0.5);
}

/* Twice the area of a b c, positive if they turn to the left. */
static int64_t turn(const int32_t *a, const int32_t *b, const int32_t *c)
{
    return (int64_t)(b[0] - a[0]) * (c[1] - a[1]) - (int64_t)(b[1] - a[1]) * (c[0] - a[0]);
}

/* Is p inside the circle through a b c, which turn to the left? Exact. */
static int in_circle(const int32_t *a, const int32_t *b, const int32_t *c, const int32_t *p)
{
    int64_t ax = a[0] - p[0], ay = a[1] - p[1], bx = b[0] - p[0], by = b[1] - p[1], cx = c[0] - p[0], cy = c[1] - p[1];
    __int128 det = (__int128)(ax * ax + ay * ay) * (bx * cy - cx * by);
    det -= (__int128)(bx * bx + by * by) * (ax * cy - cx * ay);
    det += (__int128)(cx * cx + cy * cy) * (ax * by - bx * ay);
    return det > 0;
}

/* Edges that bound the cavity a new corner makes: those that are not shared by two triangles of it. */
static int32_t cavity_border(pv_directions *d, const int32_t *point, int32_t (*edges)[2])
{
    int32_t count = 0, kept = 0;
    for (int32_t t = 0; t < d->triangles; t++) {
        const int32_t *v = d->triangle[t];
        if (!in_circle(d->corner[v[0]], d->corner[v[1]], d->corner[v[2]], point)) {
            memmove(d->triangle[kept++], v, sizeof d->triangle[0]);
            continue;
        }
        for (int32_t k = 0; k < 3; k++) {
            int32_t a = v[k], b = v[(k + 1) % 3], twin = 0;
            while (twin < count && (edges[twin][0] != b || edges[twin][1] != a))
                twin++;
            if (twin < count)
                memcpy(edges[twin], edges[--count], sizeof edges[0]);
            else
                edges[count][0] = a, edges[count++][1] = b;
        }
    }
    d->triangles = kept;
    return count;
}

/* Bowyer 1981, Watson 1981. */
static void insert(pv_directions *d, int32_t corner, int32_t (*edges)[2])
{
    int32_t count = cavity_border(d, d->corner[corner], edges);
    for (int32_t i = 0; i < count; i++) {
        int32_t *t = d->triangle[d->triangles++];
        t[0] = edges[i][0], t[1] = edges[i][1], t[2] = corner;
    }
}

static void drop_scaffold(pv_directions *d)
{
    int32_t kept = 0;
    for (int32_t t = 0; t < d->triangles; t++) {
        const int32_t *v = d->triangle[t];
        if (v[0] < d->corners && v[1] < d->corners && v[2] < d->corners)
            memmove(d->triangle[kept++], v, sizeof d->triangle[0]);
    }
    d->triangles = kept;
}

static pave_result triangulate(pave_context *context, pv_directions *d)
{
    static const int32_t square[4][2] = { { -FAR, -FAR }, { FAR, -FAR }, { FAR, FAR }, { -FAR, FAR } };
    int32_t n = d->corners;
    pave_result result = PAVE_OK;
    int32_t(*edges)[2] = pv_allocate(context, (size_t)n * 2 + 16, sizeof *edges * 3, &result);
    if (result)
        return result;
    memcpy(d->corner[n], square, sizeof square);
    int32_t halves[2][3] = { { n, n + 1, n + 2 }, { n, n + 2, n + 3 } };
    memcpy(d->triangle, halves, sizeof halves);
    d->triangles = 2;
    for (int32_t i = 0; i < n; i++)
        insert(d, i, edges);
    drop_scaffold(d);
    pv_release(edges);
    return PAVE_OK;
}

static int32_t nearest(const pv_directions *d, const int32_t *point)
{
    int32_t best = 0;
    int64_t least = INT64_MAX;
    for (int32_t i = 0; i < d->count; i++) {
        int64_t dx = d->corner[i][0] - point[0], dy = d->corner[i][1] - point[1];
        if (dx * dx + dy * dy < least)
            least = dx * dx + dy * dy, best = i;
    }
    return best;
}

/* A ring just beyond the horizon, so that every direction lies in a triangle. */
static void add_horizon(pv_directions *d, int32_t count)
{
    double radius = 1.05 / cos(180 * degree / count) * ONE;
    for (int32_t k = 0; k < count; k++) {
        int32_t *at = d->corner[d->corners];
        at[0] = (int32_t)floor(radius * cos(360 * degree * k / count) + 0.5);
        at[1] = (int32_t)floor(radius * sin(360 * degree * k / count) + 0.5);
        d->stands_for[d->corners++] = nearest(d, at);
    }
}

static int32_t lowest_ring(const pv_directions *d)
{
    float lowest = 0;
    int32_t count = 0;
    for (int32_t i = 0; i < d->count; i++)
        lowest = d->direction[i].theta > lowest ? d->direction[i].theta : lowest;
    for (int32_t i = 0; i < d->count; i++)
        count += d->direction[i].theta > lowest - 0.01f;
    return count < 10 ? 10 : count > 360 ? 360 : count;
}

static pave_result check(pave_context *context, const char *what, const pv_directions *d)
{
    for (int32_t i = 0; i < d->count; i++) {
        const pave_direction *at = &d->direction[i];
        if (!(at->theta >= 0 && at->theta <= 1.5708f) || !(fabsf(at->phi) < 100))
            return pv_fail(context, PAVE_ERR_FORMAT, "%s %d points at inclination %g and azimuth %g degrees: it is not "
                           "above the surface", what, (int)i, at->theta / degree, at->phi / degree);
        for (int32_t k = 0; k < i; k++)
            if (d->corner[k][0] == d->corner[i][0] && d->corner[k][1] == d->corner[i][1])
                return pv_fail(context, PAVE_ERR_FORMAT, "%ss %d and %d have the same direction", what, (int)k, (int)i);
    }
    return PAVE_OK;
}

static pave_result allocate(pave_context *context, int32_t count, pv_directions *d)
{
    pave_result result = PAVE_OK;
    size_t corners = (size_t)count + 364;
    d->direction = pv_allocate(context, (size_t)count, sizeof *d->direction, &result);
    if (!result)
        d->corner = pv_allocate(context, corners, sizeof *d->corner, &result);
    if (!result)
        d->stands_for = pv_allocate(context, corners, sizeof *d->stands_for, &result);
    if (!result)
        d->triangle = pv_allocate(context, 2 * corners + 8, sizeof *d->triangle, &result);
    return result;
}

pave_result pv_directions_create(pave_context *context, const char *what, const pave_direction *given, int32_t count,
                                 pv_directions *out)
{
    memset(out, 0, sizeof *out);
    if (count < 1 || count > MOST_DIRECTIONS || !given)
        return pv_fail(context, PAVE_ERR_FORMAT, "there are %d %ss, and 1 to %d can be", (int)count, what,
                       MOST_DIRECTIONS);
    pave_result result = allocate(context, count, out);
    if (result)
        return result;
    memcpy(out->direction, given, (size_t)count * sizeof *given);
    out->count = out->corners = count;
    for (int32_t i = 0; i < count; i++) {
        if (isfinite(given[i].theta) && isfinite(given[i].phi))
            project(given[i], out->corner[i]);
        out->stands_for[i] = i;
    }
    result = check(context, what, out);
    if (result)
        return result;
    add_horizon(out, lowest_ring(out));
    return triangulate(context, out);
}

void pv_directions_free(pv_directions *directions)
{
    pv_release(directions->direction);
    pv_release(directions->corner);
    pv_release(directions->stands_for);
    pv_release(directions->triangle);
    memset(directions, 0, sizeof *directions);
}

void pv_directions_weigh(const pv_directions *d, pave_direction direction, int32_t index[3], double weight[3])
{
    int32_t p[2];
    project(direction, p);
    for (int32_t t = 0; t < d->triangles; t++) {
        const int32_t *v = d->triangle[t];
        const int32_t *a = d->corner[v[0]], *b = d->corner[v[1]], *c = d->corner[v[2]];
        int64_t area[3] = { turn(b, c, p), turn(c, a, p), turn(a, b, p) };
        if (area[0] < 0 || area[1] < 0 || area[2] < 0)
            continue;
        double whole = (double)(area[0] + area[1] + area[2]);
        for (int32_t k = 0; k < 3; k++) {
            index[k] = d->stands_for[v[k]];
            weight[k] = (double)area[k] / whole;
        }
        return;
    }
    index[0] = index[1] = index[2] = nearest(d, p);
    weight[0] = 1, weight[1] = weight[2] = 0;
}

/* Counted on an even spiral. */
void pv_directions_share(const pv_directions *directions, double *share)
{
    memset(share, 0, (size_t)directions->count * sizeof *share);
    for (int32_t k = 0; k < DOTS; k++) {
        double z = (k + 0.5) / DOTS, r = sqrt(1 - z * z), a = k * 2.399963229728653;
        double d[3] = { r * cos(a), r * sin(a), z }, most = -2;
        int32_t best = 0;
        for (int32_t l = 0; l < directions->count; l++) {
            double v[3];
            pv_direction_vector(directions->direction[l], v);
            double near = d[0] * v[0] + d[1] * v[1] + d[2] * v[2];
            if (near > most)
                most = near, best = l;
        }
        share[best] += 360 * degree / DOTS;
    }
}

pave_result pv_directions_match(pave_context *context, const char *holder, const char *what, const pv_directions *own,
                                const pv_directions *all, int32_t *out)
{
    for (int32_t i = 0; i < own->count; i++) {
        double away;
        out[i] = pv_directions_nearest(all, own->direction[i], &away);
        if (away > 1.01 * degree)
            return pv_fail(context, PAVE_ERR_ARGUMENT, "%s is of other directions: %s %d, at %.2f and %.2f degrees, is "
                           "%.2f degrees from its nearest", holder, what, (int)i,
                           (double)own->direction[i].theta / degree, (double)own->direction[i].phi / degree,
                           away / degree);
        for (int32_t k = 0; k < i; k++)
            if (out[k] == out[i])
                return pv_fail(context, PAVE_ERR_ARGUMENT, "%s is of other directions: its %s %d is the nearest to %d "
                               "and to %d", holder, what, (int)out[i], (int)k, (int)i);
    }
    return PAVE_OK;
}
