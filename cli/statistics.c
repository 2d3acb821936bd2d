/* pave statistics: a texture with the statistics of another. */
#include "cli.h"

static int run(const cli_command *command, pave_context *context, const pave_statistics_params *params,
               const pave_statistics_synthesis_params *synthesis)
{
    pave_image *texture = NULL, *made = NULL;
    pave_statistics *statistics = NULL;
    pave_statistics_report report = { .size = sizeof report };
    phase(0, 0.01);
    pave_result result = read_image(context, command->input[0], &texture);
    int status = exit_code(result, WHILE_READING);
    phase(0.01, 0.03);
    if (!result)
        status = exit_code(result = pave_statistics_create(context, texture, params, &statistics), WHILE_WORKING);
    phase(0.03, 0.98);
    if (!result)
        status = exit_code(result = pave_statistics_synthesize(context, statistics, synthesis, &report, &made),
                           WHILE_WORKING);
    phase(0.98, 1);
    for (int i = 0; i < command->output_count && !result; i++)
        status = exit_code(result = pave_image_write(context, made, command->output[i]), WHILE_WRITING);
    if (!result && command->wants_json)
        status = exit_code(pave_statistics_write(context, statistics, synthesis, &report, "-"), WHILE_WRITING);
    pave_image_free(&made);
    pave_statistics_free(&statistics);
    pave_image_free(&texture);
    return status;
}

int statistics_main(int argc, char **argv)
{
    pave_statistics_params statistics = PAVE_STATISTICS_PARAMS_INIT;
    pave_statistics_synthesis_params synthesis = PAVE_STATISTICS_SYNTHESIS_PARAMS_INIT;
    pave_limits limits = PAVE_LIMITS_INIT;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    const cli_group groups[] = {
        { "Texture", PAVE_PARAMS_STATISTICS_SYNTHESIS, &synthesis },
        { "Statistics", PAVE_PARAMS_STATISTICS, &statistics },
        { "Machine", PAVE_PARAMS_CONTEXT, &params },
        { "Limits", PAVE_PARAMS_LIMITS, &limits },
    };
    cli_command command = {
        .verb = "statistics",
        .usage = "TEXTURE [--size WxH] -o FILE [options]",
        .summary = "Makes from noise another texture with the statistics of one (Portilla and Simoncelli 2000).\n"
                   "It repeats without a seam where 2^scales divides its size.",
        .outputs = "write the texture (.png, .tif, .jpg, .exr); repeatable",
        .json = "write to stdout how near each group of statistics came",
        .inputs = 1,
        .groups = groups,
        .group_count = sizeof groups / sizeof *groups,
    };
    params.limits = &limits;
    int status = read_command(&command, argc, argv);
    if (!status && !command.output_count && !command.wants_json)
        complain(&command, "where to? give -o FILE or --json"), status = EXIT_USAGE;
    if (status)
        return status < 0 ? EXIT_FINE : status;
    pave_context *context = start(&command, &params);
    if (!context)
        return EXIT_USAGE;
    status = run(&command, context, &statistics, &synthesis);
    finish(&context);
    return status;
}
