/* Measures of stones as JSON, and as lines to read. */
#include <pave/io.h>

#include "io/measures.h"
#include "io/output.h"
#include "util/text.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NUMBER, COUNT, SHARE, CORNERS };

typedef struct row {
    const char *name; /* in JSON */
    int32_t kind;
    size_t offset;
    const char *words;
} row;

#define ROW(field, kind, words) { #field, kind, offsetof(pave_stones_measures, field), words }

static const row rows[] = {
    ROW(width, COUNT, "px, width of the window"),
    ROW(height, COUNT, "px, its height"),
    ROW(half_side, NUMBER, "px, h: half the side of a mean stone"),
    ROW(stones, COUNT, "stones"),
    ROW(quads, SHARE, "of them have four corners"),
    ROW(triangles, SHARE, "have three"),
    ROW(vertices, CORNERS, NULL),
    ROW(invalid, COUNT, "touch or cross themselves, or are no polygons"),
    ROW(clockwise, COUNT, "go round the other way than most"),
    ROW(nonconvex, SHARE, "are not convex"),
    ROW(overlapping, COUNT, "stones overlap another one"),
    ROW(overlap, SHARE, "of the window lies under two stones"),
    ROW(multiple, SHARE, "of its pixels do"),
    ROW(coverage, SHARE, "of the window is stone"),
    ROW(uncovered, SHARE, "of its pixels are under no stone"),
    ROW(mismatch, SHARE, "are under a stone of another colour than the drawing's"),
    ROW(straddlers, SHARE, "of the stones have under 95 % of their pixels in their own colour"),
    ROW(edge_mean, NUMBER, "px, from the stones' colour edges to the drawing's, mean"),
    ROW(edge_max, NUMBER, "px, greatest"),
    ROW(missed_mean, NUMBER, "px, from the drawing's colour edges to the stones', mean"),
    ROW(missed_max, NUMBER, "px, greatest"),
    ROW(area_mean, NUMBER, "px^2, mean area"),
    ROW(area_median, NUMBER, "px^2, median"),
    ROW(area_cv, NUMBER, "standard deviation / mean"),
    ROW(sliver, SHARE, "of the stones are slivers: 4 pi area / perimeter^2 under 0.3"),
    ROW(tiny, SHARE, "are under 1/8 of the median"),
    ROW(small, SHARE, "are under h^2"),
    ROW(thin, SHARE, "fit through a slit of width h"),
    ROW(axis_bias, NUMBER, "R4: 1 if stones away from edges all lie alike, 0 if as they like"),
    ROW(far_stones, COUNT, "stones more than 3 h away"),
    ROW(near_mean, NUMBER, "degrees between stones within 1.5 h of an edge and the edge, mean"),
    ROW(near_p90, NUMBER, "degrees, not exceeded by 90 % of them"),
    ROW(near_stones, COUNT, "stones so near"),
    ROW(joint_mean, NUMBER, "px, width of joints, mean"),
    ROW(joint_deviation, NUMBER, "px, standard deviation"),
    ROW(joint_p5, NUMBER, "px, not exceeded by 5 % of them"),
    ROW(joint_p95, NUMBER, "px, not exceeded by 95 %"),
    ROW(jointed, SHARE, "of the stones' sides have a joint beside them, not a hole or the border"),
};

enum { ROWS = sizeof rows / sizeof *rows };

static double value_of(const pave_stones_measures *measures, const row *r)
{
    const char *at = (const char *)measures + r->offset;
    return r->kind == COUNT ? *(const int32_t *)(const void *)at : *(const double *)(const void *)at;
}

/* The last bin, "31+", is for that many corners or more. */
static void corners_name(char out[8], int32_t i)
{
    snprintf(out, 8, "%d%s", (int)i, i == PAVE_REPORT_BINS - 1 ? "+" : "");
}

void pv_json_corners(pv_json *json, const char *key, const int64_t *counts)
{
    pv_json_object(json, key);
    for (int32_t i = 0; i < PAVE_REPORT_BINS; i++) {
        char name[8];
        corners_name(name, i);
        if (counts[i])
            pv_json_whole(json, name, counts[i]);
    }
    pv_json_close(json);
}

void pv_json_measures(pv_json *json, const char *key, const pave_stones_measures *measures)
{
    pv_json_object(json, key);
    for (int32_t i = 0; i < ROWS; i++)
        if (rows[i].kind == CORNERS)
            pv_json_corners(json, rows[i].name, measures->vertices);
        else
            pv_json_number(json, rows[i].name, value_of(measures, &rows[i]));
    pv_json_close(json);
}

static void put_json(pv_output *output, const pave_stones_measures *measures)
{
    pv_json json;
    pv_json_begin(&json, pv_output_put, output);
    pv_json_measures(&json, NULL, measures);
}

/* "98.43 %": four digits, for more are noise to a reader; there and back, so that the locale has no say. */
static void short_number(char *out, size_t capacity, const row *r, double value)
{
    char digits[40];
    snprintf(digits, sizeof digits, r->kind == COUNT ? "%.0f" : "%.4g", r->kind == SHARE ? 100 * value : value);
    pv_text_number(digits, sizeof digits, strtod(digits, NULL));
    snprintf(out, capacity, "%s%s", digits, r->kind == SHARE ? " %" : "");
}

static void put_corners(pv_output *output, const int64_t *counts)
{
    for (int32_t i = 0; i < PAVE_REPORT_BINS; i++) {
        char name[8], line[64];
        corners_name(name, i);
        if (!counts[i])
            continue;
        snprintf(line, sizeof line, "%14s%lld  stones of %s corners\n", "", (long long)counts[i], name);
        pv_output_text(output, line);
    }
}

static void put_text(pv_output *output, const pave_stones_measures *measures)
{
    for (int32_t i = 0; i < ROWS; i++) {
        char number[48], line[160];
        if (rows[i].kind == CORNERS) {
            put_corners(output, measures->vertices);
            continue;
        }
        short_number(number, sizeof number, &rows[i], value_of(measures, &rows[i]));
        snprintf(line, sizeof line, "%-16s %12s  %s\n", rows[i].name, number, rows[i].words);
        pv_output_text(output, line);
    }
}

pave_result pave_stones_measures_write(pave_context *context, const pave_stones_measures *given, const char *path,
                                       const char *format)
{
    if (!context)
        return PAVE_ERR_ARGUMENT;
    int json = format && !strcmp(format, "json"), before = errno;
    if (!given || !path || (!json && format && strcmp(format, "text")))
        return pv_fail(context, PAVE_ERR_ARGUMENT, "measures are written as \"json\" or \"text\"");
    pave_stones_measures measures;
    pv_output *output;
    memset(&measures, 0, sizeof measures);
    memcpy(&measures, given, given->size < sizeof measures ? given->size : sizeof measures);
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    if (json)
        put_json(output, &measures);
    else
        put_text(output, &measures);
    result = pv_output_close(output, PAVE_OK);
    errno = before;
    return result;
}
