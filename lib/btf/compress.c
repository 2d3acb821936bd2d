/* Compression: each channel's matrix becomes its truncated singular value decomposition, found by randomised subspace
 * iteration over blocks of texels (Halko, Martinsson and Tropp 2011, 4.5). */
#include "btf/algebra.h"
#include "btf/btf.h"

#include "base/parallel.h"
#include "util/random.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 512, GROUP = 64, STRIPE = 2048, SPARE = 16 };

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

/* One channel's matrix: texels x pairs, seen through a basis of `width` columns. */
typedef struct plane {
    int32_t width;
    float *basis; /* [row][width], orthonormal */
    float *sum;   /* [row][width], of A' A basis */
    float *seen;  /* [texel of the block][width], A basis */
    double *inner, *part; /* [width][width], of basis' A' A basis; what a block adds */
    float *block; /* [texel of the block][row], A */
    double energy;
} plane;

typedef struct work {
    const pave_btf *btf;
    const pv_algebra *algebra;
    int32_t colour;
    int64_t rows;   /* of a matrix */
    plane plane[PV_BTF_CHANNELS];
    float *texel;   /* two texels for each worker */
    double *energy; /* [texel of the block][channel] */
    int64_t first;  /* texel of the block */
    int32_t count;  /* of its texels */
    pave_btf *out;
} work;

/* Reads a texel of the block: what is factored, channel by channel. */
static int all_finite(const float *values, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return 0;
    return 1;
}

static void read_texel(void *data, int32_t index, int32_t worker)
{
    work *w = data;
    const pave_btf *btf = w->btf;
    float *samples = w->texel + (size_t)worker * 2 * (size_t)pv_btf_length(btf);
    float *values = samples + pv_btf_length(btf);
    int64_t texel = w->first + index;
    pave_btf_abrdf(btf, (int32_t)(texel % btf->width), (int32_t)(texel / btf->width), samples);
    pv_colour_encode(w->colour, btf->channels, samples, pv_btf_length(btf) / btf->channels, values);
    int32_t planes = pv_btf_planes(w->out);
    double none = all_finite(samples, pv_btf_length(btf)) ? 0 : NAN;
    for (int32_t c = 0; c < planes; c++) {
        float *row = w->plane[c].block + (size_t)index * (size_t)w->rows;
        double energy = none;
        for (int64_t p = 0; p < w->rows; p++) {
            row[p] = values[p * planes + c];
            energy += (double)row[p] * row[p];
        }
        w->energy[index * planes + c] = energy;
    }
}

static int32_t groups(const work *w)
{
    return (w->count + GROUP - 1) / GROUP;
}

static int32_t stripes(const work *w)
{
    return (int32_t)((w->rows + STRIPE - 1) / STRIPE);
}

static int least(int64_t a, int64_t b)
{
    return (int)(a < b ? a : b);
}

static void see_group(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    const work *w = data;
    const plane *p = &w->plane[index / groups(w)];
    int32_t first = index % groups(w) * GROUP;
    pv_multiply(w->algebra, 0, 0, least(GROUP, w->count - first), p->width, (int)w->rows,
                p->block + (size_t)first * (size_t)w->rows, (int)w->rows, p->basis, p->width, 0,
                p->seen + (size_t)first * (size_t)p->width, p->width);
}

static void sum_stripe(void *data, int32_t index, int32_t worker)
{
    (void)worker;
    const work *w = data;
    const plane *p = &w->plane[index / stripes(w)];
    int64_t first = (int64_t)(index % stripes(w)) * STRIPE;
    pv_multiply(w->algebra, 1, 0, least(STRIPE, w->rows - first), p->width, w->count, p->block + first, (int)w->rows,
                p->seen, p->width, 1, p->sum + (size_t)first * (size_t)p->width, p->width);
}

static pave_result check_energy(pave_context *context, const work *w)
{
    int32_t planes = pv_btf_planes(w->out);
    for (int32_t i = 0; i < w->count * planes; i++) {
        int64_t texel = w->first + i / planes;
        if (!isfinite(w->energy[i]))
            return pv_fail(context, PAVE_ERR_FORMAT, "texel %lld,%lld has samples that are infinite or no numbers",
                           (long long)(texel % w->btf->width), (long long)(texel / w->btf->width));
    }
    return PAVE_OK;
}

/* Reads a block of texels and looks at it through the bases. */
static pave_result see_block(pave_context *context, work *w, double from, double to)
{
    double half = from + 0.5 * (to - from);
    int64_t left = pv_btf_texels(w->btf) - w->first;
    w->count = least(BLOCK, left);
    pave_result result = pv_parallel(context, w->count, read_texel, w, from, half);
    if (!result)
        result = check_energy(context, w);
    return result ? result : pv_parallel(context, groups(w) * pv_btf_planes(w->out), see_group, w, half, to);
}

static void add_energy(work *w)
{
    for (int32_t i = 0; i < w->count * pv_btf_planes(w->out); i++)
        w->plane[i % pv_btf_planes(w->out)].energy += w->energy[i];
}

static pave_result add_inner(pave_context *context, work *w)
{
    pave_result result = PAVE_OK;
    for (int32_t c = 0; c < pv_btf_planes(w->out) && !result; c++) {
        plane *p = &w->plane[c];
        result = pv_gram(context, w->algebra, w->count, p->width, p->seen, p->part);
        for (int64_t i = 0; i < (int64_t)p->width * p->width && !result; i++)
            p->inner[i] += p->part[i];
    }
    return result;
}

/* The sum, turned to singular directions first (Rayleigh and Ritz), so that small ones keep their digits. */
static pave_result renew_basis(pave_context *context, work *w, plane *p)
{
    float *swap = p->basis;
    pave_result result = pv_eigen(context, w->algebra, p->width, p->inner, p->part);
    if (!result)
        result = pv_rotate(context, w->algebra, w->rows, p->width, p->sum, p->width, p->inner, p->sum);
    p->basis = p->sum;
    p->sum = swap;
    return result ? result : pv_orthonormalise(context, w->algebra, w->rows, p->width, p->basis);
}

/* basis := an orthonormal basis of A' A basis. */
static pave_result iterate(pave_context *context, work *w, double from, double to)
{
    int32_t planes = pv_btf_planes(w->out);
    int64_t texels = pv_btf_texels(w->btf);
    pave_result result = PAVE_OK;
    for (int32_t c = 0; c < planes; c++) {
        size_t width = (size_t)w->plane[c].width;
        memset(w->plane[c].sum, 0, (size_t)w->rows * width * sizeof(float));
        memset(w->plane[c].inner, 0, width * width * sizeof(double));
    }
    for (w->first = 0; w->first < texels && !result; w->first += BLOCK) {
        double a = from + (to - from) * (double)w->first / (double)texels;
        double b = from + (to - from) * (double)least(w->first + BLOCK, texels) / (double)texels;
        result = see_block(context, w, a, 0.6 * a + 0.4 * b);
        if (!result)
            result = add_inner(context, w);
        if (!result)
            result = pv_parallel(context, stripes(w) * planes, sum_stripe, w, 0.6 * a + 0.4 * b, b);
    }
    for (int32_t c = 0; c < planes && !result; c++)
        result = renew_basis(context, w, &w->plane[c]);
    return result;
}

/* A basis, which becomes each channel's right factor before it is rotated. */
static pave_result project(pave_context *context, work *w, double from, double to)
{
    int64_t texels = pv_btf_texels(w->btf);
    pave_result result = PAVE_OK;
    for (w->first = 0; w->first < texels && !result; w->first += BLOCK) {
        result = see_block(context, w, from + (to - from) * (double)w->first / (double)texels,
                           from + (to - from) * (double)least(w->first + BLOCK, texels) / (double)texels);
        add_energy(w);
        for (int32_t c = 0; c < pv_btf_planes(w->out) && !result; c++)
            memcpy(w->out->factors[c].right + w->first * w->plane[c].width, w->plane[c].seen,
                   (size_t)w->count * (size_t)w->plane[c].width * sizeof(float));
    }
    return result;
}

/* As many components as the error asks for, or as were asked for; the error that remains. */
static int32_t choose_components(const work *w, const pave_btf_compress_params *params, int32_t c,
                                 const double *values)
{
    const plane *p = &w->plane[c];
    pv_factors *f = &w->out->factors[c];
    int32_t most = least(f->components, p->width), k = 0;
    double left = p->energy;
    while (k < most && (!params->error || left > params->error * params->error * p->energy))
        left -= fmax(values[k++], 0);
    f->error = p->energy > 0 ? sqrt(fmax(left, 0) / p->energy) : 0;
    return k ? k : 1;
}

/* Rotates a channel's basis and its projection to singular vectors, and keeps the greatest. */
static pave_result finish_channel(pave_context *context, const pave_btf_compress_params *params, work *w, int32_t c)
{
    plane *p = &w->plane[c];
    pv_factors *f = &w->out->factors[c];
    int64_t texels = pv_btf_texels(w->btf);
    pave_result result = PAVE_OK;
    double *turn = pv_allocate(context, (size_t)p->width, (size_t)p->width * sizeof *turn, &result), *values = NULL;
    float *right = NULL;
    if (!result)
        values = pv_allocate(context, (size_t)p->width, sizeof *values, &result);
    if (!result)
        result = pv_gram(context, w->algebra, texels, p->width, f->right, turn);
    if (!result)
        result = pv_eigen(context, w->algebra, p->width, turn, values);
    int32_t k = result ? 0 : choose_components(w, params, c, values);
    if (!result)
        right = pv_allocate(context, (size_t)texels, (size_t)k * sizeof *right, &result);
    if (!result)
        result = pv_rotate(context, w->algebra, texels, p->width, f->right, k, turn, right);
    if (!result)
        result = pv_rotate(context, w->algebra, w->rows, p->width, p->basis, k, turn, f->left);
    for (int32_t i = 0; i < k && !result; i++)
        f->singular[i] = (float)sqrt(fmax(values[i], 0));
    pv_release(turn);
    pv_release(values);
    if (right) {
        pv_release(f->right);
        f->right = right;
        f->components = k;
    }
    return result;
}

static pave_result open_plane(pave_context *context, work *w, int32_t c, int32_t components)
{
    plane *p = &w->plane[c];
    int64_t texels = pv_btf_texels(w->btf), room = components + (components / 8 > SPARE ? components / 8 : SPARE);
    p->width = least(least(room, w->rows), texels);
    pave_result result = pv_btf_allocate_factors(context, w->out, c, p->width);
    size_t width = (size_t)p->width * sizeof(float);
    if (!result)
        p->basis = pv_allocate(context, (size_t)w->rows, width, &result);
    if (!result)
        p->sum = pv_allocate(context, (size_t)w->rows, width, &result);
    if (!result)
        p->seen = pv_allocate(context, BLOCK, width, &result);
    if (!result)
        p->block = pv_allocate(context, BLOCK, (size_t)w->rows * sizeof(float), &result);
    if (!result)
        p->inner = pv_allocate(context, (size_t)p->width, (size_t)p->width * sizeof *p->inner, &result);
    if (!result)
        p->part = pv_allocate(context, (size_t)p->width, (size_t)p->width * sizeof *p->part, &result);
    for (int64_t i = 0; i < w->rows * p->width && !result; i++) {
        pv_random r = pv_draw(0, PV_DRAW_SKETCH, (uint32_t)i, (uint32_t)(i >> 32), (uint32_t)c);
        p->basis[i] = (float)(r.word[0] >> 8) * 0x1p-23f - 1;
    }
    w->out->factors[c].components = least(components, p->width);
    return result ? result : pv_orthonormalise(context, w->algebra, w->rows, p->width, p->basis);
}

static pave_result open_work(pave_context *context, const pave_btf_compress_params *params, work *w)
{
    const pave_btf *btf = w->btf;
    pave_result result = PAVE_OK;
    size_t length = (size_t)pv_btf_length(btf);
    w->rows = pv_btf_rows(w->out);
    w->texel = pv_allocate(context, (size_t)pv_workers(context), 2 * length * sizeof *w->texel, &result);
    if (!result)
        w->energy = pv_allocate(context, BLOCK, (size_t)btf->channels * sizeof *w->energy, &result);
    for (int32_t c = 0; c < pv_btf_planes(w->out) && !result; c++) {
        int32_t asked = c == 1 ? params->second : params->third, half = (params->components + 1) / 2;
        int32_t chroma = w->colour == PV_COLOUR_LOG_YUV && c;
        result = open_plane(context, w, c, !chroma ? params->components : asked ? asked
                                                   : params->error ? params->components : half);
    }
    return result;
}

static void close_work(work *w)
{
    pv_release(w->texel);
    pv_release(w->energy);
    for (int32_t c = 0; c < PV_BTF_CHANNELS; c++) {
        pv_release(w->plane[c].basis);
        pv_release(w->plane[c].sum);
        pv_release(w->plane[c].seen);
        pv_release(w->plane[c].block);
        pv_release(w->plane[c].inner);
        pv_release(w->plane[c].part);
    }
}

static pave_result factor(pave_context *context, const pave_btf_compress_params *params, work *w)
{
    pave_result result = open_work(context, params, w);
    for (int32_t i = 0; i + 1 < params->passes && !result; i++)
        result = iterate(context, w, (double)i / params->passes, (double)(i + 1) / params->passes);
    if (!result)
        result = project(context, w, 1 - 1.0 / params->passes, 1);
    for (int32_t c = 0; c < pv_btf_planes(w->out) && !result; c++) {
        result = finish_channel(context, params, w, c);
        if (!result && params->error && w->out->factors[c].error > params->error)
            pv_note(context, PAVE_MESSAGE_WARNING, "channel %d keeps an error of %.4f with %d components", (int)c,
                    w->out->factors[c].error, (int)w->out->factors[c].components);
    }
    return result;
}

static pave_result choose_colour(pave_context *context, const pave_btf *btf, const pave_btf_compress_params *params,
                                 int32_t *colour)
{
    static const int32_t known[4] = { -1, PV_COLOUR_LOG_YUV, PV_COLOUR_LOG, PV_COLOUR_RGB };
    *colour = known[params->colour];
    if (!params->colour)
        *colour = btf->channels == 3 && !params->joint ? PV_COLOUR_LOG_YUV : PV_COLOUR_LOG;
    if (*colour == PV_COLOUR_LOG_YUV && params->joint)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "joint factors are of plain samples or of their logarithms");
    if (*colour == PV_COLOUR_LOG_YUV && btf->channels != 3)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "log-yuv is for three channels, and this BTF has %d",
                       (int)btf->channels);
    return PAVE_OK;
}

pave_result pave_btf_compress(pave_context *context, const pave_btf *btf, const pave_btf_compress_params *given,
                              pave_btf **out)
{
    pave_btf_compress_params params;
    pv_algebra algebra;
    work w = { .btf = btf, .algebra = &algebra };
    if (out)
        *out = NULL;
    if (!context || !btf || !out)
        return PAVE_ERR_ARGUMENT;
    pave_result result = pv_params_read(context, &pv_btf_compress_table, given, &params);
    if (!result)
        result = choose_colour(context, btf, &params, &w.colour);
    if (!result)
        result = pv_btf_copy_frame(context, btf, out);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "compress", 0, 1);
    w.out = *out;
    w.out->colour = w.colour;
    w.out->factor_type = params.type;
    w.out->joint = params.joint;
    result = pv_algebra_open(context, &algebra);
    if (!result) {
        result = factor(context, &params, &w);
        close_work(&w);
        pv_algebra_close(&algebra);
    }
    pv_call_end(context, call);
    if (result)
        pave_btf_free(out);
    return result;
}
