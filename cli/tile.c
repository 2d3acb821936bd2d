/* pave tile: a larger texture, or one that repeats, from a small one. */
#include "cli.h"

#include <stdio.h>
#include <string.h>

enum { GUIDE, APPLY, SOURCES, NAMED };

/* What a run holds. */
typedef struct tile_work {
    pave_image *exemplars[MOST_FILES];
    pave_image *guide;
    pave_tiling *tiling;
} tile_work;

static pave_result read_inputs(const cli_command *command, pave_context *context, tile_work *work)
{
    pave_result result = PAVE_OK;
    phase(0, 0.02);
    for (int i = 0; i < command->input_count && !result; i++)
        result = read_image(context, command->input[i], &work->exemplars[i]);
    if (!result && command->named[GUIDE].count)
        result = read_image(context, command->named[GUIDE].value[0], &work->guide);
    return result;
}

static const pave_image *const *as_images(pave_image **images)
{
    return (const pave_image *const *)images;
}

static pave_result write_picture(pave_context *context, const tile_work *work, pave_image **images, int count,
                                 const char *path)
{
    pave_image *picture = NULL;
    pave_result result = pave_tiling_apply(context, work->tiling, as_images(images), count, &picture);
    if (!result)
        result = pave_image_write(context, picture, path);
    pave_image_free(&picture);
    return result;
}

static int run(const cli_command *command, pave_context *context, const pave_tiling_params *params, tile_work *work)
{
    pave_result result = read_inputs(command, context, work);
    if (result)
        return exit_code(result, WHILE_READING);
    phase(0.02, 0.9);
    result = pave_tiling_create(context, as_images(work->exemplars), command->input_count, work->guide, params,
                                &work->tiling);
    if (result)
        return exit_code(result, WHILE_WORKING);
    for (int i = 0; i < command->output_count && !result; i++)
        result = write_picture(context, work, work->exemplars, command->input_count, command->output[i]);
    return exit_code(result, WHILE_WRITING);
}

int tile_main(int argc, char **argv)
{
    pave_tiling_params tiling = PAVE_TILING_PARAMS_INIT;
    pave_limits limits = PAVE_LIMITS_INIT;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    const cli_group groups[] = {
        { "Tiling", PAVE_PARAMS_TILING, &tiling },
        { "Machine", PAVE_PARAMS_CONTEXT, &params },
        { "Limits", PAVE_PARAMS_LIMITS, &limits },
    };
    cli_named named[NAMED] = {
        [GUIDE] = { .usage = "guide FILE", .help = "image as large as the result, whose brightness it follows", .most = 1 },
        [APPLY] = { .usage = "apply IN[,IN...]=OUT", .help = "lay other maps of the exemplars alike; repeatable",
                    .most = MOST_FILES },
        [SOURCES] = { .usage = "sources FILE.exr", .help = "write where each pixel comes from", .most = 1 },
    };
    cli_command command = {
        .verb = "tile",
        .usage = "EXEMPLAR [EXEMPLAR ...] [--size WxH] -o FILE [options]",
        .summary = "Makes a larger texture that repeats without a seam from a small one.",
        .outputs = "write tiling.png (.tif, .jpg, .exr), or the report.json; repeatable",
        .json = "write the report to stdout",
        .inputs = -1,
        .groups = groups,
        .group_count = sizeof groups / sizeof *groups,
        .named = named,
        .named_count = NAMED,
    };
    tile_work work = { { NULL }, NULL, NULL };
    params.limits = &limits;
    int status = read_command(&command, argc, argv);
    if (!status && command.input_count > MOST_FILES)
        complain(&command, "more than %d exemplars", MOST_FILES), status = EXIT_USAGE;
    if (status)
        return status < 0 ? EXIT_FINE : status;
    pave_context *context = start(&command, &params);
    if (!context)
        return EXIT_USAGE;
    status = run(&command, context, &tiling, &work);
    pave_tiling_free(&work.tiling);
    pave_image_free(&work.guide);
    for (int i = 0; i < MOST_FILES; i++)
        pave_image_free(&work.exemplars[i]);
    finish(&context);
    return status;
}
