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

/* Takes "--components 200,100,100" apart into the options that the table has. */
static int split_components(int argc, char **argv, char **words, char (*store)[64])
{
    static const char *const names[3] = { "components", "second", "third" };
    int count = 0;
    for (int i = 0; i < argc; i++) {
        int has_list = !strcmp(argv[i], "--components") && i + 1 < argc && strchr(argv[i + 1], ',');
        words[count++] = argv[i];
        const char *list = has_list ? argv[++i] : NULL;
        for (int k = 0; k < 3 && list && *list; k++) {
            int length = (int)strcspn(list, ",");
            snprintf(store[k], 64, "--%s=%.*s", names[k], length, list);
            words[count - 1 + (k > 0)] = store[k];
            count += k > 0;
            list += length + (list[length] == ',');
        }
    }
    return count;
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
    char store[3][64], **words = malloc((size_t)(argc + 3) * sizeof *words);
    if (!words)
        return EXIT_RESOURCES;
    int status = begin(&command, groups, 1, split_components(argc, argv, words, store), words, &context);
    if (status) {
        free(words);
        return status < 0 ? EXIT_FINE : status;
    }
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
    free(words);
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

/* Takes "--NAME VALUE" or "--NAME=VALUE" out of a command line and returns the value; NULL: it is not there. */
static const char *take_option(const char *name, int *argc, char **argv)
{
    size_t length = strlen(name);
    for (int i = 1; i < *argc; i++) {
        if (strncmp(argv[i], "--", 2) || strncmp(argv[i] + 2, name, length))
            continue;
        const char *rest = argv[i] + 2 + length, *value = *rest == '=' ? rest + 1 : i + 1 < *argc ? argv[i + 1] : NULL;
        if ((*rest && *rest != '=') || !value)
            continue;
        int gone = *rest ? 1 : 2;
        for (*argc -= gone; i < *argc; i++)
            argv[i] = argv[i + gone];
        argv[*argc] = NULL;
        return value;
    }
    return NULL;
}

static pave_result draw_albedo(pave_context *context, const pave_btf *btf, const char *path)
{
    pave_image *picture = NULL;
    pave_result result = path ? pave_btf_albedo(context, btf, &picture) : PAVE_OK;
    if (!result && path)
        result = pave_image_write(context, picture, path);
    pave_image_free(&picture);
    return result;
}

static int info(int argc, char **argv)
{
    pave_btf_texels_params texels = PAVE_BTF_TEXELS_PARAMS_INIT;
    pave_btf_diagnosis diagnosis = { .size = sizeof diagnosis };
    cli_group groups[1 + SHARED] = { { "Diagnosis", PAVE_PARAMS_BTF_TEXELS, &texels } };
    const char *path = take_option("picture", &argc, argv);
    cli_command command = {
        .verb = "btf info",
        .usage = "BTF [--json] [--picture ALBEDO.png]",
        .summary = "Tells what a BTF holds and how sound it is: reciprocity, albedo, saturation, missing pairs.",
        .json = "as JSON",
        .inputs = 1,
    };
    pave_context *context;
    pave_btf *btf = NULL;
    int status = begin(&command, groups, 1, argc, argv, &context);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    phase(0, 0.1);
    pave_result result = pave_btf_read(context, command.input[0], &files, &btf);
    status = exit_code(result, WHILE_READING);
    phase(0.1, 1);
    if (!result)
        status = exit_code(result = pave_btf_diagnose(context, btf, &texels, &diagnosis), WHILE_WORKING);
    if (!result)
        result = pave_btf_diagnosis_write(context, btf, &diagnosis, "-", command.wants_json ? "json" : "text");
    if (!result && !status)
        status = exit_code(draw_albedo(context, btf, path), WHILE_WRITING);
    pave_btf_free(&btf);
    finish(&context);
    return status;
}

static int measure(int argc, char **argv)
{
    pave_btf_texels_params texels = PAVE_BTF_TEXELS_PARAMS_INIT;
    pave_btf_difference difference = { .size = sizeof difference };
    cli_group groups[1 + SHARED] = { { "Comparison", PAVE_PARAMS_BTF_TEXELS, &texels } };
    cli_command command = {
        .verb = "btf measure",
        .usage = "A B [--json]",
        .summary = "Tells how far A is from B, which it stands for: errors of ABRDFs, linear, in logarithms, relative.",
        .json = "as JSON",
        .inputs = 2,
    };
    pave_context *context;
    pave_btf *btf[2] = { NULL, NULL };
    int status = begin(&command, groups, 1, argc, argv, &context);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    pave_result result = PAVE_OK;
    for (int i = 0; i < 2 && !result; i++) {
        phase(0.1 * i, 0.1 * (i + 1));
        result = pave_btf_read(context, command.input[i], &files, &btf[i]);
    }
    status = exit_code(result, WHILE_READING);
    phase(0.2, 1);
    if (!result)
        status = exit_code(result = pave_btf_measure(context, btf[0], btf[1], &texels, &difference), WHILE_WORKING);
    if (!result)
        status = exit_code(pave_btf_difference_write(context, &difference, "-", command.wants_json ? "json" : "text"),
                           WHILE_WRITING);
    pave_btf_free(&btf[0]);
    pave_btf_free(&btf[1]);
    finish(&context);
    return status;
}

typedef pave_result sheet_maker(pave_context *context, const pave_btf *btf, const pave_btf_sheet_params *params,
                                pave_image **out);

static int draw_sheet(int argc, char **argv, const char *verb, const char *summary, sheet_maker *make)
{
    pave_btf_sheet_params params = PAVE_BTF_SHEET_PARAMS_INIT;
    cli_group groups[1 + SHARED] = { { "Sheet", PAVE_PARAMS_BTF_SHEET, &params } };
    cli_command command = { .verb = verb, .usage = "BTF -o FILE [options]", .summary = summary,
                            .outputs = "write sheet.png or sheet.exr", .inputs = 1 };
    pave_context *context;
    pave_btf *btf = NULL;
    pave_image *picture = NULL;
    int status = begin(&command, groups, 1, argc, argv, &context);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    pave_result result = pave_btf_read(context, command.input[0], &files, &btf);
    status = exit_code(result, WHILE_READING);
    if (!result)
        status = exit_code(result = make(context, btf, &params, &picture), WHILE_WORKING);
    if (!result)
        status = exit_code(pave_image_write(context, picture, command.output[0]), WHILE_WRITING);
    pave_image_free(&picture);
    pave_btf_free(&btf);
    finish(&context);
    return status;
}

static int sheet(int argc, char **argv)
{
    return draw_sheet(argc, argv, "btf sheet", "Draws textures side by side: a row for each view, a column a light.",
                      pave_btf_contact_sheet);
}

static int plot(int argc, char **argv)
{
    return draw_sheet(argc, argv, "btf plot", "Draws an ABRDF: for each view a disc of all lights.", pave_btf_plot);
}

static pave_result read_all(const cli_command *command, pave_context *context, pave_btf **btfs)
{
    pave_result result = PAVE_OK;
    for (int i = 0; i < command->input_count && !result; i++) {
        phase(0.3 * i / command->input_count, 0.3 * (i + 1) / command->input_count);
        result = pave_btf_read(context, command->input[i], &files, &btfs[i]);
    }
    return result;
}

static int merge(int argc, char **argv)
{
    cli_group groups[SHARED];
    const char *most = take_option("components", &argc, argv);
    int32_t components = most ? (int32_t)strtol(most, NULL, 10) : 2048;
    cli_command command = {
        .verb = "btf merge",
        .usage = "A.btf B.btf ... -o FILE.btf [--components N]",
        .summary = "Finds one basis for several factored materials, which come to lie below each other.",
        .outputs = "write all.btf",
        .inputs = -1,
    };
    pave_context *context;
    int status = begin(&command, groups, 0, argc, argv, &context);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    pave_btf *merged = NULL, **btfs = calloc((size_t)command.input_count, sizeof *btfs);
    pave_result result = btfs ? read_all(&command, context, btfs) : PAVE_ERR_MEMORY;
    status = exit_code(result, WHILE_READING);
    phase(0.3, 0.9);
    if (!result) {
        result = pave_btf_merge(context, (const pave_btf *const *)btfs, command.input_count, components, &merged);
        status = write_btf(&command, context, result, &merged, 0.9);
    }
    for (int i = 0; btfs && i < command.input_count; i++)
        pave_btf_free(&btfs[i]);
    free(btfs);
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
                        const pave_image *environment, const pave_btf *btf, const char *against, double scale)
{
    pave_image *picture = NULL;
    pave_btf *other = NULL;
    pave_result result = against ? pave_btf_read(context, against, &files, &other) : PAVE_OK;
    if (!result)
        result = other ? pave_btf_view_difference(context, btf, other, environment, params, scale, &picture)
                       : pave_btf_view(context, btf, environment, params, &picture);
    pave_btf_free(&other);
    if (!result)
        result = pave_image_write(context, picture, command->output[0]);
    pave_image_free(&picture);
    return result;
}

static int view(int argc, char **argv)
{
    pave_btf_view_params params = PAVE_BTF_VIEW_PARAMS_INIT;
    cli_group groups[1 + SHARED] = { { "Picture", PAVE_PARAMS_BTF_VIEW, &params } };
    const char *against = take_option("against", &argc, argv), *scale = take_option("scale", &argc, argv);
    char store[4][64], **words = malloc((size_t)(argc + 3) * sizeof *words);
    cli_command command = {
        .verb = "btf view",
        .usage = "BTF [ENVIRONMENT] -o FILE [--light THETA,PHI] [--view THETA,PHI] [--against BTF] [options]",
        .summary = "Draws a material on a plane, a cylinder or a sphere, under a lamp or an environment picture.\n"
                   "--against draws the difference to another BTF instead, --scale times (20 if not given).",
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
            status = exit_code(draw(&command, context, &params, environment, btf, against,
                                    scale ? strtod(scale, NULL) : 20), WHILE_WRITING);
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
    { "plot", plot, "draw an ABRDF: for each view a disc of all lights" },
    { "sheet", sheet, "draw textures under some lights from some views, side by side" },
    { "info", info, "tell what one holds and how sound it is" },
    { "measure", measure, "tell how far one is from another" },
    { "merge", merge, "find one basis for several factored ones" },
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
