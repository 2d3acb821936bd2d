/* pave solid: a volume of stone from a flat sample. */
#include "cli.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SLICES = 16, MOST_CHANNELS = 8, LINE = 1024 };

/* The verb's own options. */
enum { SIZE, MESH, MEASURED, SLICE, PARTIAL, STATES, SLICES, SURFACE, CELLS, CELL_VOLUME, NAMED };

typedef struct solid_options {
    const char *size, *mesh, *measured, *partial, *states, *slices, *surface, *cells, *cell_volume;
    const char *const *slice;
    int slice_count;
} solid_options;

/* What is read and made. */
typedef struct solid_work {
    const cli_command *command;
    pave_context *context;
    const solid_options *options;
    pave_solid_params *params;
    pave_image *sample[3], *slice[MOST_SLICES];
    int32_t slice_places[2 * MOST_SLICES];
    pave_mesh *mesh;
    pave_volume *partial, *states, *volume;
    double *points, *values;
    int64_t point_count;
} solid_work;

static int bad(const solid_work *w, const char *option, const char *text, const char *wanted)
{
    complain(w->command, "%s is '%s', but must be %s", option, text, wanted);
    return EXIT_USAGE;
}

static int read_size(const solid_work *w)
{
    int32_t *to[3] = { &w->params->width, &w->params->height, &w->params->depth };
    const char *text = w->options->size;
    for (int i = 0; text && i < 3; i++) {
        char *end;
        long v = strtol(text, &end, 10);
        if (end == text || v < 1 || v > 1 << 20 || *end != (i < 2 ? ',' : 0))
            return bad(w, "--size", w->options->size, "X,Y,Z in voxels, each of 1 .. 1048576");
        *to[i] = (int32_t)v;
        text = end + 1;
    }
    return EXIT_FINE;
}

/* FILE,AXIS,INDEX */
static int read_slice(solid_work *w, int i)
{
    char path[4096];
    const char *text = w->options->slice[i], *index = strrchr(text, ','), *axis = index;
    while (axis && axis > text && *--axis != ',')
        ;
    if (!index || axis == text || axis[1] < 'x' || axis[1] > 'z' || index != axis + 2 || strlen(text) >= sizeof path)
        return bad(w, "--slice", text, "FILE,AXIS,INDEX as in cut.png,z,12");
    char *end;
    long place = strtol(index + 1, &end, 10);
    if (*end || end == index + 1 || place < 0 || place > 1 << 20)
        return bad(w, "--slice", text, "FILE,AXIS,INDEX as in cut.png,z,12");
    snprintf(path, sizeof path, "%.*s", (int)(axis - text), text);
    w->slice_places[2 * i] = axis[1] - 'x';
    w->slice_places[2 * i + 1] = (int32_t)place;
    return exit_code(read_image(w->context, path, &w->slice[i]), WHILE_READING);
}

/* x,y,z and a value for each channel. The numbers of a line; -1 if one is none. */
static int read_line(char *line, double *out)
{
    int count = 0;
    for (char *word = strtok(line, ",; \t\r\n"); word; word = strtok(NULL, ",; \t\r\n")) {
        char *end;
        if (count == 3 + MOST_CHANNELS)
            return -1;
        out[count] = strtod(word, &end); /* the program never sets a locale: the separator is '.' */
        if (*end || !isfinite(out[count++]))
            return -1;
    }
    return count;
}

static int add_point(solid_work *w, const double *numbers, int channels)
{
    if (w->point_count % 1024 == 0) {
        size_t room = (size_t)w->point_count + 1024;
        double *points = realloc(w->points, room * 3 * sizeof *points);
        w->points = points ? points : w->points;
        double *values = points ? realloc(w->values, room * (size_t)channels * sizeof *values) : NULL;
        w->values = values ? values : w->values;
        if (!values)
            return complain(w->command, "out of memory"), EXIT_RESOURCES;
    }
    memcpy(w->points + 3 * w->point_count, numbers, 3 * sizeof *numbers);
    memcpy(w->values + channels * w->point_count, numbers + 3, (size_t)channels * sizeof *numbers);
    w->point_count++;
    return EXIT_FINE;
}

/* The first line may be a heading. */
static int read_points(solid_work *w, const char *path, int channels)
{
    char line[LINE];
    double numbers[3 + MOST_CHANNELS];
    int status = EXIT_FINE;
    FILE *file = fopen(path, "r");
    if (!file)
        return complain(w->command, "%s: cannot be read: %s", path, strerror(errno)), EXIT_INPUT;
    for (long number = 1; !status && fgets(line, sizeof line, file); number++) {
        int blank = line[strspn(line, " \t\r\n")] == 0 || *line == '#', count = read_line(line, numbers);
        if (blank || (count < 0 && number == 1))
            continue;
        if (count != 3 + channels) {
            complain(w->command, "%s: line %ld is not x,y,z and %d finite value%s", path, number, channels,
                     channels > 1 ? "s" : "");
            status = EXIT_INPUT;
        } else
            status = add_point(w, numbers, channels);
    }
    fclose(file);
    return status;
}

/* Values, and what of them is known. */
static int join_states(solid_work *w)
{
    pave_volume_params p = PAVE_VOLUME_PARAMS_INIT;
    const pave_volume *v = w->partial, *s = w->states;
    pave_volume *joined = NULL;
    if (pave_volume_width(v) != pave_volume_width(s) || pave_volume_height(v) != pave_volume_height(s) ||
        pave_volume_depth(v) != pave_volume_depth(s) || pave_volume_type(s) != PAVE_U8)
        return complain(w->command, "--states is not of the size of --partial, or not of bytes"), EXIT_INPUT;
    p.width = pave_volume_width(v);
    p.height = pave_volume_height(v);
    p.depth = pave_volume_depth(v);
    p.channels = pave_volume_channels(v);
    p.type = pave_volume_type(v);
    p.spacing = pave_volume_spacing(v);
    memcpy(p.origin, pave_volume_origin(v), sizeof p.origin);
    pave_result result = pave_volume_create(w->context, &p, pave_volume_values(v), pave_volume_values(s), &joined);
    pave_volume_free(&w->partial);
    w->partial = joined;
    return exit_code(result, WHILE_READING);
}

static int read_inputs(solid_work *w)
{
    const solid_options *o = w->options;
    pave_result result = PAVE_OK;
    int status = read_size(w);
    if (!status && w->command->input_count != 1 && w->command->input_count != 3)
        complain(w->command, "give one sample, or three for the planes across x, y and z"), status = EXIT_USAGE;
    for (int i = 0; i < w->command->input_count && !status; i++)
        status = exit_code(read_image(w->context, w->command->input[i], &w->sample[i]), WHILE_READING);
    for (int i = 0; i < o->slice_count && !status; i++)
        status = read_slice(w, i);
    if (!status && o->measured)
        status = read_points(w, o->measured, pave_image_channels(w->sample[0]) - (pave_image_alpha(w->sample[0]) >= 0));
    if (!status && o->mesh)
        result = pave_mesh_read(w->context, o->mesh, &w->mesh);
    if (!status && !result && o->partial)
        result = pave_volume_read(w->context, o->partial, &w->partial);
    if (!status && !result && o->states)
        result = pave_volume_read(w->context, o->states, &w->states);
    status = status ? status : exit_code(result, WHILE_READING);
    return status || !w->states || !w->partial ? status : join_states(w);
}

static pave_result make(solid_work *w)
{
    pave_solid_input in = PAVE_SOLID_INPUT_INIT;
    for (int i = 0; i < 3; i++)
        in.exemplar[i] = w->sample[i];
    in.mesh = w->mesh;
    in.partial = w->partial;
    in.point_count = w->point_count;
    in.points = w->points;
    in.point_values = w->values;
    in.slice_count = w->options->slice_count;
    in.slices = (const pave_image *const *)w->slice;
    in.slice_places = w->slice_places;
    return pave_solid_create(w->context, &in, w->params, &w->volume);
}

/* PREFIX-x.png, -y.png, -z.png: the cuts through the middle. */
static pave_result write_slices(const solid_work *w, const char *prefix, int cells)
{
    const int32_t size[3] = { pave_volume_width(w->volume), pave_volume_height(w->volume),
                              pave_volume_depth(w->volume) };
    pave_result result = PAVE_OK;
    for (int32_t axis = 0; axis < 3 && !result; axis++) {
        char path[4096];
        pave_image *image = NULL;
        snprintf(path, sizeof path, "%s-%c.png", prefix, 'x' + axis);
        result = (cells ? pave_volume_slice_cells : pave_volume_slice)(w->context, w->volume, axis, size[axis] / 2,
                                                                        &image);
        if (!result)
            result = pave_image_write(w->context, image, path);
        pave_image_free(&image);
    }
    return result;
}

/* The number of each voxel's cell, from 1; 0 outside. */
static pave_result write_cells(const solid_work *w, const char *path)
{
    pave_volume_params p = PAVE_VOLUME_PARAMS_INIT;
    pave_volume *numbers = NULL;
    const int32_t *cells = pave_volume_cells(w->volume);
    p.width = pave_volume_width(w->volume);
    p.height = pave_volume_height(w->volume);
    p.depth = pave_volume_depth(w->volume);
    p.type = PAVE_F32;
    p.spacing = pave_volume_spacing(w->volume);
    memcpy(p.origin, pave_volume_origin(w->volume), sizeof p.origin);
    size_t count = (size_t)p.width * (size_t)p.height * (size_t)p.depth;
    float *values = calloc(count, sizeof *values);
    for (size_t i = 0; values && i < count; i++)
        values[i] = (float)(cells[i] + 1);
    pave_result result = values ? pave_volume_create(w->context, &p, values, NULL, &numbers) : PAVE_ERR_MEMORY;
    if (!result)
        result = pave_volume_write(w->context, numbers, path, NULL);
    pave_volume_free(&numbers);
    free(values);
    return result;
}

static pave_result write_outputs(const solid_work *w)
{
    const solid_options *o = w->options;
    pave_result result = PAVE_OK;
    for (int i = 0; i < w->command->output_count && !result; i++)
        result = pave_volume_write(w->context, w->volume, w->command->output[i], NULL);
    if (!result && o->slices)
        result = write_slices(w, o->slices, 0);
    if (!result && o->cells)
        result = write_slices(w, o->cells, 1);
    if (!result && o->cell_volume)
        result = write_cells(w, o->cell_volume);
    if (!result && o->surface)
        result = pave_surface_write(w->context, w->mesh, w->volume, o->surface);
    return result;
}

static int write_measure(const solid_work *w)
{
    pave_solid_measure measure = { .size = sizeof measure };
    pave_result result = pave_solid_measure_against(w->context, w->sample[0], w->volume, &measure);
    if (result)
        return exit_code(result, WHILE_WORKING);
    return exit_code(pave_solid_measure_write(w->context, w->volume, &measure, "-"), WHILE_WRITING);
}

static int run(solid_work *w)
{
    phase(0, 0.1);
    int status = read_inputs(w);
    phase(0.1, 0.9);
    pave_result result = status ? PAVE_OK : make(w);
    if (result == PAVE_ERR_ARGUMENT && (w->point_count || w->options->slice_count || w->partial))
        status = EXIT_INPUT; /* what was measured does not fit */
    else if (!status)
        status = exit_code(result, WHILE_WORKING);
    phase(0.9, 1);
    if (!status)
        status = exit_code(write_outputs(w), WHILE_WRITING);
    if (!status && w->command->wants_json)
        status = write_measure(w);
    return status;
}

static void clean_up(solid_work *w)
{
    for (int i = 0; i < 3; i++)
        pave_image_free(&w->sample[i]);
    for (int i = 0; i < MOST_SLICES; i++)
        pave_image_free(&w->slice[i]);
    pave_mesh_free(&w->mesh);
    pave_volume_free(&w->partial);
    pave_volume_free(&w->states);
    pave_volume_free(&w->volume);
    free(w->points);
    free(w->values);
}

/* What cannot be served is said before anything is read. */
static int check(const cli_command *command, const solid_options *o)
{
    for (int i = 0; i < command->output_count; i++)
        if (!pave_volume_format(command->output[i])) {
            complain(command, "%s: a volume is written as .nrrd, .nrrd.gz, .vti, .raw or .tif", command->output[i]);
            return EXIT_USAGE;
        }
    if (o->cell_volume && !pave_volume_format(o->cell_volume)) {
        complain(command, "%s: a volume is written as .nrrd, .nrrd.gz, .vti, .raw or .tif", o->cell_volume);
        return EXIT_USAGE;
    }
    if (!command->output_count && !command->wants_json && !o->slices && !o->surface && !o->cells &&
        !o->cell_volume)
        complain(command, "where to? give -o FILE.nrrd, --slices NAME, --surface FILE.ply or --json");
    else if (o->surface && !o->mesh)
        complain(command, "--surface needs a --mesh");
    else if (o->states && !o->partial)
        complain(command, "--states needs a --partial");
    else
        return EXIT_FINE;
    return EXIT_USAGE;
}

int solid_main(int argc, char **argv)
{
    pave_solid_params solid = PAVE_SOLID_PARAMS_INIT;
    pave_limits limits = PAVE_LIMITS_INIT;
    pave_context_params params = PAVE_CONTEXT_PARAMS_INIT;
    cli_named named[NAMED] = {
        [SIZE] = { .usage = "size X,Y,Z", .help = "voxels of the box [64,64,64]", .most = 1 },
        [MESH] = { .usage = "mesh FILE", .help = "the stone's shape: .obj, .ply or .stl", .most = 1 },
        [MEASURED] = { .usage = "measured FILE.csv", .help = "measurements to keep: lines of x,y,z,value...",
                       .most = 1 },
        [SLICE] = { .usage = "slice FILE,AXIS,INDEX", .help = "a picture to keep, on a plane of voxels; repeatable",
                    .most = MOST_SLICES },
        [PARTIAL] = { .usage = "partial FILE", .help = "a volume to keep; NaN is free", .most = 1 },
        [STATES] = { .usage = "states FILE", .help = "what of it: 0 outside, 1 free, 2 measured", .most = 1 },
        [SLICES] = { .usage = "slices NAME", .help = "write the three middle cuts, NAME-x.png ...", .most = 1 },
        [SURFACE] = { .usage = "surface FILE.ply", .help = "write the mesh with colours from the volume", .most = 1 },
        [CELL_VOLUME] = { .usage = "cells-volume FILE", .help = "write the number of each voxel's cell, 0 outside",
                          .most = 1 },
        [CELLS] = { .usage = "cells-slices NAME", .help = "write the same cuts of the flood's cells", .most = 1 },
    };
    const cli_group groups[] = {
        { "Stone", PAVE_PARAMS_SOLID, &solid },
        { "Machine", PAVE_PARAMS_CONTEXT, &params },
        { "Limits", PAVE_PARAMS_LIMITS, &limits },
    };
    cli_command command = {
        .verb = "solid",
        .usage = "SAMPLE [SAMPLE SAMPLE] -o FILE.nrrd [options]",
        .summary = "Makes a volume that looks in every direction like the sample, keeping what was measured. Three\n"
                   "samples are those of the planes across x, y and z, for layered stone.",
        .outputs = "write .nrrd, .nrrd.gz, .vti, .raw or .tif; repeatable",
        .json = "measures of the stone against its sample on stdout",
        .inputs = -1,
        .groups = groups,
        .group_count = sizeof groups / sizeof *groups,
        .named = named,
        .named_count = NAMED,
    };
    params.limits = &limits;
    int status = read_command(&command, argc, argv);
    const solid_options o = {
        named[SIZE].value[0], named[MESH].value[0], named[MEASURED].value[0], named[PARTIAL].value[0],
        named[STATES].value[0], named[SLICES].value[0], named[SURFACE].value[0], named[CELLS].value[0],
        named[CELL_VOLUME].value[0], named[SLICE].value, named[SLICE].count,
    };
    if (!status)
        status = check(&command, &o);
    if (status)
        return status < 0 ? EXIT_FINE : status;
    solid.cells = solid.cells || o.cells || o.cell_volume;
    solid_work w = { .command = &command, .options = &o, .params = &solid };
    w.context = start(&command, &params);
    if (!w.context)
        return EXIT_USAGE;
    status = run(&w);
    clean_up(&w);
    finish(&w.context);
    return status;
}
