/* JSON, written as it comes. */
#include "util/json.h"

#include "util/text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static void put(pv_json *json, const char *text)
{
    json->put(json->user, text, strlen(text));
}

/* Length of the well-formed UTF-8 character at `s`, 0 if there is none. */
static size_t utf8_length(const unsigned char *s)
{
    size_t n = s[0] < 0x80 ? 1 : s[0] < 0xC2 ? 0 : s[0] < 0xE0 ? 2 : s[0] < 0xF0 ? 3 : s[0] < 0xF5 ? 4 : 0;
    for (size_t i = 1; i < n; i++)
        if ((s[i] & 0xC0) != 0x80)
            return 0;
    int overlong = (s[0] == 0xE0 && s[1] < 0xA0) || (s[0] == 0xF0 && s[1] < 0x90);
    int beyond = (s[0] == 0xED && s[1] >= 0xA0) || (s[0] == 0xF4 && s[1] >= 0x90);
    return overlong || beyond ? 0 : n;
}

static void put_string(pv_json *json, const char *value)
{
    char escape[8];
    put(json, "\"");
    while (*value) {
        unsigned char c = (unsigned char)*value;
        size_t n = utf8_length((const unsigned char *)value);
        if (c == '"' || c == '\\' || c < 0x20 || c == 0x7F) {
            snprintf(escape, sizeof escape, c < 0x20 || c == 0x7F ? "\\u%04x" : "\\%c", c);
            put(json, escape);
        } else if (n) {
            json->put(json->user, value, n);
        } else {
            put(json, "\xEF\xBF\xBD");
        }
        value += n ? n : 1;
    }
    put(json, "\"");
}

static void new_line(pv_json *json)
{
    put(json, "\n");
    for (int32_t i = 0; i < json->depth; i++)
        put(json, "  ");
}

/* What comes before every value. Arrays hold numbers here and stay on one line. */
static void member(pv_json *json, const char *key)
{
    int32_t depth = json->depth;
    if (depth && json->started[depth - 1])
        put(json, json->closing[depth - 1] == ']' ? ", " : ",");
    if (depth)
        json->started[depth - 1] = 1;
    if (depth && json->closing[depth - 1] == '}')
        new_line(json);
    if (key) {
        put_string(json, key);
        put(json, ": ");
    }
}

static void opened(pv_json *json, const char *key, const char *opening, char closing)
{
    member(json, key);
    put(json, opening);
    if (json->depth == PV_JSON_DEPTH)
        return;
    json->closing[json->depth] = closing;
    json->started[json->depth++] = 0;
}

void pv_json_begin(pv_json *json, void (*function)(void *user, const char *text, size_t length), void *user)
{
    memset(json, 0, sizeof *json);
    json->put = function;
    json->user = user;
}

void pv_json_object(pv_json *json, const char *key)
{
    opened(json, key, "{", '}');
}

void pv_json_array(pv_json *json, const char *key)
{
    opened(json, key, "[", ']');
}

void pv_json_close(pv_json *json)
{
    char closing[2] = { json->closing[--json->depth], 0 };
    if (closing[0] == '}' && json->started[json->depth])
        new_line(json);
    put(json, closing);
    if (!json->depth)
        put(json, "\n");
}

void pv_json_number(pv_json *json, const char *key, double value)
{
    char text[40] = "null";
    if (isfinite(value))
        pv_text_number(text, sizeof text, value);
    member(json, key);
    put(json, text);
}

void pv_json_whole(pv_json *json, const char *key, int64_t value)
{
    if (value >= 0) {
        pv_json_unsigned(json, key, (uint64_t)value);
        return;
    }
    char text[24];
    snprintf(text, sizeof text, "%lld", (long long)value);
    member(json, key);
    put(json, text);
}

void pv_json_unsigned(pv_json *json, const char *key, uint64_t value)
{
    char text[24];
    const char *quote = value > (uint64_t)1 << 53 ? "\"" : "";
    snprintf(text, sizeof text, "%s%llu%s", quote, (unsigned long long)value, quote);
    member(json, key);
    put(json, text);
}

void pv_json_string(pv_json *json, const char *key, const char *value)
{
    member(json, key);
    put_string(json, value);
}

void pv_json_flag(pv_json *json, const char *key, int value)
{
    member(json, key);
    put(json, value ? "true" : "false");
}
