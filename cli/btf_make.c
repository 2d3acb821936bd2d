/* The verbs of pave btf that make one: synthesize, compress, convert, merge. */
#include "btf.h"

#include <stdlib.h>

/* Samples are made as the file is written, so that it may be larger than memory. */
int btf_synthesize(int argc, char **argv)
{
    pave_btf_synthesis_params params = PAVE_BTF_SYNTHESIS_PARAMS_INIT;
    pave_btf *btf = NULL;
    btf_job job = { .command = {
        .verb = "btf synthesize",
        .usage = "-o FILE [options]",
        .summary = "Makes the BTF of a relief of stone: masking, parallax, shadows and bounces are ray-cast.",
        .outputs = "write material.bdi, a folder/ or material.exr",
    } };
    params.stored = 0;
    int status = btf_begin(&job, (cli_group){ "Material", PAVE_PARAMS_BTF_SYNTHESIS, &params }, argc, argv);
    phase(0, 0.2);
    if (!status)
        status = exit_code(pave_btf_synthesize(job.context, &params, &btf), WHILE_WORKING);
    if (!status)
        status = btf_write(&job, btf, 0.2);
    pave_btf_free(&btf);
    return btf_end(&job, status);
}

int btf_compress(int argc, char **argv)
{
    static const char *const channels[3] = { "components", "second", "third" };
    pave_btf_compress_params params = PAVE_BTF_COMPRESS_PARAMS_INIT;
    const cli_group group = { "Compression", PAVE_PARAMS_BTF_COMPRESS, &params };
    pave_btf *btf = NULL, *small = NULL;
    cli_named list = { .usage = "components N,N,N", .help = "of log Y, U/Y and V/Y, or one N of all", .most = 1 };
    btf_job job = { .command = {
        .verb = "btf compress",
        .usage = "BTF -o FILE.btf [options]",
        .summary = "Factors a BTF: a few components stand for all its samples, with a known error.",
        .outputs = "write small.btf",
        .inputs = 1,
        .named = &list,
        .named_count = 1,
    } };
    int status = btf_begin(&job, group, argc, argv);
    if (!status)
        status = btf_set_list(&job, &list, &group, channels, 3, 1);
    if (!status)
        status = btf_read(&job, 0, 0, 0.02, &btf);
    phase(0.02, 0.95);
    if (!status)
        status = exit_code(pave_btf_compress(job.context, btf, &params, &small), WHILE_WORKING);
    if (!status)
        status = btf_write(&job, small, 0.95);
    pave_btf_free(&small);
    pave_btf_free(&btf);
    return btf_end(&job, status);
}

int btf_convert(int argc, char **argv)
{
    pave_btf *btf = NULL;
    btf_job job = { .command = {
        .verb = "btf convert",
        .usage = "BTF -o FILE",
        .summary = "Writes a BTF in another format.",
        .outputs = "write other.bdi, other.btf, other.exr or a folder/",
        .inputs = 1,
    } };
    int status = btf_begin(&job, (cli_group){ 0 }, argc, argv);
    if (!status)
        status = btf_read(&job, 0, 0, 0.02, &btf);
    if (!status)
        status = btf_write(&job, btf, 0.02);
    pave_btf_free(&btf);
    return btf_end(&job, status);
}

static int merge_all(const btf_job *job, pave_btf **btfs, int32_t components)
{
    int count = job->command.input_count, status = EXIT_FINE;
    pave_btf *merged = NULL;
    for (int i = 0; i < count && !status; i++)
        status = btf_read(job, i, 0.3 * i / count, 0.3 * (i + 1) / count, &btfs[i]);
    phase(0.3, 0.9);
    if (!status)
        status = exit_code(pave_btf_merge(job->context, (const pave_btf *const *)btfs, count, components, &merged),
                           WHILE_WORKING);
    if (!status)
        status = btf_write(job, merged, 0.9);
    pave_btf_free(&merged);
    return status;
}

int btf_merge(int argc, char **argv)
{
    double components = 2048;
    cli_named most = { .usage = "components N", .help = "of the basis, at most [2048]", .most = 1 };
    btf_job job = { .command = {
        .verb = "btf merge",
        .usage = "A.btf B.btf ... -o FILE.btf [--components N]",
        .summary = "Finds one basis for several factored materials, which come to lie below each other.",
        .outputs = "write all.btf",
        .inputs = -1,
        .named = &most,
        .named_count = 1,
    } };
    int status = btf_begin(&job, (cli_group){ 0 }, argc, argv);
    if (!status)
        status = btf_read_number(&job, &most, 1, 1 << 20, &components);
    pave_btf **btfs = status ? NULL : calloc((size_t)job.command.input_count, sizeof *btfs);
    if (!status)
        status = btfs ? merge_all(&job, btfs, (int32_t)components) : EXIT_RESOURCES;
    for (int i = 0; btfs && i < job.command.input_count; i++)
        pave_btf_free(&btfs[i]);
    free(btfs);
    return btf_end(&job, status);
}
