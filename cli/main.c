/* pave: drawings into pavements. Finds the verb and runs it. */
#include "cli.h"

#include <stdio.h>
#include <string.h>

typedef struct verb {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *summary;
} verb;

static const verb verbs[] = {
    { "lay", lay_main, "lay a pavement: from a black and white drawing to the polygons of its stones" },
    { "mosaic", mosaic_main, "lay a mosaic: from a photo to oriented tiles that follow its edges" },
    { "plan", plan_main, "divide a large pavement into windows, for many machines" },
    { "merge", merge_main, "merge windows that were laid one by one into one file" },
    { "measure", measure_main, "judge stones against their drawing" },
    { "tile", tile_main, "make a larger texture, or one that repeats without a seam, from a small one" },
    { "statistics", statistics_main, "make another texture with the statistics of one, from noise" },
    { "field", field_main, "write the distance field of a drawing" },
    { "solid", solid_main, "make a volume of stone from a flat sample" },
    { "maps", maps_main, "maps and models of a pavement, for renderers" },
    { "btf", btf_main, "bidirectional texture functions: make, compress, convert, look at them" },
    { "info", info_main, "list backends, devices and versions" },
};

enum { VERBS = sizeof verbs / sizeof *verbs };

static void print_help(FILE *to)
{
    fputs("usage: pave VERB ...\n\n", to);
    for (int i = 0; i < VERBS; i++)
        fprintf(to, "  pave %-10s %s\n", verbs[i].name, verbs[i].summary);
    fputs("\n  pave VERB --help    the verb's options\n"
          "  pave --version      the version\n\n"
          "example: pave lay drawing.png -o stones.svg\n\n"
          "exit status: 0 done, 2 mistyped, 3 bad input, 4 beyond a limit, 5 no memory or disk,\n"
          "6 no such device, 7 a fault of pave itself, 130 cancelled\n", to);
}

static int unknown_verb(const char *typed)
{
    const char *names[VERBS];
    for (int i = 0; i < VERBS; i++)
        names[i] = verbs[i].name;
    const char *near = nearest_name(typed, names, VERBS);
    fprintf(stderr, "pave: there is no verb '%s'%s%s%s; see pave --help\n", typed, near ? ", did you mean '" : "",
            near ? near : "", near ? "'?" : "");
    return EXIT_USAGE;
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        print_help(stderr);
        return EXIT_USAGE;
    }
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h") || !strcmp(argv[1], "help"))
        return print_help(stdout), EXIT_FINE;
    if (!strcmp(argv[1], "--version"))
        return printf("pave %s\n", pave_version()), EXIT_FINE;
    for (int i = 0; i < VERBS; i++)
        if (!strcmp(argv[1], verbs[i].name))
            return verbs[i].run(argc - 1, argv + 1);
    return unknown_verb(argv[1]);
}
