/* The verbs of pave btf that tell of one: info, measure. */
#include "btf.h"

#include <string.h>

static const char *format_of(const btf_job *job)
{
    return job->command.wants_json ? "json" : "text";
}

static pave_result draw_albedo(pave_context *context, const pave_btf *btf, const char *path)
{
    pave_image *picture = NULL;
    pave_result result = path ? pave_btf_albedo(context, btf, &picture) : PAVE_OK;
    if (!result && path)
        result = pave_image_write(context, picture, path);
    pave_image_free(&picture);
    return result;
}

int btf_names_model(const char *path)
{
    const char *point = strrchr(path, '.');
    return point && !strcmp(point, ".model");
}

static int tell_model(const btf_job *job)
{
    pave_btf_model *model = NULL;
    int status = exit_code(pave_btf_model_read(job->context, job->command.input[0], &model), WHILE_READING);
    if (!status)
        status = exit_code(pave_btf_model_info_write(job->context, model, "-", format_of(job)), WHILE_WRITING);
    pave_btf_model_free(&model);
    return status;
}

int btf_info(int argc, char **argv)
{
    pave_btf_texels_params texels = PAVE_BTF_TEXELS_PARAMS_INIT;
    pave_btf_diagnosis diagnosis = { .size = sizeof diagnosis };
    pave_btf *btf = NULL;
    cli_named picture = { .usage = "picture FILE.png", .help = "draw the albedo", .most = 1 };
    btf_job job = { .command = {
        .verb = "btf info",
        .usage = "BTF|FILE.model [--json] [--picture ALBEDO.png]",
        .summary = "Tells what a BTF holds and how sound it is: reciprocity, albedo, saturation, missing pairs.",
        .json = "as JSON",
        .inputs = 1,
        .named = &picture,
        .named_count = 1,
    } };
    int status = btf_begin(&job, (cli_group){ "Diagnosis", PAVE_PARAMS_BTF_TEXELS, &texels }, argc, argv);
    if (!status && btf_names_model(job.command.input[0]))
        return btf_end(&job, tell_model(&job));
    if (!status)
        status = btf_read(&job, 0, 0, 0.1, &btf);
    phase(0.1, 1);
    if (!status)
        status = exit_code(pave_btf_diagnose(job.context, btf, &texels, &diagnosis), WHILE_WORKING);
    if (!status)
        status = exit_code(pave_btf_diagnosis_write(job.context, btf, &diagnosis, "-", format_of(&job)),
                           WHILE_WRITING);
    if (!status)
        status = exit_code(draw_albedo(job.context, btf, picture.value[0]), WHILE_WRITING);
    pave_btf_free(&btf);
    return btf_end(&job, status);
}

int btf_measure(int argc, char **argv)
{
    pave_btf_measure_params texels = PAVE_BTF_MEASURE_PARAMS_INIT;
    pave_btf_difference difference = { .size = sizeof difference };
    pave_btf *btf[2] = { NULL, NULL };
    btf_job job = { .command = {
        .verb = "btf measure",
        .usage = "A B [--json]",
        .summary = "Tells how far A is from B, which it stands for: errors of ABRDFs, linear, in logarithms, relative.",
        .json = "as JSON",
        .inputs = 2,
    } };
    int status = btf_begin(&job, (cli_group){ "Comparison", PAVE_PARAMS_BTF_MEASURE, &texels }, argc, argv);
    for (int i = 0; i < 2 && !status; i++)
        status = btf_read(&job, i, 0.1 * i, 0.1 * (i + 1), &btf[i]);
    phase(0.2, 1);
    if (!status)
        status = exit_code(pave_btf_measure(job.context, btf[0], btf[1], &texels, &difference), WHILE_WORKING);
    if (!status)
        status = exit_code(pave_btf_difference_write(job.context, &difference, "-", format_of(&job)), WHILE_WRITING);
    pave_btf_free(&btf[0]);
    pave_btf_free(&btf[1]);
    return btf_end(&job, status);
}
