/* Writing Bonn's BTF files: BDI (samples), DFMF (a matrix for each channel) and FMF (one matrix). */
#include "io/bonn.h"

#include "base/parallel.h"
#include "io/output.h"
#include "util/half.h"

#include <math.h>
#include <string.h>

enum { SCAN_LINES = 4, VERSION = 4 };

static void put_word(pv_output *output, uint32_t value)
{
    uint8_t bytes[4] = { (uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16), (uint8_t)(value >> 24) };
    pv_output_bytes(output, bytes, sizeof bytes);
}

static void put_byte(pv_output *output, uint8_t value)
{
    pv_output_bytes(output, &value, 1);
}

static void put_real(pv_output *output, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_word(output, bits);
}

static void put_string(pv_output *output, const char *text)
{
    put_word(output, (uint32_t)strlen(text));
    pv_output_text(output, text);
}

/* From the header's size to the channels' names. */
static void put_common(pv_output *output, const pave_btf *btf)
{
    const char *texts[3] = { btf->setup, btf->sensor, btf->source };
    size_t size = 4 + 4 + 240 + 16 + 4 + 4 + 4, notes = btf->notes ? strlen(btf->notes) : 0;
    for (int32_t c = 0; c < btf->channels; c++)
        size += 4 + strlen(btf->names[c]);
    put_word(output, (uint32_t)(size + notes));
    put_word(output, VERSION);
    for (int i = 0; i < 3; i++)
        pv_output_bytes(output, texts[i], PV_BTF_TEXT - 1);
    put_real(output, (float)btf->pixels_per_mm);
    for (int i = 0; i < 3; i++)
        put_real(output, btf->rgb_scale[i]);
    put_word(output, (uint32_t)btf->cosine);
    put_string(output, btf->notes ? btf->notes : "");
    put_word(output, (uint32_t)btf->channels);
    for (int32_t c = 0; c < btf->channels; c++)
        put_string(output, btf->names[c]);
}

static void put_sampling(pv_output *output, const pave_btf *btf)
{
    put_word(output, (uint32_t)btf->views.count);
    for (int32_t v = 0; v < btf->views.count; v++) {
        put_real(output, btf->views.direction[v].theta);
        put_real(output, btf->views.direction[v].phi);
        put_word(output, (uint32_t)btf->lights.count);
        for (int32_t l = 0; l < btf->lights.count; l++) {
            put_real(output, btf->lights.direction[l].theta);
            put_real(output, btf->lights.direction[l].phi);
        }
    }
    put_word(output, (uint32_t)btf->width);
    put_word(output, (uint32_t)btf->height);
}

/* The greatest half, for what is beyond. */
static uint16_t to_half(float value)
{
    return pv_half(fminf(fmaxf(value, -65504), 65504));
}

static void to_halves(const float *from, int64_t count, uint8_t *to)
{
    for (int64_t i = 0; i < count; i++) {
        uint16_t half = to_half(from[i]);
        to[2 * i] = (uint8_t)half;
        to[2 * i + 1] = (uint8_t)(half >> 8);
    }
}

/* A row of texels under way. */
typedef struct row {
    const pave_btf *btf;
    int32_t y;
    float *values;  /* a texel for each worker */
    uint8_t *halves;
} row;

static void make_texel(void *data, int32_t x, int32_t worker)
{
    const row *r = data;
    int64_t length = pv_btf_length(r->btf);
    float *values = r->values + worker * length;
    pave_btf_abrdf(r->btf, x, r->y, values);
    to_halves(values, length, r->halves + (size_t)x * (size_t)length * 2);
}

static pave_result put_rows(pave_context *context, const pave_btf *btf, int32_t lines, pv_output *output)
{
    size_t length = (size_t)pv_btf_length(btf), bytes = length * 2 * (size_t)btf->width;
    pave_result result = PAVE_OK;
    row r = { .btf = btf };
    r.values = pv_allocate(context, (size_t)pv_workers(context), length * sizeof *r.values, &result);
    if (!result)
        r.halves = pv_allocate(context, bytes, 1, &result);
    for (r.y = 0; r.y < btf->height && !result; r.y++) {
        int32_t left = btf->height - r.y;
        if (r.y % lines == 0)
            put_word(output, (uint32_t)((size_t)(left < lines ? left : lines) * bytes));
        result = pv_parallel(context, btf->width, make_texel, &r, (double)r.y / btf->height,
                             (double)(r.y + 1) / btf->height);
        if (!result)
            pv_output_bytes(output, r.halves, bytes);
        if (pv_output_failed(output))
            break;
    }
    pv_release(r.values);
    pv_release(r.halves);
    return result;
}

pave_result pv_bdi_write(pave_context *context, const pave_btf *btf, const char *path)
{
    pv_output *output;
    double row_bytes = (double)pv_btf_length(btf) * 2 * btf->width;
    int32_t lines = SCAN_LINES * row_bytes < UINT32_MAX ? SCAN_LINES : 1;
    if (row_bytes > UINT32_MAX)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: a row of %d texels is too long for a chunk of a BDI file",
                       path, (int)btf->width);
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    pv_output_text(output, "!BDIF06R2!");
    put_common(output, btf);
    put_sampling(output, btf);
    put_word(output, (uint32_t)lines);
    put_byte(output, 0);
    for (int64_t i = 0; i < pv_btf_texels(btf); i++)
        put_byte(output, 1);
    put_word(output, 0);
    result = put_rows(context, btf, lines, output);
    return pv_output_close(output, result);
}

static void put_numbers(pv_output *output, int32_t type, const float *values, int64_t count)
{
    uint8_t bytes[8192];
    for (int64_t i = 0; i < count; i += 2048) {
        int64_t n = count - i < 2048 ? count - i : 2048;
        if (type == PAVE_F16)
            to_halves(values + i, n, bytes);
        for (int64_t k = 0; k < n && type != PAVE_F16; k++) {
            uint32_t bits;
            memcpy(&bits, &values[i + k], 4);
            for (int b = 0; b < 4; b++)
                bytes[4 * k + b] = (uint8_t)(bits >> 8 * b);
        }
        pv_output_bytes(output, bytes, (size_t)n * (type == PAVE_F16 ? 2 : 4));
    }
}

static void put_factors(pv_output *output, const pave_btf *btf, int32_t plane)
{
    const pv_factors *f = &btf->factors[plane];
    put_byte(output, btf->factor_type == PAVE_F16 ? 2 : 4);
    put_word(output, (uint32_t)f->components);
    put_word(output, (uint32_t)pv_btf_rows(btf));
    put_word(output, (uint32_t)pv_btf_texels(btf));
    put_numbers(output, btf->factor_type, f->singular, f->components);
    put_numbers(output, btf->factor_type, f->left, pv_btf_rows(btf) * f->components);
    put_numbers(output, btf->factor_type, f->right, pv_btf_texels(btf) * f->components);
}

static void put_dfmf(pv_output *output, const pave_btf *btf)
{
    int32_t most = 0;
    for (int32_t c = 0; c < btf->channels; c++)
        most = btf->factors[c].components > most ? btf->factors[c].components : most;
    put_word(output, (uint32_t)most);
    put_word(output, (uint32_t)btf->colour);
    for (int i = 0; i < 12; i++)
        put_real(output, btf->colour == PV_COLOUR_PCA ? btf->colour_space[i] : i >= 3 && (i - 3) % 4 == 0);
    for (int32_t c = 0; c < btf->channels; c++)
        put_factors(output, btf, c);
}

static void put_fmf(pv_output *output, const pave_btf *btf)
{
    put_byte(output, 1); /* version of the extended header */
    put_word(output, btf->colour == PV_COLOUR_LOG);
    put_word(output, (uint32_t)btf->factors[0].components);
    put_factors(output, btf, 0);
}

pave_result pv_fmf_write(pave_context *context, const pave_btf *btf, const char *path)
{
    pv_output *output;
    if (!btf->factors)
        return pv_fail(context, PAVE_ERR_ARGUMENT,
                       "%s: a .btf file holds factors, and this BTF holds samples: compress it first", path);
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    pv_output_text(output, btf->joint ? "!FMF12FCER" : "!DFMF08FCR");
    put_common(output, btf);
    put_sampling(output, btf);
    put_word(output, 0); /* local frames */
    if (btf->joint)
        put_fmf(output, btf);
    else
        put_dfmf(output, btf);
    return pv_output_close(output, result);
}
