/* What was found out about BTFs, as JSON and as lines to read. */
#include <pave/io.h>

#include "btf/model.h"
#include "io/output.h"
#include "util/json.h"
#include "util/text.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Numbers go out twice: as members of an object, or as lines with words. */
typedef struct telling {
    pv_output *output;
    pv_json json;
    int as_json;
} telling;

static void tell(telling *t, const char *name, double value, const char *words)
{
    char number[40], line[200];
    if (t->as_json) {
        pv_json_number(&t->json, name, value);
        return;
    }
    pv_text_number(number, sizeof number, value == 0 ? 0 : round(value * 1e6) / 1e6);
    snprintf(line, sizeof line, "%-16s %12s  %s\n", name, isnan(value) ? "-" : number, words);
    pv_output_text(t->output, line);
}

static const char *set_name(int32_t set)
{
    return set == PAVE_DIRECTIONS_UBO81 ? "ubo81" : set == PAVE_DIRECTIONS_DOME151 ? "dome151" : "other";
}

static void tell_text(telling *t, const char *name, const char *value, const char *words)
{
    char line[200];
    if (t->as_json) {
        pv_json_string(&t->json, name, value);
        return;
    }
    snprintf(line, sizeof line, "%-16s %12.40s  %s\n", name, value, words);
    pv_output_text(t->output, line);
}

static void tell_channels(telling *t, const pave_btf *btf)
{
    if (t->as_json)
        pv_json_array(&t->json, "channels");
    for (int32_t c = 0; c < btf->channels; c++) {
        if (t->as_json)
            pv_json_object(&t->json, NULL);
        tell_text(t, "name", btf->names[c], "channel");
        tell(t, "components", pave_btf_components(btf, c), "of its factors; 0: samples as they are");
        tell(t, "error", pave_btf_error(btf, c), "relative, of its factors, if pave made them just now");
        if (t->as_json)
            pv_json_close(&t->json);
    }
    if (t->as_json)
        pv_json_close(&t->json);
}

static void tell_diagnosis(telling *t, const pave_btf *btf, const pave_btf_diagnosis *d)
{
    double samples = (double)d->samples;
    tell(t, "width", btf->width, "texels");
    tell(t, "height", btf->height, "texels");
    tell(t, "views", btf->views.count, "directions");
    tell_text(t, "view_set", set_name(d->view_set), "they are of");
    tell(t, "lights", btf->lights.count, "directions");
    tell_text(t, "light_set", set_name(d->light_set), "they are of");
    tell(t, "cosine", btf->cosine, "1: samples hold the cosine of the light");
    tell(t, "pixels_per_mm", btf->pixels_per_mm, "0: not known");
    tell(t, "texels", (double)d->texels, "of them looked at");
    tell(t, "missing", (double)d->missing, "pairs of view and light without samples");
    tell(t, "not_finite", (double)d->not_finite, "samples are no numbers");
    tell(t, "negative", (double)d->negative / samples, "of the samples are below 0");
    tell(t, "saturated", (double)d->saturated / samples, "of the samples are the greatest of their channel");
    tell(t, "least", d->least, "sample");
    tell(t, "greatest", d->greatest, "sample");
    tell(t, "mean", d->mean, "sample");
    tell(t, "reciprocity", d->reciprocity, "rms error of the mean over texels, of its rms");
    tell(t, "albedo", d->albedo, "mean over texels, views and channels");
    tell(t, "albedo_over", d->albedo_over, "of the albedos are above 1");
    tell_channels(t, btf);
}

static void tell_difference(telling *t, const pave_btf_difference *d)
{
    tell(t, "texels", (double)d->texels, "looked at");
    tell(t, "rmse", d->rmse, "of an ABRDF, mean over texels");
    tell(t, "rmse_log", d->rmse_log, "of its logarithm");
    tell(t, "relative", d->relative, "of log luminance, in the Frobenius norm");
    tell(t, "whole", d->whole, "what that is over: root mean square of B's log luminance");
    tell(t, "variation", d->variation, "of what texels of B differ from their mean ABRDF");
    tell(t, "centred", d->centred, "the same error over that");
    tell(t, "linear", d->linear, "of luminance as it is, in the Frobenius norm");
    tell(t, "direction_error", d->direction_error, "degrees, the greatest between directions");
}

static void tell_enlargement(telling *t, const pave_btf_enlargement *e)
{
    tell(t, "photographs", e->photographs, "of the whole");
    tell(t, "rounds", e->rounds, "of Texture Optimization and of Algorithm 1");
    tell(t, "explained", e->explained, "of what the sample varies by, predicted from photographs (best mode)");
    tell(t, "expected", e->expected, "root mean square error of a value, as that tells");
    tell(t, "least", e->least, "of that what the components leave of the sample");
    tell(t, "missed", e->missed, "root mean square of what photographs show and the result does not");
    tell(t, "sharpness", e->sharpness, "mean square difference of neighbours, over the sample's");
    tell(t, "spectrum", e->spectrum, "root mean square logarithm of the power of octaves, over the sample's");
    tell(t, "statistics", e->statistics, "relative distance of statistics from the sample's");
}

/* How much of what materials have a basis keeps with its first so many vectors. */
static double kept(const pv_basis *basis, int64_t rows, int32_t count)
{
    double sum = 0, whole = basis->whole * (double)rows;
    for (int32_t k = 0; k < count && k < basis->components; k++)
        sum += (double)basis->deviation[k] * (double)basis->deviation[k];
    return whole > 0 ? sum / whole : 1;
}

static void tell_basis(telling *t, const pave_btf_model *m, int32_t plane, int32_t of)
{
    const pv_basis *basis = &m->basis[plane][of];
    int64_t rows = pv_basis_rows(m, of);
    if (t->as_json)
        pv_json_object(&t->json, of == PV_OF_PATCHES ? "abtf" : "abrdf");
    tell(t, "components", basis->components, of == PV_OF_PATCHES ? "eigen-ABTFs" : "eigen-ABRDFs");
    tell(t, "rms", sqrt(basis->whole), "of a value, less that of a grey plane");
    tell(t, "rms_outside", sqrt(basis->outside), "of what the basis leaves of the materials it was made of");
    tell(t, "kept_by_16", kept(basis, rows, 16), "of the variance");
    tell(t, "kept_by_128", kept(basis, rows, 128), "alike");
    if (t->as_json)
        pv_json_close(&t->json);
}

static void tell_rungs(telling *t, const pave_btf_model *m, int32_t plane)
{
    if (t->as_json)
        pv_json_array(&t->json, "settings");
    for (int32_t k = 0; k < m->rungs; k++) {
        const pv_rung *r = &m->rung[plane][k];
        if (t->as_json)
            pv_json_object(&t->json, NULL);
        tell(t, "samples", r->samples, "measured, of the material that was held out:");
        tell(t, "noise_abrdf", sqrt(r->noise[0]), "expected about the ABRDFs");
        tell(t, "noise_abtf", sqrt(r->noise[1]), "and about the ABTFs");
        tell(t, "share", r->share, "of the ABTFs' prediction, before the ABRDFs'");
        if (t->as_json)
            pv_json_close(&t->json);
    }
    if (t->as_json)
        pv_json_close(&t->json);
}

static void tell_model(telling *t, const pave_btf_model *m)
{
    tell(t, "materials", m->materials, "that it was made of");
    tell(t, "copies", m->symmetry, "of each, mirrored and turned");
    tell(t, "texels", (double)m->texels, "of all");
    tell(t, "patches", (double)m->patches, "of all");
    tell(t, "patch", m->patch, "texels a side");
    tell(t, "views", m->views.count, "directions");
    tell(t, "lights", m->lights.count, "directions");
    tell(t, "epsilon", (double)m->least, "added before logarithms");
    if (t->as_json)
        pv_json_array(&t->json, "channels");
    for (int32_t c = 0; c < m->planes; c++) {
        if (t->as_json)
            pv_json_object(&t->json, NULL);
        for (int32_t of = 0; of < 2; of++)
            if (m->basis[c][of].components)
                tell_basis(t, m, c, of);
        tell_rungs(t, m, c);
        if (t->as_json)
            pv_json_close(&t->json);
    }
    if (t->as_json)
        pv_json_close(&t->json);
}

/* What there is to tell of: one of them. */
typedef struct subject {
    const pave_btf *btf;
    const pave_btf_diagnosis *diagnosis; /* of the BTF */
    const pave_btf_difference *difference;
    const pave_btf_enlargement *enlargement;
    const pave_btf_model *model;
} subject;

static pave_result write_telling(pave_context *context, const char *path, const char *format, const subject *of)
{
    telling t = { .as_json = format && !strcmp(format, "json") };
    int before = errno;
    if (!t.as_json && format && strcmp(format, "text"))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "it is written as \"json\" or \"text\"");
    pave_result result = pv_output_open(context, path, 0, &t.output);
    if (result)
        return result;
    pv_json_begin(&t.json, pv_output_put, t.output);
    if (t.as_json)
        pv_json_object(&t.json, NULL);
    if (of->diagnosis)
        tell_diagnosis(&t, of->btf, of->diagnosis);
    else if (of->model)
        tell_model(&t, of->model);
    else if (of->enlargement)
        tell_enlargement(&t, of->enlargement);
    else
        tell_difference(&t, of->difference);
    if (t.as_json)
        pv_json_close(&t.json);
    result = pv_output_close(t.output, PAVE_OK);
    errno = before;
    return result;
}

pave_result pave_btf_diagnosis_write(pave_context *context, const pave_btf *btf, const pave_btf_diagnosis *given,
                                     const char *path, const char *format)
{
    pave_btf_diagnosis diagnosis;
    if (!context || !btf || !given || !path)
        return PAVE_ERR_ARGUMENT;
    memset(&diagnosis, 0, sizeof diagnosis);
    memcpy(&diagnosis, given, given->size < sizeof diagnosis ? given->size : sizeof diagnosis);
    return write_telling(context, path, format, &(subject){ .btf = btf, .diagnosis = &diagnosis });
}

pave_result pave_btf_difference_write(pave_context *context, const pave_btf_difference *given, const char *path,
                                      const char *format)
{
    pave_btf_difference difference;
    if (!context || !given || !path)
        return PAVE_ERR_ARGUMENT;
    memset(&difference, 0, sizeof difference);
    memcpy(&difference, given, given->size < sizeof difference ? given->size : sizeof difference);
    return write_telling(context, path, format, &(subject){ .difference = &difference });
}

pave_result pave_btf_enlargement_write(pave_context *context, const pave_btf_enlargement *given, const char *path,
                                       const char *format)
{
    pave_btf_enlargement enlargement;
    if (!context || !given || !path)
        return PAVE_ERR_ARGUMENT;
    memset(&enlargement, 0, sizeof enlargement);
    memcpy(&enlargement, given, given->size < sizeof enlargement ? given->size : sizeof enlargement);
    return write_telling(context, path, format, &(subject){ .enlargement = &enlargement });
}

pave_result pave_btf_model_info_write(pave_context *context, const pave_btf_model *model, const char *path,
                                      const char *format)
{
    if (!context || !model || !path)
        return PAVE_ERR_ARGUMENT;
    return write_telling(context, path, format, &(subject){ .model = model });
}
