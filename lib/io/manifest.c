/* A plan as a JSON file. */
#include "io/manifest.h"

#include "io/input.h"
#include "io/output.h"
#include "io/parameters.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LARGEST = 64 << 20 };

pv_rect pv_manifest_window(const pv_manifest *m, int32_t k)
{
    int64_t column = k % m->columns, row = k / m->columns, w = m->width, h = m->height;
    int32_t left = (int32_t)(w * column / m->columns), top = (int32_t)(h * row / m->rows);
    return (pv_rect){ left, top, (int32_t)(w * (column + 1) / m->columns) - left,
                      (int32_t)(h * (row + 1) / m->rows) - top };
}

enum { WINDOW_TEXT = 64 };

static void window_text(const pv_manifest *m, int32_t k, char text[WINDOW_TEXT])
{
    pv_rect w = pv_manifest_window(m, k);
    snprintf(text, WINDOW_TEXT, "%d,%d,%d,%d", (int)w.x, (int)w.y, (int)w.width, (int)w.height);
}

static void put_windows(pv_json *json, const pv_manifest *m)
{
    pv_json_array(json, "windows");
    for (int32_t k = 0; k < m->columns * m->rows; k++) {
        char text[WINDOW_TEXT];
        window_text(m, k, text);
        pv_json_string(json, NULL, text);
    }
    pv_json_close(json);
}

pave_result pv_manifest_write(pave_context *context, const pv_manifest *m, const char *path)
{
    pv_json json;
    pv_output *output;
    char hash[20];
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    snprintf(hash, sizeof hash, "%016llx", (unsigned long long)m->hash);
    pv_json_begin(&json, pv_output_put, output);
    pv_json_object(&json, NULL);
    pv_json_string(&json, "pave", pave_version());
    pv_json_string(&json, "drawing", m->drawing);
    pv_json_string(&json, "hash", hash);
    pv_json_whole(&json, "width", m->width);
    pv_json_whole(&json, "height", m->height);
    pv_json_object(&json, "parameters");
    pv_json_params(&json, &pv_threshold_table, &m->threshold);
    pv_json_params(&json, &pv_palette_table, &m->palette);
    pv_json_params(&json, &pv_field_table, &m->field);
    pv_json_params(&json, &pv_cvd_table, &m->cvd);
    pv_json_params(&json, &pv_stones_table, &m->stones);
    pv_json_close(&json);
    pv_json_whole(&json, "columns", m->columns);
    pv_json_whole(&json, "rows", m->rows);
    pv_json_whole(&json, "margin", m->margin);
    put_windows(&json, m);
    pv_json_close(&json);
    return pv_output_close(output, PAVE_OK);
}

static pave_result read_text(pave_context *context, const char *path, char **out)
{
    pv_input input;
    *out = NULL;
    pave_result result = pv_input_open(context, path, &input);
    if (!result && input.size > LARGEST)
        result = pv_fail(context, PAVE_ERR_FORMAT, "%s: is not a plan", path);
    char *text = result ? NULL : pv_allocate_zeroed(context, (size_t)input.size + 1, 1, &result);
    if (text)
        result = pv_input_read(&input, 0, text, input.size);
    pv_input_close(&input);
    if (result)
        pv_release(text);
    else
        *out = text;
    return result;
}

static int32_t number(const cJSON *json, const char *key, int32_t most)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, key);
    int good = cJSON_IsNumber(item) && item->valuedouble >= 1 && item->valuedouble <= most;
    return good && item->valuedouble == (int32_t)item->valuedouble ? (int32_t)item->valuedouble : 0;
}

/* 16 digits; 0 if it is anything else. */
static uint64_t hash(const char *text)
{
    return strspn(text, "0123456789abcdef") == 16 && !text[16] ? strtoull(text, NULL, 16) : 0;
}

static const char *string(const cJSON *json, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, key);
    return cJSON_IsString(item) ? item->valuestring : "";
}

/* The windows are there to be read by others; they follow from the columns and rows, and must not say anything else. */
static pave_result check_windows(pave_context *context, const char *path, const cJSON *json, const pv_manifest *m)
{
    const cJSON *windows = cJSON_GetObjectItemCaseSensitive(json, "windows"), *item;
    int32_t k = 0, count = m->columns * m->rows;
    int good = cJSON_IsArray(windows);
    cJSON_ArrayForEach(item, windows)
    {
        char text[WINDOW_TEXT];
        if (k < count)
            window_text(m, k, text);
        good &= k++ < count && cJSON_IsString(item) && !strcmp(item->valuestring, text);
    }
    return good && k == count ? PAVE_OK
                              : pv_fail(context, PAVE_ERR_FORMAT,
                                        "%s: is a damaged plan: its windows are not those of %d columns and %d rows",
                                        path, (int)m->columns, (int)m->rows);
}

static pave_result take_drawing(pave_context *context, const cJSON *json, pv_manifest *m)
{
    pave_result result = PAVE_OK;
    const char *drawing = string(json, "drawing");
    m->drawing = pv_allocate(context, strlen(drawing) + 1, 1, &result);
    if (m->drawing)
        strcpy(m->drawing, drawing);
    return result;
}

static pave_result take(pave_context *context, const char *path, const cJSON *json, pv_manifest *m)
{
    const cJSON *parameters = cJSON_GetObjectItemCaseSensitive(json, "parameters");
    if (!cJSON_IsObject(json) || !cJSON_IsObject(parameters))
        return pv_fail(context, PAVE_ERR_FORMAT, "%s: is not a plan", path);
    if (strcmp(string(json, "pave"), pave_version()))
        return pv_fail(context, PAVE_ERR_FORMAT, "%s: was planned by pave %.20s, and this is %s", path,
                       string(json, "pave"), pave_version());
    m->hash = hash(string(json, "hash"));
    m->width = number(json, "width", 1 << 20);
    m->height = number(json, "height", 1 << 20);
    m->columns = number(json, "columns", PV_MOST_WINDOWS);
    m->rows = number(json, "rows", PV_MOST_WINDOWS);
    m->margin = number(json, "margin", 1 << 20);
    if (!m->hash || !m->width || !m->height || !m->columns || !m->rows || !m->margin ||
        (int64_t)m->columns * m->rows > PV_MOST_WINDOWS || m->columns > m->width || m->rows > m->height)
        return pv_fail(context, PAVE_ERR_FORMAT, "%s: is a damaged plan", path);
    pave_result result = check_windows(context, path, json, m);
    if (result)
        return result;
    pave_threshold_params_init(&m->threshold, sizeof m->threshold);
    pave_palette_params_init(&m->palette, sizeof m->palette);
    pave_field_params_init(&m->field, sizeof m->field);
    pave_cvd_params_init(&m->cvd, sizeof m->cvd);
    pave_stones_params_init(&m->stones, sizeof m->stones);
    result = pv_json_read_params(context, path, parameters, &pv_threshold_table, &m->threshold);
    if (!result)
        result = pv_json_read_params(context, path, parameters, &pv_palette_table, &m->palette);
    if (!result)
        result = pv_json_read_params(context, path, parameters, &pv_field_table, &m->field);
    if (!result)
        result = pv_json_read_params(context, path, parameters, &pv_cvd_table, &m->cvd);
    if (!result)
        result = pv_json_read_params(context, path, parameters, &pv_stones_table, &m->stones);
    return result ? result : take_drawing(context, json, m);
}

pave_result pv_manifest_read(pave_context *context, const char *path, pv_manifest *out)
{
    char *text = NULL;
    memset(out, 0, sizeof *out);
    pave_result result = read_text(context, path, &text);
    if (result)
        return result;
    cJSON *json = cJSON_Parse(text);
    result = take(context, path, json, out);
    cJSON_Delete(json);
    pv_release(text);
    return result;
}

void pv_manifest_free(pv_manifest *manifest)
{
    pv_release(manifest->drawing);
    manifest->drawing = NULL;
}
