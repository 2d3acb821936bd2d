/* pave lay: from a drawing to stones. */
#include "cli.h"

#include <stdlib.h>

/* One window of a plan: all that it follows from stands there. */
static int run_shard(const cli_command *command, pave_context *context)
{
    char *end;
    long shard = command->shard ? strtol(command->shard, &end, 10) : -1;
    if (!command->shard || end == command->shard || *end || shard < 0 || shard > INT32_MAX) {
        complain(command, "--manifest needs --shard and a number from 0");
        return EXIT_USAGE;
    }
    const char *output = command->output_count ? command->output[0] : NULL;
    pave_result result = pave_lay_shard(context, command->manifest, (int32_t)shard, output);
    return exit_code(result, result == PAVE_ERR_IO ? WHILE_READING : WHILE_WORKING);
}

static int check_outputs(const cli_command *command, const pave_stream_params *stream)
{
    for (int i = 0; i < command->output_count; i++)
        if (!pave_stones_format(command->output[i])) {
            complain(command, "%s: an output ends in .svg, .png, .json or .stones", command->output[i]);
            return EXIT_USAGE;
        }
    if (command->manifest || command->output_count || (command->wants_json && !stream->memory))
        return EXIT_FINE;
    complain(command, "where to? give -o FILE or --json");
    return EXIT_USAGE;
}

/* Window after window, for drawings and pavements beyond memory. */
static int run_stream(const cli_command *command, pave_context *context, const pave_lay_params *params,
                      const pave_stream_params *stream)
{
    pave_result result = pave_lay_file(context, command->input[0], params, stream, command->output,
                                       command->output_count);
    return exit_code(result, WHILE_WORKING);
}

static int run(const cli_command *command, pave_context *context, const pave_lay_params *params)
{
    pave_image *drawing = NULL;
    pave_stones *stones = NULL;
    phase(0, 0.05);
    pave_result result = read_image(context, command->input[0], &drawing);
    if (result)
        return exit_code(result, WHILE_READING);
    phase(0.05, 0.9);
    result = pave_lay(context, drawing, params, &stones);
    pave_image_free(&drawing);
    if (result)
        return exit_code(result, WHILE_WORKING);
    int status = write_stones(command, context, stones);
    pave_stones_free(&stones);
    return status;
}

int lay_main(int argc, char **argv)
{
    lay_options options;
    cli_command command = {
        .verb = "lay",
        .usage = "DRAWING -o FILE [-o FILE ...] [options]",
        .summary = "Lays a pavement: turns a black and white drawing into the polygons of its stones.",
        .outputs = "write stones.svg, a picture.png, a report.json or a part.stones; repeatable;\n"
                   "                               - is stdout, as SVG",
        .json = "write the report to stdout",
        .inputs = 1,
        .plans = 1,
        .shards = 1,
        .groups = options.groups,
        .group_count = LAY_GROUPS,
    };
    lay_options_init(&options);
    int status = read_command(&command, argc, argv);
    if (!status)
        status = check_outputs(&command, &options.stream);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    int windows = options.stream.memory || command.manifest;
    if (!options.limits.max_pixels)
        options.limits.max_pixels = windows ? (int64_t)1 << 40 : (int64_t)1 << 28;
    pave_context *context = start(&command, &options.context);
    if (!context)
        return EXIT_USAGE;
    if (command.manifest)
        status = run_shard(&command, context);
    else if (windows)
        status = run_stream(&command, context, &options.lay, &options.stream);
    else
        status = run(&command, context, &options.lay);
    finish(&context);
    return status;
}
