/* Stones as SVG: one polygon a stone, grouped by colour on a ground of grout. */
#include "io/output.h"
#include "io/palette.h"
#include "io/pavement.h"

#include <math.h>
#include <stdio.h>

static void put_colour(pv_output *output, pv_colour colour)
{
    char text[8];
    snprintf(text, sizeof text, "#%02x%02x%02x", colour.r, colour.g, colour.b);
    pv_output_text(output, text);
}

static void put_head(pv_output *output, const pave_stones *stones)
{
    char text[256];
    int32_t x = stones->x, y = stones->y, w = stones->width, h = stones->height;
    snprintf(text, sizeof text,
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"%d %d %d %d\">\n"
             "<title>Pavement of %d stones</title>\n<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"",
             w, h, x, y, w, h, stones->count, x, y, w, h);
    pv_output_text(output, text);
    put_colour(output, pv_grout);
    pv_output_text(output, "\"/>\n");
}

static void put_stone(pv_output *output, const pave_stones *stones, int32_t stone)
{
    pv_output_text(output, "<polygon id=\"s");
    pv_output_whole(output, stones->sites[stone]);
    pv_output_text(output, "\" points=\"");
    for (int64_t i = stones->starts[stone]; i < stones->starts[stone + 1]; i++) {
        if (i > stones->starts[stone])
            pv_output_text(output, " ");
        pv_output_thousandths(output, llround(stones->vertices[2 * i] * 1000));
        pv_output_text(output, ",");
        pv_output_thousandths(output, llround(stones->vertices[2 * i + 1] * 1000));
    }
    pv_output_text(output, "\"/>\n");
}

static void put_group_head(pv_output *output, int32_t value)
{
    pv_output_text(output, "<g id=\"");
    pv_output_text(output, value == 0 ? "black" : value == 255 ? "white" : "grey");
    if (value > 0 && value < 255)
        pv_output_whole(output, value);
    pv_output_text(output, "\" fill=\"");
    put_colour(output, pv_stone_colour((uint8_t)value));
    pv_output_text(output, "\">\n");
}

static pave_result put_group(pave_context *context, pv_output *output, const pave_stones *stones, int32_t value,
                             int64_t *done)
{
    pave_result result = PAVE_OK;
    put_group_head(output, value);
    for (int32_t i = 0; i < stones->count && !result; i++) {
        if (stones->colours[i] != value)
            continue;
        put_stone(output, stones, i);
        if (++*done % 4096 == 0)
            result = pv_progress(context, (double)*done / stones->count);
    }
    pv_output_text(output, "</g>\n");
    return result;
}

pave_result pv_svg_write(pave_context *context, const pave_stones *stones, const char *path)
{
    pv_output *output;
    pave_result result = pv_output_open(context, path, 0, &output);
    if (result)
        return result;
    int64_t counts[256] = { 0 }, done = 0;
    for (int32_t i = 0; i < stones->count; i++)
        counts[stones->colours[i]]++;
    put_head(output, stones);
    for (int32_t value = 0; value < 256 && !result; value++)
        if (counts[value])
            result = put_group(context, output, stones, value, &done);
    pv_output_text(output, "</svg>\n");
    return pv_output_close(output, result);
}
