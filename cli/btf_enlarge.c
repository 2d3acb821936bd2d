/* pave btf enlarge: a whole BTF from a complete one of a small region and a few photographs. */
#include "btf.h"

/* Photographs, and the one under even light. */
typedef struct given {
    pave_btf *sample, *photographs;
    pave_image *mean;
} given;

static int read_given(const btf_job *job, const cli_named *constraints, const cli_named *mean, given *out)
{
    int status = btf_read(job, 0, 0, 0.02, &out->sample);
    phase(0.02, 0.05);
    if (!status && constraints->count)
        status = exit_code(pave_btf_read(job->context, constraints->value[0], &job->files, &out->photographs),
                           WHILE_READING);
    if (!status && mean->count)
        status = exit_code(pave_image_read(job->context, mean->value[0], &out->mean), WHILE_READING);
    return status;
}

static int write_result(const btf_job *job, const pave_btf *whole, const pave_btf_enlargement *report)
{
    int status = btf_write(job, whole, 0.95);
    if (!status && (job->command.wants_json || !job->command.quiet))
        status = exit_code(pave_btf_enlargement_write(job->context, report, "-",
                                                      job->command.wants_json ? "json" : "text"), WHILE_WRITING);
    return status;
}

int btf_enlarge(int argc, char **argv)
{
    enum { CONSTRAINTS, MEAN, NAMED };
    pave_btf_enlarge_params params = PAVE_BTF_ENLARGE_PARAMS_INIT;
    pave_btf_enlargement report = { .size = sizeof report };
    given from = { 0 };
    pave_btf *whole = NULL;
    cli_named named[NAMED] = {
        [CONSTRAINTS] = { .usage = "constraints FOLDER", .help = "photographs of the whole, named by view and light",
                          .most = 1 },
        [MEAN] = { .usage = "mean FILE", .help = "photograph from the top under even light", .most = 1 },
    };
    btf_job job = { .command = {
        .verb = "btf enlarge",
        .usage = "SAMPLE --constraints FOLDER -o FILE [options]",
        .summary = "Makes the BTF of a large piece from one of a small region and a few photographs of all of it.",
        .outputs = "write whole.btf, whole.bdi, whole.exr or a folder/",
        .json = "tell how it came out as JSON",
        .inputs = 1,
        .named = named,
        .named_count = NAMED,
    } };
    int status = btf_begin(&job, (cli_group){ "Enlargement", PAVE_PARAMS_BTF_ENLARGE, &params }, argc, argv);
    if (!status)
        status = read_given(&job, &named[CONSTRAINTS], &named[MEAN], &from);
    phase(0.05, 0.95);
    if (!status)
        status = exit_code(pave_btf_enlarge(job.context, from.sample, from.photographs, NULL, from.mean, &params,
                                            &whole, &report), WHILE_WORKING);
    if (!status)
        status = write_result(&job, whole, &report);
    pave_btf_free(&whole);
    pave_btf_free(&from.photographs);
    pave_btf_free(&from.sample);
    pave_image_free(&from.mean);
    return btf_end(&job, status);
}
