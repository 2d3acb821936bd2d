/* How near a texture's statistics came to those wanted, in JSON. */
#include <pave/io.h>

#include "io/output.h"
#include "io/parameters.h"
#include "statistics/statistics.h"

#include <errno.h>

static void put_groups(pv_json *json, const pave_statistics_report *r)
{
    pv_json_object(json, "groups");
    pv_json_number(json, "pixels", r->pixels);
    pv_json_number(json, "shape", r->shape);
    pv_json_number(json, "low_shape", r->low_shape);
    pv_json_number(json, "low_correlation", r->low_correlation);
    pv_json_number(json, "high", r->high);
    pv_json_number(json, "magnitude", r->magnitude);
    pv_json_number(json, "magnitude_correlation", r->magnitude_correlation);
    pv_json_number(json, "orientations", r->orientations);
    pv_json_number(json, "scales", r->scales);
    pv_json_number(json, "phase", r->phase);
    pv_json_number(json, "channels", r->channels);
    pv_json_number(json, "channel_magnitudes", r->channel_magnitudes);
    pv_json_close(json);
}

static void put_report(pv_json *json, const pave_statistics *wanted, const pave_statistics_synthesis_params *params,
                       const pave_statistics_report *report)
{
    pv_json_object(json, NULL);
    pv_json_string(json, "pave", pave_version());
    pv_json_object(json, "parameters");
    pv_json_params(json, &pv_statistics_table, &wanted->params);
    if (params)
        pv_json_params(json, &pv_statistics_synthesis_table, params);
    pv_json_close(json);
    pv_json_whole(json, "statistics", pave_statistics_count(wanted));
    pv_json_number(json, "distance", report->distance);
    put_groups(json, report);
    pv_json_close(json);
}

pave_result pave_statistics_write(pave_context *context, const pave_statistics *wanted,
                                  const pave_statistics_synthesis_params *params,
                                  const pave_statistics_report *report, const char *path)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!wanted || !report || !path)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_statistics_write: statistics, report or path is NULL");
    int before = errno;
    pv_json json;
    pv_output *output;
    pave_result result = pv_output_open(context, path, 0, &output);
    if (!result) {
        pv_json_begin(&json, pv_output_put, output);
        put_report(&json, wanted, params, report);
        result = pv_output_close(output, PAVE_OK);
    }
    errno = before;
    return result;
}
