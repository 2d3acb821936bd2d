/* pave btf: bidirectional texture functions made, compressed, converted and told of. */
#include "btf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int btf_begin(btf_job *job, cli_group own, int argc, char **argv)
{
    cli_command *command = &job->command;
    pave_btf_file_params_init(&job->files, sizeof job->files);
    pave_limits_init(&job->limits, sizeof job->limits);
    pave_context_params_init(&job->machine, sizeof job->machine);
    job->machine.limits = &job->limits;
    if (own.title)
        job->groups[command->group_count++] = own;
    job->groups[command->group_count++] = (cli_group){ "Files", PAVE_PARAMS_BTF_FILE, &job->files };
    job->groups[command->group_count++] = (cli_group){ "Machine", PAVE_PARAMS_CONTEXT, &job->machine };
    job->groups[command->group_count++] = (cli_group){ "Limits", PAVE_PARAMS_LIMITS, &job->limits };
    command->groups = job->groups;
    int status = read_command(command, argc, argv);
    if (!status && command->outputs && command->output_count != 1)
        complain(command, "where to? give one -o FILE"), status = EXIT_USAGE;
    if (!status && !(job->context = start(command, &job->machine)))
        status = EXIT_USAGE;
    return status;
}

int btf_end(btf_job *job, int status)
{
    if (job->context)
        finish(&job->context);
    return status < 0 ? EXIT_FINE : status; /* after --help */
}

int btf_set_list(const btf_job *job, const cli_named *list, const cli_group *group, const char *const *names,
                 int count, int least)
{
    const char *rest = list->value[0];
    int k = 0;
    for (; rest && k < count; k++) {
        char piece[64];
        size_t length = strcspn(rest, ",");
        snprintf(piece, sizeof piece, "%.*s", (int)length, rest);
        if (pave_params_set(job->context, group->table, group->params, names[k], piece))
            return EXIT_USAGE;
        rest = rest[length] ? rest + length + 1 : NULL;
    }
    if (!rest && (k >= least || !list->count))
        return EXIT_FINE;
    complain(&job->command, "--%s is meant, not %s", list->usage, list->value[0]);
    return EXIT_USAGE;
}

int btf_read_number(const btf_job *job, const cli_named *option, double least, double greatest, double *number)
{
    char *end = NULL;
    if (!option->count)
        return EXIT_FINE;
    *number = strtod(option->value[0], &end); /* the program never sets a locale: the separator is '.' */
    if (end != option->value[0] && !*end && *number >= least && *number <= greatest)
        return EXIT_FINE;
    complain(&job->command, "--%s is meant, from %.0f to %.0f, not %s", option->usage, least, greatest,
             option->value[0]);
    return EXIT_USAGE;
}

int btf_read(const btf_job *job, int input, double from, double to, pave_btf **out)
{
    phase(from, to);
    return exit_code(pave_btf_read(job->context, job->command.input[input], &job->files, out), WHILE_READING);
}

int btf_write(const btf_job *job, const pave_btf *btf, double from)
{
    phase(from, 1);
    return exit_code(pave_btf_write(job->context, btf, &job->files, job->command.output[0]), WHILE_WRITING);
}

static const struct {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *summary;
} verbs[] = {
    { "synthesize", btf_synthesize, "make one: a relief of stone under all lights, from all views" },
    { "compress", btf_compress, "factor one, with a known error" },
    { "convert", btf_convert, "write one in another format" },
    { "view", btf_view, "draw one on a plane, a cylinder or a sphere" },
    { "plot", btf_plot, "draw an ABRDF: for each view a disc of all lights" },
    { "sheet", btf_sheet, "draw textures under some lights from some views, side by side" },
    { "info", btf_info, "tell what one holds and how sound it is" },
    { "measure", btf_measure, "tell how far one is from another" },
    { "merge", btf_merge, "find one basis for several factored ones" },
    { "model", btf_model, "fit a model to a class of materials" },
    { "plan", btf_plan, "choose which pairs of view and light to measure" },
    { "reconstruct", btf_reconstruct, "make a whole one of a few pairs" },
    { "enlarge", btf_enlarge, "make one of a large piece from a small region and a few photographs" },
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
