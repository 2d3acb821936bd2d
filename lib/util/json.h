/* JSON, written as it comes, indented by two spaces, the same in every locale. */
#pragma once

#include <stddef.h>
#include <stdint.h>

enum { PV_JSON_DEPTH = 16 };

typedef struct pv_json {
    void (*put)(void *user, const char *text, size_t length);
    void *user;
    int32_t depth;
    char closing[PV_JSON_DEPTH]; /* how each open object or array ends */
    char started[PV_JSON_DEPTH]; /* it has a member */
} pv_json;

void pv_json_begin(pv_json *json, void (*put)(void *user, const char *text, size_t length), void *user);

/* `key` is NULL in an array and at the top. */
void pv_json_object(pv_json *json, const char *key);
void pv_json_array(pv_json *json, const char *key);
void pv_json_close(pv_json *json);

/* A number that is not finite becomes null, a whole number beyond 2^53 a string, for readers of JSON keep no more. */
void pv_json_number(pv_json *json, const char *key, double value);
void pv_json_whole(pv_json *json, const char *key, int64_t value);
void pv_json_unsigned(pv_json *json, const char *key, uint64_t value);

/* UTF-8; bytes that are not become U+FFFD. */
void pv_json_string(pv_json *json, const char *key, const char *value);
void pv_json_flag(pv_json *json, const char *key, int value);
