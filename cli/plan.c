/* pave plan: a large pavement divided into windows, for many machines. */
#include "cli.h"

#include <stdio.h>

static int run(const cli_command *command, pave_context *context, const pave_lay_params *params,
               const pave_stream_params *stream)
{
    int32_t windows = 0;
    pave_result result = pave_plan(context, command->input[0], params, stream, command->output[0], &windows);
    if (!result)
        printf("%d\n", (int)windows);
    return exit_code(result, result == PAVE_ERR_IO ? WHILE_READING : WHILE_WORKING);
}

int plan_main(int argc, char **argv)
{
    lay_options options;
    cli_command command = {
        .verb = "plan",
        .usage = "DRAWING -o PLAN.json [--memory N] [options]",
        .summary = "Divides a pavement into windows that can be laid one by one, anywhere, in any order:\n"
                   "pave lay --manifest PLAN.json --shard 0 (1, 2 ...), then pave merge --manifest PLAN.json.\n"
                   "Prints the number of windows. --memory is what one of them may take.",
        .outputs = "where the plan goes",
        .inputs = 1,
        .groups = options.groups,
        .group_count = LAY_GROUPS,
    };
    lay_options_init(&options);
    int status = read_command(&command, argc, argv);
    if (!status && command.output_count != 1)
        complain(&command, "where to? give one -o PLAN.json"), status = EXIT_USAGE;
    if (status)
        return status < 0 ? EXIT_FINE : status;
    if (!options.limits.max_pixels)
        options.limits.max_pixels = (int64_t)1 << 40;
    pave_context *context = start(&command, &options.context);
    if (!context)
        return EXIT_USAGE;
    status = run(&command, context, &options.lay, &options.stream);
    finish(&context);
    return status;
}
