/* The verbs of pave btf that make sparse ones whole: plan, reconstruct. */
#include "btf.h"

#include <stdio.h>

static int read_model(const btf_job *job, pave_btf_model **out)
{
    phase(0, 0.1);
    return exit_code(pave_btf_model_read(job->context, job->command.input[0], out), WHILE_READING);
}

/* Of a BTF that is not a model: what its own texels have to say, and no patches, for no prior of a class is known. */
static int model_sample(const btf_job *job, pave_btf_model **out)
{
    pave_btf_model_params params = PAVE_BTF_MODEL_PARAMS_INIT;
    pave_btf *sample = NULL;
    params.patch = 1;
    params.validate = 0;
    params.symmetric = 0;
    int status = btf_read(job, 0, 0, 0.05, &sample);
    phase(0.05, 0.6);
    if (!status)
        status = exit_code(pave_btf_model_create(job->context, (const pave_btf *const *)&sample, 1, &params, out),
                           WHILE_WORKING);
    pave_btf_free(&sample);
    return status;
}

int btf_plan(int argc, char **argv)
{
    pave_btf_plan_params params = PAVE_BTF_PLAN_PARAMS_INIT;
    pave_btf_model *model = NULL;
    pave_btf_plan *plan = NULL;
    btf_job job = { .command = {
        .verb = "btf plan",
        .usage = "FILE.model|SAMPLE -o FILE.csv [options]",
        .summary = "Chooses which pairs of view and light to measure, and in which order: by a model of a class, or by "
                   "a\nsample of what is to be enlarged.",
        .outputs = "write plan.csv; - is standard output",
        .inputs = 1,
    } };
    int status = btf_begin(&job, (cli_group){ "Plan", PAVE_PARAMS_BTF_PLAN, &params }, argc, argv);
    if (!status)
        status = btf_names_model(job.command.input[0]) ? read_model(&job, &model) : model_sample(&job, &model);
    phase(0.6, 0.95);
    if (!status)
        status = exit_code(pave_btf_plan_create(job.context, model, &params, &plan), WHILE_WORKING);
    phase(0.95, 1);
    if (!status)
        status = exit_code(pave_btf_plan_write(job.context, plan, job.command.output[0]), WHILE_WRITING);
    double before = 0, after = 0;
    if (plan)
        pave_btf_plan_condition(plan, &before, &after);
    if (!status && before > 0 && !job.command.quiet)
        fprintf(stderr, "condition number %.6g, before %.6g\n", after, before);
    pave_btf_plan_free(&plan);
    pave_btf_model_free(&model);
    return btf_end(&job, status);
}

static int write_errors(const btf_job *job, const pave_image *errors, const char *path)
{
    return path ? exit_code(pave_image_write(job->context, errors, path), WHILE_WRITING) : EXIT_FINE;
}

int btf_reconstruct(int argc, char **argv)
{
    enum { PLAN, ERRORS, NAMED };
    pave_btf_reconstruct_params params = PAVE_BTF_RECONSTRUCT_PARAMS_INIT;
    pave_btf_model *model = NULL;
    pave_btf *sparse = NULL, *whole = NULL;
    pave_btf_plan *plan = NULL;
    pave_image *errors = NULL;
    cli_named named[NAMED] = {
        [PLAN] = { .usage = "plan FILE.csv", .help = "look at these pairs only", .most = 1 },
        [ERRORS] = { .usage = "errors FILE.exr", .help = "write what error to expect of each texel", .most = 1 },
    };
    btf_job job = { .command = {
        .verb = "btf reconstruct",
        .usage = "FILE.model SPARSE -o FILE [options]",
        .summary = "Makes a whole BTF of one of which some pairs of view and light were measured.",
        .outputs = "write whole.bdi, whole.exr or a folder/",
        .inputs = 2,
        .named = named,
        .named_count = NAMED,
    } };
    int status = btf_begin(&job, (cli_group){ "Reconstruction", PAVE_PARAMS_BTF_RECONSTRUCT, &params }, argc, argv);
    if (!status)
        status = read_model(&job, &model);
    if (!status)
        status = btf_read(&job, 1, 0.1, 0.15, &sparse);
    if (!status && named[PLAN].count)
        status = exit_code(pave_btf_plan_read(job.context, model, named[PLAN].value[0], &plan), WHILE_READING);
    phase(0.15, 0.8);
    if (!status)
        status = exit_code(pave_btf_reconstruct(job.context, model, sparse, plan, &params, &whole,
                                                named[ERRORS].count ? &errors : NULL), WHILE_WORKING);
    if (!status)
        status = btf_write(&job, whole, 0.8);
    if (!status)
        status = write_errors(&job, errors, named[ERRORS].value[0]);
    pave_btf_plan_free(&plan);
    pave_image_free(&errors);
    pave_btf_free(&whole);
    pave_btf_free(&sparse);
    pave_btf_model_free(&model);
    return btf_end(&job, status);
}
