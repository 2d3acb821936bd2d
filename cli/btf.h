/* What the verbs of pave btf share. */
#pragma once

#include "cli.h"

/* One of them, from its command line to its end. */
typedef struct btf_job {
    cli_command command; /* filled in by the verb, but for its groups */
    cli_group groups[4];
    pave_btf_file_params files;
    pave_limits limits;
    pave_context_params machine;
    pave_context *context;
} btf_job;

/* Reads the command line, with the verb's `own` group of options unless that has no title, and opens the context.
 * EXIT_FINE; otherwise nothing is left to do but btf_end. */
int btf_begin(btf_job *job, cli_group own, int argc, char **argv);

/* Frees the job; returns the exit code for the verb's last status. */
int btf_end(btf_job *job, int status);

/* Sets the options `names` of a table from a list as in "--light 30,120", which may be shorter than that by all but
 * `least`; nothing if it is not given. */
int btf_set_list(const btf_job *job, const cli_named *list, const cli_group *group, const char *const *names,
                 int count, int least);

/* The number that an option of the verb's own gives. */
int btf_read_number(const btf_job *job, const cli_named *option, double least, double greatest, double *number);

/* Does a path end in .model, as a model's file does? */
int btf_names_model(const char *path);

/* Read an input, and write the one output, while the progress bar goes that far. */
int btf_read(const btf_job *job, int input, double from, double to, pave_btf **out);
int btf_write(const btf_job *job, const pave_btf *btf, double from);

int btf_synthesize(int argc, char **argv);
int btf_compress(int argc, char **argv);
int btf_convert(int argc, char **argv);
int btf_merge(int argc, char **argv);
int btf_view(int argc, char **argv);
int btf_plot(int argc, char **argv);
int btf_sheet(int argc, char **argv);
int btf_info(int argc, char **argv);
int btf_measure(int argc, char **argv);
int btf_model(int argc, char **argv);
int btf_plan(int argc, char **argv);
int btf_reconstruct(int argc, char **argv);
int btf_enlarge(int argc, char **argv);
