/* Measures of stones as members of a JSON object. */
#pragma once

#include "stones/stones.h"
#include "util/json.h"

void pv_json_measures(pv_json *json, const char *key, const pave_stones_measures *measures);

/* Stones by number of corners; the last bin, "31+", is for that many or more. */
void pv_json_corners(pv_json *json, const char *key, const int64_t *counts);
