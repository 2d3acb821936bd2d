/* The command line: a small client of the library. */
#pragma once

#include <pave/pave.h>

/* Exit codes; documented in `pave --help` and docs/cli.md. */
enum {
    EXIT_FINE = 0,
    EXIT_USAGE = 2,     /* a mistyped verb, option or value */
    EXIT_INPUT = 3,     /* an input that is missing, damaged or not what it should be */
    EXIT_LIMIT = 4,     /* the job is beyond the limits */
    EXIT_RESOURCES = 5, /* no memory, no disk, or an output that cannot be written */
    EXIT_DEVICE = 6,    /* the graphics device asked for is missing or failed */
    EXIT_FAULT = 7,     /* a fault of the library */
    EXIT_CANCELLED = 130
};

/* What the library was doing when it failed: a file that cannot be read is an input, one that cannot be written is
 * not. */
enum { WHILE_READING, WHILE_WORKING, WHILE_WRITING };
int exit_code(pave_result result, int doing);

/* Options of one params struct. */
typedef struct cli_group {
    const char *title;
    int32_t table;
    void *params;
} cli_group;

/* The params of laying, and their groups. */
enum { LAY_GROUPS = 8 };
typedef struct lay_options {
    pave_threshold_params threshold;
    pave_palette_params palette;
    pave_field_params field;
    pave_cvd_params cvd;
    pave_stones_params stones;
    pave_stream_params stream;
    pave_limits limits; /* max_pixels 0: not given */
    pave_context_params context;
    pave_lay_params lay; /* points at the ones above */
    cli_group groups[LAY_GROUPS];
} lay_options;

void lay_options_init(lay_options *options);

enum { MOST_FILES = 16 };

/* A file, or more, that a verb takes by an option of its own. */
typedef struct cli_named {
    const char *usage; /* "guide FILE" */
    const char *help;
    int most;
    const char *value[MOST_FILES];
    int count;
} cli_named;

/* A verb's command line, taken apart. */
typedef struct cli_command {
    const char *verb;
    const char *usage;   /* "DRAWING -o FILE..." */
    const char *summary; /* what it does, a few lines */
    const char *outputs; /* help text of -o; NULL: the verb has no -o */
    const char *json;    /* help text of --json; NULL: none */
    int inputs;          /* how many it needs; -1: any number but 0 */
    const cli_group *groups;
    int group_count;
    cli_named *named;
    int named_count;
    char **input; /* within argv */
    const char *output[MOST_FILES];
    int input_count, output_count;
    int wants_json, quiet;
    int plans, shards;     /* the verb knows --manifest; and --shard */
    const char *manifest, *shard;
} cli_command;

/* Reads argv[1..] into `command` and its groups. EXIT_FINE; EXIT_USAGE after a sentence on stderr; -1 after --help. */
int read_command(cli_command *command, int argc, char **argv);

/* The nearest of `count` names to a mistyped one, NULL if none is near. */
const char *nearest_name(const char *typed, const char *const *names, int count);

/* One line on stderr: "pave lay: sentence". */
void complain(const cli_command *command, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* A context that writes messages and progress to stderr and is cancelled by Ctrl-C. NULL after a sentence. */
pave_context *start(const cli_command *command, pave_context_params *params);
void finish(pave_context **context);

/* What share of the verb the next calls into the library are, for the progress bar. */
void phase(double from, double to);

/* pave_image_read, during which Ctrl-C does not wait: loading the module that reads PNG can take 0.3 s. */
pave_result read_image(pave_context *context, const char *path, pave_image **out);

/* Writes stones to every -o and, if asked to, the report to stdout: the last tenth of a verb. Returns its exit code. */
int write_stones(const cli_command *command, pave_context *context, const pave_stones *stones);

/* Verbs */
int lay_main(int argc, char **argv);
int field_main(int argc, char **argv);
int solid_main(int argc, char **argv);
int info_main(int argc, char **argv);
int merge_main(int argc, char **argv);
int mosaic_main(int argc, char **argv);
int plan_main(int argc, char **argv);
int measure_main(int argc, char **argv);
int tile_main(int argc, char **argv);
int statistics_main(int argc, char **argv);
int maps_main(int argc, char **argv);
int btf_main(int argc, char **argv);
