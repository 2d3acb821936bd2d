/* pave btf: bidirectional texture functions made, compressed, converted and told of. */
#include "cli.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static pave_btf_file_params files;
static pave_limits limits;
static pave_context_params machine;

enum { SHARED = 3 };

/* Reads the command line of one of the verbs below; the groups of files, machine and limits come last in each. */
static int begin(cli_command *command, cli_group *groups, int count, int argc, char **argv, pave_context **context)
{
    pave_btf_file_params_init(&files, sizeof files);
    pave_limits_init(&limits, sizeof limits);
    pave_context_params_init(&machine, sizeof machine);
    machine.limits = &limits;
    groups[count] = (cli_group){ "Files", PAVE_PARAMS_BTF_FILE, &files };
    groups[count + 1] = (cli_group){ "Machine", PAVE_PARAMS_CONTEXT, &machine };
    groups[count + 2] = (cli_group){ "Limits", PAVE_PARAMS_LIMITS, &limits };
    command->groups = groups;
    command->group_count = count + SHARED;
    int status = read_command(command, argc, argv);
    if (!status && command->outputs && command->output_count != 1)
        complain(command, "where to? give one -o FILE"), status = EXIT_USAGE;
    if (!status && !(*context = start(command, &machine)))
        status = EXIT_USAGE;
    return status;
}

static int write_btf(const cli_command *command, pave_context *context, pave_result made, pave_btf **btf, double from)
{
    int status = exit_code(made, WHILE_WORKING);
    phase(from, 1);
    if (!made)
        status = exit_code(pave_btf_write(context, *btf, &files, command->output[0]), WHILE_WRITING);
    pave_btf_free(btf);
    return status;
}

/* Samples are made as the file is written, so that it may be larger than memory. */
static int synthesize(int argc, char **argv)
{
    pave_btf_synthesis_params params = PAVE_BTF_SYNTHESIS_PARAMS_INIT;
    cli_group groups[1 + SHARED] = { { "Material", PAVE_PARAMS_BTF_SYNTHESIS, &params } };
    cli_command command = {
        .verb = "btf synthesize",
        .usage = "-o FILE [options]",
        .summary = "Makes the BTF of a relief of stone: masking, parallax, shadows and bounces are ray-cast.",
        .outputs = "write material.bdi, a folder/ or material.exr",
    };
    pave_context *context;
    pave_btf *btf = NULL;
    params.stored = 0;
    int status = begin(&command, groups, 1, argc, argv, &context);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    phase(0, 0.2);
    pave_result result = pave_btf_synthesize(context, &params, &btf);
    status = write_btf(&command, context, result, &btf, 0.2);
    finish(&context);
    return status;
}

static int compress(int argc, char **argv)
{
    pave_btf_compress_params params = PAVE_BTF_COMPRESS_PARAMS_INIT;
    cli_group groups[1 + SHARED] = { { "Compression", PAVE_PARAMS_BTF_COMPRESS, &params } };
    cli_command command = {
        .verb = "btf compress",
        .usage = "BTF -o FILE.btf [options]",
        .summary = "Factors a BTF: a few components stand for all its samples, with a known error.",
        .outputs = "write small.btf",
        .inputs = 1,
    };
    pave_context *context;
    pave_btf *btf = NULL, *small = NULL;
    int status = begin(&command, groups, 1, argc, argv, &context);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    phase(0, 0.02);
    pave_result result = pave_btf_read(context, command.input[0], &files, &btf);
    if (result)
        status = exit_code(result, WHILE_READING);
    phase(0.02, 0.95);
    if (!result) {
        result = pave_btf_compress(context, btf, &params, &small);
        status = write_btf(&command, context, result, &small, 0.95);
    }
    pave_btf_free(&btf);
    finish(&context);
    return status;
}

static int convert(int argc, char **argv)
{
    cli_group groups[SHARED];
    cli_command command = {
        .verb = "btf convert",
        .usage = "BTF -o FILE",
        .summary = "Writes a BTF in another format.",
        .outputs = "write other.bdi, other.btf, other.exr or a folder/",
        .inputs = 1,
    };
    pave_context *context;
    pave_btf *btf = NULL;
    int status = begin(&command, groups, 0, argc, argv, &context);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    phase(0, 0.02);
    pave_result result = pave_btf_read(context, command.input[0], &files, &btf);
    status = result ? exit_code(result, WHILE_READING) : write_btf(&command, context, result, &btf, 0.02);
    finish(&context);
    return status;
}

static void print_info(const pave_btf *btf)
{
    printf("texels      %d x %d\nviews       %d\nlights      %d\nchannels   ", (int)pave_btf_width(btf),
           (int)pave_btf_height(btf), (int)pave_btf_views(btf), (int)pave_btf_lights(btf));
    for (int32_t c = 0; c < pave_btf_channels(btf); c++)
        printf(" %s", pave_btf_channel_name(btf, c));
    printf("\ncomponents ");
    for (int32_t c = 0; c < pave_btf_channels(btf); c++)
        printf(" %d", (int)pave_btf_components(btf, c));
    printf("\ncosine      %s\n", pave_btf_cosine(btf) ? "in the samples" : "not in the samples");
}

static int info(int argc, char **argv)
{
    cli_group groups[SHARED];
    cli_command command = {
        .verb = "btf info",
        .usage = "BTF [--json]",
        .summary = "Tells what a BTF holds and how sound it is: reciprocity, albedo, missing pairs.",
        .json = "as JSON",
        .inputs = 1,
    };
    pave_context *context;
    pave_btf *btf = NULL;
    int status = begin(&command, groups, 0, argc, argv, &context);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    pave_result result = pave_btf_read(context, command.input[0], &files, &btf);
    status = exit_code(result, WHILE_READING);
    if (!result)
        print_info(btf);
    pave_btf_free(&btf);
    finish(&context);
    return status;
}

/* Takes "--light 30,120" and "--view 0,0" apart into the options that the table has. */
static int split_directions(int argc, char **argv, char **words, char (*store)[64])
{
    int count = 0;
    for (int i = 0; i < argc; i++) {
        const char *names[2] = { "light", "view" };
        int which = !strcmp(argv[i], "--light") ? 0 : !strcmp(argv[i], "--view") ? 1 : -1;
        const char *comma = which >= 0 && i + 1 < argc ? strchr(argv[i + 1], ',') : NULL;
        words[count++] = argv[i];
        if (!comma)
            continue;
        snprintf(store[2 * which], 64, "--%s-theta=%.*s", names[which], (int)(comma - argv[i + 1]), argv[i + 1]);
        snprintf(store[2 * which + 1], 64, "--%s-phi=%s", names[which], comma + 1);
        words[count - 1] = store[2 * which];
        words[count++] = store[2 * which + 1];
        i++;
    }
    return count;
}

static pave_result draw(const cli_command *command, pave_context *context, const pave_btf_view_params *params,
                        const pave_image *environment, const pave_btf *btf)
{
    pave_image *picture = NULL;
    pave_result result = pave_btf_view(context, btf, environment, params, &picture);
    if (!result)
        result = pave_image_write(context, picture, command->output[0]);
    pave_image_free(&picture);
    return result;
}

static int view(int argc, char **argv)
{
    pave_btf_view_params params = PAVE_BTF_VIEW_PARAMS_INIT;
    cli_group groups[1 + SHARED] = { { "Picture", PAVE_PARAMS_BTF_VIEW, &params } };
    char store[4][64], **words = malloc((size_t)(argc + 3) * sizeof *words);
    cli_command command = {
        .verb = "btf view",
        .usage = "BTF [ENVIRONMENT] -o FILE [--light THETA,PHI] [--view THETA,PHI] [options]",
        .summary = "Draws a material on a plane, a cylinder or a sphere, under a lamp or an environment picture.",
        .outputs = "write picture.png or picture.exr",
        .inputs = -1,
    };
    pave_context *context;
    pave_btf *btf = NULL;
    pave_image *environment = NULL;
    if (!words)
        return EXIT_RESOURCES;
    int status = begin(&command, groups, 1, split_directions(argc, argv, words, store), words, &context);
    if (!status) {
        pave_result result = pave_btf_read(context, command.input[0], &files, &btf);
        if (!result && command.input_count > 1)
            result = read_image(context, command.input[1], &environment);
        status = exit_code(result, WHILE_READING);
        if (!result)
            status = exit_code(draw(&command, context, &params, environment, btf), WHILE_WRITING);
        pave_image_free(&environment);
        pave_btf_free(&btf);
        finish(&context);
    }
    free(words);
    return status < 0 ? EXIT_FINE : status;
}

static const struct {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *summary;
} verbs[] = {
    { "synthesize", synthesize, "make one: a relief of stone under all lights, from all views" },
    { "compress", compress, "factor one, with a known error" },
    { "convert", convert, "write one in another format" },
    { "view", view, "draw one on a plane, a cylinder or a sphere" },
    { "info", info, "tell what one holds" },
};

enum { VERBS = sizeof verbs / sizeof *verbs };

int btf_main(int argc, char **argv)
{
    const char *names[VERBS];
    for (int i = 0; i < VERBS; i++) {
        names[i] = verbs[i].name;
        if (argc > 1 && !strcmp(argv[1], names[i]))
            return verbs[i].run(argc - 1, argv + 1);
    }
    int help = argc > 1 && (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"));
    const char *near = argc > 1 && !help ? nearest_name(argv[1], names, VERBS) : NULL;
    if (argc > 1 && !help) {
        fprintf(stderr, "pave btf: there is no verb '%s'%s%s%s; see pave btf --help\n", argv[1],
                near ? ", did you mean '" : "", near ? near : "", near ? "'?" : "");
        return EXIT_USAGE;
    }
    FILE *to = help ? stdout : stderr;
    fputs("usage: pave btf VERB ...\n\n", to);
    for (int i = 0; i < VERBS; i++)
        fprintf(to, "  pave btf %-11s %s\n", verbs[i].name, verbs[i].summary);
    return help ? EXIT_FINE : EXIT_USAGE;
}
