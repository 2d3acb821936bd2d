/* The BTF handle: made from samples, and looked at by texel, by texture and by direction. */
#include "btf/btf.h"

#include "btf/scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>

static const pave_btf_params default_params = PAVE_BTF_PARAMS_INIT;

void pave_btf_params_init(pave_btf_params *params, size_t size)
{
    const pv_table table = { "BTF", sizeof default_params, &default_params, NULL, 0 };
    pv_params_init(&table, params, size);
}

static pave_result check_shape(pave_context *context, const pave_btf_params *p)
{
    if (p->width < 1 || p->height < 1 || p->width > context->limits.max_side || p->height > context->limits.max_side)
        return pv_fail(context, PAVE_ERR_LIMIT, "a BTF of %d x %d texels: a side must be 1 .. %lld (max_side)",
                       (int)p->width, (int)p->height, (long long)context->limits.max_side);
    if (p->channels < 1 || p->channels > PV_BTF_CHANNELS)
        return pv_fail(context, PAVE_ERR_LIMIT, "a BTF of %d channels: 1 to %d can be", (int)p->channels,
                       PV_BTF_CHANNELS);
    if (p->type != PAVE_F16 && p->type != PAVE_F32)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the samples of a BTF are PAVE_F16 or PAVE_F32");
    if (!(p->pixels_per_mm >= 0) || isinf(p->pixels_per_mm))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pixels_per_mm is %g, but must be a number from 0",
                       p->pixels_per_mm);
    return PAVE_OK;
}

static pave_result name_channels(pave_context *context, const char *names, pave_btf *btf)
{
    for (int32_t c = 0; c < btf->channels; c++) {
        size_t length = names ? strcspn(names, ",") : 0;
        if (names && (!length || length >= PV_BTF_NAME))
            return pv_fail(context, PAVE_ERR_ARGUMENT, "channel %d has no name, or one of more than %d letters", (int)c,
                           PV_BTF_NAME - 1);
        if (names)
            snprintf(btf->names[c], PV_BTF_NAME, "%.*s", (int)length, names);
        else if (btf->channels == 3 || btf->channels == 1)
            snprintf(btf->names[c], PV_BTF_NAME, "%c", btf->channels == 1 ? 'Y' : "RGB"[c]);
        else
            snprintf(btf->names[c], PV_BTF_NAME, "%d", (int)c);
        names = names ? names + length + (names[length] == ',') : NULL;
    }
    return PAVE_OK;
}

pave_result pv_btf_new(pave_context *context, const pave_btf_params *params, pave_btf **out)
{
    pave_result result = check_shape(context, params);
    *out = result ? NULL : pv_allocate_zeroed(context, 1, sizeof **out, &result);
    pave_btf *btf = *out;
    if (result)
        return result;
    btf->width = params->width;
    btf->height = params->height;
    btf->channels = params->channels;
    btf->type = params->type;
    btf->cosine = params->cosine != 0;
    btf->pixels_per_mm = params->pixels_per_mm;
    btf->rgb_scale[0] = btf->rgb_scale[1] = btf->rgb_scale[2] = 1;
    result = name_channels(context, params->names, btf);
    if (!result)
        result = pv_directions_create(context, "view", params->view_directions, params->views, &btf->views);
    if (!result)
        result = pv_directions_create(context, "light", params->light_directions, params->lights, &btf->lights);
    if (result)
        pave_btf_free(out);
    return result;
}

pave_result pv_btf_copy_frame(pave_context *context, const pave_btf *btf, pave_btf **out)
{
    pave_btf_params params = PAVE_BTF_PARAMS_INIT;
    params.width = btf->width;
    params.height = btf->height;
    params.channels = btf->channels;
    params.type = btf->type;
    params.views = btf->views.count;
    params.lights = btf->lights.count;
    params.view_directions = btf->views.direction;
    params.light_directions = btf->lights.direction;
    params.cosine = btf->cosine;
    params.pixels_per_mm = btf->pixels_per_mm;
    pave_result result = pv_btf_new(context, &params, out);
    if (result)
        return result;
    pave_btf *copy = *out;
    memcpy(copy->names, btf->names, sizeof copy->names);
    memcpy(copy->setup, btf->setup, sizeof copy->setup);
    memcpy(copy->sensor, btf->sensor, sizeof copy->sensor);
    memcpy(copy->source, btf->source, sizeof copy->source);
    memcpy(copy->rgb_scale, btf->rgb_scale, sizeof copy->rgb_scale);
    size_t pairs = (size_t)btf->views.count * (size_t)btf->lights.count, notes = btf->notes ? strlen(btf->notes) : 0;
    if (btf->missing && (copy->missing = pv_allocate(context, pairs, 1, &result)))
        memcpy(copy->missing, btf->missing, pairs);
    if (btf->notes && !result && (copy->notes = pv_allocate(context, notes + 1, 1, &result)))
        memcpy(copy->notes, btf->notes, notes + 1);
    if (result)
        pave_btf_free(out);
    return result;
}

pave_result pv_btf_allocate_factors(pave_context *context, pave_btf *btf, int32_t plane, int32_t components)
{
    pave_result result = PAVE_OK;
    if (!btf->factors)
        btf->factors = pv_allocate_zeroed(context, (size_t)pv_btf_planes(btf), sizeof *btf->factors, &result);
    if (result)
        return result;
    pv_factors *f = &btf->factors[plane];
    size_t k = (size_t)components;
    f->components = components;
    f->singular = pv_allocate(context, k, sizeof *f->singular, &result);
    if (!result)
        f->left = pv_allocate(context, (size_t)pv_btf_rows(btf), k * sizeof *f->left, &result);
    if (!result)
        f->right = pv_allocate(context, (size_t)pv_btf_texels(btf), k * sizeof *f->right, &result);
    return result;
}

pave_result pave_btf_create(pave_context *context, const pave_btf_params *given, const void *samples, pave_btf **out)
{
    pave_btf_params params;
    if (out)
        *out = NULL;
    if (!context || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_struct_read(context, "BTF", &default_params, sizeof default_params, given, &params);
    if (!result)
        result = pv_btf_new(context, &params, out);
    if (!result)
        result = pv_btf_allocate_samples(context, *out);
    if (result) {
        pave_btf_free(out);
        return result;
    }
    size_t bytes = (size_t)pv_btf_texels(*out) * (*out)->samples.texel_bytes;
    if (samples)
        memcpy((*out)->samples.block, samples, bytes);
    else
        memset((*out)->samples.block, 0, bytes);
    return PAVE_OK;
}

static void free_factors(pave_btf *btf)
{
    for (int32_t c = 0; c < pv_btf_planes(btf) && btf->factors; c++) {
        pv_release(btf->factors[c].left);
        pv_release(btf->factors[c].right);
        pv_release(btf->factors[c].singular);
    }
    pv_release(btf->factors);
}

void pave_btf_free(pave_btf **btf)
{
    if (!btf || !*btf)
        return;
    pave_btf *b = *btf;
    free_factors(b);
    pv_scene_free(&b->scene);
    if (b->samples.map)
        munmap(b->samples.map, b->samples.map_bytes);
    pv_release(b->samples.block);
    pv_release((void *)(uintptr_t)b->samples.slots);
    pv_release(b->missing);
    pv_release(b->notes);
    pv_directions_free(&b->views);
    pv_directions_free(&b->lights);
    pv_release(b);
    *btf = NULL;
}

int32_t pave_btf_width(const pave_btf *btf) { return btf->width; }
int32_t pave_btf_height(const pave_btf *btf) { return btf->height; }
int32_t pave_btf_channels(const pave_btf *btf) { return btf->channels; }
int32_t pave_btf_views(const pave_btf *btf) { return btf->views.count; }
int32_t pave_btf_lights(const pave_btf *btf) { return btf->lights.count; }
const pave_direction *pave_btf_view_directions(const pave_btf *btf) { return btf->views.direction; }
const pave_direction *pave_btf_light_directions(const pave_btf *btf) { return btf->lights.direction; }
int32_t pave_btf_cosine(const pave_btf *btf) { return btf->cosine; }
double pave_btf_pixels_per_mm(const pave_btf *btf) { return btf->pixels_per_mm; }
const uint8_t *pave_btf_missing(const pave_btf *btf) { return btf->missing; }

static int is_channel(const pave_btf *btf, int32_t channel)
{
    return channel >= 0 && channel < btf->channels;
}

const char *pave_btf_channel_name(const pave_btf *btf, int32_t channel)
{
    return is_channel(btf, channel) ? btf->names[channel] : NULL;
}

int32_t pave_btf_components(const pave_btf *btf, int32_t channel)
{
    return btf->factors && is_channel(btf, channel) ? btf->factors[btf->joint ? 0 : channel].components : 0;
}

static const pv_factors *own_factors(const pave_btf *btf, int32_t channel)
{
    return btf->factors && !btf->joint && channel >= 0 && channel < btf->channels ? &btf->factors[channel] : NULL;
}

const float *pave_btf_eigenvectors(const pave_btf *btf, int32_t channel)
{
    const pv_factors *f = own_factors(btf, channel);
    return f ? f->left : NULL;
}

const float *pave_btf_coefficients(const pave_btf *btf, int32_t channel)
{
    const pv_factors *f = own_factors(btf, channel);
    return f ? f->right : NULL;
}

double pave_btf_error(const pave_btf *btf, int32_t channel)
{
    return btf->factors && is_channel(btf, channel) ? btf->factors[btf->joint ? 0 : channel].error : 0;
}

void pave_btf_abrdf(const pave_btf *btf, int32_t x, int32_t y, float *out)
{
    int64_t texel = (int64_t)y * btf->width + x, pairs = (int64_t)btf->views.count * btf->lights.count;
    if (btf->scene) {
        pv_scene_texel(btf->scene, texel, out);
        return;
    }
    if (!btf->factors) {
        pv_btf_samples(btf, texel, 0, pv_btf_length(btf), out);
        pv_btf_leave(btf, texel);
        return;
    }
    for (int64_t pair = 0; pair < pairs; pair++)
        pv_btf_sample(btf, texel, pair, out + pair * btf->channels);
}

void pave_btf_texture(const pave_btf *btf, int32_t view, int32_t light, float *out)
{
    int64_t pair = (int64_t)view * btf->lights.count + light;
    for (int64_t texel = 0; texel < pv_btf_texels(btf); texel++)
        pv_btf_sample(btf, texel, pair, out + texel * btf->channels);
}

void pave_btf_weights(const pave_btf *btf, int32_t of_lights, pave_direction direction, int32_t index[3],
                      double weight[3])
{
    pv_directions_weigh(of_lights ? &btf->lights : &btf->views, direction, index, weight);
}

static double lowest_cosine(const pv_directions *directions)
{
    float lowest = 0;
    for (int32_t i = 0; i < directions->count; i++)
        lowest = directions->direction[i].theta > lowest ? directions->direction[i].theta : lowest;
    return cos((double)lowest);
}

void pv_btf_mix(const pave_btf *btf, pave_direction view, pave_direction light, pv_mix *out)
{
    int32_t views[3], lights[3];
    double of_view[3], of_light[3], lowest = lowest_cosine(&btf->lights), cosine = cos((double)light.theta);
    double fade = btf->cosine && cosine < lowest ? fmax(cosine, 0) / lowest : cosine > 0;
    pv_directions_weigh(&btf->views, view, views, of_view);
    pv_directions_weigh(&btf->lights, light, lights, of_light);
    for (int32_t i = 0; i < 9; i++) {
        out->pair[i] = (int64_t)views[i / 3] * btf->lights.count + lights[i % 3];
        out->weight[i] = of_view[i / 3] * of_light[i % 3] * fade;
    }
}

void pave_btf_lookup(const pave_btf *btf, int32_t x, int32_t y, pave_direction view, pave_direction light, float *out)
{
    double sum[PV_BTF_CHANNELS] = { 0 };
    float values[PV_BTF_CHANNELS];
    pv_mix mix;
    pv_btf_mix(btf, view, light, &mix);
    for (int32_t i = 0; i < 9; i++) {
        if (mix.weight[i] == 0)
            continue;
        pv_btf_sample(btf, (int64_t)y * btf->width + x, mix.pair[i], values);
        for (int32_t c = 0; c < btf->channels; c++)
            sum[c] += mix.weight[i] * values[c];
    }
    for (int32_t c = 0; c < btf->channels; c++)
        out[c] = (float)sum[c];
}
