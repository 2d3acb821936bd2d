/* Params structs as JSON objects. */
#include "io/parameters.h"

#include "util/text.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

static void put_choice(pv_json *json, const pv_param *row, int32_t value)
{
    char text[64];
    const char *from = row->choices;
    for (; value > 0 && strchr(from, '|'); value--)
        from = strchr(from, '|') + 1;
    size_t length = strcspn(from, "|");
    if (length >= sizeof text)
        length = sizeof text - 1;
    memcpy(text, from, length);
    text[length] = 0;
    pv_json_string(json, row->name, text);
}

/* A window, or an extent. */
static void put_whole_numbers(pv_json *json, const char *key, const int32_t *numbers, int count)
{
    pv_json_array(json, key);
    for (int i = 0; i < count; i++)
        pv_json_whole(json, NULL, numbers[i]);
    pv_json_close(json);
}

/* "#rrggbb #rrggbb"; "" for none. */
static void put_palette(pv_json *json, const char *key, const pave_palette *palette)
{
    char text[8 * 256 + 1] = "";
    for (int32_t i = 0; i < palette->count; i++)
        snprintf(text + 8 * i, sizeof text - 8 * (size_t)i, "#%02x%02x%02x%s", palette->rgb[3 * i],
                 palette->rgb[3 * i + 1], palette->rgb[3 * i + 2], i + 1 < palette->count ? " " : "");
    pv_json_string(json, key, text);
}

void pv_json_params(pv_json *json, const pv_table *table, const void *params)
{
    pv_json_object(json, table->name);
    for (int32_t i = 0; i < table->count; i++) {
        const pv_param *row = &table->rows[i];
        const void *at = (const char *)params + row->offset;
        switch (row->type) {
        case PAVE_PARAM_REAL: pv_json_number(json, row->name, *(const double *)at); break;
        case PAVE_PARAM_LONG: pv_json_whole(json, row->name, *(const int64_t *)at); break;
        case PAVE_PARAM_SEED: pv_json_unsigned(json, row->name, *(const uint64_t *)at); break;
        case PAVE_PARAM_FLAG: pv_json_flag(json, row->name, *(const int32_t *)at); break;
        case PAVE_PARAM_WINDOW: put_whole_numbers(json, row->name, at, 4); break;
        case PAVE_PARAM_PALETTE: put_palette(json, row->name, at); break;
        case PAVE_PARAM_EXTENT: put_whole_numbers(json, row->name, at, 2); break;
        case PAVE_PARAM_CHOICE: put_choice(json, row, *(const int32_t *)at); break;
        default: pv_json_whole(json, row->name, *(const int32_t *)at);
        }
    }
    pv_json_close(json);
}

/* A value as the text that pv_param_set takes; NULL if it is of no such kind. */
static const char *as_text(const cJSON *item, char text[64])
{
    if (cJSON_IsString(item))
        return item->valuestring;
    if (cJSON_IsBool(item))
        return cJSON_IsTrue(item) ? "1" : "0";
    if (cJSON_IsNumber(item)) {
        pv_text_number(text, 64, item->valuedouble);
        return text;
    }
    int count = cJSON_IsArray(item) ? cJSON_GetArraySize(item) : 0, at = 0;
    if (count != 4 && count != 2)
        return NULL;
    for (int i = 0; i < count; i++)
        at += snprintf(text + at, 64 - (size_t)at, "%s%d", !i ? "" : count == 4 ? "," : "x",
                       cJSON_GetArrayItem(item, i)->valueint);
    return text;
}

pave_result pv_json_read_params(pave_context *context, const char *path, const void *parent, const pv_table *table,
                                void *params)
{
    const cJSON *object = cJSON_GetObjectItemCaseSensitive(parent, table->name), *item;
    pave_result result = PAVE_OK;
    if (!cJSON_IsObject(object))
        return pv_fail(context, PAVE_ERR_FORMAT, "%s: has no %s parameters", path, table->name);
    cJSON_ArrayForEach(item, object)
    {
        char text[64];
        const char *value = as_text(item, text);
        if (value && !*value && !strcmp(item->string, "palette"))
            continue; /* none */
        if (!result && !value)
            result = pv_fail(context, PAVE_ERR_FORMAT, "%s: %s is of a strange kind", path, item->string);
        if (!result)
            result = pv_param_set(context, table, params, item->string, value);
    }
    return result;
}
