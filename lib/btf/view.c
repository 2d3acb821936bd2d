/* Looking at a BTF: on a plane, a cylinder or a sphere, under one lamp or an environment. */
#include "btf/btf.h"

#include "base/parallel.h"
#include "image/image.h"
#include "util/light.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum { SKY = 64 };

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

/* Light from all around, coarse: [SKY / 2][SKY][channel], the zenith (y) first. */
typedef struct sky {
    double *radiance;
    double *share; /* of the hemisphere that each light direction stands for, steradian */
} sky;

typedef struct camera {
    double right[3], up[3], toward[3];
} camera;

typedef struct scene {
    const pave_btf *btf;
    pave_btf_view_params params;
    camera camera;
    double lamp[3];
    const sky *sky; /* NULL: the lamp alone */
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

/* Between the middles of four cells, around the horizon and up to the poles. */
static void look_up(const sky *around, int32_t channels, const double d[3], double *out)
{
    double y = acos(fmin(fmax(d[1], -1), 1)) / pi * (SKY / 2) - 0.5;
    double x = (atan2(d[0], d[2]) / pi + 1) / 2 * SKY - 0.5, fx = x - floor(x), fy = y - floor(y);
    int32_t x0 = ((int32_t)floor(x) + SKY) % SKY, x1 = (x0 + 1) % SKY;
    int32_t y0 = y < 0 ? 0 : (int32_t)y, y1 = (int32_t)floor(y) + 1;
    y1 = y1 < SKY / 2 ? y1 : SKY / 2 - 1;
    const double *a = around->radiance + (int64_t)y0 * SKY * channels;
    const double *b = around->radiance + (int64_t)y1 * SKY * channels;
    for (int32_t c = 0; c < channels; c++) {
        double above = (1 - fx) * a[x0 * channels + c] + fx * a[x1 * channels + c];
        double below = (1 - fx) * b[x0 * channels + c] + fx * b[x1 * channels + c];
        out[c] = (1 - fy) * above + fy * below;
    }
}

static void add_sky(const scene *s, const spot *p, pave_direction view, int64_t texel, double *sum)
{
    const pave_btf *btf = s->btf;
    int32_t views[3];
    double of_view[3];
    pv_directions_weigh(&btf->views, view, views, of_view);
    float values[PV_BTF_CHANNELS];
    for (int32_t l = 0; l < btf->lights.count; l++) {
        double in[3], out[3];
        pv_direction_vector(btf->lights.direction[l], in);
        for (int i = 0; i < 3; i++)
            out[i] = in[0] * p->tangent[i] + in[1] * p->across[i] + in[2] * p->normal[i];
        double radiance[PV_BTF_CHANNELS];
        look_up(s->sky, btf->channels, out, radiance);
        for (int32_t k = 0; k < 3; k++) {
            double w = of_view[k] * s->sky->share[l] * (btf->cosine ? 1 : in[2]);
            if (w == 0)
                continue;
            pv_btf_sample(btf, texel, (int64_t)views[k] * btf->lights.count + l, values);
            for (int32_t c = 0; c < btf->channels; c++)
                sum[c] += w * values[c] * radiance[c];
        }
    }
}

static int64_t texel_at(const pave_btf *btf, int64_t x, int64_t y)
{
    x %= btf->width;
    y %= btf->height;
    return (y < 0 ? y + btf->height : y) * btf->width + (x < 0 ? x + btf->width : x);
}

/* The four texels about a spot. A sky is mixed at the nearest one only: it costs fifty times as much. */
static void shade(const scene *s, const spot *p, double *sum)
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
        add_sky(s, p, view, texel_at(btf, ix + (fx >= 0.5), iy + (fy >= 0.5)), sum);
        return;
    }
    pv_btf_mix(btf, view, light, &mix);
    for (int32_t k = 0; k < 4; k++) {
        double weight = (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy) * (btf->cosine ? 1 : cos((double)light.theta));
        pv_btf_add(btf, texel_at(btf, ix + k % 2, iy + k / 2), &mix, weight, sum);
    }
}

static void draw_pixel(const scene *s, int32_t px, int32_t py, float *out)
{
    int32_t side = s->params.side, samples = s->params.samples, channels = s->btf->channels;
    double sum[PV_BTF_CHANNELS] = { 0 };
    int32_t covered = 0;
    for (int32_t k = 0; k < samples * samples; k++) {
        double x = 1.05 * (2 * (px + (k % samples + 0.5) / samples) / side - 1);
        double y = 1.05 * (1 - 2 * (py + (k / samples + 0.5) / samples) / side);
        spot p;
        if (!hit_shape(s, x, y, &p))
            continue;
        covered++;
        shade(s, &p, sum);
    }
    for (int32_t c = 0; c < channels; c++)
        out[c] = covered ? (float)(sum[c] * s->gain / covered) : 0;
    out[channels] = (float)covered / (float)(samples * samples);
}

static void draw_row(void *data, int32_t y, int32_t worker)
{
    (void)worker;
    const scene *s = data;
    size_t each = (size_t)s->btf->channels + 1;
    for (int32_t x = 0; x < s->params.side; x++)
        draw_pixel(s, x, y, s->pixels + ((size_t)y * (size_t)s->params.side + (size_t)x) * each);
}

static double light_of(const pave_image *image, int32_t x, int32_t y, int32_t channel)
{
    double value = pv_image_value(image, ((int64_t)y * image->width + x) * image->channels + channel);
    return image->encoding == PAVE_DISPLAY ? pv_linear_light(value) : value;
}

/* The mean light of a cell of the sky, at least one pixel of it. */
static double mean_light(const pave_image *image, int32_t cell, int32_t channel)
{
    int32_t w = image->width, h = image->height, column = cell % SKY, row = cell / SKY;
    int32_t x0 = (int32_t)((int64_t)column * w / SKY), x1 = (int32_t)((int64_t)(column + 1) * w / SKY);
    int32_t y0 = (int32_t)((int64_t)row * h * 2 / SKY), y1 = (int32_t)((int64_t)(row + 1) * h * 2 / SKY);
    double sum = 0, count = 0;
    x1 = x1 > x0 ? x1 : x0 + 1;
    y1 = y1 > y0 ? y1 : y0 + 1;
    for (int32_t y = y0; y < y1; y++)
        for (int32_t x = x0; x < x1; x++, count++)
            sum += light_of(image, x, y, channel);
    return sum / count;
}

static pave_result open_sky(pave_context *context, const pave_btf *btf, const pave_image *image, sky *out)
{
    pave_result result = PAVE_OK;
    int32_t channels = btf->channels;
    out->radiance = pv_allocate(context, SKY * SKY / 2, (size_t)channels * sizeof *out->radiance, &result);
    if (!result)
        out->share = pv_allocate(context, (size_t)btf->lights.count, sizeof *out->share, &result);
    if (result)
        return result;
    for (int32_t i = 0; i < SKY * SKY / 2 * channels; i++) /* a grey sky lights all channels alike */
        out->radiance[i] = mean_light(image, i / channels, image->channels >= channels ? i % channels : 0);
    pv_directions_share(&btf->lights, out->share);
    return PAVE_OK;
}

pave_result pave_btf_view(pave_context *context, const pave_btf *btf, const pave_image *environment,
                          const pave_btf_view_params *given, pave_image **out)
{
    scene s = { .btf = btf };
    sky around = { NULL, NULL };
    if (out)
        *out = NULL;
    if (!context || !btf || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_btf_view_table, given, &s.params);
    if (!result && environment)
        result = open_sky(context, btf, environment, &around);
    if (!result)
        result = pv_btf_picture(context, btf, s.params.side, s.params.side, 1, out);
    if (!result) {
        pv_call call = pv_call_begin(context, "view", 0, 1);
        aim(degrees(s.params.view_theta, s.params.view_phi), &s.camera);
        pv_direction_vector(degrees(s.params.light_theta, s.params.light_phi), s.lamp);
        s.sky = environment ? &around : NULL;
        s.gain = pi * exp2(s.params.exposure);
        s.pixels = (*out)->pixels;
        result = pv_parallel(context, s.params.side, draw_row, &s, 0, 1);
        pv_call_end(context, call);
    }
    pv_release(around.radiance);
    pv_release(around.share);
    if (result)
        pave_image_free(out);
    return result;
}
