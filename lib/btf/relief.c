/* Recipes for reliefs: periodic height fields with a mineral at every point, one recipe a class. */
#include "btf/relief.h"

#include "util/noise.h"
#include "util/random.h"

#include <math.h>
#include <string.h>

typedef struct recipe {
    float depth;            /* of the relief, share of the side */
    float colour[3];        /* mean diffuse reflectance */
    float spread;           /* of materials about it */
    float rough[2];         /* least and most */
    float stretch;          /* rough_x : rough_y */
    float mirror;
    int32_t materials;
    float dirt;
} recipe;

static const recipe recipes[PAVE_BTF_CLASSES] = {
    [PAVE_BTF_FLAT] = { 0, { .45f, .40f, .33f }, 0, { .3f, .3f }, 1, .04f, 1, 0 },
    [PAVE_BTF_MINERALS] = { 0, { .40f, .38f, .36f }, .6f, { .1f, .5f }, 1, .05f, 4, 0 },
    [PAVE_BTF_SAWN] = { .012f, { .46f, .43f, .38f }, .25f, { .3f, .5f }, 1, .04f, 5, .3f },
    [PAVE_BTF_POLISHED] = { .002f, { .36f, .30f, .28f }, .6f, { .05f, .12f }, 1, .05f, 6, .05f },
    [PAVE_BTF_TILE] = { .03f, { .50f, .38f, .28f }, .2f, { .15f, .3f }, 1, .04f, 4, .4f },
    [PAVE_BTF_GROOVED] = { .02f, { .42f, .28f, .17f }, .25f, { .2f, .4f }, 2.0f, .04f, 4, .2f },
    [PAVE_BTF_BRUSHED] = { .003f, { .20f, .20f, .21f }, .1f, { .08f, .15f }, 4, .5f, 3, .05f },
    [PAVE_BTF_CONCRETE] = { .025f, { .42f, .41f, .39f }, .15f, { .4f, .6f }, 1, .03f, 4, .3f },
    [PAVE_BTF_COBBLE] = { .07f, { .34f, .32f, .31f }, .25f, { .25f, .45f }, 1, .04f, 6, .4f },
    [PAVE_BTF_ASPHALT] = { .04f, { .12f, .12f, .12f }, .6f, { .3f, .6f }, 1, .04f, 6, .3f },
    [PAVE_BTF_GRAVEL] = { .11f, { .40f, .36f, .31f }, .45f, { .25f, .6f }, 1, .04f, 8, .2f },
};

/* A number of 0 .. 1 for a lattice point. */
static float chance(uint32_t key, int32_t x, int32_t y)
{
    return (float)(pv_lattice_hash(key, x, y) >> 8) * 0x1p-24f;
}

static int32_t wrapped(int32_t i, int32_t n)
{
    return ((i % n) + n) % n;
}

static float corner(uint32_t key, int32_t x, int32_t y, int32_t nx, int32_t ny, float fx, float fy)
{
    int32_t cosine, sine;
    pv_turn((int32_t)(pv_lattice_hash(key, wrapped(x, nx), wrapped(y, ny)) >> 16), &cosine, &sine);
    return ((float)cosine * fx + (float)sine * fy) * 0x1p-16f;
}

static float fade(float t)
{
    return t * t * t * (t * (6 * t - 15) + 10);
}

/* Gradient noise of -1 .. 1 with nx x ny waves in the period; u and v of 0 .. 1. */
static float noise(uint32_t key, float u, float v, int32_t nx, int32_t ny)
{
    float x = u * (float)nx, y = v * (float)ny;
    int32_t ix = (int32_t)floorf(x), iy = (int32_t)floorf(y);
    float fx = x - (float)ix, fy = y - (float)iy, s = fade(fx), t = fade(fy);
    float a = corner(key, ix, iy, nx, ny, fx, fy), b = corner(key, ix + 1, iy, nx, ny, fx - 1, fy);
    float c = corner(key, ix, iy + 1, nx, ny, fx, fy - 1), d = corner(key, ix + 1, iy + 1, nx, ny, fx - 1, fy - 1);
    a += (b - a) * s;
    c += (d - c) * s;
    return (a + (c - a) * t) * 1.41f;
}

static float fractal(uint32_t key, float u, float v, int32_t waves, int32_t octaves, float gain)
{
    float sum = 0, weight = 1;
    for (int32_t i = 0; i < octaves; i++, weight *= gain, waves *= 2)
        sum += weight * noise(key + (uint32_t)i, u, v, waves, waves);
    return sum;
}

/* The nearest two points of a jittered n x n lattice that repeats, and whose the first is. */
typedef struct cell {
    float first, second; /* distances, lattice steps */
    float dx, dy;        /* from the point */
    int32_t x, y;
} cell;

static cell nearest_cell(uint32_t key, float u, float v, int32_t n, float jitter)
{
    float x = u * (float)n, y = v * (float)n;
    cell out = { 9, 9, 0, 0, 0, 0 };
    for (int32_t k = 0; k < 25; k++) {
        int32_t ix = (int32_t)floorf(x) + k % 5 - 2, iy = (int32_t)floorf(y) + k / 5 - 2;
        int32_t wx = wrapped(ix, n), wy = wrapped(iy, n);
        float dx = x - ((float)ix + 0.5f + jitter * (chance(key, wx, wy) - 0.5f));
        float dy = y - ((float)iy + 0.5f + jitter * (chance(key + 1, wx, wy) - 0.5f));
        float d = sqrtf(dx * dx + dy * dy);
        if (d < out.first)
            out = (cell){ d, out.first, dx, dy, wx, wy };
        else if (d < out.second)
            out.second = d;
    }
    return out;
}

/* What a recipe says of a point: height of -1 .. 1 or so, and the material. */
typedef struct point {
    float height;
    int32_t label;
} point;

static float smooth_step(float t)
{
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    return t * t * (3 - 2 * t);
}

static point plates(uint32_t key, float u, float v, int32_t n, float joint, float crown, float tilt)
{
    cell c = nearest_cell(key, u, v, n, 0.5f);
    float edge = (c.second - c.first) / 2, rise = smooth_step(edge / joint);
    float lean = tilt * (c.dx * (chance(key + 2, c.x, c.y) - 0.5f) + c.dy * (chance(key + 3, c.x, c.y) - 0.5f));
    float high = 1 + 0.3f * (chance(key + 4, c.x, c.y) - 0.5f) + lean - crown * c.first * c.first;
    return (point){ rise * high + 0.05f * fractal(key + 8, u, v, 4 * n, 3, 0.6f),
                    rise < 0.5f ? 0 : 1 + (int32_t)(pv_lattice_hash(key + 5, c.x, c.y) >> 16) };
}

/* Rounded stones of one size, the highest of which is seen. */
static point grains(uint32_t key, float u, float v, int32_t n, float size, float share)
{
    float x = u * (float)n, y = v * (float)n;
    point out = { -9, 0 };
    for (int32_t k = 0; k < 25; k++) {
        int32_t ix = (int32_t)floorf(x) + k % 5 - 2, iy = (int32_t)floorf(y) + k / 5 - 2;
        int32_t wx = wrapped(ix, n), wy = wrapped(iy, n), cosine, sine;
        if (chance(key + 9, wx, wy) > share)
            continue;
        float dx = x - ((float)ix + chance(key, wx, wy)), dy = y - ((float)iy + chance(key + 1, wx, wy));
        pv_turn((int32_t)(pv_lattice_hash(key + 2, wx, wy) >> 16), &cosine, &sine);
        float a = (dx * (float)cosine + dy * (float)sine) * 0x1p-16f;
        float b = (dy * (float)cosine - dx * (float)sine) * 0x1p-16f;
        float radius = size * (0.6f + 0.6f * chance(key + 3, wx, wy));
        a /= radius;
        b /= radius * (0.6f + 0.4f * chance(key + 4, wx, wy));
        float d = a * a + b * b, facet = fabsf(a) + fabsf(b);
        d = 0.6f * d + 0.4f * facet * facet * 0.7f;
        if (d >= 1)
            continue;
        float high = radius * sqrtf(1 - d) * 0.8f + 0.35f * (chance(key + 5, wx, wy) - 0.5f);
        if (high > out.height)
            out = (point){ high, 1 + (int32_t)(pv_lattice_hash(key + 6, wx, wy) >> 16) };
    }
    return out;
}

static point higher(point a, point b)
{
    return a.height > b.height ? a : b;
}

static point mineral_mix(uint32_t key, float u, float v, float height)
{
    cell c = nearest_cell(key, u, v, 24, 1);
    return (point){ height, (int32_t)(pv_lattice_hash(key + 7, c.x, c.y) >> 16) };
}

static point grooves(uint32_t key, float u, float v)
{
    float bend = 0.03f * noise(key, u, v, 2, 3), across = v + bend + 0.01f * noise(key + 1, u, v, 4, 12);
    float ring = fabsf(noise(key + 2, 0.37f, across, 1, 10)) + 0.4f * fabsf(noise(key + 3, u, across, 2, 40));
    float pore = noise(key + 4, u, v, 8, 96);
    return (point){ 0.8f - ring - (pore > 0.45f ? 0.6f : 0),
                    1 + (int32_t)(3 * fabsf(noise(key + 5, u, across, 1, 8))) };
}

static point concrete(uint32_t key, float u, float v)
{
    cell pore = nearest_cell(key, u, v, 12, 1);
    float radius = 0.28f * chance(key + 2, pore.x, pore.y) * chance(key + 3, pore.x, pore.y);
    float hole = pore.first < radius ? -1.2f * sqrtf(1 - pore.first * pore.first / (radius * radius)) : 0;
    return (point){ hole + 0.25f * fractal(key + 10, u, v, 6, 5, 0.6f),
                    1 + (int32_t)(4 * fabsf(noise(key + 6, u, v, 9, 9))) };
}

static point make_point(int32_t class_of, uint32_t key, float u, float v)
{
    switch (class_of) {
    case PAVE_BTF_MINERALS: return mineral_mix(key, u, v, 0);
    case PAVE_BTF_SAWN: return mineral_mix(key, u, v, 0.6f * fractal(key + 20, u, v, 4, 6, 0.62f));
    case PAVE_BTF_POLISHED: return mineral_mix(key, u, v, 0.5f * fractal(key + 20, u, v, 8, 3, 0.5f));
    case PAVE_BTF_TILE: return plates(key, u, v, 4, 0.05f, 0.05f, 0.3f);
    case PAVE_BTF_GROOVED: return grooves(key, u, v);
    case PAVE_BTF_BRUSHED: return (point){ noise(key, u, v, 3, 64) + 0.5f * noise(key + 1, u, v, 5, 128),
                                           (int32_t)(3 * fabsf(noise(key + 2, u, v, 2, 24))) };
    case PAVE_BTF_CONCRETE: return concrete(key, u, v);
    case PAVE_BTF_COBBLE: return plates(key, u, v, 5, 0.3f, 0.8f, 0.4f);
    case PAVE_BTF_ASPHALT: return higher((point){ 0.1f * fractal(key + 30, u, v, 12, 3, 0.5f), 0 },
                                         grains(key, u, v, 14, 0.5f, 0.85f));
    case PAVE_BTF_GRAVEL: return higher(higher((point){ -0.2f, 0 }, grains(key, u, v, 6, 0.75f, 1)),
                                        grains(key + 40, u, v, 11, 0.35f, 0.7f));
    default: return (point){ 0, 0 };
    }
}

static float mixed(float least, float most, float t)
{
    return least + (most - least) * t;
}

static void make_materials(const recipe *r, uint64_t seed, pv_relief *relief)
{
    relief->material_count = r->materials;
    for (int32_t i = 0; i < r->materials; i++) {
        pv_random a = pv_draw(seed, PV_DRAW_MATERIAL, (uint32_t)i, 0, 0), b = pv_draw(seed, PV_DRAW_MATERIAL, 0, 0, 1);
        pv_material *m = &relief->materials[i];
        float bright = 1 + r->spread * ((float)a.word[0] * 0x1p-31f - 1), rough = (float)a.word[1] * 0x1p-32f;
        float whole = 0.85f + 0.3f * (float)b.word[0] * 0x1p-32f, warm = 0.2f * ((float)b.word[1] * 0x1p-32f - 0.5f);
        warm += 0.3f * r->spread * ((float)a.word[2] * 0x1p-32f - 0.5f);
        for (int32_t c = 0; c < 3; c++)
            m->diffuse[c] = fminf(r->colour[c] * bright * whole * (1 + warm * (float)(1 - c)), 0.9f);
        m->rough_x = mixed(r->rough[0], r->rough[1], rough);
        m->rough_y = fminf(m->rough_x * r->stretch, 1);
        m->mirror = r->mirror;
    }
}

static void make_normals(pv_relief *relief)
{
    int32_t n = relief->side;
    const float *h = relief->height;
    for (int32_t y = 0; y < n; y++)
        for (int32_t x = 0; x < n; x++) {
            float dx = h[y * n + (x + 1) % n] - h[y * n + (x + n - 1) % n];
            float dy = h[(y + 1) % n * n + x] - h[(y + n - 1) % n * n + x];
            float step = 2 * relief->spacing, length = sqrtf(dx * dx + dy * dy + step * step);
            float *normal = relief->normal[(int64_t)y * n + x];
            normal[0] = -dx / length, normal[1] = -dy / length, normal[2] = step / length;
        }
}

typedef struct relief_work {
    const pave_btf_synthesis_params *params;
    pv_relief *relief;
    uint32_t key;
} relief_work;

static void make_row(const relief_work *work, int32_t y)
{
    pv_relief *relief = work->relief;
    const recipe *r = &recipes[work->params->class_of];
    int32_t n = relief->side;
    float scale = r->depth * (float)relief->texels * (float)work->params->relief;
    for (int32_t x = 0; x < n; x++) {
        float u = ((float)x + 0.5f) / (float)n, v = ((float)y + 0.5f) / (float)n;
        point p = make_point(work->params->class_of, work->key, u, v);
        int64_t i = (int64_t)y * n + x;
        float dust = 0.5f + 0.7f * fractal(work->key + 60, u, v, 3, 4, 0.6f);
        relief->height[i] = scale * p.height;
        relief->label[i] = (uint8_t)(p.label % r->materials);
        relief->dirt[i] = r->dirt * (dust < 0 ? 0 : dust > 1 ? 1 : dust);
    }
}

static pave_result allocate(pave_context *context, pv_relief *relief)
{
    pave_result result = PAVE_OK;
    size_t points = (size_t)relief->side * (size_t)relief->side;
    relief->height = pv_allocate(context, points, sizeof *relief->height, &result);
    if (!result)
        relief->dirt = pv_allocate(context, points, sizeof *relief->dirt, &result);
    if (!result)
        relief->label = pv_allocate(context, points, 1, &result);
    if (!result)
        relief->normal = pv_allocate(context, points, sizeof *relief->normal, &result);
    return result;
}

/* Heights about their mean, so that the plane of the texels lies in the middle of the relief. */
static void level(pv_relief *relief)
{
    int64_t points = (int64_t)relief->side * relief->side;
    double sum = 0;
    for (int64_t i = 0; i < points; i++)
        sum += relief->height[i];
    float mean = (float)(sum / (double)points);
    relief->lowest = INFINITY, relief->highest = -INFINITY;
    for (int64_t i = 0; i < points; i++) {
        float h = relief->height[i] -= mean;
        relief->lowest = fminf(relief->lowest, h);
        relief->highest = fmaxf(relief->highest, h);
    }
}

pave_result pv_relief_create(pave_context *context, const pave_btf_synthesis_params *params, pv_relief *out)
{
    memset(out, 0, sizeof *out);
    out->texels = params->texels;
    out->side = 2 * params->texels;
    out->spacing = 0.5f;
    pave_result result = allocate(context, out);
    relief_work work = { params, out, pv_draw(params->seed, PV_DRAW_RELIEF, 0, 0, 0).word[0] };
    for (int32_t y = 0; y < out->side && !result; y++) {
        make_row(&work, y);
        result = pv_progress(context, 0.05 * y / out->side);
    }
    if (result)
        return result;
    level(out);
    make_normals(out);
    make_materials(&recipes[params->class_of], params->seed, out);
    return PAVE_OK;
}

void pv_relief_free(pv_relief *relief)
{
    pv_release(relief->height);
    pv_release(relief->dirt);
    pv_release(relief->label);
    pv_release(relief->normal);
    memset(relief, 0, sizeof *relief);
}

float pv_relief_height(const pv_relief *relief, float x, float y)
{
    int32_t n = relief->side, ix = (int32_t)floorf(x), iy = (int32_t)floorf(y);
    float fx = x - (float)ix, fy = y - (float)iy;
    int32_t x0 = wrapped(ix, n), y0 = wrapped(iy, n), x1 = x0 + 1 == n ? 0 : x0 + 1, y1 = y0 + 1 == n ? 0 : y0 + 1;
    const float *h = relief->height;
    float a = h[(int64_t)y0 * n + x0], b = h[(int64_t)y0 * n + x1];
    float c = h[(int64_t)y1 * n + x0], d = h[(int64_t)y1 * n + x1];
    a += (b - a) * fx;
    c += (d - c) * fx;
    return a + (c - a) * fy;
}

int pv_relief_hit(const pv_relief *relief, const float from[3], const float direction[3], float place[2])
{
    float across = sqrtf(direction[0] * direction[0] + direction[1] * direction[1]);
    float drop = fabsf(direction[2]), range = relief->highest - relief->lowest;
    float step = across > 0.5f * drop ? 0.7f / across : range > 0 ? fminf(0.05f * range, 0.5f) / drop : 1 / drop;
    float before = from[2] - pv_relief_height(relief, from[0], from[1]), at = 0;
    for (int32_t i = 0; i < 100000; i++) {
        float next = at + step, z = from[2] + next * direction[2];
        float x = from[0] + next * direction[0], y = from[1] + next * direction[1];
        float above = z - pv_relief_height(relief, x, y);
        if (above <= 0) {
            float share = before > above ? before / (before - above) : 0;
            at += step * (share > 0 ? share : 0);
            place[0] = from[0] + at * direction[0];
            place[1] = from[1] + at * direction[1];
            return 1;
        }
        if (z > relief->highest)
            return 0;
        before = above;
        at = next;
    }
    return 0;
}
