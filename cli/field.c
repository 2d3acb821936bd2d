/* pave field: the distance field of a drawing, as an image of three float channels. */
#include "cli.h"

static pave_result write_field(const cli_command *command, pave_context *context, const pave_field *field)
{
    pave_image *image = NULL;
    pave_result result = pave_field_image(context, field, &image);
    for (int i = 0; i < command->output_count && !result; i++)
        result = pave_image_write(context, image, command->output[i]);
    pave_image_free(&image);
    return result;
}

static int run(const cli_command *command, pave_context *context, const pave_threshold_params *threshold,
               const pave_field_params *params)
{
    pave_image *image = NULL, *drawing = NULL;
    pave_field *field = NULL;
    pave_result result = read_image(context, command->input[0], &image);
    if (result)
        return exit_code(result, WHILE_READING);
    result = pave_image_threshold(context, image, threshold, &drawing);
    if (!result)
        result = pave_field_create(context, drawing, params, &field);
    int status = exit_code(result, WHILE_WORKING);
    if (!result)
        status = exit_code(write_field(command, context, field), WHILE_WRITING);
    pave_field_free(&field);
    pave_image_free(&drawing);
    pave_image_free(&image);
    return status;
}

int field_main(int argc, char **argv)
{
    pave_threshold_params threshold = PAVE_THRESHOLD_PARAMS_INIT;
    pave_field_params field = PAVE_FIELD_PARAMS_INIT;
    pave_limits limits = PAVE_LIMITS_INIT;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    const cli_group groups[] = {
        { "Distance field", PAVE_PARAMS_FIELD, &field },
        { "Drawing", PAVE_PARAMS_THRESHOLD, &threshold },
        { "Machine", PAVE_PARAMS_CONTEXT, &params },
        { "Limits", PAVE_PARAMS_LIMITS, &limits },
    };
    cli_command command = {
        .verb = "field",
        .usage = "DRAWING -o FILE.exr [options]",
        .summary = "Writes how far each pixel is from the nearest edge between two colours, in pixels, and the\n"
                   "gradient of that distance (y down): channels distance, gradient.x and gradient.y.",
        .outputs = "write field.exr; repeatable",
        .inputs = 1,
        .groups = groups,
        .group_count = sizeof groups / sizeof *groups,
    };
    params.limits = &limits;
    int status = read_command(&command, argc, argv);
    if (!status && !command.output_count)
        complain(&command, "where to? give -o FILE.exr"), status = EXIT_USAGE;
    if (status)
        return status < 0 ? EXIT_FINE : status;
    pave_context *context = start(&command, &params);
    if (!context)
        return EXIT_USAGE;
    status = run(&command, context, &threshold, &field);
    finish(&context);
    return status;
}
