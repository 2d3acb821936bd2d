/* Options: read, explained and range-checked by the library's parameter tables. */
#include "cli.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_NAMES = 128, NAME = 48 };

int exit_code(pave_result result, int doing)
{
    switch (result) {
    case PAVE_OK: return EXIT_FINE;
    case PAVE_ERR_ARGUMENT:
    case PAVE_ERR_TOO_NEW: return EXIT_USAGE;
    case PAVE_ERR_FORMAT: return EXIT_INPUT;
    case PAVE_ERR_LIMIT: return EXIT_LIMIT;
    case PAVE_ERR_MEMORY: return EXIT_RESOURCES;
    case PAVE_ERR_IO: return doing == WHILE_READING ? EXIT_INPUT : EXIT_RESOURCES;
    case PAVE_ERR_UNSUPPORTED:
        return doing == WHILE_READING ? EXIT_INPUT : doing == WHILE_WRITING ? EXIT_USAGE : EXIT_DEVICE;
    case PAVE_ERR_DEVICE: return EXIT_DEVICE;
    case PAVE_ERR_CANCELLED: return EXIT_CANCELLED;
    default: return EXIT_FAULT;
    }
}

void complain(const cli_command *command, const char *format, ...)
{
    va_list arguments;
    fprintf(stderr, "pave %s: ", command->verb);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

/* "half_side" as typed: "half-side". */
static void option_name(char out[NAME], const char *name)
{
    snprintf(out, NAME, "%s", name);
    for (char *p = out; *p; p++)
        *p = *p == '_' ? '-' : *p;
}

/* Edit distance, up to `most`. */
static int distance(const char *a, const char *b)
{
    int row[NAME + 1], m = (int)strlen(b);
    if (strlen(a) > NAME || m > NAME)
        return NAME;
    for (int j = 0; j <= m; j++)
        row[j] = j;
    for (int i = 1; a[i - 1]; i++) {
        int corner = row[0];
        row[0] = i;
        for (int j = 1; j <= m; j++) {
            int change = corner + (a[i - 1] != b[j - 1]), shorter = (row[j] < row[j - 1] ? row[j] : row[j - 1]) + 1;
            corner = row[j];
            row[j] = change < shorter ? change : shorter;
        }
    }
    return row[m];
}

const char *nearest_name(const char *typed, const char *const *names, int count)
{
    const char *best = NULL;
    int least = strlen(typed) < 3 ? 2 : 3;
    for (int i = 0; i < count; i++)
        if (distance(typed, names[i]) < least)
            least = distance(typed, names[i]), best = names[i];
    return best;
}

void lay_options_init(lay_options *o)
{
    const cli_group groups[LAY_GROUPS] = {
        { "Stones", PAVE_PARAMS_STONES, &o->stones },       { "Diagram", PAVE_PARAMS_CVD, &o->cvd },
        { "Distance field", PAVE_PARAMS_FIELD, &o->field }, { "Drawing", PAVE_PARAMS_THRESHOLD, &o->threshold },
        { "Colours", PAVE_PARAMS_PALETTE, &o->palette },
        { "Machine", PAVE_PARAMS_CONTEXT, &o->context },    { "Size", PAVE_PARAMS_STREAM, &o->stream },
        { "Limits", PAVE_PARAMS_LIMITS, &o->limits },
    };
    memcpy(o->groups, groups, sizeof groups);
    pave_threshold_params_init(&o->threshold, sizeof o->threshold);
    pave_palette_params_init(&o->palette, sizeof o->palette);
    pave_field_params_init(&o->field, sizeof o->field);
    pave_cvd_params_init(&o->cvd, sizeof o->cvd);
    pave_stones_params_init(&o->stones, sizeof o->stones);
    pave_stream_params_init(&o->stream, sizeof o->stream);
    pave_limits_init(&o->limits, sizeof o->limits);
    pave_context_params_init(&o->context, sizeof o->context);
    o->limits.max_pixels = 0;
    o->context.limits = &o->limits;
    o->lay = (pave_lay_params){ sizeof o->lay, &o->threshold, &o->field, &o->cvd, &o->stones, &o->palette };
}

static void print_value(const pave_param *param, double value)
{
    const char *choice = param->choices;
    for (int i = 0; choice && i < (int)value; i++)
        choice = strchr(choice, '|') + 1;
    if (choice)
        printf("%.*s", (int)strcspn(choice, "|"), choice);
    else
        printf("%.15g", value);
}

static void print_range(const pave_param *param)
{
    printf(" [");
    print_value(param, param->initial);
    printf("%s%s", *param->unit ? " " : "", param->unit);
    if (param->type == PAVE_PARAM_SEED)
        printf("; any whole number");
    else if (!param->choices)
        printf("; %.15g .. %.15g", param->least, param->greatest);
    printf("]");
}

/* Choices go below the option, for their list may be long. */
static void print_option(const pave_param *param)
{
    char name[NAME], left[NAME + 16];
    option_name(name, param->name);
    const char *value = param->type == PAVE_PARAM_FLAG     ? ""
                        : param->type == PAVE_PARAM_WINDOW ? " X,Y,W,H"
                        : param->type == PAVE_PARAM_PALETTE ? " LIST"
                        : param->type == PAVE_PARAM_EXTENT ? " WxH"
                        : param->choices                   ? " NAME"
                                                           : " N";
    const char *no = param->type == PAVE_PARAM_FLAG && param->initial > 0 ? "[no-]" : "";
    snprintf(left, sizeof left, "--%s%s%s", no, name, value);
    printf("  %-28s %s%s", left, param->help, *no ? " [yes]" : "");
    if (param->type != PAVE_PARAM_FLAG && param->type != PAVE_PARAM_WINDOW && param->type != PAVE_PARAM_PALETTE &&
        param->type != PAVE_PARAM_EXTENT)
        print_range(param);
    if (param->choices)
        printf("\n  %-28s %s", "", param->choices);
    putchar('\n');
}

static void print_help(const cli_command *command)
{
    printf("usage: pave %s %s\n\n%s\n", command->verb, command->usage, command->summary);
    if (command->outputs)
        printf("\n  -o FILE, --output FILE       %s\n", command->outputs);
    if (command->json)
        printf("  --json                       %s\n", command->json);
    if (command->plans && !command->shards)
        printf("  --manifest FILE              all windows of a plan made by pave plan, instead of PART.stones ...\n");
    if (command->shards)
        printf("  --manifest FILE --shard N    lay one window of a plan made by pave plan, instead of DRAWING\n");
    for (int i = 0; i < command->named_count; i++)
        printf("  --%-26s %s\n", command->named[i].usage, command->named[i].help);
    printf("  -q, --quiet                  no progress, no notes\n  -h, --help                   this help\n");
    for (int g = 0; g < command->group_count; g++) {
        printf("\n%s\n", command->groups[g].title);
        for (int32_t i = 0; i < pave_params_count(command->groups[g].table); i++) {
            pave_param param;
            if (!pave_params_describe(command->groups[g].table, i, &param))
                print_option(&param);
        }
    }
}

/* The group and the description of an option "half-side"; NULL if no table has it. */
static const cli_group *find_option(const cli_command *command, const char *typed, pave_param *param)
{
    for (int g = 0; g < command->group_count; g++)
        for (int32_t i = 0; i < pave_params_count(command->groups[g].table); i++) {
            char name[NAME];
            pave_params_describe(command->groups[g].table, i, param);
            option_name(name, param->name);
            if (!strcmp(name, typed))
                return &command->groups[g];
        }
    return NULL;
}

static int unknown_option(const cli_command *command, const char *typed)
{
    static char store[MOST_NAMES][NAME];
    const char *names[MOST_NAMES] = { "help", "quiet", "output", "json" };
    int count = 4;
    for (int g = 0; g < command->group_count; g++)
        for (int32_t i = 0; i < pave_params_count(command->groups[g].table) && count < MOST_NAMES; i++) {
            pave_param param;
            pave_params_describe(command->groups[g].table, i, &param);
            option_name(store[count], param.name);
            names[count] = store[count];
            count++;
        }
    const char *near = nearest_name(typed, names, count);
    complain(command, "there is no option --%s%s%s%s; see pave %s --help", typed, near ? ", did you mean --" : "",
             near ? near : "", near ? "?" : "", command->verb);
    return EXIT_USAGE;
}

static void say(void *user, int32_t level, const char *text)
{
    (void)level;
    complain(user, "%s", text);
}

/* A palette is a list, or a file that holds one. */
static int set_palette(const cli_command *command, pave_context *tables, const cli_group *group, const char *name,
                       const char *value)
{
    char text[4096];
    if (*value == '#')
        return pave_params_set(tables, group->table, group->params, name, value) ? EXIT_USAGE : EXIT_FINE;
    FILE *file = fopen(value, "r");
    size_t n = file ? fread(text, 1, sizeof text, file) : 0;
    if (file)
        fclose(file);
    if (!file || n == sizeof text)
        return complain(command, "--%s %s is neither colours like #rrggbb nor a short file of them", name, value),
               EXIT_INPUT;
    text[n] = 0;
    return pave_params_set(tables, group->table, group->params, name, text) ? EXIT_INPUT : EXIT_FINE;
}

/* Sets "--name value" or "--name=value", or for a flag "--name" or "--no-name"; *used tells how many words it took. */
static int set_option(cli_command *command, pave_context *tables, int left, char **words, int *used)
{
    char name[NAME];
    pave_param param;
    const char *value = strchr(words[0], '=');
    size_t length = value ? (size_t)(value - words[0]) - 2 : strlen(words[0]) - 2;
    snprintf(name, sizeof name, "%.*s", (int)(length < NAME ? length : NAME - 1), words[0] + 2);
    const cli_group *group = find_option(command, name, &param);
    int no = !group && !value && !strncmp(name, "no-", 3);
    if (no)
        group = find_option(command, name + 3, &param);
    if (!group || (no && param.type != PAVE_PARAM_FLAG))
        return unknown_option(command, name);
    *used = 1;
    if (value)
        value++;
    else if (no)
        value = "0";
    else if (param.type == PAVE_PARAM_FLAG)
        value = "1";
    else if (left > 1)
        value = words[1], *used = 2;
    else
        return complain(command, "--%s needs a value", name), EXIT_USAGE;
    if (param.type == PAVE_PARAM_PALETTE)
        return set_palette(command, tables, group, name, value);
    return pave_params_set(tables, group->table, group->params, name + 3 * no, value) ? EXIT_USAGE : EXIT_FINE;
}

static int add_output(cli_command *command, const char *path)
{
    if (command->output_count == MOST_FILES) {
        complain(command, "more than %d outputs", MOST_FILES);
        return EXIT_USAGE;
    }
    command->output[command->output_count++] = path;
    return EXIT_FINE;
}

/* "--name FILE" or "--name=FILE" of the files that a verb takes by name; 0 if it is none of them. */
static int add_named(cli_command *command, int left, char **words, int *used, int *status)
{
    for (int i = 0; i < command->named_count; i++) {
        cli_named *named = &command->named[i];
        size_t length = strcspn(named->usage, " ");
        if (strncmp(words[0], "--", 2) || strncmp(words[0] + 2, named->usage, length))
            continue;
        const char *rest = words[0] + 2 + length;
        if (*rest && *rest != '=')
            continue;
        *status = EXIT_USAGE;
        if (named->count == named->most)
            complain(command, "--%.*s is given too often", (int)length, named->usage);
        else if (!*rest && left < 2)
            complain(command, "--%.*s needs a value", (int)length, named->usage);
        else
            named->value[named->count++] = *rest ? rest + 1 : words[1], *status = EXIT_FINE;
        *used = *rest ? 1 : 2;
        return 1;
    }
    return 0;
}

static int is_output(const char *word)
{
    return !strcmp(word, "-o") || !strcmp(word, "--output");
}

static int read_words(cli_command *command, pave_context *tables, int argc, char **argv)
{
    int status = EXIT_FINE, only_files = 0;
    for (int i = 1, used; i < argc && !status; i += used) {
        used = 1;
        if (only_files || argv[i][0] != '-' || !argv[i][1])
            argv[command->input_count++] = argv[i]; /* those before have been read */
        else if (!strcmp(argv[i], "--"))
            only_files = 1;
        else if (!strcmp(argv[i], "-h") || !strcmp(argv[i], "--help"))
            return print_help(command), -1;
        else if (!strcmp(argv[i], "-q") || !strcmp(argv[i], "--quiet"))
            command->quiet = 1;
        else if (command->json && !strcmp(argv[i], "--json"))
            command->wants_json = 1;
        else if (command->outputs && is_output(argv[i]) && i + 1 < argc)
            status = add_output(command, argv[i + (used = 2) - 1]);
        else if (command->outputs && !strncmp(argv[i], "--output=", 9))
            status = add_output(command, argv[i] + 9);
        else if (command->outputs && is_output(argv[i]))
            complain(command, "%s needs a file", argv[i]), status = EXIT_USAGE;
        else if (command->plans && i + 1 < argc && !strcmp(argv[i], "--manifest"))
            command->manifest = argv[i + (used = 2) - 1];
        else if (command->shards && i + 1 < argc && !strcmp(argv[i], "--shard"))
            command->shard = argv[i + (used = 2) - 1];
        else if (add_named(command, argc - i, argv + i, &used, &status))
            continue;
        else if (argv[i][1] == '-')
            status = set_option(command, tables, argc - i, argv + i, &used);
        else
            complain(command, "there is no option %s; see pave %s --help", argv[i], command->verb), status = EXIT_USAGE;
    }
    return status;
}

int read_command(cli_command *command, int argc, char **argv)
{
    pave_context *tables = NULL;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    params.message = say;
    params.message_user = command;
    if (pave_context_create(&params, &tables))
        return EXIT_RESOURCES;
    command->input = argv;
    int status = read_words(command, tables, argc, argv);
    pave_context_free(&tables);
    if (command->manifest)
        command->inputs = 0;
    int enough = command->inputs < 0 ? command->input_count > 0 : command->input_count == command->inputs;
    if (!status && !enough) {
        if (command->input_count <= command->inputs || command->inputs < 0)
            complain(command, "which file? usage: pave %s %s", command->verb, command->usage);
        else
            complain(command, "one file too many: %s", command->input[command->inputs]);
        status = EXIT_USAGE;
    }
    return status;
}
