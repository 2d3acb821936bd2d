/* Stones as a report in JSON: figures, parameters, versions. */
#include "io/exr.h"
#include "io/measures.h"
#include "io/output.h"
#include "io/parameters.h"
#include "io/pavement.h"

#include "base/params.h"
#include "cvd/cvd.h"
#include "field/field.h"
#include "image/image.h"
#include "mosaic/mosaic.h"
#include "util/json.h"

#include <stdio.h>
#include <string.h>

static void put_areas(pv_json *json, const pave_report *report)
{
    pv_json_object(json, "areas");
    pv_json_number(json, "step", report->area_step);
    pv_json_array(json, "counts");
    for (int32_t i = 0; i < PAVE_REPORT_BINS; i++)
        pv_json_whole(json, NULL, report->areas[i]);
    pv_json_close(json);
    pv_json_close(json);
}

/* How many stones there are of each colour. The pile knows it, unless its polygons are parts of cut stones. */
static pave_result count_colours(pave_context *context, pv_pile *pile, int64_t counts[256])
{
    pv_stone stone;
    pave_result result = PAVE_OK;
    memcpy(counts, pile->counts, 256 * sizeof *counts);
    if (pile->head.params.border != PAVE_BORDER_CUT)
        return PAVE_OK;
    memset(counts, 0, 256 * sizeof *counts);
    pile->rewind(pile);
    for (int64_t seen = 1; !result; seen++) {
        result = pile->next(context, pile, &stone);
        if (result || !stone.corners)
            break;
        counts[stone.colour] += !stone.part;
        if (seen % 4096 == 0)
            result = pv_progress(context, (double)seen / pile->head.count);
    }
    return result;
}

static void put_colours(pv_json *json, const pv_pile *pile, const int64_t counts[256])
{
    const pave_palette *palette = &pile->head.palette.palette;
    pv_json_object(json, "colours");
    for (int32_t i = 0; i < palette->count; i++) {
        char name[8];
        snprintf(name, sizeof name, "#%02x%02x%02x", palette->rgb[3 * i], palette->rgb[3 * i + 1],
                 palette->rgb[3 * i + 2]);
        pv_json_whole(json, name, counts[i]);
    }
    if (!palette->count) {
        pv_json_whole(json, "black", counts[0]);
        pv_json_whole(json, "white", counts[255]);
    }
    pv_json_close(json);
}

static void put_report(pv_json *json, const pave_report *report)
{
    pv_json_whole(json, "steps", report->steps);
    if (report->movement >= 0) /* not known of windows */
        pv_json_number(json, "movement", report->movement);
    pv_json_whole(json, "sites", report->sites);
    pv_json_whole(json, "stones", report->stones);
    pv_json_whole(json, "lost", report->lost);
    pv_json_whole(json, "repaired", report->repaired);
    pv_json_whole(json, "vanished", report->vanished);
    pv_json_whole(json, "reduced", report->reduced);
    pv_json_corners(json, "corners_before", report->corners_before);
    pv_json_corners(json, "corners_after", report->corners_after);
    pv_json_number(json, "quads", report->stones ? (double)report->corners_after[4] / report->stones : 0);
    put_areas(json, report);
    pv_json_number(json, "area_mean", report->area_mean);
    pv_json_number(json, "area_cv", report->area_mean > 0 ? report->area_deviation / report->area_mean : 0);
    pv_json_number(json, "coverage", report->coverage);
    pv_json_number(json, "half_side", report->half_side);
}

static void put_origin(pv_json *json, const pave_stones *stones)
{
    pv_json_string(json, "pave", pave_version());
    pv_json_object(json, "plane");
    pv_json_whole(json, "width", stones->plane_width);
    pv_json_whole(json, "height", stones->plane_height);
    pv_json_close(json);
    pv_json_object(json, "window");
    pv_json_whole(json, "x", stones->x);
    pv_json_whole(json, "y", stones->y);
    pv_json_whole(json, "width", stones->width);
    pv_json_whole(json, "height", stones->height);
    pv_json_close(json);
    pv_json_object(json, "parameters");
    pv_json_params(json, &pv_threshold_table, &stones->threshold);
    pv_json_params(json, &pv_palette_table, &stones->palette);
    pv_json_params(json, &pv_field_table, &stones->field);
    pv_json_params(json, &pv_cvd_table, &stones->cvd);
    pv_json_params(json, &pv_stones_table, &stones->params);
    pv_json_close(json);
    pv_json_unsigned(json, "seed", stones->cvd.seed);
    pv_json_string(json, "backend", stones->backend_name);
}

static void put_seconds_and_versions(pv_json *json, const pave_report *report)
{
    char version[32];
    pv_json_object(json, "seconds");
    pv_json_number(json, "field", report->seconds_field);
    pv_json_number(json, "cvd", report->seconds_cvd);
    pv_json_number(json, "stones", report->seconds_stones);
    pv_json_close(json);
    pv_exr_version(version, sizeof version);
    pv_json_object(json, "libraries");
    pv_json_string(json, "OpenEXR", version);
    pv_json_close(json);
}

static void put_mosaic(pv_json *json, const pave_stones *stones)
{
    const pave_mosaic_measure *m = &stones->mosaic->measure;
    pv_json_string(json, "pave", pave_version());
    pv_json_object(json, "plane");
    pv_json_whole(json, "width", stones->plane_width);
    pv_json_whole(json, "height", stones->plane_height);
    pv_json_close(json);
    pv_json_object(json, "parameters");
    pv_json_params(json, &pv_mosaic_table, &stones->mosaic->params);
    pv_json_close(json);
    pv_json_unsigned(json, "seed", stones->mosaic->params.seed);
    pv_json_string(json, "backend", stones->backend_name);
    pv_json_whole(json, "tiles", m->tiles);
    pv_json_whole(json, "chips", m->chips);
    pv_json_whole(json, "lost", m->lost);
    pv_json_whole(json, "singularities", m->singularities);
    const struct { const char *name; double value; } figures[] = {
        { "tile_side", m->tile_side }, { "coverage", m->coverage }, { "overlap", m->overlap },
        { "corners4", m->corners4 }, { "squareness", m->squareness }, { "aspect", m->aspect },
        { "side_cv", m->side_cv }, { "field_angle", m->field_angle }, { "edge_angle", m->edge_angle },
        { "straddlers", m->straddlers }, { "delta_e", m->delta_e }, { "delta_e_p95", m->delta_e_p95 },
        { "sizes_met", m->sizes_met }, { "size_error", m->size_error },
    };
    for (size_t i = 0; i < sizeof figures / sizeof *figures; i++)
        pv_json_number(json, figures[i].name, figures[i].value);
}

pave_result pv_report_write(pave_context *context, pv_pile *pile, const char *path)
{
    int64_t counts[256];
    pv_json json;
    pv_output *output;
    const pave_stones *stones = &pile->head;
    const pave_report *report = &stones->report;
    pave_result result = count_colours(context, pile, counts);
    if (!result)
        result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    pv_json_begin(&json, pv_output_put, output);
    pv_json_object(&json, NULL);
    if (stones->mosaic) {
        put_mosaic(&json, stones);
    } else {
        put_origin(&json, stones);
        put_report(&json, report);
        put_colours(&json, pile, counts);
        put_seconds_and_versions(&json, report);
    }
    pv_json_close(&json);
    return pv_output_close(output, PAVE_OK);
}
