/* pave maps: what a renderer takes of a pavement: maps of its surface, or a model of its stones. */
#include "cli.h"

#include <stdio.h>
#include <string.h>

enum { TEXTURE, VOLUME, JOINT, NAMED };

typedef struct maps_work {
    const cli_command *command;
    pave_context *context;
    const pave_maps_params *maps;
    const pave_model_params *model;
    const pave_maps_file_params *file;
    pave_stones *stones;
    pave_image *textures[MOST_FILES], *joint;
    pave_volume *volumes[MOST_FILES];
} maps_work;

static int ends_in(const char *path, const char *ending)
{
    size_t n = strlen(path), e = strlen(ending);
    return n > e && !strcmp(path + n - e, ending);
}

static pave_result read_inputs(maps_work *w)
{
    const cli_named *named = w->command->named;
    pave_result result = pave_stones_read(w->context, w->command->input[0], &w->stones);
    for (int i = 0; i < named[TEXTURE].count && !result; i++)
        result = read_image(w->context, named[TEXTURE].value[i], &w->textures[i]);
    for (int i = 0; i < named[VOLUME].count && !result; i++)
        result = pave_volume_read(w->context, named[VOLUME].value[i], &w->volumes[i]);
    if (!result && named[JOINT].count)
        result = read_image(w->context, named[JOINT].value[0], &w->joint);
    return result;
}

static pave_maps_input input_of(const maps_work *w)
{
    pave_maps_input input = PAVE_MAPS_INPUT_INIT;
    input.stones = w->stones;
    input.textures = (const pave_image *const *)w->textures;
    input.texture_count = w->command->named[TEXTURE].count;
    input.volumes = (const pave_volume *const *)w->volumes;
    input.volume_count = w->command->named[VOLUME].count;
    input.joint = w->joint;
    return input;
}

/* Parameters have been checked by now: what does not fit are stones, textures or volumes. */
static int work_code(pave_result result)
{
    return result == PAVE_ERR_ARGUMENT || result == PAVE_ERR_UNSUPPORTED ? EXIT_INPUT
                                                                         : exit_code(result, WHILE_WORKING);
}

static int write_maps(const maps_work *w, const char *path)
{
    const pave_maps_input input = input_of(w);
    pave_maps *maps = NULL;
    pave_result result = pave_maps_create(w->context, &input, w->maps, &maps);
    int status = work_code(result);
    if (!result)
        status = exit_code(pave_maps_write(w->context, maps, w->file, path), WHILE_WRITING);
    pave_maps_free(&maps);
    return status;
}

static int write_model(const maps_work *w, const char *path)
{
    const pave_maps_input input = input_of(w);
    pave_model *model = NULL;
    pave_result result = pave_model_create(w->context, &input, w->maps, w->model, &model);
    int status = work_code(result);
    if (!result)
        status = exit_code(pave_model_write(w->context, model, path), WHILE_WRITING);
    pave_model_free(&model);
    return status;
}

static int run(maps_work *w)
{
    int count = w->command->output_count;
    phase(0, 0.1);
    int status = exit_code(read_inputs(w), WHILE_READING);
    for (int i = 0; i < count && !status; i++) {
        phase(0.1 + 0.9 * i / count, 0.1 + 0.9 * (i + 1) / count);
        status = ends_in(w->command->output[i], ".glb") ? write_model(w, w->command->output[i])
                                                        : write_maps(w, w->command->output[i]);
    }
    return status;
}

static void clean_up(maps_work *w)
{
    pave_stones_free(&w->stones);
    pave_image_free(&w->joint);
    for (int i = 0; i < MOST_FILES; i++) {
        pave_image_free(&w->textures[i]);
        pave_volume_free(&w->volumes[i]);
    }
}

/* A name with an ending and no slash after it is taken for a file, and the only file is a model. */
static int is_served(const char *path)
{
    const char *name = strrchr(path, '/');
    name = name ? name + 1 : path;
    return ends_in(path, ".glb") || !*name || !strchr(name, '.') || !strcmp(name, ".") || !strcmp(name, "..");
}

static int check(const cli_command *command, const pave_maps_params *maps)
{
    const int32_t *w = maps->window;
    if ((w[0] || w[1] || w[2] || w[3]) && (!w[2] || !w[3]))
        return complain(command, "the window %d,%d,%d,%d has no area", w[0], w[1], w[2], w[3]), EXIT_USAGE;
    if (maps->joint_colour.count > 1)
        return complain(command, "--joint-colour is one colour, and not %d", maps->joint_colour.count), EXIT_USAGE;
    if (!command->output_count)
        return complain(command, "where to? give -o FOLDER/ for maps or -o FILE.glb for a model"), EXIT_USAGE;
    for (int i = 0; i < command->output_count; i++)
        if (!is_served(command->output[i])) {
            complain(command, "%s: is neither a folder/ for maps nor a model.glb", command->output[i]);
            return EXIT_USAGE;
        }
    return EXIT_FINE;
}

int maps_main(int argc, char **argv)
{
    pave_maps_params maps = PAVE_MAPS_PARAMS_INIT;
    pave_model_params model = PAVE_MODEL_PARAMS_INIT;
    pave_maps_file_params file = PAVE_MAPS_FILE_PARAMS_INIT;
    pave_limits limits = PAVE_LIMITS_INIT;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    const cli_group groups[] = {
        { "Maps", PAVE_PARAMS_MAPS, &maps },         { "Files", PAVE_PARAMS_MAPS_FILE, &file },
        { "Model", PAVE_PARAMS_MODEL, &model },      { "Machine", PAVE_PARAMS_CONTEXT, &params },
        { "Limits", PAVE_PARAMS_LIMITS, &limits },
    };
    cli_named named[NAMED] = {
        [TEXTURE] = { .usage = "texture FILE", .help = "what faces are cut from; one for all stones, or one for each\n"
                      "                               colour: black, white, or the palette's; repeatable",
                      .most = MOST_FILES },
        [VOLUME] = { .usage = "volume FILE", .help = "or volumes of stone, as pave solid makes them",
                     .most = MOST_FILES },
        [JOINT] = { .usage = "joint-texture FILE", .help = "texture of the joints", .most = 1 },
    };
    cli_command command = {
        .verb = "maps",
        .usage = "STONES -o FOLDER/ [-o FILE.glb] [options]",
        .summary = "Makes what a renderer takes of a pavement: maps of its surface (colour, height, normal,\n"
                   "roughness, occlusion, mask, number of the stone), or a model of its stones. STONES is a file\n"
                   "that pave lay wrote as .stones or .svg.",
        .outputs = "write maps into a folder/, or a model.glb (glTF 2.0); repeatable",
        .inputs = 1,
        .groups = groups,
        .group_count = sizeof groups / sizeof *groups,
        .named = named,
        .named_count = NAMED,
    };
    params.limits = &limits;
    int status = read_command(&command, argc, argv);
    if (!status)
        status = check(&command, &maps);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    maps_work w = { .command = &command, .maps = &maps, .model = &model, .file = &file };
    w.context = start(&command, &params);
    if (!w.context)
        return EXIT_USAGE;
    status = run(&w);
    clean_up(&w);
    finish(&w.context);
    return status;
}
