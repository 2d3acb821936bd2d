/* pave merge: windows that were laid one by one, into one file. */
#include "cli.h"

static int run(const cli_command *command, pave_context *context)
{
    pave_result result = PAVE_OK;
    if (command->manifest) {
        result = pave_plan_merge(context, command->manifest, command->output, command->output_count);
        return exit_code(result, WHILE_WRITING);
    }
    const char *const *parts = (const char *const *)command->input;
    for (int i = 0; i < command->output_count && !result; i++)
        result = pave_stones_merge(context, parts, command->input_count, command->output[i], NULL);
    if (!result && command->wants_json)
        result = pave_stones_merge(context, parts, command->input_count, "-", "json");
    return exit_code(result, result == PAVE_ERR_IO ? WHILE_READING : WHILE_WRITING);
}

int merge_main(int argc, char **argv)
{
    pave_limits limits = PAVE_LIMITS_INIT;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    const cli_group groups[] = { { "Limits", PAVE_PARAMS_LIMITS, &limits } };
    cli_command command = {
        .verb = "merge",
        .usage = "PART.stones ... | --manifest PLAN.json -o FILE [-o FILE ...]",
        .summary = "Merges windows of one pavement, each written by pave lay --window ... -o PART.stones, or all\n"
                   "those of a plan, into one file: the same bytes as from the whole at once.",
        .outputs = "write stones.svg, a report.json or whole.stones; repeatable; - is stdout, as SVG",
        .json = "write the report to stdout",
        .inputs = -1,
        .plans = 1,
        .groups = groups,
        .group_count = 1,
    };
    params.limits = &limits;
    int status = read_command(&command, argc, argv);
    if (!status && command.manifest && (command.wants_json || !command.output_count))
        complain(&command, "--manifest needs -o FILE; -o FILE.json is the report"), status = EXIT_USAGE;
    if (!status && !command.output_count && !command.wants_json)
        complain(&command, "where to? give -o FILE or --json"), status = EXIT_USAGE;
    if (status)
        return status < 0 ? EXIT_FINE : status;
    pave_context *context = start(&command, &params);
    if (!context)
        return EXIT_USAGE;
    status = run(&command, context);
    finish(&context);
    return status;
}
