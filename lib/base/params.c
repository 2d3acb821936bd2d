/* Parameter tables at work: defaults, reading structs of any size, ranges, values from text. */
#include "base/params.h"

#include "util/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void init_struct(const void *defaults, size_t known, void *params, size_t size)
{
    if (!params || size < sizeof(size_t))
        return;
    memset(params, 0, size);
    memcpy(params, defaults, size < known ? size : known);
    *(size_t *)params = size;
}

void pv_params_init(const pv_table *table, void *params, size_t size)
{
    init_struct(table->defaults, table->size, params, size);
}

pave_result pv_struct_read(pave_context *context, const char *name, const void *defaults, size_t known,
                           const void *given, void *out)
{
    memcpy(out, defaults, known);
    if (!given)
        return PAVE_OK;
    size_t size = *(const size_t *)given;
    if (size < sizeof(size_t) || size > 65536)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "the %s parameters have a size of %zu: initialise them first", name,
                       size);
    for (size_t i = known; i < size; i++)
        if (((const char *)given)[i])
            return pv_fail(context, PAVE_ERR_TOO_NEW, "the %s parameters set fields that libpave %s does not know",
                           name, pave_version());
    memcpy(out, given, size < known ? size : known);
    *(size_t *)out = known;
    return PAVE_OK;
}

static int32_t choices_count(const char *choices)
{
    int32_t count = 1;
    for (; *choices; choices++)
        count += *choices == '|';
    return count;
}

static double greatest(const pv_param *row)
{
    return row->choices ? choices_count(row->choices) - 1 : row->greatest;
}

/* The worst number of a window, or an extent, stands for all. */
static double window_value(const int32_t *window, int count)
{
    double value = 0;
    for (int i = 0; i < count; i++)
        value = window[i] < 0 || window[i] > value ? window[i] : value;
    return value;
}

static double field_value(const pv_param *row, const void *params)
{
    const char *at = (const char *)params + row->offset;
    switch (row->type) {
    case PAVE_PARAM_REAL: return *(const double *)(const void *)at;
    case PAVE_PARAM_LONG: return (double)*(const int64_t *)(const void *)at;
    case PAVE_PARAM_SEED: return (double)*(const uint64_t *)(const void *)at;
    case PAVE_PARAM_WINDOW: return window_value((const int32_t *)(const void *)at, 4);
    case PAVE_PARAM_EXTENT: return window_value((const int32_t *)(const void *)at, 2);
    default: return *(const int32_t *)(const void *)at;
    }
}

static pave_result range_error(pave_context *context, const pv_param *row, const char *name, const char *text)
{
    if (row->choices)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%s is '%s', but must be one of %s", name, text, row->choices);
    if (row->type == PAVE_PARAM_WINDOW)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%s is '%s', but must be X,Y,WIDTH,HEIGHT in px", name, text);
    if (row->type == PAVE_PARAM_PALETTE)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%s is '%.60s', but must be 1 to 256 colours like #rrggbb,#rrggbb",
                       name, text);
    if (row->type == PAVE_PARAM_EXTENT)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%s is '%s', but must be WIDTHxHEIGHT in px, up to %.0f a side",
                       name, text, row->greatest);
    char least[32], most[32];
    pv_text_number(least, sizeof least, row->least);
    pv_text_number(most, sizeof most, row->greatest);
    if (row->type == PAVE_PARAM_SEED)
        return pv_fail(context, PAVE_ERR_ARGUMENT, "%s is '%s', but must be a whole number of 0 .. 2^64-1", name,
                       text);
    return pv_fail(context, PAVE_ERR_ARGUMENT, "%s is %s, but must be %s%s .. %s%s%s", name, text,
                   row->type == PAVE_PARAM_REAL ? "" : "a whole number of ", least, most, *row->unit ? " " : "",
                   row->unit);
}

/* "#rrggbb", with white space or commas between. 0 if it is not that, or more than there is room for. */
static int parse_palette(const char *text, pave_palette *out)
{
    memset(out, 0, sizeof *out);
    for (text += strspn(text, " \t\r\n,"); *text; text += strspn(text, " \t\r\n,")) {
        if (*text != '#' || strspn(text + 1, "0123456789abcdefABCDEF") != 6 || out->count == 256)
            return 0;
        for (int i = 0; i < 3; i++) {
            char pair[3] = { text[1 + 2 * i], text[2 + 2 * i], 0 };
            out->rgb[3 * out->count + i] = (uint8_t)strtoul(pair, NULL, 16);
        }
        out->count++;
        text += 7;
    }
    return out->count > 0;
}

/* NaN is outside every range. */
static int in_range(const pv_param *row, double value)
{
    return value >= row->least && value <= greatest(row);
}

pave_result pv_params_read(pave_context *context, const pv_table *table, const void *given, void *out)
{
    pave_result result = pv_struct_read(context, table->name, table->defaults, table->size, given, out);
    for (int32_t i = 0; i < table->count && !result; i++) {
        double value = field_value(&table->rows[i], out);
        char text[32];
        if (in_range(&table->rows[i], value))
            continue;
        pv_text_number(text, sizeof text, value);
        result = range_error(context, &table->rows[i], table->rows[i].name, text);
    }
    return result;
}

pave_result pv_param_describe(const pv_table *table, int32_t index, pave_param *out)
{
    if (!table || !out || index < 0 || index >= table->count)
        return PAVE_ERR_ARGUMENT;
    const pv_param *row = &table->rows[index];
    out->name = row->name;
    out->type = row->type;
    out->unit = row->unit;
    out->least = row->least;
    out->greatest = greatest(row);
    out->initial = field_value(row, table->defaults);
    out->choices = row->choices;
    out->help = row->help;
    return PAVE_OK;
}

static int same_name(const char *name, const char *given)
{
    for (; *name && *given; name++, given++)
        if (*name != (*given == '-' ? '_' : *given))
            return 0;
    return *name == *given;
}

static int parse_choice(const char *choices, const char *text, double *value)
{
    size_t length = strlen(text);
    for (int32_t i = 0; choices; i++) {
        const char *end = strchr(choices, '|');
        size_t n = end ? (size_t)(end - choices) : strlen(choices);
        if (n == length && !memcmp(choices, text, n)) {
            *value = i;
            return 1;
        }
        choices = end ? end + 1 : NULL;
    }
    return 0;
}

static int parse_flag(const char *text, double *value)
{
    int yes = !strcmp(text, "1") || !strcmp(text, "yes") || !strcmp(text, "true");
    *value = yes;
    return yes || !strcmp(text, "0") || !strcmp(text, "no") || !strcmp(text, "false");
}

/* Whole numbers with a letter between them: "X,Y,WIDTH,HEIGHT", "WIDTHxHEIGHT". */
static int parse_whole_numbers(const char *text, int count, char between, int32_t *window)
{
    char *end;
    for (int i = 0; i < count; i++, text = end + 1) {
        long v = strtol(text, &end, 10);
        if (end == text || *end != (i + 1 < count ? between : 0) || v < 0 || v > 1 << 20)
            return 0;
        window[i] = (int32_t)v;
    }
    return 1;
}

static int parse_value(const pv_param *row, const char *text, double *value, uint64_t *whole)
{
    if (row->type == PAVE_PARAM_CHOICE)
        return parse_choice(row->choices, text, value);
    if (row->type == PAVE_PARAM_FLAG)
        return parse_flag(text, value);
    if (row->type == PAVE_PARAM_SEED)
        return *value = 0, pv_parse_whole(text, whole);
    if (row->type == PAVE_PARAM_LONG && !strcmp(row->unit, "bytes"))
        return pv_parse_bytes(text, value);
    if (!pv_parse_number(text, value))
        return 0;
    return row->type == PAVE_PARAM_REAL || (in_range(row, *value) && *value == (double)(int64_t)*value);
}

static size_t stored_size(const pv_param *row)
{
    switch (row->type) {
    case PAVE_PARAM_REAL:
    case PAVE_PARAM_LONG:
    case PAVE_PARAM_SEED: return 8;
    case PAVE_PARAM_WINDOW: return 4 * sizeof(int32_t);
    case PAVE_PARAM_PALETTE: return sizeof(pave_palette);
    case PAVE_PARAM_EXTENT: return 2 * sizeof(int32_t);
    default: return sizeof(int32_t);
    }
}

int pv_params_same(const pv_table *table, const void *a, const void *b, size_t end)
{
    for (int32_t i = 0; i < table->count; i++) {
        size_t at = table->rows[i].offset;
        if (at < end && memcmp((const char *)a + at, (const char *)b + at, stored_size(&table->rows[i])))
            return 0;
    }
    return 1;
}

static void store(const pv_param *row, void *params, double value, uint64_t whole)
{
    void *at = (char *)params + row->offset;
    switch (row->type) {
    case PAVE_PARAM_REAL: *(double *)at = value; break;
    case PAVE_PARAM_LONG: *(int64_t *)at = (int64_t)value; break;
    case PAVE_PARAM_SEED: *(uint64_t *)at = whole; break;
    default: *(int32_t *)at = (int32_t)value;
    }
}

static pave_result set_palette(pave_context *context, const pv_param *row, void *params, const char *name,
                               const char *value)
{
    pave_palette palette;
    if (!parse_palette(value, &palette))
        return range_error(context, row, name, value);
    memcpy((char *)params + row->offset, &palette, sizeof palette);
    return PAVE_OK;
}

pave_result pv_param_set(pave_context *context, const pv_table *table, void *params, const char *name,
                         const char *value)
{
    for (int32_t i = 0; i < table->count; i++) {
        const pv_param *row = &table->rows[i];
        double number = 0;
        uint64_t whole = 0;
        if (!same_name(row->name, name))
            continue;
        if (*(size_t *)params < row->offset + stored_size(row))
            return pv_fail(context, PAVE_ERR_ARGUMENT, "this %s struct is too old to hold %s", table->name, name);
        if (row->type == PAVE_PARAM_PALETTE)
            return set_palette(context, row, params, name, value);
        int32_t window[4];
        int several = row->type == PAVE_PARAM_WINDOW ? 4 : row->type == PAVE_PARAM_EXTENT ? 2 : 0;
        int parsed = several ? parse_whole_numbers(value, several, several == 4 ? ',' : 'x', window)
                             : parse_value(row, value, &number, &whole) && in_range(row, number);
        if (!parsed)
            return range_error(context, row, name, value);
        if (several)
            memcpy((char *)params + row->offset, window, stored_size(row));
        else
            store(row, params, number, whole);
        return PAVE_OK;
    }
    return pv_fail(context, PAVE_ERR_ARGUMENT, "%s has no parameter named %s", table->name, name);
}
