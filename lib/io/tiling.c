/* A tiling's report in JSON: figures, parameters, and the index of a set of Wang tiles. */
#include <pave/io.h>

#include "io/output.h"
#include "io/parameters.h"
#include "tiling/tiling.h"

#include <errno.h>

static void put_measure(pv_json *json, const pave_tiling_measure *m)
{
    pv_json_object(json, "measure");
    pv_json_number(json, "seam_x", m->seam_x);
    pv_json_number(json, "seam_y", m->seam_y);
    pv_json_number(json, "worst_line", m->worst_line);
    pv_json_number(json, "coherence", m->coherence);
    pv_json_number(json, "completeness", m->completeness);
    pv_json_number(json, "entropy", m->entropy);
    pv_json_number(json, "overuse", m->overuse);
    pv_json_number(json, "histogram", m->histogram);
    pv_json_number(json, "sliced", m->sliced);
    pv_json_number(json, "sharpness", m->sharpness);
    pv_json_number(json, "seam_energy", m->seam_energy);
    pv_json_number(json, "seam_share", m->seam_share);
    pv_json_number(json, "seam_inner", m->seam_inner);
    pv_json_number(json, "joint_share", m->joint_share);
    pv_json_number(json, "stone_ratio", m->stone_ratio);
    pv_json_number(json, "repeat", m->repeat);
    pv_json_close(json);
}

static void put_tile(pv_json *json, const pave_wang_tile *tile)
{
    pv_json_object(json, NULL);
    pv_json_whole(json, "x", tile->x);
    pv_json_whole(json, "y", tile->y);
    pv_json_whole(json, "north", tile->north);
    pv_json_whole(json, "east", tile->east);
    pv_json_whole(json, "south", tile->south);
    pv_json_whole(json, "west", tile->west);
    pv_json_close(json);
}

static void put_tiles(pv_json *json, const pave_tiling *tiling)
{
    pv_json_object(json, "wang");
    pv_json_whole(json, "colours", tiling->params.wang);
    pv_json_whole(json, "tile_width", tiling->tile_width);
    pv_json_whole(json, "tile_height", tiling->tile_height);
    pv_json_array(json, "tiles");
    for (int32_t i = 0; i < tiling->tile_count; i++)
        put_tile(json, &tiling->tiles[i]);
    pv_json_close(json);
    pv_json_close(json);
}

static void put_tiling(pv_json *json, const pave_tiling *tiling, const pave_tiling_measure *measure)
{
    pv_json_object(json, NULL);
    pv_json_string(json, "pave", pave_version());
    pv_json_whole(json, "width", tiling->width);
    pv_json_whole(json, "height", tiling->height);
    pv_json_whole(json, "exemplars", tiling->exemplars);
    pv_json_object(json, "parameters");
    pv_json_params(json, &pv_tiling_table, &tiling->params);
    pv_json_close(json);
    pv_json_number(json, "feature", tiling->feature);
    if (measure)
        put_measure(json, measure);
    if (tiling->tile_count)
        put_tiles(json, tiling);
    pv_json_number(json, "seconds", tiling->seconds);
    pv_json_close(json);
}

pave_result pave_tiling_write(pave_context *context, const pave_tiling *tiling, const pave_tiling_measure *measure,
                              const char *path)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    if (!tiling || !path)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "pave_tiling_write: tiling or path is NULL");
    int before = errno;
    pv_json json;
    pv_output *output;
    pave_result result = pv_output_open(context, path, 0, &output);
    if (!result) {
        pv_json_begin(&json, pv_output_put, output);
        put_tiling(&json, tiling, measure);
        result = pv_output_close(output, PAVE_OK);
    }
    errno = before;
    return result;
}
