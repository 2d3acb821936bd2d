/* A digital stone's measures in JSON. */
#include <pave/io.h>

#include "base/context.h"
#include "io/output.h"
#include "io/parameters.h"
#include "solid/solid.h"
#include "util/json.h"

#include <errno.h>
#include <string.h>

static void put_volume(pv_json *json, const pave_volume *volume)
{
    pv_json_string(json, "pave", pave_version());
    pv_json_string(json, "shape", pave_volume_shape(volume));
    pv_json_whole(json, "width", pave_volume_width(volume));
    pv_json_whole(json, "height", pave_volume_height(volume));
    pv_json_whole(json, "depth", pave_volume_depth(volume));
    pv_json_number(json, "spacing", pave_volume_spacing(volume));
    pv_json_array(json, "origin");
    for (int a = 0; a < 3; a++)
        pv_json_number(json, NULL, volume->origin[a]);
    pv_json_close(json);
}

/* What the stone was made with, with the choices that were left to the library: the mode, the levels. */
static void put_making(pv_json *json, const pave_volume *volume)
{
    if (volume->params.mode < 0)
        return;
    pv_json_whole(json, "samples", volume->samples);
    pv_json_whole(json, "labels", volume->labels);
    pv_json_whole(json, "flood_seeds", volume->seeds);
    pv_json_params(json, &pv_solid_table, &volume->params);
}

static void put_measure(pv_json *json, const pave_solid_measure *m)
{
    pv_json_whole(json, "voxels", m->voxels);
    pv_json_whole(json, "measured_voxels", m->measured_voxels);
    pv_json_number(json, "emd", m->emd);
    pv_json_number(json, "phase", m->phase);
    pv_json_number(json, "s2_rmse", m->s2_rmse);
    pv_json_number(json, "cov_error", m->cov_error);
    pv_json_number(json, "isotropy", m->isotropy);
    pv_json_number(json, "correlation_x", m->correlation[0]);
    pv_json_number(json, "correlation_y", m->correlation[1]);
    pv_json_number(json, "correlation_z", m->correlation[2]);
    pv_json_number(json, "correlation_reference", m->correlation_reference);
    pv_json_number(json, "sharpness", m->sharpness);
    pv_json_number(json, "speckle", m->speckle);
    pv_json_number(json, "slice_distance", m->slice_distance);
    pv_json_number(json, "walls", m->walls);
    pv_json_number(json, "measured", m->measured);
    pv_json_number(json, "use", m->use);
    pv_json_number(json, "constraint_error", m->constraint_error);
}

pave_result pave_solid_measure_write(pave_context *context, const pave_volume *volume,
                                     const pave_solid_measure *given, const char *path)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!volume || !given || !path)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_solid_measure_write: volume, measure or path is NULL");
    int before = errno;
    pv_json json;
    pv_output *output;
    pave_solid_measure measure;
    memset(&measure, 0, sizeof measure);
    memcpy(&measure, given, given->size < sizeof measure ? given->size : sizeof measure);
    pave_result result = pv_output_open(context, path, 0, &output);
    if (!result) {
        pv_json_begin(&json, pv_output_put, output);
        pv_json_object(&json, NULL);
        put_volume(&json, volume);
        put_making(&json, volume);
        put_measure(&json, &measure);
        pv_json_close(&json);
        result = pv_output_close(output, PAVE_OK);
    }
    errno = before;
    return result;
}
