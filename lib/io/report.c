/* Stones as a report in JSON: figures, parameters, versions. */
#include "io/exr.h"
#include "io/output.h"
#include "io/parameters.h"
#include "io/pavement.h"

#include "base/params.h"
#include "cvd/cvd.h"
#include "field/field.h"
#include "image/image.h"
#include "util/json.h"

#include <string.h>

static void put(void *user, const char *text, size_t length)
{
    pv_output_bytes(user, text, length);
}

/* Stones by number of corners; the last bin, "31+", is for that many or more. */
static void put_corners(pv_json *json, const char *key, const int64_t *counts)
{
    pv_json_object(json, key);
    for (int32_t i = 0; i < PAVE_MEASURE_BINS; i++) {
        char corners[8] = { 0 };
        if (!counts[i])
            continue;
        corners[0] = (char)(i < 10 ? '0' + i : '0' + i / 10);
        if (i >= 10)
            corners[1] = (char)('0' + i % 10);
        if (i == PAVE_MEASURE_BINS - 1)
            corners[2] = '+';
        pv_json_whole(json, corners, counts[i]);
    }
    pv_json_close(json);
}

static void put_areas(pv_json *json, const pave_measure *measure)
{
    pv_json_object(json, "areas");
    pv_json_number(json, "step", measure->area_step);
    pv_json_array(json, "counts");
    for (int32_t i = 0; i < PAVE_MEASURE_BINS; i++)
        pv_json_whole(json, NULL, measure->areas[i]);
    pv_json_close(json);
    pv_json_close(json);
}

static void put_measure(pv_json *json, const pave_measure *measure)
{
    pv_json_whole(json, "steps", measure->steps);
    if (measure->movement >= 0) /* not known of windows */
        pv_json_number(json, "movement", measure->movement);
    pv_json_whole(json, "sites", measure->sites);
    pv_json_whole(json, "stones", measure->stones);
    pv_json_whole(json, "lost", measure->lost);
    pv_json_whole(json, "repaired", measure->repaired);
    put_corners(json, "corners_before", measure->corners_before);
    put_corners(json, "corners_after", measure->corners_after);
    pv_json_number(json, "quads", measure->stones ? (double)measure->corners_after[4] / measure->stones : 0);
    put_areas(json, measure);
    pv_json_number(json, "area_mean", measure->area_mean);
    pv_json_number(json, "area_cv", measure->area_mean > 0 ? measure->area_deviation / measure->area_mean : 0);
    pv_json_number(json, "coverage", measure->coverage);
    pv_json_number(json, "half_side", measure->half_side);
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
    pv_json_params(json, &pv_field_table, &stones->field);
    pv_json_params(json, &pv_cvd_table, &stones->cvd);
    pv_json_params(json, &pv_stones_table, &stones->params);
    pv_json_close(json);
    pv_json_unsigned(json, "seed", stones->cvd.seed);
    pv_json_string(json, "backend", stones->backend_name);
}

static void put_seconds_and_versions(pv_json *json, const pave_measure *measure)
{
    char version[32];
    pv_json_object(json, "seconds");
    pv_json_number(json, "field", measure->seconds_field);
    pv_json_number(json, "cvd", measure->seconds_cvd);
    pv_json_number(json, "stones", measure->seconds_stones);
    pv_json_close(json);
    pv_exr_version(version, sizeof version);
    pv_json_object(json, "libraries");
    pv_json_string(json, "OpenEXR", version);
    pv_json_close(json);
}

pave_result pv_report_write(pave_context *context, const pave_stones *stones, const char *path)
{
    pv_json json;
    pv_output *output;
    const pave_measure *measure = &stones->measure;
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    pv_json_begin(&json, put, output);
    pv_json_object(&json, NULL);
    put_origin(&json, stones);
    put_measure(&json, measure);
    put_seconds_and_versions(&json, measure);
    pv_json_close(&json);
    return pv_output_close(output, PAVE_OK);
}
