/* pave tile: a larger texture, or one that repeats, from a small one. */
#include "cli.h"

#include <stdio.h>
#include <string.h>

enum { GUIDE, SOURCES, APPLY, NORMALS, NORMALS_DOWN, NAMED, KINDS = NAMED - APPLY };

/* What a run holds. */
typedef struct tile_work {
    pave_image *exemplars[MOST_FILES];
    pave_image *maps[KINDS][MOST_FILES][MOST_FILES]; /* companions, for each output one of each exemplar */
    pave_image *guide;
    pave_tiling *tiling;
} tile_work;

/* "normal.png=normal-out.png", or "a.png,b.png=out.png" for two exemplars. Read, and held against the exemplars, before
 * anything is done. */
static pave_result read_maps(const cli_command *command, pave_context *context, const char *text, tile_work *work,
                             pave_image **maps)
{
    char name[4096];
    pave_result result = PAVE_OK;
    for (int i = 0; i < command->input_count && !result; i++) {
        int length = (int)strcspn(text, i + 1 < command->input_count ? ",=" : "=");
        snprintf(name, sizeof name, "%.*s", length, text);
        result = read_image(context, name, &maps[i]);
        text += length + (text[length] == ',');
        if (result || (pave_image_width(maps[i]) == pave_image_width(work->exemplars[i]) &&
                       pave_image_height(maps[i]) == pave_image_height(work->exemplars[i])))
            continue;
        complain(command, "%s: does not fit its exemplar: %d x %d px, not %d x %d", name,
                 (int)pave_image_width(maps[i]), (int)pave_image_height(maps[i]),
                 (int)pave_image_width(work->exemplars[i]), (int)pave_image_height(work->exemplars[i]));
        result = PAVE_ERR_ARGUMENT;
    }
    return result;
}

static pave_result read_inputs(const cli_command *command, pave_context *context, tile_work *work)
{
    pave_result result = PAVE_OK;
    phase(0, 0.02);
    for (int i = 0; i < command->input_count && !result; i++)
        result = read_image(context, command->input[i], &work->exemplars[i]);
    if (!result && command->named[GUIDE].count)
        result = read_image(context, command->named[GUIDE].value[0], &work->guide);
    for (int kind = APPLY; kind < NAMED; kind++)
        for (int i = 0; i < command->named[kind].count && !result; i++)
            result = read_maps(command, context, command->named[kind].value[i], work, work->maps[kind - APPLY][i]);
    return result;
}

static const pave_image *const *as_images(pave_image **images)
{
    return (const pave_image *const *)images;
}

static pave_result write_picture(pave_context *context, const tile_work *work, int kind, pave_image **images,
                                 int count, const char *path)
{
    pave_image *picture = NULL;
    pave_result result = kind == APPLY ? pave_tiling_apply(context, work->tiling, as_images(images), count, &picture)
                                       : pave_tiling_apply_normals(context, work->tiling, as_images(images), count,
                                                                   kind == NORMALS, &picture);
    if (!result)
        result = pave_image_write(context, picture, path);
    pave_image_free(&picture);
    return result;
}

static int is_json(const char *path)
{
    size_t length = strlen(path);
    return length > 4 && !strcmp(path + length - 5, ".json");
}

static pave_result write_report(pave_context *context, const cli_command *command, const tile_work *work,
                                const char *path)
{
    pave_tiling_measure measure = { .size = sizeof measure };
    pave_result result = pave_tiling_judge(context, work->tiling, as_images((pave_image **)work->exemplars),
                                           command->input_count, &measure);
    return result ? result : pave_tiling_write(context, work->tiling, &measure, path);
}

static pave_result write_maps(pave_context *context, const cli_command *command, const tile_work *work)
{
    pave_result result = PAVE_OK;
    for (int kind = APPLY; kind < NAMED; kind++)
        for (int i = 0; i < command->named[kind].count && !result; i++)
            result = write_picture(context, work, kind, (pave_image **)work->maps[kind - APPLY][i],
                                   command->input_count, strrchr(command->named[kind].value[i], '=') + 1);
    return result;
}

static pave_result write_sources(pave_context *context, const tile_work *work, const char *path)
{
    pave_image *sources = NULL;
    pave_result result = pave_tiling_source_image(context, work->tiling, &sources);
    if (!result)
        result = pave_image_write(context, sources, path);
    pave_image_free(&sources);
    return result;
}

static pave_result write_outputs(const cli_command *command, pave_context *context, const tile_work *work)
{
    const cli_named *sources = &command->named[SOURCES];
    pave_result result = PAVE_OK;
    phase(0.9, 1);
    for (int i = 0; i < command->output_count && !result; i++)
        result = is_json(command->output[i])
                     ? write_report(context, command, work, command->output[i])
                     : write_picture(context, work, APPLY, (pave_image **)work->exemplars,
                                     command->input_count, command->output[i]);
    if (!result)
        result = write_maps(context, command, work);
    if (!result && sources->count)
        result = write_sources(context, work, sources->value[0]);
    if (!result && command->wants_json)
        result = write_report(context, command, work, "-");
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
    return exit_code(write_outputs(command, context, work), WHILE_WRITING);
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
        [GUIDE] = { .usage = "guide FILE", .help = "image as large as the result, whose brightness it follows",
                    .most = 1 },
        [APPLY] = { .usage = "apply IN[,IN...]=OUT", .help = "lay other maps of the exemplars alike; repeatable",
                    .most = MOST_FILES },
        [NORMALS] = { .usage = "normals IN[,IN...]=OUT",
                      .help = "the same for normal maps, turned with their copies; y is up", .most = MOST_FILES },
        [NORMALS_DOWN] = { .usage = "normals-down IN[,IN...]=OUT", .help = "normal maps whose y is down",
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
    tile_work work = { 0 };
    params.limits = &limits;
    int status = read_command(&command, argc, argv);
    int maps = 0;
    for (int kind = APPLY; kind < NAMED; maps += named[kind++].count)
        for (int i = 0; i < named[kind].count && !status; i++)
            if (!strchr(named[kind].value[i], '='))
                complain(&command, "%s: must be IN=OUT", named[kind].value[i]), status = EXIT_USAGE;
    if (!status && !command.output_count && !command.wants_json && !maps && !named[SOURCES].count)
        complain(&command, "where to? give -o FILE or --json"), status = EXIT_USAGE;
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
    for (int i = 0; i < MOST_FILES; i++) {
        pave_image_free(&work.exemplars[i]);
        for (int k = 0; k < KINDS * MOST_FILES; k++)
            pave_image_free(&work.maps[k / MOST_FILES][k % MOST_FILES][i]);
    }
    finish(&context);
    return status;
}
