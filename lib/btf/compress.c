/* Compression: each channel's matrix becomes its truncated singular value decomposition. */
#include "btf/factor.h"

#include "base/parallel.h"


static const pave_btf_compress_params default_params = PAVE_BTF_COMPRESS_PARAMS_INIT;

static const pv_param compress_rows[] = {
    PV_INTEGER(pave_btf_compress_params, components, "", 1, 4096, "components of each channel; with error, at most"),
    PV_INTEGER(pave_btf_compress_params, second, "", 0, 4096, "of U/Y; 0: half as many"),
    PV_INTEGER(pave_btf_compress_params, third, "", 0, 4096, "of V/Y; 0: half as many"),
    PV_REAL(pave_btf_compress_params, error, "", 0, 1, "greatest relative error of a channel; 0: as components say"),
    PV_CHOICE(pave_btf_compress_params, colour, "auto|log-yuv|log|plain", "what is factored"),
    PV_FLAG(pave_btf_compress_params, joint, "factor all channels as one matrix, which makes an FMF file"),
    PV_INTEGER(pave_btf_compress_params, passes, "", 1, 16, "passes over the data"),
    { "type", PAVE_PARAM_INTEGER, "", PAVE_F16, PAVE_F32, NULL, "4: halves, 5: floats, in the file",
      offsetof(pave_btf_compress_params, type) },
};

const pv_table pv_btf_compress_table = PV_TABLE("BTF compression", default_params, compress_rows);

void pave_btf_compress_params_init(pave_btf_compress_params *params, size_t size)
{
    pv_params_init(&pv_btf_compress_table, params, size);
}

typedef struct work {
    const pave_btf *btf;
    pave_btf *out;
    float *texel; /* two texels for each worker */
} work;

/* What is factored of a texel, channel by channel. */
static int read_texel(void *user, int64_t texel, int32_t worker, float *const *out)
{
    const work *w = user;
    const pave_btf *btf = w->btf;
    int64_t length = pv_btf_length(btf), rows = pv_btf_rows(w->out);
    int32_t planes = pv_btf_planes(w->out);
    float *samples = w->texel + worker * 2 * length, *values = samples + length;
    pave_btf_abrdf(btf, (int32_t)(texel % btf->width), (int32_t)(texel / btf->width), samples);
    pv_colour_encode(w->out->colour, PV_LEAST_LIGHT, btf->channels, samples, length / btf->channels, values);
    for (int32_t c = 0; c < planes; c++)
        for (int64_t r = 0; r < rows; r++)
            out[c][r] = values[r * planes + c];
    return pv_all_finite(samples, length);
}

static pave_result refuse_texel(pave_context *context, void *user, int64_t texel)
{
    const work *w = user;
    return pv_fail(context, PAVE_ERR_FORMAT, "texel %lld,%lld has samples that are infinite or no numbers",
                   (long long)(texel % w->btf->width), (long long)(texel / w->btf->width));
}

static void ask_for(const pave_btf_compress_params *params, int32_t colour, int32_t planes, int32_t *components)
{
    for (int32_t c = 0; c < planes; c++) {
        int32_t asked = c == 1 ? params->second : params->third, half = (params->components + 1) / 2;
        int32_t chroma = colour == PV_COLOUR_LOG_YUV && c;
        components[c] = !chroma ? params->components : asked ? asked : params->error ? params->components : half;
    }
}

static pave_result factor(pave_context *context, const pv_algebra *algebra, const pave_btf_compress_params *params,
                          work *w)
{
    pave_btf *out = w->out;
    int32_t planes = pv_btf_planes(out), components[PV_BTF_CHANNELS];
    const pv_columns columns = { planes, pv_btf_rows(out), pv_btf_texels(out), read_texel, refuse_texel, w };
    pave_result result = PAVE_OK;
    ask_for(params, out->colour, planes, components);
    w->texel = pv_allocate(context, (size_t)pv_workers(context), 2 * (size_t)pv_btf_length(out) * sizeof *w->texel,
                           &result);
    if (!result)
        out->factors = pv_allocate_zeroed(context, (size_t)planes, sizeof *out->factors, &result);
    if (!result)
        result = pv_factor(context, algebra, &columns, components, params->error, params->passes, out->factors);
    for (int32_t c = 0; c < planes && !result; c++)
        if (params->error && out->factors[c].error > params->error)
            pv_note(context, PAVE_MESSAGE_WARNING, "channel %d keeps an error of %.4f with %d components", (int)c,
                    out->factors[c].error, (int)out->factors[c].components);
    pv_release(w->texel);
    return result;
}

pave_result pave_btf_compress(pave_context *context, const pave_btf *btf, const pave_btf_compress_params *given,
                              pave_btf **out)
{
    pave_btf_compress_params params;
    pv_algebra algebra;
    work w = { .btf = btf };
    int32_t colour;
    if (out)
        *out = NULL;
    if (!context || !btf || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_btf_compress_table, given, &params);
    if (!result)
        result = pv_colour_choose(context, params.colour, btf->channels, params.joint, &colour);
    if (!result)
        result = pv_btf_copy_frame(context, btf, out);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "compress", 0, 1);
    w.out = *out;
    w.out->colour = colour;
    w.out->factor_type = params.type;
    w.out->joint = params.joint;
    result = pv_algebra_open(context, &algebra);
    if (!result) {
        result = factor(context, &algebra, &params, &w);
        pv_algebra_close(&algebra);
    }
    pv_call_end(context, call);
    if (result)
        pave_btf_free(out);
    return result;
}
