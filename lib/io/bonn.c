/* Reading Bonn's BTF files. Every number is held against the bytes that are there before it is believed. */
#include "io/bonn.h"

#include "io/reader.h"
#include "util/half.h"

#include <math.h>
#include <string.h>

typedef enum kind { DFMF, FMF, FMF_EXTENDED, BDI, PVF } kind;

typedef struct signature {
    const char *text;
    kind is;
    int rotations;
} signature;

/* Longer ones first, for some begin like others. */
static const signature signatures[] = {
    { "!FMF12FCER", FMF_EXTENDED, 1 }, { "!DFMF08FCR", DFMF, 1 }, { "!BDIF06R2!", BDI, 1 }, { "!FMF06FCR", FMF, 1 },
    { "!DFMF08FC", DFMF, 0 },          { "!PVF06FCR", PVF, 1 },   { "!FMF06FC", FMF, 0 },   { "!PVF06FC", PVF, 0 },
};

static const signature *find_signature(const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < sizeof signatures / sizeof *signatures; i++) {
        size_t length = strlen(signatures[i].text);
        if (size >= length && !memcmp(bytes, signatures[i].text, length))
            return &signatures[i];
    }
    return NULL;
}

int pv_is_bonn(const uint8_t *bytes, size_t size)
{
    return find_signature(bytes, size) != NULL;
}

static pave_result damaged(const pv_reader *r, const char *reason)
{
    return pv_fail(r->context, PAVE_ERR_FORMAT, "%s: is a damaged BTF file: %s", r->path, reason);
}

static pave_result check_cut(const pv_reader *r)
{
    return r->cut ? damaged(r, "it is cut short") : PAVE_OK;
}

/* What stands before the body. */
typedef struct head {
    const signature *signature;
    pave_btf_params params;
    float rgb_scale[3];
    char text[3][PV_BTF_TEXT];
    char names[PV_BTF_CHANNELS * PV_BTF_NAME];
    const uint8_t *notes;
    uint32_t notes_length;
    pave_direction *views, *lights;
} head;

static pave_result read_names(pv_reader *r, head *h)
{
    uint32_t count = pv_word(r);
    char *to = h->names;
    if (count < 1 || count > PV_BTF_CHANNELS)
        return r->cut ? check_cut(r)
                      : pv_fail(r->context, PAVE_ERR_LIMIT, "%s: has %u channels, and 1 to %d can be read", r->path,
                                (unsigned)count, PV_BTF_CHANNELS);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t length = pv_word(r);
        const uint8_t *name = pv_take(r, length);
        if (!name)
            return check_cut(r);
        if (i)
            *to++ = ',';
        uint32_t kept = length < PV_BTF_NAME - 1 ? length : PV_BTF_NAME - 1, written = 0;
        for (uint32_t k = 0; k < kept && name[k]; k++, written++)
            *to++ = name[k] == ',' || name[k] < ' ' ? '_' : (char)name[k];
        if (!written)
            *to++ = '?';
    }
    *to = 0;
    h->params.channels = (int32_t)count;
    h->params.names = h->names;
    return PAVE_OK;
}

static pave_result read_common(pv_reader *r, head *h)
{
    const uint8_t *start = r->at;
    uint32_t size = pv_word(r), version = pv_word(r);
    for (int i = 0; i < 3; i++) {
        const uint8_t *text = pv_take(r, PV_BTF_TEXT - 1);
        if (text)
            memcpy(h->text[i], text, PV_BTF_TEXT - 1);
    }
    h->params.pixels_per_mm = pv_real(r);
    for (int i = 0; i < 3; i++)
        h->rgb_scale[i] = pv_real(r);
    if (!r->cut && (version < 1 || version > 4))
        return pv_fail(r->context, PAVE_ERR_UNSUPPORTED, "%s: is a BTF file of version %u, and 1 to 4 are read",
                       r->path, (unsigned)version);
    h->params.cosine = version > 1 ? pv_word(r) != 0 : 0;
    h->notes_length = version > 2 ? pv_word(r) : 0;
    h->notes = pv_take(r, h->notes_length);
    h->params.channels = 3;
    pave_result result = version > 3 ? read_names(r, h) : PAVE_OK;
    if (result || r->cut)
        return result ? result : check_cut(r);
    if (!(h->params.pixels_per_mm >= 0) || isinf(h->params.pixels_per_mm))
        h->params.pixels_per_mm = 0;
    return (size_t)(r->at - start) == size ? PAVE_OK : damaged(r, "its header has not the size that it says");
}

static pave_result read_lights(pv_reader *r, head *h, uint32_t view)
{
    uint32_t count = pv_word(r);
    pave_result result = PAVE_OK;
    if (!r->cut && !count)
        return damaged(r, "a view has no lights");
    if (view && !r->cut && (int32_t)count != h->params.lights)
        return pv_fail(r->context, PAVE_ERR_UNSUPPORTED, "%s: its views have different lights", r->path);
    if (r->cut || (uint64_t)count * 8 > pv_left(r))
        return damaged(r, "it is cut short");
    if (!view) {
        h->params.lights = (int32_t)count;
        h->lights = pv_allocate(r->context, count, sizeof *h->lights, &result);
    }
    for (uint32_t l = 0; l < count && !result; l++) {
        float theta = pv_real(r), phi = pv_real(r);
        if (!view)
            h->lights[l] = (pave_direction){ theta, phi };
        else if (!(fabsf(theta - h->lights[l].theta) < 1e-4f) || !(fabsf(phi - h->lights[l].phi) < 1e-4f))
            result = pv_fail(r->context, PAVE_ERR_UNSUPPORTED, "%s: its views have different lights", r->path);
    }
    return result;
}

static pave_result read_sampling(pv_reader *r, head *h)
{
    uint32_t count = pv_word(r);
    pave_result result = PAVE_OK;
    if (r->cut || (uint64_t)count * 12 > pv_left(r))
        return damaged(r, "it is cut short");
    h->params.views = (int32_t)count;
    h->views = pv_allocate(r->context, count, sizeof *h->views, &result);
    for (uint32_t v = 0; v < count && !result; v++) {
        h->views[v].theta = pv_real(r);
        h->views[v].phi = pv_real(r);
        result = read_lights(r, h, v);
    }
    h->params.view_directions = h->views;
    h->params.light_directions = h->lights;
    return result;
}

static pave_result read_size(pv_reader *r, head *h)
{
    uint32_t width = pv_word(r), height = pv_word(r);
    if (r->cut)
        return check_cut(r);
    if (width > INT32_MAX || height > INT32_MAX)
        return damaged(r, "its sides are beyond all measure");
    h->params.width = (int32_t)width;
    h->params.height = (int32_t)height;
    return PAVE_OK;
}

static void walk_matrix(pv_reader *r)
{
    uint64_t size = pv_byte(r), k = pv_word(r), rows = pv_word(r), columns = pv_word(r);
    if (k > 65536 || size > 8)
        r->cut = 1;
    pv_take(r, (1 + rows + columns) * k * size);
}

/* Does a body that begins here end with the file? */
static int body_fits(pv_reader r, const head *h)
{
    int32_t planes = h->signature->is == DFMF ? h->params.channels : 1;
    if (h->signature->is == BDI) {
        while (!r.cut && r.at != r.end)
            pv_take(&r, pv_word(&r));
        return !r.cut;
    }
    if (h->signature->is == DFMF)
        pv_take(&r, 56);
    else if (h->signature->is == FMF_EXTENDED) {
        uint8_t version = pv_byte(&r);
        pv_take(&r, version >= 1 ? 4 : 0);
        uint64_t width = version >= 2 ? pv_word(&r) : 0, height = version >= 2 ? pv_word(&r) : 0;
        pv_take(&r, height && width < UINT64_MAX / 2 / height ? width * height * 2 : 0);
    }
    if (h->signature->is != DFMF)
        pv_word(&r);
    for (int32_t c = 0; c < planes; c++)
        walk_matrix(&r);
    return !r.cut && r.at == r.end;
}

/* Local frames are not used. Readers disagree on how large one is, 3 or 9 numbers: the file's end tells. */
static pave_result skip_rotations(pv_reader *r, const head *h)
{
    uint32_t count = pv_word(r);
    if (r->cut || !count)
        return check_cut(r);
    for (uint64_t each = 12; each <= 36; each += 24) {
        pv_reader after = *r;
        pv_take(&after, each * count);
        if (!after.cut && body_fits(after, h)) {
            *r = after;
            return PAVE_OK;
        }
    }
    return damaged(r, "its local frames have not the size that they say");
}

static pave_result new_btf(const pv_reader *r, const head *h, pave_btf **out)
{
    pave_result result = pv_btf_new(r->context, &h->params, out);
    if (result)
        return result;
    pave_btf *btf = *out;
    memcpy(btf->setup, h->text[0], PV_BTF_TEXT);
    memcpy(btf->sensor, h->text[1], PV_BTF_TEXT);
    memcpy(btf->source, h->text[2], PV_BTF_TEXT);
    memcpy(btf->rgb_scale, h->rgb_scale, sizeof btf->rgb_scale);
    if (h->notes_length) {
        btf->notes = pv_allocate_zeroed(r->context, (size_t)h->notes_length + 1, 1, &result);
        if (!result)
            memcpy(btf->notes, h->notes, h->notes_length);
    }
    return result;
}

static double scalar(const uint8_t *p, uint8_t size)
{
    uint16_t half;
    float single;
    double value;
    switch (size) {
    case 2: return memcpy(&half, p, 2), (double)pv_half_value(half);
    case 4: return memcpy(&single, p, 4), (double)single;
    default: return memcpy(&value, p, 8), value;
    }
}

static pave_result read_scalars(pv_reader *r, uint8_t size, uint64_t count, float *out)
{
    const uint8_t *from = pv_take(r, count * size);
    if (!from)
        return check_cut(r);
    for (uint64_t i = 0; i < count; i++) {
        double value = scalar(from + i * size, size);
        if (!(fabs(value) <= 3e38))
            return damaged(r, "a factor is not a number");
        out[i] = (float)value;
    }
    return PAVE_OK;
}

/* The factors of one matrix. Some files hold it the other way round, a texture in each column. */
static pave_result read_factors(pv_reader *r, uint8_t size, uint32_t components, uint32_t rows, uint32_t columns,
                                int32_t plane, pave_btf *btf)
{
    uint64_t wanted_rows = (uint64_t)pv_btf_rows(btf), texels = (uint64_t)pv_btf_texels(btf), k = components;
    if (r->cut)
        return check_cut(r);
    int turned = rows == texels && columns == wanted_rows && rows != columns;
    if (size != 2 && size != 4 && size != 8)
        return damaged(r, "its numbers have an unknown size");
    if (!turned && (rows != wanted_rows || columns != texels))
        return damaged(r, "a matrix does not have the size that directions and texels make");
    if (!k || k > 65536 || (1 + wanted_rows + texels) * k > pv_left(r) / size)
        return damaged(r, "it is cut short");
    pave_result result = pv_btf_allocate_factors(r->context, btf, plane, (int32_t)components);
    if (result)
        return result;
    pv_factors *f = &btf->factors[plane];
    result = read_scalars(r, size, k, f->singular);
    if (!result)
        result = read_scalars(r, size, rows * k, turned ? f->right : f->left);
    if (!result)
        result = read_scalars(r, size, columns * k, turned ? f->left : f->right);
    btf->factor_type = size == 2 ? PAVE_F16 : PAVE_F32;
    return result;
}

static pave_result read_dfmf(pv_reader *r, pave_btf *btf)
{
    pv_word(r); /* the most components of a channel: said again by each */
    btf->colour = (int32_t)pv_word(r);
    for (int i = 0; i < 12; i++)
        btf->colour_space[i] = pv_real(r);
    pave_result result = check_cut(r);
    if (!result && !pv_colour_known(btf->colour))
        result = pv_fail(r->context, PAVE_ERR_UNSUPPORTED, "%s: its colour model %d is not read", r->path,
                         (int)btf->colour);
    if (!result && btf->channels != 3 && pv_colour_is_triple(btf->colour))
        result = damaged(r, "its colour model is for three channels");
    for (int32_t c = 0; c < btf->channels && !result; c++) {
        uint8_t size = pv_byte(r);
        uint32_t k = pv_word(r), rows = pv_word(r), columns = pv_word(r);
        result = read_factors(r, size, k, rows, columns, c, btf);
    }
    return result;
}

/* The height map that some files carry is skipped. */
static pave_result read_extension(pv_reader *r, pave_btf *btf)
{
    uint8_t version = pv_byte(r);
    if (version > 2)
        return pv_fail(r->context, PAVE_ERR_UNSUPPORTED, "%s: its extended header has version %d, and 0 to 2 are read",
                       r->path, version);
    btf->colour = version >= 1 && pv_word(r) ? PV_COLOUR_LOG : PV_COLOUR_RGB;
    uint64_t width = version >= 2 ? pv_word(r) : 0, height = version >= 2 ? pv_word(r) : 0;
    if (width && height > pv_left(r) / 2 / width)
        return damaged(r, "it is cut short");
    pv_take(r, width * height * 2);
    return check_cut(r);
}

static pave_result read_fmf(pv_reader *r, kind is, pave_btf *btf)
{
    btf->joint = 1;
    btf->colour = PV_COLOUR_RGB;
    pave_result result = is == FMF_EXTENDED ? read_extension(r, btf) : PAVE_OK;
    if (result)
        return result;
    pv_word(r); /* components: said again */
    uint8_t size = pv_byte(r);
    uint32_t k = pv_word(r), rows = pv_word(r), columns = pv_word(r);
    return read_factors(r, size, k, rows, columns, 0, btf);
}

/* Texels that were left out have no place in a sparse file. */
static pave_result place_texels(pv_reader *r, const uint8_t *mask, pave_btf *btf)
{
    pave_result result = PAVE_OK;
    int64_t texels = pv_btf_texels(btf);
    int32_t *slots = pv_allocate(r->context, (size_t)texels, sizeof *slots, &result), next = 0;
    for (int64_t i = 0; i < texels && !result; i++)
        slots[i] = mask[i] ? next++ : -1;
    btf->samples.slots = slots;
    return result;
}

static pave_result check_chunks(pv_reader *r, const pave_btf *btf, uint64_t stored)
{
    const pv_samples *s = &btf->samples;
    for (uint64_t done = 0; done < stored; done += (uint64_t)s->chunk) {
        uint64_t here = stored - done < (uint64_t)s->chunk ? stored - done : (uint64_t)s->chunk;
        uint32_t size = pv_word(r);
        if (!r->cut && size != here * s->texel_bytes)
            return damaged(r, "a chunk does not have the size that its texels make");
        pv_take(r, size);
    }
    return check_cut(r);
}

static pave_result read_bdi(pv_reader *r, pave_btf *btf, uint32_t lines, uint8_t compression, const uint8_t *mask)
{
    uint64_t texels = (uint64_t)pv_btf_texels(btf), stored = texels;
    pave_result result = PAVE_OK;
    if (compression != 0 && compression != 2)
        return pv_fail(r->context, PAVE_ERR_UNSUPPORTED, "%s: its chunks are compressed with bzip2, which is not read",
                       r->path);
    if (compression == 2)
        result = place_texels(r, mask, btf);
    for (uint64_t i = 0; i < texels && compression == 2; i++)
        stored -= !mask[i];
    if (!lines || lines > (uint32_t)btf->height)
        lines = (uint32_t)btf->height;
    btf->samples.texel_bytes = (size_t)pv_btf_length(btf) * 2;
    btf->samples.chunk = (int32_t)((uint64_t)lines * (uint64_t)btf->width < INT32_MAX ? (int32_t)lines * btf->width
                                                                                      : INT32_MAX);
    btf->samples.gap = 4;
    btf->samples.first = r->at + 4;
    if ((double)stored * (double)btf->samples.texel_bytes > (double)pv_left(r))
        return damaged(r, "it is cut short");
    return result ? result : check_chunks(r, btf, stored);
}

static pave_result read_body(pv_reader *r, head *h, int *keeps, pave_btf **out)
{
    int bdi = h->signature->is == BDI;
    uint32_t lines = bdi ? pv_word(r) : 0;
    uint8_t compression = bdi ? pv_byte(r) : 0;
    const uint8_t *mask = bdi ? pv_take(r, (uint64_t)h->params.width * (uint64_t)h->params.height) : NULL;
    pave_result result = check_cut(r);
    if (!result && h->signature->rotations)
        result = skip_rotations(r, h);
    if (!result)
        result = new_btf(r, h, out);
    if (result)
        return result;
    *keeps = bdi;
    result = bdi ? read_bdi(r, *out, lines, compression, mask)
                 : h->signature->is == DFMF ? read_dfmf(r, *out) : read_fmf(r, h->signature->is, *out);
    if (!result && r->at != r->end)
        result = damaged(r, "something follows its end");
    return result;
}

pave_result pv_bonn_read(pave_context *context, const char *path, const uint8_t *bytes, size_t size, int *keeps,
                         pave_btf **out)
{
    head h = { .signature = find_signature(bytes, size), .params = PAVE_BTF_PARAMS_INIT };
    pv_reader r = pv_reader_of(context, path, bytes, size);
    r.at += strlen(h.signature->text);
    *keeps = 0;
    if (h.signature->is == PVF)
        return pv_fail(context, PAVE_ERR_UNSUPPORTED, "%s: is a PVF file (factored view by view), which is not read",
                       path);
    pave_result result = read_common(&r, &h);
    if (!result)
        result = read_sampling(&r, &h);
    if (!result)
        result = read_size(&r, &h);
    if (!result)
        result = read_body(&r, &h, keeps, out);
    pv_release(h.views);
    pv_release(h.lights);
    if (result)
        pave_btf_free(out);
    return result;
}
