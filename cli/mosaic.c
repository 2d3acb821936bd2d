/* pave mosaic: from a photo to oriented tiles. */
#include "cli.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_COLOURS = 4096, GROUPS = 3, NAMED = 4 };

/* What is read from files beside the photo. */
typedef struct extras {
    const char *edges, *directions, *sizes, *palette; /* names */
    pave_image *photo, *edge_image, *direction_image, *size_image;
    pave_curves *curves;
    uint8_t colours[3 * MOST_COLOURS];
    int32_t stock[MOST_COLOURS];
    int32_t colour_count, stocked;
} extras;

static int ends_in(const char *name, const char *ending)
{
    size_t n = strlen(name), e = strlen(ending);
    return n >= e && !strcmp(name + n - e, ending);
}

/* A line a colour: #rrggbb, and how many tesserae there are of it if that is limited. */
static int read_palette(const cli_command *command, extras *x)
{
    char line[256];
    FILE *file = fopen(x->palette, "r");
    if (!file)
        return complain(command, "%s: cannot be read", x->palette), EXIT_INPUT;
    for (int number = 1; fgets(line, sizeof line, file); number++) {
        unsigned r, g, b;
        long stock = -1;
        char rest;
        if (line[strspn(line, " \t\r\n")] == 0)
            continue;
        int read = sscanf(line, " #%2x%2x%2x %ld %c", &r, &g, &b, &stock, &rest);
        int fine = read == 3 || (read == 4 && stock >= 0 && stock <= INT32_MAX);
        if (!fine || x->colour_count == MOST_COLOURS) {
            complain(command, "%s, line %d: a colour is #rrggbb, and how many there are of it", x->palette, number);
            fclose(file);
            return EXIT_INPUT;
        }
        uint8_t *to = x->colours + 3 * x->colour_count;
        to[0] = (uint8_t)r, to[1] = (uint8_t)g, to[2] = (uint8_t)b;
        x->stocked |= read == 4;
        x->stock[x->colour_count++] = read == 4 ? (int32_t)stock : INT32_MAX;
    }
    fclose(file);
    return EXIT_FINE;
}

static int read_extras(const cli_command *command, pave_context *context, extras *x)
{
    pave_result result = read_image(context, command->input[0], &x->photo);
    if (!result && x->edges && ends_in(x->edges, ".svg"))
        result = pave_curves_read(context, x->edges, &x->curves);
    else if (!result && x->edges && strcmp(x->edges, "auto"))
        result = read_image(context, x->edges, &x->edge_image);
    if (!result && x->directions)
        result = read_image(context, x->directions, &x->direction_image);
    if (!result && x->sizes)
        result = read_image(context, x->sizes, &x->size_image);
    if (result)
        return exit_code(result, WHILE_READING);
    return x->palette ? read_palette(command, x) : EXIT_FINE;
}

static void free_extras(extras *x)
{
    pave_image_free(&x->photo);
    pave_image_free(&x->edge_image);
    pave_image_free(&x->direction_image);
    pave_image_free(&x->size_image);
    pave_curves_free(&x->curves);
}

static int run(const cli_command *command, pave_context *context, extras *x, const pave_mosaic_params *params)
{
    pave_mosaic_sources sources = PAVE_MOSAIC_SOURCES_INIT;
    pave_stones *stones = NULL;
    phase(0, 0.3);
    int status = read_extras(command, context, x);
    if (status)
        return status;
    sources.photo = x->photo;
    sources.curves = x->curves;
    sources.edges = x->edge_image;
    sources.direction = x->direction_image;
    sources.sizes = x->size_image;
    sources.palette = x->colour_count ? x->colours : NULL;
    sources.stock = x->stocked ? x->stock : NULL;
    sources.palette_count = x->colour_count;
    phase(0.3, 0.9);
    pave_result result = pave_mosaic_create(context, &sources, NULL, params, &stones);
    if (result)
        return exit_code(result, WHILE_WORKING);
    status = write_stones(command, context, stones);
    pave_stones_free(&stones);
    return status;
}

static int check_outputs(const cli_command *command)
{
    for (int i = 0; i < command->output_count; i++)
        if (!pave_stones_format(command->output[i]) || ends_in(command->output[i], ".stones"))
            return complain(command, "%s: an output ends in .svg, .png or .json", command->output[i]), EXIT_USAGE;
    if (command->output_count || command->wants_json)
        return EXIT_FINE;
    return complain(command, "where to? give -o FILE or --json"), EXIT_USAGE;
}

int mosaic_main(int argc, char **argv)
{
    static extras x;
    pave_mosaic_params params = PAVE_MOSAIC_PARAMS_INIT;
    pave_context_params machine = PAVE_CONTEXT_PARAMS_INIT;
    pave_limits limits = PAVE_LIMITS_INIT;
    const cli_group groups[GROUPS] = { { "Mosaic", PAVE_PARAMS_MOSAIC, &params },
                                       { "Machine", PAVE_PARAMS_CONTEXT, &machine },
                                       { "Limits", PAVE_PARAMS_LIMITS, &limits } };
    cli_named named[NAMED] = {
        { .usage = "edges FILE", .help = "curves.svg or a mask of lines that tiles follow; auto [found in the photo]" },
        { .usage = "directions FILE", .help = "the field itself, as an image: x and y of a vector" },
        { .usage = "sizes FILE", .help = "image of relative sides or regions; see --size-from" },
        { .usage = "palette FILE", .help = "colours in stock, a line each: #rrggbb, and their number" },
    };
    cli_command command = {
        .verb = "mosaic",
        .usage = "PHOTO -o FILE [-o FILE ...] [options]",
        .summary = "Lays a mosaic: turns a photo into tiles that follow its edges.",
        .outputs = "write mosaic.svg, a picture.png or a report.json; repeatable; - is stdout, as SVG",
        .json = "write the report to stdout",
        .inputs = 1,
        .named = named,
        .named_count = NAMED,
        .groups = groups,
        .group_count = GROUPS,
    };
    machine.limits = &limits;
    for (int i = 0; i < NAMED; i++)
        named[i].most = 1;
    int status = read_command(&command, argc, argv);
    if (!status)
        status = check_outputs(&command);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    x.edges = named[0].value[0];
    x.directions = named[1].value[0];
    x.sizes = named[2].value[0];
    x.palette = named[3].value[0];
    pave_context *context = start(&command, &machine);
    if (!context)
        return EXIT_USAGE;
    status = run(&command, context, &x, &params);
    free_extras(&x);
    finish(&context);
    return status;
}
