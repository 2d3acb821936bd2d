/* Light on a relief: shadows, bounces between its parts, and what a texel sends to each view. */
#include "btf/scene.h"

#include "base/parallel.h"
#include "util/fixed.h"
#include "util/half.h"
#include "util/random.h"

#include <math.h>
#include <string.h>

enum { LIGHTS_AT_ONCE = 16 };

static const float pi = 3.14159265f;

static int64_t points_of(const pv_scene *scene)
{
    return (int64_t)scene->relief.side * scene->relief.side;
}

/* The greatest height, over all places towards the light, of a ray to the light that just passes there. */
static float shade_height(const pv_relief *relief, float x, float y, const float light[3])
{
    float across = sqrtf(light[0] * light[0] + light[1] * light[1]);
    if (across < 1e-4f)
        return -INFINITY;
    float dx = light[0] / across, dy = light[1] / across, rise = light[2] / across * relief->spacing, most = -INFINITY;
    for (int32_t t = 1; t < 65536; t++) {
        float risen = (float)t * rise;
        if (relief->highest - risen <= most || relief->highest - risen < relief->lowest)
            break;
        most = fmaxf(most, pv_relief_height(relief, x + (float)t * dx, y + (float)t * dy) - risen);
    }
    return most;
}

static void shade_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    pv_scene *scene = data;
    int32_t n = scene->relief.side;
    for (int32_t x = 0; x < n; x++)
        for (int32_t l = 0; l < scene->directions; l++)
            scene->shade[((int64_t)y * n + x) * scene->directions + l] =
                scene->params.shadows ? shade_height(&scene->relief, (float)x, (float)y, scene->toward[l]) : -INFINITY;
}

/* 1 in the light, 0 in shadow, between within a quarter of a texel: lamps are no points. */
static float lit(float height, float shade)
{
    float v = 0.5f - (shade - height) * 10;
    return v < 0 ? 0 : v > 1 ? 1 : v;
}

/* An orthonormal frame about a normal (Duff et al. 2017). */
static void frame(const float n[3], float t[3], float b[3])
{
    float sign = n[2] < 0 ? -1.0f : 1.0f, a = -1 / (sign + n[2]), c = n[0] * n[1] * a;
    t[0] = 1 + sign * n[0] * n[0] * a, t[1] = sign * c, t[2] = -sign * n[0];
    b[0] = c, b[1] = sign + n[1] * n[1] * a, b[2] = -n[1];
}

void pv_scene_sight(const pv_scene *scene, int32_t point, int32_t *seen)
{
    const pv_relief *relief = &scene->relief;
    int32_t n = relief->side, rays = scene->params.rays, cosine, sine;
    const float *normal = relief->normal[point];
    float t[3], b[3], at[3] = { (float)(point % n), (float)(point / n), relief->height[point] + 1e-3f };
    frame(normal, t, b);
    pv_random r = pv_draw(scene->params.seed, PV_DRAW_RAY, (uint32_t)point, 0, 0);
    for (int32_t k = 0; k < rays; k++) {
        /* A rotated golden spiral on the disc below the hemisphere. */
        float share = ((float)k + (float)r.word[1] * 0x1p-32f) / (float)rays, radius = sqrtf(share), place[2];
        pv_turn((int32_t)(((uint64_t)k * 40503 + r.word[0]) & 65535), &cosine, &sine);
        float u = radius * (float)cosine * 0x1p-16f, v = radius * (float)sine * 0x1p-16f, w = sqrtf(1 - share);
        float d[3];
        for (int32_t i = 0; i < 3; i++)
            d[i] = u * t[i] + v * b[i] + w * normal[i];
        float step[3] = { d[0] / relief->spacing, d[1] / relief->spacing, d[2] };
        seen[k] = -1;
        if (pv_relief_hit(relief, at, step, place)) {
            int32_t x = (int32_t)floorf(place[0] + 0.5f) % n, y = (int32_t)floorf(place[1] + 0.5f) % n;
            seen[k] = (y < 0 ? y + n : y) * n + (x < 0 ? x + n : x);
        }
    }
}

/* Light that bounces, for some lights at a time. */
typedef struct bouncing {
    pv_scene *scene;
    int32_t *seen;              /* [point][ray] */
    float *sent, *next;         /* [point][light of these][3]: exitance */
    int32_t first, lights, last; /* is it the last bounce? */
} bouncing;

static void sight_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    bouncing *b = data;
    int32_t n = b->scene->relief.side;
    for (int32_t x = 0; x < n; x++)
        pv_scene_sight(b->scene, y * n + x, b->seen + ((int64_t)y * n + x) * b->scene->params.rays);
}

static float diffuse_at(const pv_relief *relief, int64_t point, int32_t channel)
{
    float d = relief->materials[relief->label[point]].diffuse[channel];
    return d + (0.45f - d) * 0.5f * relief->dirt[point];
}

static float direct(const pv_scene *scene, int64_t point, int32_t light)
{
    const float *normal = scene->relief.normal[point], *l = scene->toward[light];
    float cosine = normal[0] * l[0] + normal[1] * l[1] + normal[2] * l[2];
    return fmaxf(cosine, 0) * lit(scene->relief.height[point], scene->shade[point * scene->directions + light]);
}

static void send_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    bouncing *b = data;
    int32_t n = b->scene->relief.side;
    for (int64_t point = (int64_t)y * n; point < (int64_t)(y + 1) * n; point++)
        for (int32_t l = 0; l < b->lights; l++)
            for (int32_t c = 0; c < 3; c++)
                b->sent[(point * LIGHTS_AT_ONCE + l) * 3 + c] =
                    diffuse_at(&b->scene->relief, point, c) * direct(b->scene, point, b->first + l);
}

static void gather(const bouncing *b, int64_t point, float sum[LIGHTS_AT_ONCE * 3])
{
    int32_t rays = b->scene->params.rays;
    memset(sum, 0, LIGHTS_AT_ONCE * 3 * sizeof *sum);
    for (int32_t k = 0; k < rays; k++) {
        int32_t q = b->seen[point * rays + k];
        const float *from = b->sent + (int64_t)q * LIGHTS_AT_ONCE * 3;
        for (int32_t i = 0; i < LIGHTS_AT_ONCE * 3 && q >= 0; i++)
            sum[i] += from[i];
    }
    for (int32_t i = 0; i < LIGHTS_AT_ONCE * 3; i++)
        sum[i] /= (float)rays;
}

static void bounce_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    bouncing *b = data;
    pv_scene *scene = b->scene;
    int32_t n = scene->relief.side;
    for (int64_t point = (int64_t)y * n; point < (int64_t)(y + 1) * n; point++) {
        float sum[LIGHTS_AT_ONCE * 3];
        gather(b, point, sum);
        for (int32_t i = 0; i < b->lights * 3; i++) {
            int32_t light = b->first + i / 3;
            if (b->last)
                scene->bounced[(point * scene->directions + light) * 3 + i % 3] = pv_half(sum[i]);
            else
                b->next[point * LIGHTS_AT_ONCE * 3 + i] = diffuse_at(&scene->relief, point, i % 3) *
                                                          (direct(scene, point, light) + sum[i]);
        }
    }
}

static pave_result bounce_lights(pave_context *context, bouncing *b, double from, double to)
{
    int32_t n = b->scene->relief.side, bounces = b->scene->params.bounces;
    double share = (to - from) / (bounces + 1);
    pave_result result = pv_parallel(context, n, send_row, b, from, from + share);
    for (int32_t i = 0; i < bounces && !result; i++) {
        b->last = i + 1 == bounces;
        result = pv_parallel(context, n, bounce_row, b, from + (i + 1) * share, from + (i + 2) * share);
        float *swap = b->sent;
        b->sent = b->next;
        b->next = swap;
    }
    return result;
}

static pave_result bounce(pave_context *context, pv_scene *scene, double from, double to)
{
    size_t points = (size_t)points_of(scene), each = LIGHTS_AT_ONCE * 3 * sizeof(float);
    pave_result result = PAVE_OK;
    bouncing b = { .scene = scene };
    scene->bounced = pv_allocate(context, points, (size_t)scene->directions * 3 * sizeof *scene->bounced, &result);
    if (!result)
        b.seen = pv_allocate(context, points, (size_t)scene->params.rays * sizeof *b.seen, &result);
    if (!result)
        b.sent = pv_allocate_zeroed(context, points, each, &result);
    if (!result)
        b.next = pv_allocate_zeroed(context, points, each, &result);
    double middle = from + 0.3 * (to - from);
    if (!result)
        result = pv_parallel(context, scene->relief.side, sight_row, &b, from, middle);
    for (b.first = 0; b.first < scene->directions && !result; b.first += LIGHTS_AT_ONCE) {
        int32_t left = scene->directions - b.first;
        b.lights = left < LIGHTS_AT_ONCE ? left : LIGHTS_AT_ONCE;
        result = bounce_lights(context, &b, middle + (to - middle) * b.first / scene->directions,
                               middle + (to - middle) * (b.first + b.lights) / scene->directions);
    }
    pv_release(b.seen);
    pv_release(b.sent);
    pv_release(b.next);
    return result;
}

static pave_result set_directions(pave_context *context, const pave_direction *directions, int32_t count,
                                  pv_scene *scene)
{
    pave_result result = PAVE_OK;
    scene->directions = count;
    scene->toward = pv_allocate(context, (size_t)count, sizeof *scene->toward, &result);
    for (int32_t i = 0; i < count && !result; i++) {
        double v[3];
        pv_direction_vector(directions[i], v);
        scene->toward[i][0] = (float)v[0], scene->toward[i][1] = (float)-v[1], scene->toward[i][2] = (float)v[2];
    }
    return result;
}

pave_result pv_scene_create(pave_context *context, const pave_btf_synthesis_params *params,
                            const pave_direction *directions, int32_t count, double share, pv_scene **out)
{
    pave_result result = PAVE_OK;
    if (count > PV_MOST_LIGHTS)
        return pv_fail(context, PAVE_ERR_LIMIT, "%d directions: a scene has at most %d", (int)count, PV_MOST_LIGHTS);
    pv_scene *scene = *out = pv_allocate_zeroed(context, 1, sizeof *scene, &result);
    if (result)
        return result;
    scene->params = *params;
    result = set_directions(context, directions, count, scene);
    if (!result)
        result = pv_relief_create(context, params, &scene->relief);
    if (!result)
        scene->shade = pv_allocate(context, (size_t)points_of(scene), (size_t)count * sizeof *scene->shade, &result);
    if (!result)
        result = pv_parallel(context, scene->relief.side, shade_row, scene, 0.05 * share, 0.3 * share);
    if (!result && params->bounces && scene->relief.highest > scene->relief.lowest)
        result = bounce(context, scene, 0.3 * share, share);
    if (result)
        pv_scene_free(out);
    return result;
}

void pv_scene_free(pv_scene **scene)
{
    if (!*scene)
        return;
    pv_relief_free(&(*scene)->relief);
    pv_release((*scene)->toward);
    pv_release((*scene)->shade);
    pv_release((*scene)->bounced);
    pv_release(*scene);
    *scene = NULL;
}

/* A place that a view sees: what it is made of, and how it lies. */
typedef struct place {
    float normal[3], tangent[3], across[3]; /* the normal of the surface itself: only then is light conserved */
    float diffuse[3], rough_x, rough_y, mirror;
    int64_t corner[4]; /* grid points around it, */
    float share[4];    /* and their weights */
} place;

static void settle(const pv_relief *relief, const float at[2], place *p)
{
    int32_t n = relief->side, ix = (int32_t)floorf(at[0]), iy = (int32_t)floorf(at[1]);
    float fx = at[0] - (float)ix, fy = at[1] - (float)iy, h[4];
    for (int32_t k = 0; k < 4; k++) {
        int32_t x = (ix + k % 2) % n, y = (iy + k / 2) % n;
        p->corner[k] = (int64_t)(y < 0 ? y + n : y) * n + (x < 0 ? x + n : x);
        p->share[k] = (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy);
        h[k] = relief->height[p->corner[k]];
    }
    float dx = (h[1] - h[0]) * (1 - fy) + (h[3] - h[2]) * fy, dy = (h[2] - h[0]) * (1 - fx) + (h[3] - h[1]) * fx;
    float up = relief->spacing, length = sqrtf(dx * dx + dy * dy + up * up);
    p->normal[0] = -dx / length, p->normal[1] = -dy / length, p->normal[2] = up / length;
    /* The tangent follows the grid's x, along which brushes go. */
    float along = sqrtf(p->normal[2] * p->normal[2] + p->normal[0] * p->normal[0]);
    p->tangent[0] = p->normal[2] / along, p->tangent[1] = 0, p->tangent[2] = -p->normal[0] / along;
    p->across[0] = p->normal[1] * p->tangent[2] - p->normal[2] * p->tangent[1];
    p->across[1] = p->normal[2] * p->tangent[0] - p->normal[0] * p->tangent[2];
    p->across[2] = p->normal[0] * p->tangent[1] - p->normal[1] * p->tangent[0];
}

static void furnish(const pv_relief *relief, const float at[2], place *p)
{
    int32_t near = (at[0] - floorf(at[0]) >= 0.5f) + 2 * (at[1] - floorf(at[1]) >= 0.5f);
    int64_t point = p->corner[near];
    const pv_material *m = &relief->materials[relief->label[point]];
    float dirt = relief->dirt[point];
    for (int32_t c = 0; c < 3; c++)
        p->diffuse[c] = diffuse_at(relief, point, c);
    p->rough_x = m->rough_x + (0.7f - m->rough_x) * 0.5f * dirt;
    p->rough_y = m->rough_y + (0.7f - m->rough_y) * 0.5f * dirt;
    p->mirror = m->mirror * (1 - 0.5f * dirt);
}

/* The place that a view sees through a point of the texels' plane, coordinates in grid units. */
static void look(const pv_scene *scene, float x, float y, const float view[3], place *p)
{
    const pv_relief *relief = &scene->relief;
    float per = 1 / (view[2] * relief->spacing), up = relief->highest + 1e-3f, at[2] = { x, y };
    float from[3] = { x + view[0] * per * up, y + view[1] * per * up, up };
    float along[3] = { -view[0] / relief->spacing, -view[1] / relief->spacing, -view[2] };
    if (relief->highest > relief->lowest)
        pv_relief_hit(relief, from, along, at);
    settle(relief, at, p);
    furnish(relief, at, p);
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Direct light of every direction that reaches the place: the cosine to its normal, 0 in shadow. */
static void reach(const pv_scene *scene, const place *p, float *cosine)
{
    int32_t n = scene->directions;
    const float *shade[4];
    for (int32_t k = 0; k < 4; k++)
        shade[k] = scene->shade + p->corner[k] * n;
    const float *h = scene->relief.height;
    for (int32_t l = 0; l < n; l++) {
        float light = 0;
        for (int32_t k = 0; k < 4; k++)
            light += p->share[k] * lit(h[p->corner[k]], shade[k][l]);
        cosine[l] = fmaxf(dot(p->normal, scene->toward[l]), 0) * light;
    }
}

/* GGX with separate roughness along and across the grain, height-correlated masking (Heitz 2014), Schlick's Fresnel. */
static void gloss(const pv_scene *scene, const place *p, const float view[3], const float *cosine, float *out)
{
    float vt = dot(view, p->tangent) * p->rough_x, vb = dot(view, p->across) * p->rough_y;
    float vn = fmaxf(dot(view, p->normal), 1e-3f), v_length = sqrtf(vt * vt + vb * vb + vn * vn);
    float scale = p->mirror / (2 * pi * p->rough_x * p->rough_y);
    for (int32_t l = 0; l < scene->directions; l++) {
        const float *light = scene->toward[l];
        float h[3] = { view[0] + light[0], view[1] + light[1], view[2] + light[2] };
        float inverse = 1 / sqrtf(dot(h, h)), vh = dot(view, h) * inverse;
        float ht = dot(h, p->tangent) * inverse / p->rough_x, hb = dot(h, p->across) * inverse / p->rough_y;
        float hn = dot(h, p->normal) * inverse, d = ht * ht + hb * hb + hn * hn;
        float lt = dot(light, p->tangent) * p->rough_x, lb = dot(light, p->across) * p->rough_y;
        float ln = fmaxf(dot(light, p->normal), 1e-3f), l_length = sqrtf(lt * lt + lb * lb + ln * ln);
        float away = 1 - vh, fresnel = 1 + (1 / p->mirror - 1) * (away * away) * (away * away) * away;
        out[l] = scale * fresnel / (d * d * (ln * v_length + vn * l_length)) * cosine[l];
    }
}

static void shine(const pv_scene *scene, const place *p, const float view[3], float weight, float *out)
{
    float cosine[PV_MOST_LIGHTS], mirrored[PV_MOST_LIGHTS];
    int32_t n = scene->directions;
    reach(scene, p, cosine);
    gloss(scene, p, view, cosine, mirrored);
    for (int32_t l = 0; l < n; l++)
        for (int32_t c = 0; c < 3; c++)
            out[3 * l + c] += weight * (p->diffuse[c] / pi * (1 - p->mirror) * cosine[l] + mirrored[l]);
    for (int32_t k = 0; k < 4 && scene->bounced; k++) {
        const uint16_t *from = scene->bounced + p->corner[k] * n * 3;
        for (int32_t i = 0; i < 3 * n; i++)
            out[i] += weight * p->share[k] * p->diffuse[i % 3] / pi * pv_half_value(from[i]);
    }
}

/* Where a sample of a texel of the window lies in its plane, in grid units. */
static void spread(const pv_scene *scene, int64_t texel, int32_t sample, float at[2])
{
    int32_t texels = scene->relief.texels;
    const int32_t *window = scene->params.window;
    if (window[2])
        texel = (texel / window[2] + window[1]) * texels + texel % window[2] + window[0];
    pv_random r = pv_draw(scene->params.seed, PV_DRAW_RAY, (uint32_t)texel, (uint32_t)sample, 1);
    float u = (float)r.word[0] * 0x1p-32f;
    float v = ((float)sample + (float)r.word[1] * 0x1p-32f) / (float)scene->params.samples;
    at[0] = ((float)(texel % texels) + u) / scene->relief.spacing - 0.5f;
    at[1] = ((float)(texel / texels) + v) / scene->relief.spacing - 0.5f;
}

void pv_scene_view(const pv_scene *scene, int64_t texel, int32_t view, float *out)
{
    int32_t samples = scene->params.samples;
    memset(out, 0, (size_t)scene->directions * 3 * sizeof *out);
    for (int32_t s = 0; s < samples; s++) {
        float at[2];
        place p;
        spread(scene, texel, s, at);
        look(scene, at[0], at[1], scene->toward[view], &p);
        shine(scene, &p, scene->toward[view], 1 / (float)samples, out);
    }
}

void pv_scene_texel(const pv_scene *scene, int64_t texel, float *out)
{
    for (int32_t view = 0; view < scene->directions; view++)
        pv_scene_view(scene, texel, view, out + (int64_t)view * scene->directions * 3);
}
