/* pave measure: stones judged against their drawing. */
#include "cli.h"

static pave_result write_measures(const cli_command *command, pave_context *context,
                                  const pave_stones_measures *measures)
{
    const char *format = command->wants_json ? "json" : "text";
    pave_result result = PAVE_OK;
    for (int i = 0; i < command->output_count && !result; i++)
        result = pave_stones_measures_write(context, measures, command->output[i], "json");
    if (!result && (command->wants_json || !command->output_count))
        result = pave_stones_measures_write(context, measures, "-", format);
    return result;
}

/* In the colours asked for, or in those that the stones were laid in. */
static pave_result make_drawing(pave_context *context, const pave_image *image, const pave_threshold_params *threshold,
                                const pave_palette_params *given, const pave_stones *stones, pave_image **out)
{
    pave_palette palette = given->palette.count || given->colours ? given->palette : *pave_stones_palette(stones);
    pave_result result = PAVE_OK;
    if (!palette.count && !given->colours)
        return pave_image_threshold(context, image, threshold, out);
    if (!palette.count)
        result = pave_palette_find(context, image, given->colours, &palette);
    return result ? result : pave_image_quantise(context, image, &palette, out);
}

static int run(const cli_command *command, pave_context *context, const pave_threshold_params *threshold,
               const pave_palette_params *palette, const pave_stones_measure_params *params)
{
    pave_image *image = NULL, *drawing = NULL;
    pave_stones *stones = NULL;
    pave_stones_measures measures = { .size = sizeof measures };
    phase(0, 0.2);
    pave_result result = read_image(context, command->input[0], &image);
    phase(0.2, 0.4);
    if (!result)
        result = pave_stones_read(context, command->input[1], &stones);
    int status = exit_code(result, WHILE_READING);
    phase(0.4, 1);
    if (!result)
        result = make_drawing(context, image, threshold, palette, stones, &drawing);
    if (!result)
        status = exit_code(result = pave_stones_measure(context, drawing, stones, params, &measures), WHILE_WORKING);
    if (!result)
        status = exit_code(write_measures(command, context, &measures), WHILE_WRITING);
    pave_stones_free(&stones);
    pave_image_free(&drawing);
    pave_image_free(&image);
    return status;
}

int measure_main(int argc, char **argv)
{
    pave_threshold_params threshold = PAVE_THRESHOLD_PARAMS_INIT;
    pave_palette_params palette = PAVE_PALETTE_PARAMS_INIT;
    pave_stones_measure_params measure = PAVE_STONES_MEASURE_PARAMS_INIT;
    pave_limits limits = PAVE_LIMITS_INIT;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    const cli_group groups[] = {
        { "Measures", PAVE_PARAMS_MEASURE, &measure },
        { "Drawing", PAVE_PARAMS_THRESHOLD, &threshold },
        { "Colours", PAVE_PARAMS_PALETTE, &palette },
        { "Machine", PAVE_PARAMS_CONTEXT, &params },
        { "Limits", PAVE_PARAMS_LIMITS, &limits },
    };
    cli_command command = {
        .verb = "measure",
        .usage = "DRAWING STONES.svg [--json] [-o FILE.json]",
        .summary = "Judges stones against their drawing: corners, areas, overlap, colours, edges, directions, joints.\n"
                   "STONES is an SVG file of straight polygons in px of the drawing, from pave or from elsewhere,\n"
                   "or a file that pave wrote as .stones.",
        .outputs = "write the measures as JSON; repeatable",
        .json = "as JSON, to stdout",
        .inputs = 2,
        .groups = groups,
        .group_count = sizeof groups / sizeof *groups,
    };
    params.limits = &limits;
    int status = read_command(&command, argc, argv);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    pave_context *context = start(&command, &params);
    if (!context)
        return EXIT_USAGE;
    status = run(&command, context, &threshold, &palette, &measure);
    finish(&context);
    return status;
}
