/* Params structs as JSON objects, both ways, by their tables. */
#pragma once

#include "base/params.h"
#include "util/json.h"

/* Writes an object named after the table. */
void pv_json_params(pv_json *json, const pv_table *table, const void *params);

/* Reads such an object, a member of `parent` (cJSON), into an initialised struct. What it does not name keeps its
 * value; what the table does not know is PAVE_ERR_TOO_NEW. */
pave_result pv_json_read_params(pave_context *context, const char *path, const void *parent, const pv_table *table,
                                void *params);
