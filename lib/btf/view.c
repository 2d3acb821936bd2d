/* Looking at a BTF: on a plane, a cylinder or a sphere, under one lamp or an environment. */
#include "btf/btf.h"

#include "base/parallel.h"
#include "btf/view_device.h"
#include "btf/sky.h"
#include "image/image.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum { BATCH = 1 << 20 }; /* terms that a device gets at a time */

static const pave_btf_view_params default_params = PAVE_BTF_VIEW_PARAMS_INIT;

static const pv_param view_rows[] = {
    PV_CHOICE(pave_btf_view_params, shape, "plane|cylinder|sphere", "what the material covers"),
    PV_INTEGER(pave_btf_view_params, side, "px", 1, 16384, "width and height of the picture"),
    PV_REAL(pave_btf_view_params, light_theta, "degrees", 0, 180, "inclination of the lamp from the viewer's axis z"),
    PV_REAL(pave_btf_view_params, light_phi, "degrees", -360, 360, "azimuth of the lamp"),
    PV_REAL(pave_btf_view_params, view_theta, "degrees", 0, 89, "inclination of the camera from z"),
    PV_REAL(pave_btf_view_params, view_phi, "degrees", -360, 360, "azimuth of the camera"),
    PV_REAL(pave_btf_view_params, repeats, "", 0.01, 1000, "times that the texture goes across the shape"),
    PV_REAL(pave_btf_view_params, exposure, "stops", -20, 20, "brightness, in powers of two"),
    PV_INTEGER(pave_btf_view_params, samples, "", 1, 16, "for each side of a pixel"),
};

const pv_table pv_btf_view_table = PV_TABLE("BTF view", default_params, view_rows);

void pave_btf_view_params_init(pave_btf_view_params *params, size_t size)
{
    pv_params_init(&pv_btf_view_table, params, size);
}

typedef struct camera {
    double right[3], up[3], toward[3];
} camera;

typedef struct scene {
    const pave_btf *btf;
    pave_btf_view_params params;
    camera camera;
    double lamp[3];
    const pv_sky *sky; /* NULL: the lamp alone */
    double gain;
    float *pixels;
} scene;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static pave_direction degrees(double theta, double phi)
{
    return (pave_direction){ (float)(theta * pi / 180), (float)(phi * pi / 180) };
}

/* The picture's axes, turned from x and y by the shortest way that brings z to the camera. */
static void aim(pave_direction view, camera *out)
{
    double c = cos((double)view.theta), s = sin((double)view.theta);
    double x = cos((double)view.phi), y = sin((double)view.phi);
    camera turned = { { c * x * x + y * y, (c - 1) * x * y, -s * x }, { (c - 1) * x * y, c * y * y + x * x, -s * y },
                      { 0, 0, 1 } };
    *out = turned;
    pv_direction_vector(view, out->toward);
}

/* A place on the shape: its frame, and where it lies on the texture, 0..1 for one repeat. */
typedef struct spot {
    double tangent[3], across[3], normal[3], u, v;
} spot;

static int hit_plane(const scene *s, double x, double y, spot *out)
{
    static const spot flat = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, 0, 0 };
    const camera *c = &s->camera;
    *out = flat;
    /* Along the line of sight to z = 0. */
    double z = x * c->right[2] + y * c->up[2], t = -z / c->toward[2];
    double px = x * c->right[0] + y * c->up[0] + t * c->toward[0];
    double py = x * c->right[1] + y * c->up[1] + t * c->toward[1];
    out->u = (px + 1) / 2;
    out->v = (1 - py) / 2;
    return fabs(px) <= 1 && fabs(py) <= 1;
}

/* About the axis y; a sphere also narrows towards its poles. */
static int hit_round(const scene *s, double x, double y, int sphere, spot *out)
{
    const camera *c = &s->camera;
    double o[3], d[3], a = 0, b = 0, k = -1;
    for (int i = 0; i < 3; i++) {
        o[i] = x * c->right[i] + y * c->up[i] + 4 * c->toward[i];
        d[i] = -c->toward[i];
        double part = i == 1 && !sphere ? 0 : 1;
        a += part * d[i] * d[i];
        b += part * o[i] * d[i];
        k += part * o[i] * o[i];
    }
    double root = b * b - a * k;
    if (root < 0 || a < 1e-9)
        return 0;
    double t = (-b - sqrt(root)) / a, p[3] = { o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2] };
    if (!sphere && fabs(p[1]) > 1)
        return 0;
    double ring = sqrt(p[0] * p[0] + p[2] * p[2]);
    *out = (spot){ { ring > 0 ? p[2] / ring : 1, 0, ring > 0 ? -p[0] / ring : 0 }, { 0, 0, 0 },
                   { p[0], sphere ? p[1] : 0, p[2] }, 0, 0 };
    cross(out->normal, out->tangent, out->across);
    out->u = atan2(p[0], p[2]) / pi + 0.5;
    out->v = sphere ? acos(fmin(fmax(p[1], -1), 1)) / pi : (1 - p[1]) / 2;
    return 1;
}

static int hit_shape(const scene *s, double x, double y, spot *out)
{
    int32_t shape = s->params.shape;
    return shape == PAVE_BTF_ON_PLANE ? hit_plane(s, x, y, out) : hit_round(s, x, y, shape == PAVE_BTF_ON_SPHERE, out);
}

static pave_direction local(const spot *p, const double v[3])
{
    double in[3] = { dot(v, p->tangent), dot(v, p->across), dot(v, p->normal) };
    return pv_vector_direction(in);
}

/* Where samples of the BTF go that a pixel is made of, each with what its channels count: into its sum, or to the
 * terms that a device adds up. */
typedef struct receiver {
    const pave_btf *btf;
    double sum[PV_BTF_CHANNELS];
    pv_term *terms; /* NULL: the sum */
    int32_t count;
} receiver;

static void receive(receiver *r, int64_t texel, int64_t pair, const double *weight)
{
    float values[PV_BTF_CHANNELS];
    if (r->terms) {
        pv_term *term = &r->terms[r->count++];
        *term = (pv_term){ (int32_t)texel, (int32_t)pair, { 0 } };
        for (int32_t c = 0; c < r->btf->channels; c++)
            term->weight[c] = (float)weight[c];
        return;
    }
    pv_btf_sample(r->btf, texel, pair, values);
    for (int32_t c = 0; c < r->btf->channels; c++)
        r->sum[c] += weight[c] * values[c];
}

static void add_sky(const scene *s, const spot *p, pave_direction view, int64_t texel, receiver *to)
{
    const pave_btf *btf = s->btf;
    int32_t views[3];
    double of_view[3];
    pv_directions_weigh(&btf->views, view, views, of_view);
    for (int32_t l = 0; l < btf->lights.count; l++) {
        double in[3], out[3];
        pv_direction_vector(btf->lights.direction[l], in);
        for (int i = 0; i < 3; i++)
            out[i] = in[0] * p->tangent[i] + in[1] * p->across[i] + in[2] * p->normal[i];
        double radiance[PV_BTF_CHANNELS], weight[PV_BTF_CHANNELS];
        pv_sky_look(s->sky, out, radiance);
        for (int32_t k = 0; k < 3; k++) {
            double w = of_view[k] * s->sky->share[l] * (btf->cosine ? 1 : in[2]);
            if (w == 0)
                continue;
            for (int32_t c = 0; c < btf->channels; c++)
                weight[c] = w * radiance[c];
            receive(to, texel, (int64_t)views[k] * btf->lights.count + l, weight);
        }
    }
}

static int64_t texel_at(const pave_btf *btf, int64_t x, int64_t y)
{
    x %= btf->width;
    y %= btf->height;
    return (y < 0 ? y + btf->height : y) * btf->width + (x < 0 ? x + btf->width : x);
}

static void add_lamp(const pave_btf *btf, const pv_mix *mix, double share, int64_t texel, receiver *to)
{
    double weight[PV_BTF_CHANNELS];
    for (int32_t i = 0; i < 9; i++) {
        if (mix->weight[i] == 0)
            continue;
        for (int32_t c = 0; c < btf->channels; c++)
            weight[c] = share * mix->weight[i];
        receive(to, texel, mix->pair[i], weight);
    }
}

/* The four texels about a spot. A sky is mixed at the nearest one only: it costs fifty times as much. */
static void shade(const scene *s, const spot *p, receiver *to)
{
    const pave_btf *btf = s->btf;
    pave_direction view = local(p, s->camera.toward), light = local(p, s->lamp);
    double x = p->u * s->params.repeats * btf->width - 0.5, y = p->v * s->params.repeats * btf->height - 0.5;
    int64_t ix = (int64_t)floor(x), iy = (int64_t)floor(y);
    double fx = x - (double)ix, fy = y - (double)iy;
    pv_mix mix;
    if (view.theta >= pi / 2 || (!s->sky && light.theta >= pi / 2))
        return;
    if (s->sky) {
        add_sky(s, p, view, texel_at(btf, ix + (fx >= 0.5), iy + (fy >= 0.5)), to);
        return;
    }
    pv_btf_mix(btf, view, light, &mix);
    for (int32_t k = 0; k < 4; k++) {
        double share = (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy) * (btf->cosine ? 1 : cos((double)light.theta));
        add_lamp(btf, &mix, share, texel_at(btf, ix + k % 2, iy + k / 2), to);
    }
}

/* Shades all samples of a pixel; tells how many lie on the shape. */
static int32_t cover(const scene *s, int32_t px, int32_t py, receiver *to)
{
    int32_t side = s->params.side, samples = s->params.samples, covered = 0;
    for (int32_t k = 0; k < samples * samples; k++) {
        double x = 1.05 * (2 * (px + (k % samples + 0.5) / samples) / side - 1);
        double y = 1.05 * (1 - 2 * (py + (k / samples + 0.5) / samples) / side);
        spot p;
        if (!hit_shape(s, x, y, &p))
            continue;
        covered++;
        shade(s, &p, to);
    }
    return covered;
}

static void set_pixel(const scene *s, int64_t pixel, int32_t covered, const double *sum)
{
    int32_t channels = s->btf->channels, samples = s->params.samples;
    float *out = s->pixels + pixel * (channels + 1);
    for (int32_t c = 0; c < channels; c++)
        out[c] = covered ? (float)(sum[c] * s->gain / covered) : 0;
    out[channels] = (float)covered / (float)(samples * samples);
}

static void draw_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const scene *s = data;
    for (int32_t x = 0; x < s->params.side; x++) {
        receiver to = { .btf = s->btf };
        int32_t covered = cover(s, x, y, &to);
        set_pixel(s, (int64_t)y * s->params.side + x, covered, to.sum);
    }
}

/* Pixels that a device draws at a time. */
typedef struct batch {
    const scene *scene;
    int64_t first;
    int32_t pixels, most; /* terms of a pixel */
    pv_term *terms;
    int32_t *counts, *covered;
    float *sums;
} batch;

static void list_pixel(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    const batch *b = data;
    int64_t pixel = b->first + index, side = b->scene->params.side;
    receiver to = { .btf = b->scene->btf, .terms = b->terms + (int64_t)index * b->most };
    b->covered[index] = cover(b->scene, (int32_t)(pixel % side), (int32_t)(pixel / side), &to);
    b->counts[index] = to.count;
}

static pave_result draw_batch(pave_context *context, pv_blender *blender, const batch *b, int32_t count)
{
    int64_t all = (int64_t)b->scene->params.side * b->scene->params.side;
    double from = (double)b->first / (double)all, to = (double)(b->first + count) / (double)all;
    pave_result result = pv_parallel(context, count, list_pixel, (void *)(uintptr_t)b, from, to);
    if (!result)
        result = pv_blender_run(blender, b->terms, b->counts, count, b->sums);
    for (int32_t i = 0; i < count && !result; i++) {
        const float *from_device = b->sums + PV_BLEND_CHANNELS * (int64_t)i;
        double sum[PV_BLEND_CHANNELS] = { from_device[0], from_device[1], from_device[2] };
        set_pixel(b->scene, b->first + i, b->covered[i], sum);
    }
    return result;
}

static pave_result make_batch(pave_context *context, const scene *s, batch *b)
{
    pave_result result = PAVE_OK;
    int64_t samples = (int64_t)s->params.samples * s->params.samples, all = (int64_t)s->params.side * s->params.side;
    int64_t most = samples * (s->sky ? 3 * (int64_t)s->btf->lights.count : 4 * 9);
    int64_t pixels = BATCH / most < 1 ? 1 : BATCH / most < all ? BATCH / most : all;
    *b = (batch){ .scene = s, .pixels = (int32_t)pixels, .most = (int32_t)most };
    b->terms = pv_allocate(context, (size_t)pixels * (size_t)most, sizeof *b->terms, &result);
    if (!result)
        b->counts = pv_allocate(context, (size_t)pixels, sizeof *b->counts, &result);
    if (!result)
        b->covered = pv_allocate(context, (size_t)pixels, sizeof *b->covered, &result);
    if (!result)
        b->sums = pv_allocate(context, (size_t)pixels, PV_BLEND_CHANNELS * sizeof *b->sums, &result);
    return result;
}

static pave_result draw_on_device(pave_context *context, const scene *s)
{
    batch b;
    pv_blender *blender = NULL;
    int64_t all = (int64_t)s->params.side * s->params.side;
    pave_result result = make_batch(context, s, &b);
    if (!result)
        result = pv_blender_open(context, s->btf, b.pixels, b.most, &blender);
    for (; b.first < all && !result; b.first += b.pixels)
        result = draw_batch(context, blender, &b, (int32_t)(all - b.first < b.pixels ? all - b.first : b.pixels));
    pv_blender_close(blender);
    pv_release(b.terms);
    pv_release(b.counts);
    pv_release(b.covered);
    pv_release(b.sums);
    return result;
}

static pave_result draw(pave_context *context, const scene *s)
{
    int vulkan = context->backend == PAVE_BACKEND_VULKAN_COMPUTE || context->backend == PAVE_BACKEND_VULKAN_RASTER;
    return vulkan ? draw_on_device(context, s)
                  : pv_parallel(context, s->params.side, draw_row, (void *)(uintptr_t)s, 0, 1);
}

pave_result pave_btf_view(pave_context *context, const pave_btf *btf, const pave_image *environment,
                          const pave_btf_view_params *given, pave_image **out)
{
    scene s = { .btf = btf };
    pv_sky around = { NULL, NULL, 0 };
    if (out)
        *out = NULL;
    if (!context || !btf || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_btf_view_table, given, &s.params);
    if (!result && environment)
        result = pv_sky_open(context, btf, environment, &around);
    if (!result)
        result = pv_btf_picture(context, btf, s.params.side, s.params.side, 1, out);
    if (!result) {
        pv_call call = pv_call_begin(context, "view", 0, 1);
        aim(degrees(s.params.view_theta, s.params.view_phi), &s.camera);
        pv_direction_vector(degrees(s.params.light_theta, s.params.light_phi), s.lamp);
        s.sky = environment ? &around : NULL;
        s.gain = pi * exp2(s.params.exposure);
        s.pixels = (*out)->pixels;
        result = draw(context, &s);
        pv_call_end(context, call);
    }
    pv_sky_close(&around);
    if (result)
        pave_image_free(out);
    return result;
}
