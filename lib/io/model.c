/* Files of BTF models: a header, the directions, the settings, and the bases, which are mapped and not read. */
#include "btf/model.h"

#include <pave/io.h>

#include "io/input.h"
#include "io/output.h"
#include "io/reader.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/mman.h>

enum { SIGNATURE = 8, FORMAT = 1, ALIGNMENT = 64, MOST_DIRECTIONS = 4096 };

static const char signature[] = "PAVEMODL";

/* ---- Writing ---- */

typedef struct writer {
    pv_output *output;
    int64_t at;
} writer;

static void put(writer *w, const void *bytes, size_t size)
{
    pv_output_bytes(w->output, bytes, size);
    w->at += (int64_t)size;
}

static void put_word(writer *w, uint32_t value)
{
    uint8_t bytes[4] = { (uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16), (uint8_t)(value >> 24) };
    put(w, bytes, sizeof bytes);
}

static void put_double(writer *w, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_word(w, (uint32_t)bits);
    put_word(w, (uint32_t)(bits >> 32));
}

static void put_reals(writer *w, const float *values, int64_t count)
{
    for (int64_t i = 0; i < count && !pv_output_failed(w->output); i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        put_word(w, bits);
    }
}

static void align(writer *w)
{
    static const uint8_t zeros[ALIGNMENT] = { 0 };
    put(w, zeros, (size_t)((ALIGNMENT - w->at % ALIGNMENT) % ALIGNMENT));
}

static void put_directions(writer *w, const pv_directions *d)
{
    for (int32_t i = 0; i < d->count; i++) {
        const float both[2] = { d->direction[i].theta, d->direction[i].phi };
        put_reals(w, both, 2);
    }
}

static void put_head(writer *w, const pave_btf_model *m)
{
    const int32_t words[] = { FORMAT, m->channels, m->colour, m->cosine, m->patch, m->materials, m->symmetry,
                              m->views.count, m->lights.count, m->rungs };
    put(w, signature, SIGNATURE);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        put_word(w, (uint32_t)words[i]);
    put_reals(w, &m->least, 1);
    put_double(w, (double)m->texels);
    put_double(w, (double)m->patches);
    for (int32_t c = 0; c < m->channels; c++)
        put(w, m->names[c], PV_BTF_NAME);
    put_directions(w, &m->views);
    put_directions(w, &m->lights);
}

static void put_plane(writer *w, const pave_btf_model *m, int32_t plane)
{
    put_reals(w, m->range[plane], 2);
    for (int32_t of = 0; of < 2; of++) {
        put_word(w, (uint32_t)m->basis[plane][of].components);
        put_double(w, m->basis[plane][of].whole);
        put_double(w, m->basis[plane][of].outside);
    }
    for (int32_t k = 0; k < m->rungs; k++) {
        const pv_rung *r = &m->rung[plane][k];
        const double numbers[6] = { r->samples, r->noise[0], r->noise[1], r->rest, r->share, r->trust };
        for (int i = 0; i < 6; i++)
            put_double(w, numbers[i]);
    }
    put_reals(w, m->mean + plane * pv_model_pairs(m), pv_model_pairs(m));
}

static pave_result put_bases(pave_context *context, writer *w, const pave_btf_model *m)
{
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < 2 * m->planes && !result; i++) {
        const pv_basis *basis = &m->basis[i / 2][i % 2];
        int64_t rows = pv_basis_rows(m, i % 2), each = 1 + (1 << 20) / (basis->components + 1);
        align(w);
        put_reals(w, basis->deviation, basis->components);
        align(w);
        for (int64_t r = 0; r < rows && basis->components && !result; r += each) {
            put_reals(w, basis->left + r * basis->components, (rows - r < each ? rows - r : each) * basis->components);
            result = pv_progress(context, (i + (double)r / (double)rows) / (2 * m->planes));
        }
    }
    return result;
}

pave_result pave_btf_model_write(pave_context *context, const pave_btf_model *model, const char *path)
{
    writer w = { 0 };
    if (!context || !model || !path)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    pave_result result = pv_output_open(context, path, 0, &w.output);
    if (result)
        return result;
    pv_call call = pv_call_begin(context, "write", 0, 1);
    put_head(&w, model);
    for (int32_t c = 0; c < model->planes; c++)
        put_plane(&w, model, c);
    result = put_bases(context, &w, model);
    result = pv_output_close(w.output, result);
    pv_call_end(context, call);
    errno = before;
    return result;
}

/* ---- Reading: every number is held against the bytes that are there before it is believed ---- */

static pave_result damaged(const pv_reader *r, const char *reason)
{
    return pv_fail(r->context, PAVE_ERR_FORMAT, "%s: is a damaged model: %s", r->path,
                   r->cut ? "it is cut short" : reason);
}

typedef struct head {
    int32_t channels, colour, cosine, patch, materials, symmetry, views, lights, rungs;
    float least;
    double texels, patches;
} head;

static int head_is_sound(const head *h)
{
    int triple = h->colour == PV_COLOUR_LOG_YUV;
    return h->channels >= 1 && h->channels <= PV_BTF_CHANNELS && (!triple || h->channels == 3) &&
           (triple || h->colour == PV_COLOUR_LOG || h->colour == PV_COLOUR_RGB) && (h->cosine & ~1) == 0 &&
           h->patch >= 1 && h->patch <= PV_MOST_PATCH && h->patch % 2 == 1 && h->materials >= 1 &&
           (h->symmetry == 1 || h->symmetry == 2 || h->symmetry == 4) && h->views >= 1 && h->lights >= 1 &&
           h->views <= MOST_DIRECTIONS && h->lights <= MOST_DIRECTIONS && h->rungs >= 0 && h->rungs <= PV_MOST_RUNGS &&
           h->least > 0 && h->least <= 1 && h->texels >= 0 && h->texels < 1e15 && h->patches >= 0 && h->patches < 1e15;
}

static pave_result read_head(pv_reader *r, head *h)
{
    const uint8_t *sign = pv_take(r, SIGNATURE);
    if (!sign || memcmp(sign, signature, SIGNATURE))
        return pv_fail(r->context, PAVE_ERR_FORMAT, "%s: is not a model of BTFs", r->path);
    uint32_t format = pv_word(r);
    if (format != FORMAT)
        return pv_fail(r->context, PAVE_ERR_UNSUPPORTED, "%s: is a model of format %u, and %d is read", r->path,
                       (unsigned)format, FORMAT);
    int32_t *words[9] = { &h->channels, &h->colour, &h->cosine, &h->patch, &h->materials, &h->symmetry, &h->views,
                          &h->lights, &h->rungs };
    for (int i = 0; i < 9; i++) {
        uint32_t value = pv_word(r);
        *words[i] = value <= INT32_MAX ? (int32_t)value : -1;
    }
    h->least = pv_real(r);
    h->texels = pv_number(r);
    h->patches = pv_number(r);
    return r->cut || !head_is_sound(h) ? damaged(r, "its header holds what cannot be") : PAVE_OK;
}

static pave_result read_directions(pv_reader *r, int32_t count, pave_direction **out)
{
    pave_result result = PAVE_OK;
    const size_t needed = (size_t)count * 8;
    if (needed > pv_left(r))
        r->cut = 1;
    if (r->cut)
        return damaged(r, "");
    *out = pv_allocate(r->context, (size_t)count, sizeof **out, &result);
    for (int32_t i = 0; i < count && !result; i++) {
        (*out)[i].theta = pv_real(r);
        (*out)[i].phi = pv_real(r);
    }
    return result;
}

static void read_names(pv_reader *r, const head *h, char names[][PV_BTF_NAME])
{
    for (int32_t c = 0; c < h->channels; c++) {
        const uint8_t *name = pv_take(r, PV_BTF_NAME);
        for (int32_t i = 0; i < PV_BTF_NAME - 1 && name && name[i]; i++)
            names[c][i] = name[i] == ',' || name[i] < ' ' ? '_' : (char)name[i];
        if (!names[c][0])
            names[c][0] = '?';
    }
}

static pave_result make_frame(pv_reader *r, const head *h, pave_btf_model **out)
{
    char names[PV_BTF_CHANNELS][PV_BTF_NAME] = { { 0 } };
    pave_direction *views = NULL, *lights = NULL;
    read_names(r, h, names);
    pave_result result = read_directions(r, h->views, &views);
    if (!result)
        result = read_directions(r, h->lights, &lights);
    if (!result && (uint64_t)h->views * (uint64_t)h->lights * 4 * (uint64_t)h->channels > pv_left(r))
        result = (r->cut = 1, damaged(r, ""));
    if (!result)
        result = pv_model_new(r->context, h->channels, views, h->views, lights, h->lights, out);
    pv_release(views);
    pv_release(lights);
    if (result)
        return result;
    pave_btf_model *m = *out;
    m->channels = h->channels;
    m->colour = h->colour;
    m->cosine = h->cosine;
    m->patch = h->patch;
    m->materials = h->materials;
    m->symmetry = h->symmetry;
    m->rungs = h->rungs;
    m->least = h->least;
    m->texels = (int64_t)h->texels;
    m->patches = (int64_t)h->patches;
    memcpy(m->names, names, sizeof m->names);
    return PAVE_OK;
}

static int all_within(const float *values, int64_t count, float least, float greatest)
{
    for (int64_t i = 0; i < count; i++)
        if (!(values[i] >= least && values[i] <= greatest))
            return 0;
    return 1;
}

static int rung_is_sound(const pv_rung *r)
{
    return r->samples >= 1 && r->samples < 1e9 && r->noise[0] > 0 && r->noise[1] > 0 && r->rest > 0 && r->share >= 0 &&
           r->share <= 1 && r->trust >= 0 && isfinite(r->noise[0]) && isfinite(r->noise[1]) && isfinite(r->rest) &&
           isfinite(r->trust);
}

static pave_result read_plane(pv_reader *r, pave_btf_model *m, int32_t plane)
{
    double last = 0;
    int sound = 1;
    m->range[plane][0] = pv_real(r);
    m->range[plane][1] = pv_real(r);
    sound &= all_within(m->range[plane], 2, -1e5f, 1e5f) && m->range[plane][0] <= m->range[plane][1];
    for (int32_t of = 0; of < 2; of++) {
        pv_basis *b = &m->basis[plane][of];
        uint32_t components = pv_word(r);
        b->whole = pv_number(r);
        b->outside = pv_number(r);
        sound &= components <= PV_MOST_COMPONENTS && components <= pv_basis_rows(m, of) && b->whole >= 0 &&
                 b->outside >= 0 && isfinite(b->whole) && isfinite(b->outside);
        sound &= of == PV_OF_PATCHES ? (components > 0) == (m->patch > 1) : components > 0;
        b->components = sound ? (int32_t)components : 0;
    }
    for (int32_t k = 0; k < m->rungs; k++) {
        pv_rung *g = &m->rung[plane][k];
        double *numbers[6] = { &g->samples, &g->noise[0], &g->noise[1], &g->rest, &g->share, &g->trust };
        for (int i = 0; i < 6; i++)
            *numbers[i] = pv_number(r);
        sound &= rung_is_sound(g) && g->samples > last;
        last = g->samples;
    }
    for (int64_t p = 0; p < pv_model_pairs(m); p++)
        m->mean[plane * pv_model_pairs(m) + p] = pv_real(r);
    sound &= all_within(m->mean + plane * pv_model_pairs(m), pv_model_pairs(m), -1e5f, 1e5f);
    return r->cut || !sound ? damaged(r, "a channel's settings hold what cannot be") : PAVE_OK;
}

/* Floats where they lie in the map. */
static float *take_reals(pv_reader *r, int64_t count)
{
    pv_take(r, (ALIGNMENT - (uint64_t)(r->at - r->begin) % ALIGNMENT) % ALIGNMENT);
    const uint8_t *at = pv_take(r, (uint64_t)count * 4);
    return (float *)(uintptr_t)at;
}

static pave_result find_bases(pv_reader *r, pave_btf_model *m)
{
    pave_result result = PAVE_OK;
    for (int32_t i = 0; i < 2 * m->planes && !result; i++) {
        pv_basis *b = &m->basis[i / 2][i % 2];
        b->deviation = take_reals(r, b->components);
        b->left = take_reals(r, pv_basis_rows(m, i % 2) * b->components);
        if (r->cut || !all_within(b->deviation, b->components, 0, 1e6f) ||
            !all_within(b->left, pv_basis_rows(m, i % 2) * b->components, -1.01f, 1.01f)) /* columns have length 1 */
            result = damaged(r, "its bases are none");
        if (!result)
            result = pv_progress(r->context, (i + 1.0) / (2 * m->planes));
    }
    return result || r->at == r->end ? result : damaged(r, "bytes are left over at its end");
}

static pave_result read_model(pv_reader *r, pave_btf_model **out)
{
    head h;
    pave_result result = read_head(r, &h);
    if (!result)
        result = make_frame(r, &h, out);
    for (int32_t c = 0; c < h.channels && !result; c++)
        result = read_plane(r, *out, c);
    return result ? result : find_bases(r, *out);
}

static pave_result read_mapped(const pv_input *input, pave_btf_model **out)
{
    const uint32_t one = 1;
    if (!*(const uint8_t *)&one)
        return pv_fail(input->context, PAVE_ERR_UNSUPPORTED, "models are read on little-endian machines");
    size_t size = (size_t)input->size;
    uint8_t *bytes = mmap(NULL, size, PROT_READ, MAP_PRIVATE, input->file, 0);
    if (bytes == MAP_FAILED)
        return pv_unreadable(input->context, input->path, errno);
    pv_reader r = pv_reader_of(input->context, input->path, bytes, size);
    pave_result result = read_model(&r, out);
    if (*out) { /* what it has of bases lies in the map */
        (*out)->map = bytes;
        (*out)->map_bytes = size;
    } else
        munmap(bytes, size);
    if (result)
        pave_btf_model_free(out);
    return result;
}

pave_result pave_btf_model_read(pave_context *context, const char *path, pave_btf_model **out)
{
    pv_input input;
    if (out)
        *out = NULL;
    if (!context || !path || !out)
        return PAVE_ERR_ARGUMENT;
    int before = errno;
    pv_call call = pv_call_begin(context, "read", 0, 1);
    pave_result result = pv_input_open(context, path, &input);
    if (!result)
        result = read_mapped(&input, out);
    pv_input_close(&input);
    pv_call_end(context, call);
    errno = before;
    return result;
}
